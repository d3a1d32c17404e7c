//! One uncertain parameter of `[[uncertain]]`: from the keys of the file to quantiles, moments and a description.
//!
//! | | order along which it is correlated | moments |
//! |---|---|---|
//! | continuous laws, truncated by `lower`, `upper` | the value | by quadrature of the quantile function |
//! | `empirical` | the value | exact |
//! | `discrete` | numbers: the value; words: as given | exact; words have none |
//! | `periodic` | the value, from `lower` | none: both ends are the same |

mod continuous;
mod discrete;
mod empirical;
mod error;
mod keys;
mod law;
pub(crate) mod panels;
mod plain;
mod read;
mod words;

pub use continuous::Continuous;
pub use discrete::Discrete;
pub use empirical::Empirical;
pub use error::UncertainError;
pub use keys::{Distribution, Holds, Values, Written};
pub use plain::Plain;

use bladeoff_model::machine::Range;

/// Largest allowed probability of values that the machine rejects.
pub const MOST_REFUSED: f64 = 1e-12;

/// Distribution of an uncertain parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Uncertain {
    /// A distribution with a density, truncated or not.
    Continuous(Continuous),
    /// Interpolated order statistics of a sample.
    Empirical(Empirical),
    /// Uniform from the first number to the second, which is equivalent to the first.
    Periodic(f64, f64),
    /// Discrete values with their probabilities.
    Discrete(Discrete),
}

impl Uncertain {
    /// The value with probability p below and q = 1 - p above it; for words, the position in their list.
    #[must_use]
    pub fn quantile(&self, p: f64, q: f64) -> f64 {
        match self {
            Uncertain::Continuous(law) => law.quantile(p, q),
            Uncertain::Empirical(law) => law.quantile(p, q),
            Uncertain::Periodic(from, to) => {
                let value = if p <= q { from + p * (to - from) } else { to - q * (to - from) };
                if value < *to { value } else { *from }
            }
            Uncertain::Discrete(law) => law.number(law.place(p, q)),
        }
    }

    /// Allowed words, if the values are words.
    #[must_use]
    pub fn words(&self) -> Option<&[String]> {
        match self {
            Uncertain::Discrete(law) => law.words(),
            _ => None,
        }
    }

    /// Mean and standard deviation after truncation; `None` for words and periodic values.
    #[must_use]
    pub fn moments(&self) -> Option<(f64, f64)> {
        match self {
            Uncertain::Continuous(law) => Some(law.moments()),
            Uncertain::Empirical(law) => Some(law.moments()),
            Uncertain::Periodic(..) => None,
            Uncertain::Discrete(law) => law.moments(),
        }
    }

    /// Probability of values below and above the range; 0 for words.
    #[must_use]
    pub fn outside(&self, range: Range) -> [f64; 2] {
        let [low, high] = range.ends();
        match self {
            // a single value has no probability
            Uncertain::Continuous(law) => [law.below(low), law.above(high)],
            Uncertain::Empirical(law) => law.outside(range),
            Uncertain::Periodic(from, to) => {
                let width = to - from;
                [((low.min(*to) - from) / width).max(0.0), ((to - high.max(*from)) / width).max(0.0)]
            }
            Uncertain::Discrete(law) => law.outside(range),
        }
    }

    /// Rejects a distribution whose values the machine would reject; `unit` is the SI unit of the parameter.
    ///
    /// # Errors
    /// The probability of such values exceeds [`MOST_REFUSED`].
    pub fn refuse_outside(&self, range: Range, unit: &str) -> Result<(), UncertainError> {
        let [below, above] = self.outside(range);
        let probability = below + above;
        if probability <= MOST_REFUSED {
            return Ok(());
        }
        let key = match self {
            Uncertain::Discrete(_) => "values",
            _ if below >= above => "lower",
            _ => "upper",
        };
        Err(UncertainError::Refused { key, probability, allowed: range.words(unit) })
    }

    /// Whether the values are ordered and continuous, so that rank and linear correlation are meaningful.
    #[must_use]
    pub fn is_ordered(&self) -> bool {
        matches!(self, Uncertain::Continuous(_) | Uncertain::Empirical(_))
    }

    /// Smallest and largest value; infinite for an unbounded distribution.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        [self.quantile(0.0, 1.0), self.quantile(1.0, 0.0)]
    }

    /// Probabilities at which the slope of the quantile function jumps.
    #[must_use]
    pub fn kinks(&self) -> Vec<f64> {
        match self {
            Uncertain::Continuous(law) => law.kink().into_iter().collect(),
            Uncertain::Empirical(law) => law.kinks(),
            _ => Vec::new(),
        }
    }
}
