//! Interim analyses of a gate, and the number of points at which it would be decided.
//!
//! ```text
//! analysis k = 0, 1, ...   of the first 256 2^k points, at level alpha/2^(k+1):  the levels of all analyses sum to less than alpha
//! ```
//! Judging more often evaluates the same analyses again, so it does not increase the error (J. L. Doob's union of the analyses; the
//! levels spend alpha geometrically).

use crate::estimate::limits::{lower_limit, upper_limit};

/// Number of points of the first interim analysis.
pub const FIRST_LOOK: u64 = 256;

/// Largest number of points that a gate asks for.
pub const MOST_POINTS: u64 = 100_000_000;

/// The last interim analysis within `points` points: its number of points and its level; `None` before the first.
#[must_use]
pub fn last_look(points: u64, alpha: f64) -> Option<(u64, f64)> {
    let looks = (points / FIRST_LOOK).checked_ilog2()?;
    Some((FIRST_LOOK << looks, alpha / libm::exp2(f64::from(looks) + 1.0)))
}

/// Number of points at which a gate would be decided at the present rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deciding {
    /// At this number of points.
    At(u64),
    /// With more than [`MOST_POINTS`].
    Beyond,
    /// At no number of points.
    Never,
}

/// Additional points with which a gate would be decided.
///
/// * `low`, `high` - share of events with bad runs harmless and harmful; `points` - present number; `half_way` - decision at an interim analysis.
#[must_use]
pub fn deciding((low, high): (f64, f64), bound: f64, points: u64, alpha: f64, half_way: bool) -> Deciding {
    let events = |share: f64, n: u64| libm::rint(share * n as f64) as u64;
    let decided = |n: u64, level: f64| {
        (high < bound && upper_limit(events(high, n), n, level) < bound)
            || (low > bound && lower_limit(events(low, n), n, level) >= bound)
    };
    if high >= bound && low <= bound {
        return Deciding::Never;
    }
    if half_way {
        let looks = (0..).map(|k| FIRST_LOOK << k).take_while(|look| *look <= MOST_POINTS);
        let mut next = looks.filter(|look| *look > points);
        let found = next.find(|look| last_look(*look, alpha).is_some_and(|(n, level)| decided(n, level)));
        return found.map_or(Deciding::Beyond, Deciding::At);
    }
    if points >= MOST_POINTS || !decided(MOST_POINTS, alpha) {
        return Deciding::Beyond;
    }
    let (mut below, mut top) = (points, points + 1);
    while top < MOST_POINTS && !decided(top, alpha) {
        (below, top) = (top, (2 * top - points).min(MOST_POINTS));
    }
    while top - below > 1 {
        let middle = below + (top - below) / 2;
        if decided(middle, alpha) { top = middle } else { below = middle }
    }
    Deciding::At(top)
}
