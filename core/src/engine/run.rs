//! A run of the full or the reduced engine from start to end, observed by recorders and a follower.

use super::bearing_loads::BearingLoads;
use super::beginning::begin;
use super::motion::Motion;
use super::release::Releases;
use super::rub::{Rub, StepContact};
use super::shaft_line::ShaftLine;
use super::stability::SolvedGrid;
use super::time_step::{StartError, TimeStep};
use super::torques::TruncatedTorsion;
use super::works::{add_works, write_stores};
use crate::contact::Gap;
use crate::record::{At, ContactFrame, End, EnergyBalance, Follower, Frame, Recorders, RingInstant, RotorInstant};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause};

/// Runs a machine from start to end: recorded quantities, and the end of the run.
///
/// # Errors
/// [`StartError`] for a run that cannot be started.
pub(super) fn run(
    machine: &Machine,
    structure: &Structure,
    plan: &TimeStep,
    follower: &mut dyn Follower,
) -> Result<(Recorders, End), StartError> {
    let mut run = Run::new(machine, structure, plan.step)?;
    let (cause, failure) = loop {
        if !follower.goes_on(run.motion.step) {
            break (EndCause::Failure, Some(Cause::StepLimit));
        }
        match run.step(follower) {
            Ok(None) => {}
            Ok(Some(end)) => break (end, None),
            Err(cause) => break (EndCause::Failure, Some(cause)),
        }
    };
    let Motion { time, speed, step: steps, .. } = run.motion;
    let end = End { cause, time, speed, failure, steps, iterations: run.motion.iterations() };
    // callers often check whether a run can start, with zero steps
    if steps > 0 {
        run.recorders.see_speed(At { time, speed }, &run.damping);
    }
    run.recorders.finish(&end, machine, structure);
    run.show_end(failure, follower);
    Ok((run.recorders, end))
}

