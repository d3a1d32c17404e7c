//! Gyroscopic torques on the torsional modes.
//!
//! ```text
//! G_g   = q'^T S_g q/2                        gyroscopic momentum of site g, about the shaft's axis
//! Y_j   = sum_g row_gj G_g                    its part in torsional mode j; row_gj: angle of the site beside the mean angle, per amplitude      (1)
//! f_j   = -(Y_j(n+1) - Y_j(n))/h              mean torque on the mode over the step                                                             (2)
//! ```
//! The Lagrangian has `sum_g Omega_g G_g` with `Omega_g = W + sum_j row_gj e_j'`, so (1) is the momentum that belongs to `e_j'`, and its change is a torque:
//! -1/2 (theta_u''^T H theta_v - theta_v''^T H^T theta_u) of [`crate::rotor::GyroSite`], integrated once over the step. Differences add up to that of the whole run, so nothing drifts.
//!
//! Source: docs/theory/01-shaft-line.md. Limit: the rate `e_j'` is not in the gyroscopic moments on the lateral motion.
//! Verified by `the_momenta_of_the_torsional_modes_add_up` and `core/tests/torsion.rs`.

use super::eights::Eights;
use super::spin::Spin;
use crate::engine::beginning::projected;
use crate::linalg::lanes::LANES;
use crate::linalg::{Matrix, dot};
use crate::structure::Structure;

/// S of (1) for each torsional mode.
#[derive(Debug, Clone)]
pub(super) struct Gyration {
    /// Coordinates, those up to a multiple of eight, and modes.
    size: usize,
    padded: usize,
    modes: usize,
    /// Half of `sum_g row_gj S_g`, mode after mode.
    halves: Eights,
}

/// Momenta (1) at n, what they have changed by over the last step, and room for a motion.
#[derive(Debug, Clone, Default)]
pub(super) struct Gyrating {
    momenta: Vec<f64>,
    pub changes: Vec<f64>,
    pub places: Vec<f64>,
    pub rates: Vec<f64>,
    products: Vec<f64>,
}

impl Gyration {
    /// Of a structure and its torsional modes.
    pub fn new(structure: &Structure, spin: &Spin) -> Self {
        let rotor = &structure.rotor;
        let rows: Vec<Vec<f64>> = (0..rotor.nodes).map(|node| spin.row_of(structure, node)).collect();
        let size = structure.lateral.coordinates.size();
        let (padded, modes) = (size.next_multiple_of(LANES), rows.first().map_or(0, Vec::len));
        let mut halves = Matrix::zeros(padded * modes, size);
        for j in 0..modes {
            let nodal: Vec<f64> = rows.iter().map(|row| row[j]).collect();
            if nodal.iter().all(|&angle| angle == 0.0) {
                continue;
            }
            let mut dense = Matrix::zeros(rotor.lateral_size(), rotor.lateral_size());
            for site in &rotor.gyro {
                site.add_dense(0.5 * site.mean(&nodal), &mut dense);
            }
            halves.view_mut((padded * j, 0), (size, size)).copy_from(&projected(structure, &dense));
        }
        Self { size, padded, modes, halves: Eights::new(&halves) }
    }

    /// Takes (1) of the motion that `now` has, and what it has changed by.
    pub fn take(&self, now: &mut Gyrating) {
        let Gyrating { momenta, changes, places, rates, products } = now;
        momenta.resize(self.modes, 0.0);
        changes.resize(self.modes, 0.0);
        self.halves.times(&places[..self.size], products);
        let all = momenta.iter_mut().zip(changes.iter_mut()).zip(products.chunks_exact(self.padded));
        for ((momentum, change), product) in all {
            let next = dot(&rates[..], product);
            *change = next - *momentum;
            *momentum = next;
        }
    }
}
