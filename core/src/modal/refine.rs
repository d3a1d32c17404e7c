//! Refinement of a critical speed in the full model by Newton's method.
//!
//! ```text
//! P(lambda, W) y = 0,  lambda = r + i W,  c^H y = 1           unknown: y, r, W                                   (1)
//! P = lambda^2 M^ + lambda (C^ + W G^) + K^                   A^ = L^-1 A L^-T,  y = L^T x,  K = L L^T + K_skew  (2)
//! a = P^-1 P_lambda y,  b = P^-1 (i P_lambda + P_W) y,  c^H (a dr + b dW) = -1,  y <- -(a dr + b dW)             (3)
//! ```
//! (3) is Newton's step for (1); it keeps c^H y = 1. In the coordinates (2) the low modes keep their accuracy, as in
//! [`super::quadratic_modes`]. Source: Newton's method for nonlinear eigenproblems with a fixed normalisation (Ruhe 1973). Limits: the
//! symmetric part of K is positive definite. Verified by `both_solvers_agree_on_every_kind_of_machine` in `tests/rotor/display_modes.rs`.

use super::matrices::Matrices;
use super::quadratic::{congruent, noise_with};
use super::shape::{CLEAR, Mode};
use super::whirl::{Lateral, MIXED, undamped_below};
use bladeoff_numerics::linalg::{ComplexFactors, Matrix, cholesky, mul_transposed_vec, mul_vec, solve_upper};

/// Maximum number of Newton steps; four are usual.
const STEPS: usize = 20;
/// Relative step size of convergence.
const FOUND: f64 = 1e-13;
/// Relative size of the last step at which the result is accepted if rounding keeps the steps above [`FOUND`].
const SMALL: f64 = 1e-10;
/// Largest relative change of the speed; a larger change leads to another mode.
const NEAR: f64 = 1e-3;
/// Relative speed increment of the difference quotient of bearing tables.
const DIFFERENCE: f64 = 1e-6;

type Complex = [f64; 2];

fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

/// The full model in the coordinates (2).
pub(super) struct Refinement<'a> {
    pub lateral: &'a Lateral,
    /// Cholesky factor L of the symmetric part of K.
    pub factor: Matrix,
    /// M^, C^ and K^ without bearing tables, and G^.
    matrices: Matrices,
}

impl<'a> Refinement<'a> {
    /// Transforms the matrices of a rotor; `None` if its stiffness is not positive definite.
    pub fn new(lateral: &'a Lateral) -> Option<Self> {
        let [_, stiffness] = lateral.at(None, 0.0);
        let factor = cholesky(&((&stiffness + stiffness.transpose()) * 0.5))?;
        let Matrices { mass, damping, stiffness, gyroscopic } = &lateral.matrices;
        let [mass, damping, stiffness, gyroscopic] =
            [mass, damping, stiffness, gyroscopic].map(|matrix| congruent(&factor, matrix));
        Some(Self { lateral, factor, matrices: Matrices { mass, damping, stiffness, gyroscopic } })
    }

    /// Returns M^, C^ + W G^ and K^ at a speed W \[rad/s\], bearing tables included.
    pub fn at(&self, speed: f64) -> [Matrix; 3] {
        let Matrices { mass, damping, stiffness, gyroscopic } = &self.matrices;
        let [mut velocity, mut stiffness] = [damping + gyroscopic * speed, stiffness.clone()];
        if let Some(changes) = self.lateral.rotor.change_at(speed) {
            let [k, c] = changes.map(|change| congruent(&self.factor, &change));
            velocity += c;
            stiffness += k;
        }
        [mass.clone(), velocity, stiffness]
    }

    /// Coordinates y = L^T x of a mode, as real and imaginary part.
    pub fn coordinates(&self, mode: &Mode) -> [Vec<f64>; 2] {
        mode.parts().map(|part| {
            let mut product = vec![0.0; part.len()];
            mul_transposed_vec(&self.factor, part, &mut product);
            product
        })
    }

    /// Derivative `P_W` at a speed, as the matrices that multiply y and lambda y. For bearing tables it is a difference quotient.
    fn derivative(&self, speed: f64) -> [Matrix; 2] {
        if self.lateral.rotor.tables.is_empty() {
            return [&self.matrices.stiffness * 0.0, self.matrices.gyroscopic.clone()];
        }
        let step = DIFFERENCE * speed;
        let [[_, c, k], [_, velocity, stiffness]] = [speed, speed + step].map(|speed| self.at(speed));
        [(stiffness - k) / step, (velocity - c) / step]
    }

