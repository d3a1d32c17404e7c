//! The stores and works of a run one by one, for who follows it: the row needs the sum of the stores alone ([`super::measured`]).

use super::flight::{Flight, Instant};
use super::kicked_ring::KickedRing;
use super::shape::Shape;
use super::transient::Transient;
use crate::record::Energies;
use crate::structure::Structure;

/// What it takes to tell them apart.
pub(super) struct Apart {
    shape: Shape,
    /// As they were when they were taken last: at a look at what damping takes, or at an instant that is shown.
    pub energies: Energies,
    /// Where an instant is shown between two looks: it, and what the twist's damping had taken \[J\].
    pub instant: Instant,
    pub damped: f64,
}

impl Apart {
    /// Of a run.
    pub fn new(structure: &Structure, transient: &Transient) -> Self {
        Self {
            shape: Shape::new(structure, transient.flight.spin(), transient.contact_step()),
            energies: Energies::default(),
            instant: transient.flight.instant(),
            damped: 0.0,
        }
    }

    /// Keeps the instant at which a flight is.
    pub fn keep(&mut self, flight: &Flight) {
        flight.keep(&mut self.instant);
        self.damped = flight.spin().damped();
    }

    /// Takes the stores of a flight and a ring where they are.
    pub fn take_stores(&mut self, flight: &mut Flight, ring: Option<&KickedRing>, structure: &Structure) {
        self.shape.take(flight, structure);
        let gyroscopic = flight.gyroscopic_momentum();
        let shift = flight.held_back(gyroscopic);
        let model = &flight.shared().grid.model;
        let (q, velocity) = (self.shape.coordinates(), self.shape.rates());
        let [kinetic, strain] = model.system.energies(flight.spin().speed + shift, q, velocity);
        let [turning, twisted] = flight.spin().energies(shift, flight.velocities());
        let ring = ring.map_or([0.0; 2], KickedRing::energies);
        self.energies = Energies {
            kinetic: kinetic + turning + ring[0],
            strain: strain + twisted + ring[1],
            gravity: -crate::linalg::dot(model.outputs.weight(), q),
            ..self.energies
        };
    }

    /// Takes the works of a run with these sums.
    pub fn take_works(&mut self, sums: &Energies) {
        let Energies { kinetic, strain, gravity, .. } = self.energies;
        self.energies = Energies { kinetic, strain, gravity, ..*sums };
    }
}
