//! Check whether the time step resolves the damping of the bearings.
//!
//! ```text
//! x = (dt/2) max eig(C_b R M^-1 R^T)          R: rows of u and v at the bearing's node; c dt/(2 m) for one mass      (1)
//! ```
//! One step of centred damping multiplies a motion that the damping governs by `(1 - x)/(1 + x)`. The scheme is stable for every x, but from `x = 1`
//! on the motion alternates in sign, while the true motion decays within the step. An excitation of the node (a release, an impact) then rings in the
//! bearing load from step to step, up to twice too high.
//! Source: the scheme of `shaft_line::stepper`, on `M q'' + C q' = 0`.
//! Limits: one bearing node at a time; structural damping is not included. It alternates in modes that hardly move a bearing.
//! Verified by `tests/runs/stepping.rs`: `damping_beyond_the_step_is_told`.

use super::shaft_line::{masses, sites};
use crate::rotor::BearingSite;
use crate::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_numerics::linalg::{dot, inverse, mul_vec};

/// A bearing whose damping the step of a run does not resolve.
#[derive(Debug, Clone, PartialEq)]
pub struct UnresolvedDamping {
    /// Name of the bearing, or of the bearing on the pedestal.
    pub bearing: String,
    /// Ratio x of (1), above 1.
    pub ratio: f64,
    /// Largest step with x <= 1 \[s\].
    pub step: f64,
}

/// Bearings whose x of (1) is above 1 in a run with time step `dt` \[s\], in the machine's order.
///
/// `structure` must fit the machine. The check costs one inverse of the lateral mass matrix. The exponential engine integrates damping
/// exactly, so its list is empty.
#[must_use]
pub fn unresolved_damping(machine: &Machine, structure: &Structure, dt: f64) -> Vec<UnresolvedDamping> {
    if machine.run.engine == Engine::Exponential {
        return Vec::new();
    }
    let coordinates = &structure.lateral.coordinates;
    let Some(mobility) = inverse(&masses(structure, &sites(machine)).0) else { return Vec::new() };
    let sites: Vec<&BearingSite> = structure.rotor.supports().collect();
    let rates = sites.iter().map(|site| {
        let rows = site.rows(|place| coordinates.row(place));
        let moved = rows.clone().map(|row| {
            let mut moved = vec![0.0; row.len()];
            mul_vec(&mobility, &row, &mut moved);
            moved
        });
        let s: [[f64; 2]; 2] = std::array::from_fn(|i| std::array::from_fn(|j| dot(&rows[i], &moved[j])));
        let mut c = [[0.0; 2]; 2];
        for other in sites.iter().filter(|other| (other.places, other.base) == (site.places, site.base)) {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                c[i][j] += 0.5 * (other.damping[i][j] + other.damping[j][i]);
            }
        }
        largest_eigenvalue(&c, &s)
    });
    let bearings = &machine.rotor.bearings;
    let names = bearings.iter().map(|bearing| bearing.name.clone());
    let pedestals = bearings.iter().filter(|bearing| bearing.pedestal.is_some());
    let names = names.chain(pedestals.map(|bearing| format!("{} (pedestal)", bearing.name)));
    let unresolved = rates.zip(names).filter(|(rate, _)| 0.5 * dt * rate > 1.0);
    unresolved.map(|(rate, bearing)| UnresolvedDamping { bearing, ratio: 0.5 * dt * rate, step: 2.0 / rate }).collect()
}

/// Largest eigenvalue of the product of two symmetric matrices, of which the second is positive definite.
fn largest_eigenvalue(c: &[[f64; 2]; 2], s: &[[f64; 2]; 2]) -> f64 {
    let product = |i: usize, j: usize| c[i][0] * s[0][j] + c[i][1] * s[1][j];
    let (mean, determinant) =
        (0.5 * (product(0, 0) + product(1, 1)), product(0, 0) * product(1, 1) - product(0, 1) * product(1, 0));
    mean + (mean * mean - determinant).max(0.0).sqrt()
}
