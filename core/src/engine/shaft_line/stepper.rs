//! Central differences of one linear part, in increments.
//!
//! ```text
//! d = q+ - q,  d- = q - q-:      M (d - d-)/dt^2 + C (d + d-)/(2 dt) + K q = f
//! A = M/dt^2 + C/(2 dt):         d = d- + A^-1 (f - K q - C d-/dt)                    (1)
//! ```
//! Source: paper, section 3; (1) is the same scheme in increments, which avoids second differences of large numbers. Damping is centred. The scheme
//! is stable for `dt < 2/omega_max`.
//! Verified by `an_oscillator_converges_with_order_two`, `the_discrete_energy_balance_is_exact`.

use crate::structure::Part;
use bladeoff_numerics::linalg::{Csr, Matrix, inverse, mul_vec};

/// State and operators of one linear part during a run.
#[derive(Debug, Clone)]
pub(crate) struct Stepper {
    /// Time step \[s\].
    pub dt: f64,
    /// Inverse of A, and M, C, K for forces and energies.
    operator: Operator,
    /// Coordinates q at step n.
    pub q: Vec<f64>,
    /// Increment d- = q(n) - q(n-1).
    pub previous: Vec<f64>,
    /// Elastic forces K q at step n.
    pub elastic: Vec<f64>,
    /// Force f - K q - C d-/dt of the step.
    residual: Vec<f64>,
    /// Scratch: forces, or the sum of two increments.
    scratch: Vec<f64>,
}

#[derive(Debug, Clone)]
enum Operator {
    Diagonal { inverse: Vec<f64>, stiffness: Vec<f64>, damping: Vec<f64> },
    General { inverse: Matrix, mass: Csr, stiffness: Csr, damping: Csr },
}

impl Stepper {
    /// Part at rest; `mass` replaces the part's mass matrix if a run adds masses. `None` if A is singular.
    pub fn new(part: &Part, mass: &Matrix, dt: f64) -> Option<Self> {
        let size = part.coordinates.size();
        let zeros = vec![0.0; size];
        let diagonal = |a: &Matrix| a.diagonal().as_slice().to_vec();
        let operator = if part.modal && *mass == part.mass {
            let (stiffness, damping) = (diagonal(&part.stiffness), diagonal(&part.damping));
            let inverse = damping.iter().map(|c| 1.0 / (1.0 / (dt * dt) + c / (2.0 * dt))).collect();
            Operator::Diagonal { inverse, stiffness, damping }
        } else {
            Operator::General {
                inverse: inverse(&(mass / (dt * dt) + &part.damping / (2.0 * dt)))?,
                mass: Csr::from_dense(mass),
                stiffness: Csr::from_dense(&part.stiffness),
                damping: Csr::from_dense(&part.damping),
            }
        };
        Some(Self {
            dt,
            operator,
            q: zeros.clone(),
            previous: zeros.clone(),
            elastic: zeros.clone(),
            residual: zeros.clone(),
            scratch: zeros,
        })
    }

    /// Computes `f - K q - C d-/dt` for the step from n.
    pub fn prepare(&mut self, force: Option<&[f64]>) {
        match force {
            Some(force) => self.residual.copy_from_slice(force),
            None => self.residual.fill(0.0),
        }
        match &self.operator {
            Operator::Diagonal { stiffness, damping, .. } => {
                let rate = 1.0 / self.dt;
                for i in 0..self.q.len() {
                    self.elastic[i] = stiffness[i] * self.q[i];
                    self.residual[i] -= self.elastic[i] + rate * damping[i] * self.previous[i];
                }
            }
            Operator::General { stiffness, damping, .. } => {
                self.elastic.fill(0.0);
                stiffness.subtract_scaled(-1.0, &self.q, &mut self.elastic);
                for (residual, elastic) in self.residual.iter_mut().zip(&self.elastic) {
                    *residual -= elastic;
                }
                damping.subtract_scaled(1.0 / self.dt, &self.previous, &mut self.residual);
            }
        }
    }

    /// Increment (1) with an additional force.
    pub fn increment(&mut self, extra: Option<&[f64]>, out: &mut [f64]) {
        self.scratch.copy_from_slice(&self.residual);
        if let Some(extra) = extra {
            for (sum, value) in self.scratch.iter_mut().zip(extra) {
                *sum += value;
            }
        }
        let scratch = std::mem::take(&mut self.scratch);
        self.compliance(&scratch, out);
        self.scratch = scratch;
        for (value, previous) in out.iter_mut().zip(&self.previous) {
            *value += previous;
        }
    }

