//! State space of the lateral motion: the equations of motion of a shaft line as a first-order system in displacement and canonical momentum.
//!
//! ```text
//! M q'' + (C + W G) q' + (K + W' G/2) q = F                      equations of motion
//! p = M q' + W G q/2                                              canonical momentum of the kinetic energy q'^T M q'/2 + W q'^T G q/2
//! q' = M^-1 (p - W G q/2),   p' = -(C + W G/2) q' - K q + F       without W': where W jumps, q and p do not                (1)
//! x = (s_q q, s_p p),   s_q = sqrt(K_jj), s_p = 1/sqrt(M_jj)      state vector; |x|^2/2 is nearly the energy               (2)
//! x' = A(W) x + B F                                               state equation
//! ```
//!
//! | symbol | quantity, of `n` lateral coordinates |
//! |---|---|
//! | `q` | lateral coordinates of the structure: displacements and rotations of nodes, or modal coordinates |
//! | `F` | force in these coordinates |
//! | `W` | spin \[rad/s\], positive about +z |
//! | `M`, `C`, `K` | mass (with the masses of the unbalances), damping, stiffness (with the skew part of the bearings); with bearing tables C(W), K(W) |
//! | `G` | gyroscopic matrix per unit spin, skew-symmetric |
//! | `x` | state vector, `2n` entries; condition numbers of modal bases are taken in it |
//!
//! Source: docs/theory/01-shaft-line.md; docs/theory/08-exponential-engine.md, "Whirl states". Limits: all gyroscopic sites have one spin (the rate
//! of the elastic torsion is neglected), and no coefficient depends on the displacements. Verified by `tests/exponential/exponential.rs` against the reduced engine.

use super::bearing_tables::BearingTables;
use crate::engine::beginning::projected;
use crate::engine::shaft_line::{masses, sites};
use crate::modal::quadratic_modes;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{EigenError, Matrix, column_of, dot, inverse, mul};
use std::borrow::Cow;

/// Lower limit of s_q in (2), as a share of the largest: for coordinates without stiffness.
const MIN_DISPLACEMENT_SCALE: f64 = 1e-6;

/// System matrices of the lateral motion of a run, in the coordinates q of the structure.
#[derive(Debug, Clone)]
pub(crate) struct StateSpace {
    /// Number of lateral coordinates n; the state vector has 2n entries.
    pub size: usize,
    /// `M^-1`, n x n.
    pub inverse_mass: Matrix,
    /// `C`, n x n: damping of shaft and bearings, with the constant parts of bearing tables.
    damping: Matrix,
    /// `K`, n x n, with the skew part of the bearings and the constant parts of bearing tables: not symmetric where a bearing has a skew part.
    stiffness: Matrix,
    /// Bearing tables: the differences of C and K at a speed from their constant parts.
    pub tables: BearingTables,
    /// `G`, n x n, per unit spin, skew-symmetric.
    pub gyroscopic: Matrix,
    /// `M`, n x n, symmetric.
    mass: Matrix,
    gyroscopic_products: GyroscopicProducts,
    /// Scale factors `(s_q, s_p)` of (2), 2n.
    scale: Vec<f64>,
    /// Fault that a test injects.
    #[cfg(test)]
    pub fault: Option<crate::engine::exponential::settings::Fault>,
}

/// Products of G that the change of A with the spin consists of, n x n each.
#[derive(Debug, Clone)]
struct GyroscopicProducts {
    /// `M^-1 G`.
    m_inv_g: Matrix,
    /// `C M^-1 G`.
    c_m_inv_g: Matrix,
    /// `G M^-1 G`.
    g_m_inv_g: Matrix,
}

/// Eigenvector of A in the scaled state vector x of (2), complex length 1.
///
/// A conjugate pair is represented by the eigenvector of the eigenvalue with positive imaginary part.
#[derive(Debug, Clone)]
pub(crate) struct EigenMotion {
    /// Real part, 2n.
    pub real: Vec<f64>,
    /// Imaginary part, 2n; `None` for a real eigenvalue.
    pub imaginary: Option<Vec<f64>>,
}

