//! Instants of a run as a follower sees them.
//!
//! In flight an instant between two steps is that of a copy which goes on in contact steps: nothing that is seen changes the run.

use super::nodal_motion::NodalMotion;
use super::ring_clearance::RingClearance;
use crate::engine::exponential::contact::contact_step::ContactStep;
use crate::engine::exponential::contact::corrected_shape::CorrectedShape;
use crate::engine::exponential::contact::impact::Impact;
use crate::engine::exponential::contact::impulsed_ring::ImpulsedRing;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::stepping::transient::Transient;
use crate::record::{ContactFrame, Energies, Follower, Frame};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// What it takes to see instants.
pub(crate) struct FrameSampler<'a> {
    structure: &'a Structure,
    motion: NodalMotion,
    velocity: Vec<f64>,
    ring: Option<RingClearance<'a>>,
    time: f64,
    angle: f64,
    pub speed: f64,
}

impl<'a> FrameSampler<'a> {
    pub fn new(machine: &Machine, structure: &'a Structure, transient: &Transient) -> Self {
        Self {
            motion: NodalMotion::new(structure, transient.free_motion.spin(), transient.contact_step()),
            velocity: vec![0.0; structure.lateral.coordinates.nodal_size()],
            ring: RingClearance::new(machine, structure),
            structure,
            time: 0.0,
            angle: 0.0,
            speed: 0.0,
        }
    }

    /// Takes the instant at which a run is.
    pub fn sample(&mut self, transient: &mut Transient) {
        let ring = transient.contact.as_ref().map(|contact| (&contact.contact_step, &contact.contact_step.ring));
        self.take(&mut transient.free_motion, ring, true);
    }

    /// `pressed`: whether the last impulses are still those of the step before.
    fn take(&mut self, flight: &mut FreeMotion, ring: Option<(&ContactStep, &ImpulsedRing)>, pressed: bool) {
        (self.time, self.angle, self.speed) = (flight.time(), flight.angle(), flight.speed());
        self.motion.take(flight, self.structure);
        self.structure.lateral.coordinates.expand(self.motion.rates(), &mut self.velocity);
        if let (Some(eye), Some((rub, modes))) = (&mut self.ring, ring) {
            let place = rub.displacement_in_stator_axes(flight.contact_displacement(0));
            let settled = if pressed {
                rub.corrected_shape(place, flight.impulse_response())
            } else {
                CorrectedShape { amplitudes: modes.amplitudes().to_vec(), pressed: Vec::new(), rotor: place }
            };
            eye.update(place, &settled);
        }
    }

    /// Shows the instant that was taken: loads of the bearings \[N\], and what the contact step of `h` \[s\] from it does.
    pub fn show(
        &self,
        loads: &[[f64; 2]],
        impact: Option<(&Impact, f64)>,
        energies: Energies,
        follower: &mut dyn Follower,
    ) {
        let contact = self.ring.as_ref().map(|ring| ContactFrame {
            rotor: ring.place,
            gap: ring.gap.map_or(0.0, |gap| gap.value),
            angle: ring.gap.map_or(0.0, |gap| gap.place.alpha),
            normal_force: impact.map_or(0.0, |(impact, h)| impact.normal / h),
            friction_force: impact.map_or(0.0, |(impact, h)| impact.tangential / h),
            slip: impact.map_or(0.0, |(impact, _)| impact.slip),
            ring: ring.displacement,
            field: Some(&ring.field),
        });
        follower.see(&Frame {
            time: self.time,
            angle: self.angle,
            speed: self.speed,
            displacement: &self.motion.nodal,
            velocity: &self.velocity,
            twist: &self.motion.twists,
            bearing_loads: loads,
            contacts: contact.as_slice(),
            energies,
        });
    }
}

/// A copy of a run in flight, which goes on in contact steps.
pub(crate) struct MotionAhead {
    pub free_motion: FreeMotion,
    pub ring: Option<ImpulsedRing>,
    loads: Vec<[f64; 2]>,
}

impl MotionAhead {
    pub fn of(transient: &Transient) -> Self {
        Self {
            free_motion: transient.free_motion.clone(),
            ring: transient.contact.as_ref().map(|contact| contact.contact_step.ring.clone()),
            loads: transient.loads().bearings.to_vec(),
        }
    }

    /// Goes on to a time in contact steps; whether it got there. The run itself stands where it was.
    pub fn advance_to(&mut self, ticks: u64) -> bool {
        let step = self.ring.as_ref().map(|ring| ring.propagator(self.free_motion.step_length(0)));
        while self.free_motion.contact_steps() < ticks {
            if self.free_motion.advance(0).is_err() {
                return false;
            }
            if let (Some(ring), Some(step)) = (&mut self.ring, &step) {
                ring.propagate(step);
            }
        }
        true
    }

    /// Shows the instant where it is.
    pub fn show(
        &mut self,
        transient: &Transient,
        eye: &mut FrameSampler<'_>,
        energies: Energies,
        follower: &mut dyn Follower,
    ) {
        for (bearing, load) in self.loads.iter_mut().enumerate() {
            *load = self.free_motion.load(bearing);
        }
        let rub = transient.contact.as_ref().map(|contact| &contact.contact_step);
        eye.take(&mut self.free_motion, rub.zip(self.ring.as_ref()), false);
        eye.show(&self.loads, None, energies, follower);
    }
}
