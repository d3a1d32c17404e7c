//! What a load, or the rotor's place, can be between two looks in flight beyond what it is at them.
//!
//! ```text
//! v = sum over pairs of r y + constant,   w' = v' - W (e_z x v)     its rate for one who turns with the spin: |v| is that of v as he sees it      (1)
//! beyond its chord   at most  sum over pairs |w'| min((|B| + W) h^2/8, 2/w_k)     w_k = |B|/sqrt(2) - W, where that is positive                  (2)
//! from what it is    at most  sum over pairs |w'| min(h, 2/w_k)                                                                                   (3)
//! ```
//! A motion leaves its chord by h^2/8 of its second derivative, and one that rings by twice its amplitude. A step of flight is as long as (2) is below a
//! thousandth of the largest value so far, or as v and (3) are below that value: so far a peak may be missed. What turns with the unbalance has no w' and shortens nothing.
//! Limits: w' is that at n. Verified by `peaks_in_flight_are_those_of_contact_steps` (`tests/exponential_rub.rs`).

use super::bound::length;
use super::local::Local;

/// Part of the largest value so far that may be missed.
const PART: f64 = 1e-3;

/// The parts of (2) and (3) that a cell fixes.
#[derive(Debug, Clone)]
pub(super) struct Missed {
    /// First rows of the quantities, of two each.
    firsts: Vec<usize>,
    /// Lengths of steps \[s\], with the weights of the pairs in (2) and (3).
    levels: Vec<(f64, [Vec<f64>; 2])>,
}

/// A quantity at n: its constant part, its size, and the largest of all instants before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watched {
    pub constant: [f64; 2],
    pub size: f64,
    pub largest: f64,
}

impl Missed {
    /// Of quantities whose rows begin at these places, for steps of these lengths \[s\].
    pub fn new(cell: &Local, firsts: &[usize], lengths: &[f64]) -> Self {
        let spin = cell.speed.abs();
        let level = |&h: &f64| {
            let weights = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
                let block = |b: &[f64; 4]| b.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
                let pair = |block: f64| of(block, 2.0 / (block * std::f64::consts::FRAC_1_SQRT_2 - spin).max(1e-300));
                cell.blocks.iter().map(|b| pair(block(b))).collect()
            };
            (
                h,
                [
                    weights(&|block, twice| (0.125 * h * h * (block + spin)).min(twice)),
                    weights(&|_, twice| twice.min(h)),
                ],
            )
        };
        Self { firsts: firsts.to_vec(), levels: lengths.iter().map(level).collect() }
    }

    /// The longest step up to a level over which no peak of what is watched is missed, of y and y'; `sizes`: room.
    pub fn longest(
        &self,
        cell: &Local,
        [y, rates]: [&[f64]; 2],
        watched: &[Watched],
        most: usize,
        sizes: &mut Vec<f64>,
    ) -> usize {
        let mut longest = most.min(self.levels.len() - 1);
        for (&first, watched) in self.firsts.iter().zip(watched) {
            if longest == 0 {
                break;
            }
            rates_in_turn(cell, first, [y, rates], sizes);
            let spin = cell.speed.abs();
            let still = spin * length(watched.constant);
            longest = (1..=longest)
                .rev()
                .find(|&level| {
                    let (h, [beyond, from]) = &self.levels[level];
                    let sum = |weights: &[f64]| crate::linalg::dot(sizes, weights);
                    sum(beyond) + 0.125 * h * h * spin * still <= PART * watched.largest
                        || watched.size + sum(from) + h * still <= watched.largest
                })
                .unwrap_or(0);
        }
        longest
    }
}

/// |w'| of each pair in (1), of the quantity whose rows begin at a place.
fn rates_in_turn(cell: &Local, first: usize, [y, rates]: [&[f64]; 2], sizes: &mut Vec<f64>) {
    let pairs = cell.blocks.len();
    sizes.resize(pairs, 0.0);
    let spin = cell.speed;
    let ((ua, ub), (va, vb)) = (cell.rows[first].split_at(pairs), cell.rows[first + 1].split_at(pairs));
    let ((a, b), (da, db)) = (y.split_at(pairs), rates.split_at(pairs));
    let (ub, vb, b, db, sizes) = (&ub[..pairs], &vb[..pairs], &b[..pairs], &db[..pairs], &mut sizes[..pairs]);
    for k in 0..pairs {
        let place = [ua[k] * a[k] + ub[k] * b[k], va[k] * a[k] + vb[k] * b[k]];
        let rate = [ua[k] * da[k] + ub[k] * db[k], va[k] * da[k] + vb[k] * db[k]];
        sizes[k] = length([rate[0] + spin * place[1], rate[1] - spin * place[0]]);
    }
}
