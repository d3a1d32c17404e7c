//! Integrals over a standard normal number z by Gauss-Legendre quadrature, on panels that end where the slope of the integrand jumps.
//!
//! ```text
//! E[f(z)] = integral of f(z) phi(z), z = -37 .. 37: beyond, phi is below 1e-297
//! ```
//! The panels are so narrow that functions which oscillate by 64 radians per unit are integrated to rounding.

/// Panels reach from -REACH to REACH, where the tails of the normal distribution still have full precision.
const REACH: f64 = 37.0;
/// Width of a panel.
const PANEL: f64 = 0.125;
/// Largest share of the variance in the end panels; a larger share means that the tails extend further.
pub(crate) const AT_ENDS: f64 = 1e-25;

/// Quadrature nodes and weights, without phi.
pub(crate) struct Rule {
    /// Nodes and weights.
    pub nodes: Vec<(f64, f64)>,
}

impl Rule {
    /// Panels divided at these positions, ascending.
    pub fn new(cuts: &[f64]) -> Self {
        let orders = [12, 8, 6, 2].map(|order| (order, legendre(order)));
        let mut edges: Vec<f64> = (0..=(2.0 * REACH / PANEL) as u32).map(|k| f64::from(k) * PANEL - REACH).collect();
        edges.extend(cuts.iter().filter(|cut| cut.abs() < REACH));
        edges.sort_by(f64::total_cmp);
        let mut nodes = Vec::new();
        for pair in edges.windows(2) {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            if half <= 0.0 {
                continue;
            }
            // as many nodes as psi_k of the largest k needs in a panel this short
            let order = if half > 0.03 {
                0
            } else if half > 0.0075 {
                1
            } else if half > 5e-5 {
                2
            } else {
                3
            };
            nodes.extend(orders[order].1.iter().map(|(x, weight)| (middle + half * x, half * weight)));
        }
        Self { nodes }
    }
}

/// Square root of the density phi(z).
pub(crate) fn root_density(z: f64) -> f64 {
    const FACTOR: f64 = 0.631_618_777_746_065_2;
    FACTOR * libm::exp(-0.25 * z * z)
}

/// Mean and standard deviation of a smooth function of z; infinite if the tails extend beyond the panels.
pub(super) fn moments(of: impl Fn(f64) -> f64) -> (f64, f64) {
    let part = |(z, weight): (f64, f64)| (weight * root_density(z) * root_density(z), of(z));
    let values: Vec<(f64, f64)> = Rule::new(&[]).nodes.into_iter().map(part).collect();
    let mean: f64 = values.iter().map(|(part, x)| part * x).sum();
    let squares: Vec<f64> = values.iter().map(|(part, x)| part * (x - mean) * (x - mean)).collect();
    let variance: f64 = squares.iter().sum();
    let ends = squares[0] + squares[squares.len() - 1];
    // comparisons with NaN are false
    if ends < AT_ENDS * variance { (mean, libm::sqrt(variance)) } else { (f64::INFINITY, f64::INFINITY) }
}

/// Nodes and weights of Gauss-Legendre quadrature on -1 .. 1, by Newton's method on the recurrence.
fn legendre(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    let node = |i: usize| {
        let mut x = libm::cos(core::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
        let mut slope = 0.0;
        for _ in 0..10 {
            let (mut previous, mut present) = (1.0, x);
            for k in 2..=order {
                let k = k as f64;
                (previous, present) = (present, ((2.0 * k - 1.0) * x * present - (k - 1.0) * previous) / k);
            }
            slope = n * (x * present - previous) / (x * x - 1.0);
            x -= present / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..order).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_integrate_polynomials_of_their_degree() {
        for order in [2, 6, 8, 12] {
            let rule = legendre(order);
            for degree in (0..2 * order).step_by(2) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 2.0 / (degree + 1) as f64).abs() < 1e-14, "{order} {degree} {sum}");
            }
        }
    }
}
