//! A sample as a distribution: its order statistics with linear interpolation.
//!
//! ```text
//! x(p) = x_i at p = (i - 1/2)/n, i = 1 .. n, linear between; x_1 below 1/(2n) and x_n above 1 - 1/(2n)
//! ```
//! Source: A. Hazen (1914); definition 5 of R. J. Hyndman, Y. Fan, "Sample quantiles in statistical packages" (1996). Of their nine definitions,
//! this is the one whose mean is the mean of the sample, without values outside the sample. Its standard deviation is a little below that of
//! the sample, because of the interpolation.
//!
//! Truncation to `lower` .. `upper` keeps the range of p between the first position with x >= lower and the last with x <= upper.

use bladeoff_model::machine::Range;

/// An empirical distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Empirical {
    sorted: Vec<f64>,
    /// Remaining range of p.
    from: f64,
    to: f64,
    bounds: [f64; 2],
}

impl Empirical {
    /// Creates the truncated distribution of sorted values, at least one; the remaining part may be 0 or less.
    pub(super) fn new(sorted: Vec<f64>, lower: Option<f64>, upper: Option<f64>) -> Self {
        let bounds = [lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)];
        let mut law = Self { sorted, from: 0.0, to: 1.0, bounds };
        let from = lower.map_or(0.0, |lower| law.part_below(lower));
        let to = upper.map_or(1.0, |upper| law.part_up_to(upper));
        law.from = from;
        law.to = to;
        law
    }

    /// Probability that remains after truncation; 0 or less: nothing remains.
    #[must_use]
    pub fn left(&self) -> f64 {
        self.to - self.from
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> usize {
        self.sorted.len()
    }

    /// Smallest and largest value of the sample.
    #[must_use]
    pub fn sample_ends(&self) -> [f64; 2] {
        [self.sorted[0], self.sorted[self.sorted.len() - 1]]
    }

    /// P(x < value) of the whole sample.
    fn part_below(&self, value: f64) -> f64 {
        self.part(value, self.sorted.partition_point(|x| *x < value))
    }

    /// P(x <= value) of the whole sample.
    fn part_up_to(&self, value: f64) -> f64 {
        self.part(value, self.sorted.partition_point(|x| *x <= value))
    }

    /// The p at which the distribution passes `value`; `below` values of the sample are smaller.
    fn part(&self, value: f64, below: usize) -> f64 {
        let n = self.sorted.len();
        if below == 0 {
            return 0.0;
        }
        if below == n {
            return 1.0;
        }
        let (left, right) = (self.sorted[below - 1], self.sorted[below]);
        (below as f64 - 0.5 + (value - left) / (right - left)) / n as f64
    }

    /// The value with the probability p below it.
    pub(super) fn quantile(&self, p: f64, q: f64) -> f64 {
        let part = if p <= q { self.from + p * self.left() } else { self.to - q * self.left() };
        // rounding must not exceed a bound
        self.at(part).max(self.bounds[0]).min(self.bounds[1])
    }

    fn at(&self, part: f64) -> f64 {
        let last = self.sorted.len() - 1;
        let place = part * self.sorted.len() as f64 - 0.5;
        if place <= 0.0 {
            return self.sorted[0];
        }
        let below = (libm::floor(place) as usize).min(last);
        if below == last {
            return self.sorted[last];
        }
        let (left, right) = (self.sorted[below], self.sorted[below + 1]);
        (left + (place - below as f64) * (right - left)).min(right)
    }

    /// The remaining pieces: width in p and the values at their ends.
    fn pieces(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let n = self.sorted.len();
        let knot = move |i: usize| {
            if i == 0 {
                0.0
            } else if i > n {
                1.0
            } else {
                (i as f64 - 0.5) / n as f64
            }
        };
        (0..=n).filter_map(move |i| {
            let (left, right) = (knot(i).max(self.from), knot(i + 1).min(self.to));
            (right > left).then(|| (right - left, self.at(left), self.at(right)))
        })
    }

    pub(super) fn moments(&self) -> (f64, f64) {
        let all = self.left();
        let mean = self.pieces().map(|(width, a, b)| width / all * (0.5 * a + 0.5 * b)).sum::<f64>();
        let square = self.pieces().map(|(width, a, b)| {
            let (a, b) = (a - mean, b - mean);
            width / all * (a * a + a * b + b * b) / 3.0
        });
        (mean, libm::sqrt(square.sum::<f64>()))
    }

    pub(super) fn outside(&self, range: Range) -> [f64; 2] {
        let [low, high] = range.ends();
        // an end may be a value of the sample
        let below = if range.contains(low) { self.part_below(low) } else { self.part_up_to(low) };
        let upto = if range.contains(high) { self.part_up_to(high) } else { self.part_below(high) };
        [(below - self.from).max(0.0) / self.left(), (self.to - upto).max(0.0) / self.left()]
    }

    pub(super) fn kinks(&self) -> Vec<f64> {
        let n = self.sorted.len() as f64;
        let knots = (0..self.sorted.len()).map(|i| (i as f64 + 0.5) / n);
        knots.map(|knot| (knot - self.from) / self.left()).filter(|p| *p > 0.0 && *p < 1.0).collect()
    }
}
