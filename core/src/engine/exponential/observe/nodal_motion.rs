//! Displacement, velocity and torsion angle of all nodes at an instant.

use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::torsion::spin::Spin;
use crate::structure::Structure;
use bladeoff_numerics::linalg::{axpy, dot};

/// Motion of all nodes of the shaft line.
pub(crate) struct NodalMotion {
    /// Lateral coordinates.
    size: usize,
    /// Lateral coordinates and their rates.
    motion: [Vec<f64>; 2],
    /// Lateral displacements and slopes of all nodes, in the machine's axes [m, rad].
    pub nodal: Vec<f64>,
    /// Torsion angles of all nodes \[rad\].
    pub torsion_angles: Vec<f64>,
    /// Torsion angle of each node per torsional modal coordinate.
    torsional_rows: Vec<Vec<f64>>,
    /// Static correction of each angle per angular impulse of the last step at each diaphragm \[rad/(N m s)\].
    static_corrections: Vec<Vec<f64>>,
}

impl NodalMotion {
    /// Motion of a structure in contact steps of `h` \[s\].
    pub fn new(structure: &Structure, spin: &Spin, h: f64) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let torsional_rows: Vec<Vec<f64>> = (0..rotor.nodes).map(|node| spin.torsion_row(structure, node)).collect();
        Self {
            size: map.size(),
            motion: Default::default(),
            nodal: vec![0.0; map.nodal_size()],
            torsion_angles: vec![0.0; rotor.nodes],
            static_corrections: (0..spin.impulse_torques().len())
                .map(|diaphragm| {
                    let correction = spin.static_correction(diaphragm, h);
                    torsional_rows.iter().map(|row| dot(row, &correction)).collect()
                })
                .collect(),
            torsional_rows,
        }
    }

    /// Takes the motion at the present instant.
    pub fn take(&mut self, free_motion: &mut FreeMotion, structure: &Structure) {
        free_motion.lateral_coordinates(&mut self.motion[0]);
        free_motion.lateral_rates(&mut self.motion[1]);
        structure.lateral.coordinates.expand(&self.motion[0][..self.size], &mut self.nodal);
        free_motion.spin().torsion_angles(&self.torsional_rows, &mut self.torsion_angles);
        for (torque, correction) in free_motion.spin().impulse_torques().iter().zip(&self.static_corrections) {
            axpy(*torque, correction, &mut self.torsion_angles);
        }
    }

    /// Lateral coordinates.
    pub fn coordinates(&self) -> &[f64] {
        &self.motion[0][..self.size]
    }

    /// Rates of the lateral coordinates.
    pub fn rates(&self) -> &[f64] {
        &self.motion[1][..self.size]
    }
}
