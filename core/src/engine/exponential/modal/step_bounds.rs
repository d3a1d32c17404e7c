//! Step bounds: limits of the length of a free step from the modal state at n, by contact and by missed peaks.
//!
//! ```text
//! of each plane       |y|,   y' = B y + l f,   |w'| of each watched quantity (`peak_bound`)
//! of all planes       x', velocity of each diaphragm's node
//! ```
//! `y`, `B`, `l`: modal state, block and input vectors of a plane; `f`: forces of the unbalances and the weight \[N\].
//!
//! The quantities above do not depend on the length of the step and are computed once, eight planes at a time. The weights of `displacement_bound` and `peak_bound` do depend on it:
//! an interval computes them for each number of doublings when they are first needed. The longest step is tried first.
//! Verified by `state_bounds_are_those_of_each_plane` and by the tests of both bounds.

use super::displacement_bound::DisplacementBound;
use super::interval_model::IntervalModel;
use super::peak_bound::{PeakBound, WatchedPeak};
use crate::engine::exponential::plane::length;
use crate::engine::exponential::settings::MAX_DOUBLINGS;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, kernel, sum};
use nalgebra::Complex;
use std::sync::OnceLock;

/// Step bounds of one speed interval for contact steps of one length.
#[derive(Debug)]
pub(crate) struct StepBounds {
    /// Contact step \[s\].
    step: f64,
    /// W \[rad/s\].
    spin: f64,
    /// Plane blocks, eight planes at a time.
    blocks: Vec<[Lane; 4]>,
    /// Input vectors of the unbalances along u and v and of the weight, on both entries of y; for eight planes one after the other.
    input_vectors: Vec<[Lane; 2]>,
    /// Two output rows of each watched quantity, on both entries of y; for eight planes one after the other.
    rows: Vec<[Lane; 4]>,
    /// First output row of each diaphragm's node: the last watched quantities.
    contacts: Vec<usize>,
    /// Bounds by diaphragm and by the number of doublings of the contact step.
    displacement_bounds: Vec<[OnceLock<DisplacementBound>; MAX_DOUBLINGS + 1]>,
    /// Bounds by the number of doublings of the contact step.
    peak_bounds: [OnceLock<PeakBound>; MAX_DOUBLINGS + 1],
}

/// Modal state at n and the amplitudes and rates that the bounds need.
#[derive(Debug, Clone, Default)]
pub(crate) struct StateBounds {
    /// y, eight planes at a time.
    y: Vec<[Lane; 2]>,
    /// Force components along u and v of each unbalance \[N\], then 1 for the weight.
    force_components: Vec<f64>,
    /// Magnitudes of the forces of the unbalances \[N\].
    forces: Vec<f64>,
    /// |y| of each plane.
    amplitudes: Vec<Lane>,
    /// |w'| of each plane, one watched quantity after the other.
    rotating_rates: Vec<Lane>,
    /// Velocity of each diaphragm's node, lane by lane and as a sum \[m/s\].
    rates: Vec<[Lane; 2]>,
    pub velocities: Vec<[f64; 2]>,
}

impl StepBounds {
    /// Step bounds for contact steps of `h` \[s\]; `watched`: first output row of each watched quantity, the last ones those of the diaphragms.
    pub fn new(interval: &IntervalModel, (watched, diaphragms): (&[usize], usize), unbalances: usize, h: f64) -> Self {
        let planes = interval.blocks.len();
        let groups = planes.div_ceil(LANES);
        let mut blocks = vec![[Lane::default(); 4]; groups];
        for (k, block) in interval.blocks.iter().enumerate() {
            for (lane, entry) in blocks[k / LANES].iter_mut().zip(block) {
                lane.0[k % LANES] = *entry;
            }
        }
        let forces = 2 * unbalances + 1;
        let mut input_vectors = vec![[Lane::default(); 2]; groups * forces];
        for (at, input_vector) in interval.input_vectors[..forces].iter().enumerate() {
            copy_by_planes(
                [&input_vector[..planes], &input_vector[planes..]],
                input_vectors[at..].iter_mut().step_by(forces),
            );
        }
        let mut rows = vec![[Lane::default(); 4]; groups * watched.len()];
        for (at, &first) in watched.iter().enumerate() {
            let [u, v] = [&interval.output_rows[first], &interval.output_rows[first + 1]];
            let lists = [&u[..planes], &u[planes..], &v[..planes], &v[planes..]];
            copy_by_planes(lists, rows[at..].iter_mut().step_by(watched.len()));
        }
        Self {
            step: h,
            spin: interval.speed,
            blocks,
            input_vectors,
            rows,
            contacts: watched[watched.len() - diaphragms..].to_vec(),
            displacement_bounds: (0..diaphragms).map(|_| Default::default()).collect(),
            peak_bounds: Default::default(),
        }
    }

