//! Energy balance of a run: stored energy, what damping has taken, and the works of contact and braking.
//!
//! ```text
//! stored(t) - stored(0) = work of contact, braking, torques and bearing tables - dissipation                          guarded: energy_error
//! ```
//! Works of contact, of braking, and of the damping of ring and torsion are added in each step. The stored energy and the dissipation of the shaft are quadratic forms of the whole
//! motion: they are evaluated when an observation is due ([`super::observation_schedule`]). Where the impulse at n is not known yet, the observation is completed behind the step.
//! Verified by the balances of `tests/exponential/exponential_run.rs`.

use super::dissipated_energy::{DampingPowers, DissipatedEnergy};
use super::energy_terms::EnergyTerms;
use super::observation_schedule::Due;
use crate::engine::exponential::contact::impulsed_ring::ImpulsedRing;
use crate::engine::exponential::modal::dissipation::DissipationBuffer;
use crate::engine::exponential::stepping::motion_quantities::LateralState;
use crate::engine::exponential::stepping::transient::Transient;
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::record::{Energies, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// An observation at n, to be completed when the impulse at n is known.
pub(crate) struct Pending {
    contact_steps: u64,
    due: Due,
    /// Energy that torsional damping had taken at n \[J\].
    torsional_damping: f64,
}

/// Energy balance of a run.
pub(crate) struct EnergyBalance {
    dissipated: DissipatedEnergy,
    /// Motion at n of a pending observation.
    instant: LateralState,
    /// Energies one by one, where the follower wants them.
    pub terms: Option<Box<EnergyTerms>>,
    dissipation_buffer: DissipationBuffer,
    /// Buffers: modal outputs, coordinates, and their rates.
    outputs: Vec<f64>,
    coordinates: Vec<f64>,
    rates: Vec<f64>,
}

/// Modes of each flexible ring.
fn rings_of(transient: &Transient) -> impl Iterator<Item = &ImpulsedRing> {
    transient.contacts.iter().filter_map(|contact| Some(&contact.stator.ring()?.ring))
}

/// Kinetic and strain energy of rings \[J\].
pub(crate) fn energies_of<'a>(rings: impl Iterator<Item = &'a ImpulsedRing>) -> [f64; 2] {
    rings.map(ImpulsedRing::energies).fold([0.0; 2], |[kinetic, strain], ring| [kinetic + ring[0], strain + ring[1]])
}

/// Energy of the modes of all rings \[J\]; 0 without a ring.
pub(crate) fn ring_energy(transient: &Transient) -> f64 {
    energies_of(rings_of(transient)).iter().sum()
}

impl EnergyBalance {
    /// Balance of a run that begins, in contact steps of `h` \[s\].
    pub fn new(h: f64, transient: &Transient) -> Self {
        Self {
            dissipated: DissipatedEnergy::new(h),
            instant: transient.free_motion.instant(),
            terms: None,
            dissipation_buffer: DissipationBuffer::default(),
            outputs: Vec::new(),
            coordinates: Vec::new(),
            rates: Vec::new(),
        }
    }

    /// Follows a release, which changes the modes.
    pub fn follow_release(&mut self) {
        self.terms = None;
    }

    /// Begins an observation at n: takes the stored energy where a balance is due.
    pub fn begin(&mut self, due: Due, transient: &mut Transient, recorders: &mut Recorders) -> Pending {
        if due.balance {
            let [stored, lateral] = self.stored_energy(transient);
            recorders.energies.now.kinetic = stored;
            recorders.energies.now.lateral = lateral;
        }
        Pending {
            contact_steps: transient.free_motion.contact_steps(),
            due,
            torsional_damping: transient.free_motion.spin().torsional_dissipation(),
        }
    }

    /// Keeps the motion at n, for a pending observation.
    pub fn keep_motion(&mut self, transient: &Transient) {
        transient.free_motion.copy_instant(&mut self.instant);
    }

    /// Completes an observation: the dissipation since the last one by the trapezoidal rule, and the balance.
    ///
    /// `impulses`: the contact impulses at n; the powers are then means of the step behind n. `None` in free motion, but for the first steps and those of a disturbed start: the powers
    /// are those at n.
    pub fn complete(
        &mut self,
        pending: Pending,
        impulses: Option<&[ContactImpulse]>,
        transient: &mut Transient,
        (recorders, machine, structure): (&mut Recorders, &Machine, &Structure),
    ) {
        let Self { dissipated, instant, outputs, dissipation_buffer, .. } = self;
        let Pending { contact_steps, due, torsional_damping: damped } = pending;
        let motion = &mut transient.free_motion;
        let (bearings, whole) = match impulses {
            Some(impulses) => {
                motion.damping_powers_after(instant, impulses, due.dissipation, (outputs, dissipation_buffer))
            }
            None => motion.damping_powers(due.dissipation, outputs),
        };
        let behind = if impulses.is_some() { 0.5 } else { 0.0 };
        let powers = DampingPowers { bearings, whole, behind, damped };
        let now = &mut recorders.energies.now;
        dissipated.add_bearing_losses(contact_steps, &powers, now);
        if !due.dissipation {
            return;
        }
        dissipated.add_losses(contact_steps, powers, now);
        if due.balance {
            recorders.energies.take();
            recorders.judge(machine, structure);
        }
        if let Some(terms) = &mut self.terms {
            terms.take_works(&recorders.energies.now);
        }
    }

