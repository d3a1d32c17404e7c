//! A run with contact: flight in large steps where nothing can touch, contact steps where something may.
//!
//! ```text
//! room = gap - sum over ring modes of amplitude reach         > |x| all the time:  a step of h cannot touch
//! ```
//! |x| during the step is bounded ([`super::bound`]). Verified by `the_bound_of_the_way_is_one` and
//! `flight_misses_no_contact` (`tests/exponential_rub.rs`).

use super::free_motion::FreeMotion;
use super::shared_model::ring_points_of;
use crate::engine::exponential::contact::contact_step::ContactStep;
use crate::engine::exponential::contact::impact::{FreeStep, Impact};
use crate::engine::exponential::error::ExponentialError;
use crate::engine::exponential::modal::displacement_bound::length;
use crate::engine::exponential::modal::peak_bound::WatchedPeak;
use crate::engine::exponential::settings::{MAX_DOUBLINGS, StepSettings};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::engine::time_step::{StartError, slowest_to_resolve};
use crate::record::{LastMillisecond, Loads};
use crate::structure::Structure;
use bladeoff_model::machine::{ContactPoints, Detection, Diaphragm, ForceLocation, InitialState, Machine, OnExceed};
use bladeoff_model::outcome::Limit;

/// Flights up to this level are as long as they may for contact and peaks: their error goes with the contact step.
pub(crate) const SHORT_STEP: usize = 4;
/// Longer ones while neither the rotor nor its lowest lateral mode turns by more \[rad\], and where the spin is predicted so well that steps of every size give the same one.
const LONGEST_TURN: f64 = 0.075;
const MAX_PREDICTION_ERROR: f64 = 1e-7;
/// Nor by more than this does a torque of the brakes change in a flight that depends on the spin, beside the momentum: trapezoids are off by a twelfth of the square.
const EVEN_SPEED_CHANGE: f64 = 2e-3;
/// Contact steps after a touch in which a flight is no longer than those of the level beside: the shaft rings, and what its damping takes and what the unbalances pull are of powers at both ends.
/// (At 16 contact steps of 49 us a mode of the turbine of 640 Hz was at each look in one phase: energy errors of rubs with bounces were ten times as large.)
const RINGING_STEPS: u64 = 512;
const RINGING_LEVEL: usize = 3;
/// Contact steps of a start, each a flight of its own.
const STARTING_STEPS: u64 = 8;

/// A shaft line and the ring about it.
pub(crate) struct Transient {
    pub free_motion: FreeMotion,
    /// `None` without a diaphragm.
    pub contact: Option<RingContact>,
    /// Loads of the bearings at n, in the machine's order \[N\], then displacements of the journals whose bearings have a clearance \[m\].
    loads: Vec<[f64; 2]>,
    bearings: usize,
    /// Those, and the place of the diaphragm's node \[m\], as flight has to resolve them.
    watched: Vec<WatchedPeak>,
    /// Lengths of steps, by level \[s\].
    lengths: [f64; MAX_DOUBLINGS + 1],
    takes_long_steps: bool,
    /// Level of the longest flight, and of the last one.
    pub max_level: usize,
    last_level: usize,
    /// Time of the last touch, in contact steps.
    last_contact: Option<u64>,
    /// The shaft rings in all its modes from the start on: there are no flights, in which the loss of those would be seen too seldom.
    pub disturbed: bool,
    /// Contact steps of the whole run, and the spin \[rad/s\] that ends it: no flight goes beyond.
    end: u64,
    end_speed: f64,
}

/// The ring, and where the rotor is that it may touch.
pub(crate) struct RingContact {
    pub contact_step: ContactStep,
    /// Turn of the node over a contact step per angular impulse on it, and the jump of its rate \[1/(kg m2)\].
    rolling: f64,
    jump: f64,
}

