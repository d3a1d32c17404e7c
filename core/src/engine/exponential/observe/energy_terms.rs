//! Energies of a run one by one, for a follower. The row needs the sum of the stored energies alone ([`super::energy_balance`]).

use super::nodal_motion::NodalMotion;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::stepping::motion_quantities::LateralState;
use crate::engine::exponential::stepping::transient::Transient;
use crate::record::Energies;
use crate::structure::Structure;

/// Stored energies and works, and the motion that they are computed from.
pub(crate) struct EnergyTerms {
    motion: NodalMotion,
    /// Energies when they were last taken: at an observation of the dissipation, or at an instant that is shown \[J\].
    pub energies: Energies,
    /// Motion at an instant that is shown between two observations.
    pub instant: LateralState,
    /// Energy that torsional damping had taken then \[J\].
    pub damped: f64,
}

impl EnergyTerms {
    /// Energies of a run that begins.
    pub fn new(structure: &Structure, transient: &Transient) -> Self {
        Self {
            motion: NodalMotion::new(structure, transient.free_motion.spin(), transient.contact_step()),
            energies: Energies::default(),
            instant: transient.free_motion.instant(),
            damped: 0.0,
        }
    }

    /// Keeps the motion at the present instant.
    pub fn keep(&mut self, free_motion: &FreeMotion) {
        free_motion.copy_instant(&mut self.instant);
        self.damped = free_motion.spin().torsional_dissipation();
    }

    /// Takes the kinetic energy of shaft, spin and rings, the strain energy with that of radial springs \[J\], and the potential of
    /// the weight, at the present instant. `rings`: kinetic and strain energy of the rings.
    pub fn take_stores(&mut self, free_motion: &mut FreeMotion, rings: [f64; 2], spring: f64, structure: &Structure) {
        self.motion.take(free_motion, structure);
        let gyroscopic = free_motion.gyroscopic_momentum();
        let shift = free_motion.gyroscopic_speed_shift(gyroscopic);
        let model = &free_motion.shared().grid.model;
        let (q, velocity) = (self.motion.coordinates(), self.motion.rates());
        let [kinetic, strain] =
            model.state_space.kinetic_and_elastic_energy(free_motion.spin().speed + shift, q, velocity);
        let [turning, twisted] = free_motion.spin().energies(shift, free_motion.unbalance_velocities());
        self.energies = Energies {
            kinetic: kinetic + turning + rings[0],
            strain: strain + free_motion.table_energy(q) + twisted + rings[1] + spring,
            gravity: -bladeoff_numerics::linalg::dot(model.outputs.weight(), q),
            ..self.energies
        };
    }

    /// Takes the works of the sums of a run, beside the stored energies that were taken before.
    pub fn take_works(&mut self, sums: &Energies) {
        let Energies { kinetic, strain, gravity, .. } = self.energies;
        self.energies = Energies { kinetic, strain, gravity, ..*sums };
    }
}
