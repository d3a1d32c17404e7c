//! Gyroscopic terms in the form that is invariant under rotation of the frame.
//!
//! ```text
//! T_gyro = 1/2 sum_g Omega_g (theta_u'^T H_g theta_v - theta_v'^T H_g^T theta_u)      (1)
//! theta_u rows  + Omega_g H theta_v' + 1/2 Omega_g' H theta_v                          (2)
//! theta_v rows  - Omega_g H^T theta_u' - 1/2 Omega_g' H^T theta_u
//! twist rows    + 1/2 (theta_u''^T H theta_v - theta_v''^T H^T theta_u), shared by the site's nodes
//! ```
//! Source: physics.md section 1. Deviation from the paper: its term `Omega theta_u' theta_v` is replaced by the symmetric
//! form, equal to it to third order, because the paper's is not invariant under rotation of the frame.
//! Written with the skew operator `S` of one site, (1) reads `1/2 Omega x'^T S x`, (2) `Omega S x' + 1/2 Omega' S x`.
//! Verified by `the_operator_is_skew`, `forces_are_the_derivative_of_the_energy` and the whirl frequencies of
//! `tests/linear_rotors.rs`.

use crate::linalg::Matrix;

/// One place with polar inertia.
#[derive(Debug, Clone, PartialEq)]
pub enum GyroSite {
    /// Rigid disc at a node; `H = I_p`.
    Disc {
        /// Node.
        node: usize,
        /// Polar inertia [kg m2].
        polar_inertia: f64,
    },
    /// Shaft element between `node` and `node + 1`; rows of H on `[v1, theta_u1, v2, theta_u2]`, columns on
    /// `[u1, theta_v1, u2, theta_v2]`; spin rate: mean of its nodes.
    Element {
        /// Left node.
        node: usize,
        /// H with the signs of both planes.
        h: [[f64; 4]; 4],
    },
}

impl GyroSite {
    /// Site of a shaft element from its plane matrix: `theta_u = -v,z` turns the sign of the deflection rows.
    #[must_use]
    pub fn from_plane(node: usize, plane: &nalgebra::Matrix4<f64>) -> Self {
        let sign = [-1.0, 1.0, -1.0, 1.0];
        let h = std::array::from_fn(|i| std::array::from_fn(|j| sign[i] * plane[(i, j)]));
        GyroSite::Element { node, h }
    }

    /// Spin rate of the site from nodal rates of twist [rad/s] (or its derivative from their derivatives).
    #[must_use]
    pub fn mean(&self, nodal: &[f64]) -> f64 {
        match *self {
            GyroSite::Disc { node, .. } => nodal[node],
            GyroSite::Element { node, .. } => 0.5 * (nodal[node] + nodal[node + 1]),
        }
    }

    /// Adds `torque` to the twist rows of the site's nodes.
    pub fn spread(&self, torque: f64, nodal: &mut [f64]) {
        match *self {
            GyroSite::Disc { node, .. } => nodal[node] += torque,
            GyroSite::Element { node, .. } => {
                nodal[node] += 0.5 * torque;
                nodal[node + 1] += 0.5 * torque;
            }
        }
    }

    /// `y -= S x`, x and y lateral nodal vectors.
    #[inline]
    pub fn subtract_product(&self, x: &[f64], y: &mut [f64]) {
        match *self {
            GyroSite::Disc { node, polar_inertia } => {
                let base = 4 * node;
                y[base + 2] -= polar_inertia * x[base + 3];
                y[base + 3] += polar_inertia * x[base + 2];
            }
            GyroSite::Element { node, ref h } => {
                let x: &[f64; 8] = x[4 * node..4 * node + 8].try_into().expect("an element has two nodes");
                let y: &mut [f64; 8] = (&mut y[4 * node..4 * node + 8]).try_into().expect("two nodes");
                for i in 0..4 {
                    for j in 0..4 {
                        y[U_SET[i]] -= h[i][j] * x[V_SET[j]];
                        y[V_SET[j]] += h[i][j] * x[U_SET[i]];
                    }
                }
            }
        }
    }

    /// `S x` in the site's own freedoms: an element's eight, a disc's four in the first half.
    #[inline]
    pub fn local_product(&self, x: &[f64], product: &mut [f64; 8]) {
        match *self {
            GyroSite::Disc { node, polar_inertia } => {
                product[2] = polar_inertia * x[4 * node + 3];
                product[3] = -polar_inertia * x[4 * node + 2];
            }
            GyroSite::Element { node, ref h } => {
                let x: &[f64; 8] = x[4 * node..4 * node + 8].try_into().expect("an element has two nodes");
                for i in 0..4 {
                    for j in 0..4 {
                        product[U_SET[i]] += h[i][j] * x[V_SET[j]];
                        product[V_SET[j]] -= h[i][j] * x[U_SET[i]];
                    }
                }
            }
        }
    }