/// A step that has been done, from n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepResult {
    /// It had `2^level` contact steps; `None` of one in which something might have touched.
    pub level: Option<usize>,
    /// Of the rotor's node at n, in the machine's axes.
    pub place: [f64; 2],
    pub velocity: [f64; 2],
    pub impact: Option<Impact>,
}

impl Transient {
    /// A machine at t = 0; `flies`: in larger steps where it may.
    ///
    /// # Errors
    /// [`ExponentialError`].
    pub fn new(
        machine: &Machine,
        structure: &Structure,
        settings: StepSettings,
        flies: bool,
    ) -> Result<Self, ExponentialError> {
        check_covered(machine)?;
        let flight = FreeMotion::new(machine, structure, settings)?;
        let contact = match machine.diaphragms.first() {
            None => None,
            Some(diaphragm) => {
                starts_inside(diaphragm, flight.place(0))?;
                let candidates = ring_points_of(machine, structure, settings.step)?;
                let spin = flight.spin();
                let twist_row = spin.torque_row(structure, diaphragm.contact.node);
                Some(RingContact {
                    rolling: spin.rolling(&spin.step(settings.step)),
                    jump: spin.jump(&twist_row),
                    contact_step: ContactStep::new(diaphragm, structure, 0, &candidates, settings.step)?,
                })
            }
        };
        let lengths: [f64; MAX_DOUBLINGS + 1] = std::array::from_fn(|level| flight.step_length(level));
        let fastest = slowest_to_resolve(machine, structure);
        let turns_little = |level: &usize| lengths[*level] * fastest <= LONGEST_TURN;
        let longest = (SHORT_STEP..=MAX_DOUBLINGS).rev().find(turns_little).unwrap_or(SHORT_STEP);
        let brakes = flight.spin().braking_torque(&machine.braking);
        let holds = |&level: &usize| {
            lengths[level] * brakes <= EVEN_SPEED_CHANGE && flight.is_stable(level, machine.run.end_time)
        };
        let journals = journals(machine, &flight);
        let InitialState { displacement, velocity, .. } = machine.rotor.initial;
        let disturbed = [displacement, velocity] != [[0.0; 2]; 2];
        Ok(Self {
            max_level: if disturbed { 0 } else { (1..=longest).take_while(holds).last().unwrap_or(0) },
            disturbed,
            bearings: structure.rotor.bearings.len(),
            loads: vec![[0.0; 2]; structure.rotor.bearings.len() + journals.len()],
            watched: (0..structure.rotor.bearings.len())
                .map(|bearing| WatchedPeak::new(flight.constant_load(bearing)))
                .chain(journals)
                .chain(machine.diaphragms.first().map(|d| WatchedPeak::new(d.contact.offset.map(|part| -part))))
                .collect(),
            last_level: 0,
            last_contact: None,
            lengths,
            free_motion: flight,
            contact,
            takes_long_steps: flies,
            end_speed: machine.run.end_speed,
            end: libm::round(machine.run.end_time / settings.step).max(1.0) as u64,
        })
    }

    /// Whether the rotor's centre is farther from the stator's than its circle may ever be: by its radius.
    pub fn is_outside(&self) -> bool {
        let Some(contact) = &self.contact else { return false };
        let [x, y] = contact.contact_step.place(self.free_motion.place(0));
        x * x + y * y > contact.contact_step.outermost() * contact.contact_step.outermost()
    }

    /// Length of a contact step \[s\].
    pub fn contact_step(&self) -> f64 {
        self.lengths[0]
    }

