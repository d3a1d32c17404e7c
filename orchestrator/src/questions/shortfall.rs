//! Reasons in words why an answer is less precise than `[stop]` requires.

use super::forecast::group_in_words;
use bladeoff_answers::ask::Answer;
use bladeoff_answers::estimate::bad::Bad;
use bladeoff_answers::estimate::figures::Figures;
use bladeoff_answers::stop::{Hindrance, Precision, StopRule};

/// The numbers of an answer that are not precise enough, with the reason; `only_hindered`: only those that no further point makes precise enough.
pub(super) fn short_of(rule: &StopRule, answer: &Answer, only_hindered: bool) -> Vec<(String, String)> {
    let group = group_in_words(answer);
    let group = if group.is_empty() { group } else { format!(" ({group})") };
    let of = |(at, figures): (usize, &Figures)| {
        let why = match rule.hindrance(figures, answer.bad, 1.0 - answer.confidence) {
            Some(hindrance) => hindered(&hindrance, answer),
            None if only_hindered => return None,
            None => wide(rule, figures, answer)?,
        };
        let number = answer.figure_name(at);
        let number = if number.is_empty() { number } else { format!(", {number}") };
        Some((format!("{}{group}{number}", answer.name), why))
    };
    answer.figures.iter().enumerate().filter_map(of).collect()
}

/// The runs of an answer's group that are not ok.
fn bad_of(answer: &Answer) -> Bad {
    Bad { all: answer.bad, beyond: answer.beyond, ..Bad::default() }
}

/// Whether runs beyond the model prevent a number of an answer from reaching the required precision.
pub(super) fn is_left_open(rule: &StopRule, answer: &Answer) -> bool {
    let of = |figures: &Figures| rule.hindrance(figures, answer.bad, 1.0 - answer.confidence);
    answer.beyond_open > 0
        && answer.figures.iter().any(|figures| matches!(of(figures), Some(Hindrance::BadRuns { .. })))
}

fn hindered(hindrance: &Hindrance, answer: &Answer) -> String {
    match hindrance {
        Hindrance::BadRuns { open, wanted, is_sure } => {
            let (bad, wanted) = (bad_of(answer).words(), answer.scale.show(*wanted));
            let s = if answer.bad == 1 { "s" } else { "" };
            let open = match open {
                Some(open) => {
                    format!("alone make{s} half of its interval {}; {wanted} is required", answer.scale.show(*open))
                }
                None => format!("leave{s} it without a limit"),
            };
            // a single line for all figures states this reason
            if bad_of(answer).failing() == 0 && answer.beyond > 0 {
                return format!("{bad} {open}");
            }
            let narrow = if *is_sure { "do not narrow that" } else { "may not narrow that" };
            format!("{bad} {open}: more points {narrow}, find out why they fail")
        }
        Hindrance::Zero => "its estimate is 0 so far, so `relative` allows no width: set `half_width`".to_owned(),
        Hindrance::NoNumber => {
            let why = answer.sensitivity.as_ref().and_then(|found| found.indices.without);
            format!("it has no number{}", why.map_or(String::new(), |why| format!(": {why}")))
        }
    }
}

/// Reason why an interval is too wide; `None` if it is precise enough.
fn wide(rule: &StopRule, figures: &Figures, answer: &Answer) -> Option<String> {
    let show = |value: f64| answer.scale.show(value);
    match rule.precision(figures) {
        Precision::Enough => None,
        Precision::Wide { half, wanted } => {
            let holds_zero = figures.low.is_some_and(|low| low <= 0.0) && figures.high.is_some_and(|high| high >= 0.0);
            let near = if rule.relative.is_some() && holds_zero {
                "; its value may be 0, where `relative` allows no width"
            } else {
                ""
            };
            Some(format!("half of its interval is {}; {} is required{near}", show(half), show(wanted)))
        }
        Precision::BadRuns => {
            let half = figures.high.zip(figures.low).map(|(high, low)| 0.5 * (high - low));
            let wanted = figures.estimate.and_then(|estimate| rule.wanted(estimate));
            let (half, wanted) = (half.map_or("without a limit".to_owned(), show), wanted.map_or(String::new(), show));
            let bad = bad_of(answer).words();
            Some(format!("half of its interval is {half} for any outcome of {bad}; {wanted} is required"))
        }
        Precision::NoInterval => Some("it has no interval".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_answers::estimate::figures::Method;
    use bladeoff_answers::estimate::input::Group;

    /// A mean without limits, of 100 runs, with the given numbers of failing runs and runs beyond the model.
    fn mean(failing: u64, beyond: u64) -> Answer {
        let figures = Figures { estimate: Some(5.0), method: Method::Student, ..Figures::over(100) };
        let bad = Bad { of: 100, all: failing + beyond, beyond, ..Bad::default() };
        let mut answer = Answer::of("load", "mean", Group::default(), bad, 0.95, figures.clone());
        answer.figures = vec![figures];
        answer
    }

    #[test]
    fn runs_beyond_the_model_are_named_and_no_advice_about_failures_is_given() {
        let rule = StopRule { half_width: Some(0.1), ..StopRule::default() };
        let said = |answer: &Answer| short_of(&rule, answer, true).remove(0).1;
        let beyond = mean(0, 17);
        assert!(is_left_open(&rule, &beyond));
        assert_eq!(said(&beyond), "17 runs beyond the model leave it without a limit");
        let both = mean(1, 17);
        assert!(is_left_open(&rule, &both));
        let says =
            "1 bad run and 17 runs beyond the model leave it without a limit: more points do not narrow that, find out";
        assert!(said(&both).starts_with(says), "{}", said(&both));
        let failing = mean(2, 0);
        assert!(!is_left_open(&rule, &failing) && said(&failing).ends_with("find out why they fail"));
    }
}
