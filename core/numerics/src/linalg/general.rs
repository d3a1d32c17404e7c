//! Eigenvalues and eigenvectors of any real matrix.
//!
//! ```text
//! A = Q H Q^T      Householder reflections; H zero below the first subdiagonal                                                                      (1)
//! H = Z T Z^T      QR steps with both eigenvalues of the last 2 x 2 block as shifts; T upper triangular but for 2 x 2 blocks of conjugates          (2)
//! (T - lambda) x = 0,   z = Q Z x       back substitution for each eigenvalue                                                                       (3)
//! ```
//! Source: Golub and Van Loan, Matrix Computations, 7.4 (1), 7.5 (2, Francis 1961), 7.6 (3).
//! The error is the rounding of the largest entry of A times the condition of the eigenvalue. The order of operations is the same for vectors of
//! every width, so the bytes are the same on every processor. Verified by `general_tests.rs`.

use super::lanes::{add_scaled, kernel, turn_both};
use super::{Matrix, column_of, dot};
use nalgebra::Complex;

/// Most steps (2) per block: for nearly equal eigenvalues with nearly parallel vectors, each step halves the remainder. After [`STALLED`] and twice
/// as many steps, a shift independent of the eigenvalues is used, because a matrix that is symmetric in its shifts may not change. The exceptional
/// shift is not used more often, as it undoes the halving.
const STEPS: usize = 300;
const STALLED: usize = 10;
/// Steps per block after which rounding of the largest entry counts as zero, too: an undamped oscillation has a diagonal close to zero.
const PATIENT: usize = 30;
/// Size of an entry of x above which x is scaled down.
const LARGE: f64 = 1e100;

/// A reflection `I - beta v v^T` of two or three numbers.
#[derive(Debug, Clone, Copy)]
struct Reflection {
    v: [f64; 3],
    beta: f64,
    /// First component after the reflection; the others become zero.
    first: f64,
}

/// Eigenvalues (re, im) in no particular order, including both of a conjugate pair, and vectors of length 1 (re and im parts in columns). `None` if
/// (2) does not converge, for example for entries that are not finite.
#[must_use]
pub fn general_eigen(a: &Matrix) -> Option<(Vec<[f64; 2]>, Matrix, Matrix)> {
    let n = a.nrows();
    let (mut h, unit) = scaled(a)?;
    let mut q = Matrix::identity(n, n);
    hessenberg(&mut h, Some(&mut q));
    triangular(&mut h, Some(&mut q))?;
    let (mut values, mut re, mut im) = (vec![[0.0; 2]; n], Matrix::zeros(n, n), Matrix::zeros(n, n));
    let mut k = 0;
    while k < n {
        let size = block_at(&h, k);
        let value = eigenvalue(&h, k, size);
        let x = solution(&h, k, size, value);
        let (real, imaginary) = combined(&q, &x);
        values[k] = [unit * value.re, unit * value.im];
        re.column_mut(k).copy_from_slice(&real);
        im.column_mut(k).copy_from_slice(&imaginary);
        if size == 2 {
            values[k + 1] = [unit * value.re, -unit * value.im];
            re.column_mut(k + 1).copy_from_slice(&real);
            im.column_mut(k + 1).iter_mut().zip(&imaginary).for_each(|(entry, part)| *entry = -part);
        }
        k += size;
    }
    Some((values, re, im))
}

/// Eigenvalues of [`general_eigen`] without vectors, at a third of its cost.
#[must_use]
pub fn general_eigenvalues(a: &Matrix) -> Option<Vec<[f64; 2]>> {
    let n = a.nrows();
    let (mut h, unit) = scaled(a)?;
    hessenberg(&mut h, None);
    triangular(&mut h, None)?;
    let mut values = Vec::with_capacity(n);
    while values.len() < n {
        let (k, size) = (values.len(), block_at(&h, values.len()));
        let value = eigenvalue(&h, k, size);
        values.push([unit * value.re, unit * value.im]);
        if size == 2 {
            values.push([unit * value.re, -unit * value.im]);
        }
    }
    Some(values)
}

