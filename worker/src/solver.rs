//! Solvers, and the treatment of panics and omitted samples in a batch.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use crate::batch_recorder::{BatchRecorder, Sample, Stopped};

/// Solver of samples, a batch at a time.
pub trait Solver {
    /// Computes at least one sample, in any way and order, singly or together. Each outcome depends only on the sample's
    /// parameters and the plan: not on other samples, their order or earlier calls.
    ///
    /// Each sample is begun at the recorder before it is computed and finished there once, as early as possible: finished samples
    /// are sent within moments, others are lost with the process. Between both it is in progress for heartbeats and time limits,
    /// so only samples that are computed together should be in progress together. The solver returns when the recorder accepts no
    /// more outcomes.
    ///
    /// A panic is a failure of the sample in progress. If several samples or none were in progress, each is computed alone, and
    /// one that panics alone fails. An omitted sample is computed alone as well and fails if it is omitted again. The other
    /// samples are passed again, without the finished ones. All of this is logged.
    ///
    /// # Errors
    /// The result of [`BatchRecorder::finish`].
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped>;

    /// Discards unfinished state, after a panic in [`Solver::solve_batch`] or an omitted sample.
    fn recover(&mut self) {}
}

/// Passes the samples of a recorder to the solver until each has an outcome, or no more are accepted.
pub(crate) fn solve_all<S: Solver>(solver: &mut S, recorder: &mut BatchRecorder<'_>) {
    let mut calls = VecDeque::from([(0..recorder.len()).collect::<Vec<_>>()]);
    // The loop ends: each incomplete call gives up a sample, or the next calls have a single one.
    while !recorder.has_stopped()
        && let Some(call) = calls.pop_front()
    {
        let samples = recorder.open(&call);
        let solved = catch_unwind(AssertUnwindSafe(|| solver.solve_batch(&samples, recorder)));
        let panic = match solved {
            Err(panic) if recorder.is_handing_in() => resume_unwind(panic),
            solved => solved.is_err(),
        };
        if recorder.has_stopped() {
            break;
        }
        let (under_way, left) = recorder.unfinished();
        if !panic && left.is_empty() {
            continue;
        }
        solver.recover();
        // The message of the panic is in the log already.
        let is_known = call.len() == 1 || (panic && under_way.len() == 1);
        let suspects = if under_way.is_empty() || !panic { left.clone() } else { under_way };
        match suspects[..] {
            [] => eprintln!("the solver panicked when all its samples were finished"),
            [guilty] if is_known => {
                let did = if panic { "panicked" } else { "left it out" };
                eprintln!("sample {}: the solver {did}", recorder.number(guilty));
                recorder.give_up(guilty);
            }
            [first, ..] => {
                let did = if panic { "panicked in one of" } else { "left out" };
                let (n, first) = (suspects.len(), recorder.number(first));
                eprintln!("the solver {did} {n} samples, the first is {first}: each is tried alone");
            }
        }
        let rest: Vec<usize> = left.into_iter().filter(|at| !suspects.contains(at)).collect();
        if !rest.is_empty() {
            calls.push_front(rest);
        }
        if !is_known {
            suspects.into_iter().rev().for_each(|at| calls.push_front(vec![at]));
        }
    }
}
