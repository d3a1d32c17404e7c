//! What an impulse on the rotor at n is at n+1, in one cell and for one step.
//!
//! ```text
//! y      exp(B h) l                             X = rows exp(B h) l                                  displacement per impulse
//! steady train J = F h at n:   rows (1 - exp(B h))^-1 exp(B h) l h F;    constant force:  -rows B^-1 l F                       (1)
//! ```
//! The difference of (1), per impulse, is what a train of impulses lacks at n (as [`super::kicked_ring`] has it of the ring): of displacements, and of the bearings' loads.
//!
//! ```text
//! s(t)   = exp(B t) (1 - exp(B h))^-1 l J                         a steady train's motion between impulses, a saw-tooth of the rates
//! lost   int_0^h lost(s(t)) dt - h lost(s(0) - l J/2)             what the mean rates at n do not say of what damping takes         (2)
//! ```
//! (2) is of second order in the step and goes with the square of the impulse: 1.4e-5 of a whipping turbine's energies. Of a train that is not steady it is an estimate. It is taken
//! at the stations, and linear between them, as all of a cell is: `between_stations_the_saw_tooth_is_linear`.

use super::block::{Block, Split};
use super::forms::Form;
use super::local::Local;
use super::propagator::Propagator;
use crate::linalg::dot;

/// Impulses along the axes of one diaphragm's node.
#[derive(Debug, Clone)]
pub(super) struct Kick {
    /// Whirl states at n+1 of a unit impulse along each axis.
    pub states: [Vec<f64>; 2],
    /// Outputs of those.
    pub outputs: [Vec<f64>; 2],
    /// X, and what trains lack \[m/(N s)\].
    pub moved: [[f64; 2]; 2],
    pub lacking: [[f64; 2]; 2],
    /// Jump of the node's velocity at n \[m/s/(N s)\].
    pub jump: [[f64; 2]; 2],
    /// What each bearing's load lacks \[N/(N s)\]: nearly half of its jump, but not of pairs that come to rest within the step, of which a mean of before and after may have any size.
    pub loads: Vec<[[f64; 2]; 2]>,
}

impl Kick {
    /// Of the node whose rows and pushes begin at these places; `loads`: first row of each bearing's load.
    pub fn new(cell: &Local, propagator: &Propagator, h: f64, row: usize, push: usize, loads: &[usize]) -> Self {
        let pushes = [&cell.pushes[push], &cell.pushes[push + 1]];
        let states = pushes.map(|l| propagator.free(l));
        let pairs = cell.blocks.len();
        let rest = [0, 1].map(|axis| {
            let mut y = vec![0.0; 2 * pairs];
            for k in 0..pairs {
                let e = propagator.of_pair(k);
                let train = solve(&[1.0 - e[0], -e[1], -e[2], 1.0 - e[3]], [states[axis][k], states[axis][pairs + k]]);
                let still = solve(&cell.blocks[k], [pushes[axis][k], pushes[axis][pairs + k]]);
                y[k] = -still[0] / h - train[0];
                y[pairs + k] = -still[1] / h - train[1];
            }
            y
        });
        let of = |first: usize, y: &[Vec<f64>; 2]| -> [[f64; 2]; 2] {
            [0, 1].map(|i| [dot(&cell.rows[first + i], &y[0]), dot(&cell.rows[first + i], &y[1])])
        };
        let whole = pushes.map(Clone::clone);
        Self {
            moved: of(row, &states),
            lacking: of(row, &rest),
            jump: of(row + 2, &whole),
            loads: loads.iter().map(|&first| of(first, &rest)).collect(),
            outputs: states.each_ref().map(|y| {
                let mut outputs = Vec::new();
                cell.outputs.times(y, &mut outputs);
                outputs
            }),
            states,
        }
    }
}

/// Places and weights on -1..1 that integrate a polynomial of the eleventh degree (Gauss and Legendre).
const PLACES: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];

/// (2) of impulses with these pushes where `lost` is what damping takes: factors of J_u^2, J_v^2 and J_u J_v \[1/kg\].
pub(super) fn saw_tooth(blocks: &[Block], pushes: [&[f64]; 2], lost: &Form, h: f64) -> [f64; 3] {
    let pairs = blocks.len();
    let both: Vec<f64> = pushes[0].iter().zip(pushes[1]).map(|(u, v)| u + v).collect();
    let split: Vec<Split> = blocks.iter().map(Split::of).collect();
    let whole: Vec<Block> = split.iter().map(|block| block.exponential(h)).collect();
    let instants: Vec<(f64, Vec<Block>)> = PLACES
        .iter()
        .flat_map(|&(place, weight)| [1.0 - place, 1.0 + place].map(|at| (0.5 * h * weight, 0.5 * h * at)))
        .map(|(weight, t)| (weight, split.iter().map(|block| block.exponential(t)).collect()))
        .collect();
    let [u, v, sum] = [pushes[0], pushes[1], &both].map(|l| {
        let mut struck = vec![0.0; 2 * pairs];
        for (k, e) in whole.iter().enumerate() {
            [struck[k], struck[pairs + k]] = solve(&[1.0 - e[0], -e[1], -e[2], 1.0 - e[3]], [l[k], l[pairs + k]]);
        }
        let mut y = vec![0.0; 2 * pairs];
        let mut at = |blocks: &[Block]| {
            for (k, e) in blocks.iter().enumerate() {
                let (a, b) = (struck[k], struck[pairs + k]);
                [y[k], y[pairs + k]] = [e[0] * a + e[1] * b, e[2] * a + e[3] * b];
            }
            lost.of(&y)
        };
        let whole: f64 = instants.iter().map(|(weight, blocks)| weight * at(blocks)).sum();
        let mean: Vec<f64> = struck.iter().zip(l).map(|(after, l)| after - 0.5 * l).collect();
        whole - h * lost.of(&mean)
    });
    [u, v, sum - u - v]
}

/// `m^-1 v`.
fn solve(m: &Block, v: [f64; 2]) -> [f64; 2] {
    let determinant = m[0] * m[3] - m[1] * m[2];
    [(m[3] * v[0] - m[1] * v[1]) / determinant, (m[0] * v[1] - m[2] * v[0]) / determinant]
}