    /// Evaluates the modal state y under the forces of the unbalances \[N\] for all bounds.
    pub fn bound_states(&self, y: &[f64], forces: impl Iterator<Item = Complex<f64>>, state_bounds: &mut StateBounds) {
        let StateBounds {
            y: lanes,
            force_components,
            forces: magnitudes,
            amplitudes,
            rotating_rates,
            rates,
            velocities,
        } = state_bounds;
        let groups = self.blocks.len();
        force_components.clear();
        magnitudes.clear();
        for force in forces {
            force_components.extend([force.re, force.im]);
            magnitudes.push(length([force.re, force.im]));
        }
        force_components.push(1.0);
        lanes.resize(groups, Default::default());
        amplitudes.resize(groups, Lane::default());
        rotating_rates.resize(self.rows.len(), Lane::default());
        let (a, b) = y.split_at(y.len() / 2);
        for ([x, z], (a, b)) in lanes.iter_mut().zip(a.chunks(LANES).zip(b.chunks(LANES))) {
            x.0[..a.len()].copy_from_slice(a);
            z.0[..b.len()].copy_from_slice(b);
        }
        rates.clear();
        rates.resize(self.contacts.len(), Default::default());
        evaluate_planes(
            self.spin,
            force_components,
            [&self.input_vectors, lanes],
            [&self.blocks, &self.rows],
            amplitudes,
            rotating_rates,
            rates,
        );
        velocities.clear();
        velocities.extend(rates.iter().map(|rate| [sum(rate[0].0), sum(rate[1].0)]));
    }

    /// Largest deviation of a diaphragm's node \[m\] from a straight motion during a step of `2^doublings` contact steps, at a spin \[rad/s\].
    pub fn max_deviation(
        &self,
        interval: &IntervalModel,
        diaphragm: usize,
        doublings: usize,
        state_bounds: &StateBounds,
        spin: f64,
    ) -> f64 {
        let (row, forces) = (self.contacts[diaphragm], state_bounds.forces.len());
        let bound = || DisplacementBound::new(interval, row, forces, self.step_length(doublings));
        self.displacement_bounds[diaphragm][doublings].get_or_init(bound).max_deviation(
            &state_bounds.amplitudes,
            &state_bounds.forces,
            spin,
        )
    }

    /// Doublings of the longest step, up to `max_doublings`, that misses no peak of a watched quantity.
    pub fn longest_resolved_step(
        &self,
        interval: &IntervalModel,
        watched: &[WatchedPeak],
        state_bounds: &StateBounds,
        max_doublings: usize,
    ) -> usize {
        let (mut longest, groups) = (max_doublings, self.blocks.len());
        for (watched, rotating_rates) in watched.iter().zip(state_bounds.rotating_rates.chunks_exact(groups)) {
            if !watched.limits_step {
                continue;
            }
            let resolves = |&doublings: &usize| {
                let bound = || PeakBound::new(interval, self.step_length(doublings));
                self.peak_bounds[doublings].get_or_init(bound).is_resolved(watched, rotating_rates)
            };
            longest = (1..=longest).rev().find(resolves).unwrap_or(0);
        }
        longest
    }

    /// Length of a step of `2^doublings` contact steps \[s\].
    fn step_length(&self, doublings: usize) -> f64 {
        self.step * libm::exp2(doublings as f64)
    }
}

/// Copies lists into groups of eight planes; the last group is filled up with zeros.
fn copy_by_planes<'a, const N: usize>(lists: [&[f64]; N], groups: impl Iterator<Item = &'a mut [Lane; N]>) {
    for (g, group) in groups.enumerate() {
        for (lane, list) in group.iter_mut().zip(lists) {
            let part = &list[g * LANES..list.len().min((g + 1) * LANES)];
            lane.0[..part.len()].copy_from_slice(part);
        }
    }
}

