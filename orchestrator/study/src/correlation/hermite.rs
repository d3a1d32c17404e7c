//! Expansion of a parameter in Hermite polynomials of a standard normal number; correlation of two parameters as a power series.
//!
//! ```text
//! (x(z) - mean)/sd = sum over k >= 1 of a_k He_k(z)/sqrt(k!),   a_k = integral of (x(z) - mean)/sd psi_k(z) sqrt(phi(z)) dz     (1)
//! psi_0 = sqrt(phi),  psi_(k+1) = (z psi_k - sqrt(k) psi_(k-1))/sqrt(k + 1)
//! Corr(x1(z1), x2(z2)) = sum of a_k b_k r^k,   r = Corr(z1, z2)                                                               (2)
//! |remainder of (2) after K terms| <= |r|^(K+1) sqrt(1 - sum of a_k^2) sqrt(1 - sum of b_k^2)                                  (3)
//! ```
//! (3) follows from Parseval's sum and the Cauchy-Schwarz inequality, so it is a rigorous bound.
//! Sources: F. G. Mehler (1866) for (2); H. O. Lancaster, "Some properties of the bivariate normal distribution" (1957).
//! The integrals are Gauss-Legendre sums over panels that end where the slope of x(z) jumps.
//!
//! # Limits
//! Distributions whose (x - mean)^2 phi(z) has not decayed at |z| = 37 are rejected (lognormal with sigma above 12). With jumps of the slope
//! (empirical distributions), (3) decreases slowly: r close to 1 or -1 may then be out of reach, which is reported as an error.
//! # Verified by
//! `tests/correlation.rs`

use crate::uncertain::Uncertain;
use crate::uncertain::panels::{AT_ENDS, Rule, root_density};
use bladeoff_numerics::probability::{normal_quantile, normal_tails};

/// Most coefficients.
const MOST: usize = 4000;
/// Most nodes times coefficients.
const WORK: usize = 200_000_000;
/// Share of the variance that may remain after the last coefficient.
const SPENT: f64 = 1e-15;
/// Largest error of mean and standard deviation, relative to the latter; a distribution that is too steep for the panels is rejected.
const OFF: f64 = 1e-10;

/// Expansion (1) of one parameter.
#[derive(Debug, Clone)]
pub(super) struct Expansion {
    /// a_1, a_2, ...
    coefficients: Vec<f64>,
    mean: f64,
    sd: f64,
    cuts: Vec<f64>,
    /// Nodes, weights including phi, values.
    values: Vec<(f64, f64, f64)>,
}

fn at(law: &Uncertain, z: f64) -> f64 {
    let (p, q) = normal_tails(z);
    law.quantile(p, q)
}

/// Values of z at which the slope of x(z) jumps.
fn cuts(law: &Uncertain) -> Vec<f64> {
    law.kinks().into_iter().map(|p| normal_quantile(p, 1.0 - p)).collect()
}

impl Expansion {
    /// Expansion of a parameter with a positive standard deviation; `None`: its tails are too heavy, or it is almost a step.
    pub fn new(law: &Uncertain) -> Option<Self> {
        let cuts = cuts(law);
        let values: Vec<(f64, f64, f64)> = Rule::new(&cuts)
            .nodes
            .into_iter()
            .map(|(z, weight)| (z, weight * root_density(z) * root_density(z), at(law, z)))
            .collect();
        let mean: f64 = values.iter().map(|(_, part, x)| part * x).sum();
        let variance: f64 = values.iter().map(|(_, part, x)| part * (x - mean) * (x - mean)).sum();
        let sd = libm::sqrt(variance);
        let share = |&(_, part, x): &(f64, f64, f64)| part * (x - mean) * (x - mean) / variance;
        let ends = [values.first(), values.last()].into_iter().flatten().map(share).sum::<f64>();
        let (known_mean, known_sd) = law.moments()?;
        let off = ((mean - known_mean) / sd).abs().max((known_sd / sd - 1.0).abs());
        // comparisons with NaN are false
        let sound = variance > 0.0 && variance.is_finite() && ends < AT_ENDS && off < OFF;
        if !sound {
            return None;
        }
        let mut nodes: Vec<Node> =
            values.iter().filter(|value| share(value) > 1e-34).map(|value| Node::new(value, mean, sd)).collect();
        let most = MOST.min(WORK / nodes.len()).max(50);
        let mut coefficients = Vec::new();
        let mut left = 1.0;
        for k in 0..=most {
            let coefficient: f64 = nodes.iter().map(|node| node.value * node.present).sum();
            if k > 0 {
                coefficients.push(coefficient);
                left -= coefficient * coefficient;
                if left < SPENT && k >= 64 {
                    break;
                }
            }
            let (down, up) = (libm::sqrt(k as f64), libm::sqrt((k + 1) as f64));
            nodes.iter_mut().for_each(|node| node.advance(down, up));
        }
        Some(Self { coefficients, mean, sd, cuts, values })
    }
}

