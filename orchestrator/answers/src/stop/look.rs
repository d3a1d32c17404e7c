//! Where a study is looked at, and what each look spends.

use crate::gate::FIRST_LOOK;
use crate::gate::last_look;

/// A look at the first points of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// So many.
    pub points: u64,
    /// 1 - confidence of its intervals.
    pub alpha: f64,
    /// Whether it is at the end, where a study ends in any case.
    pub is_last: bool,
}

/// All looks at a design of so many points, in order; `alpha`: of all of them together.
#[must_use]
pub fn looks(points: u64, alpha: f64) -> Vec<Look> {
    let early = (0..).map(|k| FIRST_LOOK << k).take_while(|look| *look < points);
    let level = |points: u64| last_look(points, alpha).map(|(points, alpha)| Look { points, alpha, is_last: false });
    let mut found: Vec<Look> = early.filter_map(level).collect();
    // alpha less alpha/2, alpha/4 ... of those before
    let left = found.last().map_or(alpha, |look| look.alpha);
    found.push(Look { points, alpha: left, is_last: true });
    found
}
