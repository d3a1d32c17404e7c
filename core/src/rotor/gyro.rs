//! Gyroscopic terms in a form that is invariant under rotation of the frame.
//!
//! ```text
//! T_gyro = 1/2 sum_g Omega_g (theta_u'^T H_g theta_v - theta_v'^T H_g^T theta_u)      (1)
//! theta_u rows  + Omega_g H theta_v' + 1/2 Omega_g' H theta_v                          (2)
//! theta_v rows  - Omega_g H^T theta_u' - 1/2 Omega_g' H^T theta_u
//! torsion rows  + 1/2 (theta_u''^T H theta_v - theta_v''^T H^T theta_u), shared by the site's nodes
//! ```
//! Omega_g: spin rate of site g \[rad/s\]; H_g: its polar inertia matrix \[kg m2\]. Source: docs/theory/01-shaft-line.md. Deviation from
//! the paper: its term `Omega theta_u' theta_v` is replaced by the symmetric form, equal to it to third order, because the paper's form is
//! not invariant under rotation of the frame. With the skew operator `S` of a site, (1) is `1/2 Omega x'^T S x` and (2) is
//! `Omega S x' + 1/2 Omega' S x`. Verified by `the_operator_is_skew`, `forces_are_the_derivative_of_the_lagrangian` and the whirl frequencies of
//! `tests/rotor/linear_rotors.rs`.

use bladeoff_numerics::linalg::Matrix;

/// A site with polar inertia. `xz` and `yz`: indices of its degrees of freedom in the lateral vector (plane by plane).
#[derive(Debug, Clone, PartialEq)]
pub enum GyroSite {
    /// Rigid disc at a node; `H = I_p`.
    Disc {
        /// Node.
        node: usize,
        /// Index of theta_v.
        xz: usize,
        /// Index of theta_u.
        yz: usize,
        /// Polar inertia \[kg m2\].
        polar_inertia: f64,
    },
    /// Shaft element between `node` and `node + 1`. Rows of H belong to `[v1, theta_u1, v2, theta_u2]` (from `yz`), columns to
    /// `[u1, theta_v1, u2, theta_v2]` (from `xz`). The spin rate is the mean of the two nodes.
    Element {
        /// Left node.
        node: usize,
        /// Index of u1.
        xz: usize,
        /// Index of v1.
        yz: usize,
        /// H with the signs of both planes [kg, kg m, kg m2].
        h: [[f64; 4]; 4],
    },
}

/// Four successive degrees of freedom of one plane.
#[inline]
fn four(x: &[f64], from: usize) -> &[f64; 4] {
    x[from..from + 4].try_into().expect("an element has four freedoms in a plane")
}

#[inline]
fn four_mut(x: &mut [f64], from: usize) -> &mut [f64; 4] {
    (&mut x[from..from + 4]).try_into().expect("an element has four freedoms in a plane")
}

impl GyroSite {
    /// Site of a shaft element from its plane matrix. As `theta_u = -v,z`, the sign of the deflection rows is reversed.
    #[must_use]
    pub fn from_plane(node: usize, nodes: usize, plane: &nalgebra::Matrix4<f64>) -> Self {
        let sign = [-1.0, 1.0, -1.0, 1.0];
        let h = std::array::from_fn(|i| std::array::from_fn(|j| sign[i] * plane[(i, j)]));
        GyroSite::Element { node, xz: 2 * node, yz: 2 * (nodes + node), h }
    }

    /// Site of a disc.
    #[must_use]
    pub fn disc(node: usize, nodes: usize, polar_inertia: f64) -> Self {
        GyroSite::Disc { node, xz: 2 * node + 1, yz: 2 * (nodes + node) + 1, polar_inertia }
    }

    /// Spin rate of the site from the nodal spin rates \[rad/s\], or its derivative from their derivatives.
    #[inline]
    #[must_use]
    pub fn mean(&self, nodal: &[f64]) -> f64 {
        match *self {
            GyroSite::Disc { node, .. } => nodal[node],
            GyroSite::Element { node, .. } => 0.5 * (nodal[node] + nodal[node + 1]),
        }
    }

    /// Nodes that share the torque of the site, half each; a disc has its node twice.
    #[inline]
    #[must_use]
    pub fn nodes(&self) -> [usize; 2] {
        match *self {
            GyroSite::Disc { node, .. } => [node, node],
            GyroSite::Element { node, .. } => [node, node + 1],
        }
    }

    /// Distributes `torque` \[N m\] to the torsional rows of the site's nodes.
    #[inline]
    pub fn spread(&self, torque: f64, nodal: &mut [f64]) {
        match *self {
            GyroSite::Disc { node, .. } => nodal[node] += torque,
            GyroSite::Element { node, .. } => {
                nodal[node] += 0.5 * torque;
                nodal[node + 1] += 0.5 * torque;
            }
        }
    }

