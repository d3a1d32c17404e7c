//! The stores and works of a run one by one, for who follows it: the row needs the sum of the stores alone ([`super::measured`]).

use super::nodal_motion::NodalMotion;
use crate::engine::exponential::contact::impulsed_ring::ImpulsedRing;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::stepping::motion_quantities::Instant;
use crate::engine::exponential::stepping::transient::Transient;
use crate::record::Energies;
use crate::structure::Structure;

/// What it takes to tell them apart.
pub(crate) struct EnergyTerms {
    motion: NodalMotion,
    /// As they were when they were taken last: at a look at what damping takes, or at an instant that is shown.
    pub energies: Energies,
    /// Where an instant is shown between two looks: it, and what the twist's damping had taken \[J\].
    pub instant: Instant,
    pub damped: f64,
}

impl EnergyTerms {
    /// Of a run.
    pub fn new(structure: &Structure, transient: &Transient) -> Self {
        Self {
            motion: NodalMotion::new(structure, transient.free_motion.spin(), transient.contact_step()),
            energies: Energies::default(),
            instant: transient.free_motion.instant(),
            damped: 0.0,
        }
    }

    /// Keeps the instant at which a flight is.
    pub fn keep(&mut self, flight: &FreeMotion) {
        flight.copy_instant(&mut self.instant);
        self.damped = flight.spin().torsional_dissipation();
    }

    /// Takes the stores of a flight and a ring where they are.
    pub fn take_stores(&mut self, flight: &mut FreeMotion, ring: Option<&ImpulsedRing>, structure: &Structure) {
        self.motion.take(flight, structure);
        let gyroscopic = flight.gyroscopic_momentum();
        let shift = flight.gyroscopic_speed_shift(gyroscopic);
        let model = &flight.shared().grid.model;
        let (q, velocity) = (self.motion.coordinates(), self.motion.rates());
        let [kinetic, strain] = model.state_space.kinetic_and_elastic_energy(flight.spin().speed + shift, q, velocity);
        let [turning, twisted] = flight.spin().energies(shift, flight.unbalance_velocities());
        let ring = ring.map_or([0.0; 2], ImpulsedRing::energies);
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
