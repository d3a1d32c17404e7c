//! Axial and bending stress of the diaphragm's blades.

use super::fibres::{Fibres, Pairs};
use super::force_columns::ForceColumns;
use crate::structure::{Coordinates, RingPart};
use bladeoff_model::machine::{Blades, FlexibleStator};
use bladeoff_numerics::linalg::Matrix;

/// Recovery of the blade stresses from the coordinates of their ring.
///
/// ```text
/// sigma_b = E (h/2) t,xx              bending: t transverse displacement of the blade, h its tangential thickness
/// sigma   = E (a,x +- (h/2) t,xx)     at the two extreme fibres: a axial displacement, constant strain in an element
/// ```
/// The stresses are evaluated at both ends of every blade element, because the curvature varies linearly in between. Source:
/// Euler-Bernoulli blades of the paper; [`crate::stator`]. Deviation: none; the paper reports no stresses.
///
/// # Units
/// SI.
/// # Limits
/// Nominal: no stress concentration at root or fillet, no centrifugal or steam load, no bending out of the ring's plane. The axial strain
/// is constant in an element, so the inertia of a one-element blade acts at its root only.
/// # Verified by
/// `a_blade_under_a_turned_ring_has_its_textbook_stress`, `a_blade_under_a_tip_load_has_both_stresses`, `tests/runs/stresses.rs`
#[derive(Debug, Clone)]
pub(crate) struct BladeStresses {
    /// Bending stress sigma_b.
    pub(super) bending: Fibres,
    /// Total stress sigma, two fibres per position.
    pub(super) both: Fibres,
    /// Number of fibres of one blade in `both`.
    of_one: usize,
}

impl BladeStresses {
    /// Prepares the stress recovery of a flexible stator; `None` without blades.
    pub(super) fn new(stator: &FlexibleStator, ring: &RingPart, pairs: &Pairs) -> Option<Self> {
        let blades = stator.blades.filter(|blades| blades.count > 0)?;
        let coordinates = &ring.part.coordinates;
        let [bending, both] = columns(stator, &blades, ring, coordinates);
        let nodal =
            ring.residual.as_ref().map(|_| columns(stator, &blades, ring, &Coordinates::nodal(ring.matrices.size())));
        let by_forces = |which: usize| ForceColumns::new(&nodal.as_ref()?[which], ring);
        let modal = coordinates.shapes().is_some();
        Some(Self {
            bending: Fibres::new(&bending, by_forces(0), pairs, modal),
            both: Fibres::new(&both, by_forces(1), pairs, modal),
            of_one: 4 * blades.elements,
        })
    }

    /// Returns the blade of a fibre of [`BladeStresses::both`].
    pub(super) fn blade_of(&self, fibre: usize) -> usize {
        fibre / self.of_one
    }
}

