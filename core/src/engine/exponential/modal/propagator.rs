//! Propagator: the exact change of the modal state over one step of fixed length, in one speed interval.
//!
//! ```text
//! y+ = exp(B h) y + sum_s Re(c_s f_s) + c_w,     c_s = g(B) (l_u - i l_v)                  (`plane_block`)
//! ```
//! `y`, `y+`: modal state at both ends of the step; `f_s`: complex force of unbalance s in the middle of the step \[N\], rotating with the speed of the interval;
//! `l_u`, `l_v`: its input vectors along u and v; `c_s`: its response; `c_w`: response to the weight.
//!
//! With one unbalance a plane costs eight products, whatever the length of the step. Eight planes are computed together, from one row of a table.
//! Verified by `a_step_of_the_table_is_that_of_each_plane_block` and the closed forms of `tests/exponential/exponential.rs`.

use super::interval_model::IntervalModel;
use super::plane_block::{Harmonic, PlaneBlock, SplitBlock};
use bladeoff_numerics::linalg::lanes::{LANES, Lane};
use nalgebra::Complex;

/// Entries of a table row for the free motion of a plane: `exp(B h)`.
const FREE_ENTRIES: usize = 4;
/// Entries of a table row for each unbalance: its complex response of both states.
const FORCE_ENTRIES: usize = 4;

/// Free motion and force responses of all planes for one step length in one speed interval.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    planes: usize,
    unbalances: usize,
    /// One row per eight planes: entries of `exp(B h)` by rows; `Re c` and `-Im c` of both states for each unbalance; `c_w` of both states if the machine has weight.
    table: Vec<Lane>,
    /// Entries per row of the table.
    stride: usize,
}

impl Propagator {
    /// Propagator for steps of `h` \[s\] in a speed interval, for a number of unbalances.
    pub fn new(interval: &IntervalModel, unbalances: usize, h: f64) -> Self {
        let planes = interval.blocks.len();
        let weight = &interval.input_vectors[2 * unbalances];
        let has_weight = weight.iter().any(|&entry| entry != 0.0);
        let stride = FREE_ENTRIES + FORCE_ENTRIES * unbalances + if has_weight { 2 } else { 0 };
        let mut table = vec![Lane::default(); stride * planes.div_ceil(LANES)];
        let force = Harmonic::new(interval.speed, h);
        for (k, block) in interval.blocks.iter().enumerate() {
            let row = &mut table[k / LANES * stride..][..stride];
            let mut set = |at: usize, value: f64| row[at].0[k % LANES] = value;
            let split = SplitBlock::of(block);
            let step = split.step(&force);
            for (i, entry) in step.free.into_iter().enumerate() {
                set(i, entry);
            }
            for s in 0..unbalances {
                let (u, v) = (&interval.input_vectors[2 * s], &interval.input_vectors[2 * s + 1]);
                let l = |at: usize| Complex::new(u[at], -v[at]);
                let [a, b] = step.harmonic(&split, &force, [l(k), l(planes + k)]);
                for (i, entry) in [a.re, -a.im, b.re, -b.im].into_iter().enumerate() {
                    set(FREE_ENTRIES + FORCE_ENTRIES * s + i, entry);
                }
            }
            if has_weight {
                let [a, b] = split.constant_response(h, [weight[k], weight[planes + k]]);
                set(stride - 2, a);
                set(stride - 1, b);
            }
        }
        Self { planes, unbalances, table, stride }
    }

    /// Table entry of plane k.
    fn at(&self, k: usize, entry: usize) -> f64 {
        self.table[k / LANES * self.stride + entry].0[k % LANES]
    }

    /// Modal state at the end of the step due to a unit force of unbalance s along u in its middle.
    pub fn of_force(&self, s: usize) -> Vec<f64> {
        let component =
            |state: usize| (0..self.planes).map(move |k| self.at(k, FREE_ENTRIES + FORCE_ENTRIES * s + 2 * state));
        component(0).chain(component(1)).collect()
    }

    /// Matrix exponential `exp(B h)` of plane k.
    pub fn free_block(&self, k: usize) -> PlaneBlock {
        std::array::from_fn(|i| self.at(k, i))
    }