    /// Loads and journals at n.
    pub fn loads(&self) -> Loads<'_> {
        let (bearings, journals) = self.loads.split_at(self.bearings);
        Loads { bearings, journals }
    }

    /// Whether the run is in its first steps.
    pub fn is_starting(&self) -> bool {
        self.free_motion.contact_steps() < STARTING_STEPS
    }

    /// Takes the loads at n, and says how long a step from there is certain to touch nothing, and to miss no peak: `2^level` contact steps; `None` where a
    /// contact step may touch.
    pub fn next_step_doublings(&mut self) -> Option<usize> {
        let level = self.free_step_doublings();
        self.last_level = level.unwrap_or(0);
        level
    }

    fn free_step_doublings(&mut self) -> Option<usize> {
        // what contact has added to them is among the largest
        if self.contact.as_ref().is_some_and(|contact| contact.contact_step.presses()) {
            self.watch_loads();
        }
        self.evaluate_loads();
        self.watch_loads();
        let Self {
            free_motion: flight,
            contact,
            watched,
            lengths,
            takes_long_steps: flies,
            max_level: most,
            last_level: last,
            last_contact: touched,
            end,
            end_speed,
            ..
        } = self;
        let mut place = None;
        if let (Some(RingContact { contact_step: rub, .. }), Some(watched)) = (contact, watched.last_mut()) {
            let x = rub.displacement_from_centre(flight.place(0));
            watched.update(x);
            // what has pressed a step ago may press again: not worth the bounds
            if !*flies || rub.presses() {
                return None;
            }
            let within = rub.clearance();
            if length(x) >= within {
                return None;
            }
            place = Some((x, within));
        }
        let left = end.saturating_sub(flight.contact_steps()).max(1);
        // twice the last one: what it tells of the spin holds so far
        let most = match touched {
            _ if flight.contact_steps() < STARTING_STEPS => 0,
            Some(touched) if flight.contact_steps() - *touched < RINGING_STEPS => RINGING_LEVEL.min(*most),
            _ => *most,
        };
        let mut longest = most.min(left.ilog2() as usize).min(SHORT_STEP.max(*last + 1));
        while longest > SHORT_STEP && flight.spin().prediction_error(lengths[longest]) > MAX_PREDICTION_ERROR {
            longest -= 1;
        }
        // a stop is found to a contact step
        while longest > 0 && flight.spin().speed_after(2.0 * lengths[longest]) <= *end_speed {
            longest -= 1;
        }
        let velocity = flight.bound_states();
        if let Some((x, within)) = place {
            longest = flight.longest_step_within(lengths, [x, velocity], within, longest)?;
        }
        Some(flight.longest_resolved_step(watched, longest))
    }

    fn watch_loads(&mut self) {
        self.watched.iter_mut().zip(&self.loads).for_each(|(watched, load)| watched.update(*load));
    }

    /// Takes the loads at n, without what contact there adds.
    pub fn evaluate_loads(&mut self) {
        for (bearing, load) in self.loads.iter_mut().enumerate() {
            *load = self.free_motion.load(bearing);
        }
    }

    /// Loads and contact at n, of a run that does not go on from there: the state is left where the step would lead.
    pub fn solve_next_contact(&mut self) -> Option<Impact> {
        self.evaluate_loads();
        self.step(None).ok().and_then(|done| done.impact)
    }

    /// Goes from n to n+1, over a step of [`Transient::level`], which has taken the loads at n: contact adds to them.
    pub fn step(&mut self, level: Option<usize>) -> Result<StepResult, ExponentialError> {
        let Self { free_motion: flight, contact, loads, lengths, last_contact: touched, .. } = self;
        let Some(RingContact { contact_step: rub, rolling, jump }) = contact else {
            flight.advance(level.unwrap_or(0))?;
            return Ok(StepResult { level, place: [0.0; 2], velocity: [0.0; 2], impact: None });
        };
        let [place, velocity] = flight.contact(0);
        let mut done = StepResult { level, place, velocity, impact: None };
        if let Some(level) = level {
            flight.advance(level)?;
            rub.propagate_ring(level, lengths[level]);
            return Ok(done);
        }
        let h = lengths[0];
        let [twist_before, rate] = flight.spin().at_contact();
        let rate = flight.spin().speed + rate;
        flight.propagate(0)?;
        let Some(kick) = flight.impulse_response() else { return Ok(done) };
        let free = FreeStep {
            from: place,
            to: flight.place(0),
            velocity,
            kick,
            turn: flight.spin().turn(twist_before),
            rolling: *rolling,
            rate,
            jump: *jump,
            spin: flight.spin(),
        };
        done.impact = rub.solve(&free)?;
        if let Some(impact) = &done.impact {
            *touched = Some(flight.contact_steps());
            for (bearing, (load, half)) in loads.iter_mut().zip(&kick.loads).enumerate() {
                let at_once = flight.load_with_feedthrough(bearing, impact.on_rotor.map(|part| part / h));
                for i in 0..2 {
                    load[i] += half[i][0] * impact.on_rotor[0] + half[i][1] * impact.on_rotor[1] + at_once[i];
                }
            }
        }
        let blow = done.impact.map(|impact| ContactImpulse { impulse: impact.on_rotor, torque: impact.torque });
        flight.complete_step(0, blow)?;
        Ok(done)
    }
}

