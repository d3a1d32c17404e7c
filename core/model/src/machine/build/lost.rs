//! Check that lost masses do not exceed the mass and inertia at their nodes.
//!
//! ```text
//! 2T = x'^T M x' + psi'^T J psi' + sum m |p'|^2,  p' = (u' - d psi' sin a, v' + d psi' cos a),  m < 0 of a lost mass
//! T > 0 in every motion  <=>  [M_K, M_K, J_K] + sum m B^T B is positive definite,  M_K = ([M^-1]_KK)^-1, J_K alike       (1)
//! one mass after the other:  share = m lambda_max(B A^-1 B^T) < 1,  A: (1) with the added masses and those lost before    (2)
//! one lost mass alone:       share = m/M_k + m d^2/J_t                                                                    (3)
//! ```
//! K is the set of nodes of the unbalances: of M the nodes at which their forces act, of J those with which they rotate. M_k and J_t are the
//! condensed mass and inertia of a node whose neighbours follow freely, less than the sum lumped there. For a rigid body, (3) requires the
//! remaining body to have a positive moment of inertia about its own centre.
//! Without (1), a torque accelerates against its own direction: a brake drives the rotor. Close to that limit, the frequency of the
//! remaining rotor determines the step, and from a share of 0.99 on the iterations of a step may not converge (their worst contraction is
//! `share/(2 - share)` squared), so [`MOST_LOST`] bounds the share.
//!
//! The file is checked, not the solver: a machine that violates the limit is not built, and the violation is reported together with
//! every other mistake of the file. M and J are the masses of the shaft's elements ([`super::inertia`]).
//! Source: Schur complements of T. Verified by `tests/rotor/lost_masses.rs` of the core, which also compares with the matrices of a run.

use super::factor::Symmetric;
use super::inertia::{element_mass, element_torsional_mass};
use crate::machine::model::{Rotor, RotorKind, Shaft, Unbalance};

/// Largest allowed share of a lost mass in the present mass and inertia \[-\].
pub const MOST_LOST: f64 = 0.98;

/// A lost mass that exceeds the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overdrawn {
    /// Index in the machine's list of unbalances.
    pub unbalance: usize,
    /// Condensed mass of its node \[kg\].
    pub mass: f64,
    /// Condensed moment of inertia about Z of the node it rotates with [kg m2].
    pub polar_inertia: f64,
    /// Share by (2) \[-\].
    pub share: f64,
}

/// The first lost mass, in the order of the file, with a share above the limit [`MOST_LOST`]; `None` if every mass is within the limit, or if the
/// matrices of the rotor itself are not positive definite.
#[must_use]
pub fn overdrawn(rotor: &Rotor) -> Option<Overdrawn> {
    let sites = &rotor.unbalances;
    if !sites.iter().any(|site| site.signed_mass() < 0.0) {
        return None;
    }
    let places = |node: fn(&Unbalance) -> usize| {
        let mut nodes: Vec<usize> = sites.iter().map(node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    let (nodes, turning) = (places(|site| site.node), places(|site| site.torsional_node));
    let (mass, polar) = match &rotor.kind {
        RotorKind::PointMass(point) => (single(point.mass), single(point.polar_inertia)),
        RotorKind::Shaft(shaft) => condensed(shaft, &nodes, &turning)?,
    };
    let count = nodes.len();
    let mut all = Symmetric::dense(2 * count + turning.len());
    for (first, part) in [(0, &mass), (count, &mass), (2 * count, &polar)] {
        for i in 0..part.size() {
            (0..=i).for_each(|j| all.add(first + i, first + j, part.get(i, j)));
        }
    }
    // Rows of B: the velocity of the unbalance mass in X and Y, from the translation and rotation of its nodes.
    let place = |site: &Unbalance| nodes.binary_search(&site.node).unwrap_or(0);
    let turn = |site: &Unbalance| 2 * count + turning.binary_search(&site.torsional_node).unwrap_or(0);
    let rows = |site: &Unbalance| {
        let (place, turn) = (place(site), turn(site));
        let (sin, cos) = libm::sincos(site.phase);
        [[(place, 1.0), (turn, -site.radius * sin)], [(count + place, 1.0), (turn, site.radius * cos)]]
    };
    let add = |all: &mut Symmetric, site: &Unbalance| {
        for [(low, a), (high, b)] in rows(site) {
            for (row, column, value) in [(low, low, a * a), (high, low, a * b), (high, high, b * b)] {
                all.add(row, column, value * site.signed_mass());
            }
        }
    };
    // an added mass with a release may appear after the loss
    let carries = |site: &&Unbalance| site.signed_mass() > 0.0 && site.release.is_none();
    sites.iter().filter(carries).for_each(|site| add(&mut all, site));
    for (unbalance, site) in sites.iter().enumerate().filter(|(_, site)| site.signed_mass() < 0.0) {
        let factor = all.factor()?;
        let columns = rows(site).map(|row| {
            let mut column = vec![0.0; all.size()];
            row.into_iter().for_each(|(at, value)| column[at] = value);
            column
        });
        let seen = factor.between(&columns);
        let (mean, half) = (0.5 * (seen.get(0, 0) + seen.get(1, 1)), 0.5 * (seen.get(0, 0) - seen.get(1, 1)));
        let share = site.mass * (mean + half.hypot(seen.get(1, 0)));
        if share.is_nan() || share > MOST_LOST {
            let mobility = factor.inverse_at([place(site), turn(site)]);
            let [mass, polar_inertia] = [mobility.get(0, 0), mobility.get(1, 1)].map(|mobility| 1.0 / mobility);
            return Some(Overdrawn { unbalance, mass, polar_inertia, share });
        }
        add(&mut all, site);
    }
    None
}

fn single(value: f64) -> Symmetric {
    let mut matrix = Symmetric::dense(1);
    matrix.add(0, 0, value);
    matrix
}

/// M_K of one plane, and J_K of the nodes that rotate with unbalances.
fn condensed(shaft: &Shaft, nodes: &[usize], turning: &[usize]) -> Option<(Symmetric, Symmetric)> {
    let size = shaft.nodes.len();
    let (mut lateral, mut torsion) = (Symmetric::banded(2 * size, 3), Symmetric::banded(size, 1));
    for (i, element) in shaft.elements.iter().enumerate() {
        for part in [element].into_iter().chain(shaft.layers_on(i)) {
            let (mass, torsional_mass) = (element_mass(part), element_torsional_mass(part));
            for a in 0..4 {
                (0..=a).for_each(|b| lateral.add(2 * i + a, 2 * i + b, mass[a][b]));
            }
            for a in 0..2 {
                (0..=a).for_each(|b| torsion.add(i + a, i + b, torsional_mass[a][b]));
            }
        }
    }
    for disc in &shaft.discs {
        lateral.add(2 * disc.node, 2 * disc.node, disc.mass);
        lateral.add(2 * disc.node + 1, 2 * disc.node + 1, disc.transverse_inertia);
        torsion.add(disc.node, disc.node, disc.polar_inertia);
    }
    let held = |matrix: Symmetric, places: Vec<usize>| {
        let count = places.len();
        Some(matrix.factor()?.inverse_at(places).factor()?.inverse_at(0..count))
    };
    Some((held(lateral, nodes.iter().map(|node| 2 * node).collect())?, held(torsion, turning.to_vec())?))
}
