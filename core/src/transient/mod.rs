//! The transient: one blade-off from release to its end.
//!
//! Main path: [`simulate`] plans the step, starts the shaft line, and repeats: predict without contact, correct with contact,
//! record, advance. Scheme: central differences with forward-increment Lagrange multipliers (paper, section 3; physics.md
//! section 4), non-linear terms centred and iterated.

mod bearing_loads;
mod brake;
mod damping;
mod end;
mod loaded_start;
mod plan;
mod prescribed;
mod rub;
mod shaft_line;
mod start;
mod stepper;
mod twin;
mod works;

pub use damping::{UnresolvedDamping, unresolved_damping};
pub use plan::{StartError, StepPlan};

use bearing_loads::BearingLoads;
use rub::{ContactFailure, Rub, StepContact};
use shaft_line::{ShaftLine, distance, norm};

use crate::machine::Machine;
use crate::outcome::{Cause, EndCause, Outcome};
use crate::record::{At, ContactFrame, End, Follower, Frame, Recorders, RingInstant};
use crate::structure::Structure;

/// Convergence of the non-linear solve without contact, relative to the increment.
const TOLERANCE: f64 = 1e-12;
/// Its iterations at most: it contracts by about `Omega dt` each, by `m e^2/(J + m e^2)` where an unbalance outweighs the spin's
/// inertia.
const ITERATIONS: usize = 600;
/// Least contraction a round is credited with: two rounds that happen to agree say nothing about the next step's.
const CONTRACTION: f64 = 1e-3;
/// The energy balance is evaluated every so many steps (the works are summed at each), from the first on.
const BALANCE_EVERY: u64 = 8;
/// A displacement beyond this many times the model's size is no vibration any more.
const DIVERGED: f64 = 10.0;

/// Simulates one run, and its twin where `run.twin` asks for one: the follower sees the first alone, but may end both.
///
/// `structure` must fit the machine ([`Structure::fits`]). Failures of the simulation (divergence, loss of uniqueness, step
/// limit) are outcomes with a cause, not errors.
///
/// # Errors
/// [`StartError`] for a run that cannot be started.
pub fn simulate(machine: &Machine, structure: &Structure, follower: &mut dyn Follower) -> Result<Outcome, StartError> {
    let plan = StepPlan::new(machine, structure)?;
    let run = one_run(machine, structure, &plan, follower)?;
    let twin = twin::twin_of(&run, machine, structure, &plan, follower);
    let (recorders, end) = run;
    Ok(recorders.outcome(machine, structure, &end, twin.as_ref()))
}

/// One run from its start to its end.
fn one_run(
    machine: &Machine,
    structure: &Structure,
    plan: &StepPlan,
    follower: &mut dyn Follower,
) -> Result<(Recorders, End), StartError> {
    let mut run = Run::new(machine, structure, plan.step)?;
    let (cause, failure) = loop {
        if !follower.goes_on(run.step) {
            break (EndCause::Failure, Some(Cause::StepLimit));
        }
        match run.step(follower) {
            Ok(None) => {}
            Ok(Some(end)) => break (end, None),
            Err(cause) => break (EndCause::Failure, Some(cause)),
        }
    };
    let end = End { cause, time: run.time, speed: run.speed, failure };
    // a run too short for a second balance has one at its last step
    if failure.is_none() && run.step <= BALANCE_EVERY {
        run.recorders.energies.balance();
    }
    run.recorders.finish(&end);
    run.recorders.steps.iterations = run.iterations + run.rub.as_ref().map_or(0, |rub| rub.iterations);
    run.show_end(failure, follower);
    Ok((run.recorders, end))
}

