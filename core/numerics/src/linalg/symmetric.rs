//! Eigenvalues and vectors of a symmetric matrix.
//!
//! ```text
//! A = Q T Q^T      Householder reflections I - beta v v^T, column by column; T tridiagonal, diagonal d, beside it e                            (1)
//! T = Z D Z^T      QL steps with the shift of the first 2 x 2 block, plane rotations; where |e| is rounding of the rows so far, T falls apart    (2)
//! ```
//! Source: Golub and Van Loan, Matrix Computations, 8.3 (Wilkinson's shift: 8.3.4; his proof that (2) always converges: Linear Algebra Appl. 1, 1968; in numbers of finite length a
//! shift may be lost beside large rows, hence `PATIENT`).
//! Errors are rounding of the largest eigenvalue: small ones have few digits (more where entries grow or fall along the diagonal), which is why
//! [`super::symmetric_generalised`] asks for inverses.
//! One order of operations, in vectors of every width: the same bytes on every processor.
//! Verified by `the_spectrum_of_a_chain_is_its_closed_form`, `vectors_are_orthogonal_and_give_the_matrix_back`, `eigenvalues_over_many_decades_are_found_in_large_matrices`, `what_is_equal_and_what_is_tiny`.

use super::lanes::{add_scaled, kernel, turn_both};
use super::{Matrix, column_of, dot};

/// Most steps (2) per eigenvalue; three are usual.
const STEPS: usize = 60;
/// Steps per eigenvalue after which rounding of the largest eigenvalue counts as zero from then on: beside it a shift may be lost.
const PATIENT: usize = 20;
/// Number of rows of vectors that a step's rotations process together, so that they stay in the cache.
const PANEL: usize = 64;

/// A rotation of the columns i and i + 1.
#[derive(Debug, Clone, Copy)]
struct Rotation {
    i: usize,
    cos: f64,
    sin: f64,
}

/// Eigenvalues, in no particular order, and orthonormal eigenvectors in columns, of a symmetric matrix whose lower triangle is read. `None` if (2) does
/// not converge, for example for entries that are not finite.
#[must_use]
pub fn symmetric_eigen(a: &Matrix) -> Option<(Vec<f64>, Matrix)> {
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "a square matrix");
    if !a.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    // (1) keeps small entries accurate if large ones come first, (2) if small ones come first
    let back = |i: usize| n - 1 - i;
    let turned = n > 0 && a[(0, 0)].abs() < a[(n - 1, n - 1)].abs();
    let place = |i: usize| if turned { back(i) } else { i };
    let lower = |i: usize, j: usize| if i >= j { a[(i, j)] } else { a[(j, i)] };
    let (mut d, mut e, reflections, factors) = tridiagonal(Matrix::from_fn(n, n, |i, j| lower(place(i), place(j))));
    let q = accumulated(&reflections, &factors);
    d.reverse();
    e[..n.saturating_sub(1)].reverse();
    let mut vectors = Matrix::from_fn(n, n, |i, j| q[(place(i), back(j))]);
    diagonal(&mut d, &mut e, &mut vectors)?;
    Some((d, vectors))
}

/// Reduction (1) from the first column on: d, e, the vectors v of the reflections in columns, and their beta.
fn tridiagonal(mut a: Matrix) -> (Vec<f64>, Vec<f64>, Matrix, Vec<f64>) {
    let n = a.nrows();
    let (mut d, mut e, mut factors) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let (mut v, mut p) = (vec![0.0; n], vec![0.0; n]);
    for k in 0..n {
        d[k] = a[(k, k)];
        if k + 1 >= n {
            break;
        }
        let below = &column_of(&a, k)[k + 1..];
        let first = below[0];
        let size = below.len();
        let (v, p) = (&mut v[..size], &mut p[..size]);
        v.copy_from_slice(below);
        // scaled, so that no square over- or underflows
        let scale = v[1..].iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
        if scale == 0.0 {
            e[k] = first;
            continue;
        }
        let scale = scale.max(first.abs());
        v.iter_mut().for_each(|entry| *entry /= scale);
        let length = dot(v, v).sqrt();
        let turned = if v[0] > 0.0 { -length } else { length };
        e[k] = turned * scale;
        v[0] -= turned;
        // v.v = 2 (length^2 - v0 turned)
        let beta = 1.0 / (-turned * v[0]);
        factors[k] = beta;
        p.fill(0.0);
        for (j, &vj) in v.iter().enumerate() {
            add_scaled(vj, &column_of(&a, k + 1 + j)[k + 1..], p);
        }
        p.iter_mut().for_each(|entry| *entry *= beta);
        add_scaled(-0.5 * beta * dot(p, v), v, p);
        let entries = a.as_mut_slice();
        for j in 0..size {
            let from = (k + 1 + j) * n + k + 1;
            take_both([v[j], p[j]], p, v, &mut entries[from..from + size]);
        }
        entries[k * n + k + 1..(k + 1) * n].copy_from_slice(v);
    }
    (d, e, a, factors)
}