    /// Modal state at the end of the step without forces.
    pub fn free(&self, y: &[f64]) -> Vec<f64> {
        let (a, b) = y.split_at(self.planes);
        let component =
            |first: usize| (0..self.planes).map(move |k| self.at(k, first) * a[k] + self.at(k, first + 1) * b[k]);
        component(0).chain(component(2)).collect()
    }

    /// Advances y over the step under the forces of the unbalances in its middle \[N\]; runs inside a kernel.
    #[inline(always)]
    pub fn advance(&self, forces: impl Iterator<Item = Complex<f64>> + Clone, y: &mut [f64]) {
        let (a, b) = y.split_at_mut(self.planes);
        let (a, a_rest) = a.as_chunks_mut::<LANES>();
        let (b, b_rest) = b.as_chunks_mut::<LANES>();
        let mut table = self.table.as_slice();
        for (a, b) in a.iter_mut().zip(b) {
            let (row, remaining) = table.split_at(self.stride);
            table = remaining;
            advance_planes(row, self.unbalances, forces.clone(), a, b);
        }
        if !a_rest.is_empty() {
            let (mut a, mut b) = ([0.0; LANES], [0.0; LANES]);
            a.iter_mut().zip(&*a_rest).for_each(|(a, entry)| *a = *entry);
            b.iter_mut().zip(&*b_rest).for_each(|(b, entry)| *b = *entry);
            advance_planes(table, self.unbalances, forces, &mut a, &mut b);
            a_rest.iter_mut().zip(a).for_each(|(entry, a)| *entry = a);
            b_rest.iter_mut().zip(b).for_each(|(entry, b)| *entry = b);
        }
    }
}

/// Advances eight planes with their row of the table; runs inside a kernel.
#[inline(always)]
fn advance_planes(
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
    let (responses, weight) = rest.split_at(FORCE_ENTRIES * unbalances);
    for ([ar, ai, br, bi], f) in responses.as_chunks::<FORCE_ENTRIES>().0.iter().zip(forces) {
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
    use bladeoff_numerics::linalg::Matrix;

    /// Numbers of planes below, at and above multiples of eight, with and without weight and unbalances.
    #[test]
    fn a_step_of_the_table_is_that_of_each_plane_block() {
        for (planes, unbalances, weight) in
            [(1, 1, 0.0), (7, 0, 0.3), (8, 2, 0.0), (9, 1, 0.2), (16, 3, 0.1), (24, 1, 0.0)]
        {
            let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
            let blocks = (0..planes).map(|k| [-0.1, 2.0 + value(k).abs(), -1.5, -0.2]).collect();
            let input_vectors = (0..=2 * unbalances).map(|n| {
                let size = if n == 2 * unbalances { weight } else { 1.0 };
                (0..2 * planes).map(|i| size * value(100 * n + i)).collect()
            });
            let interval = IntervalModel::new(
                13.0,
                blocks,
                &Matrix::from_fn(11, 2 * planes, |i, j| value(5 * i + j)),
                input_vectors.collect(),
                unbalances,
            );
            let h = 0.07;
            let propagator = Propagator::new(&interval, unbalances, h);
            let forces: Vec<Complex<f64>> = (0..unbalances).map(|s| Complex::new(value(s), value(s + 9))).collect();
            let initial: Vec<f64> = (0..2 * planes).map(|i| value(i + 41)).collect();
            let mut y = initial.clone();
            propagator.advance(forces.iter().copied(), &mut y);
            for k in 0..planes {
                let split = SplitBlock::of(&interval.blocks[k]);
                let e = split.exponential(h);
                let at = |list: &[f64]| [list[k], list[planes + k]];
                let [a, b] = at(&initial);
                let mut wanted = [e[0] * a + e[1] * b, e[2] * a + e[3] * b];
                for (s, f) in forces.iter().enumerate() {
                    let (u, v) = (at(&interval.input_vectors[2 * s]), at(&interval.input_vectors[2 * s + 1]));
                    let c = split.harmonic(interval.speed, h, [0, 1].map(|i| Complex::new(u[i], -v[i])));
                    wanted = [0, 1].map(|i| wanted[i] + (c[i] * f).re);
                }
                let constant = split.constant_response(h, at(&interval.input_vectors[2 * unbalances]));
                let found = at(&y);
                for i in 0..2 {
                    assert!((found[i] - wanted[i] - constant[i]).abs() < 1e-12, "{planes} {unbalances} {k}");
                }
            }
        }
    }
}
