//! Transient of a shaft line inside its diaphragms: free motion in long steps while all gaps stay open, contact steps where one may
//! close.
//!
//! A step has 2^k contact steps; k is its number of doublings. [`Transient::next_step_doublings`] chooses k: no step may miss a
//! contact or a peak of a load. [`Transient::step`] takes the step.
//!
//! ```text
//! |x(t)| < gap - sum_j a_j reach_j   for the whole step:   no point of a ring is reached
//! ```
//! - x: displacement of the rotor's centre from the ring's centre; a bound of |x| over a step is in `modal/displacement_bound.rs`
//! - a_j: amplitude of ring mode j in free vibration; reach_j: largest displacement of the ring per unit of a_j
//!
//! Verified by `the_bound_of_the_way_is_one`, `free_motion_never_reaches_a_ringing_ring` and `free_motion_misses_no_contact`
//! (`tests/exponential/exponential_rub.rs`).

use super::diaphragm_contact::{self, DiaphragmContact};
use super::free_motion::FreeMotion;
use crate::engine::exponential::ExponentialError;
#[cfg(test)]
use crate::engine::exponential::contact::stator::Stator;
use crate::engine::exponential::modal::peak_bound::WatchedPeak;
#[cfg(test)]
use crate::engine::exponential::settings::Fault;
use crate::engine::exponential::settings::{MAX_DOUBLINGS, StepSettings};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::engine::release::{Releases, release_steps};
use crate::engine::time_step::slowest_to_resolve;
use crate::record::Loads;
use crate::structure::Structure;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, ForceLocation, InitialState, Machine, OnExceed, Torque};
use bladeoff_model::outcome::Limit;

/// Doublings up to which a step is limited by contact and peaks alone. The error of such a step falls with the contact step.
pub(crate) const SHORT_STEP_DOUBLINGS: usize = 4;
/// Largest turn of the rotor, and of its lowest lateral mode, over a step of more than 2^[`SHORT_STEP_DOUBLINGS`] contact steps \[rad\].
const MAX_TURN: f64 = 0.075;
/// Largest relative error of the predicted spin over such a step.
const MAX_PREDICTION_ERROR: f64 = 1e-7;
/// Largest relative change of the braking torque over a step of free motion, as far as the torque depends on the spin. The
/// trapezoidal rule is off by a twelfth of its square.
const MAX_BRAKING_CHANGE: f64 = 2e-3;
/// Number of contact steps after a contact in which steps of free motion have at most [`RINGING_DOUBLINGS`] doublings. The shaft
/// still rings then, and its energy terms are trapezoids of powers at both ends of a step. (With 16 contact steps of 49 us every
/// observation saw a 640 Hz mode of the turbine in the same phase. Energy errors of rubs with bounces were ten times as large.)
const RINGING_STEPS: u64 = 512;
const RINGING_DOUBLINGS: usize = 3;
/// Largest turn of the lowest torsional mode, and of twice the frequency of a grid, over a step of free motion once a torque has changed
/// \[rad\]: torsional moments are recorded at the ends of steps, and between two of them a peak is larger by at most an eighth of its square.
const MAX_TORSIONAL_TURN: f64 = 0.1;
/// Number of contact steps at the start of a run that are taken one by one.
const STARTING_STEPS: u64 = 8;

/// Share of the gap from which on the displacement of the rotor at a diaphragm limits the step by its peaks, besides that at the
/// diaphragm with the largest share.
const NEAR_SHARE: f64 = 0.9;

