//! A figure with bad runs harmless and harmful, and its interval; sums over replicates.

use serde::{Serialize, Serializer};

/// How an interval was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// C. J. Clopper, E. S. Pearson (1934): exact limits of a probability.
    ClopperPearson,
    /// Exact limits of both numbers of points where only one of two conditions holds.
    PairedClopperPearson,
    /// Exact limits of a quantile.
    OrderStatistics,
    /// A band around a whole curve: P. Massart's (1990) in the middle, exact limits in the tails.
    Band,
    /// Student's t of independent values.
    Student,
    /// Student's t of replicates.
    Replicates,
    /// Percentiles of resampled blocks (B. Efron, 1979).
    Bootstrap,
    /// None.
    Without,
}

impl Method {
    /// Its word in `answers.json`.
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

/// A figure; `None` where there is no number.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Points it is over.
    pub n: u64,
    /// Points where the event happened for certain.
    pub events: Option<u64>,
    /// With bad runs harmless.
    pub estimate: Option<f64>,
    /// With bad runs harmful.
    pub harmful: Option<f64>,
    /// Lower limit, bad runs harmless.
    pub low: Option<f64>,
    /// Upper limit, bad runs harmful.
    pub high: Option<f64>,
    /// Width of the interval, were every bad run harmless.
    pub statistical: Option<f64>,
    /// How the limits were made.
    pub method: Method,
    /// The interval holds in the limit of many points, not exactly.
    pub approximate: bool,
    /// What a reader has to know.
    pub notes: Vec<String>,
}

impl Figures {
    /// Without any number yet.
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

    /// How far bad runs move the figure.
    #[must_use]
    pub fn left_open(&self) -> Option<f64> {
        Some(self.harmful? - self.estimate?)
    }
}

/// A number that is one.
#[must_use]
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// A sum that keeps what rounding drops (A. Neumaier, 1974), in the order it is given.
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

    /// The sum.
    #[must_use]
    pub fn value(self) -> f64 {
        self.sum + self.rest
    }

    /// Of all these.
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
/// Where every replicate weighs the same this is the t interval of the replicates' means. Source: W. G. Cochran, "Sampling
/// techniques" (1977), section 2.11. Needs two replicates and a weight; `None` otherwise.
///
/// * `replicates` - y and w of each; `t` - Student's, of R - 1 degrees of freedom.
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

/// The same of shares: y counts points, w are the points of each replicate.
///
/// Where all R replicates have the same count, the mean count may still be d off, every replicate having that chance to differ by one:
/// as long as (1 - d)^R >= alpha/2, nothing says otherwise. So limits are never nearer than that. Stratified points make it happen:
/// of an event of one variable at a boundary of strata every replicate has all but the same count.
#[must_use]
pub fn ratio_of_counts(replicates: &[(f64, f64)], t: f64, alpha: f64) -> Option<(f64, f64)> {
    let count = replicates.len() as f64;
    let points = Sum::of(replicates.iter().map(|(_, w)| *w)) / count;
    let unseen = 1.0 - libm::pow(0.5 * alpha, 1.0 / count);
    ratio(replicates, t).map(|(share, half)| (share, half.max(unseen / points)))
}