impl StateSpace {
    /// System matrices of a machine; `None` if the mass matrix is singular.
    pub fn new(machine: &Machine, structure: &Structure) -> Option<Self> {
        let lateral = &structure.lateral;
        let (mass, _) = masses(structure, &sites(machine));
        let stiffness = &lateral.stiffness + projected(structure, &structure.rotor.skew_stiffness());
        let size = lateral.coordinates.size();
        let largest = (0..size).map(|j| stiffness[(j, j)].abs().sqrt()).fold(0.0, f64::max);
        let min_scale = if largest > 0.0 { MIN_DISPLACEMENT_SCALE * largest } else { 1.0 };
        let displacement_scales = (0..size).map(|j| stiffness[(j, j)].abs().sqrt().max(min_scale));
        let momentum_scales = (0..size).map(|j| 1.0 / mass[(j, j)].sqrt());
        let inverse_mass = inverse(&mass)?;
        let gyroscopic = projected(structure, &structure.rotor.gyroscopic());
        let m_inv_g = mul(&inverse_mass, &gyroscopic);
        let (c_m_inv_g, g_m_inv_g) = (mul(&lateral.damping, &m_inv_g), mul(&gyroscopic, &m_inv_g));
        Some(Self {
            size,
            inverse_mass,
            damping: lateral.damping.clone(),
            gyroscopic,
            gyroscopic_products: GyroscopicProducts { m_inv_g, c_m_inv_g, g_m_inv_g },
            scale: displacement_scales.chain(momentum_scales).collect(),
            stiffness,
            mass,
            tables: BearingTables::new(structure),
            #[cfg(test)]
            fault: None,
        })
    }

    /// These matrices with a fault.
    #[cfg(test)]
    pub fn with_fault(mut self, fault: Option<crate::engine::exponential::settings::Fault>) -> Self {
        if fault == Some(crate::engine::exponential::settings::Fault::GyroscopicSign) {
            self.gyroscopic.neg_mut();
            self.gyroscopic_products.m_inv_g.neg_mut();
            self.gyroscopic_products.c_m_inv_g.neg_mut();
        }
        Self { fault, ..self }
    }