/// State of a run: the shaft line, and the diaphragms around it.
pub(crate) struct Transient {
    pub free_motion: FreeMotion,
    /// Contacts with the diaphragms, in the machine's order.
    pub contacts: Vec<DiaphragmContact>,
    /// Contact impulses of the last step.
    pub impulses: Vec<ContactImpulse>,
    /// Loads of the bearings at n, in the machine's order, and of the pedestals \[N\], then displacements of the journals in bearings with a clearance
    /// and of the monitors \[m\].
    loads: Vec<[f64; 2]>,
    /// Numbers of bearings, of pedestals and of those journals: the first entries of `loads`.
    supports: [usize; 3],
    /// Quantities whose peaks limit the step: the entries of `loads`, then the displacements of the rotor at the diaphragms \[m\].
    watched: Vec<WatchedPeak>,
    /// Length of a step of 2^k contact steps \[s\], by k.
    lengths: [f64; MAX_DOUBLINGS + 1],
    /// Whether free motion inside a ring takes long steps; otherwise every step there is a contact step.
    takes_long_steps: bool,
    /// Largest number of doublings of this run, and doublings of the last step of free motion.
    pub max_doublings: usize,
    last_doublings: usize,
    /// Time of the last contact, in contact steps.
    last_contact: Option<u64>,
    /// Times at which the slope of a prescribed speed or of a torque changes or an unbalance is released, in contact steps. The torsional modes ring behind them, as the
    /// shaft does behind a contact, and no step of free motion goes beyond one.
    corners: Vec<u64>,
    /// Time from which torques have changed, in contact steps, and doublings that resolve the torsion from then on; `None`: no torque changes.
    torsion: Option<(u64, usize)>,
    /// Time of the last release of an unbalance, in contact steps, and speeds at which others are released \[rad/s\].
    last_release: Option<u64>,
    pub release_speeds: Vec<f64>,
    /// Whether the run starts with an initial disturbance, or with a rotor at rest. All shaft modes ring then, or their energy is not
    /// small beside that of the spin, so every step is one contact step: longer steps would sample the dissipation of the fast modes
    /// too seldom.
    pub disturbed: bool,
    /// Rate that a long step of free motion resolves \[rad/s\].
    highest_rate: f64,
    /// Length of the run in contact steps. No step of free motion goes beyond it.
    end: u64,
    /// Lowest and highest spin of the run \[rad/s\]: spin that ends it, or range of the bearing tables. No step of free motion goes beyond them.
    speed_range: [f64; 2],
    /// Fault that a test injects.
    #[cfg(test)]
    fault: Option<Fault>,
}

impl Transient {
    /// Creates the transient of a machine at t = 0. With `takes_long_steps = false` every step inside a ring is a contact step.
    ///
    /// # Errors
    /// [`ExponentialError`] for a machine that is not covered, has no modal basis or starts in contact.
    pub fn new(
        machine: &Machine,
        structure: &Structure,
        settings: StepSettings,
        takes_long_steps: bool,
    ) -> Result<Self, ExponentialError> {
        check_covered(machine)?;
        let free_motion = FreeMotion::new(machine, structure, settings)?;
        let contacts = DiaphragmContact::all(machine, structure, &free_motion, settings.step)?;
        #[cfg(test)]
        let contacts = with_fault(contacts, settings.fault);
        for (contact, diaphragm) in contacts.iter().zip(&machine.diaphragms) {
            contact.stator.ring().map_or(Ok(()), |ring| ring.check_static_compliance(&diaphragm.name))?;
        }
        let lengths: [f64; MAX_DOUBLINGS + 1] = std::array::from_fn(|doublings| free_motion.step_length(doublings));
        let highest_rate = slowest_to_resolve(machine, structure).max(rate_of_torques(machine));
        let max_doublings = max_doublings(machine, &free_motion, lengths, highest_rate);
        let torsion = torsional_doublings(machine, &free_motion, lengths);
        let [bearings, pedestals] = [structure.rotor.bearings.len(), structure.rotor.pedestals.len()];
        let support_count = bearings + pedestals;
        let journals = journal_peaks(machine, support_count, &free_motion);
        let supports = [bearings, pedestals, journals.len()];
        let first_monitor = support_count + journals.len();
        let load_count = first_monitor + machine.monitors.len();
        let InitialState { displacement, velocity, .. } = machine.rotor.initial;
        let [low, high] = free_motion.table_range();
        let starts_at_rest = free_motion.spin().starts_at_rest();
        let disturbed = starts_at_rest || [displacement, velocity] != [[0.0; 2]; 2];
        Ok(Self {
            max_doublings: if disturbed { 0 } else { max_doublings },
            highest_rate,
            disturbed,
            supports,
            loads: vec![[0.0; 2]; load_count],
            watched: (0..support_count)
                .map(|bearing| WatchedPeak::new(free_motion.constant_load(bearing)))
                .chain(journals)
                .chain((first_monitor..load_count).map(|at| WatchedPeak::new(free_motion.constant_load(at))))
                .chain(machine.diaphragms.iter().map(|d| WatchedPeak::new(d.contact.offset.map(|part| -part))))
                .collect(),
            last_doublings: 0,
            last_contact: None,
            corners: corners(machine, settings.step),
            torsion,
            last_release: None,
            release_speeds: Vec::new(),
            lengths,
            free_motion,
            impulses: Vec::with_capacity(contacts.len()),
            contacts,
            takes_long_steps,
            speed_range: [if starts_at_rest { low } else { low.max(machine.run.end_speed) }, high],
            end: libm::round(machine.run.end_time / settings.step).max(1.0) as u64,
            #[cfg(test)]
            fault: settings.fault,
        })
    }

