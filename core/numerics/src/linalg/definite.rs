//! Cholesky factorisation and triangular systems with many right sides, eight of them at a time.
//!
//! ```text
//! A = L L^T,   L Y = B,   L^T X = Y          column by column of B, in nalgebra's order of operations: the same bytes as its
//! ```
//! nalgebra uses strides that it knows at run time only, one number at a time; here eight right sides are adjacent in memory. A study
//! whose samples each have their own structure solves a few such systems per sample.
//! Verified by `factors_and_solutions_are_those_of_nalgebra_bit_for_bit`.

use super::lanes::{LANES, Lane, add_scaled, kernel};
use super::{Matrix, column_of};

/// Number of accumulators of nalgebra's dot product.
const SUMS: usize = 8;
/// Number of accumulators that fit in registers.
const TOGETHER: usize = 4;

/// Lower triangular factor of a symmetric matrix, with zeros above the diagonal; `None` if the matrix is not positive definite. Only the lower
/// triangle of `a` is read.
#[must_use]
pub fn cholesky(a: &Matrix) -> Option<Matrix> {
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "a square matrix");
    let mut l = a.clone();
    let entries = l.as_mut_slice();
    for j in 0..n {
        let (before, rest) = entries.split_at_mut(j * n);
        let column = &mut rest[..n];
        for before in before.chunks_exact(n) {
            add_scaled(-before[j], &before[j..], &mut column[j..]);
        }
        let square = column[j];
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        let root = square.sqrt();
        column[..j].fill(0.0);
        column[j] = root;
        column[j + 1..].iter_mut().for_each(|entry| *entry /= root);
    }
    Some(l)
}

/// Solves `L Y = B` for Y.
#[must_use]
pub fn solve_lower(l: &Matrix, b: &Matrix) -> Matrix {
    assert_eq!(l.nrows(), b.nrows(), "rows of both sides");
    by_eights(b, |rows| forward(l.nrows(), l.as_slice(), rows))
}

/// Solves `L^T X = Y` for X by columns of L^T, as nalgebra solves an upper triangular system.
#[must_use]
pub fn solve_upper(l: &Matrix, y: &Matrix) -> Matrix {
    assert_eq!(l.nrows(), y.nrows(), "rows of both sides");
    let upper = l.transpose();
    by_eights(y, |rows| backward_by_columns(upper.nrows(), upper.as_slice(), rows))
}

/// Inverse of a symmetric matrix; `None` if the matrix is not positive definite.
#[must_use]
pub fn spd_inverse(a: &Matrix) -> Option<Matrix> {
    let l = cholesky(a)?;
    let n = l.nrows();
    let unit = Matrix::identity(n, n);
    Some(by_eights(&unit, |rows| {
        forward(n, l.as_slice(), rows);
        backward_by_rows(n, l.as_slice(), rows);
    }))
}

/// Applies `change` to the columns of B, eight at a time, stored by rows; missing columns are zero.
fn by_eights(b: &Matrix, mut change: impl FnMut(&mut [Lane])) -> Matrix {
    let mut found = Matrix::zeros(b.nrows(), b.ncols());
    let mut rows = vec![Lane::default(); b.nrows()];
    for first in (0..b.ncols()).step_by(LANES) {
        let count = LANES.min(b.ncols() - first);
        rows.fill(Lane::default());
        for k in 0..count {
            for (row, entry) in rows.iter_mut().zip(column_of(b, first + k)) {
                row.0[k] = *entry;
            }
        }
        change(&mut rows);
        for k in 0..count {
            for (row, entry) in rows.iter().zip(found.column_mut(first + k).iter_mut()) {
                *entry = row.0[k];
            }
        }
    }
    found
}

/// Subtracts columns from the rows below them, one column after the other. Each right side has its own factor per column.
#[inline(always)]
fn take(columns: [&[f64]; TOGETHER], factors: &[[f64; LANES]; TOGETHER], rows: &mut [Lane]) {
    let count = rows.len();
    let [a, b, c, d] = columns.map(|column| &column[..count]);
    for i in 0..count {
        let entries = [a[i], b[i], c[i], d[i]];
        let mut row = rows[i].0;
        for m in 0..TOGETHER {
            for k in 0..LANES {
                row[k] += -factors[m][k] * entries[m];
            }
        }
        rows[i].0 = row;
    }
}

kernel! {
    /// Solves `L y = b`.
    fn forward(n: usize, l: &[f64], b: &mut [Lane]) {
        // leading zeros stay zeros; negative zeros would change sign
        let first = b.iter().position(|row| row.0.iter().any(|entry| entry.to_bits() != 0)).unwrap_or(n);
        let mut i = first;
        while i < n {
            let count = if i + TOGETHER <= n { TOGETHER } else { 1 };
            let mut factors = [[0.0; LANES]; TOGETHER];
            for m in 0..count {
                let column = &l[(i + m) * n..(i + m + 1) * n];
                let mut row = b[i + m].0;
                for k in 0..LANES {
                    row[k] /= column[i + m];
                }
                (b[i + m].0, factors[m]) = (row, row);
                // rows of this group; for a single row, all rows below
                let end = if count == 1 { n } else { i + count };
                for r in i + m + 1..end {
                    for k in 0..LANES {
                        b[r].0[k] += -row[k] * column[r];
                    }
                }
            }
            if count == TOGETHER {
                let columns = std::array::from_fn(|m| &l[(i + m) * n + i + TOGETHER..(i + m + 1) * n]);
                take(columns, &factors, &mut b[i + TOGETHER..n]);
            }
            i += count;
        }
    }
}

