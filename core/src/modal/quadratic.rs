//! Quadratic eigenvalue problem of damped rotors at a constant speed.

use bladeoff_numerics::linalg::{
    EigenError, Matrix, cholesky, complex_eigen, complex_eigen_display, complex_eigenvalues, inverse, mul, solve_lower,
    solve_upper,
};

/// Solver of general eigenproblems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Eigensolver {
    /// Own code with a fixed order of operations, for all results that enter a run.
    Own,
    /// faer, for results that are displayed only: its last digits depend on the processor. If its iteration does not converge (some
    /// matrices with double eigenvalues), the own code is used.
    Display,
}

impl Eigensolver {
    fn solve(self, a: &Matrix, what: &'static str) -> Result<(Vec<[f64; 2]>, Matrix, Matrix), EigenError> {
        match self {
            Self::Own => complex_eigen(a, what),
            Self::Display => complex_eigen_display(a, what).or_else(|_| complex_eigen(a, what)),
        }
    }
}

/// Solutions of a quadratic eigenvalue problem.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadraticModes {
    /// Eigenvalues lambda as (re, im) \[rad/s\], unordered, both of each conjugate pair.
    pub values: Vec<[f64; 2]>,
    /// Real parts of the mode shapes, one mode per column.
    pub real: Matrix,
    /// Imaginary parts of the mode shapes.
    pub imaginary: Matrix,
    /// Rounding N u |A|_F of (1) \[-\]; `None`: the eigenvalues come from the form with `M^-1 K`.
    inverse_rounding: Option<f64>,
    /// Scale s of (1) \[rad/s\].
    scale: f64,
}

impl QuadraticModes {
    /// Returns a bound on the numerical noise of a damping ratio `-Re lambda/|lambda|`, for lightly damped modes.
    ///
    /// ```text
    /// |d nu| <= kappa N u |A|_F,   kappa = (1 + |nu|^2)/(2 |nu|)       A of (1), of size N, u = 2^-53, an undamped motion     (2)
    /// |d zeta| <= |d nu|/|nu| = (N u |A|_F/2) (1 + |lambda|^2/s^2)     as |nu| = s/|lambda|
    /// ```
    /// kappa is the condition number of a simple eigenvalue: the product of the norms of its left and right eigenvectors over their scalar
    /// product. For an undamped mode these vectors are (nu x, x) and (x, nu x). In the form with `M^-1 K`, the largest |lambda| replaces s
    /// and the rounding is N u. Source: Wilkinson, The Algebraic Eigenvalue Problem (1965), chapter 2, for a backward stable method.
    /// Limits: kappa differs for a damped mode, but its damping ratio is far above (2).
    #[must_use]
    pub fn noise(&self, [re, im]: [f64; 2]) -> f64 {
        let size = libm::hypot(re, im);
        match self.inverse_rounding {
            Some(rounding) => inverse_noise(rounding, size / self.scale),
            None => {
                let largest = self.values.iter().map(|[re, im]| libm::hypot(*re, *im)).fold(0.0, f64::max);
                self.values.len() as f64 * UNIT_ROUNDOFF * largest / size
            }
        }
    }
}

/// Noise (2) of a damping ratio from `rounding` = N u |A|_F and `size` = |lambda|/s.
fn inverse_noise(rounding: f64, size: f64) -> f64 {
    0.5 * rounding * (1.0 + size * size)
}

/// Noise (2) of a damping ratio in the form (1) without skew stiffness. `mass`: M^, `damping`: C^, `size`: |lambda| \[rad/s\].
pub(super) fn noise_with(mass: &Matrix, damping: &Matrix, size: f64) -> f64 {
    let (n, scale) = (mass.nrows(), scale_of(mass));
    let norm = libm::sqrt((scale * damping.norm()).powi(2) + (scale * scale * mass.norm()).powi(2) + n as f64);
    inverse_noise((2 * n) as f64 * UNIT_ROUNDOFF * norm, size / scale)
}

/// Scale s of (1) from M^ \[rad/s\]: `omega_1^2 <= 1/(largest diagonal entry of M^)`.
fn scale_of(mass: &Matrix) -> f64 {
    1.0 / mass.diagonal().amax().sqrt()
}