    /// Whether the rotor's centre is farther from the centre of a ring than the ring's radius: the rotor has left the ring.
    pub fn is_outside(&self) -> bool {
        let is_outside = |(i, contact): (usize, &DiaphragmContact)| {
            contact.stator.is_outside(self.free_motion.contact_displacement(i))
        };
        self.contacts.iter().enumerate().any(is_outside)
    }

    /// Length of a contact step \[s\].
    pub fn contact_step(&self) -> f64 {
        self.lengths[0]
    }

    /// Bearing loads and displacements of journals and monitors at n.
    pub fn loads(&self) -> Loads<'_> {
        let (bearings, others) = self.loads.split_at(self.supports[0]);
        let (pedestals, others) = others.split_at(self.supports[1]);
        let (journals, monitors) = others.split_at(self.supports[2]);
        Loads { bearings, pedestals, journals, monitors }
    }

    /// Whether torques change during the run.
    pub fn torques_change(&self) -> bool {
        self.torsion.is_some()
    }

    /// Whether the run is in its first steps, [`STARTING_STEPS`].
    pub fn is_starting(&self) -> bool {
        self.free_motion.contact_steps() - self.last_release.unwrap_or(0) < STARTING_STEPS
    }

    /// Takes the releases that are awaited in a run of a machine.
    pub fn await_releases(&mut self, releases: &Releases<'_>, machine: &Machine) {
        self.corners = corners(machine, self.lengths[0]);
        self.release_speeds = releases.speeds().collect();
    }

    /// Follows a release at n to a machine with other unbalances: the shaft rings as behind the start.
    pub(super) fn follow_release(&mut self, machine: &Machine) {
        let Self { free_motion, watched, contacts, lengths, .. } = self;
        let loads = watched.len() - contacts.len();
        watched[..loads].iter_mut().enumerate().for_each(|(at, peak)| peak.set_constant(free_motion.constant_load(at)));
        if !self.disturbed {
            self.max_doublings = max_doublings(machine, free_motion, *lengths, self.highest_rate);
        }
        (self.last_release, self.last_doublings) = (Some(free_motion.contact_steps()), 0);
    }

    /// Evaluates the loads at n, and returns the doublings k of the longest step from n that touches nothing and misses no peak;
    /// `None` for a contact step.
    pub fn next_step_doublings(&mut self) -> Option<usize> {
        let doublings = self.free_step_doublings();
        self.last_doublings = doublings.unwrap_or(0);
        doublings
    }

    /// Doublings of the next step of free motion; `None` for a contact step.
    fn free_step_doublings(&mut self) -> Option<usize> {
        // the loads of the last contact step include its impulses
        let in_contact = self.contacts.iter().any(|contact| contact.stator.in_contact());
        if in_contact {
            self.update_load_peaks();
        }
        self.evaluate_loads();
        self.update_load_peaks();
        let Self {
            free_motion,
            contacts,
            watched,
            lengths,
            takes_long_steps,
            max_doublings,
            last_doublings,
            last_contact,
            corners,
            torsion,
            last_release,
            release_speeds,
            end,
            speed_range: [lowest, highest],
            ..
        } = self;
        let peaks = watched.len() - contacts.len();
        let mut is_clear = true;
        for (contact, peak) in contacts.iter_mut().zip(&mut watched[peaks..]) {
            peak.update(contact.update_displacement(free_motion));
            // a place that pressed in the last step will probably press again: the bounds are not worth their time
            is_clear = is_clear && *takes_long_steps && !in_contact && contact.is_within_clearance();
        }
        if !is_clear {
            return None;
        }
        select_peaks(contacts, &mut watched[peaks..]);
        let now = free_motion.contact_steps();
        let passed = corners.partition_point(|corner| *corner <= now);
        let steps_left = corners.get(passed).unwrap_or(end).min(end).saturating_sub(now).max(1);
        let last_event = (*last_contact).max(passed.checked_sub(1).map(|last| corners[last])).max(*last_release);
        // at most twice the last step: the slope of the spin is known over that length
        let max_doublings = match last_event {
            _ if now - last_release.unwrap_or(0) < STARTING_STEPS => 0,
            Some(event) if now - event < RINGING_STEPS => RINGING_DOUBLINGS.min(*max_doublings),
            _ => *max_doublings,
        };
        let max_doublings = match *torsion {
            Some((from, doublings)) if now >= from => doublings.min(max_doublings),
            _ => max_doublings,
        };
        let mut longest =
            max_doublings.min(steps_left.ilog2() as usize).min(SHORT_STEP_DOUBLINGS.max(*last_doublings + 1));
        while longest > SHORT_STEP_DOUBLINGS
            && free_motion.spin().prediction_error(lengths[longest]) > MAX_PREDICTION_ERROR
        {
            longest -= 1;
        }
        // a stop and a release are found to within a contact step
        let speed_now = free_motion.speed();
        let leaves = |longest: usize| {
            let speed = free_motion.spin().speed_after(2.0 * lengths[longest]);
            let passes = |release: &f64| (speed - release) * (speed_now - release) <= 0.0;
            speed <= *lowest || speed >= *highest || release_speeds.iter().any(passes)
        };
        while longest > 0 && leaves(longest) {
            longest -= 1;
        }
        free_motion.bound_states();
        for (i, contact) in contacts.iter().enumerate() {
            let (x, clearance) = contact.clearance;
            let motion = [x, free_motion.bounded_velocity(i)];
            longest = free_motion.longest_step_within(i, lengths, motion, clearance, longest)?;
        }
        Some(free_motion.longest_resolved_step(watched, longest))
    }

    /// Takes the loads at n into the peaks of this run.
    fn update_load_peaks(&mut self) {
        self.watched.iter_mut().zip(&self.loads).for_each(|(peak, load)| peak.update(*load));
    }

    /// Evaluates the loads at n without the contribution of contact impulses at n.
    pub fn evaluate_loads(&mut self) {
        for (bearing, load) in self.loads.iter_mut().enumerate() {
            *load = self.free_motion.load(bearing);
        }
    }

    /// Loads and contact at n of a run that ends there. The state afterwards is that of the end of the step.
    pub fn solve_next_contact(&mut self) {
        self.evaluate_loads();
        if self.step(None).is_err() {
            self.forget_contact();
        }
    }

    /// Forgets the impulses of the last step.
    pub fn forget_contact(&mut self) {
        self.contacts.iter_mut().for_each(|contact| contact.impact = None);
        self.impulses.clear();
    }

    /// Takes a step of 2^k contact steps, or a contact step for `None`, as chosen by [`Transient::next_step_doublings`]. A
    /// contact adds its impulses to the loads at n.
    pub fn step(&mut self, doublings: Option<usize>) -> Result<(), ExponentialError> {
        let Self { free_motion, contacts, impulses, loads, lengths, last_contact, .. } = self;
        contacts.iter_mut().for_each(|contact| contact.begin_step(free_motion));
        impulses.clear();
        if let Some(doublings) = doublings {
            free_motion.advance(doublings)?;
            contacts.iter_mut().for_each(|contact| contact.stator.propagate(doublings, lengths[doublings]));
            return Ok(());
        }
        let h = lengths[0];
        free_motion.propagate(0)?;
        diaphragm_contact::solve(contacts, free_motion)?;
        for (diaphragm, contact) in contacts.iter().enumerate() {
            let Some(contact) = contact.impact.as_ref().map(|impact| impact.contact) else { continue };
            #[cfg(test)]
            let contact = match self.fault {
                Some(Fault::MissingTorque) => ContactImpulse { torque: 0.0, ..contact },
                _ => contact,
            };
            impulses.push(contact);
            *last_contact = Some(free_motion.contact_steps());
            let (force, [u, v]) = (contact.impulse.map(|part| part / h), contact.impulse);
            let corrections = &free_motion.impulse_response(diaphragm).loads;
            for (bearing, (load, correction)) in loads.iter_mut().zip(corrections).enumerate() {
                let direct = free_motion.load_with_feedthrough(bearing, diaphragm, force);
                for i in 0..2 {
                    load[i] += correction[i][0] * u + correction[i][1] * v + direct[i];
                }
            }
        }
        free_motion.complete_step(0, impulses)
    }
}

