//! Eigenproblems and linear systems for results that do not enter a run, by faer: modes, critical speeds, responses to unbalance.
//!
//! faer selects its kernels by processor, so the last digits can differ between two processors. On one machine they are the same in each call: one
//! thread, no timing. A run must not use this file; the solvers of runs are in `general.rs` and `symmetric.rs`.
//! Limits: errors are those of a backward stable method, as of [`super::complex_eigen`]. Verified by the tests below, and on machines by
//! `tests/rotor/display_modes.rs` of the package bladeoff-core.

use super::{EigenError, Matrix};
use faer::linalg::solvers::{Eigen, PartialPivLu, Solve};
use faer::{Mat, MatMut, MatRef, c64};

/// Eigenvalues (re, im) of a real matrix, including both of a conjugate pair, and eigenvectors of length 1 (re and im parts in columns).
///
/// # Errors
/// [`EigenError::NoConvergence`]: the iteration failed, or an entry is not finite.
pub fn complex_eigen_display(a: &Matrix, what: &'static str) -> Result<(Vec<[f64; 2]>, Matrix, Matrix), EigenError> {
    let n = a.nrows();
    let failed = EigenError::NoConvergence { what, size: n };
    if !a.iter().all(|entry| entry.is_finite()) {
        return Err(failed);
    }
    if n == 0 {
        return Ok((Vec::new(), Matrix::zeros(0, 0), Matrix::zeros(0, 0)));
    }
    // with tiny or huge entries, products of two entries would over- or underflow
    let unit = libm::exp2(f64::from(libm::ilogb(a.amax().max(f64::MIN_POSITIVE))));
    let scaled = a.map(|entry| entry / unit);
    let solution =
        Eigen::new_from_real(MatRef::from_column_major_slice(scaled.as_slice(), n, n)).map_err(|_| failed.clone())?;
    let (shapes, diagonal) = (solution.U(), solution.S().column_vector());
    let values: Vec<[f64; 2]> = (0..n).map(|j| [unit * diagonal[j].re, unit * diagonal[j].im]).collect();
    let lengths: Vec<f64> = (0..n).map(|j| shapes.col(j).norm_l2()).collect();
    let part = |of: fn(c64) -> f64| Matrix::from_fn(n, n, |i, j| of(shapes[(i, j)]) / lengths[j]);
    let (real, imaginary) = (part(|entry| entry.re), part(|entry| entry.im));
    let is_finite = values.iter().flatten().chain(real.iter()).chain(imaginary.iter()).all(|entry| entry.is_finite());
    if is_finite { Ok((values, real, imaginary)) } else { Err(failed) }
}

/// Factors of a complex matrix with partial pivoting.
#[derive(Debug)]
pub struct ComplexFactors(PartialPivLu<c64>);

impl ComplexFactors {
    /// Factorises the matrix with these real and imaginary parts.
    #[must_use]
    pub fn new(real: &Matrix, imaginary: &Matrix) -> Self {
        let entry = |i: usize, j: usize| c64::new(real[(i, j)], imaginary[(i, j)]);
        Self(Mat::from_fn(real.nrows(), real.ncols(), entry).partial_piv_lu())
    }

    /// Solves for one right side, entries as (re, im). A singular matrix gives entries that are not finite.
    #[must_use]
    pub fn solve(&self, right: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut entries: Vec<c64> = right.iter().map(|&[re, im]| c64::new(re, im)).collect();
        let rows = entries.len();
        self.0.solve_in_place(MatMut::from_column_major_slice_mut(&mut entries, rows, 1));
        entries.into_iter().map(|entry| [entry.re, entry.im]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::complex_eigen;

    fn sample(n: usize) -> Matrix {
        Matrix::from_fn(n, n, |i, j| ((i * 37 + j * 61 + i * j * 7) % 101) as f64 / 50.0 - 1.0)
    }

    #[test]
    fn both_solvers_find_the_same_values_and_solutions() {
        for (n, scale) in [(1, 1.0), (2, 1.0), (7, 1e-200), (60, 1.0), (60, 1e150)] {
            let a = sample(n) * scale;
            let (values, re, im) = complex_eigen_display(&a, "test").expect("ends");
            let (own, ..) = complex_eigen(&a, "test").expect("ends");
            for (j, &[p, q]) in values.iter().enumerate() {
                let near = own.iter().map(|[r, s]| libm::hypot(p - r, q - s)).fold(f64::MAX, f64::min);
                assert!(near < 1e-11 * a.amax() * n as f64, "{n}: {near}");
                let (x, y) = (re.column(j), im.column(j));
                let residual = (&a * x - x * p + y * q).norm() + (&a * y - y * p - x * q).norm();
                assert!(residual <= 1e-12 * a.amax() * n as f64, "{n}: {residual}");
                assert!((x.norm_squared() + y.norm_squared() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn two_calls_give_the_same_bytes() {
        let bits = || {
            let (values, re, im) = complex_eigen_display(&sample(50), "test").expect("ends");
            let all = values.into_iter().flatten().chain(re.iter().copied()).chain(im.iter().copied());
            all.map(f64::to_bits).collect::<Vec<u64>>()
        };
        assert_eq!(bits(), bits());
    }

    #[test]
    fn a_matrix_with_an_entry_that_is_not_finite_is_rejected() {
        let mut a = sample(4);
        a[(1, 2)] = f64::NAN;
        assert_eq!(complex_eigen_display(&a, "x"), Err(EigenError::NoConvergence { what: "x", size: 4 }));
        assert_eq!(complex_eigen_display(&Matrix::zeros(0, 0), "x").expect("empty").0.len(), 0);
        assert_eq!(complex_eigen_display(&Matrix::zeros(3, 3), "x").expect("zero").0, vec![[0.0; 2]; 3]);
    }

    #[test]
    fn a_complex_system_is_solved() {
        let (re, im) = (sample(9) + Matrix::identity(9, 9) * 3.0, sample(9).transpose());
        let x: Vec<[f64; 2]> = (0..9).map(|k| [f64::from(k) - 4.0, 0.5 * f64::from(k)]).collect();
        let right: Vec<[f64; 2]> = (0..9)
            .map(|i| {
                (0..9).fold([0.0; 2], |[a, b], j| {
                    let ([p, q], [r, s]) = ([re[(i, j)], im[(i, j)]], x[j]);
                    [a + p * r - q * s, b + p * s + q * r]
                })
            })
            .collect();
        for (found, exact) in ComplexFactors::new(&re, &im).solve(&right).iter().zip(&x) {
            assert!(libm::hypot(found[0] - exact[0], found[1] - exact[1]) < 1e-12);
        }
    }
}