    /// Forces (2) from spin rate and its derivative, velocity v, acceleration a and `S x` of [`GyroSite::local_product`];
    /// subtracted from `force`; returns the torque `-1/2 a^T S x` on the site's twist rows.
    #[inline]
    #[must_use]
    pub fn apply(&self, spin: f64, spin_dot: f64, v: &[f64], a: &[f64], product: &[f64; 8], force: &mut [f64]) -> f64 {
        let half = 0.5 * spin_dot;
        match *self {
            GyroSite::Disc { node, polar_inertia } => {
                let base = 4 * node;
                force[base + 2] -= spin * polar_inertia * v[base + 3] + half * product[2];
                force[base + 3] += spin * polar_inertia * v[base + 2] - half * product[3];
                -0.5 * (a[base + 2] * product[2] + a[base + 3] * product[3])
            }
            GyroSite::Element { node, .. } => {
                let mut local = [0.0; 8];
                self.local_product(v, &mut local);
                let span = 4 * node..4 * node + 8;
                let force: &mut [f64; 8] = (&mut force[span.clone()]).try_into().expect("two nodes");
                let a: &[f64; 8] = a[span].try_into().expect("two nodes");
                let mut torque = 0.0;
                for i in 0..8 {
                    force[i] -= spin * local[i] + half * product[i];
                    torque += a[i] * product[i];
                }
                -0.5 * torque
            }
        }
    }

    /// `x^T S y`.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, x: &[f64], y: &[f64]) -> f64 {
        match *self {
            GyroSite::Disc { node, polar_inertia } => {
                let base = 4 * node;
                polar_inertia * (x[base + 2] * y[base + 3] - x[base + 3] * y[base + 2])
            }
            GyroSite::Element { node, ref h } => {
                let x: &[f64; 8] = x[4 * node..4 * node + 8].try_into().expect("an element has two nodes");
                let y: &[f64; 8] = y[4 * node..4 * node + 8].try_into().expect("an element has two nodes");
                let mut sum = 0.0;
                for i in 0..4 {
                    for j in 0..4 {
                        sum += h[i][j] * (x[U_SET[i]] * y[V_SET[j]] - y[U_SET[i]] * x[V_SET[j]]);
                    }
                }
                sum
            }
        }
    }

    /// S as a dense matrix over all lateral degrees of freedom, for linear analyses.
    pub fn add_dense(&self, factor: f64, dense: &mut Matrix) {
        let mut add = |row: usize, col: usize, h: f64| {
            dense[(row, col)] += factor * h;
            dense[(col, row)] -= factor * h;
        };
        match *self {
            GyroSite::Disc { node, polar_inertia } => add(4 * node + 2, 4 * node + 3, polar_inertia),
            GyroSite::Element { node, ref h } => {
                for i in 0..4 {
                    for j in 0..4 {
                        add(4 * node + U_SET[i], 4 * node + V_SET[j], h[i][j]);
                    }
                }
            }
        }
    }
}

/// Places of `[v1, theta_u1, v2, theta_u2]` in the element's eight lateral degrees of freedom.
const U_SET: [usize; 4] = [1, 2, 5, 6];
/// Places of `[u1, theta_v1, u2, theta_v2]`.
const V_SET: [usize; 4] = [0, 3, 4, 7];

#[cfg(test)]
mod tests {
    use super::*;

    fn sites() -> [GyroSite; 2] {
        let plane = nalgebra::Matrix4::from_fn(|i, j| ((i + j) as f64) - 1.3 + (i * j) as f64);
        [GyroSite::from_plane(0, &plane), GyroSite::Disc { node: 1, polar_inertia: 2.5 }]
    }

    #[test]
    fn the_operator_is_skew() {
        let x: Vec<f64> = (0..8).map(|i| f64::from(i * i) - 9.0).collect();
        let y: Vec<f64> = (0..8).map(|i| 3.0 - f64::from(i)).collect();
        for site in sites() {
            assert!(site.bilinear(&x, &x).abs() < 1e-12);
            assert!((site.bilinear(&x, &y) + site.bilinear(&y, &x)).abs() < 1e-12);
            let mut product = vec![0.0; 8];
            site.subtract_product(&y, &mut product);
            let through: f64 = -x.iter().zip(&product).map(|(a, b)| a * b).sum::<f64>();
            assert!((through - site.bilinear(&x, &y)).abs() < 1e-12);
            let mut dense = Matrix::zeros(8, 8);
            site.add_dense(1.0, &mut dense);
            let direct = (nalgebra::DVector::from_vec(x.clone()).transpose() * &dense * nalgebra::DVector::from_vec(y.clone()))[0];
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
