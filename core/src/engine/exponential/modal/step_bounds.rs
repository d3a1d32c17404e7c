//! What the whirl states at n say of a flight from there: how long it may be, for contact and for peaks.
//!
//! ```text
//! of each pair        |y|,   y' = B y + l f,   |w'| of each quantity (`missed`)
//! of all              x', the velocity of the diaphragm's node
//! ```
//! Eight pairs at a time, once for all lengths of steps; of each length a cell has the weights of these in `bound` and in `missed`, from the first time that it is asked for. The longest length is
//! tried first. Verified by `what_is_seen_of_pairs_is_that_of_each` and by the tests of both bounds.

use super::displacement_bound::{DisplacementBound, length};
use super::interval_model::IntervalModel;
use super::peak_bound::{PeakBound, WatchedPeak};
use crate::engine::exponential::settings::MAX_DOUBLINGS;
use crate::linalg::lanes::{LANES, Lane, kernel, sum};
use nalgebra::Complex;
use std::sync::OnceLock;

/// A cell as flights see it.
#[derive(Debug)]
pub(crate) struct StepBounds {
    /// Contact step \[s\].
    step: f64,
    /// W \[rad/s\].
    spin: f64,
    /// Of eight pairs each: blocks; pushes of the unbalances along both axes and of the weight; two rows of each quantity, on both parts of y.
    blocks: Vec<[Lane; 4]>,
    pushes: Vec<[Lane; 2]>,
    rows: Vec<[Lane; 4]>,
    displacement_bounds: [OnceLock<DisplacementBound>; MAX_DOUBLINGS + 1],
    peak_bounds: [OnceLock<PeakBound>; MAX_DOUBLINGS + 1],
}

/// What is seen at n.
#[derive(Debug, Clone, Default)]
pub(crate) struct StateBounds {
    /// y, and parts of the unbalances' forces and of the weight \[N\].
    y: Vec<[Lane; 2]>,
    parts: Vec<f64>,
    /// Sizes of the unbalances' forces \[N\].
    forces: Vec<f64>,
    amplitudes: Vec<Lane>,
    /// Of each quantity one after the other.
    in_turn: Vec<Lane>,
}

impl StepBounds {
    /// Of quantities whose rows begin at these places, in a cell under so many unbalances, for contact steps of `h` \[s\].
    pub fn new(cell: &IntervalModel, watched: &[usize], unbalances: usize, h: f64) -> Self {
        let pairs = cell.blocks.len();
        let groups = pairs.div_ceil(LANES);
        let mut blocks = vec![[Lane::default(); 4]; groups];
        for (k, block) in cell.blocks.iter().enumerate() {
            for (lane, entry) in blocks[k / LANES].iter_mut().zip(block) {
                lane.0[k % LANES] = *entry;
            }
        }
        let forces = 2 * unbalances + 1;
        let mut pushes = vec![[Lane::default(); 2]; groups * forces];
        for (at, push) in cell.input_vectors[..forces].iter().enumerate() {
            put([&push[..pairs], &push[pairs..]], pushes[at..].iter_mut().step_by(forces));
        }
        let mut rows = vec![[Lane::default(); 4]; groups * watched.len()];
        for (at, &first) in watched.iter().enumerate() {
            let [u, v] = [&cell.output_rows[first], &cell.output_rows[first + 1]];
            let lists = [&u[..pairs], &u[pairs..], &v[..pairs], &v[pairs..]];
            put(lists, rows[at..].iter_mut().step_by(watched.len()));
        }
        Self {
            step: h,
            spin: cell.speed,
            blocks,
            pushes,
            rows,
            displacement_bounds: Default::default(),
            peak_bounds: Default::default(),
        }
    }

