//! Formatting of errors: problems of files with the place underlined, other errors as a chain of causes.

use super::error::CliError;
use super::excerpt::Excerpt;
use super::output::{for_terminal, width_of_errors};
use crate::start_check::StartError;
use bladeoff_study::StudyError;
use bladeoff_system::causes;
use bladeoff_system::threads::thread_limit;
use bladeoff_text::document::{Problem, Problems, visible, visible_lines};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, SourceCode};
use std::error::Error;
use std::fmt;
use std::io::IsTerminal;

/// Text for standard error; characters from files are escaped, only colours of this program remain.
#[must_use]
pub fn render(error: &CliError) -> String {
    match error {
        CliError::Machine(problems) | CliError::Start(StartError::Machine(problems)) => {
            render_problems(std::slice::from_ref(problems))
        }
        CliError::Overridden { problems, given } => {
            let text = render_problems(std::slice::from_ref(problems));
            format!("{}, with {} in place of its own value\n", text.trim_end(), visible(given))
        }
        CliError::Study(StudyError::Problems(files)) => render_problems(files),
        CliError::Argument { argument, message, allowed } => {
            let allowed = allowed.as_ref().map(|allowed| format!("\n  allowed: {}", visible(allowed)));
            let text = format!("error: {}: {}{}\n", visible(argument), visible(message), allowed.unwrap_or_default());
            for_terminal(&text, width_of_errors()).into_owned()
        }
        other => chain(other),
    }
}

fn chain(error: &(dyn Error + 'static)) -> String {
    let mut text = format!("error: {error}\n");
    let mut lacks_threads = false;
    for cause in causes(error) {
        text.push_str(&format!("  because: {cause}\n"));
        let code = cause.downcast_ref::<std::io::Error>().and_then(std::io::Error::raw_os_error);
        lacks_threads |= code == Some(libc::EAGAIN);
    }
    if lacks_threads && !text.contains("ulimit -u") {
        text.push_str(&format!("  {}\n", thread_limit()));
    }
    for_terminal(&visible_lines(&text), width_of_errors()).into_owned()
}

/// Every problem of every file, followed by the number of problems.
fn render_problems(files: &[Problems]) -> String {
    let handler = GraphicalReportHandler::new_themed(theme())
        .with_width(width_of_errors().unwrap_or(120))
        .with_context_lines(1)
        .with_links(false)
        .with_wrap_lines(width_of_errors().is_some())
        .with_break_words(false);
    let mut text = String::new();
    for problems in files {
        for problem in &problems.list {
            let shown = Shown { problem, source: Excerpt::new(problem, &problems.text) };
            if handler.render_report(&mut text, &shown).is_err() {
                // the plain line has the same content without the picture
                text.push_str(&format!("{problem}\n"));
            }
        }
    }
    let left_out: usize = files.iter().map(|problems| problems.left_out).sum();
    let count = left_out + files.iter().map(|problems| problems.list.len()).sum::<usize>();
    let names: Vec<_> = files.iter().map(|problems| visible(&problems.file)).collect();
    let noun = if count == 1 { "problem" } else { "problems" };
    let hidden = if left_out > 0 { format!(", {left_out} of them not shown") } else { String::new() };
    let last = format!("error: {count} {noun} in {}{hidden}\n", names.join(" and "));
    text.push_str(&for_terminal(&last, width_of_errors()));
    text
}

fn theme() -> GraphicalTheme {
    let coloured = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    if coloured { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() }
}

/// A problem in the form that miette requires.
#[derive(Debug)]
struct Shown<'a> {
    problem: &'a Problem,
    source: Excerpt,
}

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.problem.headline())
    }
}

impl Error for Shown<'_> {}

impl Diagnostic for Shown<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let allowed = self.problem.allowed.as_ref().map(|allowed| format!("allowed: {}", visible(allowed)));
        let nearest = self.problem.nearest.as_ref().map(|nearest| format!("did you mean `{}`?", visible(nearest)));
        let lines: Vec<String> = [nearest, allowed].into_iter().flatten().collect();
        (!lines.is_empty()).then(|| Box::new(lines.join("\n")) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.source.span.clone();
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(Some("here".to_owned()), span))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_text::document::Collector;

    #[test]
    fn a_problem_is_shown_with_place_line_and_nearest_name() {
        let mut problems = Collector::new("m.toml", "a = 1\nfrction = 0.2\n");
        let problem = problems.add(6..13, "contact.frction", "unknown key");
        problem.allowed = Some("friction, gap".into());
        problem.nearest = Some("friction".into());
        let error = CliError::Machine(problems.finish().expect_err("one problem"));
        let text = render(&error);
        for part in [
            "m.toml:2:1",
            "contact.frction",
            "unknown key",
            "did you mean `friction`?",
            "allowed: friction, gap",
            "frction = 0.2",
            "error: 1 problem in m.toml",
        ] {
            assert!(text.contains(part), "{part} in\n{text}");
        }
        assert!(!text.contains('\u{1b}'), "no colour when not a terminal");
    }

    #[test]
    fn causes_follow_their_error() {
        let source = std::io::Error::other("disk on fire");
        let text = render(&CliError::Stdout { source });
        assert_eq!(text, "error: cannot write to standard output\n  because: disk on fire\n");
    }
}