/// Displacements of the journals whose bearings have a clearance; where the limit ends the run its first excess is found to a contact step.
fn journals(machine: &Machine, flight: &FreeMotion) -> Vec<WatchedPeak> {
    let limit = &machine.run.limits[Limit::JournalClearance as usize];
    let clearances = machine.rotor.bearings.iter().filter_map(|bearing| bearing.clearance);
    let watched = |(at, clearance): (usize, f64)| {
        let watched = WatchedPeak::new(flight.constant_load(machine.rotor.bearings.len() + at));
        match limit.on_exceed {
            OnExceed::Beyond => watched.limited(limit.value * clearance, machine.run.end_beyond),
            OnExceed::Note => watched,
        }
    };
    clearances.enumerate().map(watched).collect()
}

/// Refuses a rotor, at a place in the machine's axes, that is not free in its ring.
///
/// # Errors
/// [`StartError::StartsOutside`], [`StartError::StartsInContact`].
fn starts_inside(diaphragm: &Diaphragm, place: [f64; 2]) -> Result<(), StartError> {
    let contact = &diaphragm.contact;
    let eccentricity = length([place[0] - contact.offset[0], place[1] - contact.offset[1]]);
    let radius = contact.rotor_radius + contact.gap;
    let name = || diaphragm.name.clone();
    if eccentricity >= radius {
        return Err(StartError::StartsOutside { diaphragm: name(), eccentricity, radius, offset: contact.offset });
    }
    let gap = contact.gap - eccentricity;
    if gap < 0.0 { Err(StartError::StartsInContact { diaphragm: name(), gap }) } else { Ok(()) }
}

/// Refuses by name what is not covered.
///
/// # Errors
/// [`ExponentialError::NotCovered`].
fn check_covered(machine: &Machine) -> Result<(), ExponentialError> {
    if machine.diaphragms.len() > 1 {
        return Err(ExponentialError::NotCovered { what: "more than one diaphragm" });
    }
    for contact in machine.diaphragms.iter().map(|diaphragm| &diaphragm.contact) {
        if contact.detection != Detection::Hyp2 || contact.points != ContactPoints::Several {
            return Err(ExponentialError::NotCovered { what: "contact other than hyp2 at several points" });
        }
        if machine.run.force_location != ForceLocation::Next {
            return Err(ExponentialError::NotCovered {
                what: "forces at the place of n (run.force_location = \"current\")",
            });
        }
    }
    Ok(())
}

/// What a run with contact comes to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RubbingRun {
    /// First contact \[s\].
    pub first_contact: Option<f64>,
    /// Spin at the end \[rad/s\].
    pub end_speed: f64,
    /// Largest load of each bearing, in the machine's order \[N\].
    pub largest_loads: Vec<f64>,
    /// Largest mean of the normal force over 1 ms \[N\].
    pub largest_filtered_force: f64,
    /// Normal impulse of all contact \[N s\].
    pub impulse: f64,
    /// Work of friction \[J\].
    pub friction_energy: f64,
    /// Work that normal impulses took out \[J\].
    pub normal_work: f64,
    /// Largest distance of the rotor's node from the stator's centre \[m\].
    pub eccentricity: f64,
    /// Contact steps, those of them that touched, and flight steps.
    pub steps: [u64; 3],
}

