//! Decisions as JUnit XML for build servers: a testcase for each gate and group, `<failure>` for exit code 4, `<error>` for 5.

use super::judge::{Decision, Verdict};
use crate::ask::prefix;
use crate::page::escape::html;

/// Text of an attribute or an element. Line feeds and tabs become numeric references, because parsers replace them by blanks in attributes.
fn escaped(text: &str) -> String {
    html(text).replace('\n', "&#10;").replace('\t', "&#9;")
}

/// JUnit file; `study`: name of the study; `warning`: a line about all its runs.
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
