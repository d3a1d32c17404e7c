//! Intervals that a design allows.
//!
//! Points of a Monte Carlo design are independent: the limits are exact. Points of other designs are dependent. Only independently
//! scrambled replicates show the scatter of a figure: the limits follow Student's t and are approximate. All other designs have no
//! interval, because no valid one exists.

use super::input::{Design, DesignKind};
use bladeoff_numerics::probability::student;

/// Smallest number of replicates for an interval.
pub const FEWEST_REPLICATES: usize = 16;

/// Smallest number of events, and of points without, in all replicates for Student's t. With fewer, the limits of equally many
/// independent points are used, approximate: scrambled designs do not scatter more than independent points.
pub const FEW: u64 = 32;

/// Basis of an interval.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scheme {
    /// Independent points.
    Independent,
    /// This number of independent replicates.
    Replicated(usize),
    /// No interval, and the reason.
    Without(String),
}

impl Scheme {
    /// Scheme of the points computed so far.
    #[must_use]
    pub fn of(design: &Design<'_>) -> Self {
        Self::counted(design, || {
            let mut counts = vec![0u64; design.replicates];
            for &replicate in design.replicate {
                counts[replicate as usize] += 1;
            }
            counts
        })
    }

    /// [`Scheme::of`] with the number of points of each replicate.
    #[must_use]
    pub fn counted(design: &Design<'_>, counts: impl FnOnce() -> Vec<u64>) -> Self {
        let kind = design.kind.word();
        let without = |why: String| Self::Without(why);
        match design.kind {
            DesignKind::MonteCarlo => return Self::Independent,
            DesignKind::OneAtATime | DesignKind::Morris | DesignKind::Chosen => {
                return without(format!(
                    "{kind} points are not a random sample: the figure describes these runs, and has no interval"
                ));
            }
            DesignKind::Saltelli => {
                return without(format!("no interval: {kind} points of a block depend on one another"));
            }
            DesignKind::Sobol | DesignKind::Halton if !design.scrambled => {
                return without(format!("no interval: {kind} points without scrambling are not random"));
            }
            _ => {}
        }
        if design.replicates < FEWEST_REPLICATES {
            let told = match design.replicates {
                1 => "1 replicate shows".to_owned(),
                count => format!("{count} replicates show"),
            };
            return without(format!("no interval: {told} too little of the scatter, {FEWEST_REPLICATES} are enough"));
        }
        let counts = counts();
        if counts.contains(&0) {
            return without("no interval: some replicates have no point yet".to_owned());
        }
        let whole = counts.iter().all(|count| count.is_power_of_two() && *count == counts[0]);
        if design.kind == DesignKind::LatinHypercube && !whole {
            return without("no interval: an incomplete hypercube does not fill its slices".to_owned());
        }
        Self::Replicated(design.replicates)
    }

    /// Two-sided quantile of Student's t over the replicates; 0 without replicates.
    #[must_use]
    pub fn t(&self, alpha: f64) -> f64 {
        if let Self::Replicated(count) = self { student(*count as f64 - 1.0, alpha) } else { 0.0 }
    }

    /// Number of parts that are counted separately: the replicates, or 1.
    #[must_use]
    pub fn parts(&self) -> usize {
        if let Self::Replicated(count) = self { *count } else { 1 }
    }

    /// Part of a point.
    #[must_use]
    pub fn part(&self, design: &Design<'_>, point: usize) -> usize {
        if let Self::Replicated(_) = self { design.replicate[point] as usize } else { 0 }
    }
}
