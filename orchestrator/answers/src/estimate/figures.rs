//! An estimate with bad runs harmless and harmful, and its interval; sums over replicates.

use serde::{Serialize, Serializer};

/// Method of an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Exact limits of a probability (C. J. Clopper, E. S. Pearson, 1934).
    ClopperPearson,
    /// Exact limits of the two probabilities that only one of two conditions holds.
    PairedClopperPearson,
    /// Exact limits of a quantile from order statistics.
    OrderStatistics,
    /// Band around a whole curve: P. Massart's (1990) in the middle, exact limits in the tails.
    Band,
    /// Student's t of independent values.
    Student,
    /// Student's t of replicates.
    Replicates,
    /// Percentiles of resampled blocks (B. Efron, 1979).
    Bootstrap,
    /// No interval.
    Without,
}

impl Method {
    /// Name of the method in `answers.json`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::ClopperPearson => "clopper-pearson",
            Self::PairedClopperPearson => "paired-clopper-pearson",
            Self::OrderStatistics => "order-statistics",
            Self::Band => "exact-band",
            Self::Student => "student-t",
            Self::Replicates => "replicates-t",
            Self::Bootstrap => "bootstrap",
            Self::Without => "none",
        }
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(self.word())
    }
}

/// An estimate with its interval; `None` where a number is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Number of points.
    pub n: u64,
    /// Points where the event certainly happened.
    pub events: Option<u64>,
    /// Estimate with bad runs counted as harmless.
    pub estimate: Option<f64>,
    /// Estimate with bad runs counted as harmful.
    pub harmful: Option<f64>,
    /// Lower limit, bad runs counted as harmless.
    pub low: Option<f64>,
    /// Upper limit, bad runs counted as harmful.
    pub high: Option<f64>,
    /// Width of the interval if every bad run were harmless.
    pub statistical: Option<f64>,
    /// Method of the interval.
    pub method: Method,
    /// Whether the interval holds asymptotically (many points) instead of exactly.
    pub approximate: bool,
    /// Reservations and remarks for the reader.
    pub notes: Vec<String>,
}

impl Figures {
    /// Figures over n points, without any number yet.
    #[must_use]
    pub fn over(n: u64) -> Self {
        Self {
            n,
            events: None,
            estimate: None,
            harmful: None,
            low: None,
            high: None,
            statistical: None,
            method: Method::Without,
            approximate: false,
            notes: Vec::new(),
        }
    }

    /// Shift of the estimate by bad runs: harmful - harmless.
    #[must_use]
    pub fn left_open(&self) -> Option<f64> {
        Some(self.harmful? - self.estimate?)
    }
}

/// The value if it is finite.
#[must_use]
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Compensated sum (A. Neumaier, 1974), in the order of the calls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sum {
    sum: f64,
    rest: f64,
}

impl Sum {
    /// Adds a number.
    pub fn add(&mut self, value: f64) {
        let sum = self.sum + value;
        self.rest += if self.sum.abs() >= value.abs() { (self.sum - sum) + value } else { (value - sum) + self.sum };
        self.sum = sum;
    }

    /// The sum so far.
    #[must_use]
    pub fn value(self) -> f64 {
        self.sum + self.rest
    }

    /// Sum of these values.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> f64 {
        let mut sum = Self::default();
        values.into_iter().for_each(|value| sum.add(value));
        sum.value()
    }
}

/// A ratio of sums over replicates and half the width of its interval, by Student's t of the replicates' residuals.
///
/// ```text
/// q = sum y / sum w,  e_r = y_r - q w_r,  half = t sqrt(sum e^2/(R (R - 1))) / (sum w/R)
/// ```
/// If every replicate has the same weight, this is the t interval of the replicates' means. Source: W. G. Cochran, "Sampling
/// techniques" (1977), section 2.11. `None` with fewer than two replicates or without weight.
///
/// * `replicates` - y and w of each; `t` - Student's t with R - 1 degrees of freedom.
#[must_use]
pub fn ratio(replicates: &[(f64, f64)], t: f64) -> Option<(f64, f64)> {
    let count = replicates.len() as f64;
    let weight = Sum::of(replicates.iter().map(|(_, w)| *w));
    if replicates.len() < 2 || weight <= 0.0 {
        return None;
    }
    let q = Sum::of(replicates.iter().map(|(y, _)| *y)) / weight;
    let squares = Sum::of(replicates.iter().map(|(y, w)| (y - q * w) * (y - q * w)));
    let error = libm::sqrt(squares / (count * (count - 1.0))) / (weight / count);
    Some((q, t * error))
}

/// [`ratio`] for shares of points: y counts points, w is the number of points of each replicate.
///
/// If all R replicates have the same count, their scatter is 0 although the mean count may still be off by d, where each replicate
/// differs by one with probability d. Such an offset cannot be excluded while (1 - d)^R >= alpha/2, so the interval is never narrower than
/// this d. Stratified points cause this case: if the event depends on one variable, with its limit at a boundary of strata, every
/// replicate has almost the same count.
#[must_use]
pub fn ratio_of_counts(replicates: &[(f64, f64)], t: f64, alpha: f64) -> Option<(f64, f64)> {
    let count = replicates.len() as f64;
    let points = Sum::of(replicates.iter().map(|(_, w)| *w)) / count;
    let unseen = 1.0 - libm::pow(0.5 * alpha, 1.0 / count);
    ratio(replicates, t).map(|(share, half)| (share, half.max(unseen / points)))
}
