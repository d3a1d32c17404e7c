//! Instants of a run as a follower sees them.
//!
//! In flight an instant between two steps is that of a copy which goes on in contact steps: nothing that is seen changes the run.

use super::flight::Flight;
use super::impact::Impact;
use super::kicked_ring::KickedRing;
use super::point::Settled;
use super::ring_eye::RingEye;
use super::rub::Rub;
use super::shape::Shape;
use super::transient::Transient;
use crate::record::{ContactFrame, Energies, Follower, Frame};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// What it takes to see instants.
pub(super) struct Eye<'a> {
    structure: &'a Structure,
    shape: Shape,
    velocity: Vec<f64>,
    ring: Option<RingEye<'a>>,
    time: f64,
    angle: f64,
    pub speed: f64,
}

impl<'a> Eye<'a> {
    pub fn new(machine: &Machine, structure: &'a Structure, transient: &Transient) -> Self {
        Self {
            shape: Shape::new(structure, transient.flight.spin(), transient.contact_step()),
            velocity: vec![0.0; structure.lateral.coordinates.nodal_size()],
            ring: RingEye::new(machine, structure),
            structure,
            time: 0.0,
            angle: 0.0,
            speed: 0.0,
        }
    }

    /// Takes the instant at which a run is.
    pub fn look(&mut self, transient: &mut Transient) {
        let ring = transient.contact.as_ref().map(|contact| (&contact.rub, &contact.rub.ring));
        self.take(&mut transient.flight, ring, true);
    }

    /// `pressed`: whether the last impulses are still those of the step before.
    fn take(&mut self, flight: &mut Flight, ring: Option<(&Rub, &KickedRing)>, pressed: bool) {
        (self.time, self.angle, self.speed) = (flight.time(), flight.angle(), flight.speed());
        self.shape.take(flight, self.structure);
        self.structure.lateral.coordinates.expand(self.shape.rates(), &mut self.velocity);
        if let (Some(eye), Some((rub, modes))) = (&mut self.ring, ring) {
            let place = rub.place(flight.place(0));
            let settled = if pressed {
                rub.settled(place, flight.kick())
            } else {
                Settled { amplitudes: modes.amplitudes().to_vec(), pressed: Vec::new(), rotor: place }
            };
            eye.take(place, &settled);
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
            displacement: &self.shape.nodal,
            velocity: &self.velocity,
            twist: &self.shape.twists,
            bearing_loads: loads,
            contacts: contact.as_slice(),
            energies,
        });
    }
}

/// A copy of a run in flight, which goes on in contact steps.
pub(super) struct Ahead {
    pub flight: Flight,
    pub ring: Option<KickedRing>,
    loads: Vec<[f64; 2]>,
}

impl Ahead {
    pub fn of(transient: &Transient) -> Self {
        Self {
            flight: transient.flight.clone(),
            ring: transient.contact.as_ref().map(|contact| contact.rub.ring.clone()),
            loads: transient.loads().bearings.to_vec(),
        }
    }

    /// Goes on to a time in contact steps; whether it got there. The run itself stands where it was.
    pub fn goes_to(&mut self, ticks: u64) -> bool {
        let step = self.ring.as_ref().map(|ring| ring.flight(self.flight.step_of(0)));
        while self.flight.ticks() < ticks {
            if self.flight.advance(0).is_err() {
                return false;
            }
            if let (Some(ring), Some(step)) = (&mut self.ring, &step) {
                ring.fly(step);
            }
        }
        true
    }

    /// Shows the instant where it is.
    pub fn show(&mut self, transient: &Transient, eye: &mut Eye<'_>, energies: Energies, follower: &mut dyn Follower) {
        for (bearing, load) in self.loads.iter_mut().enumerate() {
            *load = self.flight.load(bearing);
        }
        let rub = transient.contact.as_ref().map(|contact| &contact.rub);
        eye.take(&mut self.flight, rub.zip(self.ring.as_ref()), false);
        eye.show(&self.loads, None, energies, follower);
    }
}
