//! Stresses by the static displacement of a ring's truncated modes under the contact forces.
//!
//! ```text
//! sigma_i = sum_j r_ij q_j + sum_d g_id f_d,    G = S (K^-1 - Phi Omega^-2 Phi^T)                                                (1)
//! ```
//! q: amplitudes of the modes kept; f: contact forces on the ring's degrees of freedom \[N, N m\]; S: stress per displacement of a degree of freedom. A contact force is
//! a load on one line of the ring's surface. Curvature and strain beside it converge slowly with the number of modes, displacements do not: with 40 blades the 92 modes kept by default
//! have 99 % of the displacement under a force, and a third of its stress.
//!
//! Source: mode acceleration method (Williams 1945; Rixen, Mech. Syst. Signal Process. 15, 2001). Limits: the truncated modes follow the force at once. No correction where
//! [`RingPart::residual`] is `None`. Verified by `the_residual_completes_the_stresses_of_a_static_load`, `tests/runs/ring_stresses.rs`.

use crate::eight::{Eight, by_width};
use crate::stator::NodalForces;
use crate::structure::RingPart;
use bladeoff_numerics::linalg::lanes::{LANES, Lane};
use bladeoff_numerics::linalg::{Matrix, axpy, column_of};

/// G of (1) for some places.
#[derive(Debug, Clone)]
pub(super) struct ForceColumns {
    /// Column of one degree of freedom after the other, the places of a column by eights.
    entries: Vec<Lane>,
    /// Number of eights of a column.
    lanes: usize,
    /// Largest size of the entries of each column \[Pa/N\].
    pub largest: Vec<f64>,
}

impl ForceColumns {
    /// Columns of places, from their stresses per displacement: one row per degree of freedom of ring and blades, one column per place. `None` without truncated modes.
    pub fn new(nodal: &Matrix, part: &RingPart) -> Option<Self> {
        let residual = part.residual.as_ref()?;
        let lanes = nodal.ncols().div_ceil(LANES);
        let mut entries = vec![Lane::default(); lanes * residual.nrows()];
        let (mut by_force, mut largest) = (vec![0.0; residual.nrows()], vec![0.0_f64; residual.nrows()]);
        for place in 0..nodal.ncols() {
            by_force.fill(0.0);
            for (dof, &stress) in column_of(nodal, place).iter().enumerate().filter(|(_, stress)| **stress != 0.0) {
                // the flexibility is symmetric: its column is also the displacement of this degree of freedom by each force
                axpy(stress, column_of(residual, dof), &mut by_force);
            }
            for (dof, &stress) in by_force.iter().enumerate() {
                entries[dof * lanes + place / LANES].0[place % LANES] = stress;
                largest[dof] = largest[dof].max(stress.abs());
            }
        }
        Some(Self { entries, lanes, largest })
    }

    /// Writes the stresses of all places by forces, by eights \[Pa\].
    pub fn stresses(&self, forces: &NodalForces, sums: &mut Vec<Lane>) {
        sums.clear();
        sums.resize(self.lanes, Lane::default());
        for (dof, force) in forces.iter() {
            add_column(force, &self.entries[dof * self.lanes..][..self.lanes], sums);
        }
    }
}

by_width! {
    /// Adds a column, multiplied by a force.
    fn add_column(force: f64, column: &[Lane], sums: &mut [Lane]) = add_column_in
}

#[inline(always)]
fn add_column_in<V: Eight>(force: f64, column: &[Lane], sums: &mut [Lane]) {
    let force = V::all(force);
    for (sum, entries) in sums.iter_mut().zip(column) {
        (V::load(sum) + V::load(entries) * force).store(sum);
    }
}
