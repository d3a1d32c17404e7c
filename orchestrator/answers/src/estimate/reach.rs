//! Limits of the difference a - b of two correlated estimates, from the limits of each.
//!
//! ```text
//! a = a^ + x, b = b^ + y;  x from -l_a to u_a, y from -l_b to u_b: the distances of both limits from the estimate
//! region      (x/s)^2 - 2 r (x/s)(y/t) + (y/t)^2 <= 1 - r^2,  s = l_a for x < 0, u_a for x > 0; t of b likewise
//! limits      the smallest and the largest a - b of the region
//! ```
//! r is the correlation of the estimates. If x < 0 < y gives the smallest difference, its distance is sqrt(l_a^2 - 2 r l_a u_b + u_b^2):
//! G. Y. Zou, A. Donner, "Construction of confidence limits about effect measures", Stat. Med. 27 (2008). For large r both estimates have
//! errors of the same sign, and the arms of that side count: the limits of a constant shift have zero width.
//! Verified by `tests/uncertainty/paired.rs`: closed forms and coverage.

/// Distances of an estimate from its limits; infinite without a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arms {
    /// Distance from the lower limit.
    pub below: f64,
    /// Distance from the upper limit.
    pub above: f64,
}

/// Distances of a - b from its limits.
#[must_use]
pub fn reach(a: Arms, b: Arms, r: f64) -> Arms {
    Arms { below: farthest(a, b, r), above: farthest(b, a, r) }
}

/// Largest value of y - x over the region, x of `a` and y of `b`.
fn farthest(a: Arms, b: Arms, r: f64) -> f64 {
    if a.below.is_infinite() || b.above.is_infinite() {
        return f64::INFINITY;
    }
    let edge = (1.0 - r * r).max(0.0).sqrt();
    let mut most = edge * a.below.max(b.above);
    // full arms of x and y towards a larger difference, and their correlation
    for (x, y, r) in [(a.below, b.above, -r), (-a.above, b.above, r), (a.below, -b.below, r)] {
        let size = (x * x + 2.0 * r * x * y + y * y).max(0.0).sqrt();
        if x + r * y >= 0.0 && y + r * x >= 0.0 && size.is_finite() {
            most = most.max(size);
        }
    }
    most
}

/// Cluster (point or replicate) of a ratio of sums: number, contribution to the numerator, contribution to the denominator.
pub type Cluster = (u64, f64, f64);

/// Correlation of two ratios of sums over clusters, where clusters with the same number are dependent: correlation of the residuals
/// e = y - (sum y/sum w) w. `None` if one of the ratios does not vary. Both lists must be in the order of the numbers.
#[must_use]
pub fn correlation(a: &[Cluster], b: &[Cluster]) -> Option<f64> {
    let ratio = |of: &[Cluster]| of.iter().map(|one| one.1).sum::<f64>() / of.iter().map(|one| one.2).sum::<f64>();
    let (q_a, q_b) = (ratio(a), ratio(b));
    let (off_a, off_b) = (|one: &Cluster| one.1 - q_a * one.2, |one: &Cluster| one.1 - q_b * one.2);
    let squares_a: f64 = a.iter().map(|one| off_a(one) * off_a(one)).sum();
    let squares_b: f64 = b.iter().map(|one| off_b(one) * off_b(one)).sum();
    let (mut products, mut at) = (0.0, 0);
    for one in a {
        while b.get(at).is_some_and(|other| other.0 < one.0) {
            at += 1;
        }
        if let Some(other) = b.get(at).filter(|other| other.0 == one.0) {
            products += off_a(one) * off_b(other);
        }
    }
    let r = products / (squares_a * squares_b).sqrt();
    r.is_finite().then(|| r.clamp(-1.0, 1.0))
}

/// Number of points assumed to differ in addition to those observed: no observed difference does not imply a correlation of 1.
pub const UNSEEN: f64 = 1.0;

/// The correlation r of two counts, reduced by possible hidden differences: unobserved ones and `open` points that are open. `a` and `b`: events
/// and points of each count.
#[must_use]
pub fn lessened(r: f64, a: (f64, f64), b: (f64, f64), open: f64) -> f64 {
    let variance = |(counted, of): (f64, f64)| counted * (of - counted) / of;
    // each such point reduces the sum of products by one half
    (r - 0.5 * (UNSEEN + open) / (variance(a) * variance(b)).sqrt()).max(-1.0)
}
