//! Independent oscillators over a step of constant force, in closed form.
//!
//! ```text
//! n'' + c n' + w^2 n = f,  f constant over the step:      (n, n')+ = exp(B h) (n, n') + g(B) (0, f),   B = [[0, 1], [-w^2, -c]]
//! ```
//! Exact for any step and any damping; f is the mean of a force over the step. Functions of B: `modal/plane_block.rs`. Lists have
//! a multiple of eight entries.

use crate::engine::exponential::modal::plane_block::SplitBlock;
use bladeoff_numerics::linalg::lanes::{LANES, Lane};

/// Tables of a step, in groups of eight modes.
#[derive(Debug, Clone)]
pub(crate) struct OscillatorStep {
    pub lanes: Vec<OscillatorLanes>,
}

/// Tables of a step for eight modes.
#[derive(Debug, Clone, Default)]
pub(crate) struct OscillatorLanes {
    /// Entries of `exp(B h)`, by rows.
    pub free: [Lane; 4],
    /// Displacement and rate after the step per unit force.
    pub force: [Lane; 2],
}

impl OscillatorStep {
    /// Creates the tables of modes with these blocks B for a step of `h` \[s\].
    pub fn new(blocks: &[SplitBlock], h: f64) -> Self {
        let eight = |blocks: &[SplitBlock]| {
            let mut eight = OscillatorLanes::default();
            for (k, block) in blocks.iter().enumerate() {
                let (free, force) = (block.exponential(h), block.constant_response(h, [0.0, 1.0]));
                for i in 0..4 {
                    eight.free[i].0[k] = free[i];
                }
                for i in 0..2 {
                    eight.force[i].0[k] = force[i];
                }
            }
            eight
        };
        Self { lanes: blocks.chunks(LANES).map(eight).collect() }
    }
}

impl OscillatorLanes {
    /// Displacement and rate of eight modes after the step without force; inside a kernel.
    #[inline(always)]
    pub fn after(&self, displacement: &[f64; LANES], rate: &[f64; LANES]) -> [[f64; LANES]; 2] {
        let [aa, ab, ba, bb] = &self.free;
        let by = |a: &Lane, b: &Lane| std::array::from_fn(|k| a.0[k] * displacement[k] + b.0[k] * rate[k]);
        [by(aa, ab), by(ba, bb)]
    }
}