    /// Sees y under these forces of the unbalances \[N\]; the rate of the last quantity.
    pub fn bound_states(
        &self,
        y: &[f64],
        forces: impl Iterator<Item = Complex<f64>>,
        sight: &mut StateBounds,
    ) -> [f64; 2] {
        let StateBounds { y: lanes, parts, forces: sizes, amplitudes, in_turn } = sight;
        let groups = self.blocks.len();
        parts.clear();
        sizes.clear();
        for force in forces {
            parts.extend([force.re, force.im]);
            sizes.push(length([force.re, force.im]));
        }
        parts.push(1.0);
        lanes.resize(groups, Default::default());
        amplitudes.resize(groups, Lane::default());
        in_turn.resize(self.rows.len(), Lane::default());
        let (a, b) = y.split_at(y.len() / 2);
        for ([x, z], (a, b)) in lanes.iter_mut().zip(a.chunks(LANES).zip(b.chunks(LANES))) {
            x.0[..a.len()].copy_from_slice(a);
            z.0[..b.len()].copy_from_slice(b);
        }
        let mut rates = [Lane::default(); 2];
        see(self.spin, parts, [&self.pushes, lanes], [&self.blocks, &self.rows], amplitudes, in_turn, &mut rates);
        rates.map(|rate| sum(rate.0))
    }

    /// How far the diaphragm's node, whose rows begin at a place, may be after a step of a level from where its velocity would take it, at a spin; what bounds it is computed once.
    pub fn max_deviation(&self, cell: &IntervalModel, row: usize, level: usize, sight: &StateBounds, spin: f64) -> f64 {
        let bound = || DisplacementBound::new(cell, row, sight.forces.len(), self.length_of(level));
        self.displacement_bounds[level].get_or_init(bound).max_deviation(&sight.amplitudes, &sight.forces, spin)
    }

    /// The longest step up to a level over which no peak of what is watched is missed.
    pub fn longest_resolved_step(
        &self,
        cell: &IntervalModel,
        watched: &[WatchedPeak],
        sight: &StateBounds,
        most: usize,
    ) -> usize {
        let (mut longest, groups) = (most, self.blocks.len());
        for (watched, in_turn) in watched.iter().zip(sight.in_turn.chunks_exact(groups)) {
            let resolves = |&level: &usize| {
                let missed = || PeakBound::new(cell, self.length_of(level));
                self.peak_bounds[level].get_or_init(missed).is_resolved(watched, in_turn)
            };
            longest = (1..=longest).rev().find(resolves).unwrap_or(0);
        }
        longest
    }

    fn length_of(&self, level: usize) -> f64 {
        self.step * libm::exp2(level as f64)
    }
}

/// Puts eight of each list after eight into places.
fn put<'a, const N: usize>(lists: [&[f64]; N], places: impl Iterator<Item = &'a mut [Lane; N]>) {
    for (g, place) in places.enumerate() {
        for (lane, list) in place.iter_mut().zip(lists) {
            let part = &list[g * LANES..list.len().min((g + 1) * LANES)];
            lane.0[..part.len()].copy_from_slice(part);
        }
    }
}

