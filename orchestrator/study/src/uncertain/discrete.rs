//! A finite number of values with their probabilities.
//!
//! ```text
//! L_i = w_1 + ... + w_i,  U_i = w_(i+1) + ... + w_n,  w summing to 1
//! value i where L_(i-1) < p <= L_i:  by the lower sums for p <= 1/2, by the upper ones above, so that a rare last value keeps its share
//! ```
//! Numbers are sorted, so that a positive correlation relates larger values to larger ones; words keep the given order.

use super::keys::Values;
use bladeoff_model::machine::Range;

/// A discrete distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete {
    values: Values,
    weights: Vec<f64>,
    /// L_i and U_i.
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Discrete {
    /// Creates the distribution from different values with weights >= 0, not all 0.
    pub(super) fn new(values: Values, weights: &[f64]) -> Self {
        // divided by the largest, because the sum may overflow
        let largest = weights.iter().fold(0.0f64, |largest, weight| largest.max(*weight));
        let mut weights: Vec<f64> = weights.iter().map(|weight| weight / largest).collect();
        let values = match values {
            Values::Numbers(numbers) => {
                let mut order: Vec<usize> = (0..numbers.len()).collect();
                order.sort_by(|&a, &b| numbers[a].total_cmp(&numbers[b]));
                weights = order.iter().map(|&place| weights[place]).collect();
                Values::Numbers(order.iter().map(|&place| numbers[place]).collect())
            }
            words => words,
        };
        let total: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= total);
        let running = |weights: &mut dyn Iterator<Item = &f64>| -> Vec<f64> {
            let mut sum = 0.0;
            weights
                .map(|weight| {
                    sum += weight;
                    sum
                })
                .collect()
        };
        let lower = running(&mut weights.iter());
        let mut upper = running(&mut weights.iter().rev());
        // nothing is above the last value
        upper.pop();
        upper.reverse();
        upper.push(0.0);
        Self { values, weights, lower, upper }
    }

    /// Values in order, with their probabilities.
    #[must_use]
    pub fn values(&self) -> (&Values, &[f64]) {
        (&self.values, &self.weights)
    }

    pub(super) fn words(&self) -> Option<&[String]> {
        match &self.values {
            Values::Words(words) => Some(words),
            Values::Numbers(_) => None,
        }
    }

    /// The value with this index as a number; for a word, the index.
    #[must_use]
    pub fn number(&self, place: usize) -> f64 {
        match &self.values {
            Values::Numbers(numbers) => numbers[place],
            Values::Words(_) => place as f64,
        }
    }

    /// Index of the value, from both tail probabilities; never a value without probability.
    #[must_use]
    pub fn place(&self, p: f64, q: f64) -> usize {
        let place = if p <= q {
            self.lower.partition_point(|sum| *sum < p)
        } else {
            self.upper.partition_point(|sum| *sum > q)
        };
        let mut place = place.min(self.weights.len() - 1);
        // p = 0, q = 0 or rounding may lead to a value without probability: the nearest one with a probability, downwards first
        while self.weights[place] == 0.0 && place > 0 {
            place -= 1;
        }
        while self.weights[place] == 0.0 {
            place += 1;
        }
        place
    }

    /// Index of the most probable value, the first of several.
    #[must_use]
    pub fn likeliest(&self) -> usize {
        (1..self.weights.len())
            .fold(0, |best, place| if self.weights[place] > self.weights[best] { place } else { best })
    }

    pub(super) fn moments(&self) -> Option<(f64, f64)> {
        let Values::Numbers(numbers) = &self.values else { return None };
        let expected =
            |of: &dyn Fn(f64) -> f64| numbers.iter().zip(&self.weights).map(|(x, w)| of(*x) * w).sum::<f64>();
        let mean = expected(&|x| x);
        Some((mean, libm::sqrt(expected(&|x| (x - mean) * (x - mean)))))
    }

    pub(super) fn outside(&self, range: Range) -> [f64; 2] {
        let Values::Numbers(numbers) = &self.values else { return [0.0; 2] };
        let [low, _] = range.ends();
        let mut outside = [0.0; 2];
        for (x, weight) in numbers.iter().zip(&self.weights).filter(|(x, _)| !range.contains(**x)) {
            outside[usize::from(*x > low)] += weight;
        }
        outside
    }
}