/// A whole run up to `run.end_time` with contact at the first diaphragm, in contact steps of `settings.step`; `flies`: in larger ones where it may.
///
/// # Errors
/// [`ExponentialError`].
pub fn rubbing_run(
    machine: &Machine,
    structure: &Structure,
    settings: StepSettings,
    flies: bool,
) -> Result<RubbingRun, ExponentialError> {
    let mut transient = Transient::new(machine, structure, settings, flies)?;
    let h = settings.step;
    let mut filter = LastMillisecond::new(h);
    let window = filter.length() as f64 * h;
    let bearings = structure.rotor.bearings.len();
    let offset = machine.diaphragms.first().map_or([0.0; 2], |diaphragm| diaphragm.contact.offset);
    let mut run = RubbingRun { largest_loads: vec![0.0; bearings], ..RubbingRun::default() };
    while transient.free_motion.time() < machine.run.end_time - 0.5 * h {
        let level = transient.next_step_doublings();
        let done = transient.step(level)?;
        run.eccentricity = run.eccentricity.max(length([done.place[0] - offset[0], done.place[1] - offset[1]]));
        match done.level {
            Some(level) => {
                (0..1 << level).for_each(|_| filter.slide(0.0));
                run.steps[2] += 1;
            }
            None => {
                run.steps[0] += 1;
                filter.slide(done.impact.map_or(0.0, |impact| impact.normal));
                if let Some(sum) = filter.sum() {
                    run.largest_filtered_force = run.largest_filtered_force.max(sum / window);
                }
            }
        }
        if let Some(impact) = done.impact {
            run.steps[1] += 1;
            run.impulse += impact.normal;
            run.friction_energy += impact.friction_work;
            run.normal_work += impact.normal_work;
            run.first_contact = run.first_contact.or(Some(transient.free_motion.time()));
        }
        for (largest, load) in run.largest_loads.iter_mut().zip(&transient.loads) {
            *largest = largest.max(length(*load));
        }
    }
    run.end_speed = transient.free_motion.speed();
    Ok(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn the_bound_of_the_way_is_one() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut flight = FreeMotion::new(&machine, &structure, StepSettings::of_step(2e-5)).expect("has a basis");
        let (mut closest, mut seen) = (0.0_f64, 0);
        for round in 0..40 {
            for (level, fine) in [(4, 16), (7, 128)] {
                let from = flight.contact(0)[0];
                let velocity = flight.bound_states();
                let bound = flight.max_deviation(level);
                let mut ahead = flight.clone();
                for n in 1..=fine {
                    ahead.advance(0).expect("goes on");
                    let (to, t) = (ahead.contact(0)[0], f64::from(n) * 2e-5);
                    let beyond = length([to[0] - from[0] - t * velocity[0], to[1] - from[1] - t * velocity[1]]);
                    assert!(beyond <= bound, "round {round}: {beyond} beyond {bound}");
                    closest = closest.max(beyond / bound);
                    seen += 1;
                }
            }
            // states of every kind: struck in between
            flight.propagate(0).expect("goes on");
            let turn = f64::from(round);
            let blow = ContactImpulse { impulse: [0.3 * turn.sin(), 0.2 * turn.cos()], torque: 1e-3 };
            flight.complete_step(0, Some(blow)).expect("goes on");
            (0..50).for_each(|_| flight.advance(1).expect("goes on"));
        }
        assert!(seen > 5000 && closest > 0.05, "the bound says something: {closest}");
    }
}