/// A divided by a power of two, so that no product of two entries over- or underflows, and that power; `None` if an entry is not finite.
fn scaled(a: &Matrix) -> Option<(Matrix, f64)> {
    assert_eq!(a.nrows(), a.ncols(), "a square matrix");
    if !a.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let unit = libm::exp2(f64::from(libm::ilogb(a.amax()).clamp(-1000, 1000)));
    let unit = if a.amax() > 0.0 { unit } else { 1.0 };
    Some((a.map(|entry| entry / unit), unit))
}

/// Reduction (1), with accumulation of Q if given.
fn hessenberg(h: &mut Matrix, mut q: Option<&mut Matrix>) {
    let n = h.nrows();
    let mut w = vec![0.0; n];
    for k in 0..n.saturating_sub(2) {
        let mut v = column_of(h, k)[k + 1..].to_vec();
        let scale = v.iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
        if v[1..].iter().all(|&entry| entry == 0.0) {
            continue;
        }
        v.iter_mut().for_each(|entry| *entry /= scale);
        let length = dot(&v, &v).sqrt();
        let turned = if v[0] > 0.0 { -length } else { length };
        v[0] -= turned;
        let beta = 1.0 / (-turned * v[0]);
        let entries = h.as_mut_slice();
        entries[k * n + k + 1] = turned * scale;
        entries[k * n + k + 2..(k + 1) * n].fill(0.0);
        for j in k + 1..n {
            let column = &mut entries[j * n + k + 1..(j + 1) * n];
            let along = beta * dot(&v, column);
            add_scaled(-along, &v, column);
        }
        for matrix in std::iter::once(&mut *h).chain(q.as_deref_mut()) {
            w.fill(0.0);
            for (j, &vj) in v.iter().enumerate() {
                add_scaled(vj, column_of(matrix, k + 1 + j), &mut w);
            }
            let entries = matrix.as_mut_slice();
            for (j, &vj) in v.iter().enumerate() {
                add_scaled(-beta * vj, &w, &mut entries[(k + 1 + j) * n..(k + 2 + j) * n]);
            }
        }
    }
}

/// Iteration (2); `q` is multiplied by Z. Without `q`, rows and columns beside the active block are not updated: the eigenvalues do not depend on them.
fn triangular(h: &mut Matrix, mut q: Option<&mut Matrix>) -> Option<()> {
    let size = h.amax();
    let (mut end, mut steps) = (h.nrows(), 0);
    while end > 0 {
        let last = end - 1;
        let least = if steps < PATIENT { 0.0 } else { size };
        let first = (1..end).rev().find(|&i| is_nothing(h, i, least, size)).unwrap_or(0);
        if first > 0 {
            h[(first, first - 1)] = 0.0;
        }
        if first == last {
            (end, steps) = (last, 0);
        } else if first + 1 == last && !splits(h, q.as_deref_mut(), first) {
            (end, steps) = (first, 0);
        } else if first + 1 == last {
            (end, steps) = (last, 0);
        } else {
            steps += 1;
            if steps > STEPS {
                return None;
            }
            step(h, q.as_deref_mut(), [first, last], steps == STALLED || steps == 2 * STALLED);
        }
    }
    Some(())
}

/// Whether the subdiagonal entry of a row is at most the rounding of its diagonal neighbours, or of `least`; if both are zero, of the largest entry.
fn is_nothing(h: &Matrix, i: usize, least: f64, size: f64) -> bool {
    let beside = (h[(i - 1, i - 1)].abs() + h[(i, i)].abs()).max(least);
    let beside = if beside == 0.0 { size } else { beside };
    h[(i, i - 1)].abs() <= f64::EPSILON * beside
}

