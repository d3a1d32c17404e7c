//! Interim analyses of a study, and the error level of a gate at each.

use crate::gate::FIRST_LOOK;
use crate::gate::last_look;

/// An interim analysis of the first points of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterimAnalysis {
    /// Number of points.
    pub points: u64,
    /// Error level of a gate at this analysis. Intervals do not use it.
    pub alpha: f64,
    /// Whether the study ends at this analysis in any case.
    pub is_last: bool,
}

/// All interim analyses of a design with `points` points, in order; `alpha`: error level of a gate over all analyses together.
#[must_use]
pub fn interim_analyses(points: u64, alpha: f64) -> Vec<InterimAnalysis> {
    let early = (0..).map(|k| FIRST_LOOK << k).take_while(|look| *look < points);
    let level =
        |points: u64| last_look(points, alpha).map(|(points, alpha)| InterimAnalysis { points, alpha, is_last: false });
    let mut found: Vec<InterimAnalysis> = early.filter_map(level).collect();
    // alpha minus alpha/2, alpha/4 ... of the previous ones
    let left = found.last().map_or(alpha, |look| look.alpha);
    found.push(InterimAnalysis { points, alpha: left, is_last: true });
    found
}
