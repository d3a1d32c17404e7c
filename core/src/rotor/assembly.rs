//! Assembly of the matrices of the shaft line.

use super::{BearingSite, GyroSite, shaft_blocks};
use bladeoff_model::machine::{BearingTable, Pedestal, Rotor, RotorKind, Shaft};
use bladeoff_numerics::linalg::Matrix;

/// Largest circular frequency of a pedestal alone between its springs \[rad/s\]. A pedestal with less mass, or massless, gets the mass of
/// this frequency.
const PEDESTAL_RATE: f64 = 1e5;

/// Finite-element matrices of the shaft line, without unbalances, which differ from sample to sample.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorMatrices {
    /// Number of nodes.
    pub nodes: usize,
    /// Lateral degrees of freedom per node in each plane: 2, or 1 for a point mass.
    pub per_plane: usize,
    /// Lateral mass matrix [kg, kg m, kg m2].
    pub mass: Matrix,
    /// Lateral stiffness matrix [N/m, N, N m]: shaft and symmetric part of the bearings.
    pub stiffness: Matrix,
    /// Lateral damping matrix [N s/m, N s, N m s]: structural damping and bearings.
    pub damping: Matrix,
    /// Torsional inertia matrix \[kg m2\].
    pub torsional_mass: Matrix,
    /// Torsional stiffness matrix [N m/rad].
    pub torsional_stiffness: Matrix,
    /// Factor b of the torsional damping `C = b K` \[s\].
    pub torsional_damping: f64,
    /// Axial mass matrix \[kg\].
    pub axial_mass: Matrix,
    /// Axial stiffness matrix \[N/m\].
    pub axial_stiffness: Matrix,
    /// Gyroscopic sites: shaft elements and discs.
    pub gyro: Vec<GyroSite>,
    /// Bearings, in the machine's order.
    pub bearings: Vec<BearingSite>,
    /// Bearing tables (coefficients over the speed) with the index of their bearing. The site in `bearings` has the constant part of its
    /// table.
    pub tables: Vec<(usize, BearingTable)>,
    /// Pedestals on the ground, in the order of the bearings with a pedestal. Their displacements follow after those of all nodes in the
    /// lateral vector, X and Y of each next to each other.
    pub pedestals: Vec<BearingSite>,
    /// Inertia weights of the mean spin `s = j/J_t` \[-\], with `j = M_beta 1` and the total polar inertia J_t.
    pub spin_weights: Vec<f64>,
}

impl RotorMatrices {
    /// Assembles the shaft line of a validated machine.
    #[must_use]
    pub fn assemble(rotor: &Rotor) -> Self {
        let mut matrices = match &rotor.kind {
            RotorKind::Shaft(shaft) => shaft_matrices(shaft, rotor),
            RotorKind::PointMass(point) => {
                let mut empty = Self::empty(1, 1, pedestals(rotor));
                // the two degrees of freedom of the point mass; those of pedestals follow
                [0, 1].into_iter().for_each(|place| empty.mass[(place, place)] = point.mass);
                empty.torsional_mass[(0, 0)] = point.polar_inertia;
                empty.axial_mass[(0, 0)] = point.mass;
                empty
            }
        };
        matrices.add_bearings(rotor);
        let inertia: Vec<f64> = matrices.torsional_mass.row_iter().map(|row| row.sum()).collect();
        let total: f64 = inertia.iter().sum();
        matrices.spin_weights = inertia.iter().map(|j| j / total).collect();
        matrices
    }

    fn empty(nodes: usize, per_plane: usize, pedestals: usize) -> Self {
        let size = 2 * (nodes * per_plane + pedestals);
        let (lateral, single) = (Matrix::zeros(size, size), Matrix::zeros(nodes, nodes));
        Self {
            nodes,
            per_plane,
            mass: lateral.clone(),
            stiffness: lateral.clone(),
            damping: lateral,
            torsional_mass: single.clone(),
            torsional_stiffness: single.clone(),
            torsional_damping: 0.0,
            axial_mass: single.clone(),
            axial_stiffness: single,
            gyro: Vec::new(),
            bearings: Vec::new(),
            tables: Vec::new(),
            pedestals: Vec::new(),
            spin_weights: Vec::new(),
        }
    }

