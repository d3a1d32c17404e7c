//! Decisions as JUnit's XML, which build servers show: a testcase for each gate and group, `<failure>` for 4, `<error>` for 5.

use super::judge::{Decision, Verdict};
use crate::ask::prefix;
use std::fmt::Write;

/// Text for an attribute or an element: what XML has no way to write becomes U+FFFD.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\t' | '\n' | '\r' => write!(out, "&#{};", u32::from(c)).expect("writing to a String cannot fail"),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// The file; `study`: its name; `warning`: a line about all runs of the study.
#[must_use]
pub fn junit(study: &str, decisions: &[Decision], warning: Option<&str>) -> String {
    let count = |verdict: Verdict| decisions.iter().filter(|decision| decision.verdict == verdict).count();
    let (tests, failures, errors) = (decisions.len(), count(Verdict::Failed), count(Verdict::Open));
    let counts = format!("tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\"");
    let name = escaped(study);
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    line(format!("<testsuites name=\"bladeoff gate\" {counts}>"));
    line(format!("  <testsuite name=\"{name}\" {counts}>"));
    for decision in decisions {
        let case = escaped(&format!("{}{}", prefix(&decision.group), decision.gate));
        let said = escaped(&decision.sentence);
        line(format!("    <testcase classname=\"{name}\" name=\"{case}\">"));
        match decision.verdict {
            Verdict::Passed => line(format!("      <system-out>{said}</system-out>")),
            Verdict::Failed => line(format!("      <failure message=\"{said}\" type=\"gate\"/>")),
            Verdict::Open => line(format!("      <error message=\"{said}\" type=\"undecided\"/>")),
        }
        line("    </testcase>".to_owned());
    }
    if let Some(warning) = warning {
        line(format!("    <system-err>{}</system-err>", escaped(warning)));
    }
    line("  </testsuite>".to_owned());
    line("</testsuites>".to_owned());
    out
}
