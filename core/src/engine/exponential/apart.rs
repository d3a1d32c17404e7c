//! The stores and works of a run one by one, for who follows it: the row needs the sum of the stores alone ([`super::measured`]).

use super::shape::Shape;
use super::transient::Transient;
use crate::record::Energies;
use crate::structure::Structure;

/// What it takes to tell them apart.
pub(super) struct Apart {
    shape: Shape,
    /// As they were when they were taken last: at a look at what damping takes, or at an instant that is shown.
    pub energies: Energies,
}

impl Apart {
    /// Of a run.
    pub fn new(structure: &Structure, transient: &Transient) -> Self {
        Self {
            shape: Shape::new(structure, transient.flight.spin(), transient.contact_step()),
            energies: Energies::default(),
        }
    }

    /// Takes the stores at n.
    pub fn take_stores(&mut self, transient: &mut Transient, structure: &Structure) {
        let flight = &mut transient.flight;
        self.shape.take(flight, structure);
        let gyroscopic = flight.gyroscopic_momentum();
        let shift = flight.held_back(gyroscopic);
        let model = &flight.shared().grid.model;
        let (q, velocity) = (self.shape.coordinates(), self.shape.rates());
        let [kinetic, strain] = model.system.energies(flight.spin().speed + shift, q, velocity);
        let [turning, twisted] = flight.spin().energies(shift, flight.velocities());
        let ring = transient.contact.as_ref().map_or([0.0; 2], |contact| contact.rub.ring.energies());
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
