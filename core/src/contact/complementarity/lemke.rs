//! Linear complementarity problems by Lemke's method.
//!
//! ```text
//! w = M z + q,   w >= 0,   z >= 0,   w_i z_i = 0
//! ```
//! One artificial variable covers every negative q; complementary pivots remove it from the basis. For a copositive M (contact with friction,
//! formulated as in `linear`) the method ends with a solution, apart from rounding.
//! Source: Lemke 1965; Cottle, Pang, Stone 1992, section 4.4. Verified by `lemke_solves_what_was_made_up`.

/// Smallest pivot that is not rounding, for entries of the order of one.
const ROUNDING: f64 = 1e-12;
/// Largest difference of two ratios that counts as a tie.
const TIE: f64 = 1e-11;

/// Solution z, or `None` if the method ends on a ray. `m` by rows, scaled to entries of the order of one.
pub(super) fn lemke(m: &[f64], q: &[f64]) -> Option<Vec<f64>> {
    let size = q.len();
    let covering = 2 * size;
    let right = covering + 1;
    let width = right + 1;
    // columns: w (0..size), z (size..2 size), the artificial variable, the right-hand side
    let mut table = vec![0.0; size * width];
    for i in 0..size {
        let row = &mut table[i * width..(i + 1) * width];
        row[i] = 1.0;
        for j in 0..size {
            row[size + j] = -m[i * size + j];
        }
        row[covering] = -1.0;
        row[right] = q[i];
    }
    let mut basis: Vec<usize> = (0..size).collect();
    let mut row = (0..size).min_by(|&a, &b| q[a].total_cmp(&q[b]))?;
    if q[row] >= 0.0 {
        return Some(vec![0.0; size]);
    }
    let mut entering = covering;
    for _ in 0..50 * size {
        let leaving = basis[row];
        pivot(&mut table, width, row, entering);
        basis[row] = entering;
        if leaving == covering {
            let mut z = vec![0.0; size];
            for (i, &column) in basis.iter().enumerate() {
                if (size..covering).contains(&column) {
                    z[column - size] = table[i * width + right].max(0.0);
                }
            }
            return Some(z);
        }
        entering = if leaving < size { leaving + size } else { leaving - size };
        row = ratio_test(&table, width, entering)?;
    }
    None
}

/// Row that limits the entering variable first. Ties are frequent, because a sliding point has no slip left to cover. A wrong choice ends on a ray,
/// so the lexicographic order of the rows breaks ties.
fn ratio_test(table: &[f64], width: usize, entering: usize) -> Option<usize> {
    let rows = || table.chunks_exact(width);
    let (size, right) = (rows().len(), width - 1);
    let before = |a: &[f64], b: &[f64]| {
        std::iter::once(right)
            .chain(0..size)
            .map(|column| a[column] / a[entering] - b[column] / b[entering])
            .find(|difference| difference.abs() > TIE)
            .is_some_and(|difference| difference < 0.0)
    };
    let mut best: Option<(usize, &[f64])> = None;
    for (i, row) in rows().enumerate().filter(|(_, row)| row[entering] > ROUNDING) {
        if best.is_none_or(|(_, least)| before(row, least)) {
            best = Some((i, row));
        }
    }
    best.map(|(i, _)| i)
}

fn pivot(table: &mut [f64], width: usize, row: usize, column: usize) {
    let scale = 1.0 / table[row * width + column];
    let top: Vec<f64> = table[row * width..(row + 1) * width].iter().map(|entry| entry * scale).collect();
    for (i, other) in table.chunks_exact_mut(width).enumerate() {
        if i == row {
            other.copy_from_slice(&top);
            continue;
        }
        let factor = other[column];
        if factor != 0.0 {
            for (entry, above) in other.iter_mut().zip(&top) {
                *entry -= factor * above;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::lemke;
    use proptest::prelude::*;

    proptest! {
        /// A definite M has one solution: the one from which q was computed.
        #[test]
        fn lemke_solves_what_was_made_up(
            factor in proptest::collection::vec(-1.0..1.0f64, 100),
            solution in proptest::collection::vec((any::<bool>(), 0.0..1.0f64), 10),
        ) {
            let size = 10;
            let mut m = vec![0.0; size * size];
            for i in 0..size {
                for j in 0..size {
                    let product: f64 = (0..size).map(|k| factor[i * size + k] * factor[j * size + k]).sum();
                    // not symmetric, but definite
                    let skew = 0.3 * (factor[i * size + j] - factor[j * size + i]);
                    m[i * size + j] = product + skew + if i == j { 0.1 } else { 0.0 };
                }
            }
            let z: Vec<f64> = solution.iter().map(|&(presses, size)| if presses { size } else { 0.0 }).collect();
            let q: Vec<f64> = (0..size)
                .map(|i| {
                    let pushed: f64 = (0..size).map(|j| m[i * size + j] * z[j]).sum();
                    let (presses, size) = solution[i];
                    if presses { -pushed } else { size - pushed }
                })
                .collect();
            let found = lemke(&m, &q).expect("definite");
            for (found, made) in found.iter().zip(&z) {
                prop_assert!((found - made).abs() < 1e-9, "{found} {made}");
            }
        }
    }

    #[test]
    fn nothing_pressed_needs_nothing() {
        assert_eq!(lemke(&[1.0, 0.0, 0.0, 1.0], &[0.5, 0.0]), Some(vec![0.0, 0.0]));
        // no solution: w = -1 for every z
        assert_eq!(lemke(&[0.0], &[-1.0]), None);
    }
}
