//! Limits of the difference a - b of two correlated estimates, from the limits of each.
//!
//! ```text
//! a = a^ + x, b = b^ + y;  x from -l_a to u_a, y from -l_b to u_b: the distances of both limits from the estimate
//! region      (x/s)^2 - 2 r (x/s)(y/t) + (y/t)^2 <= 1 - r^2,  s = l_a for x < 0, u_a for x > 0; t of b likewise
//! limits      the smallest and the largest a - b of the region
//! ```
//! r is the correlation of the estimates. Where x < 0 < y gives the smallest difference, its distance is sqrt(l_a^2 - 2 r l_a u_b + u_b^2):
//! G. Y. Zou, A. Donner, "Construction of confidence limits about effect measures", Stat. Med. 27 (2008). For a large r both estimates are
//! off to the same side, and the arms of that side count: a constant shift of one distribution has limits of no width.
//! Verified by `tests/uncertainty/paired.rs`: closed forms, and how often the limits hold.

/// Distances of an estimate from its limits; infinite without a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arms {
    /// From the lower limit.
    pub below: f64,
    /// From the upper limit.
    pub above: f64,
}

/// The distances of a - b from its limits.
#[must_use]
pub fn reach(a: Arms, b: Arms, r: f64) -> Arms {
    Arms { below: farthest(a, b, r), above: farthest(b, a, r) }
}

/// The most that y - x comes to, x of `a` and y of `b`.
fn farthest(a: Arms, b: Arms, r: f64) -> f64 {
    if a.below.is_infinite() || b.above.is_infinite() {
        return f64::INFINITY;
    }
    let edge = (1.0 - r * r).max(0.0).sqrt();
    let mut most = edge * a.below.max(b.above);
    // what x and y add to the difference by their full arms, and the correlation of these two
    for (x, y, r) in [(a.below, b.above, -r), (-a.above, b.above, r), (a.below, -b.below, r)] {
        let size = (x * x + 2.0 * r * x * y + y * y).max(0.0).sqrt();
        if x + r * y >= 0.0 && y + r * x >= 0.0 && size.is_finite() {
            most = most.max(size);
        }
    }
    most
}

/// Cluster (a point, a replicate) of a ratio of sums: its number, its part of the numerator and of the denominator.
pub type Cluster = (u64, f64, f64);

/// Correlation of two ratios of sums over clusters, of which those with the same number depend on one another: that of the residuals
/// e = y - (sum y/sum w) w. `None`: one of both does not vary. Both lists in the order of the numbers.
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

/// Points that are taken to differ beside those that do: that none was seen to differ is no correlation of 1.
pub const UNSEEN: f64 = 1.0;

/// The correlation r of two counts less what may be hidden: points that were not seen to differ, and open ones, of which `open` is the
/// number. `a` and `b`: how many of how many were counted.
#[must_use]
pub fn lessened(r: f64, a: (f64, f64), b: (f64, f64), open: f64) -> f64 {
    let variance = |(counted, of): (f64, f64)| counted * (of - counted) / of;
    // each such point takes half of itself from the sum of products
    (r - 0.5 * (UNSEEN + open) / (variance(a) * variance(b)).sqrt()).max(-1.0)
}