/// Makes a 2 x 2 block triangular if its eigenvalues are real.
fn splits(h: &mut Matrix, q: Option<&mut Matrix>, k: usize) -> bool {
    let n = h.nrows();
    let [[a, b], [c, d]] = block(h, k);
    let half = 0.5 * (a - d);
    // scaled, so that no square over- or underflows
    let scale = half.abs().max(b.abs()).max(c.abs());
    let square = (half / scale) * (half / scale) + (b / scale) * (c / scale);
    if square < 0.0 {
        return false;
    }
    let root = scale * square.sqrt();
    // vector of the block for the eigenvalue without cancellation
    let along = if half < 0.0 { half - root } else { half + root };
    let length = libm::hypot(along, c);
    let (cos, sin) = (along / length, c / length);
    for j in k..n {
        let (x, y) = (h[(k, j)], h[(k + 1, j)]);
        (h[(k, j)], h[(k + 1, j)]) = (cos * x + sin * y, cos * y - sin * x);
    }
    let (left, right) = h.as_mut_slice().split_at_mut((k + 1) * n);
    turn_both(cos, -sin, &mut left[k * n..k * n + k + 2], &mut right[..k + 2]);
    if let Some(q) = q {
        let (left, right) = q.as_mut_slice().split_at_mut((k + 1) * n);
        turn_both(cos, -sin, &mut left[k * n..(k + 1) * n], &mut right[..n]);
    }
    h[(k + 1, k)] = 0.0;
    true
}

/// One step (2) on the rows from first to last, which are decoupled from the others below the diagonal.
fn step(h: &mut Matrix, mut q: Option<&mut Matrix>, [first, last]: [usize; 2], stalled: bool) {
    let n = h.nrows();
    // diagonal of the last block, and product of its other two entries
    let (shifts, product) = if stalled {
        let size = h[(last, last - 1)].abs() + h[(last - 1, last - 2)].abs();
        ([h[(last, last)] + 0.75 * size; 2], -0.4375 * size * size)
    } else {
        let [[a, b], [c, d]] = block(h, last - 1);
        ([a, d], b * c)
    };
    // first column of (H - s1)(H - s2), starting at a row before which the entries are small enough; computed from differences, which are small among
    // neighbours
    let start = |h: &Matrix, m: usize| {
        let ([[a, b], [c, d]], e) = (block(h, m), h[(m + 2, m + 1)]);
        let [r, s] = shifts.map(|shift| shift - a);
        // divided by c, which is not negligible
        [(r * s - product) / c + b, (d - a) - r - s, e]
    };
    let quiet = |h: &Matrix, m: usize| {
        let [x, y, z] = start(h, m);
        let beside = h[(m - 1, m - 1)].abs() + h[(m, m)].abs() + h[(m + 1, m + 1)].abs();
        h[(m, m - 1)].abs() * (y.abs() + z.abs()) <= f64::EPSILON * x.abs() * beside
    };
    let m = (first + 1..=last - 2).rev().find(|&m| quiet(h, m)).unwrap_or(first);
    for k in m..last {
        let three = k + 1 < last;
        let column = if k == m {
            start(h, m)
        } else {
            [h[(k, k - 1)], h[(k + 1, k - 1)], if three { h[(k + 2, k - 1)] } else { 0.0 }]
        };
        let column = if three { column } else { [column[0], column[1], 0.0] };
        let Some(reflection) = reflection(column) else { continue };
        let Reflection { v, beta, first: turned } = reflection;
        let count = if three { 3 } else { 2 };
        if k > m {
            h[(k, k - 1)] = turned;
            for i in 1..count {
                h[(k + i, k - 1)] = 0.0;
            }
        } else if k > first {
            h[(k, k - 1)] *= 1.0 - beta * v[0] * v[0];
        }
        let entries = h.as_mut_slice();
        let columns = if q.is_some() { n } else { last + 1 };
        for j in k..columns {
            let rows = &mut entries[j * n + k..j * n + k + count];
            let along = beta * rows.iter().zip(v).map(|(row, v)| row * v).sum::<f64>();
            rows.iter_mut().zip(v).for_each(|(row, v)| *row -= along * v);
        }
        reflect_columns(h, k, (last + 1).min(k + 4), count, &reflection);
        if let Some(q) = q.as_deref_mut() {
            reflect_columns(q, k, n, count, &reflection);
        }
    }
}

