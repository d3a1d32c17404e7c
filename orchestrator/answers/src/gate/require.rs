//! Syntax of a gate: `P(max_bearing_load_N > 1.2 MN) < 1e-2`.

use crate::ask::{CONFIDENCE, Names, Problem};
use crate::estimate::formula::{Formula, closing};
use bladeoff_text::formula::{Kind, parse};

/// `P(CONDITION) < BOUND`.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    /// The gate as written.
    pub text: String,
    /// Condition whose probability is bounded.
    pub condition: Formula,
    /// Bound of the probability, above 0 and at most 1.
    pub bound: f64,
    /// Confidence level of each decision.
    pub confidence: f64,
}

impl Gate {
    /// Parses a gate such as `P(max_bearing_load_N > 1.2e6) < 1e-2`.
    ///
    /// # Errors
    /// All errors with their places in the text.
    pub fn new(text: &str, confidence: Option<f64>, names: &Names) -> Result<Self, Vec<Problem>> {
        let wrong = |place: std::ops::Range<usize>, message: String| {
            Err(vec![Problem { key: "require", place: Some(place), message, allowed: None }])
        };
        const FORM: &str = "a gate is `P(CONDITION) < BOUND`, such as `P(max_bearing_load_N > 1.2 MN) < 1e-2`";
        let start = text.len() - text.trim_start().len();
        let rest = &text[start..];
        let Some(open) = rest.strip_prefix('P').map(str::trim_start).filter(|rest| rest.starts_with('(')) else {
            return wrong(0..text.len(), FORM.to_owned());
        };
        let from = text.len() - open.len() + 1;
        let Some(length) = closing(&text[from..]) else {
            return wrong(from - 1..text.len(), "`)` is missing after `P(...`".to_owned());
        };
        let (condition, after) = (&text[from..from + length], from + length + 1);
        let sign = text[after..].trim_start();
        let at = text.len() - sign.len();
        if sign.starts_with("<=") {
            return wrong(at..at + 2, "write `<`: a limit is never exactly at the bound".to_owned());
        }
        if sign.starts_with('>') {
            let why = "a gate checks that a probability is small; write `P(not (...)) < ...` for a probability that \
                       must be large";
            return wrong(at..at + 1, why.to_owned());
        }
        if !sign.starts_with('<') {
            return wrong(at..text.len(), FORM.to_owned());
        }
        let end = &text[at + 1..];
        if let Some((from, c)) =
            end.char_indices().find(|(_, c)| (c.is_alphabetic() && !matches!(c, 'e' | 'E')) || *c == '°')
        {
            let place = at + 1 + from..at + 1 + from + c.len_utf8();
            return wrong(place, "a bound is a plain number, or one with `%`".to_owned());
        }
        // the three parts are checked independently
        let mut problems = Vec::new();
        let mut say =
            |place, message| problems.push(Problem { key: "require", place: Some(place), message, allowed: None });
        let found = Formula::condition(condition, &names.known)
            .map_err(|error| say(error.place.start + from..error.place.end + from, error.message));
        let bound = match parse(end, Kind::Number, &|_| None, &|_| None) {
            Ok(program) => program.value(|_| f64::NAN, &mut Vec::new()),
            Err(error) => {
                say(error.place.start + at + 1..error.place.end + at + 1, error.message);
                1.0
            }
        };
        if !(bound > 0.0 && bound <= 1.0) {
            say(at + 1..text.len(), format!("a bound is above 0 and at most 1, not {bound}"));
        }
        let confidence = confidence.unwrap_or(CONFIDENCE);
        if !(confidence > 0.0 && confidence < 1.0) {
            let message = format!("{confidence} is not between 0 and 1");
            problems.push(Problem { key: "confidence", place: None, message, allowed: None });
        }
        match found {
            Ok(condition) if problems.is_empty() => {
                Ok(Self { text: text.trim().to_owned(), condition, bound, confidence })
            }
            _ => Err(problems),
        }
    }
}