/// Contacts with the fault that a test injects.
#[cfg(test)]
fn with_fault(mut contacts: Vec<DiaphragmContact>, fault: Option<Fault>) -> Vec<DiaphragmContact> {
    for contact in &mut contacts {
        if let Stator::Ring(ring) = &mut contact.stator.stator {
            ring.fault = fault;
            if fault == Some(Fault::StaticCorrection) {
                ring.reverse_static_correction();
            }
        }
    }
    contacts
}

/// Selects the diaphragms at which peaks of the rotor's displacement limit the step: the one with the largest share of its gap used
/// up so far, and those above [`NEAR_SHARE`]. A diaphragm out of reach therefore changes no step.
fn select_peaks(contacts: &[DiaphragmContact], peaks: &mut [WatchedPeak]) {
    if contacts.len() < 2 {
        return;
    }
    let share = |(contact, peak): (&DiaphragmContact, &WatchedPeak)| {
        peak.largest_square() / (contact.stator.gap() * contact.stator.gap())
    };
    let largest = contacts.iter().zip(&*peaks).map(share).fold(0.0, f64::max);
    for (contact, peak) in contacts.iter().zip(peaks) {
        peak.limits_step = share((contact, peak)) >= largest.min(NEAR_SHARE * NEAR_SHARE);
    }
}