    fn add_bearings(&mut self, rotor: &Rotor) {
        for bearing in &rotor.bearings {
            let k = &bearing.stiffness;
            let site = BearingSite {
                node: bearing.node,
                places: self.plane_places(bearing.node),
                base: bearing.pedestal.map(|_| self.pedestal_places(self.pedestals.len())),
                stiffness: bearing.stiffness,
                skew: 0.5 * (k[0][1] - k[1][0]),
                damping: bearing.damping,
            };
            let cross = 0.5 * (k[0][1] + k[1][0]);
            site.add_to(&[[k[0][0], cross], [cross, k[1][1]]], &mut self.stiffness);
            site.add_to(&site.damping, &mut self.damping);
            self.axial_stiffness[(bearing.node, bearing.node)] += bearing.axial_stiffness;
            if let (Some(pedestal), Some(places)) = (&bearing.pedestal, site.base) {
                self.add_pedestal(pedestal, &site, places);
            }
            if let Some(table) = &bearing.table {
                self.tables.push((self.bearings.len(), table.clone()));
            }
            self.bearings.push(site);
        }
    }

    fn add_pedestal(&mut self, pedestal: &Pedestal, bearing: &BearingSite, places: [usize; 2]) {
        let Pedestal { mass, stiffness: [kx, ky], damping: [cx, cy] } = *pedestal;
        for axis in 0..2 {
            let least =
                (pedestal.stiffness[axis] + bearing.stiffness[axis][axis].abs()) / (PEDESTAL_RATE * PEDESTAL_RATE);
            self.mass[(places[axis], places[axis])] += mass[axis].max(least);
        }
        let site = BearingSite {
            node: bearing.node,
            places,
            base: None,
            stiffness: [[kx, 0.0], [0.0, ky]],
            skew: 0.0,
            damping: [[cx, 0.0], [0.0, cy]],
        };
        site.add_to(&site.stiffness, &mut self.stiffness);
        site.add_to(&site.damping, &mut self.damping);
        self.pedestals.push(site);
    }

    /// Bearings, then pedestals: all springs and dampers outside the shaft.
    pub fn supports(&self) -> impl Iterator<Item = &BearingSite> {
        self.bearings.iter().chain(&self.pedestals)
    }

    /// Indices of X and Y of a pedestal.
    fn pedestal_places(&self, pedestal: usize) -> [usize; 2] {
        [0, 1].map(|axis| 2 * (self.nodes * self.per_plane + pedestal) + axis)
    }

    /// Indices of the degrees of freedom of the XZ plane and of the YZ plane, in the same order.
    #[must_use]
    pub fn planes(&self) -> [Vec<usize>; 2] {
        let (half, size) = (self.nodes * self.per_plane, self.lateral_size());
        [0, 1].map(|axis| (axis * half..(axis + 1) * half).chain((2 * half + axis..size).step_by(2)).collect())
    }

    /// Sign of a degree of freedom under the rotation of the XZ plane into the YZ plane, by its order in [`RotorMatrices::planes`]; -1 for
    /// slopes, as `theta_u = -v,z`.
    #[must_use]
    pub fn turn_sign(&self, order: usize) -> f64 {
        if self.per_plane == 2 && order < 2 * self.nodes && order % 2 == 1 { -1.0 } else { 1.0 }
    }

    /// Number of lateral degrees of freedom.
    #[must_use]
    pub fn lateral_size(&self) -> usize {
        self.mass.nrows()
    }

    /// Index of u of a node in the lateral vector.
    #[inline]
    #[must_use]
    pub fn u(&self, node: usize) -> usize {
        self.per_plane * node
    }

    /// Index of v of a node in the lateral vector.
    #[inline]
    #[must_use]
    pub fn v(&self, node: usize) -> usize {
        self.per_plane * (self.nodes + node)
    }

    /// Index of theta_v of a node; `None` for a point mass.
    #[must_use]
    pub fn theta_v(&self, node: usize) -> Option<usize> {
        (self.per_plane == 2).then(|| self.u(node) + 1)
    }

    /// Index of theta_u of a node; `None` for a point mass.
    #[must_use]
    pub fn theta_u(&self, node: usize) -> Option<usize> {
        (self.per_plane == 2).then(|| self.v(node) + 1)
    }

    /// Indices of u and v of a node.
    #[inline]
    #[must_use]
    pub fn plane_places(&self, node: usize) -> [usize; 2] {
        [self.u(node), self.v(node)]
    }

    /// Returns u and v of a node from a lateral vector.
    #[inline]
    #[must_use]
    pub fn at(&self, node: usize, x: &[f64]) -> [f64; 2] {
        [x[self.u(node)], x[self.v(node)]]
    }

