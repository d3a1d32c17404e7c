//! End of a run: time, number of steps and cause.

use super::row::Row;
use bladeoff_model::outcome::{Cause, EndCause};

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct End {
    pub cause: EndCause,
    /// Simulated time at the end \[s\].
    pub time: f64,
    /// Mean spin at the end \[rad/s\].
    pub speed: f64,
    /// Cause of a failure; `None` if the run did not fail.
    pub failure: Option<Cause>,
    /// Number of completed time steps.
    pub steps: u64,
    /// Number of iterations of the nonlinear solver.
    pub iterations: u64,
}

impl End {
    /// Returns whether the run ended between two completed steps: regularly, or at the step limit. All of its values then come from solved
    /// steps.
    pub fn is_between_steps(&self) -> bool {
        matches!(self.failure, None | Some(Cause::StepLimit))
    }

    pub(super) fn report(of: Option<&Self>, row: &mut Row<'_>) {
        row.growing("end_time_s", "s", "simulated time at which the run ended", of.map(|end| end.time));
        row.real(
            "end_speed_rad_s",
            "rad/s",
            "inertia-weighted mean spin at the end, of second order; 0 where the rotor stopped",
            of.map(|end| end.speed),
        );
    }

    pub(super) fn report_stop(of: Option<&Self>, row: &mut Row<'_>) {
        let stopped = of.filter(|end| end.cause == EndCause::Stopped);
        let time = stopped.map(|end| end.time);
        row.once("stop_time_s", "time at which the rotor came to rest; null unless it stopped", time, None);
    }
}

/// Time steps of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    /// Length of a step \[s\].
    pub length: f64,
}

impl Steps {
    /// Name of the column of completed steps.
    pub const DONE: &str = "steps";

    pub fn report(self, end: Option<&End>, row: &mut Row<'_>) {
        row.count(Self::DONE, "time steps", end.map(|end| end.steps));
        row.real("step_s", "s", "time step", self.length);
        let iterations = end.map(|end| end.iterations);
        row.count("iterations", "iterations of the non-linear solve, all steps together; with the engine exponential, which has none, the steps", iterations);
    }
}
