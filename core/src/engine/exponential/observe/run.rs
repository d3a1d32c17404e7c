//! One run of the exponential engine from its start to its end.
//!
//! Each step is observed at n, chosen in size, done, and recorded. The motion ([`Transient`]) does not depend on what is observed of it ([`Observer`]).
//! Verified by `tests/exponential/exponential_run.rs`.

use super::observer::Observer;
use crate::engine::exponential::error::ExponentialError;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::exponential::stepping::release::Release;
use crate::engine::exponential::stepping::transient::Transient;
use crate::engine::release::Releases;
use crate::record::{At, End, Follower, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause};

/// Computes one run in contact steps of `settings.step` and free steps of `2^k` contact steps.
///
/// # Errors
/// [`ExponentialError`] of a machine that this engine does not cover, or that has no modal basis at its start.
pub(in crate::engine) fn run(
    machine: &Machine,
    structure: &Structure,
    settings: StepSettings,
    follower: &mut dyn Follower,
) -> Result<(Recorders, End), ExponentialError> {
    let releases = Releases::new(machine);
    let mut transient = match releases.is_over() {
        true => Transient::new(machine, structure, settings, true)?,
        false => Transient::new(&releases.present(), structure, settings, true)?,
    };
    transient.await_releases(&releases, machine);
    let observer = Observer::new(machine, structure, settings.step, &transient);
    let mut run = Run { machine, structure, transient, observer, releases, h: settings.step, steps: 0 };
    let (cause, failure) = loop {
        if !follower.goes_on(run.steps) || machine.run.step_limit.is_some_and(|limit| run.steps >= limit) {
            break (EndCause::Failure, Some(Cause::StepLimit));
        }
        match run.step(follower) {
            Ok(None) => {}
            Ok(Some(cause)) => break (cause, None),
            Err(cause) => break (EndCause::Failure, Some(cause)),
        }
    };
    let Run { mut transient, mut observer, steps, .. } = run;
    let time = transient.free_motion.time();
    let end = End { cause, time, speed: observer.speed, failure, steps, iterations: steps };
    let end = observer.finish(end, &mut transient, follower);
    Ok((observer.recorders, end))
}

/// A run under way.
struct Run<'a> {
    machine: &'a Machine,
    structure: &'a Structure,
    transient: Transient,
    observer: Observer<'a>,
    releases: Releases<'a>,
    /// Contact step \[s\].
    h: f64,
    /// Steps that have been done.
    steps: u64,
}

impl Run<'_> {
    /// Goes from n to n+1; `Some` when the run has ended.
    fn step(&mut self, follower: &mut dyn Follower) -> Result<Option<EndCause>, Cause> {
        let Self { transient, observer, .. } = self;
        let mut step = observer.begin(transient, follower)?;
        let doublings = transient.next_step_doublings().map(|doublings| doublings.min(step.max_doublings()));
        observer.before_step(&mut step, doublings, transient, follower);
        transient.step(doublings)?;
        observer.after_step(&mut step, doublings, transient, follower);
        self.steps += 1;
        let end = self.end_cause()?;
        if end.is_none() && !self.releases.is_over() {
            self.release()?;
        }
        Ok(end)
    }

    /// Releases what is due at n.
    fn release(&mut self) -> Result<(), Cause> {
        let Self { machine, structure, transient, observer, releases, .. } = self;
        let now = At { time: transient.free_motion.time(), speed: transient.free_motion.speed() };
        while let Some(due) = releases.due(now) {
            let before = releases.present();
            let (site, late) = (releases.happen(&due), now.time - due.at.time);
            let release = Release { before: &before, after: &releases.present(), site: &site, late };
            let energy = transient.release(&release, structure)?;
            transient.await_releases(releases, machine);
            observer.released(due, energy, transient);
        }
        releases.pass(At { speed: transient.free_motion.speed(), ..now });
        Ok(())
    }

    /// End cause of a run that ends at n+1.
    fn end_cause(&mut self) -> Result<Option<EndCause>, Cause> {
        let Self { machine, transient, observer, .. } = self;
        let speed = transient.free_motion.speed();
        let places = transient.contacts.iter().flat_map(|contact| contact.displacement);
        if !places.fold(speed, |sum, part| sum + part).is_finite() {
            return Err(Cause::NonFinite);
        }
        if observer.recorders.limits.newly_beyond().is_some() {
            observer.recorders.judge(machine, self.structure);
        }
        let [low, high] = transient.free_motion.table_range();
        let has_stopped = speed <= 0.0 && transient.free_motion.spin().can_stop();
        observer.speed = if has_stopped { 0.0 } else { speed };
        if transient.is_outside() {
            return Err(Cause::OutsideRing);
        }
        Ok(if has_stopped {
            Some(EndCause::Stopped)
        } else if observer.recorders.limits.ends(machine) {
            Some(EndCause::Limit)
        } else if machine.run.end_speed > 0.0 && speed <= machine.run.end_speed {
            Some(EndCause::EndSpeed)
        } else if transient.free_motion.time() >= machine.run.end_time - 0.5 * self.h {
            // half a step of slack: the last step ends at end_time, not one beyond it
            Some(EndCause::EndTime)
        } else {
            (!(low..=high).contains(&speed)).then_some(EndCause::TableRange)
        })
    }
}
