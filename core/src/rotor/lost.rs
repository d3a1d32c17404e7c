//! Whether what a rotor loses is there: lost masses against the mass and the inertia at their nodes.
//!
//! ```text
//! 2T = x'^T M x' + psi'^T J psi' + sum m |p'|^2,  p' = (u' - d psi' sin a, v' + d psi' cos a),  m < 0 of a lost mass
//! T > 0 in every motion  <=>  [M_K, M_K, J_K] + sum m B^T B is positive definite,  M_K = ([M^-1]_KK)^-1, J_K alike       (1)
//! one mass after the other:  share = m lambda_max(B A^-1 B^T) < 1,  A: (1) with the added masses and those lost before    (2)
//! one lost mass alone:       share = m/M_k + m d^2/J_t                                                                    (3)
//! ```
//! K are the nodes of the unbalances: of M where they pull, of J those they turn with ([`UnbalanceSite`]). M_k and J_t are what a node has when its neighbours follow as they like, less than the
//! sum of what is lumped there. Of a rigid body (3) says that what is left has a positive moment of inertia about its own centre.
//! Without (1) a torque accelerates against its own direction: a brake drives the rotor. Close to it the frequency of what is left
//! governs the step, and from a share of 0.99 on the rounds of a step need not settle (they contract by `share/(2 - share)` squared at
//! worst), so [`MOST_LOST`] bounds the share.
//! Source: Schur complements of T. Verified by `tests/twist.rs` and the test below.

use super::{UnbalanceSite, shaft_blocks};
use crate::linalg::{Matrix, mul, spd_inverse};
use crate::machine::{Rotor, RotorKind, Shaft};

/// Largest share of what is there that may be lost.
pub const MOST_LOST: f64 = 0.98;

/// A lost mass that is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overdrawn {
    /// Its place in the machine's list of unbalances.
    pub unbalance: usize,
    /// What its node has for it \[kg\].
    pub mass: f64,
    /// Moment of inertia about Z of what it turns with [kg m2].
    pub polar_inertia: f64,
    /// Share (2).
    pub share: f64,
}