/// Congruence transformation `L^-1 A L^-T`.
pub(super) fn congruent(l: &Matrix, a: &Matrix) -> Matrix {
    solve_lower(l, &solve_lower(l, a).transpose()).transpose()
}

/// Unit roundoff u of double precision.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;

/// Solves `(lambda^2 M + lambda C + K) x = 0` for all eigenvalues and mode shapes. M is symmetric positive definite; C and K are arbitrary.
///
/// ```text
/// K = L L^T + K_skew,  y = L^T x,  nu = s/lambda,  s about the lowest frequency
/// nu^2 (1 + K_skew^) y + nu s C^ y + s^2 M^ y = 0,   M^ = L^-1 M L^-T ...                         (1)
/// ```
/// In (1) the low modes have the largest eigenvalues nu, so they keep nearly full relative accuracy. In the usual form with `M^-1 K` they
/// have the rounding error of the highest mode (relative 3e-6 on the reference rotors). That form is used only if the symmetric part of K
/// is not positive definite (a free direction).
///
/// # Errors
/// [`EigenError`] if M is singular or the iteration does not converge.
/// # Verified by
/// `both_forms_agree`, and the whirl frequencies of `tests/rotor/linear_rotors.rs`
pub fn quadratic_modes(m: &Matrix, c: &Matrix, k: &Matrix, what: &'static str) -> Result<QuadraticModes, EigenError> {
    quadratic_modes_by(Eigensolver::Own, [m, c, k], what)
}

/// [`quadratic_modes`] of M, C and K with a given solver.
///
/// # Errors
/// The errors of [`quadratic_modes`].
pub fn quadratic_modes_by(
    solver: Eigensolver,
    [m, c, k]: [&Matrix; 3],
    what: &'static str,
) -> Result<QuadraticModes, EigenError> {
    let symmetric = (k + k.transpose()) * 0.5;
    match cholesky(&symmetric) {
        Some(l) => by_stiffness(solver, [m, c, &(k - &symmetric), &l], what),
        None => by_mass(solver, [m, c, k], what),
    }
}

/// Computes the eigenvalues of [`quadratic_modes`] without mode shapes, at less than half the cost.
///
/// # Errors
/// The errors of [`quadratic_modes`].
pub fn quadratic_values(m: &Matrix, c: &Matrix, k: &Matrix, what: &'static str) -> Result<Vec<[f64; 2]>, EigenError> {
    let symmetric = (k + k.transpose()) * 0.5;
    match cholesky(&symmetric) {
        Some(l) => {
            let (a, scale) = inverse_form(m, c, &(k - &symmetric), &l, what)?;
            Ok(complex_eigenvalues(&a, what)?.into_iter().map(|inverse| inverted(scale, inverse)).collect())
        }
        None => complex_eigenvalues(&mass_form(m, c, k, what)?, what),
    }
}

/// Companion matrix of (1), and its scale s \[rad/s\].
fn inverse_form(
    m: &Matrix,
    c: &Matrix,
    skew: &Matrix,
    l: &Matrix,
    what: &'static str,
) -> Result<(Matrix, f64), EigenError> {
    let n = m.nrows();
    let (mut mass, mut damping) = (congruent(l, m), congruent(l, c));
    mass = (&mass + mass.transpose()) * 0.5;
    let scale = scale_of(&mass);
    if skew.amax() > 0.0 {
        let left = inverse(&(Matrix::identity(n, n) + congruent(l, skew)))
            .ok_or(EigenError::NoConvergence { what, size: n })?;
        mass = mul(&left, &mass);
        damping = mul(&left, &damping);
    }
    let mut a = Matrix::zeros(2 * n, 2 * n);
    a.view_mut((0, 0), (n, n)).copy_from(&(damping * -scale));
    a.view_mut((0, n), (n, n)).copy_from(&(mass * -(scale * scale)));
    a.view_mut((n, 0), (n, n)).fill_with_identity();
    Ok((a, scale))
}

/// Converts nu to lambda = s/nu \[rad/s\].
fn inverted(scale: f64, [re, im]: [f64; 2]) -> [f64; 2] {
    let square = re * re + im * im;
    [scale * re / square, -scale * im / square]
}