    /// Product `S x` in the site's own degrees of freedom: first the YZ set, then the XZ set (a disc uses entries 0 and 4).
    #[inline]
    pub fn local_product(&self, x: &[f64], product: &mut [f64; 8]) {
        match *self {
            GyroSite::Disc { xz, yz, polar_inertia, .. } => {
                product[0] = polar_inertia * x[xz];
                product[4] = -polar_inertia * x[yz];
            }
            GyroSite::Element { xz, yz, ref h, .. } => {
                let (a, b) = (four(x, xz), four(x, yz));
                for i in 0..4 {
                    product[i] = h[i][0] * a[0] + h[i][1] * a[1] + h[i][2] * a[2] + h[i][3] * a[3];
                    product[4 + i] = -(h[0][i] * b[0] + h[1][i] * b[1] + h[2][i] * b[2] + h[3][i] * b[3]);
                }
            }
        }
    }

    /// Subtracts the forces (2) from `force`; returns the torque `-1/2 a^T S x` on the torsional rows of the site \[N m\]. Arguments: spin
    /// rate and its derivative, velocity v, acceleration a, and `S x` of [`GyroSite::local_product`].
    #[inline]
    #[must_use]
    pub fn apply(&self, spin: f64, spin_dot: f64, v: &[f64], a: &[f64], product: &[f64; 8], force: &mut [f64]) -> f64 {
        let half = 0.5 * spin_dot;
        match *self {
            GyroSite::Disc { xz, yz, polar_inertia, .. } => {
                force[yz] -= spin * polar_inertia * v[xz] + half * product[0];
                force[xz] += spin * polar_inertia * v[yz] - half * product[4];
                -0.5 * (a[yz] * product[0] + a[xz] * product[4])
            }
            GyroSite::Element { xz, yz, .. } => {
                let mut local = [0.0; 8];
                self.local_product(v, &mut local);
                let mut torque = 0.0;
                for (place, from) in [(0, yz), (4, xz)] {
                    let (force, a) = (four_mut(force, from), four(a, from));
                    for i in 0..4 {
                        force[i] -= spin * local[place + i] + half * product[place + i];
                        torque += a[i] * product[place + i];
                    }
                }
                -0.5 * torque
            }
        }
    }

    /// Bilinear form `x^T S y`.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, x: &[f64], y: &[f64]) -> f64 {
        let mut product = [0.0; 8];
        self.local_product(y, &mut product);
        match *self {
            GyroSite::Disc { xz, yz, .. } => x[yz] * product[0] + x[xz] * product[4],
            GyroSite::Element { xz, yz, .. } => {
                let (a, b) = (four(x, xz), four(x, yz));
                (0..4).map(|i| b[i] * product[i] + a[i] * product[4 + i]).sum()
            }
        }
    }

    /// Adds `factor` times S to a dense lateral matrix, for linear analyses.
    pub fn add_dense(&self, factor: f64, dense: &mut Matrix) {
        let mut add = |row: usize, col: usize, h: f64| {
            dense[(row, col)] += factor * h;
            dense[(col, row)] -= factor * h;
        };
        match *self {
            GyroSite::Disc { xz, yz, polar_inertia, .. } => add(yz, xz, polar_inertia),
            GyroSite::Element { xz, yz, ref h, .. } => {
                for i in 0..4 {
                    for j in 0..4 {
                        add(yz + i, xz + j, h[i][j]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sites() -> [GyroSite; 2] {
        let plane = nalgebra::Matrix4::from_fn(|i, j| ((i + j) as f64) - 1.3 + (i * j) as f64);
        [GyroSite::from_plane(0, 2, &plane), GyroSite::disc(1, 2, 2.5)]
    }

    #[test]
    fn the_operator_is_skew() {
        let x: Vec<f64> = (0..8).map(|i| f64::from(i * i) - 9.0).collect();
        let y: Vec<f64> = (0..8).map(|i| 3.0 - f64::from(i)).collect();
        for site in sites() {
            assert!(site.bilinear(&x, &x).abs() < 1e-12);
            assert!((site.bilinear(&x, &y) + site.bilinear(&y, &x)).abs() < 1e-12);
            let mut dense = Matrix::zeros(8, 8);
            site.add_dense(1.0, &mut dense);
            let direct = (nalgebra::DVector::from_vec(x.clone()).transpose()
                * &dense
                * nalgebra::DVector::from_vec(y.clone()))[0];
            assert!((direct - site.bilinear(&x, &y)).abs() < 1e-11);
        }
    }

    #[test]
    fn spreading_is_the_transpose_of_the_mean() {
        for site in sites() {
            let rates = [3.0, 5.0];
            let mut nodal = [0.0; 2];
            site.spread(2.0, &mut nodal);
            assert!((2.0 * site.mean(&rates) - (nodal[0] * rates[0] + nodal[1] * rates[1])).abs() < 1e-14);
        }
    }
}
