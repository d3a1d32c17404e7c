//! The lateral motion of a shaft line as a system of the first order, in its canonical momentum.
//!
//! ```text
//! M q'' + (C + W G) q' + (K + W' G/2) q = F                      M with the unbalances' masses, K with the skew part of the bearings
//! p = M q' + W G q/2                                              canonical momentum of the kinetic energy q'^T M q'/2 + W q'^T G q/2
//! q' = M^-1 (p - W G q/2),   p' = -(C + W G/2) q' - K q + F       no W': where W jumps, q and p do not                     (1)
//! x = (s_q q, s_p p),   s_q = sqrt(K_jj), s_p = 1/sqrt(M_jj)      |x|^2/2 is nearly the energy: conditions are taken in x  (2)
//! ```
//! Source: docs/theory/01-shaft-line.md; the theory page of this engine. Limits: one spin for all gyroscopic sites (the rate of the elastic torsion is
//! not in their rates), coefficients that do not depend on displacements. Verified by `tests/exponential.rs` against the reduced engine.

use crate::engine::beginning::projected;
use crate::engine::shaft_line::{masses, sites};
use crate::linalg::{EigenError, Matrix, column_of, dot, inverse, mul};
use crate::modal::quadratic_modes;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// s_q of a coordinate without stiffness, as a part of the largest.
const LEAST_SCALE: f64 = 1e-6;

/// M, C, G and K of a run in the structure's coordinates.
#[derive(Debug, Clone)]
pub(crate) struct StateSpace {
    /// n.
    pub size: usize,
    pub inverse_mass: Matrix,
    pub damping: Matrix,
    pub stiffness: Matrix,
    pub gyroscopic: Matrix,
    mass: Matrix,
    gyration: GyroscopicProducts,
    /// (s_q, s_p) of (2).
    scale: Vec<f64>,
}

/// `M^-1 G`, `C M^-1 G` and `G M^-1 G`.
#[derive(Debug, Clone)]
struct GyroscopicProducts {
    of_mass: Matrix,
    of_damping: Matrix,
    of_both: Matrix,
}

/// An eigenvector of (1) in the coordinates (2), of length 1; of conjugates the one with `Im lambda > 0`.
#[derive(Debug, Clone)]
pub(crate) struct EigenMotion {
    pub real: Vec<f64>,
    /// `None` of a real eigenvalue.
    pub imaginary: Option<Vec<f64>>,
}

impl StateSpace {
    /// Of a machine; `None` where the mass is singular.
    pub fn new(machine: &Machine, structure: &Structure) -> Option<Self> {
        let part = &structure.lateral;
        let (mass, _) = masses(structure, &sites(machine));
        let stiffness = &part.stiffness + projected(structure, &structure.rotor.skew_stiffness());
        let size = part.coordinates.size();
        let largest = (0..size).map(|j| stiffness[(j, j)].abs().sqrt()).fold(0.0, f64::max);
        let least = if largest > 0.0 { LEAST_SCALE * largest } else { 1.0 };
        let of_places = (0..size).map(|j| stiffness[(j, j)].abs().sqrt().max(least));
        let of_momenta = (0..size).map(|j| 1.0 / mass[(j, j)].sqrt());
        let inverse_mass = inverse(&mass)?;
        let gyroscopic = projected(structure, &structure.rotor.gyroscopic());
        let of_mass = mul(&inverse_mass, &gyroscopic);
        let (of_damping, of_both) = (mul(&part.damping, &of_mass), mul(&gyroscopic, &of_mass));
        Some(Self {
            size,
            inverse_mass,
            damping: part.damping.clone(),
            gyroscopic,
            gyration: GyroscopicProducts { of_mass, of_damping, of_both },
            scale: of_places.chain(of_momenta).collect(),
            stiffness,
            mass,
        })
    }

    /// `(q, q')` of x at a spin.
    pub fn motion_of_state(&self, spin: f64) -> Matrix {
        let n = self.size;
        let mut map = Matrix::zeros(2 * n, 2 * n);
        map.view_mut((0, 0), (n, n)).fill_with_identity();
        map.view_mut((n, 0), (n, n)).copy_from(&(&self.gyration.of_mass * (-0.5 * spin)));
        map.view_mut((n, n), (n, n)).copy_from(&self.inverse_mass);
        for (j, scale) in self.scale.iter().enumerate() {
            map.column_mut(j).scale_mut(1.0 / scale);
        }
        map
    }

