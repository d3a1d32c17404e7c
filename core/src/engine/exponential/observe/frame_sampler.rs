//! Frames of a run for a follower: the motion of rotor and ring at an instant.
//!
//! An instant within a free step is that of a copy of the motion, which takes contact steps: no frame changes the run.

use super::nodal_motion::NodalMotion;
use super::ring_clearance::{RingClearance, ring_clearances};
use crate::engine::exponential::contact::contact_step_result::ContactStepResult;
use crate::engine::exponential::contact::corrected_shape::CorrectedShape;
use crate::engine::exponential::contact::impulsed_ring::ImpulsedRing;
use crate::engine::exponential::plane::length;
use crate::engine::exponential::stepping::diaphragm_contact::DiaphragmContact;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::stepping::transient::Transient;
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::engine::torques::TruncatedTorsion;
use crate::record::{ContactFrame, Energies, Follower, Frame, Loads};
use crate::structure::Structure;
use bladeoff_model::machine::{Diaphragm, Machine};

/// View of one diaphragm and of the rotor in it.
enum StatorView<'a> {
    /// Flexible ring.
    Ring(Box<RingClearance<'a>>),
    /// Stator without degrees of freedom: radial gap, and centre of the rotor from that of the stator \[m\].
    Circle { gap: f64, place: [f64; 2] },
}

/// Sampler of frames.
pub(crate) struct FrameSampler<'a> {
    structure: &'a Structure,
    motion: NodalMotion,
    /// Torsion of the truncated modes under torques over time.
    truncated: TruncatedTorsion,
    /// Lateral velocities of all nodes, in the machine's axes [m/s, rad/s].
    velocity: Vec<f64>,
    /// By diaphragm.
    stators: Vec<StatorView<'a>>,
    /// Contact step \[s\].
    step: f64,
    /// Time \[s\], angle of rotation \[rad\] and spin \[rad/s\] of the sampled instant.
    time: f64,
    angle: f64,
    pub speed: f64,
}

impl<'a> FrameSampler<'a> {
    /// Sampler of a machine's runs.
    pub fn new(machine: &Machine, structure: &'a Structure, transient: &Transient) -> Self {
        let view = |(ring, diaphragm): (Option<RingClearance<'a>>, &Diaphragm)| match ring {
            Some(ring) => StatorView::Ring(Box::new(ring)),
            None => StatorView::Circle { gap: diaphragm.contact.gap, place: [0.0; 2] },
        };
        Self {
            motion: NodalMotion::new(structure, transient.free_motion.spin(), transient.contact_step()),
            truncated: TruncatedTorsion::new(machine, structure),
            velocity: vec![0.0; structure.lateral.coordinates.nodal_size()],
            stators: ring_clearances(machine, structure).into_iter().zip(&machine.diaphragms).map(view).collect(),
            step: transient.contact_step(),
            structure,
            time: 0.0,
            angle: 0.0,
            speed: 0.0,
        }
    }

    /// Samples the present instant of a run.
    pub fn sample(&mut self, transient: &mut Transient) {
        self.take(&mut transient.free_motion);
        for (stator, contact) in self.stators.iter_mut().zip(&transient.contacts) {
            stator.take(contact, None, &transient.free_motion, &transient.impulses);
        }
    }

    /// Takes the motion of the shaft line at an instant.
    fn take(&mut self, free_motion: &mut FreeMotion) {
        (self.time, self.angle, self.speed) = (free_motion.time(), free_motion.angle(), free_motion.speed());
        self.motion.take(free_motion, self.structure);
        self.structure.lateral.coordinates.expand(self.motion.rates(), &mut self.velocity);
    }

    /// Shows the sampled instant, with the loads of bearings and pedestals and, for a contact step, the impacts of the step from it.
    pub fn show(
        &self,
        loads: Loads<'_>,
        contact_step: Option<&Transient>,
        energies: Energies,
        follower: &mut dyn Follower,
    ) {
        let impact = |diaphragm: usize| contact_step.and_then(|step| step.contacts[diaphragm].impact.as_ref());
        let stators = self.stators.iter().enumerate();
        let contacts: Vec<ContactFrame<'_>> =
            stators.map(|(diaphragm, stator)| stator.frame(impact(diaphragm), self.step)).collect();
        follower.see(&Frame {
            time: self.time,
            angle: self.angle,
            speed: self.speed,
            displacement: &self.motion.nodal,
            velocity: &self.velocity,
            torsion_angles: &self.truncated.complete(self.time, &self.motion.torsion_angles),
            bearing_loads: loads.bearings,
            pedestal_loads: loads.pedestals,
            contacts: &contacts,
            energies,
        });
    }
}

