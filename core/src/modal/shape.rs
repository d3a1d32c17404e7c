//! A mode of the damped, spinning rotor, and the similarity of two modes.
//!
//! ```text
//! z = (K^1/2 x, lambda M^1/2 x),   MAC(a, b) = |z_a^H z_b|^2 / (|z_a|^2 |z_b|^2)                              (1)
//! ```
//! (1) is the modal assurance criterion (Allemang 1982) in state space with the energy norm. Without damping, different modes are
//! orthogonal in this norm, with or without gyroscopic effects. With damping, two motions with the same shape still differ by their lambda.

use crate::rotor::RotorMatrices;
use bladeoff_numerics::linalg::{Csr, Matrix, column_of, mul_vec};

/// Similarity (1) above which two modes are the same mode.
pub(super) const CLEAR: f64 = 0.9;

/// A mode `x e^{lambda t}` with complex shape x and eigenvalue lambda.
#[derive(Debug, Clone)]
pub(super) struct Mode {
    /// Eigenvalue lambda as (re, im) \[rad/s\].
    pub value: [f64; 2],
    /// Real part of the shape x.
    re: Vec<f64>,
    /// Imaginary part of the shape x.
    im: Vec<f64>,
    /// K x as real and imaginary part.
    stiff: [Vec<f64>; 2],
    /// M x as real and imaginary part.
    heavy: [Vec<f64>; 2],
    /// Squared norm |z|^2 of (1).
    energy: f64,
}

impl Mode {
    /// Takes the mode shape from a column of the eigenvector matrices.
    pub fn new(value: [f64; 2], real: &Matrix, imaginary: &Matrix, column: usize) -> Self {
        Self::of(value, column_of(real, column).to_vec(), column_of(imaginary, column).to_vec())
    }

    /// Takes the mode shape as real and imaginary part.
    pub fn of(value: [f64; 2], re: Vec<f64>, im: Vec<f64>) -> Self {
        Self { value, re, im, stiff: Default::default(), heavy: Default::default(), energy: 0.0 }
    }

    /// Computes K x, M x and |z|^2, which [`Mode::alike`] needs.
    pub fn weigh(&mut self, stiffness: &Csr, mass: &Csr) {
        let times = |a: &Csr, x: &[f64]| a.products(x).collect::<Vec<f64>>();
        self.stiff = [times(stiffness, &self.re), times(stiffness, &self.im)];
        self.heavy = [times(mass, &self.re), times(mass, &self.im)];
        self.energy = self.product(self)[0];
    }

    /// Scalar product `z_self^H z_other`.
    fn product(&self, other: &Self) -> [f64; 2] {
        let inner = |of: &[Vec<f64>; 2]| {
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            [dot(&self.re, &of[0]) + dot(&self.im, &of[1]), dot(&self.re, &of[1]) - dot(&self.im, &of[0])]
        };
        let (k, m) = (inner(&other.stiff), inner(&other.heavy));
        let ([a, b], [c, d]) = (self.value, other.value);
        // conj(lambda_self) lambda_other
        let (re, im) = (a * c + b * d, a * d - b * c);
        [k[0] + re * m[0] - im * m[1], k[1] + re * m[1] + im * m[0]]
    }

    /// Bilinear form `x_self^T A x_other`, without conjugation.
    pub fn through(&self, matrix: &Matrix, other: &Self) -> [f64; 2] {
        let mut parts = [vec![0.0; other.re.len()], vec![0.0; other.re.len()]];
        mul_vec(matrix, &other.re, &mut parts[0]);
        mul_vec(matrix, &other.im, &mut parts[1]);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let [re, im] = &parts;
        [dot(&self.re, re) - dot(&self.im, im), dot(&self.re, im) + dot(&self.im, re)]
    }

    /// Similarity (1) \[-\]: 1 for the same motion, 0 for orthogonal motions.
    pub fn alike(&self, other: &Self) -> f64 {
        let [re, im] = self.product(other);
        let both = self.energy * other.energy;
        if both > 0.0 { (re * re + im * im) / both } else { 0.0 }
    }

    /// Real and imaginary part of the mode shape.
    pub fn parts(&self) -> [&[f64]; 2] {
        [&self.re, &self.im]
    }

    /// Displacement of one degree of freedom, as (re, im).
    pub fn at(&self, place: usize) -> [f64; 2] {
        [self.re[place], self.im[place]]
    }

    /// Squared norm of the mode shape.
    pub fn size(&self) -> f64 {
        self.re.iter().chain(&self.im).map(|x| x * x).sum()
    }

    /// Returns the forward or backward circular part of the mode shape: `(1 -+ i R)/2 x`. R rotates all nodes by a right angle: `u -> v`,
    /// `v -> -u`, and, as `theta_u = -v,z`, also `theta_v -> -theta_u`.
    pub fn circular(&self, rotor: &RotorMatrices, forward: bool) -> Self {
        let [xz, yz] = rotor.planes();
        let turned = |x: &[f64]| -> Vec<f64> {
            let mut turned = vec![0.0; x.len()];
            for (order, (&u, &v)) in xz.iter().zip(&yz).enumerate() {
                let sign = rotor.turn_sign(order);
                (turned[u], turned[v]) = (-sign * x[v], sign * x[u]);
            }
            turned
        };
        let (re, im) = (turned(&self.re), turned(&self.im));
        let way = if forward { 1.0 } else { -1.0 };
        let part =
            |x: &[f64], other: &[f64], sign: f64| x.iter().zip(other).map(|(x, y)| 0.5 * (x + sign * y)).collect();
        // -i R (a + i b) = R b - i R a
        Self::of(self.value, part(&self.re, &im, way), part(&self.im, &re, -way))
    }
}
