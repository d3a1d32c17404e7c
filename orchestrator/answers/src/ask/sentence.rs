//! Text of an answer.

use super::answer::Answer;
use super::scale::Scale;
use crate::estimate::bad::Bad;
use crate::estimate::curve::CurvePoint;
use crate::estimate::input::{Group, Label};
use crate::share::percent_given;
use bladeoff_text::document::units::format_digits;

/// Text for runs whose recorded values do not determine the answer.
pub(super) const UNDECIDED: &str = "undecided (the interval covers all possible outcomes)";

/// A count with its noun in singular or plural.
#[must_use]
pub fn counted(count: u64, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}

/// Values of a group before a sentence: "run.detection = hyp1, gap = 0.001: "; empty for the only group of a study without varied parameters.
#[must_use]
pub fn prefix(group: &Group) -> String {
    let said: Vec<String> = group.0.iter().map(|(path, label)| format!("{path} = {label}")).collect();
    if said.is_empty() { String::new() } else { format!("{}: ", said.join(", ")) }
}

/// Whether runs that are not ok change neither the estimate nor its limits.
fn is_unchanged_by_bad(answer: &Answer) -> bool {
    let statistical = answer.figures.first().and_then(|figures| figures.statistical);
    let width = answer.high.zip(answer.low).map(|(high, low)| high - low);
    // the limits of a mean are rounded, so the widths agree except for the last digits
    let is_width = |(width, statistical): (f64, f64)| (width - statistical).abs() <= 1e-9 * statistical;
    answer.estimate.is_some()
        && answer.estimate == answer.estimate_if_bad_harmful
        && width.zip(statistical).is_some_and(is_width)
}

/// Lower limit of a quantile without an upper limit, at its one-sided confidence 1 - alpha/2.
fn lower_limit_only(answer: &Answer, scale: &Scale) -> Option<String> {
    let low = answer.low.filter(|_| answer.high.is_none())?;
    let (about, level) =
        (if answer.approximate { "about " } else { "" }, percent_given((1.0 + answer.confidence) / 2.0));
    Some(format!(" (lower limit {} with {about}{level} confidence, no upper limit)", scale.show(low)))
}

/// Sentence of an answer; `bad`: counts of runs that are not ok; `by`: values that determine the condition for the decided ones.
/// "P(max_bearing_load_N > 1.2 MN) = 0.43 % (95 %: 0.31 % to 0.58 %), 43 of 10000, 2 bad runs undecided (the interval ...)".
#[must_use]
pub fn sentence(answer: &Answer, subject: &str, scale: &Scale, (bad, by): (&Bad, &str)) -> String {
    let mut text = format!("{}{subject}", prefix(&answer.group));
    let level = percent_given(answer.confidence);
    let about = if answer.approximate { "about " } else { "" };
    let mut limits = None;
    let none = answer.events == Some(0) && *scale == Scale::Share;
    match (answer.estimate, answer.estimate_if_bad_harmful) {
        (Some(_), Some(harmful)) if none && harmful == 0.0 => {
            let limit = answer.high.map_or("no upper limit".to_owned(), |high| format!("at most {}", scale.show(high)));
            return text + &format!(": no event in {}, {limit} ({about}{level})", counted(answer.n, "run"));
        }
        // a difference: both figures with the bad runs of both values counted alike; mixed combinations lie outside of these
        (Some(estimate), Some(harmful)) if estimate != harmful && answer.kind == "difference" => {
            let (estimate, harmful) = scale.show_both(estimate, harmful);
            text += &format!(" = {estimate} with bad runs harmless, {harmful} with bad runs harmful");
        }
        (Some(estimate), Some(harmful)) if estimate != harmful => {
            let (estimate, harmful) = scale.show_both(estimate, harmful);
            text += &format!(" = {estimate} to {harmful}");
        }
        // reached values of beyond runs are lower bounds, and failed runs count at their lower bound
        (Some(estimate), None) if bad.beyond > 0 && answer.kind == "quantile" => {
            text += &format!(": at least {} in these runs", scale.show(estimate));
            limits = lower_limit_only(answer, scale);
        }
        // the subject says that the mean is that of the runs inside the model
        (Some(estimate), None) if bad.failing() == 0 && bad.beyond > 0 && answer.kind == "mean" => {
            text += &format!(" = {}", scale.show(estimate));
        }
        (Some(estimate), None) if answer.bad > 0 => {
            let which = if bad.failing() == 0 && bad.beyond > 0 { "runs beyond the model" } else { "bad runs" };
            text += &format!(" = {}, no number with {which} harmful", scale.show(estimate));
        }
        (Some(estimate), _) => text += &format!(" = {}", scale.show(estimate)),
        (None, Some(harmful)) => text += &format!(" is at most {}", scale.show(harmful)),
        (None, None) => text += " has no number",
    }
    text += &limits.unwrap_or_else(|| match (answer.low, answer.high) {
        (Some(low), Some(high)) => {
            let (low, high) = scale.show_both(low, high);
            format!(" ({about}{level}: {low} to {high})")
        }
        (Some(low), None) => format!(" ({about}{level}: from {}, no upper limit)", scale.show(low)),
        (None, Some(high)) => format!(" ({about}{level}: up to {}, no lower limit)", scale.show(high)),
        (None, None) => " (no interval)".to_owned(),
    });
    text += &match answer.events {
        Some(events) => format!(", {events} of {}", answer.n),
        None => format!(", {}", counted(answer.n, "run")),
    };
    let open = bad.open();
    if open.all > 0 && !is_unchanged_by_bad(answer) {
        // a mean without limits is that of the other runs
        let both = answer.low.is_some() || answer.high.is_some() || answer.estimate_if_bad_harmful.is_some();
        text += &format!(", {}", open.words());
        if both {
            text += &format!(" {UNDECIDED}");
        }
    }
    let decided = bad.decided();
    if decided.all > 0 {
        text += &format!(", {} {by}", decided.words());
    }
    text
}

/// "exceedance of max_bearing_load_N: 1000 levels from 1 MN to 3 MN, in 10000 runs".
#[must_use]
pub fn of_curve(
    answer: &Answer,
    subject: &str,
    points: &[CurvePoint],
    (unit, what): (&str, &str),
    bad: &Bad,
) -> String {
    let mut text = format!("{}{subject}: {}", prefix(&answer.group), counted(points.len() as u64, what));
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        let show = |label: &Label| match label {
            Label::Number(number) => format_digits(*number, unit, 4),
            Label::Word(word) => word.clone(),
        };
        text += &format!(" from {} to {}", show(&first.at.0), show(&last.at.1));
    }
    text += &format!(", {}", counted(answer.n, "run"));
    if bad.all > 0 {
        text += &format!(", {} (the limits cover all possible outcomes)", bad.words());
    }
    text
}