/// The reflection of two or three numbers to the first axis; `None` if the others are zero already.
fn reflection(x: [f64; 3]) -> Option<Reflection> {
    let scale = x.iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    if x[1] == 0.0 && x[2] == 0.0 {
        return None;
    }
    let mut v = x.map(|entry| entry / scale);
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let turned = if v[0] > 0.0 { -length } else { length };
    v[0] -= turned;
    Some(Reflection { v, beta: 1.0 / (-turned * v[0]), first: turned * scale })
}

/// Reflects the first `rows` rows of the columns from k on.
fn reflect_columns(matrix: &mut Matrix, k: usize, rows: usize, count: usize, reflection: &Reflection) {
    let n = matrix.nrows();
    let (x, rest) = matrix.as_mut_slice()[k * n..(k + count) * n].split_at_mut(n);
    let (y, z) = rest.split_at_mut(n);
    let Reflection { v, beta, .. } = *reflection;
    if count == 3 {
        reflect_three(v, beta, &mut x[..rows], &mut y[..rows], &mut z[..rows]);
    } else {
        reflect_two(v, beta, &mut x[..rows], &mut y[..rows]);
    }
}

fn block(h: &Matrix, k: usize) -> [[f64; 2]; 2] {
    [[h[(k, k)], h[(k, k + 1)]], [h[(k + 1, k)], h[(k + 1, k + 1)]]]
}

/// Size of the block of T that begins in row k.
fn block_at(t: &Matrix, k: usize) -> usize {
    if k + 1 < t.nrows() && t[(k + 1, k)] != 0.0 { 2 } else { 1 }
}

/// Eigenvalue of a block; of two conjugates the one with im > 0.
fn eigenvalue(t: &Matrix, k: usize, size: usize) -> Complex<f64> {
    if size == 1 {
        return Complex::new(t[(k, k)], 0.0);
    }
    let [[a, b], [c, d]] = block(t, k);
    let half = 0.5 * (a - d);
    let scale = half.abs().max(b.abs()).max(c.abs());
    let square = -((half / scale) * (half / scale) + (b / scale) * (c / scale));
    Complex::new(0.5 * (a + d), scale * square.max(0.0).sqrt())
}

/// Solution x of (3) for the eigenvalue of the block that begins in row k; zero behind the block.
fn solution(t: &Matrix, k: usize, size: usize, value: Complex<f64>) -> [Vec<f64>; 2] {
    let n = t.nrows();
    // its square does not underflow
    let least = (f64::EPSILON * t.amax()).max(1e-150);
    let size_of = |z: Complex<f64>| z.re.abs().max(z.im.abs());
    let mut x = vec![Complex::new(0.0, 0.0); n];
    // sum of known terms in each row
    let mut sums = [vec![0.0; n], vec![0.0; n]];
    if size == 1 {
        x[k] = Complex::new(1.0, 0.0);
    } else {
        let [[a, b], [c, d]] = block(t, k);
        let one = Complex::new(1.0, 0.0);
        (x[k], x[k + 1]) = if b.abs() >= c.abs() { (one, (value - a) / b) } else { ((value - d) / c, one) };
    }
    for j in k..k + size {
        spread(t, j, k, x[j], &mut sums);
    }
    let mut end = k;
    while end > 0 {
        let from = if end > 1 && t[(end - 1, end - 2)] != 0.0 { end - 2 } else { end - 1 };
        let right = |i: usize, sums: &[Vec<f64>; 2]| -Complex::new(sums[0][i], sums[1][i]);
        if from + 1 == end {
            let mut pivot = Complex::new(t[(from, from)], 0.0) - value;
            if size_of(pivot) < least {
                pivot = Complex::new(least, 0.0);
            }
            x[from] = right(from, &sums) / pivot;
        } else {
            let [[a, b], [c, d]] = block(t, from);
            let real = |x: f64| Complex::new(x, 0.0);
            let matrix = [[real(a) - value, real(b)], [real(c), real(d) - value]];
            let sides = [right(from, &sums), right(from + 1, &sums)];
            [x[from], x[from + 1]] = of_two(matrix, sides, least);
        }
        let largest = x[from..end].iter().fold(0.0_f64, |most, x| most.max(x.re.abs()).max(x.im.abs()));
        if largest > LARGE {
            x.iter_mut().for_each(|x| *x /= largest);
            sums.iter_mut().flatten().for_each(|sum| *sum /= largest);
        }
        for j in from..end {
            spread(t, j, from, x[j], &mut sums);
        }
        end = from;
    }
    [x.iter().map(|x| x.re).collect(), x.iter().map(|x| x.im).collect()]
}