/// A run under way.
struct Run<'a> {
    machine: &'a Machine,
    line: ShaftLine<'a>,
    rub: Option<Rub<'a>>,
    recorders: Recorders,
    /// Steps done, time and speed at n.
    step: u64,
    time: f64,
    speed: f64,
    iterations: u64,
    /// Increments of the step, and those of the step before (for the first guess).
    d: Vec<f64>,
    d_twist: Vec<f64>,
    before: [Vec<f64>; 2],
    twist_before: Vec<f64>,
    /// Contraction of the non-linear iteration, as last measured.
    contraction: f64,
    next: Vec<f64>,
    next_twist: Vec<f64>,
    size: f64,
    loads: BearingLoads,
    /// The last instant has been shown.
    end_shown: bool,
    /// Why the start did not settle: there is no first step from it.
    unsettled: Option<Cause>,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, structure: &'a Structure, dt: f64) -> Result<Self, StartError> {
        let singular = StartError::Singular { what: "mass", part: "the rotor" };
        let mut line = ShaftLine::new(machine, structure, dt).ok_or_else(|| singular.clone())?;
        let settled = start::start(machine, structure, &mut line)?;
        let rub = match machine.diaphragms.first() {
            None => None,
            Some(diaphragm) => {
                let mut rub = Rub::new(diaphragm, structure, &line, machine.run.force_location, dt).ok_or(singular)?;
                let place = rub.local(line.place(rub.node));
                if rub.is_outside(place) {
                    return Err(StartError::StartsOutside {
                        diaphragm: diaphragm.name.clone(),
                        eccentricity: norm(&place),
                        radius: diaphragm.contact.rotor_radius + diaphragm.contact.gap,
                        offset: diaphragm.contact.offset,
                    });
                }
                let gap = rub.gap_at(place).value;
                if gap < 0.0 && !rub.is_spring() {
                    return Err(StartError::StartsInContact { diaphragm: diaphragm.name.clone(), gap });
                }
                Some(rub)
            }
        };
        let size = match &machine.rotor.kind {
            crate::machine::RotorKind::Shaft(shaft) => shaft.nodes.last().copied().unwrap_or(1.0),
            // a point mass has no length: only its clearance, or nothing, tells its size
            crate::machine::RotorKind::PointMass(_) => {
                machine.diaphragms.first().map_or(1e6, |d| 1e4 * (d.contact.gap + d.contact.rotor_radius))
            }
        };
        let zeros = vec![0.0; line.lateral.q.len()];
        let twist = vec![0.0; line.twist.q.len()];
        let mut run = Self {
            machine,
            rub,
            recorders: Recorders::new(machine, &structure.rings, dt),
            step: 0,
            time: 0.0,
            speed: machine.rotor.initial_speed,
            iterations: 0,
            d: line.lateral.previous.clone(),
            d_twist: line.twist.previous.clone(),
            before: [line.lateral.previous.clone(), line.lateral.previous.clone()],
            twist_before: line.twist.previous.clone(),
            contraction: 1.0,
            next: zeros,
            next_twist: twist,
            size,
            loads: BearingLoads::new(structure, &line),
            end_shown: false,
            line,
            unsettled: None,
        };
        let loaded = if settled { run.load_start(structure) } else { Err(Cause::Diverged) };
        run.unsettled = loaded.err();
        Ok(run)
    }

    /// One step from n to n+1; `Some` when the run has ended.
    fn step(&mut self, follower: &mut dyn Follower) -> Result<Option<EndCause>, Cause> {
        if self.machine.run.step_limit.is_some_and(|limit| self.step >= limit) {
            return Err(Cause::StepLimit);
        }
        if let Some(cause) = self.unsettled {
            return Err(cause);
        }
        self.line.prepare();
        if let Some(rub) = &mut self.rub {
            rub.prepare();
        }
        self.predict()?;
        let contact = match &mut self.rub {
            None => None,
            Some(rub) => {
                rub.correct(&mut self.line, self.time, &mut self.d, &mut self.d_twist).map_err(
                    |failure| match failure {
                        ContactFailure::NotUnique(_) => Cause::LossOfUniqueness,
                        ContactFailure::NoConvergence => Cause::Diverged,
                    },
                )?
            }
        };
        self.line.settle(&self.d, &self.d_twist);
        if self.rub.is_some() {
            follower.contact_force(self.time, contact.as_ref().map_or(0.0, |contact| contact.force.normal));
        }
        let shown = follower.wants(self.step, self.time);
        self.record(contact.as_ref(), shown);
        if shown {
            self.show(contact.as_ref(), self.line.centred_spin(&self.d_twist), follower);
        }
        if let Some(cause) = self.beyond() {
            self.show_last(contact.as_ref(), shown, follower);
            return Err(cause);
        }
        let (over_step, reached) =
            (self.line.spin_over_step(&self.d_twist), self.line.spin_reached(self.time, &self.d_twist));
        self.before.swap(0, 1);
        self.before[0].copy_from_slice(&self.line.lateral.previous);
        self.twist_before.copy_from_slice(&self.line.twist.previous);
        self.line.advance(&self.d, &self.d_twist);
        if let Some(rub) = &mut self.rub {
            rub.advance();
        }
        self.step += 1;
        self.recorders.steps.done = self.step;
        self.time = self.step as f64 * self.line.dt;
        let can_stop = self.line.prescribed.is_none() && self.machine.rotor.initial_speed > 0.0;
        let stopped = can_stop && over_step <= 0.0;
        // a rotor that stops within the last half step does not turn back in it
        self.speed = if stopped || can_stop && reached < 0.0 { 0.0 } else { reached };
        if let Some(rub) = &mut self.rub
            && rub.is_outside(rub.local(self.line.place(rub.node)))
        {
            return Err(Cause::OutsideRing);
        }
        Ok(if stopped { Some(EndCause::Stopped) } else { self.ended() })
    }

    /// Why the state at n+1, not yet taken, cannot be gone on with.
    fn beyond(&self) -> Option<Cause> {
        let next = self.line.x.iter().zip(&self.line.d_nodal).map(|(x, dx)| (x + dx).abs());
        // `max` passes over NaN
        let reach = next.fold(0.0_f64, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) });
        if !reach.is_finite() {
            return Some(Cause::NonFinite);
        }
        (reach > DIVERGED * self.size).then_some(Cause::Diverged)
    }

    /// Increments without contact, converged: the remaining error, from the measured contraction, is below tolerance.
    fn predict(&mut self) -> Result<(), Cause> {
        // extrapolated from the last three steps
        for i in 0..self.d.len() {
            let (last, before, first) = (self.line.lateral.previous[i], self.before[0][i], self.before[1][i]);
            self.d[i] = 3.0 * (last - before) + first;
        }
        for i in 0..self.d_twist.len() {
            self.d_twist[i] = 2.0 * self.line.twist.previous[i] - self.twist_before[i];
        }
        let mut last_change: Option<f64> = None;
        for _ in 0..ITERATIONS {
            self.iterations += 1;
            let driven = self.line.driven();
            self.line.respond(self.time, &self.d, &self.d_twist, &mut self.next, &mut self.next_twist);
            let scale = self.line.lateral_scale(norm(&self.next));
            let twist_scale = norm(&self.next_twist).max(self.line.twist_scale());
            let drive_change = (self.line.driven() - driven).abs();
            let change = (distance(&self.next, &self.d) / scale)
                .max((distance(&self.next_twist, &self.d_twist) + drive_change) / (twist_scale + f64::MIN_POSITIVE));
            std::mem::swap(&mut self.d, &mut self.next);
            std::mem::swap(&mut self.d_twist, &mut self.next_twist);
            if let Some(last) = last_change {
                self.contraction = (change / last).clamp(CONTRACTION, 1.0);
            }
            // before a second round the last measured contraction stands in, with a margin
            let contraction = if last_change.is_some() { self.contraction } else { (4.0 * self.contraction).min(1.0) };
            if change * contraction <= TOLERANCE {
                return Ok(());
            }
            if !(scale.is_finite() && twist_scale.is_finite()) {
                return Err(Cause::NonFinite);
            }
            last_change = Some(change);
        }
        Err(Cause::Diverged)
    }

    /// Quantities and works of the step at n. An instant that is shown has the stores of its own step; the balance is judged
    /// at the same steps whoever looks.
    fn record(&mut self, contact: Option<&StepContact>, shown: bool) {
        let at = At { time: self.time, speed: self.line.centred_spin(&self.d_twist) };
        let pressed = self.rub.as_ref().zip(contact).map(|(rub, contact)| (rub.node, rub.outwards(contact.on_rotor)));
        self.loads.update(&self.line, pressed);
        self.recorders.loads.see(self.loads.all(), at);
        self.recorders.stresses.see(&self.line.x, &self.line.beta, at);
        for (ring, rub) in self.recorders.rings.iter_mut().zip(&self.rub) {
            let (place, velocity) = self.line.node(rub.node);
            let now = RingInstant {
                angle: self.line.phi,
                place: rub.local(place),
                velocity: rub.local_direction(velocity),
                touch: contact.map(StepContact::touch),
                ring: rub.ring_coordinates(),
            };
            ring.see(&now, at);
        }
        let rub = self.rub.as_mut().map(|rub| (rub, contact));
        works::add_works(&mut self.recorders.energies.now, &mut self.line, rub, &self.d, &self.d_twist);
        let balanced = self.step.is_multiple_of(BALANCE_EVERY);
        if balanced || shown || self.step < BALANCE_EVERY {
            self.write_stores();
        }
        if balanced {
            self.recorders.energies.balance();
        }
    }

    fn write_stores(&mut self) {
        let now = &mut self.recorders.energies.now;
        works::write_stores(now, &self.line, self.rub.as_ref(), &self.d, &self.d_twist);
    }

    /// Hands the instant n to the follower.
    fn show(&mut self, contact: Option<&StepContact>, speed: f64, follower: &mut dyn Follower) {
        let frame_contact = self.rub.as_mut().map(|rub| {
            let rotor = rub.local(self.line.place(rub.node));
            let gap = rub.gap_at(rotor);
            ContactFrame {
                rotor,
                gap: gap.value,
                angle: gap.place.alpha,
                normal_force: contact.map_or(0.0, |c| c.force.normal),
                friction_force: contact.map_or(0.0, |c| c.force.tangential),
                slip: contact.map_or(0.0, |c| c.slip),
                ring: rub.ring_displacement(&gap),
            }
        });
        follower.see(&Frame {
            time: self.time,
            angle: self.line.phi,
            speed,
            displacement: &self.line.x,
            velocity: self.line.velocity(),
            twist: &self.line.beta,
            bearing_loads: self.loads.all(),
            contact: frame_contact,
            ring: self.rub.as_ref().and_then(Rub::ring_field),
            energies: self.recorders.energies.now,
        });
    }

    /// Whether the run has come to its end, unless the rotor has stopped.
    fn ended(&self) -> Option<EndCause> {
        let run = &self.machine.run;
        if run.end_speed > 0.0 && self.speed <= run.end_speed {
            return Some(EndCause::EndSpeed);
        }
        // half a step of slack: the last step ends at end_time, not one beyond it
        (self.time >= run.end_time - 0.5 * self.line.dt).then_some(EndCause::EndTime)
    }
}
