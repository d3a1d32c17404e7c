//! What the whirl states are in one cell of the grid, where all of it is constant.
//!
//! Verified by `rates_are_those_of_the_blocks` and, with all that is made of it, by `tests/exponential.rs`.

use super::block::Block;
use super::forms::Rows;
use crate::linalg::Matrix;
use crate::linalg::lanes::{LANES, Lane, kernel, sum};
use nalgebra::Complex;

#[derive(Debug)]
pub(super) struct Local {
    /// Speed in the cell's middle \[rad/s\].
    pub speed: f64,
    pub blocks: Vec<Block>,
    /// A row on y for each output, and all of them.
    pub rows: Vec<Vec<f64>>,
    pub outputs: Rows,
    /// A vector of y for each force.
    pub pushes: Vec<Vec<f64>>,
    /// Outputs of those of the unbalances.
    struck: Vec<Vec<f64>>,
    /// Entries of the blocks, of eight pairs after eight.
    entries: Vec<[Lane; 4]>,
}

impl Local {
    /// Of a cell with this speed in its middle and so many unbalances, whose pushes are the first.
    pub fn new(speed: f64, blocks: Vec<Block>, rows: &Matrix, pushes: Vec<Vec<f64>>, unbalances: usize) -> Self {
        let outputs = Rows::new(rows);
        let struck = pushes[..2 * unbalances].iter().map(|push| {
            let mut seen = Vec::new();
            outputs.times(push, &mut seen);
            seen
        });
        let eight = |blocks: &[Block]| {
            let mut entries = [Lane::default(); 4];
            for (k, block) in blocks.iter().enumerate() {
                for i in 0..4 {
                    entries[i].0[k] = block[i];
                }
            }
            entries
        };
        Self {
            speed,
            struck: struck.collect(),
            outputs,
            rows: rows.row_iter().map(|row| row.iter().copied().collect()).collect(),
            pushes,
            entries: blocks.chunks(LANES).map(eight).collect(),
            blocks,
        }
    }

    /// Adds impulses of the unbalances on their nodes \[N s\] to y and its outputs, and to y what impulses at n have made, so much of two lists; inside a kernel.
    #[inline(always)]
    pub fn strike(
        &self,
        impulses: impl Iterator<Item = Complex<f64>>,
        mut made: Option<([f64; 2], &[Vec<f64>; 2])>,
        y: &mut [f64],
        seen: &mut [f64],
    ) {
        let lists = self.pushes.as_chunks::<2>().0.iter().zip(self.struck.as_chunks::<2>().0);
        for (impulse, (pushes, struck)) in impulses.zip(lists) {
            let parts = [impulse.re, impulse.im];
            match made.take() {
                Some(made) => add_four(made, (parts, pushes), y),
                None => add_both(parts, pushes, y),
            }
            add_both(parts, struck, seen);
        }
        if let Some((parts, states)) = made {
            add_both(parts, states, y);
        }
    }

    /// y' of y under the unbalances' forces \[N\] and the weight.
    pub fn rates(&self, y: &[f64], forces: impl Iterator<Item = Complex<f64>>, rates: &mut [f64]) {
        set_out(&self.entries, self.blocks.len(), y, &self.pushes[self.struck.len()], rates);
        for (f, pushes) in forces.zip(self.pushes.as_chunks::<2>().0) {
            add([f.re, f.im], pushes, rates);
        }
    }

    /// What two rows from one on have of a state.
    pub fn both(&self, first: usize, y: &[f64]) -> [f64; 2] {
        let mut lanes = [[0.0; LANES]; 2];
        both(&self.rows[first], &self.rows[first + 1], y, &mut lanes);
        lanes.map(sum)
    }
}

/// `sums += a x + b y`; inside a kernel.
#[inline(always)]
pub(super) fn add_both([a, b]: [f64; 2], [x, y]: &[Vec<f64>; 2], sums: &mut [f64]) {
    let count = sums.len();
    let (x, y) = (&x[..count], &y[..count]);
    for j in 0..count {
        sums[j] = sums[j] + a * x[j] + b * y[j];
    }
}

/// The same twice, one after the other, in one pass.
#[inline(always)]
fn add_four(
    ([a, b], [x, y]): ([f64; 2], &[Vec<f64>; 2]),
    ([c, d], [u, v]): ([f64; 2], &[Vec<f64>; 2]),
    sums: &mut [f64],
) {
    let count = sums.len();
    let (x, y, u, v) = (&x[..count], &y[..count], &u[..count], &v[..count]);
    for j in 0..count {
        sums[j] = sums[j] + a * x[j] + b * y[j] + c * u[j] + d * v[j];
    }
}

kernel! {
    /// [`add_both`].
    fn add(factors: [f64; 2], lists: &[Vec<f64>; 2], sums: &mut [f64]) {
        add_both(factors, lists, sums);
    }
}