    /// Increment A^-1 f due to a force.
    pub fn compliance(&self, force: &[f64], out: &mut [f64]) {
        match &self.operator {
            Operator::Diagonal { inverse, .. } => {
                for ((out, force), inverse) in out.iter_mut().zip(force).zip(inverse) {
                    *out = inverse * force;
                }
            }
            Operator::General { inverse, .. } => mul_vec_sparse(inverse, force, out),
        }
    }

    /// Accepts an increment.
    pub fn advance(&mut self, increment: &[f64]) {
        for (q, d) in self.q.iter_mut().zip(increment) {
            *q += d;
        }
        self.previous.copy_from_slice(increment);
    }

    /// Kinetic energy of an increment, `d^T M d / (2 dt^2)` \[J\].
    pub fn kinetic_energy(&self, increment: &[f64]) -> f64 {
        let sum = match &self.operator {
            Operator::Diagonal { .. } => bladeoff_numerics::linalg::dot(increment, increment),
            Operator::General { mass, .. } => mass.bilinear(increment, increment),
        };
        0.5 * sum / (self.dt * self.dt)
    }

    /// Strain energy between n and n+1, `q+^T K q / 2` \[J\], the form for which the energy balance of the scheme is exact.
    /// Before [`Stepper::advance`].
    pub fn strain_energy(&self, increment: &[f64]) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.q.len() {
            sum += self.elastic[i] * (self.q[i] + increment[i]);
        }
        0.5 * sum
    }

    /// Energy dissipated by damping over the step at n, `dt v^T C v` with centred v \[J\].
    pub fn damping_work(&mut self, increment: &[f64]) -> f64 {
        let scale = 0.25 / self.dt;
        for i in 0..self.q.len() {
            self.scratch[i] = increment[i] + self.previous[i];
        }
        match &self.operator {
            Operator::Diagonal { damping, .. } => {
                let mut sum = 0.0;
                for (c, v) in damping.iter().zip(&self.scratch) {
                    sum += c * v * v;
                }
                scale * sum
            }
            Operator::General { damping, .. } => scale * damping.bilinear(&self.scratch, &self.scratch),
        }
    }
}

/// Variant of `mul_vec` that skips zero entries of x: contact forces act on few degrees of freedom.
fn mul_vec_sparse(a: &Matrix, x: &[f64], y: &mut [f64]) {
    let filled = x.iter().filter(|&&value| value != 0.0).count();
    if 2 * filled > x.len() {
        return mul_vec(a, x, y);
    }
    y.fill(0.0);
    for (j, &value) in x.iter().enumerate() {
        if value != 0.0 {
            bladeoff_numerics::linalg::axpy(value, bladeoff_numerics::linalg::column_of(a, j), y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::Coordinates;

    fn oscillator(modal: bool, damping: f64) -> Part {
        let one = |value: f64| Matrix::from_element(1, 1, value);
        Part {
            coordinates: Coordinates::nodal(1),
            mass: one(1.0),
            damping: one(damping),
            stiffness: one(4.0),
            modal,
            highest: 2.0,
        }
    }

    fn run(part: &Part, dt: f64, end: f64) -> (f64, f64) {
        let mut stepper = Stepper::new(part, &part.mass, dt).expect("regular");
        stepper.q[0] = 1.0;
        let a0 = -4.0;
        stepper.previous[0] = -0.5 * dt * dt * a0;
        let mut d = [0.0];
        let (mut energies, mut dissipated) = (Vec::new(), 0.0);
        let steps = (end / dt).round() as usize;
        for _ in 0..steps {
            stepper.prepare(None);
            stepper.increment(None, &mut d);
            dissipated += stepper.damping_work(&d);
            energies.push(stepper.kinetic_energy(&d) + stepper.strain_energy(&d) + dissipated);
            stepper.advance(&d);
        }
        let drift = energies.iter().map(|e| (e - energies[0]).abs()).fold(0.0, f64::max);
        // the first entry already contains the dissipation of the first step: differences start there
        (stepper.q[0], drift)
    }

    #[test]
    fn an_oscillator_converges_with_order_two() {
        let part = oscillator(true, 0.0);
        let error = |dt: f64| (run(&part, dt, 3.0).0 - 6.0_f64.cos()).abs();
        let order = (error(0.01) / error(0.005)).log2();
        assert!((order - 2.0).abs() < 0.02, "{order}");
    }

    #[test]
    fn the_discrete_energy_balance_is_exact() {
        for modal in [true, false] {
            let (_, drift) = run(&oscillator(modal, 0.3), 0.05, 5.0);
            assert!(drift < 1e-13, "{drift}");
        }
    }

    #[test]
    fn both_forms_of_the_operator_agree() {
        let (a, b) = (run(&oscillator(true, 0.3), 0.05, 5.0), run(&oscillator(false, 0.3), 0.05, 5.0));
        assert!((a.0 - b.0).abs() < 1e-14);
    }
}