    /// Returns the critical speed near `near` \[rad/s\] and its mode; `None` if the iteration fails or converges to another mode.
    pub fn critical(&self, near: f64, mode: &Mode) -> Option<(f64, Mode)> {
        let [mut r, mut speed] = [mode.value[0], near];
        let parts = self.coordinates(mode);
        let size = parts.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        let start: Vec<Complex> = parts[0].iter().zip(&parts[1]).map(|(re, im)| [re / size, im / size]).collect();
        let along = |y: &[Complex]| {
            let parts = start.iter().zip(y).map(|([p, q], value)| times([*p, -q], *value));
            parts.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
        };
        let derivative = self.derivative(near);
        let (mut y, mut last) = (start.clone(), f64::INFINITY);
        for _ in 0..STEPS {
            let [mass, velocity, stiffness] = self.at(speed);
            let lambda = [r, speed];
            let square = times(lambda, lambda);
            let system = ComplexFactors::new(
                &(&mass * square[0] + &velocity * r + &stiffness),
                &(&mass * square[1] + &velocity * speed),
            );
            let [heavy, slow] = [&mass, &velocity].map(|matrix| product(matrix, &y));
            let by_lambda: Vec<Complex> = heavy
                .iter()
                .zip(&slow)
                .map(|(heavy, slow)| {
                    let [p, q] = times([2.0 * r, 2.0 * speed], *heavy);
                    [p + slow[0], q + slow[1]]
                })
                .collect();
            let [stiffer, faster] = [&derivative[0], &derivative[1]].map(|matrix| product(matrix, &y));
            let by_speed: Vec<Complex> = by_lambda
                .iter()
                .zip(stiffer.iter().zip(&faster))
                .map(|([p, q], (stiffer, faster))| {
                    let [s, t] = times(lambda, *faster);
                    [s + stiffer[0] - q, t + stiffer[1] + p]
                })
                .collect();
            let (a, b) = (system.solve(&by_lambda), system.solve(&by_speed));
            let ([ar, ai], [br, bi]) = (along(&a), along(&b));
            let determinant = ar * bi - ai * br;
            let (dr, dw) = (-bi / determinant, ai / determinant);
            let step = libm::hypot(dr, dw) / libm::hypot(r, speed);
            if !step.is_finite() {
                // P is singular to working precision
                return (last < SMALL).then(|| self.mode(mode, [r, speed], &y)).flatten();
            }
            (r, speed) = (r + dr, speed + dw);
            y = a.iter().zip(&b).map(|([p, q], [s, t])| [-(p * dr + s * dw), -(q * dr + t * dw)]).collect();
            if (speed - near).abs() > NEAR * near {
                return None;
            }
            if step < FOUND || (step < SMALL && step >= 0.5 * last) {
                return self.mode(mode, [r, speed], &y);
            }
            last = step;
        }
        None
    }

    /// Returns the refined mode with its speed \[rad/s\]; `None` if it is not the mode `from`.
    fn mode(&self, from: &Mode, value: Complex, y: &[Complex]) -> Option<(f64, Mode)> {
        let speed = value[1];
        let [mass, velocity, _] = self.at(speed);
        let value = undamped_below(noise_with(&mass, &velocity, libm::hypot(value[0], speed)), value);
        let part = |of: usize| {
            let column = Matrix::from_iterator(y.len(), 1, y.iter().map(|entry| entry[of]));
            solve_upper(&self.factor, &column).as_slice().to_vec()
        };
        let mut mode = Mode::of(value, part(0), part(1));
        if self.lateral.isotropic {
            let [backward, forward] = [false, true].map(|way| mode.circular(&self.lateral.rotor, way));
            let share = backward.size() / (backward.size() + forward.size());
            if share.min(1.0 - share) <= MIXED {
                mode = if share > 0.5 { backward } else { forward };
            }
        }
        self.lateral.weigh(&mut mode);
        (from.alike(&mode) > CLEAR).then_some((speed, mode))
    }
}

fn product(matrix: &Matrix, y: &[Complex]) -> Vec<Complex> {
    let [re, im] = [0, 1].map(|part| {
        let column: Vec<f64> = y.iter().map(|entry| entry[part]).collect();
        let mut product = vec![0.0; column.len()];
        mul_vec(matrix, &column, &mut product);
        product
    });
    re.into_iter().zip(im).map(|(re, im)| [re, im]).collect()
}