kernel! {
    /// `B y + weight`.
    fn set_out(entries: &[[Lane; 4]], pairs: usize, y: &[f64], weight: &[f64], rates: &mut [f64]) {
        let ((x, z), (u, v)) = (y.split_at(pairs), weight.split_at(pairs));
        let (dx, dz) = rates.split_at_mut(pairs);
        for (i, [aa, ab, ba, bb]) in entries.iter().enumerate() {
            let from = LANES * i;
            if let (Some(x), Some(z)) = (x[from..].first_chunk::<LANES>(), z[from..].first_chunk::<LANES>())
                && let (Some(u), Some(v)) = (u[from..].first_chunk::<LANES>(), v[from..].first_chunk::<LANES>())
                && let (Some(dx), Some(dz)) =
                    (dx[from..].first_chunk_mut::<LANES>(), dz[from..].first_chunk_mut::<LANES>())
            {
                for k in 0..LANES {
                    dx[k] = u[k] + (aa.0[k] * x[k] + ab.0[k] * z[k]);
                    dz[k] = v[k] + (ba.0[k] * x[k] + bb.0[k] * z[k]);
                }
            } else {
                for k in 0..pairs - from {
                    let j = from + k;
                    dx[j] = u[j] + (aa.0[k] * x[j] + ab.0[k] * z[j]);
                    dz[j] = v[j] + (ba.0[k] * x[j] + bb.0[k] * z[j]);
                }
            }
        }
    }
}

kernel! {
    /// Products of two rows with a list, lane by lane.
    fn both(a: &[f64], b: &[f64], list: &[f64], lanes: &mut [[f64; LANES]; 2]) {
        let count = list.len();
        let (a, b) = (&a[..count], &b[..count]);
        let ((a, a_left), (b, b_left)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
        let (list, left) = list.as_chunks::<LANES>();
        let (mut one, mut other) = ([0.0; LANES], [0.0; LANES]);
        for ((a, b), list) in a.iter().zip(b).zip(list) {
            for k in 0..LANES {
                one[k] += a[k] * list[k];
            }
            for k in 0..LANES {
                other[k] += b[k] * list[k];
            }
        }
        for (k, list) in left.iter().enumerate() {
            one[k] += a_left[k] * list;
            other[k] += b_left[k] * list;
        }
        *lanes = [one, other];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of every number of pairs: rates, what rows have of them, and impulses.
    #[test]
    fn rates_are_those_of_the_blocks() {
        let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
        for pairs in [1, 3, 8, 13, 24] {
            let size = 2 * pairs;
            let blocks: Vec<Block> = (0..pairs).map(|k| std::array::from_fn(|i| value(4 * k + i))).collect();
            let pushes: Vec<Vec<f64>> = (0..3).map(|n| (0..size).map(|i| value(300 * n + i)).collect()).collect();
            let rows = Matrix::from_fn(3, size, |i, j| value(5 * i + j));
            let local = Local::new(1.0, blocks.clone(), &rows, pushes.clone(), 1);
            let mut y: Vec<f64> = (0..size).map(|i| value(i + 77)).collect();
            let (f, mut rates) = (Complex::new(0.4, -1.3), vec![f64::NAN; size]);
            local.rates(&y, std::iter::once(f), &mut rates);
            for i in 0..size {
                let (k, b) = (i % pairs, &blocks[i % pairs][if i < pairs { 0..2 } else { 2..4 }]);
                let wanted =
                    b[0] * y[k] + b[1] * y[pairs + k] + pushes[0][i] * f.re + pushes[1][i] * f.im + pushes[2][i];
                assert!((rates[i] - wanted).abs() < 1e-12, "{pairs} {i}");
            }
            let found = local.both(1, &rates);
            for (i, found) in found.into_iter().enumerate() {
                assert!((found - crate::linalg::dot(&local.rows[1 + i], &rates)).abs() < 1e-10, "{pairs} {i}");
            }
            let mut seen = Vec::new();
            local.outputs.times(&y, &mut seen);
            let mut struck = y.clone();
            local.strike(std::iter::once(f), None, &mut struck, &mut seen);
            let made = (0..size).map(|i| y[i] + pushes[0][i] * f.re + pushes[1][i] * f.im);
            assert!(made.zip(&struck).all(|(made, struck)| (made - struck).abs() < 1e-12));
            // with what another impulse has made, to the last bit
            let ([a, b], states) = ([0.3, -0.8], [pushes[2].clone(), pushes[1].clone()]);
            let mut at_once = y.clone();
            local.strike(std::iter::once(f), Some(([a, b], &states)), &mut at_once, &mut seen.clone());
            add_both([a, b], &states, &mut y);
            local.strike(std::iter::once(f), None, &mut y, &mut seen.clone());
            assert_eq!(at_once, y);
            y = struck;
            for (row, seen) in local.rows.iter().zip(&seen) {
                assert!((crate::linalg::dot(row, &y) - seen).abs() < 1e-10, "{pairs}");
            }
        }
    }
}