kernel! {
    /// Amplitudes of the planes and rotating rates of the watched quantities; `rates`: rates of the last quantities, lane by lane.
    fn evaluate_planes(
        spin: f64,
        force_components: &[f64],
        inputs_and_y: [&[[Lane; 2]]; 2],
        blocks_and_rows: [&[[Lane; 4]]; 2],
        amplitudes: &mut [Lane],
        rotating_rates: &mut [Lane],
        rates: &mut [[Lane; 2]],
    ) {
        let ([input_vectors, y], [blocks, rows]) = (inputs_and_y, blocks_and_rows);
        let groups = y.len();
        let quantities = rows.len() / groups.max(1);
        let others = quantities - rates.len();
        for g in 0..groups {
            let [a, b] = &y[g];
            let block = &blocks[g];
            let (mut da, mut db) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..LANES {
                da[k] = block[0].0[k] * a.0[k] + block[1].0[k] * b.0[k];
                db[k] = block[2].0[k] * a.0[k] + block[3].0[k] * b.0[k];
                amplitudes[g].0[k] = (a.0[k] * a.0[k] + b.0[k] * b.0[k]).sqrt();
            }
            for (part, [input_vector, other]) in force_components.iter().zip(&input_vectors[g * force_components.len()..]) {
                for k in 0..LANES {
                    da[k] += part * input_vector.0[k];
                    db[k] += part * other.0[k];
                }
            }
            for q in 0..quantities {
                let [ua, ub, va, vb] = &rows[g * quantities + q];
                let magnitudes = &mut rotating_rates[q * groups + g];
                let (mut rate_u, mut rate_v) = ([0.0; LANES], [0.0; LANES]);
                for k in 0..LANES {
                    rate_u[k] = ua.0[k] * da[k] + ub.0[k] * db[k];
                    rate_v[k] = va.0[k] * da[k] + vb.0[k] * db[k];
                }
                if q >= others {
                    let [along_u, along_v] = &mut rates[q - others];
                    for k in 0..LANES {
                        along_u.0[k] += rate_u[k];
                        along_v.0[k] += rate_v[k];
                    }
                }
                for k in 0..LANES {
                    let x = rate_u[k] + spin * (va.0[k] * a.0[k] + vb.0[k] * b.0[k]);
                    let z = rate_v[k] - spin * (ua.0[k] * a.0[k] + ub.0[k] * b.0[k]);
                    magnitudes.0[k] = (x * x + z * z).sqrt();
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
    use bladeoff_numerics::linalg::Matrix;

    /// Numbers of planes that are not a multiple of eight, and none, one or more unbalances.
    #[test]
    fn state_bounds_are_those_of_each_plane() {
        for (planes, unbalances) in [(1, 1), (5, 0), (8, 2), (13, 3), (24, 1)] {
            let value = |i: usize, j: usize| ((i * 31 + j * 17) % 23) as f64 - 11.3;
            let list = |i: usize| -> Vec<f64> { (0..2 * planes).map(|j| value(i, j)).collect() };
            let interval = IntervalModel {
                speed: 1.7,
                blocks: (0..planes).map(|k| std::array::from_fn(|i| value(k, i + 3))).collect(),
                output_rows: OutputRows::of(&Matrix::from_fn(6, 2 * planes, |i, j| value(i + 1, j))),
                output_matrix: OutputMatrix::new(&Matrix::zeros(0, 0)),
                input_vectors: (0..=2 * unbalances).map(|i| list(i + 50)).collect(),
                outputs_of_impulses: Vec::new(),
            };
            let y = list(99);
            let forces: Vec<Complex<f64>> = (0..unbalances).map(|s| Complex::new(value(s, 5), value(s, 9))).collect();
            let mut state_bounds = StateBounds::default();
            let step_bounds = StepBounds::new(&interval, (&[0, 4, 2], 2), unbalances, 1e-3);
            step_bounds.bound_states(&y, forces.iter().copied(), &mut state_bounds);
            let rates: Vec<f64> = (0..2 * planes)
                .map(|j| {
                    let (k, b) = (j % planes, interval.blocks[j % planes]);
                    let of = if j < planes { [b[0], b[1]] } else { [b[2], b[3]] };
                    let forced: f64 = forces
                        .iter()
                        .enumerate()
                        .map(|(s, f)| {
                            interval.input_vectors[2 * s][j] * f.re + interval.input_vectors[2 * s + 1][j] * f.im
                        })
                        .sum();
                    of[0] * y[k] + of[1] * y[planes + k] + forced + interval.input_vectors[2 * unbalances][j]
                })
                .collect();
            let mut sums = [[0.0; 2]; 2];
            for k in 0..planes {
                let near = |found: f64, wanted: f64| {
                    assert!((found - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{planes} {k}: {found} {wanted}");
                };
                near(state_bounds.amplitudes[k / LANES].0[k % LANES], length([y[k], y[planes + k]]));
                for (q, first) in [0, 4, 2].into_iter().enumerate() {
                    let of = |row: usize, x: &[f64]| {
                        interval.output_rows[row][k] * x[k] + interval.output_rows[row][planes + k] * x[planes + k]
                    };
                    let (displacement, rate) =
                        ([of(first, &y), of(first + 1, &y)], [of(first, &rates), of(first + 1, &rates)]);
                    let wanted = length([
                        rate[0] + interval.speed * displacement[1],
                        rate[1] - interval.speed * displacement[0],
                    ]);
                    near(state_bounds.rotating_rates[q * step_bounds.blocks.len() + k / LANES].0[k % LANES], wanted);
                    if q > 0 {
                        (0..2).for_each(|i| sums[q - 1][i] += rate[i]);
                    }
                }
            }
            assert_eq!(state_bounds.velocities.len(), 2);
            for (found, wanted) in state_bounds.velocities.iter().flatten().zip(sums.iter().flatten()) {
                assert!((found - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{planes}: {found} {wanted}");
            }
        }
    }
}