kernel! {
    /// What is seen of `[pushes, y]` by `[blocks, rows]`; `rates`: of the last quantity, lane by lane.
    fn see(
        spin: f64,
        parts: &[f64],
        pushes_and_y: [&[[Lane; 2]]; 2],
        blocks_and_rows: [&[[Lane; 4]]; 2],
        amplitudes: &mut [Lane],
        in_turn: &mut [Lane],
        rates: &mut [Lane; 2],
    ) {
        let ([pushes, y], [blocks, rows]) = (pushes_and_y, blocks_and_rows);
        let groups = y.len();
        let quantities = rows.len() / groups.max(1);
        for g in 0..groups {
            let [a, b] = &y[g];
            let block = &blocks[g];
            let (mut da, mut db) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..LANES {
                da[k] = block[0].0[k] * a.0[k] + block[1].0[k] * b.0[k];
                db[k] = block[2].0[k] * a.0[k] + block[3].0[k] * b.0[k];
                amplitudes[g].0[k] = (a.0[k] * a.0[k] + b.0[k] * b.0[k]).sqrt();
            }
            for (part, [push, other]) in parts.iter().zip(&pushes[g * parts.len()..]) {
                for k in 0..LANES {
                    da[k] += part * push.0[k];
                    db[k] += part * other.0[k];
                }
            }
            for q in 0..quantities {
                let [ua, ub, va, vb] = &rows[g * quantities + q];
                let sizes = &mut in_turn[q * groups + g];
                let (mut along, mut across) = ([0.0; LANES], [0.0; LANES]);
                for k in 0..LANES {
                    along[k] = ua.0[k] * da[k] + ub.0[k] * db[k];
                    across[k] = va.0[k] * da[k] + vb.0[k] * db[k];
                }
                if q + 1 == quantities {
                    for k in 0..LANES {
                        rates[0].0[k] += along[k];
                        rates[1].0[k] += across[k];
                    }
                }
                for k in 0..LANES {
                    let x = along[k] + spin * (va.0[k] * a.0[k] + vb.0[k] * b.0[k]);
                    let z = across[k] - spin * (ua.0[k] * a.0[k] + ub.0[k] * b.0[k]);
                    sizes.0[k] = (x * x + z * z).sqrt();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::interval_model::OutputRows;
    use super::super::quadratic_form::OutputMatrix;
    use super::*;
    use crate::linalg::Matrix;

    /// Of numbers of pairs that are no multiple of eight, and of more than one unbalance.
    #[test]
    fn what_is_seen_of_pairs_is_that_of_each() {
        for (pairs, unbalances) in [(1, 1), (5, 0), (8, 2), (13, 3), (24, 1)] {
            let value = |i: usize, j: usize| ((i * 31 + j * 17) % 23) as f64 - 11.3;
            let list = |i: usize| -> Vec<f64> { (0..2 * pairs).map(|j| value(i, j)).collect() };
            let cell = IntervalModel {
                speed: 1.7,
                blocks: (0..pairs).map(|k| std::array::from_fn(|i| value(k, i + 3))).collect(),
                output_rows: OutputRows::of(&Matrix::from_fn(6, 2 * pairs, |i, j| value(i + 1, j))),
                output_matrix: OutputMatrix::new(&Matrix::zeros(0, 0)),
                input_vectors: (0..=2 * unbalances).map(|i| list(i + 50)).collect(),
                outputs_of_impulses: Vec::new(),
            };
            let y = list(99);
            let forces: Vec<Complex<f64>> = (0..unbalances).map(|s| Complex::new(value(s, 5), value(s, 9))).collect();
            let mut sight = StateBounds::default();
            let outlook = StepBounds::new(&cell, &[0, 4, 2], unbalances, 1e-3);
            let rate = outlook.bound_states(&y, forces.iter().copied(), &mut sight);
            let rates: Vec<f64> = (0..2 * pairs)
                .map(|j| {
                    let (k, b) = (j % pairs, cell.blocks[j % pairs]);
                    let of = if j < pairs { [b[0], b[1]] } else { [b[2], b[3]] };
                    let pushed: f64 = forces
                        .iter()
                        .enumerate()
                        .map(|(s, f)| cell.input_vectors[2 * s][j] * f.re + cell.input_vectors[2 * s + 1][j] * f.im)
                        .sum();
                    of[0] * y[k] + of[1] * y[pairs + k] + pushed + cell.input_vectors[2 * unbalances][j]
                })
                .collect();
            let mut sum = [0.0; 2];
            for k in 0..pairs {
                let near = |found: f64, wanted: f64| {
                    assert!((found - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{pairs} {k}: {found} {wanted}");
                };
                near(sight.amplitudes[k / LANES].0[k % LANES], length([y[k], y[pairs + k]]));
                for (q, first) in [0, 4, 2].into_iter().enumerate() {
                    let of = |row: usize, x: &[f64]| {
                        cell.output_rows[row][k] * x[k] + cell.output_rows[row][pairs + k] * x[pairs + k]
                    };
                    let (place, rate) =
                        ([of(first, &y), of(first + 1, &y)], [of(first, &rates), of(first + 1, &rates)]);
                    let wanted = length([rate[0] + cell.speed * place[1], rate[1] - cell.speed * place[0]]);
                    near(sight.in_turn[q * outlook.blocks.len() + k / LANES].0[k % LANES], wanted);
                    if q == 2 {
                        (0..2).for_each(|i| sum[i] += rate[i]);
                    }
                }
            }
            (0..2).for_each(|i| assert!((rate[i] - sum[i]).abs() < 1e-9 * (1.0 + sum[i].abs())));
        }
    }
}
