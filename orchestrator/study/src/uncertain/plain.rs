//! Distributions in the form of other programs.

use super::Uncertain;
use super::law::Law;

/// A distribution with the parameters that other programs use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plain {
    /// Lower and upper end.
    Uniform(f64, f64),
    /// Lower end, mode, upper end.
    Triangular(f64, f64, f64),
    /// Mean, standard deviation.
    Normal(f64, f64),
    /// Lower and upper end; mean and standard deviation before truncation.
    TruncatedNormal(f64, f64, f64, f64),
    /// Mean and standard deviation of ln x.
    LogNormal(f64, f64),
    /// Lower and upper end: ln x is uniform.
    LogUniform(f64, f64),
    /// Shape and scale; an exponential distribution has shape 1.
    Weibull(f64, f64),
}

impl Uncertain {
    /// The distribution in the form of other programs; `None`: they do not have it.
    #[must_use]
    pub fn plain(&self) -> Option<Plain> {
        let law = match self {
            Uncertain::Continuous(law) => law,
            Uncertain::Periodic(from, to) => return Some(Plain::Uniform(*from, *to)),
            Uncertain::Empirical(_) | Uncertain::Discrete(_) => return None,
        };
        match (law.law(), law.cut()) {
            (Law::Uniform(from, to), [None, None]) => Some(Plain::Uniform(*from, *to)),
            (Law::Triangular(from, mode, to), [None, None]) => Some(Plain::Triangular(*from, *mode, *to)),
            (Law::Normal(mean, sd), [None, None]) => Some(Plain::Normal(*mean, *sd)),
            (Law::Normal(mean, sd), [Some(lower), Some(upper)]) => {
                Some(Plain::TruncatedNormal(lower, upper, *mean, *sd))
            }
            (Law::LogNormal(mu, sigma), [None, None]) => Some(Plain::LogNormal(*mu, *sigma)),
            (Law::LogUniform(from, to), [None, None]) => Some(Plain::LogUniform(*from, *to)),
            (Law::Weibull(shape, scale), [None, None]) => Some(Plain::Weibull(*shape, *scale)),
            (Law::Exponential(mean), [None, None]) => Some(Plain::Weibull(1.0, *mean)),
            _ => None,
        }
    }
}
