//! One step of the whirl states in a cell, exactly, for a step size.
//!
//! ```text
//! y+ = exp(B h) y + sum_s Re(c_s f_s) + c_w,     c_s = g(B) (l_u - i l_v)                  (block)
//! ```
//! f_s is the complex force of unbalance s in the middle of the step, which turns with the cell's speed, c_w the weight's. A pair costs eight products with
//! one unbalance; nothing depends on the step's size. Eight pairs stand together, all that is made of them in one row of the table. Verified by `the_table_has_what_the_blocks_say` and the closed forms of `tests/exponential.rs`.

use super::interval_model::IntervalModel;
use super::plane_block::{Harmonic, PlaneBlock, SplitBlock};
use crate::linalg::lanes::{LANES, Lane};
use nalgebra::Complex;

/// Entries of a row of the table before those of the unbalances, and those of each.
const FREE_ENTRIES: usize = 4;
const FORCE_ENTRIES: usize = 4;

/// `exp(B h)` and the responses of a step size in one cell.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    pairs: usize,
    unbalances: usize,
    /// Of eight pairs after eight: entries of `exp(B h)` by rows, `Re c` and `-Im c` of both states for each unbalance, c_w of both where there is weight.
    table: Vec<Lane>,
    stride: usize,
}

impl Propagator {
    /// For steps of `h` \[s\] in a cell under so many unbalances.
    pub fn new(cell: &IntervalModel, unbalances: usize, h: f64) -> Self {
        let pairs = cell.blocks.len();
        let weight = &cell.input_vectors[2 * unbalances];
        let weighs = weight.iter().any(|&push| push != 0.0);
        let stride = FREE_ENTRIES + FORCE_ENTRIES * unbalances + if weighs { 2 } else { 0 };
        let mut table = vec![Lane::default(); stride * pairs.div_ceil(LANES)];
        let drive = Harmonic::new(cell.speed, h);
        for (k, block) in cell.blocks.iter().enumerate() {
            let row = &mut table[k / LANES * stride..][..stride];
            let mut put = |at: usize, value: f64| row[at].0[k % LANES] = value;
            let split = SplitBlock::of(block);
            let over = split.step(&drive);
            for (i, entry) in over.free.into_iter().enumerate() {
                put(i, entry);
            }
            for s in 0..unbalances {
                let (u, v) = (&cell.input_vectors[2 * s], &cell.input_vectors[2 * s + 1]);
                let l = |at: usize| Complex::new(u[at], -v[at]);
                let [a, b] = over.harmonic(&split, &drive, [l(k), l(pairs + k)]);
                for (i, entry) in [a.re, -a.im, b.re, -b.im].into_iter().enumerate() {
                    put(FREE_ENTRIES + FORCE_ENTRIES * s + i, entry);
                }
            }
            if weighs {
                let [a, b] = split.constant_response(h, [weight[k], weight[pairs + k]]);
                put(stride - 2, a);
                put(stride - 1, b);
            }
        }
        Self { pairs, unbalances, table, stride }
    }

    /// Entry of a pair in the table.
    fn at(&self, k: usize, entry: usize) -> f64 {
        self.table[k / LANES * self.stride + entry].0[k % LANES]
    }

    /// y after the step of a unit force of an unbalance along u in its middle.
    pub fn of_force(&self, s: usize) -> Vec<f64> {
        let of = |state: usize| (0..self.pairs).map(move |k| self.at(k, FREE_ENTRIES + FORCE_ENTRIES * s + 2 * state));
        of(0).chain(of(1)).collect()
    }

    /// `exp(B h)` of a pair.
    pub fn of_pair(&self, k: usize) -> PlaneBlock {
        std::array::from_fn(|i| self.at(k, i))
    }

    /// y+ without any force.
    pub fn free(&self, y: &[f64]) -> Vec<f64> {
        let (a, b) = y.split_at(self.pairs);
        let of = |first: usize| (0..self.pairs).map(move |k| self.at(k, first) * a[k] + self.at(k, first + 1) * b[k]);
        of(0).chain(of(2)).collect()
    }

