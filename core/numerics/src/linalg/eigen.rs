//! Eigenvalue problems of structures, by [`super::symmetric`] and [`super::general`].

use super::general::{general_eigen, general_eigenvalues};
use super::symmetric::symmetric_eigen;
use super::{Matrix, cholesky, solve_lower, solve_upper};

/// Error of an eigenvalue problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EigenError {
    /// The mass matrix is not positive definite.
    #[error("the mass matrix of {what} ({size} degrees of freedom) is not positive definite")]
    MassNotDefinite {
        /// Part of the machine.
        what: &'static str,
        /// Number of degrees of freedom.
        size: usize,
    },
    /// The iteration did not converge.
    #[error("the eigenvalue iteration of {what} ({size} degrees of freedom) did not converge")]
    NoConvergence {
        /// Which part.
        what: &'static str,
        /// Its size.
        size: usize,
    },
}

/// All solutions of `K phi = omega^2 M phi`: omega^2 ascending, phi mass-normalised (`phi^T M phi = 1`), in columns.
///
/// ```text
/// K + sigma M = L L^T,  L^-1 M L^-T y = mu y,  omega^2 = 1/mu - sigma,  phi = L^-T y / sqrt(mu)
/// sigma = 1e-6 max_i K_ii/M_ii: between the lowest and the highest omega^2
/// ```
/// The low modes, which matter, then have a relative error of rounding size times at most `sigma/omega^2` or
/// `omega^2/sigma`. The textbook form `L^-1 K L^-T` with `M = L L^T` leaves them the rounding of the highest, 1e-3 in the
/// frequencies of a thin ring of 96 elements; it is used only where the stiffness is not positive.
///
/// # Errors
/// [`EigenError`] if M is not positive definite or the iteration fails.
/// # Verified by
/// the tests below, `tests/rotor/linear_rotors.rs`, `tests/contact/ring.rs`
pub fn symmetric_generalised(k: &Matrix, m: &Matrix, what: &'static str) -> Result<(Vec<f64>, Matrix), EigenError> {
    let size = m.nrows();
    let mass_factor = cholesky(m).ok_or(EigenError::MassNotDefinite { what, size })?;
    let highest = (0..size).map(|i| k[(i, i)] / m[(i, i)]).fold(0.0, f64::max);
    // without any stiffness, every shift is valid
    let shift = if highest > 0.0 { 1e-6 * highest } else { 1.0 };
    let shifted = cholesky(&(k + m * shift));
    let (l, inner) = match &shifted {
        Some(factor) => (factor, m),
        None => (&mass_factor, k),
    };
    let c = solve_lower(l, &solve_lower(l, inner).transpose());
    let c = (&c + c.transpose()) * 0.5;
    let (found, vectors) = symmetric_eigen(&c).ok_or(EigenError::NoConvergence { what, size })?;
    let value = |j: usize| if shifted.is_some() { 1.0 / found[j] - shift } else { found[j] };
    // mu > 0, but the smallest may be rounded to zero: such a mode has no frequency
    let norm = |j: usize| if shifted.is_some() { 1.0 / found[j].sqrt() } else { 1.0 };
    if (0..size).any(|j| !(value(j).is_finite() && norm(j).is_finite())) {
        return Err(EigenError::NoConvergence { what, size });
    }
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| value(a).total_cmp(&value(b)));
    let y = Matrix::from_fn(size, size, |i, j| vectors[(i, order[j])] * norm(order[j]));
    let shapes = solve_upper(l, &y);
    Ok((order.iter().map(|&j| value(j)).collect(), shapes))
}

/// Eigenvalues (re, im) of a real matrix, including both of a conjugate pair, and eigenvectors of length 1 (re, im parts in columns).
///
/// # Errors
/// [`EigenError::NoConvergence`].
pub fn complex_eigen(a: &Matrix, what: &'static str) -> Result<(Vec<[f64; 2]>, Matrix, Matrix), EigenError> {
    general_eigen(a).ok_or(EigenError::NoConvergence { what, size: a.nrows() })
}

/// Eigenvalues of [`complex_eigen`] without vectors.
///
/// # Errors
/// [`EigenError::NoConvergence`].
pub fn complex_eigenvalues(a: &Matrix, what: &'static str) -> Result<Vec<[f64; 2]>, EigenError> {
    general_eigenvalues(a).ok_or(EigenError::NoConvergence { what, size: a.nrows() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{mul, mul_tn};

    #[test]
    fn two_masses_on_three_springs_have_their_textbook_modes() {
        let k = Matrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 2.0]);
        let m = Matrix::identity(2, 2) * 4.0;
        let (values, vectors) = symmetric_generalised(&k, &m, "test").expect("solvable");
        assert!((values[0] - 0.25).abs() < 1e-14 && (values[1] - 0.75).abs() < 1e-14);
        let gram = mul_tn(&vectors, &mul(&m, &vectors));
        assert!((gram - Matrix::identity(2, 2)).amax() < 1e-13);
    }

    #[test]
    fn low_modes_of_a_stiff_chain_keep_their_accuracy() {
        // a free chain of 60 masses: omega_k = 2 sin(k pi / 120) sqrt(k/m), six decades of omega^2, one rigid mode
        let n = 60;
        let mut k = Matrix::zeros(n, n);
        for i in 0..n - 1 {
            for (a, b, sign) in [(i, i, 1.0), (i + 1, i + 1, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0)] {
                k[(a, b)] += sign * 1e10;
            }
        }
        let (values, shapes) = symmetric_generalised(&k, &Matrix::identity(n, n), "test").expect("solvable");
        // rounding of the shift in K: 1e-16 of the highest omega^2
        assert!(values[0].abs() < 1e-15 * 4e10);
        for (j, value) in values.iter().enumerate().skip(1) {
            let exact = 4e10 * (j as f64 * std::f64::consts::PI / 120.0).sin().powi(2);
            assert!((value / exact - 1.0).abs() < 1e-11, "{j}: {value} {exact}");
        }
        assert!((mul_tn(&shapes, &shapes) - Matrix::identity(n, n)).amax() < 1e-9);
    }

    #[test]
    fn negative_stiffness_has_its_negative_square() {
        let k = Matrix::from_row_slice(2, 2, &[-3.0, 0.0, 0.0, 8.0]);
        let (values, _) = symmetric_generalised(&k, &(Matrix::identity(2, 2) * 2.0), "test").expect("solvable");
        assert!((values[0] + 1.5).abs() < 1e-14 && (values[1] - 4.0).abs() < 1e-14);
    }

    #[test]
    fn an_indefinite_mass_is_refused() {
        let k = Matrix::identity(2, 2);
        let m = Matrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, -1.0]);
        assert_eq!(symmetric_generalised(&k, &m, "x"), Err(EigenError::MassNotDefinite { what: "x", size: 2 }));
    }

    #[test]
    fn a_damped_oscillator_has_its_complex_pair() {
        let a = Matrix::from_row_slice(2, 2, &[0.0, 1.0, -1.0, -0.2]);
        let (values, _, _) = complex_eigen(&a, "test").expect("solvable");
        for value in values {
            assert!((value[0] + 0.1).abs() < 1e-14 && (value[1].abs() - 0.99_f64.sqrt()).abs() < 1e-14);
        }
    }
}
