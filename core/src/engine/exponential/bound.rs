//! How fast a node of the rotor can move during a step, whatever its whirl states do.
//!
//! ```text
//! x' = sum over pairs of rows y',   |y'| <= |B| |y| + |l| f,   |y(t)| <= g (|y| + h |l| f),   g = exp(h max(0, mu(B)))
//! v  = sum over pairs of |rows| [ |B| g (|y| + h |l| f) + |l| f ]                                                          (1)
//! ```
//! mu(B) is the largest eigenvalue of the symmetric part of a block, its logarithmic norm, which bounds its exponential (Dahlquist 1958); f the unbalances'
//! forces with a margin for the change of spin and twist in the step. (1) is a bound, not an estimate. Verified by `the_bound_of_the_velocity_is_one`.

use super::local::Local;

/// What the unbalances' forces may grow by in a step.
const GROWING: f64 = 1.05;

/// The parts of (1) that a cell fixes, for one node.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    pairs: Vec<PairBound>,
}

#[derive(Debug, Clone)]
struct PairBound {
    rows: f64,
    block: f64,
    growth: f64,
    /// |l| of each unbalance, and of the weight as it stands.
    pushes: Vec<f64>,
    weight: f64,
}

impl Bound {
    /// Of the node whose rows begin at a place, in a cell under so many unbalances.
    pub fn new(cell: &Local, row: usize, unbalances: usize) -> Self {
        let pairs = cell.blocks.len();
        let of = |v: &[f64], k: usize| length([v[k], v[pairs + k]]);
        let pair = |(k, b): (usize, &[f64; 4])| {
            let mean = 0.5 * (b[0] + b[3]);
            PairBound {
                rows: length([of(&cell.rows[row], k), of(&cell.rows[row + 1], k)]),
                block: b.iter().map(|entry| entry * entry).sum::<f64>().sqrt(),
                growth: (mean + length([0.5 * (b[0] - b[3]), 0.5 * (b[1] + b[2])])).max(0.0),
                pushes: (0..unbalances)
                    .map(|s| length([of(&cell.pushes[2 * s], k), of(&cell.pushes[2 * s + 1], k)]))
                    .collect(),
                weight: of(&cell.pushes[2 * unbalances], k),
            }
        };
        Self { pairs: cell.blocks.iter().enumerate().map(pair).collect() }
    }

    /// v of a step of `h` \[s\] from y under unbalances of these forces at n \[N\].
    pub fn speed(&self, h: f64, y: &[f64], forces: &[f64]) -> f64 {
        let count = self.pairs.len();
        let mut sum = 0.0;
        for (k, pair) in self.pairs.iter().enumerate() {
            let pushed = pair.pushes.iter().zip(forces).map(|(l, f)| l * f).sum::<f64>();
            let pushed = GROWING * pushed + pair.weight;
            let grown = if pair.growth > 0.0 { libm::exp(h * pair.growth) } else { 1.0 };
            sum += pair.rows * (pair.block * grown * (length([y[k], y[count + k]]) + h * pushed) + pushed);
        }
        sum
    }
}

/// Length of a vector: one root, the same on every machine.
pub(super) fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}