kernel! {
    /// Solves `U x = b`.
    fn backward_by_columns(n: usize, upper: &[f64], b: &mut [Lane]) {
        let mut end = n;
        while end > 0 {
            let count = if end >= TOGETHER { TOGETHER } else { 1 };
            let mut factors = [[0.0; LANES]; TOGETHER];
            for m in 0..count {
                let i = end - 1 - m;
                let column = &upper[i * n..i * n + i + 1];
                let mut row = b[i].0;
                for k in 0..LANES {
                    row[k] /= column[i];
                }
                (b[i].0, factors[m]) = (row, row);
                let from = if count == 1 { 0 } else { end - count };
                for r in from..i {
                    for k in 0..LANES {
                        b[r].0[k] += -row[k] * column[r];
                    }
                }
            }
            if count == TOGETHER {
                let columns = std::array::from_fn(|m| &upper[(end - 1 - m) * n..(end - m) * n]);
                take(columns, &factors, &mut b[..end - TOGETHER]);
            }
            end -= count;
        }
    }
}

kernel! {
    /// Solves `L^T x = b` by products with the columns of L, in eight interleaved sums.
    fn backward_by_rows(n: usize, l: &[f64], b: &mut [Lane]) {
        for i in (0..n).rev() {
            let (here, below) = b[i..n].split_at_mut(1);
            let column = &l[i * n + i..(i + 1) * n];
            let (eights, rest) = column[1..].as_chunks::<SUMS>();
            let (lanes, last) = below.as_chunks::<SUMS>();
            let mut sums = [[0.0; LANES]; SUMS];
            for half in 0..SUMS / TOGETHER {
                let mut some = [[0.0; LANES]; TOGETHER];
                for (entries, lanes) in eights.iter().zip(lanes) {
                    for m in 0..TOGETHER {
                        let (entry, lane) = (entries[half * TOGETHER + m], &lanes[half * TOGETHER + m].0);
                        for k in 0..LANES {
                            some[m][k] += entry * lane[k];
                        }
                    }
                }
                sums[half * TOGETHER..][..TOGETHER].copy_from_slice(&some);
            }
            let mut whole = [0.0; LANES];
            for m in 0..TOGETHER {
                for k in 0..LANES {
                    whole[k] += sums[m][k] + sums[m + TOGETHER][k];
                }
            }
            for (entry, lane) in rest.iter().zip(last) {
                for k in 0..LANES {
                    whole[k] += entry * lane.0[k];
                }
            }
            for k in 0..LANES {
                here[0].0[k] = (here[0].0[k] - whole[k]) / column[0];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same(one: &Matrix, other: &Matrix) -> bool {
        one.shape() == other.shape() && one.iter().zip(other.iter()).all(|(a, b)| a.to_bits() == b.to_bits())
    }

    #[test]
    fn factors_and_solutions_are_those_of_nalgebra_bit_for_bit() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for n in [1, 2, 3, 7, 8, 9, 17, 40, 61] {
            let root = Matrix::from_fn(n, n, |_, _| random());
            let a = super::super::mul_tn(&root, &root) + Matrix::identity(n, n) * 1e-3;
            let mut b = Matrix::from_fn(n, n + 3, |_, _| random());
            // right sides that begin with zeros, of both signs
            for j in 0..n.saturating_sub(1) {
                b.view_mut((0, j), (j, 1)).fill(if j % 3 == 0 { -0.0 } else { 0.0 });
            }
            let theirs = nalgebra::Cholesky::new(a.clone()).expect("definite");
            let l = cholesky(&a).expect("definite");
            assert!(same(&l, &theirs.l()), "{n}");
            assert!(same(&solve_lower(&l, &b), &theirs.l().solve_lower_triangular(&b).expect("regular")), "{n}");
            let upper = theirs.l().transpose().solve_upper_triangular(&b).expect("regular");
            assert!(same(&solve_upper(&l, &b), &upper), "{n}");
            assert!(same(&spd_inverse(&a).expect("definite"), &theirs.inverse()), "{n}");
        }
    }

    #[test]
    fn what_is_not_definite_has_no_factor() {
        for bad in [-1.0, 0.0, f64::NAN] {
            let mut a = Matrix::identity(3, 3);
            a[(1, 1)] = bad;
            assert!(cholesky(&a).is_none() && spd_inverse(&a).is_none(), "{bad}");
        }
    }
}