/// Stress per unit coordinate in columns: bending stress alone, and total stress.
fn columns(stator: &FlexibleStator, blades: &Blades, ring: &RingPart, coordinates: &Coordinates) -> [Matrix; 2] {
    let l = blades.length / blades.elements as f64;
    let scale = stator.young_modulus * 0.5 * blades.thickness;
    // second derivatives of the cubic Hermite functions at both ends, for [t1, th1, t2, th2]
    let curvature =
        [[-6.0 / (l * l), -4.0 / l, 6.0 / (l * l), -2.0 / l], [6.0 / (l * l), 2.0 / l, -6.0 / (l * l), 4.0 / l]];
    let (size, places) = (coordinates.size(), 2 * blades.count * blades.elements);
    let (mut bending, mut both) = (Matrix::zeros(size, places), Matrix::zeros(size, 2 * places));
    let mut place = 0;
    for blade in 0..blades.count {
        for element in 0..blades.elements {
            let ends = [0, 1].map(|end| ring.matrices.blade_node(blades, blade, element + end));
            let mut axial = vec![0.0; size];
            for (sign, [along, _, _]) in [-1.0, 1.0].into_iter().zip(&ends) {
                for &(dof, weight) in along {
                    coordinates.add_row(dof, stator.young_modulus / l * sign * weight, &mut axial);
                }
            }
            for end in &curvature {
                let column = &mut bending.as_mut_slice()[place * size..(place + 1) * size];
                for (node, [_, transverse, slope]) in ends.iter().enumerate() {
                    for (freedom, factor) in [(transverse, end[2 * node]), (slope, end[2 * node + 1])] {
                        for &(dof, weight) in freedom {
                            coordinates.add_row(dof, scale * factor * weight, column);
                        }
                    }
                }
                for (row, (axial, bent)) in axial.iter().zip(&*column).enumerate() {
                    both[(row, 2 * place)] = axial + bent;
                    both[(row, 2 * place + 1)] = axial - bent;
                }
                place += 1;
            }
        }
    }
    [bending, both]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stator::{NodalForces, RingMatrices};
    use crate::structure::Part;
    use bladeoff_model::machine::{Rayleigh, Ring};

    fn stator(elements: usize) -> FlexibleStator {
        FlexibleStator {
            young_modulus: 2e11,
            poisson_ratio: 0.3,
            density: 7800.0,
            yield_strength: None,
            ring: Ring { mean_radius: 0.4, thickness: 0.03, width: 0.05, elements: 12 },
            blades: Some(Blades { count: 4, length: 0.3, thickness: 0.02, width: 0.05, elements }),
            damping: Rayleigh::default(),
        }
    }

    fn part(matrices: &RingMatrices, coordinates: Coordinates) -> RingPart {
        let part = Part {
            coordinates,
            mass: matrices.mass.clone(),
            damping: matrices.mass.clone(),
            stiffness: matrices.stiffness.clone(),
            modal: false,
            highest: 0.0,
        };
        RingPart {
            matrices: matrices.clone(),
            part,
            residual: None,
            truncation_errors: Vec::new(),
            engine_cache: Default::default(),
            stress_cache: Default::default(),
        }
    }

    /// The ring rotates by a small angle a as a rigid body: each blade is a cantilever with the tip displacement `R a` and the tip rotation
    /// a.
    #[test]
    fn a_blade_under_a_turned_ring_has_its_textbook_stress() {
        for elements in [1, 3] {
            let stator = stator(elements);
            let matrices = RingMatrices::assemble(&stator);
            let (turn, length, radius) = (1e-3, 0.3, 0.4);
            let mut field = vec![0.0; matrices.size()];
            for node in 0..12 {
                field[4 * node] = radius * turn;
            }
            // static displacements of the inner nodes
            let free: Vec<usize> = (48..matrices.size()).collect();
            if !free.is_empty() {
                let k = Matrix::from_fn(free.len(), free.len(), |i, j| matrices.stiffness[(free[i], free[j])]);
                let f = bladeoff_numerics::linalg::Vector::from_iterator(
                    free.len(),
                    free.iter().map(|&i| -(0..48).map(|j| matrices.stiffness[(i, j)] * field[j]).sum::<f64>()),
                );
                let solution = bladeoff_numerics::linalg::solve(&k, &f).expect("clamped");
                for (value, &i) in solution.iter().zip(&free) {
                    field[i] = *value;
                }
            }
            // foot moment E I/L^2 (6 d + 4 L a), from slope-deflection with the casing end clamped
            let inertia = 0.05 * 0.02f64.powi(3) / 12.0;
            let moment = 2e11 * inertia / (length * length) * (6.0 * radius * turn + 4.0 * length * turn);
            let expected = moment * 0.01 / inertia;
            let largest = |coordinates: Coordinates, q: &[f64]| {
                let ring = part(&matrices, coordinates);
                let mut blades = BladeStresses::new(&stator, &ring, &Pairs::of(&ring.part)).expect("blades");
                blades.bending.largest(q, &NodalForces::none())
            };
            let stress = largest(Coordinates::nodal(matrices.size()), &field);
            assert!((stress / expected - 1.0).abs() < 1e-9, "{stress} {expected}");
            let shapes = Matrix::from_fn(matrices.size(), 2, |i, j| if j == 0 { field[i] } else { 0.0 });
            let stress = largest(Coordinates::modal(&shapes), &[2.0, 5.0]);
            assert!((stress / (2.0 * expected) - 1.0).abs() < 1e-9);
        }
    }
}