/// Largest number of doublings of a run: steps resolve the turn of the rotor and of its lowest mode (`highest_rate`, \[rad/s\]) and the braking, and keep the torsion stable.
fn max_doublings(
    machine: &Machine,
    free_motion: &FreeMotion,
    lengths: [f64; MAX_DOUBLINGS + 1],
    highest_rate: f64,
) -> usize {
    let resolves_turn = |doublings: &usize| lengths[*doublings] * highest_rate <= MAX_TURN;
    let longest = (SHORT_STEP_DOUBLINGS..=MAX_DOUBLINGS).rev().find(resolves_turn).unwrap_or(SHORT_STEP_DOUBLINGS);
    let braking_rate = free_motion.spin().braking_rate(&machine.braking);
    let is_accurate = |&doublings: &usize| {
        lengths[doublings] * braking_rate <= MAX_BRAKING_CHANGE
            && free_motion.is_stable(doublings, machine.run.end_time)
    };
    (1..=longest).take_while(is_accurate).last().unwrap_or(0)
}

/// Time from which torques change, in contact steps, and the largest number of doublings that resolves the torsion; `None`: no torque changes.
fn torsional_doublings(
    machine: &Machine,
    free_motion: &FreeMotion,
    lengths: [f64; MAX_DOUBLINGS + 1],
) -> Option<(u64, usize)> {
    let first = machine.torques.iter().filter_map(Torque::first_change).reduce(f64::min)?;
    let rate = free_motion.spin().lowest_torsional_rate().max(rate_of_torques(machine));
    let resolves = |doublings: &usize| lengths[*doublings] * rate <= MAX_TORSIONAL_TURN;
    Some((libm::floor(first / lengths[0]) as u64, (1..=MAX_DOUBLINGS).take_while(resolves).last().unwrap_or(0)))
}