/// A node with the terms that are summed there.
struct Node {
    z: f64,
    /// Weight sqrt(phi) (x - mean)/sd.
    value: f64,
    /// psi_k and psi_(k-1).
    present: f64,
    previous: f64,
}

impl Node {
    fn new(&(z, part, x): &(f64, f64, f64), mean: f64, sd: f64) -> Self {
        let root = root_density(z);
        Self { z, value: part / root * (x - mean) / sd, present: root, previous: 0.0 }
    }

    fn advance(&mut self, down: f64, up: f64) {
        let next = (self.z * self.present - down * self.previous) / up;
        self.previous = self.present;
        self.present = next;
    }
}

/// Series (2) of two parameters.
#[derive(Debug, Clone)]
pub(super) struct Series {
    /// a_k b_k, from k = 1.
    products: Vec<f64>,
    /// Product of the square roots in (3).
    lacking: f64,
    /// The correlation at r = -1 and 1, by an integral over one variable.
    ends: [f64; 2],
}

impl Series {
    pub fn new((law_a, a): (&Uncertain, &Expansion), (law_b, b): (&Uncertain, &Expansion)) -> Self {
        let terms = a.coefficients.len().min(b.coefficients.len());
        let products = a.coefficients.iter().zip(&b.coefficients).map(|(a, b)| a * b).collect();
        let rest = |expansion: &Expansion| {
            let used: f64 = expansion.coefficients[..terms].iter().map(|a| a * a).sum();
            // rounding leaves about this much of the sum
            libm::sqrt((1.0 - used).max(SPENT))
        };
        let product = |x: f64, y: f64| (x - a.mean) / a.sd * ((y - b.mean) / b.sd);
        let end = |sign: f64| -> f64 {
            if a.cuts.is_empty() && b.cuts.is_empty() {
                // the same symmetric panels: values can be reused
                let (forward, backward) = (b.values.iter(), b.values.iter().rev());
                let sum = |(first, second): (&(f64, f64, f64), &(f64, f64, f64))| first.1 * product(first.2, second.2);
                return if sign > 0.0 {
                    a.values.iter().zip(forward).map(sum).sum()
                } else {
                    a.values.iter().zip(backward).map(sum).sum()
                };
            }
            let mut all = a.cuts.clone();
            all.extend(b.cuts.iter().map(|cut| sign * cut));
            all.sort_by(f64::total_cmp);
            let part = |&(z, weight): &(f64, f64)| {
                weight * root_density(z) * root_density(z) * product(at(law_a, z), at(law_b, sign * z))
            };
            Rule::new(&all).nodes.iter().map(part).sum()
        };
        Self { products, lacking: rest(a) * rest(b), ends: [end(-1.0), end(1.0)] }
    }

    /// Sum (2), and the bound (3) on its error.
    pub fn at(&self, r: f64) -> (f64, f64) {
        let sum = self.products.iter().rev().fold(0.0, |sum, product| (sum + product) * r);
        let power = libm::pow(r.abs(), (self.products.len() + 1) as f64);
        (sum, power * self.lacking + 1e-13)
    }

    /// Smallest and largest possible correlation.
    pub fn ends(&self) -> [f64; 2] {
        self.ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_law_is_its_first_coefficient() {
        use crate::uncertain::{Distribution, Written};
        let numbers = vec![("mean".to_owned(), 3.0), ("sd".to_owned(), 0.5)];
        let law = Uncertain::new(Distribution::Normal, &Written { numbers, ..Written::default() }, "").expect("a law");
        let expansion = Expansion::new(&law).expect("light tails");
        assert!((expansion.coefficients[0] - 1.0).abs() < 1e-14);
        assert!(expansion.coefficients[1..].iter().all(|a| a.abs() < 1e-13), "{:?}", expansion.coefficients);
    }
}
