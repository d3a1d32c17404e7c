//! Description of an uncertain parameter for `check`: "normal, mean 1 mm, sd 0.1 mm, cut at 0.7 mm and 1.3 mm: mean 1 mm, sd 98.66 um".

use super::Uncertain;
use super::keys::{Distribution, Holds, Values, Written};
use bladeoff_text::document::units::{format_digits, format_quantity};

/// Most values that are listed.
const SHOWN: usize = 8;

/// Name and keys of a distribution.
pub(super) fn law_in_words(distribution: Distribution, written: &Written, unit: &str) -> String {
    let few = |key: &str, number: f64| {
        format_quantity(number, if Distribution::holds(key) == Some(Holds::Quantity) { unit } else { "" })
    };
    let end = |key: &str| written.number(key).map(|number| few(key, number));
    // ends that round to the same text are shown with all their digits
    let are_near = end("lower").is_some() && end("lower") == end("upper");
    let shown = |key: &str, number: f64| match key {
        "lower" | "upper" if are_near => format_digits(number, unit, 17),
        _ => few(key, number),
    };
    let takes = distribution.takes();
    let is_cut = |key: &str| takes.optional.contains(&key);
    let mut said = distribution.word().to_owned();
    if let (Distribution::Empirical, Some(Values::Numbers(numbers))) = (distribution, &written.values) {
        let least = numbers.iter().fold(f64::INFINITY, |least, number| least.min(*number));
        let most = numbers.iter().fold(f64::NEG_INFINITY, |most, number| most.max(*number));
        let (least, most) = (format_quantity(least, unit), format_quantity(most, unit));
        said += &format!(", {} values from {least} to {most}", numbers.len());
    }
    // in the order of the distribution's keys, not of the file
    for key in takes.needed.iter().copied().flatten() {
        if let Some(number) = written.number(key) {
            said += &format!(", {key} {}", shown(key, number));
        }
    }
    let cut = |key: &str| written.number(key).filter(|_| is_cut(key)).map(|number| shown(key, number));
    said + &match (cut("lower"), cut("upper")) {
        (Some(lower), Some(upper)) => format!(", cut at {lower} and {upper}"),
        (Some(lower), None) => format!(", cut below {lower}"),
        (None, Some(upper)) => format!(", cut above {upper}"),
        (None, None) => String::new(),
    }
}

impl Uncertain {
    /// One sentence: the distribution as read, then mean and standard deviation after truncation. `written`: the keys of the distribution.
    #[must_use]
    pub fn sentence(&self, written: &Written, unit: &str) -> String {
        let said = match self {
            Uncertain::Continuous(law) => law.said().to_owned(),
            Uncertain::Empirical(_) => law_in_words(Distribution::Empirical, written, unit),
            Uncertain::Periodic(..) => law_in_words(Distribution::Periodic, written, unit),
            Uncertain::Discrete(law) => {
                let (values, weights) = law.values();
                let part = |weight: f64| format!("{} %", format_digits(100.0 * weight, "", 4));
                let value = |place: usize| match values {
                    Values::Numbers(numbers) => format_quantity(numbers[place], unit),
                    Values::Words(words) => words[place].clone(),
                };
                let shown: Vec<String> = (0..weights.len().min(SHOWN))
                    .map(|place| format!("{} ({})", value(place), part(weights[place])))
                    .collect();
                let more = match weights.len().saturating_sub(SHOWN) {
                    0 => String::new(),
                    more => format!(" and {more} more"),
                };
                format!("discrete, {}{more}", shown.join(", "))
            }
        };
        match (self.moments(), self) {
            (Some((mean, sd)), _) => {
                format!("{said}: mean {}, sd {}", format_digits(mean, unit, 4), format_digits(sd, unit, 4))
            }
            (None, Uncertain::Periodic(..)) => format!("{said}: uniform, both ends are the same"),
            (None, _) => said,
        }
    }
}