    /// `K` at a spin \[rad/s\].
    pub fn stiffness_at(&self, spin: f64) -> Cow<'_, Matrix> {
        match self.tables.matrix(&self.tables.changes(spin), |change| &change.stiffness) {
            None => Cow::Borrowed(&self.stiffness),
            Some(change) => Cow::Owned(&self.stiffness + change),
        }
    }

    /// `C` at a spin \[rad/s\].
    pub fn damping_at(&self, spin: f64) -> Cow<'_, Matrix> {
        match self.tables.matrix(&self.tables.changes(spin), |change| &change.damping) {
            None => Cow::Borrowed(&self.damping),
            Some(change) => Cow::Owned(&self.damping + change),
        }
    }

    /// Matrix from the state vector x to the motion `(q, q')` at a spin \[rad/s\], 2n x 2n.
    pub fn motion_of_state(&self, spin: f64) -> Matrix {
        let n = self.size;
        let mut map = Matrix::zeros(2 * n, 2 * n);
        map.view_mut((0, 0), (n, n)).fill_with_identity();
        map.view_mut((n, 0), (n, n)).copy_from(&(&self.gyroscopic_products.m_inv_g * (-0.5 * spin)));
        map.view_mut((n, n), (n, n)).copy_from(&self.inverse_mass);
        for (j, scale) in self.scale.iter().enumerate() {
            map.column_mut(j).scale_mut(1.0 / scale);
        }
        map
    }

    /// Kinetic energy with its gyroscopic part, and strain energy, of a motion `(q, q')` at a spin \[J\]; the part of bearing tables that changes with the speed is
    /// [`BearingTables::strain_energy`].
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

    /// Stiffness matrix, with the constant parts of bearing tables, and mass matrix.
    pub fn energy_matrices(&self) -> [&Matrix; 2] {
        [&self.stiffness, &self.mass]
    }

    /// Velocity jump of all coordinates, `M^-1 I`, by an impulse `I` in the coordinates.
    pub fn velocity_jump(&self, impulse: &[f64]) -> Vec<f64> {
        (0..self.size).map(|i| (0..self.size).map(|j| self.inverse_mass[(i, j)] * impulse[j]).sum()).collect()
    }

    /// State vector x of a motion `(q, q')` at a spin \[rad/s\].
    pub fn state_of_motion(&self, spin: f64, q: &[f64], velocity: &[f64]) -> Vec<f64> {
        let n = self.size;
        let momentum = |i: usize| -> f64 {
            (0..n).map(|j| self.mass[(i, j)] * velocity[j] + 0.5 * spin * self.gyroscopic[(i, j)] * q[j]).sum()
        };
        (0..n).map(|i| self.scale[i] * q[i]).chain((0..n).map(|i| self.scale[n + i] * momentum(i))).collect()
    }

    /// System matrix A of `x' = A x` at a spin \[rad/s\], 2n x 2n.
    pub fn system_matrix(&self, spin: f64) -> Matrix {
        let n = self.size;
        let mut rates = Matrix::zeros(2 * n, 2 * n);
        rates.view_mut((0, n), (n, n)).fill_with_identity();
        rates.view_mut((n, 0), (n, n)).copy_from(&-&*self.stiffness_at(spin));
        rates.view_mut((n, n), (n, n)).copy_from(&(&self.gyroscopic * (-0.5 * spin) - &*self.damping_at(spin)));
        let mut a = mul(&rates, &self.motion_of_state(spin));
        for (i, scale) in self.scale.iter().enumerate() {
            a.row_mut(i).scale_mut(*scale);
        }
        a
    }

    /// Change of the system matrix A between two spins \[rad/s\], from its gyroscopic terms and bearing tables alone.
    ///
    /// The difference of two system matrices would carry the rounding of their large entries into slow modes.
    pub fn system_matrix_change(&self, from: f64, to: f64) -> Matrix {
        let n = self.size;
        let half = 0.5 * (to - from);
        let GyroscopicProducts { m_inv_g, c_m_inv_g, g_m_inv_g } = &self.gyroscopic_products;
        let mut change = Matrix::zeros(2 * n, 2 * n);
        change.view_mut((0, 0), (n, n)).copy_from(&(m_inv_g * -half));
        change.view_mut((n, 0), (n, n)).copy_from(&(c_m_inv_g * half + g_m_inv_g * (half * 0.5 * (to + from))));
        // G is skew, M symmetric
        change.view_mut((n, n), (n, n)).copy_from(&(m_inv_g.transpose() * half));
        if let Some([stiffness, damping, before]) = self.tables.changes_between(from, to) {
            let gyroscopic_damping = mul(&(&damping * (0.5 * to) + before * half), m_inv_g);
            let mut lower_left = change.view_mut((n, 0), (n, n));
            lower_left += gyroscopic_damping - stiffness;
            let mut lower_right = change.view_mut((n, n), (n, n));
            lower_right -= mul(&damping, &self.inverse_mass);
        }
        for (j, scale) in self.scale.iter().enumerate() {
            change.column_mut(j).scale_mut(1.0 / scale);
            change.row_mut(j).scale_mut(*scale);
        }
        change
    }

    /// Input vector of a force in the coordinates: its contribution `(0, s_p F)` to `x'`.
    pub fn input_vector(&self, force: &[f64]) -> Vec<f64> {
        let momentum_scales = &self.scale[self.size..];
        std::iter::repeat_n(0.0, self.size).chain(momentum_scales.iter().zip(force).map(|(s, f)| s * f)).collect()
    }

    /// All eigenvectors of A at a spin \[rad/s\]; real eigenvectors count one dimension, conjugate pairs two, together 2n.
    ///
    /// # Errors
    /// [`EigenError`] if the eigenvalue problem does not converge.
    pub fn eigen_motions(&self, spin: f64) -> Result<Vec<EigenMotion>, EigenError> {
        let damping = &*self.damping_at(spin) + &self.gyroscopic * spin;
        let modes = quadratic_modes(&self.mass, &damping, &self.stiffness_at(spin), "whirl at one speed")?;
        let n = self.size;
        let mut motions = Vec::with_capacity(2 * n);
        for (j, &[decay, frequency]) in modes.values.iter().enumerate() {
            if frequency < 0.0 {
                continue;
            }
            let (x, y) = (modes.real.column(j), modes.imaginary.column(j));
            let (a, b) = (x.as_slice(), y.as_slice());
            let velocity = |i: usize| [decay * a[i] - frequency * b[i], decay * b[i] + frequency * a[i]];
            let (v, w): (Vec<f64>, Vec<f64>) = (0..n).map(|i| velocity(i).into()).unzip();
            let (mut real, mut imaginary) = (self.state_of_motion(spin, a, &v), self.state_of_motion(spin, b, &w));
            let length = real.iter().chain(&imaginary).map(|entry| entry * entry).sum::<f64>().sqrt();
            real.iter_mut().chain(&mut imaginary).for_each(|entry| *entry /= length);
            motions.push(EigenMotion { real, imaginary: (frequency > 0.0).then_some(imaginary) });
        }
        Ok(motions)
    }
}
