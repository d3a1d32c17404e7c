//! Interim analyses of a study, and the error that a gate spends at each.

use crate::gate::FIRST_LOOK;
use crate::gate::last_look;

/// An interim analysis of the first points of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterimAnalysis {
    /// Number of points.
    pub points: u64,
    /// Error that a gate spends here. Intervals do not use it.
    pub alpha: f64,
    /// Whether the study ends here in any case.
    pub is_last: bool,
}

/// All interim analyses of a design of so many points, in order; `alpha`: error of a gate over all of them together.
#[must_use]
pub fn interim_analyses(points: u64, alpha: f64) -> Vec<InterimAnalysis> {
    let early = (0..).map(|k| FIRST_LOOK << k).take_while(|look| *look < points);
    let level =
        |points: u64| last_look(points, alpha).map(|(points, alpha)| InterimAnalysis { points, alpha, is_last: false });
    let mut found: Vec<InterimAnalysis> = early.filter_map(level).collect();
    // alpha less alpha/2, alpha/4 ... of those before
    let left = found.last().map_or(alpha, |look| look.alpha);
    found.push(InterimAnalysis { points, alpha: left, is_last: true });
    found
}
