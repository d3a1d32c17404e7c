//! Text of questions, and notes about rows without a value.

use super::mapped::map_in_words;
use super::question::{Ask, Figure, Question};
use super::sentence::{UNDECIDED, counted};
use crate::share::percent_given;

/// Name of the kind of a figure.
pub(super) fn kind(figure: &Figure) -> &'static str {
    match figure {
        Figure::Probability(_) => "probability",
        Figure::Quantile(..) => "quantile",
        Figure::Mean(_) => "mean",
    }
}

/// Short text of a question: "load-95: 95 % quantile of max_bearing_load_N (95 %)".
#[must_use]
pub fn in_words(question: &Question) -> String {
    let what = match &question.ask {
        Ask::One(figure) => subject(figure),
        Ask::Exceedance(column) => format!("exceedance of {column}"),
        Ask::Fragility(path, formula) => format!("P({}) over {path}", formula.text),
        Ask::Difference(figure, path, [a, b]) => {
            format!("{} at {path} = {a} less that at {b}, paired", subject(figure))
        }
        Ask::Map(wanted) => map_in_words(wanted),
        Ask::Sensitivity(wanted) => format!("sensitivity of {} by {}", wanted.output, wanted.method.word()),
    };
    format!("{}: {what} (confidence {})", question.name, percent_given(question.confidence))
}

/// Quantity that a figure estimates: "95 % quantile of max_bearing_load_N".
pub(super) fn subject(figure: &Figure) -> String {
    match figure {
        Figure::Probability(formula) => format!("P({})", formula.text),
        Figure::Quantile(u, column) => format!("{} quantile of {column}", percent_given(*u)),
        Figure::Mean(column) => format!("mean of {column}"),
    }
}

/// Column name with its unit appended.
pub(super) fn with_unit(name: &str, unit: &str) -> String {
    let unit = unit.replace(' ', "").replace('/', "_");
    if unit.is_empty() { name.to_owned() } else { format!("{name}_{unit}") }
}

/// Adds a note about ok rows where the condition has no value.
pub(super) fn note_undefined(notes: &mut Vec<String>, undefined: u64) {
    if undefined > 0 {
        let runs = counted(undefined, "run");
        notes
            .push(format!("in {runs} the condition has no value (such as the root of a negative number): {UNDECIDED}"));
    }
}

/// Adds a note about rows without a value.
pub(super) fn note_empty(notes: &mut Vec<String>, empty: u64, what: &str) {
    if empty > 0 {
        let runs = counted(empty, "run");
        notes.push(format!("in {runs} a column has no value (for example, no contact, or no limit exceeded): {what}"));
    }
}

pub(super) const CONDITION: &str = "a comparison with it counts as not met, except `!=`";
pub(super) const LEFT_OUT: &str = "not included in this figure";
pub(super) const NO_LEVEL: &str = "counted as exceeding no level";
