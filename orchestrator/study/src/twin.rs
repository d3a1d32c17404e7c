//! `twin_share`: the share of a study's samples that are computed twice, the second time with another initial speed (`run.twin`).
//!
//! The selection depends only on the number of a sample in the whole study, not on `--scale` and `--limit`:
//!
//! ```text
//! selected if (number x G mod 2^64)/2^64 < share,   G = 2^64/golden ratio
//! ```
//! Multiples of the golden ratio are evenly distributed in every sequence of numbers, and in every k-th of them. So each value of an axis has
//! its share of the twins, and the total number is right within one or two. Sample 0 is always selected.

use super::table::wrong_type;
use bladeoff_model::machine::{MachineDef, ParamValue, PathInfo, TWIN};
use bladeoff_text::document::{Collector, Entry, Value};

/// Default shift of the initial speed.
const SHIFT: f64 = 1e-6;
const ALLOWED: &str = "a share such as \"5 %\", or a number from 0 to 1";

/// Samples with a twin.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinShare {
    share: f64,
    /// The parameter `run.twin`, and its value for samples with a twin.
    pub info: PathInfo,
    /// Relative shift of the initial speed.
    pub shift: f64,
}

impl TwinShare {
    /// Reads the key of a study; sets `run.twin` of the machine if it is 0. Problems are added to `problems`.
    pub(super) fn read(entry: &Entry, machine: &mut MachineDef, problems: &mut Collector<'_>) -> Option<Self> {
        let share = match &entry.node.value {
            Value::Integer(number) => Some(*number as f64),
            Value::Float(number) => Some(*number),
            Value::Text(text) => {
                let percent = text.trim().strip_suffix('%').and_then(|number| number.trim_end().parse::<f64>().ok());
                percent.map(|percent| percent / 100.0)
            }
            _ => {
                wrong_type(&entry.node, "twin_share", "a share", problems);
                return None;
            }
        };
        let Some(share) = share.filter(|share| (0.0..=1.0).contains(share)) else {
            let value = problems.excerpt(entry.node.span.clone());
            let problem = problems.add(entry.node.span.clone(), "twin_share", "not a share of the samples");
            problem.value = Some(value);
            problem.allowed = Some(ALLOWED.to_owned());
            return None;
        };
        let info = machine.resolve(TWIN).ok()?;
        let shift = match info.value {
            Some(ParamValue::Number(shift)) if shift > 0.0 => shift,
            _ => {
                machine.set(&info, &ParamValue::Number(SHIFT)).ok()?;
                SHIFT
            }
        };
        Some(Self { share, info, shift })
    }

    /// `run.twin` of the sample with this number in the whole study.
    #[must_use]
    pub fn shift_of(&self, number: u64) -> f64 {
        let place = u128::from(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        // exact: a power of two times a number below one
        let limit = (self.share * 18_446_744_073_709_551_616.0) as u128;
        if place < limit { self.shift } else { 0.0 }
    }
}

impl std::fmt::Display for TwinShare {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} %", 100.0 * self.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_its_part_of_the_twins() {
        let text = include_str!("../../../studies/machines/lab_rig.toml");
        let machine = MachineDef::parse("m.toml", text).expect("valid");
        let info = machine.resolve(TWIN).expect("the path");
        let twins = |share: f64, numbers: &mut dyn Iterator<Item = u64>| {
            let share = TwinShare { share, info: info.clone(), shift: 1e-6 };
            numbers.filter(|number| share.shift_of(*number) > 0.0).count()
        };
        assert_eq!(twins(0.0, &mut (0..1000)), 0);
        assert_eq!(twins(1.0, &mut (0..1000)), 1000);
        for share in [0.05, 0.1, 0.3] {
            // of all samples, and of each value of an inner axis of 2 to 9 values
            for step in 1..=9 {
                for first in 0..step {
                    let found = twins(share, &mut (0..1000).map(|k| first + step * k)) as f64;
                    assert!((found - 1000.0 * share).abs() <= 8.0, "{share} of every {step}th from {first}: {found}");
                }
            }
        }
        assert!((5..=7).contains(&twins(0.05, &mut (0..108))));
    }
}
