//! Dense and sparse linear algebra with one operation order.
//!
//! Products, factors and eigenvalue problems are plain loops, so that a sample's bytes are the same on every x86-64 (nalgebra's own product of large
//! matrices selects kernels by CPU). Results for display only, which do not enter a run, are computed by faer (`display.rs`).

mod definite;
mod display;
mod eigen;
mod general;
#[cfg(test)]
mod general_tests;
pub mod lanes;
mod sparse;
mod symmetric;

pub use definite::{cholesky, solve_lower, solve_upper, spd_inverse};
pub use display::{ComplexFactors, complex_eigen_display};
pub use eigen::{EigenError, complex_eigen, complex_eigenvalues, symmetric_generalised};
pub use sparse::Csr;

/// Column-major dense matrix of f64.
pub type Matrix = nalgebra::DMatrix<f64>;
/// Column of f64.
pub type Vector = nalgebra::DVector<f64>;

/// C = A B, summed over the inner index in ascending order.
#[must_use]
pub fn mul(a: &Matrix, b: &Matrix) -> Matrix {
    assert_eq!(a.ncols(), b.nrows(), "inner dimensions of a product");
    let mut c = Matrix::zeros(a.nrows(), b.ncols());
    lanes::product([a.nrows(), a.ncols(), b.ncols()], a.as_slice(), b.as_slice(), c.as_mut_slice());
    c
}

/// C = A^T B.
#[must_use]
pub fn mul_tn(a: &Matrix, b: &Matrix) -> Matrix {
    mul(&a.transpose(), b)
}

/// A^T K A, the projection of K on the columns of A.
#[must_use]
pub fn project(k: &Matrix, a: &Matrix) -> Matrix {
    mul_tn(a, &mul(k, a))
}

/// y = A x by columns.
pub fn mul_vec(a: &Matrix, x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    for (j, &xj) in x.iter().enumerate() {
        axpy(xj, column_of(a, j), y);
    }
}

/// y = A^T x: one dot product per column.
pub fn mul_transposed_vec(a: &Matrix, x: &[f64], y: &mut [f64]) {
    for (j, yj) in y.iter_mut().enumerate() {
        *yj = dot(column_of(a, j), x);
    }
}

/// Column j of a column-major matrix.
#[must_use]
pub fn column_of(a: &Matrix, j: usize) -> &[f64] {
    let rows = a.nrows();
    &a.as_slice()[j * rows..(j + 1) * rows]
}

/// y += a x.
pub fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    lanes::add_scaled(a, x, y);
}

/// Dot product in four interleaved partial sums: a fixed order that vectorises on every x86-64.
#[inline]
#[must_use]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (xc, yc) = (x.chunks_exact(4), y.chunks_exact(4));
    let mut tail = 0.0;
    for (a, b) in xc.remainder().iter().zip(yc.remainder()) {
        tail += a * b;
    }
    for (a, b) in xc.zip(yc) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    ((sums[0] + sums[1]) + (sums[2] + sums[3])) + tail
}

/// Length of a vector.
#[inline]
#[must_use]
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Length of x - y, summed in ascending order.
#[inline]
#[must_use]
pub fn distance(x: &[f64], y: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in x.iter().zip(y) {
        sum += (a - b) * (a - b);
    }
    sum.sqrt()
}

/// A += f x x^T.
pub fn add_outer(a: &mut Matrix, factor: f64, x: &[f64]) {
    if factor == 0.0 {
        return;
    }
    for (j, right) in x.iter().enumerate() {
        for (i, left) in x.iter().enumerate() {
            a[(i, j)] += factor * left * right;
        }
    }
}

/// Inverse of a general matrix by partially pivoted elimination; `None` if it is singular.
#[must_use]
pub fn inverse(a: &Matrix) -> Option<Matrix> {
    nalgebra::LU::new(a.clone()).try_inverse()
}

/// Solution of A x = b by partially pivoted elimination; `None` if A is singular.
#[must_use]
pub fn solve(a: &Matrix, b: &Vector) -> Option<Vector> {
    nalgebra::LU::new(a.clone()).solve(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(rows: usize, cols: usize) -> Matrix {
        Matrix::from_fn(rows, cols, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.0)
    }

    #[test]
    fn products_agree_with_the_definition() {
        let (a, b) = (sample(9, 7), sample(7, 8));
        let c = mul(&a, &b);
        for i in 0..9 {
            for j in 0..8 {
                let sum: f64 = (0..7).map(|k| a[(i, k)] * b[(k, j)]).sum();
                assert!((c[(i, j)] - sum).abs() < 1e-12);
            }
        }
        let x: Vec<f64> = (0..7).map(f64::from).collect();
        let mut y = vec![0.0; 9];
        mul_vec(&a, &x, &mut y);
        let mut z = vec![0.0; 7];
        mul_transposed_vec(&a, &y, &mut z);
        let direct = mul_tn(&a, &Matrix::from_column_slice(9, 1, &y));
        for i in 0..7 {
            assert!((z[i] - direct[(i, 0)]).abs() < 1e-9);
        }
    }

    #[test]
    fn inverse_of_a_definite_matrix_inverts_it() {
        let a = sample(6, 6);
        let spd = mul_tn(&a, &a) + Matrix::identity(6, 6) * 3.0;
        let product = mul(&spd_inverse(&spd).expect("definite"), &spd);
        assert!((product - Matrix::identity(6, 6)).amax() < 1e-10);
        assert!(spd_inverse(&(Matrix::identity(3, 3) * -1.0)).is_none());
    }
}
