//! Which intervals a design allows.
//!
//! Points of a Monte Carlo design are independent: limits are exact. Points of other designs depend on one another, and only
//! replicates, each scrambled on its own, tell how far a figure varies: Student's t, approximate. Everything else has no interval:
//! a number there would be made up.

use super::input::{Design, DesignKind};
use bladeoff_numerics::probability::student;

/// Fewest replicates for an interval.
pub const FEWEST_REPLICATES: usize = 16;

/// Fewer events (or points without) than this in all replicates together say nothing by their scatter: the limits of as many
/// independent points are taken, approximate. Scrambled designs do not scatter more than those.
pub const FEW: u64 = 32;

/// What an interval may rest on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scheme {
    /// Independent points.
    Independent,
    /// So many independent replicates.
    Replicated(usize),
    /// Nothing, and why.
    Without(String),
}

impl Scheme {
    /// What the points that are there allow.
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

    /// The same by how many points of each replicate there are.
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

    /// Student's t of its replicates, two-sided; 0 where it has none.
    #[must_use]
    pub fn t(&self, alpha: f64) -> f64 {
        if let Self::Replicated(count) = self { student(*count as f64 - 1.0, alpha) } else { 0.0 }
    }

    /// Parts that are counted apart: replicates, or one of all points.
    #[must_use]
    pub fn parts(&self) -> usize {
        if let Self::Replicated(count) = self { *count } else { 1 }
    }

    /// The part of a point.
    #[must_use]
    pub fn part(&self, design: &Design<'_>, point: usize) -> usize {
        if let Self::Replicated(_) = self { design.replicate[point] as usize } else { 0 }
    }
}