/// Highest circular frequency of the torques of short circuits \[rad/s\].
fn rate_of_torques(machine: &Machine) -> f64 {
    let short_circuits = machine.torques.iter().filter_map(|torque| torque.short_circuit);
    short_circuits.map(|short_circuit| 2.0 * short_circuit.frequency).fold(0.0, f64::max)
}

/// Times at which the slope of a prescribed speed changes, and ends of the contact steps in which the slope of a torque does, in contact
/// steps of `h` \[s\].
fn corners(machine: &Machine, h: f64) -> Vec<u64> {
    let times = machine.rotor.speed_law.iter().flat_map(|law| &law.times);
    let mut corners: Vec<u64> = times.filter(|time| **time > 0.0).map(|time| libm::floor(time / h) as u64).collect();
    let of_torques = machine.torques.iter().flat_map(Torque::corners).filter(|time| *time > 0.0);
    corners.extend(of_torques.map(|time| libm::floor(time / h) as u64).flat_map(|corner| [corner, corner + 1]));
    corners.extend(release_steps(machine, h));
    corners.sort_unstable();
    corners
}

/// Peaks of the displacements of journals in bearings with a clearance. Where the clearance limit ends the run, its first excess
/// is found to within a contact step.
fn journal_peaks(machine: &Machine, supports: usize, free_motion: &FreeMotion) -> Vec<WatchedPeak> {
    let limit = &machine.run.limits[Limit::JournalClearance as usize];
    let clearances = machine.rotor.bearings.iter().filter_map(|bearing| bearing.clearance);
    let peak = |(journal, clearance): (usize, f64)| {
        let peak = WatchedPeak::new(free_motion.constant_load(supports + journal));
        match limit.on_exceed {
            OnExceed::Beyond => peak.limited(limit.value * clearance, machine.run.end_beyond),
            OnExceed::Note => peak,
        }
    };
    clearances.enumerate().map(peak).collect()
}

/// Checks that this engine covers the contact of a machine.
///
/// # Errors
/// [`ExponentialError::NotCovered`] with the name of the uncovered property.
fn check_covered(machine: &Machine) -> Result<(), ExponentialError> {
    if !machine.diaphragms.is_empty() && machine.run.force_location != ForceLocation::Next {
        return Err(ExponentialError::NotCovered {
            what: "forces at the place of n (run.force_location = \"current\")",
        });
    }
    let is_held = |diaphragm: &Diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => stator.blades.is_some_and(|blades| blades.count > 0),
        DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => true,
    };
    if !machine.diaphragms.iter().all(is_held) {
        return Err(ExponentialError::NotCovered { what: "a ring that nothing holds" });
    }
    Ok(())
}

#[cfg(test)]
#[path = "transient_tests.rs"]
mod tests;