/// The first lost mass, in the order of the file, that takes more than [`MOST_LOST`] of what is there; `None` if none does, or if the
/// rotor itself is no positive definite one.
#[must_use]
pub fn overdrawn(rotor: &Rotor) -> Option<Overdrawn> {
    let sites: Vec<UnbalanceSite> = rotor.unbalances.iter().map(UnbalanceSite::new).collect();
    if !sites.iter().any(|site| site.mass < 0.0) {
        return None;
    }
    let places = |node: fn(&UnbalanceSite) -> usize| {
        let mut nodes: Vec<usize> = sites.iter().map(node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    let (nodes, turning) = (places(|site| site.node), places(|site| site.twist_node));
    let (mass, polar) = match &rotor.kind {
        RotorKind::PointMass(point) => {
            (Matrix::from_element(1, 1, point.mass), Matrix::from_element(1, 1, point.polar_inertia))
        }
        RotorKind::Shaft(shaft) => condensed(shaft, &nodes, &turning)?,
    };
    let count = nodes.len();
    let size = 2 * count + turning.len();
    let mut all = Matrix::zeros(size, size);
    for (first, part) in [(0, &mass), (count, &mass), (2 * count, &polar)] {
        all.view_mut((first, first), part.shape()).copy_from(part);
    }
    // B of a site: its velocity along the arm and across it, which needs no phase unless another one stands at the same node
    let rows = |site: &UnbalanceSite| {
        let place = nodes.binary_search(&site.node).unwrap_or(0);
        let turn = 2 * count + turning.binary_search(&site.twist_node).unwrap_or(0);
        let (sin, cos) = libm::sincos(site.phase);
        let mut b = Matrix::zeros(2, size);
        (b[(0, place)], b[(1, count + place)]) = (1.0, 1.0);
        (b[(0, turn)], b[(1, turn)]) = (-site.radius * sin, site.radius * cos);
        (b, [place, turn])
    };
    for site in sites.iter().filter(|site| site.mass > 0.0) {
        let (b, _) = rows(site);
        all += mul(&b.transpose(), &b) * site.mass;
    }
    for (unbalance, site) in sites.iter().enumerate().filter(|(_, site)| site.mass < 0.0) {
        let mobility = spd_inverse(&all)?;
        let (b, places) = rows(site);
        let seen = mul(&mul(&b, &mobility), &b.transpose());
        let (mean, half) = (0.5 * (seen[(0, 0)] + seen[(1, 1)]), 0.5 * (seen[(0, 0)] - seen[(1, 1)]));
        let share = -site.mass * (mean + half.hypot(seen[(0, 1)]));
        if share.is_nan() || share > MOST_LOST {
            let [mass, polar_inertia] = places.map(|at| 1.0 / mobility[(at, at)]);
            return Some(Overdrawn { unbalance, mass, polar_inertia, share });
        }
        all += mul(&b.transpose(), &b) * site.mass;
    }
    None
}

/// M_K of one plane, and J_K of the nodes that turn.
fn condensed(shaft: &Shaft, nodes: &[usize], turning: &[usize]) -> Option<(Matrix, Matrix)> {
    let (mut lateral, mut twist) = (Band::new(2 * shaft.nodes.len()), Band::new(shaft.nodes.len()));
    for (i, element) in shaft.elements.iter().enumerate() {
        let blocks = shaft_blocks(element);
        for a in 0..4 {
            (0..=a).for_each(|b| lateral.add(2 * i + a, 2 * i + b, blocks.mass[(a, b)]));
        }
        for a in 0..2 {
            (0..=a).for_each(|b| twist.add(i + a, i + b, blocks.twist_mass[(a, b)]));
        }
    }
    for disc in &shaft.discs {
        lateral.add(2 * disc.node, 2 * disc.node, disc.mass);
        lateral.add(2 * disc.node + 1, 2 * disc.node + 1, disc.transverse_inertia);
        twist.add(disc.node, disc.node, disc.polar_inertia);
    }
    let deflections: Vec<usize> = nodes.iter().map(|node| 2 * node).collect();
    Some((lateral.condensed(&deflections)?, twist.condensed(turning)?))
}

/// Entries below the diagonal that a row of [`Band`] has.
const BELOW: usize = 3;

/// Lower triangle of a symmetric matrix whose rows reach three places back: a study asks of every sample, so this has to cost
/// nothing beside the matrices of a run.
struct Band(Vec<[f64; BELOW + 1]>);

impl Band {
    fn new(size: usize) -> Self {
        Self(vec![[0.0; BELOW + 1]; size])
    }

    /// Adds to an entry, `row - 3 <= column <= row`.
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.0[row][BELOW + column - row] += value;
    }

    /// `([A^-1]_KK)^-1`; `None` if A is not positive definite.
    fn condensed(mut self, places: &[usize]) -> Option<Matrix> {
        let rows = &mut self.0;
        // A = L L^T in place
        for i in 0..rows.len() {
            for j in i.saturating_sub(BELOW)..=i {
                let mut sum = rows[i][BELOW + j - i];
                for k in i.saturating_sub(BELOW)..j {
                    if k + BELOW >= j {
                        sum -= rows[i][BELOW + k - i] * rows[j][BELOW + k - j];
                    }
                }
                rows[i][BELOW + j - i] = if j < i {
                    sum / rows[j][BELOW]
                } else if sum > 0.0 {
                    sum.sqrt()
                } else {
                    return None;
                };
            }
        }
        // [A^-1]_KK = Y^T Y with L Y = columns K of the unit matrix
        let columns: Vec<Vec<f64>> = places
            .iter()
            .map(|&place| {
                let mut y = vec![0.0; rows.len()];
                for i in place..rows.len() {
                    let mut sum = if i == place { 1.0 } else { 0.0 };
                    for k in i.saturating_sub(BELOW)..i {
                        sum -= rows[i][BELOW + k - i] * y[k];
                    }
                    y[i] = sum / rows[i][BELOW];
                }
                y
            })
            .collect();
        let dot = |i: usize, j: usize| crate::linalg::dot(&columns[i], &columns[j]);
        spd_inverse(&Matrix::from_fn(places.len(), places.len(), dot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::MachineDef;
    use crate::rotor::RotorMatrices;

    #[test]
    fn a_band_is_condensed_as_a_dense_matrix_is() {
        let text = include_str!("../../../studies/machines/lp_turbine.toml");
        let machine = MachineDef::parse("turbine", text).expect("valid").build().expect("valid");
        let RotorKind::Shaft(shaft) = &machine.rotor.kind else { unreachable!("a shaft") };
        let matrices = RotorMatrices::assemble(&machine.rotor);
        let (nodes, turning) = ([0, 3, 4, 9], [1, 3, 5, 8]);
        let (mass, polar) = condensed(shaft, &nodes, &turning).expect("definite");
        let dense = |matrix: &Matrix, places: [usize; 4]| {
            let inverse = spd_inverse(matrix).expect("definite");
            spd_inverse(&Matrix::from_fn(4, 4, |i, j| inverse[(places[i], places[j])])).expect("definite")
        };
        let deflections = nodes.map(|node| matrices.u(node));
        for (ours, dense) in [(mass, dense(&matrices.mass, deflections)), (polar, dense(&matrices.twist_mass, turning))]
        {
            assert!((&ours - &dense).amax() < 1e-11 * dense.amax(), "{ours} {dense}");
        }
    }
}
