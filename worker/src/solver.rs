//! What computes samples, and how a batch is brought through it whatever happens.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use crate::batch_recorder::{BatchRecorder, Sample, Stopped};

/// Computes samples, a batch at a time.
pub trait Solver {
    /// Computes samples: any number from one on, in whatever way and order, alone or several at once. What it keeps between
    /// them is its own matter, but the outcome of each depends on nothing but its parameters and the plan: not on the others,
    /// their order, or what was computed before.
    ///
    /// Every sample is begun at the desk before it is computed and finished there once, as soon as it can be: what is finished
    /// leaves within moments, what is held back is lost with the process. In between it is in work for heartbeats and
    /// time limits, so no more should be begun than are computed together. Where the desk says that no more is taken, this returns.
    ///
    /// A panic is the failure of the sample that was under way; of several, or when none was and it is not known whose it is, each is tried
    /// alone, and one that panics alone fails. A sample that is left out is tried alone, too, and fails if it is left out again.
    /// The others are given anew, without those that are finished. All of this stands in the log.
    ///
    /// # Errors
    /// What [`BatchRecorder::finish`] said.
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped>;

    /// Called after a panic in [`Solver::solve_batch`], or a sample that it left out: forget whatever may be half done.
    fn recover(&mut self) {}
}

/// Gives the samples of a desk to the solver until each has its outcome, or no more is taken.
pub(crate) fn solve_all<S: Solver>(solver: &mut S, recorder: &mut BatchRecorder<'_>) {
    let mut calls = VecDeque::from([(0..recorder.len()).collect::<Vec<_>>()]);
    // Ends: of every call that leaves something over, a sample is given up, or the next calls have a single one.
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
        // The panic's own message is in the log already.
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