    /// Kinetic and strain energy of a motion at a spin, the gyroscopic part included \[J\].
    pub fn kinetic_and_elastic_energy(&self, spin: f64, q: &[f64], velocity: &[f64]) -> [f64; 2] {
        let mut sums = [0.0; 3];
        for j in 0..self.size {
            let columns = [&self.mass, &self.stiffness, &self.gyroscopic].map(|m| column_of(m, j));
            sums[0] += velocity[j] * dot(columns[0], velocity);
            sums[1] += q[j] * dot(columns[1], q);
            sums[2] += q[j] * dot(columns[2], velocity);
        }
        [0.5 * (sums[0] + spin * sums[2]), 0.5 * sums[1]]
    }

    /// K and M.
    pub fn energy_matrices(&self) -> [&Matrix; 2] {
        [&self.stiffness, &self.mass]
    }

    /// Jump of the rates by an impulse in coordinates.
    pub fn state_jump(&self, impulse: &[f64]) -> Vec<f64> {
        (0..self.size).map(|i| (0..self.size).map(|j| self.inverse_mass[(i, j)] * impulse[j]).sum()).collect()
    }

    /// x of `(q, q')` at a spin.
    pub fn state_of_motion(&self, spin: f64, q: &[f64], velocity: &[f64]) -> Vec<f64> {
        let n = self.size;
        let momentum = |i: usize| -> f64 {
            (0..n).map(|j| self.mass[(i, j)] * velocity[j] + 0.5 * spin * self.gyroscopic[(i, j)] * q[j]).sum()
        };
        (0..n).map(|i| self.scale[i] * q[i]).chain((0..n).map(|i| self.scale[n + i] * momentum(i))).collect()
    }

    /// A of `x' = A x` at a spin.
    pub fn system_matrix(&self, spin: f64) -> Matrix {
        let n = self.size;
        let mut rates = Matrix::zeros(2 * n, 2 * n);
        rates.view_mut((0, n), (n, n)).fill_with_identity();
        rates.view_mut((n, 0), (n, n)).copy_from(&-&self.stiffness);
        rates.view_mut((n, n), (n, n)).copy_from(&(&self.gyroscopic * (-0.5 * spin) - &self.damping));
        let mut a = mul(&rates, &self.motion_of_state(spin));
        for (i, scale) in self.scale.iter().enumerate() {
            a.row_mut(i).scale_mut(*scale);
        }
        a
    }

    /// What A changes by from one spin to another.
    pub fn system_matrix_change(&self, from: f64, to: f64) -> Matrix {
        let n = self.size;
        let half = 0.5 * (to - from);
        let GyroscopicProducts { of_mass, of_damping, of_both } = &self.gyration;
        let mut change = Matrix::zeros(2 * n, 2 * n);
        change.view_mut((0, 0), (n, n)).copy_from(&(of_mass * -half));
        change.view_mut((n, 0), (n, n)).copy_from(&(of_damping * half + of_both * (half * 0.5 * (to + from))));
        // G is skew, M symmetric
        change.view_mut((n, n), (n, n)).copy_from(&(of_mass.transpose() * half));
        for (j, scale) in self.scale.iter().enumerate() {
            change.column_mut(j).scale_mut(1.0 / scale);
            change.row_mut(j).scale_mut(*scale);
        }
        change
    }

    /// What a force in coordinates adds to x'.
    pub fn input_vector(&self, force: &[f64]) -> Vec<f64> {
        let momenta = &self.scale[self.size..];
        std::iter::repeat_n(0.0, self.size).chain(momenta.iter().zip(force).map(|(s, f)| s * f)).collect()
    }

    /// Every motion at a spin: `2n` real dimensions in all.
    ///
    /// # Errors
    /// [`EigenError`].
    pub fn eigen_motions(&self, spin: f64) -> Result<Vec<EigenMotion>, EigenError> {
        let damping = &self.damping + &self.gyroscopic * spin;
        let modes = quadratic_modes(&self.mass, &damping, &self.stiffness, "whirl at one speed")?;
        let n = self.size;
        let mut motions = Vec::with_capacity(2 * n);
        for (j, &[decay, turn]) in modes.values.iter().enumerate() {
            if turn < 0.0 {
                continue;
            }
            let (x, y) = (modes.real.column(j), modes.imaginary.column(j));
            let (a, b) = (x.as_slice(), y.as_slice());
            let velocity = |i: usize| [decay * a[i] - turn * b[i], decay * b[i] + turn * a[i]];
            let (v, w): (Vec<f64>, Vec<f64>) = (0..n).map(|i| velocity(i).into()).unzip();
            let (mut real, mut imaginary) = (self.state_of_motion(spin, a, &v), self.state_of_motion(spin, b, &w));
            let length = real.iter().chain(&imaginary).map(|entry| entry * entry).sum::<f64>().sqrt();
            real.iter_mut().chain(&mut imaginary).for_each(|entry| *entry /= length);
            motions.push(EigenMotion { real, imaginary: (turn > 0.0).then_some(imaginary) });
        }
        Ok(motions)
    }
}