/// Solves two equations by elimination with full pivoting. For a nearly singular matrix, the solution still satisfies the equations to rounding,
/// unlike one by determinants. The second pivot is at least `least`.
fn of_two(m: [[Complex<f64>; 2]; 2], sides: [Complex<f64>; 2], least: f64) -> [Complex<f64>; 2] {
    let size_of = |z: Complex<f64>| z.re.abs().max(z.im.abs());
    let (mut row, mut column) = (0, 0);
    for (i, j) in [(0, 1), (1, 0), (1, 1)] {
        if size_of(m[i][j]) > size_of(m[row][column]) {
            (row, column) = (i, j);
        }
    }
    let (other, beside) = (1 - row, 1 - column);
    let mut pivot = m[row][column];
    if size_of(pivot) < least {
        pivot = Complex::new(least, 0.0);
    }
    let factor = m[other][column] / pivot;
    let mut rest = m[other][beside] - factor * m[row][beside];
    if size_of(rest) < least {
        rest = Complex::new(least, 0.0);
    }
    let mut x = [Complex::new(0.0, 0.0); 2];
    x[beside] = (sides[other] - factor * sides[row]) / rest;
    x[column] = (sides[row] - m[row][beside] * x[beside]) / pivot;
    x
}

/// Adds a column of T times an entry of x to the sums of the rows above a block.
fn spread(t: &Matrix, j: usize, rows: usize, x: Complex<f64>, sums: &mut [Vec<f64>; 2]) {
    let column = &column_of(t, j)[..rows];
    add_scaled(x.re, column, &mut sums[0][..rows]);
    add_scaled(x.im, column, &mut sums[1][..rows]);
}

/// `Q x`, normalised to length 1.
fn combined(q: &Matrix, x: &[Vec<f64>; 2]) -> (Vec<f64>, Vec<f64>) {
    let n = q.nrows();
    let [mut re, mut im] = [vec![0.0; n], vec![0.0; n]];
    let largest = x.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (j, (real, imaginary)) in x[0].iter().zip(&x[1]).enumerate() {
        if *real != 0.0 {
            add_scaled(real / largest, column_of(q, j), &mut re);
        }
        if *imaginary != 0.0 {
            add_scaled(imaginary / largest, column_of(q, j), &mut im);
        }
    }
    let length = (dot(&re, &re) + dot(&im, &im)).sqrt();
    [&mut re, &mut im].into_iter().flatten().for_each(|entry| *entry /= length);
    (re, im)
}

kernel! {
    /// Subtracts `beta (v0 x + v1 y + v2 z)` times v from three columns.
    fn reflect_three(v: [f64; 3], beta: f64, x: &mut [f64], y: &mut [f64], z: &mut [f64]) {
        let count = x.len();
        let (y, z) = (&mut y[..count], &mut z[..count]);
        for i in 0..count {
            let along = beta * (v[0] * x[i] + v[1] * y[i] + v[2] * z[i]);
            x[i] -= along * v[0];
            y[i] -= along * v[1];
            z[i] -= along * v[2];
        }
    }
}

kernel! {
    /// Subtracts `beta (v0 x + v1 y)` times v from two columns.
    fn reflect_two(v: [f64; 3], beta: f64, x: &mut [f64], y: &mut [f64]) {
        let count = x.len();
        let y = &mut y[..count];
        for i in 0..count {
            let along = beta * (v[0] * x[i] + v[1] * y[i]);
            x[i] -= along * v[0];
            y[i] -= along * v[1];
        }
    }
}