    /// Takes the energies at n one by one.
    pub fn take_terms(&mut self, transient: &mut Transient, structure: &Structure) -> &mut EnergyTerms {
        let terms = self.terms.get_or_insert_with(|| Box::new(EnergyTerms::new(structure, transient)));
        let (rings, springs) = (energies_of(rings_of(transient)), spring_energy(transient));
        terms.take_stores(&mut transient.free_motion, rings, springs, structure);
        terms.keep(&transient.free_motion);
        terms
    }

    /// Completes the works of an instant that is shown between two observations, as [`EnergyBalance::complete`] does those of an observation. The balance itself does not change.
    pub fn complete_terms(
        &mut self,
        contact_steps: u64,
        impulses: Option<&[ContactImpulse]>,
        transient: &mut Transient,
        works: Energies,
    ) {
        let Self { outputs, dissipation_buffer, terms, dissipated, .. } = self;
        let Some(terms) = terms else { return };
        let motion = &mut transient.free_motion;
        let powers = match impulses {
            None => DampingPowers::in_free_motion(motion, outputs),
            Some(impulses) => {
                let buffers = (outputs, dissipation_buffer);
                let (bearings, whole) = motion.damping_powers_after(&mut terms.instant, impulses, true, buffers);
                DampingPowers { bearings, whole, behind: 0.5, damped: terms.damped }
            }
        };
        terms.take_works(&dissipated.until(contact_steps, &powers, works));
    }

    /// Energies at an instant of a free step, of a copy of the motion that has gone on to it; `works` are those up to n and of the copy.
    pub fn terms_ahead(
        &mut self,
        contact_steps: u64,
        ahead: &mut super::frame_sampler::MotionAhead,
        structure: &Structure,
        works: Energies,
    ) -> Option<Energies> {
        let Self { outputs, terms, dissipated, .. } = self;
        let terms = terms.as_mut()?;
        let powers = DampingPowers::in_free_motion(&mut ahead.free_motion, outputs);
        terms.take_stores(&mut ahead.free_motion, energies_of(ahead.rings.iter().flatten()), 0.0, structure);
        terms.take_works(&dissipated.until(contact_steps, &powers, works));
        Some(terms.energies)
    }

    /// Energies one by one, as they were taken last; zeros where the follower wants none.
    pub fn energies(&self) -> Energies {
        self.terms.as_ref().map_or_else(Energies::default, |terms| terms.energies)
    }

    /// Kinetic and elastic energy at n \[J\]: of shaft, spin, torsion and stators, and of the lateral motion of shaft and stators alone.
    fn stored_energy(&mut self, transient: &mut Transient) -> [f64; 2] {
        let Self { outputs, coordinates, rates, .. } = self;
        transient.free_motion.lateral_rates(rates);
        let stored = transient.free_motion.stored_energy(rates, coordinates, outputs);
        let motion = &transient.free_motion;
        let shift = motion.gyroscopic_speed_shift(stored.gyroscopic);
        let [turning, twisted] = motion.spin().energies(shift, motion.unbalance_velocities());
        let (ring, spring) = (energies_of(rings_of(transient)), spring_energy(transient));
        let whole = stored.energy
            + (motion.spin().speed + shift) * stored.gyroscopic
            + turning
            + twisted
            + ring[0]
            + ring[1]
            + spring;
        [whole, stored.energy + ring[0] + ring[1] + spring]
    }
}

/// Energy of all radial springs \[J\].
fn spring_energy(transient: &Transient) -> f64 {
    transient.contacts.iter().map(|contact| contact.stator.spring_energy()).fold(0.0, |sum, energy| sum + energy)
}

/// Adds the works of a step. `ring_before`: energy of the rings at n \[J\] where the step was free; damping alone has taken what is missing behind it. Returns the energy behind it.
pub(crate) fn add_works(
    now: &mut Energies,
    is_free: bool,
    ring_before: Option<f64>,
    transient: &Transient,
) -> Option<f64> {
    now.braking = transient.free_motion.spin().braking_work();
    now.drive = transient.free_motion.spin().drive_work();
    now.torques = transient.free_motion.spin().torque_work();
    now.tables = transient.free_motion.table_work();
    for impact in transient.contacts.iter().filter_map(|contact| contact.impact.as_ref()) {
        now.friction += impact.friction_work;
        now.normal += impact.normal_work;
        now.model += impact.model_work;
        now.structure += impact.damped_work;
    }
    if is_free {
        let (before, behind) = (ring_before?, ring_energy(transient));
        now.stator += before - behind;
        Some(behind)
    } else {
        // nothing damps a ring at rest
        let rings = transient.contacts.iter().filter(|contact| contact.stator.has_touched);
        rings.filter_map(|contact| contact.stator.ring()).for_each(|ring| now.stator += ring.ring.step_dissipation());
        None
    }
}
