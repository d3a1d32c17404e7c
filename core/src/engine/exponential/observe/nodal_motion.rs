//! The motion of all nodes at an instant.

use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::exponential::torsion::spin::Spin;
use crate::linalg::{axpy, dot};
use crate::structure::Structure;

/// Room for it.
pub(crate) struct NodalMotion {
    /// Coordinates and their rates.
    size: usize,
    motion: [Vec<f64>; 2],
    /// Displacements [m, rad] and twists \[rad\] of all nodes.
    pub nodal: Vec<f64>,
    pub twists: Vec<f64>,
    twist_rows: Vec<Vec<f64>>,
    /// What the blow of the last step lacks of those, per unit.
    static_correction: Vec<f64>,
}

impl NodalMotion {
    /// In contact steps of `h` \[s\].
    pub fn new(structure: &Structure, spin: &Spin, h: f64) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let lacking = spin.static_correction(h);
        let twist_rows: Vec<Vec<f64>> = (0..rotor.nodes).map(|node| spin.torsion_row(structure, node)).collect();
        Self {
            size: map.size(),
            motion: Default::default(),
            nodal: vec![0.0; map.nodal_size()],
            twists: vec![0.0; rotor.nodes],
            static_correction: twist_rows
                .iter()
                .map(|row| if lacking.is_empty() { 0.0 } else { dot(row, &lacking) })
                .collect(),
            twist_rows,
        }
    }

    /// Takes the motion of a flight where it is.
    pub fn take(&mut self, flight: &mut FreeMotion, structure: &Structure) {
        flight.lateral_coordinates(&mut self.motion[0]);
        flight.lateral_rates(&mut self.motion[1]);
        structure.lateral.coordinates.expand(&self.motion[0][..self.size], &mut self.nodal);
        flight.spin().torsion_angles(&self.twist_rows, &mut self.twists);
        axpy(flight.spin().impulse_torque(), &self.static_correction, &mut self.twists);
    }

    /// Lateral coordinates.
    pub fn coordinates(&self) -> &[f64] {
        &self.motion[0][..self.size]
    }

    /// Their rates.
    pub fn rates(&self) -> &[f64] {
        &self.motion[1][..self.size]
    }
}