fn by_stiffness(
    solver: Eigensolver,
    [m, c, skew, l]: [&Matrix; 4],
    what: &'static str,
) -> Result<QuadraticModes, EigenError> {
    let n = m.nrows();
    let (a, scale) = inverse_form(m, c, skew, l, what)?;
    let (inverses, real, imaginary) = solver.solve(&a, what)?;
    let shapes = |part: &Matrix| solve_upper(l, &part.rows(n, n).into_owned());
    let values = inverses.into_iter().map(|inverse| inverted(scale, inverse)).collect();
    let inverse_rounding = Some((2 * n) as f64 * UNIT_ROUNDOFF * a.norm());
    Ok(QuadraticModes { values, real: shapes(&real), imaginary: shapes(&imaginary), inverse_rounding, scale })
}

/// State-space matrix of the form with `M^-1 K` and `M^-1 C`.
fn mass_form(m: &Matrix, c: &Matrix, k: &Matrix, what: &'static str) -> Result<Matrix, EigenError> {
    let n = m.nrows();
    let inverse_mass = inverse(m).ok_or(EigenError::MassNotDefinite { what, size: n })?;
    let mut a = Matrix::zeros(2 * n, 2 * n);
    a.view_mut((0, n), (n, n)).fill_with_identity();
    a.view_mut((n, 0), (n, n)).copy_from(&-mul(&inverse_mass, k));
    a.view_mut((n, n), (n, n)).copy_from(&-mul(&inverse_mass, c));
    Ok(a)
}

fn by_mass(solver: Eigensolver, [m, c, k]: [&Matrix; 3], what: &'static str) -> Result<QuadraticModes, EigenError> {
    let n = m.nrows();
    let (values, real, imaginary) = solver.solve(&mass_form(m, c, k, what)?, what)?;
    let head = |part: &Matrix| part.rows(0, n).into_owned();
    Ok(QuadraticModes { values, real: head(&real), imaginary: head(&imaginary), inverse_rounding: None, scale: 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_agree() {
        let n = 4;
        let spd = |shift: f64| {
            let a = Matrix::from_fn(n, n, |i, j| ((i * 3 + j * 5) % 7) as f64 - 3.0);
            &a.transpose() * &a + Matrix::identity(n, n) * shift
        };
        let (m, k) = (spd(9.0), spd(5.0) * 40.0);
        let c = Matrix::from_fn(n, n, |i, j| ((i * 2 + j * 3) % 5) as f64 * 0.3);
        let skew = Matrix::from_fn(n, n, |i, j| (i as f64 - j as f64) * 0.7);
        for k in [k.clone(), &k + &skew] {
            let symmetric = (&k + k.transpose()) * 0.5;
            let l = cholesky(&symmetric).expect("definite");
            let own = Eigensolver::Own;
            let a = by_stiffness(own, [&m, &c, &(&k - symmetric), &l], "test").expect("solvable");
            let b = by_mass(own, [&m, &c, &k], "test").expect("solvable");
            for (j, value) in a.values.iter().enumerate() {
                let near = b.values.iter().map(|v| (v[0] - value[0]).hypot(v[1] - value[1])).fold(f64::MAX, f64::min);
                assert!(near < 1e-11, "{near}");
                let alone = [
                    quadratic_values(&m, &c, &k, "test"),
                    complex_eigenvalues(&mass_form(&m, &c, &k, "t").expect("regular"), "t"),
                ];
                for values in alone {
                    let values = values.expect("solvable");
                    assert_eq!(values.len(), 2 * n);
                    let near = values.iter().map(|v| (v[0] - value[0]).hypot(v[1] - value[1])).fold(f64::MAX, f64::min);
                    assert!(near < 1e-11, "without shapes: {near}");
                }
                // residual of the eigenpair
                let ([p, q], x, y) = (*value, a.real.column(j), a.imaginary.column(j));
                let (s, t) = (p * p - q * q, 2.0 * p * q);
                let re = &m * (x * s - y * t) + &c * (x * p - y * q) + &k * x;
                assert!(re.amax() < 1e-10 * k.amax() * x.amax().max(y.amax()), "{}", re.amax());
            }
        }
    }
}