    /// Adds a vector to u and v of a node in a lateral vector.
    #[inline]
    pub fn add_at(&self, node: usize, value: [f64; 2], x: &mut [f64]) {
        x[self.u(node)] += value[0];
        x[self.v(node)] += value[1];
    }

    /// Lateral vector of a uniform translation of all nodes; pedestals and slopes are zero.
    #[must_use]
    pub fn uniform(&self, [x, y]: [f64; 2]) -> Vec<f64> {
        let mut field = vec![0.0; self.lateral_size()];
        for node in 0..self.nodes {
            self.add_at(node, [x, y], &mut field);
        }
        field
    }

    /// Gyroscopic matrix per unit of uniform spin, `sum_g S_g` [kg m2].
    #[must_use]
    pub fn gyroscopic(&self) -> Matrix {
        let mut dense = Matrix::zeros(self.lateral_size(), self.lateral_size());
        for site in &self.gyro {
            site.add_dense(1.0, &mut dense);
        }
        dense
    }

    /// Skew part of the bearing stiffness as a lateral matrix, for linear analyses.
    #[must_use]
    pub fn skew_stiffness(&self) -> Matrix {
        let mut dense = Matrix::zeros(self.lateral_size(), self.lateral_size());
        for bearing in &self.bearings {
            bearing.add_to(&[[0.0, bearing.skew], [-bearing.skew, 0.0]], &mut dense);
        }
        dense
    }

    /// Weight of the rotor in nodal coordinates [N, N m]: `M` times a uniform acceleration. `gravity`: X and Y components \[m/s2\].
    #[must_use]
    pub fn weight(&self, gravity: [f64; 2]) -> Vec<f64> {
        let field = self.uniform(gravity);
        let mut weight = vec![0.0; field.len()];
        bladeoff_numerics::linalg::mul_vec(&self.mass, &field, &mut weight);
        weight
    }
}

/// Assembles shaft elements and discs. Structural damping is `C = a M + b K` with the mass of shaft and discs and the stiffness of the
/// shaft, without bearings (added later) and unbalances. Torsion has its own damping `C = b K`. The spin, a uniform rotation, has no
/// stiffness, and therefore no damping.
fn shaft_matrices(shaft: &Shaft, rotor: &Rotor) -> RotorMatrices {
    let mut all = RotorMatrices::empty(shaft.nodes.len(), 2, pedestals(rotor));
    for (i, element) in shaft.elements.iter().enumerate() {
        let mut blocks = shaft_blocks(element);
        shaft.layers_on(i).for_each(|layer| blocks.add(&shaft_blocks(layer)));
        // the XZ plane has [u, theta_v], the YZ plane [v, -theta_u]
        let (xz, yz) = (all.u(i), all.v(i));
        for (first, signs) in [(xz, [1.0; 4]), (yz, [1.0, -1.0, 1.0, -1.0])] {
            for a in 0..4 {
                for b in 0..4 {
                    let (row, col, sign) = (first + a, first + b, signs[a] * signs[b]);
                    all.mass[(row, col)] += sign * blocks.mass[(a, b)];
                    all.stiffness[(row, col)] += sign * blocks.stiffness[(a, b)];
                }
            }
        }
        for a in 0..2 {
            for b in 0..2 {
                all.torsional_mass[(i + a, i + b)] += blocks.torsional_mass[(a, b)];
                all.torsional_stiffness[(i + a, i + b)] += blocks.torsional_stiffness[(a, b)];
                all.axial_mass[(i + a, i + b)] += blocks.axial_mass[(a, b)];
                all.axial_stiffness[(i + a, i + b)] += blocks.axial_stiffness[(a, b)];
            }
        }
        all.gyro.push(GyroSite::from_plane(i, shaft.nodes.len(), &blocks.gyroscopic));
    }
    for disc in &shaft.discs {
        for first in all.plane_places(disc.node) {
            all.mass[(first, first)] += disc.mass;
            all.mass[(first + 1, first + 1)] += disc.transverse_inertia;
        }
        all.torsional_mass[(disc.node, disc.node)] += disc.polar_inertia;
        all.axial_mass[(disc.node, disc.node)] += disc.mass;
        all.gyro.push(GyroSite::disc(disc.node, shaft.nodes.len(), disc.polar_inertia));
    }
    all.torsional_damping = rotor.torsional_damping;
    all.damping = &all.mass * rotor.damping.mass_proportional + &all.stiffness * rotor.damping.stiffness_proportional;
    all
}

fn pedestals(rotor: &Rotor) -> usize {
    rotor.bearings.iter().filter(|bearing| bearing.pedestal.is_some()).count()
}
