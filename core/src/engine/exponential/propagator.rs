//! One step of the whirl states in a cell, exactly, for a step size.
//!
//! ```text
//! y+ = exp(B h) y + sum_s Re(c_s f_s) + c_w,     c_s = g(B) (l_u - i l_v)                  (block)
//! ```
//! f_s is the complex force of unbalance s in the middle of the step, which turns with the cell's speed, c_w the weight's. A pair costs eight products with
//! one unbalance; nothing depends on the step's size.

use super::block::{Block, Split};
use super::local::Local;
use crate::linalg::lanes::kernel;
use nalgebra::Complex;

/// `exp(B h)` and the responses of a step size in one cell.
#[derive(Debug, Clone)]
pub(super) struct Propagator {
    /// Entries of `exp(B h)`, one list of all pairs for each.
    free: [Vec<f64>; 4],
    /// `Re c` and `-Im c` of each unbalance, for both vectors of all pairs.
    harmonic: Vec<[Vec<f64>; 4]>,
    /// c_w; empty without weight.
    constant: Vec<f64>,
}

impl Propagator {
    /// For steps of `h` \[s\] in a cell under so many unbalances.
    pub fn new(cell: &Local, unbalances: usize, h: f64) -> Self {
        let pairs = cell.blocks.len();
        let split: Vec<Split> = cell.blocks.iter().map(Split::of).collect();
        let blocks: Vec<Block> = split.iter().map(|block| block.exponential(h)).collect();
        let harmonic = |s: usize| {
            let (u, v) = (&cell.pushes[2 * s], &cell.pushes[2 * s + 1]);
            let l = |at: usize| Complex::new(u[at], -v[at]);
            let all: Vec<[Complex<f64>; 2]> =
                split.iter().enumerate().map(|(k, b)| b.harmonic(cell.speed, h, [l(k), l(pairs + k)])).collect();
            let list = |of: &dyn Fn(&[Complex<f64>; 2]) -> f64| all.iter().map(of).collect::<Vec<f64>>();
            [list(&|c| c[0].re), list(&|c| -c[0].im), list(&|c| c[1].re), list(&|c| -c[1].im)]
        };
        let weight = &cell.pushes[2 * unbalances];
        let mut constant = Vec::new();
        if weight.iter().any(|&push| push != 0.0) {
            constant = vec![0.0; 2 * pairs];
            for (k, block) in split.iter().enumerate() {
                [constant[k], constant[pairs + k]] = block.constant(h, [weight[k], weight[pairs + k]]);
            }
        }
        Self {
            free: std::array::from_fn(|i| blocks.iter().map(|block| block[i]).collect()),
            harmonic: (0..unbalances).map(harmonic).collect(),
            constant,
        }
    }

    /// Takes y over the step without any force.
    pub fn turn(&self, y: &mut [f64]) {
        let (a, b) = y.split_at_mut(self.free[0].len());
        turn(&self.free, a, b);
    }

    /// y after the step of a unit force of an unbalance along u in its middle.
    pub fn of_force(&self, s: usize) -> Vec<f64> {
        [self.harmonic[s][0].as_slice(), &self.harmonic[s][2]].concat()
    }

    /// `exp(B h)` of a pair.
    pub fn of_pair(&self, k: usize) -> Block {
        self.free.each_ref().map(|list| list[k])
    }

    /// Takes y over the step under the unbalances' forces in its middle \[N\].
    pub fn advance(&self, forces: &[Complex<f64>], y: &mut [f64]) {
        self.turn(y);
        let (a, b) = y.split_at_mut(self.free[0].len());
        for (response, f) in self.harmonic.iter().zip(forces) {
            push(response, [f.re, f.im], a, b);
        }
        for (y, push) in y.iter_mut().zip(&self.constant) {
            *y += push;
        }
    }
}

kernel! {
    /// (a, b) of all pairs by their blocks' entries.
    fn turn(free: &[Vec<f64>; 4], a: &mut [f64], b: &mut [f64]) {
        let pairs = a.len();
        let [aa, ab, ba, bb] = free.each_ref().map(|list| &list[..pairs]);
        let b = &mut b[..pairs];
        for k in 0..pairs {
            let (x, z) = (a[k], b[k]);
            a[k] = aa[k] * x + ab[k] * z;
            b[k] = ba[k] * x + bb[k] * z;
        }
    }
}

kernel! {
    /// Adds to (a, b) of all pairs what they have of a force.
    fn push(response: &[Vec<f64>; 4], f: [f64; 2], a: &mut [f64], b: &mut [f64]) {
        let pairs = a.len();
        let [ar, ai, br, bi] = response.each_ref().map(|list| &list[..pairs]);
        let b = &mut b[..pairs];
        for k in 0..pairs {
            a[k] += ar[k] * f[0] + ai[k] * f[1];
        }
        for k in 0..pairs {
            b[k] += br[k] * f[0] + bi[k] * f[1];
        }
    }
}
