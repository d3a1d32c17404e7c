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
