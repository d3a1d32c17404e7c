//! Eigenvalue problems, solved by faer without threads.
//!
//! faer picks its kernels by CPU: the last digits may differ between machines, which is why modes are computed once
//! per study and frozen (architecture.md, decision 3).

use faer::{Mat, Side};

use super::{Matrix, mul, mul_tn};

/// An eigenvalue problem could not be solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EigenError {
    /// The mass matrix is not positive definite.
    #[error("the mass matrix of {what} ({size} degrees of freedom) is not positive definite")]
    MassNotDefinite {
        /// Which part.
        what: &'static str,
        /// Its size.
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

fn to_faer(a: &Matrix) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)])
}

/// All solutions of `K phi = omega^2 M phi`: omega^2 ascending, phi mass-normalised (`phi^T M phi = 1`), in columns.
///
/// # Errors
/// [`EigenError`] if M is not positive definite or the iteration fails.
pub fn symmetric_generalised(k: &Matrix, m: &Matrix, what: &'static str) -> Result<(Vec<f64>, Matrix), EigenError> {
    let size = m.nrows();
    let factor =
        nalgebra::Cholesky::new(m.clone()).ok_or(EigenError::MassNotDefinite { what, size })?;
    // M = L L^T, C = L^-1 K L^-T, phi = L^-T y
    let l = factor.l();
    let l_inv = l.solve_lower_triangular(&Matrix::identity(size, size)).expect("a Cholesky factor is invertible");
    let mut c = mul(&mul(&l_inv, k), &l_inv.transpose());
    c = (&c + c.transpose()) * 0.5;
    faer::set_global_parallelism(faer::Par::Seq);
    let eigen =
        to_faer(&c).self_adjoint_eigen(Side::Lower).map_err(|_| EigenError::NoConvergence { what, size })?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let y = Matrix::from_fn(size, size, |i, j| vectors[(i, order[j])]);
    Ok((order.iter().map(|&j| values[j]).collect(), mul_tn(&l_inv, &y)))
}

/// Eigenvalues (re, im) of a real matrix and its eigenvectors (re, im parts in columns), in faer's order.
///
/// # Errors
/// [`EigenError::NoConvergence`].
pub fn complex_eigen(a: &Matrix, what: &'static str) -> Result<(Vec<[f64; 2]>, Matrix, Matrix), EigenError> {
    let size = a.nrows();
    faer::set_global_parallelism(faer::Par::Seq);
    let eigen = to_faer(a).eigen().map_err(|_| EigenError::NoConvergence { what, size })?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    Ok((
        (0..size).map(|j| [values[j].re, values[j].im]).collect(),
        Matrix::from_fn(size, size, |i, j| vectors[(i, j)].re),
        Matrix::from_fn(size, size, |i, j| vectors[(i, j)].im),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

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
