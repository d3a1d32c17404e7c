//! Frames of a run for a follower: the motion of rotor and ring at an instant.
//!
//! An instant within a free step is that of a copy of the motion, which takes contact steps: no frame changes the run.

use super::nodal_motion::NodalMotion;
use super::ring_clearance::RingClearance;
use crate::engine::exponential::contact::contact_step::ContactStep;
use crate::engine::exponential::contact::contact_step_result::ContactStepResult;
use crate::engine::exponential::contact::corrected_shape::CorrectedShape;
use crate::engine::exponential::contact::impulsed_ring::ImpulsedRing;
use crate::engine::exponential::contact::stator_axes::StatorAxes;
use crate::engine::exponential::plane::length;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::stepping::transient::Transient;
use crate::record::{ContactFrame, Energies, Follower, Frame, Loads};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Stator without degrees of freedom, and the rotor in it.
struct Circle {
    axes: StatorAxes,
    /// Radial gap \[m\].
    gap: f64,
    /// Centre of the rotor from that of the stator \[m\].
    place: [f64; 2],
}

/// Sampler of frames.
pub(crate) struct FrameSampler<'a> {
    structure: &'a Structure,
    motion: NodalMotion,
    /// Lateral velocities of all nodes, in the machine's axes [m/s, rad/s].
    velocity: Vec<f64>,
    ring: Option<RingClearance<'a>>,
    /// `None` with a flexible ring, and without a stator.
    circle: Option<Circle>,
    /// Time \[s\], angle of rotation \[rad\] and spin \[rad/s\] of the sampled instant.
    time: f64,
    angle: f64,
    pub speed: f64,
}

impl<'a> FrameSampler<'a> {
    /// Sampler of a machine's runs.
    pub fn new(machine: &Machine, structure: &'a Structure, transient: &Transient) -> Self {
        Self {
            motion: NodalMotion::new(structure, transient.free_motion.spin(), transient.contact_step()),
            velocity: vec![0.0; structure.lateral.coordinates.nodal_size()],
            ring: RingClearance::new(machine, structure),
            circle: machine.diaphragms.first().filter(|_| structure.rings.iter().flatten().next().is_none()).map(
                |diaphragm| Circle { axes: StatorAxes::new(diaphragm), gap: diaphragm.contact.gap, place: [0.0; 2] },
            ),
            structure,
            time: 0.0,
            angle: 0.0,
            speed: 0.0,
        }
    }

    /// Samples the present instant of a run.
    pub fn sample(&mut self, transient: &mut Transient) {
        let ring = transient.contact.as_ref().and_then(|contact| contact.stator.ring());
        self.take(&mut transient.free_motion, ring.map(|ring| (ring, &ring.ring)), true);
    }

    /// Takes an instant. `is_pressed`: the last impulses are still those of the step before.
    fn take(&mut self, free_motion: &mut FreeMotion, ring: Option<(&ContactStep, &ImpulsedRing)>, is_pressed: bool) {
        (self.time, self.angle, self.speed) = (free_motion.time(), free_motion.angle(), free_motion.speed());
        self.motion.take(free_motion, self.structure);
        self.structure.lateral.coordinates.expand(self.motion.rates(), &mut self.velocity);
        if let Some(circle) = &mut self.circle {
            circle.place = circle.axes.place(free_motion.contact_displacement(0));
        }
        if let (Some(clearance), Some((contact_step, modes))) = (&mut self.ring, ring) {
            let place = contact_step.axes.place(free_motion.contact_displacement(0));
            let settled = if is_pressed {
                contact_step.corrected_shape(place, free_motion.impulse_response())
            } else {
                CorrectedShape { amplitudes: modes.amplitudes().to_vec(), pressed: Vec::new(), rotor: place }
            };
            clearance.update(place, &settled);
        }
    }

    /// Shows the sampled instant, with the loads of bearings and pedestals and the impact of the contact step of `h` \[s\] from it.
    pub fn show(
        &self,
        loads: Loads<'_>,
        impact: Option<(&ContactStepResult, f64)>,
        energies: Energies,
        follower: &mut dyn Follower,
    ) {
        let of_ring = self.ring.as_ref().map(|ring| {
            let (gap, angle) = ring.gap.map_or((0.0, 0.0), |gap| (gap.value, gap.place.alpha));
            (ring.place, gap, angle, ring.displacement, Some(ring.field.as_slice()))
        });
        let of_circle = self.circle.as_ref().map(|Circle { gap, place, .. }| {
            (*place, gap - length(*place), libm::atan2(place[1], place[0]), [0.0; 2], None)
        });
        let contact = of_ring.or(of_circle).map(|(rotor, gap, angle, ring, field)| ContactFrame {
            rotor,
            gap,
            angle,
            normal_force: impact.map_or(0.0, |(impact, h)| impact.normal / h),
            friction_force: impact.map_or(0.0, |(impact, h)| impact.tangential / h),
            slip: impact.map_or(0.0, |(impact, _)| impact.slip),
            ring,
            field,
        });
        follower.see(&Frame {
            time: self.time,
            angle: self.angle,
            speed: self.speed,
            displacement: &self.motion.nodal,
            velocity: &self.velocity,
            torsion_angles: &self.motion.twists,
            bearing_loads: loads.bearings,
            pedestal_loads: loads.pedestals,
            contacts: contact.as_slice(),
            energies,
        });
    }
}

/// Copy of the motion in a free step, which takes contact steps.
pub(crate) struct MotionAhead {
    pub free_motion: FreeMotion,
    pub ring: Option<ImpulsedRing>,
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
            ring: transient.contact.as_ref().and_then(|contact| Some(contact.stator.ring()?.ring.clone())),
            loads: [transient.loads().bearings, transient.loads().pedestals].concat(),
            bearings: transient.loads().bearings.len(),
        }
    }

    /// Advances to a time in contact steps; `false` where the motion cannot be propagated to it. The run itself is not changed.
    pub fn advance_to(&mut self, time: u64) -> bool {
        let step = self.ring.as_ref().map(|ring| ring.propagator(self.free_motion.step_length(0)));
        while self.free_motion.contact_steps() < time {
            if self.free_motion.advance(0).is_err() {
                return false;
            }
            if let (Some(ring), Some(step)) = (&mut self.ring, &step) {
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
        let contact_step = transient.contact.as_ref().and_then(|contact| contact.stator.ring());
        frames.take(&mut self.free_motion, contact_step.zip(self.ring.as_ref()), false);
        let (bearings, pedestals) = self.loads.split_at(self.bearings);
        frames.show(Loads { bearings, pedestals, journals: &[], monitors: &[] }, None, energies, follower);
    }
}