/// Q as the product of the reflections in the columns below the diagonal.
fn accumulated(reflections: &Matrix, factors: &[f64]) -> Matrix {
    let n = reflections.nrows();
    let mut q = Matrix::identity(n, n);
    // from the last reflection on: columns that are not reached yet are unit vectors
    for k in (0..n.saturating_sub(1)).rev().filter(|&k| factors[k] != 0.0) {
        let v = &column_of(reflections, k)[k + 1..];
        let entries = q.as_mut_slice();
        for j in k + 1..n {
            let column = &mut entries[j * n + k + 1..(j + 1) * n];
            let along = factors[k] * dot(v, column);
            add_scaled(-along, v, column);
        }
    }
    q
}

/// Iteration (2), with rotation of the vectors.
fn diagonal(d: &mut [f64], e: &mut [f64], vectors: &mut Matrix) -> Option<()> {
    let n = d.len();
    let whole = d.iter().zip(&*e).fold(0.0_f64, |most, (d, e)| most.max(d.abs() + e.abs()));
    let mut largest = f64::EPSILON * whole;
    let mut rotations = Vec::with_capacity(n);
    for first in 0..n {
        // largest of the rows so far: beside small entries, a smaller value matters
        largest = largest.max(d[first].abs() + e[first].abs());
        for step in 0.. {
            if step == PATIENT {
                largest = whole;
            }
            let nothing = f64::EPSILON * largest;
            let end = (first..n - 1).find(|&i| e[i].abs() <= nothing).unwrap_or(n - 1);
            if end == first {
                break;
            }
            if step == STEPS {
                return None;
            }
            rotations.clear();
            sweep(d, e, first, end, &mut rotations);
            turn(vectors, &rotations);
        }
    }
    Some(())
}

/// A QL step on the rows from first to end, which are decoupled from all others.
fn sweep(d: &mut [f64], e: &mut [f64], first: usize, end: usize, rotations: &mut Vec<Rotation>) {
    // the eigenvalue of the first 2 x 2 block that is nearer to its first entry
    let half = (d[first + 1] - d[first]) / (2.0 * e[first]);
    let root = libm::hypot(half, 1.0);
    let shift = d[first] - e[first] / (half + if half < 0.0 { -root } else { root });
    let mut bulge = d[end] - shift;
    let (mut cos, mut sin, mut taken) = (1.0, 1.0, 0.0);
    for i in (first..end).rev() {
        let (above, beside) = (sin * e[i], cos * e[i]);
        let length = libm::hypot(above, bulge);
        if i + 1 < end {
            e[i + 1] = length;
        }
        if length == 0.0 {
            // the matrix separates here
            d[i + 1] -= taken;
            return;
        }
        (sin, cos) = (above / length, bulge / length);
        let place = d[i + 1] - taken;
        let both = (d[i] - place) * sin + 2.0 * cos * beside;
        taken = sin * both;
        d[i + 1] = place + taken;
        bulge = cos * both - beside;
        rotations.push(Rotation { i, cos, sin });
    }
    d[first] -= taken;
    e[first] = bulge;
}

/// Rotates columns, panel by panel of rows.
fn turn(vectors: &mut Matrix, rotations: &[Rotation]) {
    let n = vectors.nrows();
    let entries = vectors.as_mut_slice();
    for from in (0..n).step_by(PANEL) {
        let to = (from + PANEL).min(n);
        for &Rotation { i, cos, sin } in rotations {
            let (left, right) = entries.split_at_mut((i + 1) * n);
            turn_both(cos, sin, &mut left[i * n + from..i * n + to], &mut right[from..to]);
        }
    }
}