/// State of a run.
struct Run<'a> {
    /// Machine with all its unbalances.
    machine: &'a Machine,
    /// Matrices, modes and coordinates.
    structure: &'a Structure,
    /// Motion of shaft and rings.
    motion: Motion<'a>,
    /// Recorded quantities.
    recorders: Recorders,
    /// Loads of bearings and pedestals.
    loads: BearingLoads,
    /// Least damping of the whirl modes at grid speeds.
    damping: SolvedGrid,
    /// Torsion of the truncated modes under torques over time.
    truncated: TruncatedTorsion,
    /// Pending releases of unbalances.
    releases: Releases<'a>,
    /// Whether the follower has received the last instant.
    end_shown: bool,
    /// Failure of the iteration at the start, which allows no first step.
    unsettled: Option<Cause>,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, structure: &'a Structure, dt: f64) -> Result<Self, StartError> {
        let releases = Releases::new(machine);
        let (motion, unsettled) = match releases.is_over() {
            true => begin(machine, structure, dt)?,
            false => begin(&releases.present(), structure, dt)?,
        };
        let mut recorders = Recorders::new(machine, &structure.rings, dt);
        recorders.settle_shaft(machine, structure);
        Ok(Self {
            releases,
            machine,
            structure,
            recorders,
            loads: BearingLoads::new(machine, structure, &motion.line),
            damping: SolvedGrid::new(machine, structure),
            truncated: TruncatedTorsion::new(machine, structure),
            end_shown: false,
            unsettled,
            motion,
        })
    }

    /// Advances from n to n+1; `Some` if the run has ended.
    fn step(&mut self, follower: &mut dyn Follower) -> Result<Option<EndCause>, Cause> {
        if self.machine.run.step_limit.is_some_and(|limit| self.motion.step >= limit) {
            return Err(Cause::StepLimit);
        }
        if let Some(cause) = self.unsettled {
            return Err(cause);
        }
        if self.recorders.is_new_speed(self.motion.speed, self.damping.noticeable()) {
            self.recorders.see_speed(At { time: self.motion.time, speed: self.motion.speed }, &self.damping);
        }
        self.motion.solve()?;
        self.motion.settle();
        if !self.releases.is_over() {
            self.release()?;
        }
        self.watch(follower)?;
        let step = self.motion.step;
        let stopped = self.motion.advance();
        if self.motion.is_outside() {
            return Err(Cause::OutsideRing);
        }
        if !stopped && !self.motion.line.is_in_tables(self.motion.speed) {
            self.recorders.guard(step, self.machine, self.structure);
            return Ok(Some(self.ended().unwrap_or(EndCause::TableRange)));
        }
        self.recorders.guard(step, self.machine, self.structure);
        Ok(if stopped { Some(EndCause::Stopped) } else { self.ended() })
    }

    /// Releases the unbalances due at n, after the step from n was solved without them, and solves the step again.
    fn release(&mut self) -> Result<(), Cause> {
        let Motion { time, line: ShaftLine { dt, .. }, .. } = self.motion;
        let now = At { time, speed: self.motion.centred_spin() };
        while let Some(due) = self.releases.due(now) {
            let before = self.releases.present();
            let site = self.releases.happen(&due);
            let (piece, late) = (self.motion.line.piece(&site), time - due.at.time);
            let jump = piece.jump(&site, &before, self.structure).ok_or(Cause::NonFinite)?;
            // v(n) + late Da, at an acceleration that is larger by Da
            self.motion.release(&self.releases.present(), self.structure, &jump.times(dt * (late - 0.5 * dt)))?;
            self.loads.set_weight(&self.motion.line);
            self.recorders.energies.now.released += piece.energy(&site, before.rotor.gravity, late);
            self.recorders.see_release(due.unbalance, due.at);
        }
        self.releases.pass(At { speed: self.motion.centred_spin(), ..now });
        Ok(())
    }

    /// Cause of the end of the run, other than a stop of the rotor.
    fn ended(&self) -> Option<EndCause> {
        let run = &self.machine.run;
        if self.recorders.limits.ends(self.machine) {
            return Some(EndCause::Limit);
        }
        if run.end_speed > 0.0 && self.motion.speed <= run.end_speed {
            return Some(EndCause::EndSpeed);
        }
        // half a step of slack, so that the last step ends at end_time and not one step later
        (self.motion.time >= run.end_time - 0.5 * self.motion.line.dt).then_some(EndCause::EndTime)
    }

    /// Records the step at n and sends it to the follower; an error if the state is beyond the validity of every model.
    fn watch(&mut self, follower: &mut dyn Follower) -> Result<(), Cause> {
        for (diaphragm, contact) in self.motion.contacts.iter().enumerate() {
            let force = contact.map_or(0.0, |contact| contact.force.normal);
            follower.contact_force(diaphragm, self.motion.time, force);
        }
        let shown = follower.wants(self.motion.step, self.motion.time);
        self.record(shown);
        if shown {
            self.show(self.motion.centred_spin(), follower);
        }
        match self.motion.beyond() {
            None => Ok(()),
            Some(cause) => {
                self.show_last(shown, follower);
                Err(cause)
            }
        }
    }

    /// Records quantities and works of the step at n. For an instant sent to the follower it also records the stored energies of this step.
    fn record(&mut self, shown: bool) {
        let (motion, recorders) = (&mut self.motion, &mut self.recorders);
        let at = At { time: motion.time, speed: motion.centred_spin() };
        self.loads.update(&motion.line, motion.pressed());
        motion.rubs.iter_mut().for_each(Rub::average_forces);
        let line = &motion.line;
        let (lateral, torsion_angles) = (&line.lateral.x, &*self.truncated.complete(motion.time, &line.torsion.x));
        let rings = motion.rubs.iter().zip(&motion.contacts).map(|(rub, contact)| {
            let (place, velocity) = rub.motion(line);
            let touch = contact.as_ref().map(StepContact::touch);
            RingInstant { angle: line.spin.angle, place, velocity, touch, ring: rub.ring_state() }
        });
        recorders.see(&RotorInstant { at, loads: self.loads.all(), lateral, torsion_angles }, rings);
        let (energies, step) = (&mut recorders.energies, motion.step);
        add_works(&mut energies.now, motion);
        if shown || EnergyBalance::wants_stores(step) {
            write_stores(&mut energies.now, motion);
        }
        energies.see(step);
    }

    /// Sends the instant n to the follower.
    fn show(&mut self, speed: f64, follower: &mut dyn Follower) {
        let Motion { line, rubs, contacts, time, .. } = &mut self.motion;
        let gaps: Vec<Gap> = rubs.iter_mut().map(|rub| rub.gap_at_n(line)).collect();
        let rings = rubs.iter().zip(contacts).zip(&gaps);
        let contacts: Vec<ContactFrame<'_>> = rings
            .map(|((rub, contact), gap)| ContactFrame {
                rotor: rub.place(line),
                gap: gap.value,
                angle: gap.place.alpha,
                normal_force: contact.map_or(0.0, |c| c.force.normal),
                friction_force: contact.map_or(0.0, |c| c.force.tangential),
                slip: contact.map_or(0.0, |c| c.slip),
                ring: rub.ring_displacement(gap),
                field: rub.ring_field(),
            })
            .collect();
        follower.see(&Frame {
            time: *time,
            angle: line.spin.angle,
            speed,
            displacement: &line.lateral.x,
            velocity: &line.lateral.v,
            torsion_angles: &self.truncated.complete(*time, &line.torsion.x),
            bearing_loads: self.loads.all().bearings,
            pedestal_loads: self.loads.all().pedestals,
            contacts: &contacts,
            energies: self.recorders.energies.now,
        });
    }

    /// Sends the instant of the end to a follower that requests it, for every cause of the end.
    ///
    /// The state at the end is known. Centred velocities, loads and contact forces need one more step, which is computed after the row is complete
    /// and then discarded; it does not affect the row. If this step cannot be computed (because it is the one that failed), velocities are those of
    /// the previous step and there is no contact force. Time, spin and works are those of the row.
    fn show_end(&mut self, failure: Option<Cause>, follower: &mut dyn Follower) {
        if self.end_shown || !follower.wants_end() {
            return;
        }
        // a step limit ends a run between two steps
        let may_go_on = matches!(failure, None | Some(Cause::StepLimit));
        if !may_go_on || self.motion.solve().is_err() {
            self.motion.repeat();
        }
        self.motion.settle();
        self.loads.update(&self.motion.line, self.motion.pressed());
        write_stores(&mut self.recorders.energies.now, &self.motion);
        self.show(self.motion.speed, follower);
        self.end_shown = true;
    }

    /// Sends the instant of a step beyond the validity of every model, unless it was already sent.
    fn show_last(&mut self, shown: bool, follower: &mut dyn Follower) {
        if !shown && follower.wants_end() {
            write_stores(&mut self.recorders.energies.now, &self.motion);
            self.show(self.motion.speed, follower);
        }
        self.end_shown = true;
    }
}
