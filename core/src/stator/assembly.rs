//! Assembly of ring and blades.

use super::elements::{blade_element, hermite, ring_element};
use super::sectors::Sectors;
use super::surface::Surface;
use bladeoff_model::machine::{Blades, FlexibleStator};
use bladeoff_numerics::linalg::{EigenError, Matrix};

/// Finite-element matrices of a diaphragm.
#[derive(Debug, Clone, PartialEq)]
pub struct RingMatrices {
    /// Number of ring nodes.
    pub nodes: usize,
    /// Cyclic symmetry: equal sectors from one blade to the next.
    pub sectors: Sectors,
    /// Mass matrix M.
    pub mass: Matrix,
    /// Stiffness matrix K.
    pub stiffness: Matrix,
    /// Coefficient a of the Rayleigh damping C = a M + b K \[1/s\].
    pub mass_proportional: f64,
    /// Coefficient b of the Rayleigh damping \[s\].
    pub stiffness_proportional: f64,
    /// Mean radius of the ring \[m\].
    pub mean_radius: f64,
}

impl RingMatrices {
    /// Assembles a flexible stator. The outer blade nodes are clamped and have no degrees of freedom.
    #[must_use]
    pub fn assemble(stator: &FlexibleStator) -> Self {
        let nodes = stator.ring.elements;
        let blades = stator.blades.filter(|blades| blades.count > 0);
        let (sectors, inside) = blades.map_or((nodes, 0), |blades| (blades.count, blades.elements - 1));
        let size = 4 * nodes + 3 * sectors * inside;
        let mut all = Self {
            nodes,
            sectors: Sectors::new(sectors, nodes, inside),
            mass: Matrix::zeros(size, size),
            stiffness: Matrix::zeros(size, size),
            mass_proportional: stator.damping.mass_proportional,
            stiffness_proportional: stator.damping.stiffness_proportional,
            mean_radius: stator.ring.mean_radius,
        };
        let (mass, stiffness) = ring_element(stator);
        for element in 0..nodes {
            let next = (element + 1) % nodes;
            let place = |k: usize| if k < 4 { 4 * element + k } else { 4 * next + k - 4 };
            for a in 0..8 {
                for b in 0..8 {
                    all.mass[(place(a), place(b))] += mass[(a, b)];
                    all.stiffness[(place(a), place(b))] += stiffness[(a, b)];
                }
            }
        }
        if let Some(blades) = blades {
            all.add_blades(stator, &blades);
        }
        all
    }

    fn add_blades(&mut self, stator: &FlexibleStator, blades: &Blades) {
        let (mass, stiffness) = blade_element(stator, blades);
        for blade in 0..blades.count {
            for element in 0..blades.elements {
                let [near, far] = [0, 1].map(|end| self.blade_node(blades, blade, element + end));
                let places: Vec<Vec<(usize, f64)>> = near.into_iter().chain(far).collect();
                for a in 0..6 {
                    for b in 0..6 {
                        for &(row, wa) in &places[a] {
                            for &(col, wb) in &places[b] {
                                self.mass[(row, col)] += wa * wb * mass[(a, b)];
                                self.stiffness[(row, col)] += wa * wb * stiffness[(a, b)];
                            }
                        }
                    }
                }
            }
        }
    }

    /// Axial (outward) displacement, transverse displacement and slope of a blade node, as combinations `(degree of freedom, weight)`. Node 0 is the
    /// foot on the mean line (9); the last node is clamped at the casing and has no degrees of freedom.
    #[must_use]
    pub fn blade_node(&self, blades: &Blades, blade: usize, node: usize) -> [Vec<(usize, f64)>; 3] {
        if node == 0 {
            let foot = 4 * (blade * self.nodes / blades.count);
            // axial v, transverse u, slope theta_z = u/R - v_s
            [vec![(foot + 2, 1.0)], vec![(foot, 1.0)], vec![(foot, 1.0 / self.mean_radius), (foot + 3, -1.0)]]
        } else if node < blades.elements {
            let inner = 4 * self.nodes + 3 * (blade * (blades.elements - 1) + node - 1);
            [0, 1, 2].map(|k| vec![(inner + k, 1.0)])
        } else {
            [const { Vec::new() }; 3]
        }
    }

    /// All modes, from [`Sectors::modes`].
    ///
    /// # Errors
    /// [`EigenError`].
    pub fn modes(&self) -> Result<(Vec<f64>, Matrix), EigenError> {
        self.sectors.modes(&self.stiffness, &self.mass, "the ring")
    }

    /// Number of degrees of freedom.
    #[must_use]
    pub fn size(&self) -> usize {
        self.mass.nrows()
    }

    /// Contact surface of the ring with radius `R_i` \[m\]. `inner_face`: displacements are those of the inner face,
    /// otherwise those of the mean line.
    #[must_use]
    pub fn surface(&self, contact_radius: f64, inner_face: bool) -> Surface {
        Surface::new(self.nodes, self.mean_radius, contact_radius, inner_face)
    }

    /// Radial displacement v at evenly spaced angles, for the names of modes; `field` has the degrees of freedom.
    #[must_use]
    pub fn radial(&self, field: &[f64], points: usize) -> Vec<f64> {
        let arc = 2.0 * std::f64::consts::PI * self.mean_radius / self.nodes as f64;
        (0..points)
            .map(|k| {
                let place = k as f64 / points as f64 * self.nodes as f64;
                let element = (place as usize).min(self.nodes - 1);
                let [n, _, _] = hermite(place - element as f64, arc);
                let (a, b) = (4 * element, 4 * ((element + 1) % self.nodes));
                n[0] * field[a + 2] + n[1] * field[a + 3] + n[2] * field[b + 2] + n[3] * field[b + 3]
            })
            .collect()
    }
}