    /// Takes y over the step under the unbalances' forces in its middle \[N\]; inside a kernel.
    #[inline(always)]
    pub fn advance(&self, forces: impl Iterator<Item = Complex<f64>> + Clone, y: &mut [f64]) {
        let (a, b) = y.split_at_mut(self.pairs);
        let (a, a_left) = a.as_chunks_mut::<LANES>();
        let (b, b_left) = b.as_chunks_mut::<LANES>();
        let mut table = self.table.as_slice();
        for (a, b) in a.iter_mut().zip(b) {
            let (row, others) = table.split_at(self.stride);
            table = others;
            eight(row, self.unbalances, forces.clone(), a, b);
        }
        if !a_left.is_empty() {
            let (mut a, mut b) = ([0.0; LANES], [0.0; LANES]);
            a.iter_mut().zip(&*a_left).for_each(|(a, left)| *a = *left);
            b.iter_mut().zip(&*b_left).for_each(|(b, left)| *b = *left);
            eight(table, self.unbalances, forces, &mut a, &mut b);
            a_left.iter_mut().zip(a).for_each(|(left, a)| *left = a);
            b_left.iter_mut().zip(b).for_each(|(left, b)| *left = b);
        }
    }
}

/// y+ of eight pairs; inside a kernel.
#[inline(always)]
fn eight(
    row: &[Lane],
    unbalances: usize,
    forces: impl Iterator<Item = Complex<f64>>,
    a: &mut [f64; LANES],
    b: &mut [f64; LANES],
) {
    let Some(([aa, ab, ba, bb], rest)) = row.split_first_chunk::<FREE_ENTRIES>() else { return };
    let (x, z) = (*a, *b);
    let (mut p, mut q) = ([0.0; LANES], [0.0; LANES]);
    for k in 0..LANES {
        p[k] = aa.0[k] * x[k] + ab.0[k] * z[k];
        q[k] = ba.0[k] * x[k] + bb.0[k] * z[k];
    }
    let (pushes, weight) = rest.split_at(FORCE_ENTRIES * unbalances);
    for ([ar, ai, br, bi], f) in pushes.as_chunks::<FORCE_ENTRIES>().0.iter().zip(forces) {
        for k in 0..LANES {
            p[k] += ar.0[k] * f.re + ai.0[k] * f.im;
            q[k] += br.0[k] * f.re + bi.0[k] * f.im;
        }
    }
    if let [wa, wb] = weight {
        for k in 0..LANES {
            p[k] += wa.0[k];
            q[k] += wb.0[k];
        }
    }
    (*a, *b) = (p, q);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;

    /// Of every number of pairs, with and without weight and unbalances: what the blocks make of each pair alone.
    #[test]
    fn the_table_has_what_the_blocks_say() {
        for (pairs, unbalances, weight) in
            [(1, 1, 0.0), (7, 0, 0.3), (8, 2, 0.0), (9, 1, 0.2), (16, 3, 0.1), (24, 1, 0.0)]
        {
            let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
            let blocks = (0..pairs).map(|k| [-0.1, 2.0 + value(k).abs(), -1.5, -0.2]).collect();
            let pushes = (0..=2 * unbalances).map(|n| {
                let size = if n == 2 * unbalances { weight } else { 1.0 };
                (0..2 * pairs).map(|i| size * value(100 * n + i)).collect()
            });
            let cell = IntervalModel::new(
                13.0,
                blocks,
                &Matrix::from_fn(11, 2 * pairs, |i, j| value(5 * i + j)),
                pushes.collect(),
                unbalances,
            );
            let h = 0.07;
            let propagator = Propagator::new(&cell, unbalances, h);
            let forces: Vec<Complex<f64>> = (0..unbalances).map(|s| Complex::new(value(s), value(s + 9))).collect();
            let begun: Vec<f64> = (0..2 * pairs).map(|i| value(i + 41)).collect();
            let mut y = begun.clone();
            propagator.advance(forces.iter().copied(), &mut y);
            for k in 0..pairs {
                let split = SplitBlock::of(&cell.blocks[k]);
                let e = split.exponential(h);
                let at = |list: &[f64]| [list[k], list[pairs + k]];
                let [a, b] = at(&begun);
                let mut wanted = [e[0] * a + e[1] * b, e[2] * a + e[3] * b];
                for (s, f) in forces.iter().enumerate() {
                    let (u, v) = (at(&cell.input_vectors[2 * s]), at(&cell.input_vectors[2 * s + 1]));
                    let c = split.harmonic(cell.speed, h, [0, 1].map(|i| Complex::new(u[i], -v[i])));
                    wanted = [0, 1].map(|i| wanted[i] + (c[i] * f).re);
                }
                let constant = split.constant_response(h, at(&cell.input_vectors[2 * unbalances]));
                let found = at(&y);
                for i in 0..2 {
                    assert!((found[i] - wanted[i] - constant[i]).abs() < 1e-12, "{pairs} {unbalances} {k}");
                }
            }
        }
    }
}
