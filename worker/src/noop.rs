//! Solver that computes nothing, for measurements and tests of the dispatch.

use std::time::{Duration, Instant};

use bladeoff_model::outcome::{CauseSet, EndCause, Outcome, Status};

use crate::batch_recorder::{BatchRecorder, Sample, Stopped};
use crate::solver::Solver;

/// Number of values of an outcome, about that of a machine with two bearings.
pub const NOOP_VALUES: usize = 40;

/// Solver whose values follow from the sample's number and parameters, after a given time.
#[derive(Debug, Clone, Copy)]
pub struct NoopSolver {
    /// CPU time of each sample.
    pub busy: Duration,
}

/// Computes the outcome of a sample, the same in every process.
#[must_use]
pub fn noop_outcome(sample: u64, params: &[f64]) -> Outcome {
    let seed = params.iter().fold(sample as f64, |sum, value| sum + value);
    let values = (0..NOOP_VALUES).map(|i| (i % 7 != 3).then_some(seed + i as f64)).collect();
    let (status, causes) = (Status::Ok, CauseSet::default());
    Outcome { status, cause: None, causes, notes: CauseSet::default(), end_cause: EndCause::Stopped, values }
}

impl Solver for NoopSolver {
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped> {
        for index in 0..samples.len() {
            let begun = recorder.begin(index);
            if !self.busy.is_zero() {
                let start = Instant::now();
                while start.elapsed() < self.busy {
                    std::hint::spin_loop();
                }
            }
            let outcome = noop_outcome(begun.sample.number, begun.sample.params);
            recorder.finish(begun, outcome)?;
        }
        Ok(())
    }
}