impl StatorView<'_> {
    /// Takes an instant. `ahead`: modes of the ring in free motion; `None` where the last impulses are those of the step before.
    fn take(
        &mut self,
        contact: &DiaphragmContact,
        ahead: Option<&ImpulsedRing>,
        free_motion: &FreeMotion,
        impulses: &[ContactImpulse],
    ) {
        let seat = contact.place(free_motion, impulses);
        match (self, contact.stator.ring()) {
            (Self::Ring(clearance), Some(ring)) => {
                let settled = match ahead {
                    None => ring.corrected_shape(seat, free_motion.impulse_response(contact.index())),
                    Some(modes) => {
                        CorrectedShape { amplitudes: modes.amplitudes().to_vec(), pressed: Vec::new(), rotor: seat }
                    }
                };
                clearance.update(seat, &settled);
            }
            (Self::Circle { place, .. }, _) => *place = seat,
            (Self::Ring(_), None) => {}
        }
    }

    /// Contact at the instant that was taken, with the impact of the contact step of `h` \[s\] from it.
    fn frame(&self, impact: Option<&ContactStepResult>, h: f64) -> ContactFrame<'_> {
        let (rotor, gap, angle, ring, field) = match self {
            Self::Ring(ring) => {
                let (gap, angle) = ring.gap.map_or((0.0, 0.0), |gap| (gap.value, gap.place.alpha));
                (ring.place, gap, angle, ring.displacement, Some(ring.field.as_slice()))
            }
            Self::Circle { gap, place } => {
                (*place, gap - length(*place), libm::atan2(place[1], place[0]), [0.0; 2], None)
            }
        };
        ContactFrame {
            rotor,
            gap,
            angle,
            normal_force: impact.map_or(0.0, |impact| impact.normal / h),
            friction_force: impact.map_or(0.0, |impact| impact.tangential / h),
            slip: impact.map_or(0.0, |impact| impact.slip),
            ring,
            field,
        }
    }
}

/// Copy of the motion in a free step, which takes contact steps.
pub(crate) struct MotionAhead {
    pub free_motion: FreeMotion,
    /// Modes of the ring of each diaphragm; `None` without a flexible ring.
    pub rings: Vec<Option<ImpulsedRing>>,
    /// Loads of the bearings, then of the pedestals \[N\].
    loads: Vec<[f64; 2]>,
    /// Number of bearings.
    bearings: usize,
}

impl MotionAhead {
    /// Copy of the motion at the present instant.
    pub fn of(transient: &Transient) -> Self {
        Self {
            free_motion: transient.free_motion.clone(),
            rings: transient.contacts.iter().map(|contact| Some(contact.stator.ring()?.ring.clone())).collect(),
            loads: [transient.loads().bearings, transient.loads().pedestals].concat(),
            bearings: transient.loads().bearings.len(),
        }
    }

    /// Advances to a time in contact steps; `false` where the motion cannot be propagated to it. The run itself is not changed.
    pub fn advance_to(&mut self, time: u64) -> bool {
        let h = self.free_motion.step_length(0);
        let steps: Vec<_> = self.rings.iter().map(|ring| ring.as_ref().map(|ring| ring.propagator(h))).collect();
        while self.free_motion.contact_steps() < time {
            if self.free_motion.advance(0).is_err() {
                return false;
            }
            for (ring, step) in self.rings.iter_mut().flatten().zip(steps.iter().flatten()) {
                ring.propagate(step);
            }
        }
        true
    }

    /// Shows the present instant of the copy.
    pub fn show(
        &mut self,
        transient: &Transient,
        frames: &mut FrameSampler<'_>,
        energies: Energies,
        follower: &mut dyn Follower,
    ) {
        for (bearing, load) in self.loads.iter_mut().enumerate() {
            *load = self.free_motion.load(bearing);
        }
        frames.take(&mut self.free_motion);
        for ((stator, contact), ring) in frames.stators.iter_mut().zip(&transient.contacts).zip(&self.rings) {
            stator.take(contact, ring.as_ref(), &self.free_motion, &[]);
        }
        let (bearings, pedestals) = self.loads.split_at(self.bearings);
        frames.show(Loads { bearings, pedestals, journals: &[], monitors: &[] }, None, energies, follower);
    }
}
