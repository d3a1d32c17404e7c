//! How far a node of the rotor can come during a step, whatever its whirl states do.
//!
//! ```text
//! x = sum over pairs of rows y,   y' = B y + l f,   |y'| <= D = |B| g (|y| + h |l| f) + |l| f,   g = exp(h max(0, mu(B)))
//! |x(t) - x - t x'|  <=  sum over pairs of |rows| [ |B| D min(h^2/2, 2h/|B|) + |l| f W h^2 ],    0 <= t <= h              (1)
//! |x + t x'|  <=  max(|x|, |x + h x'|)
//! ```
//! mu(B) is the largest eigenvalue of the symmetric part of a block, its logarithmic norm, which bounds its exponential (Dahlquist 1958); f the unbalances'
//! forces with a margin for the change of spin and twist in the step, in which they change by `2 W t f` at most: they turn with W, and as much again is left for twist and braking.
//! (1) is a bound, not an estimate: a rotor that moves away, or along its ring, may fly on where its velocity alone would not let it.
//! Verified by `the_bound_of_the_way_is_one`.

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
    /// |B|, and 1/|B|.
    block: f64,
    turn: f64,
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
            let block = b.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            PairBound {
                rows: length([of(&cell.rows[row], k), of(&cell.rows[row + 1], k)]),
                block,
                turn: 1.0 / block,
                growth: (mean + length([0.5 * (b[0] - b[3]), 0.5 * (b[1] + b[2])])).max(0.0),
                pushes: (0..unbalances)
                    .map(|s| length([of(&cell.pushes[2 * s], k), of(&cell.pushes[2 * s + 1], k)]))
                    .collect(),
                weight: of(&cell.pushes[2 * unbalances], k),
            }
        };
        Self { pairs: cell.blocks.iter().enumerate().map(pair).collect() }
    }

    /// What (1) has of each pair, `|rows| |B| D`, for steps of at most `h` \[s\] from y under unbalances of these forces at n \[N\]; and
    /// `|rows| |l| f` of all.
    pub fn parts(&self, h: f64, y: &[f64], forces: &[f64], parts: &mut Vec<f64>) -> f64 {
        let count = self.pairs.len();
        let mut all = 0.0;
        parts.clear();
        for (k, pair) in self.pairs.iter().enumerate() {
            let turned = GROWING * pair.pushes.iter().zip(forces).map(|(l, f)| l * f).sum::<f64>();
            let pushed = turned + pair.weight;
            let grown = if pair.growth > 0.0 { libm::exp(h * pair.growth) } else { 1.0 };
            let rate = pair.block * grown * (length([y[k], y[count + k]]) + h * pushed) + pushed;
            parts.push(pair.rows * pair.block * rate);
            all += pair.rows * turned;
        }
        all
    }

    /// (1) of a step of `h` \[s\] at a spin, by its parts.
    pub fn beyond(&self, h: f64, spin: f64, parts: &[f64], pushed: f64) -> f64 {
        let half = 0.5 * h * h;
        let ways = parts.iter().zip(&self.pairs).map(|(part, pair)| part * half.min(2.0 * h * pair.turn));
        ways.sum::<f64>() + pushed * spin.abs() * h * h
    }
}

/// Length of a vector: one root, the same on every machine.
#[inline(always)]
pub(super) fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}
