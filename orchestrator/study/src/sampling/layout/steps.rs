//! One-at-a-time design: a base point, then each parameter at other values while the others stay.
//!
//! ```text
//! point 0                 the base point: medians (for words the most probable), or present values of the machine    block 0
//! then                    each other value of the discrete parameters, parameter by parameter                         block 1
//! then for each quantile  every other parameter at that quantile, parameter by parameter                              one more each
//! ```
//! A quantile added at the end of the list adds points at the end and changes none. A block is the smallest set that is useful only as a
//! whole: all parameters at one quantile. By default 10 % and 90 %, as in a tornado diagram.

use super::def::{Base, LayoutDef, LayoutError};
use crate::uncertain::{Uncertain, Values};

/// Default quantiles.
const QUANTILES: [f64; 2] = [0.1, 0.9];

/// A one-at-a-time design.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    base: Vec<f64>,
    /// For each point after the base point: the changed parameter, its value, the block.
    changes: Vec<(usize, f64, u64)>,
}

impl Steps {
    /// The design of valid keys.
    pub(super) fn new(def: &LayoutDef, names: &[String], laws: &[Uncertain]) -> Result<Self, Vec<LayoutError>> {
        let mut errors = Vec::new();
        let median = |law: &Uncertain| match law {
            Uncertain::Discrete(discrete) if discrete.values().0.is_words() => discrete.number(discrete.likeliest()),
            law => law.quantile(0.5, 0.5),
        };
        let base: Vec<f64> = match &def.base {
            None | Some(Base::Median) => laws.iter().map(median).collect(),
            Some(Base::Nominal(values)) => {
                let missing = names.iter().zip(values).filter(|(_, value)| value.is_none());
                errors.extend(missing.map(|(name, _)| LayoutError::NoNominal { name: name.clone() }));
                values.iter().map(|value| value.unwrap_or(f64::NAN)).collect()
            }
        };
        let mut changes = Vec::new();
        let mut block = 0;
        for (parameter, law) in laws.iter().enumerate() {
            let Uncertain::Discrete(discrete) = law else { continue };
            let weights = discrete.values().1;
            let possible = (0..weights.len()).filter(|place| weights[*place] > 0.0).map(|place| discrete.number(place));
            let others = possible.filter(|value| *value != base[parameter]);
            changes.extend(others.map(|value| (parameter, value, 1)));
            block = 1;
        }
        for (position, &p) in def.quantiles.as_deref().unwrap_or(&QUANTILES).iter().enumerate() {
            block += 1;
            for (parameter, law) in laws.iter().enumerate() {
                if matches!(law, Uncertain::Discrete(_)) {
                    continue;
                }
                let value = law.quantile(p, 1.0 - p);
                if value.is_finite() {
                    changes.push((parameter, value, block));
                } else {
                    let allowed = format!("above 0 and below 1: {} has no such end", names[parameter]);
                    errors.push(LayoutError::Element { key: "quantiles", position, given: p, allowed });
                }
            }
        }
        if errors.is_empty() { Ok(Self { base, changes }) } else { Err(errors) }
    }

    /// Number of points.
    #[must_use]
    pub fn count(&self) -> u64 {
        1 + self.changes.len() as u64
    }

    /// The parameter that a point changes; `None` for the base point.
    #[must_use]
    pub fn changed(&self, index: u64) -> Option<usize> {
        self.change(index).map(|(parameter, ..)| *parameter)
    }

    fn change(&self, index: u64) -> Option<&(usize, f64, u64)> {
        self.changes.get(usize::try_from(index.checked_sub(1)?).ok()?)
    }

    pub(super) fn block(&self, index: u64) -> u64 {
        self.change(index).map_or(0, |(.., block)| *block)
    }

    /// Appends the values of a point to `values`.
    pub(crate) fn values(&self, index: u64, values: &mut Vec<f64>) {
        let first = values.len();
        values.extend(&self.base);
        if let Some(&(parameter, value, _)) = self.change(index) {
            values[first + parameter] = value;
        }
    }
}

impl Values {
    /// Whether the values are words.
    #[must_use]
    pub fn is_words(&self) -> bool {
        matches!(self, Values::Words(_))
    }
}