kernel! {
    /// `y -= a x + b z`.
    fn take_both(factors: [f64; 2], x: &[f64], z: &[f64], y: &mut [f64]) {
        let [a, b] = factors;
        let count = y.len();
        let (x, z) = (&x[..count], &z[..count]);
        for i in 0..count {
            y[i] = y[i] - a * x[i] - b * z[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{mul, mul_tn};

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    fn checked(a: &Matrix) -> Vec<f64> {
        let n = a.nrows();
        let (values, vectors) = symmetric_eigen(a).expect("ends");
        let rounding = 1e-15 * (n as f64).sqrt() * 8.0;
        let size = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        assert!((mul_tn(&vectors, &vectors) - Matrix::identity(n, n)).amax() < rounding, "{n}: orthonormal");
        let scaled = Matrix::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
        assert!((mul(a, &vectors) - scaled).amax() <= rounding * size, "{n}: A z = d z");
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values
    }

    #[test]
    fn the_spectrum_of_a_chain_is_its_closed_form() {
        let n = 200;
        let a = Matrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        for (j, value) in checked(&a).into_iter().enumerate() {
            let exact = 4.0 * libm::sin((j + 1) as f64 * std::f64::consts::PI / (2 * n + 2) as f64).powi(2);
            assert!((value - exact).abs() < 2e-14, "{j}: {value} {exact}");
        }
    }

    #[test]
    fn vectors_are_orthogonal_and_give_the_matrix_back() {
        let mut seed = 1;
        for n in [1, 2, 3, 5, 8, 17, 63, 64, 65, 150] {
            let root = Matrix::from_fn(n, n, |_, _| random(&mut seed));
            let a = &root + root.transpose();
            let values = checked(&a);
            assert!((values.iter().sum::<f64>() - a.trace()).abs() < 1e-13 * n as f64);
            // of one sign, graded over thirty decades
            let graded = Matrix::from_fn(n, n, |i, j| a[(i, j)] * libm::exp2(-(100.0 / n as f64) * (i + j) as f64));
            checked(&graded);
            let turned = Matrix::from_fn(n, n, |i, j| graded[(n - 1 - i, n - 1 - j)]);
            checked(&turned);
        }
    }

    #[test]
    fn eigenvalues_over_many_decades_are_found_in_large_matrices() {
        let mut seed = 2;
        for (n, span) in [(200, 24.0), (400, 12.0), (400, 16.0), (400, 60.0)] {
            let root = Matrix::from_fn(n, n, |_, _| random(&mut seed));
            let graded = |i: usize| libm::exp2(-1.66 * span * i as f64 / n as f64);
            let a = mul(&root, &root.transpose());
            let a = Matrix::from_fn(n, n, |i, j| a[(i, j)] * graded(i) * graded(j) / n as f64);
            checked(&a);
            checked(&Matrix::from_fn(n, n, |i, j| a[(n - 1 - i, n - 1 - j)]));
        }
    }

    #[test]
    fn what_is_equal_and_what_is_tiny() {
        assert!(symmetric_eigen(&Matrix::zeros(0, 0)).is_some_and(|(values, _)| values.is_empty()));
        assert_eq!(checked(&Matrix::zeros(4, 4)), [0.0; 4]);
        assert_eq!(checked(&(Matrix::identity(9, 9) * 3.0)), [3.0; 9]);
        // a ring: pairs
        let n = 48;
        let ring = Matrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            apart if apart == n - 1 => -1.0,
            _ => 0.0,
        });
        for (size, values) in [1e-150, 1.0, 1e150].map(|size| (size, checked(&(&ring * size)))) {
            for pair in values[1..n - 1].chunks_exact(2) {
                assert!((pair[1] - pair[0]).abs() < 1e-14 * 4.0 * size, "{size}: {pair:?}");
            }
        }
        let mut bad = Matrix::identity(3, 3);
        bad[(1, 0)] = f64::NAN;
        assert!(symmetric_eigen(&bad).is_none());
    }
}
