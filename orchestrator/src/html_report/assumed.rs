//! Assumptions of the machines of a study, for `check` and the report: one line for each part of the model.

use bladeoff_model::machine::{Assumption, Machine, MachineDef};
use bladeoff_study::Samples;
use std::collections::BTreeMap;

/// Largest number of samples whose lines are compared.
const MOST: u64 = 32;

/// Lines of one machine.
#[must_use]
pub fn assumed_of_machine(definition: &MachineDef, machine: &Machine) -> Vec<String> {
    definition.assumptions(machine).iter().map(|one| line(one.topic, &one.text)).collect()
}

fn line(topic: &str, text: &str) -> String {
    format!("{topic}: {text}")
}

/// The part of `other` between the common beginning and end with `first`; all of `other` if half of it or more differs.
fn difference<'a>(first: &str, other: &'a str) -> &'a str {
    let equal = |(a, b): &(&str, &str)| a == b;
    let beginning: usize =
        first.split_inclusive(' ').zip(other.split_inclusive(' ')).take_while(equal).map(|(_, word)| word.len()).sum();
    let (a, b) = (&first[beginning..], &other[beginning..]);
    let end: usize = a.rsplit(' ').zip(b.rsplit(' ')).take_while(equal).map(|(_, word)| word.len() + 1).sum();
    let middle = b[..b.len().saturating_sub(end)].trim().trim_end_matches([',', ';']);
    if middle.is_empty() || 2 * middle.len() > other.len() { other } else { middle }
}

/// Lines of a study: those of its first sample, with a mark on each line that differs in another sample. Empty for a study of
/// formulas.
#[must_use]
pub fn assumed(samples: &Samples) -> Vec<String> {
    let of = |sample: u64| -> Option<Vec<Assumption>> {
        let definition = samples.try_machine(sample).ok().flatten()?;
        Some(definition.assumptions(&definition.build().ok()?))
    };
    let Some(first) = of(0) else { return Vec::new() };
    let most = samples.count().min(MOST);
    let mut others: BTreeMap<&'static str, String> = BTreeMap::new();
    for at in 1..most {
        // evenly spaced from the first to the last sample
        let sample = (u128::from(at) * u128::from(samples.count() - 1) / u128::from(most - 1)) as u64;
        for one in of(sample).unwrap_or_default() {
            if first.iter().find(|line| line.topic == one.topic).is_none_or(|line| line.text != one.text) {
                others.entry(one.topic).or_insert(one.text);
            }
        }
    }
    let mut lines: Vec<String> = first
        .iter()
        .map(|one| match others.remove(one.topic) {
            None => line(one.topic, &one.text),
            Some(other) => {
                format!(
                    "{}; this is sample 0, another sample has: {}",
                    line(one.topic, &one.text),
                    difference(&one.text, &other)
                )
            }
        })
        .collect();
    lines.extend(others.iter().map(|(topic, text)| format!("{} (in some samples)", line(topic, text))));
    lines
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn a_difference_is_the_words_that_differ() {
        let (first, other) = (
            "Coulomb, constant coefficient 0.169, stick and slip; no heat",
            "Coulomb, constant coefficient 0.139, stick and slip; no heat",
        );
        assert_eq!(difference(first, other), "0.139");
        assert_eq!(difference("off: no sag", "on, 9.81 m/s2"), "on, 9.81 m/s2");
    }
}
