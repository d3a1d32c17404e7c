//! What a load, or the rotor's place, can be between two looks in flight beyond what it is at them.
//!
//! ```text
//! r y between n and n+1:   beyond its chord by at most   sum over pairs |r| |y'| min(|B| h^2/8, 2/|B|),    y' = B y + l f           (1)
//! ```
//! A motion leaves its chord by h^2/8 of its second derivative, here `B y'`, and one that rings by twice its amplitude. A step of flight is as long as (1) is below a
//! thousandth of the largest value so far: so far a peak may be missed. What stands still under the unbalance has a small y' and lengthens nothing.
//! Limits: |y'| is that at n. Verified by `peaks_in_flight_are_those_of_contact_steps` (`tests/exponential_rub.rs`).

use super::bound::length;
use super::local::Local;
use nalgebra::Complex;

/// Part of the largest value so far that may be missed.
const PART: f64 = 1e-3;

/// The parts of (1) that a cell fixes.
#[derive(Debug, Clone)]
pub(super) struct Missed {
    /// |B| of each pair.
    blocks: Vec<f64>,
    /// |r| of each pair, for each quantity.
    rows: Vec<Vec<f64>>,
}

impl Missed {
    /// Of quantities of two rows each, which begin at these places.
    pub fn new(cell: &Local, firsts: &[usize]) -> Self {
        let pairs = cell.blocks.len();
        let of = |row: &[f64], k: usize| length([row[k], row[pairs + k]]);
        let rows = |&first: &usize| {
            (0..pairs).map(|k| length([of(&cell.rows[first], k), of(&cell.rows[first + 1], k)])).collect()
        };
        Self {
            blocks: cell.blocks.iter().map(|b| b.iter().map(|entry| entry * entry).sum::<f64>().sqrt()).collect(),
            rows: firsts.iter().map(rows).collect(),
        }
    }

    /// The longest of these lengths \[s\] over which (1) is small beside the largest values so far, of y under these forces \[N\]; `rates`: room.
    pub fn longest(
        &self,
        cell: &Local,
        (y, forces): (&[f64], &[Complex<f64>]),
        lengths: &[f64],
        largest: &[f64],
        rates: &mut Vec<f64>,
    ) -> usize {
        let pairs = self.blocks.len();
        rates.clear();
        for (k, b) in cell.blocks.iter().enumerate() {
            let weight = &cell.pushes[2 * forces.len()];
            let mut rate =
                [b[0] * y[k] + b[1] * y[pairs + k] + weight[k], b[2] * y[k] + b[3] * y[pairs + k] + weight[pairs + k]];
            for (s, f) in forces.iter().enumerate() {
                let (u, v) = (&cell.pushes[2 * s], &cell.pushes[2 * s + 1]);
                rate[0] += u[k] * f.re + v[k] * f.im;
                rate[1] += u[pairs + k] * f.re + v[pairs + k] * f.im;
            }
            rates.push(length(rate));
        }
        let small = |h: f64| {
            self.rows.iter().zip(largest).all(|(rows, largest)| {
                let beyond = rows.iter().zip(&*rates).zip(&self.blocks).map(|((row, rate), block)| {
                    row * rate * (0.125 * h * h * block).min(2.0 / block.max(f64::MIN_POSITIVE))
                });
                beyond.sum::<f64>() <= PART * largest
            })
        };
        (1..lengths.len()).rev().find(|&level| small(lengths[level])).unwrap_or(0)
    }
}
