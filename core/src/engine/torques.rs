//! Torques on the shaft: static torsion at the start of a run, and that of the truncated modes during it.
//!
//! ```text
//! q0      = Phi^T M sum_k T_k(0-) beta_k              torsional coordinates at t = 0                                      (1)
//! beta(t) = Phi q(t) + sum_k T_k(t) r_k               r_k = beta_k - Phi Phi^T M beta_k: torsion of the truncated modes   (2)
//! ```
//! beta_k: static torsion of all nodes per torque at node k ([`crate::rotor::RotorMatrices::static_torsion`]); T_k(0-): torque before t = 0, when the
//! sum of all torques and braking is zero; braking acts like the inertia and causes no torsion. Phi: torsional modes, M: inertia matrix.
//!
//! Source: (2) residual flexibility (MacNeal 1971), as at the contact. It completes torsion angles and moments and does not enter the motion.
//! Limits: truncated modes follow a torque at once. Verified by `core/tests/runs/torques.rs`.

use crate::structure::Structure;
use bladeoff_model::machine::{Machine, Torque};
use bladeoff_numerics::linalg::axpy;
use std::borrow::Cow;

/// Torsional coordinates (1); `None` without torques.
pub(super) fn initial_torsion(machine: &Machine, structure: &Structure) -> Option<Vec<f64>> {
    let mut angles = vec![0.0; structure.rotor.nodes];
    for torque in &machine.torques {
        axpy(torque.before(), &structure.rotor.static_torsion(torque.node), &mut angles);
    }
    (!machine.torques.is_empty()).then(|| structure.torsion.coordinates_of(&structure.rotor.torsional_mass, &angles))
}

/// Torsion of the truncated modes (2). Empty without torques, without truncated modes, and with `run.static_residual = "off"`.
#[derive(Debug, Clone)]
pub(super) struct TruncatedTorsion {
    /// Torques, and r_k of each at all nodes [rad/(N m)].
    parts: Vec<(Torque, Vec<f64>)>,
}

impl TruncatedTorsion {
    pub fn new(machine: &Machine, structure: &Structure) -> Self {
        let (rotor, part) = (&structure.rotor, &structure.torsion);
        let is_truncated = part.coordinates.size() < rotor.nodes && machine.run.static_residual;
        let of = |torque: &Torque| {
            let mut angles = rotor.static_torsion(torque.node);
            let mut kept = vec![0.0; rotor.nodes];
            part.coordinates.expand(&part.coordinates_of(&rotor.torsional_mass, &angles), &mut kept);
            axpy(-1.0, &kept, &mut angles);
            (torque.clone(), angles)
        };
        Self { parts: machine.torques.iter().filter(|_| is_truncated).map(of).collect() }
    }

    /// Torque now \[N m\] and r_k of each.
    pub fn at(&self, time: f64) -> impl Iterator<Item = (f64, &[f64])> {
        self.parts.iter().map(move |(torque, angles)| (torque.at(time), angles.as_slice()))
    }

    /// Torsion angles of all nodes \[rad\] from those of the kept modes.
    pub fn complete<'a>(&self, time: f64, kept: &'a [f64]) -> Cow<'a, [f64]> {
        let mut angles = Cow::Borrowed(kept);
        self.at(time).for_each(|(torque, part)| axpy(torque, part, angles.to_mut()));
        angles
    }
}
