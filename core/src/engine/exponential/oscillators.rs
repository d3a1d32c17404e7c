//! Modes that do not know of each other, twist or ring, in closed form.
//!
//! ```text
//! n'' + c n' + w^2 n = f,  f constant over the step:      (n, n')+ = exp(B h) (n, n') + g(B) (0, f),   B = [[0, 1], [-w^2, -c]]
//! ```
//! Exact for any step, damped, overdamped or free; f is what a force is on average over the step. Functions of B: [`super::block`].
//! All lists have a multiple of eight entries.

use super::block::Split;
use crate::linalg::lanes::{LANES, Lane, kernel};

/// Amplitudes and their rates.
#[derive(Debug, Clone)]
pub(super) struct Oscillators {
    blocks: Vec<Split>,
    pub place: Vec<f64>,
    pub rate: Vec<f64>,
}

/// What a step size makes of them, eight after eight.
#[derive(Debug, Clone)]
pub(super) struct OscillatorStep {
    pub eights: Vec<Eight>,
}

/// That of eight modes.
#[derive(Debug, Clone, Default)]
pub(super) struct Eight {
    /// Entries of `exp(B h)`, by rows.
    pub free: [Lane; 4],
    /// Place and rate after the step of a unit force.
    pub force: [Lane; 2],
}

impl Oscillators {
    /// At rest; `(w^2, c)` of each \[1/s2, 1/s\].
    pub fn new(modes: impl Iterator<Item = (f64, f64)>) -> Self {
        let blocks: Vec<Split> = modes.map(|(square, damping)| Split::of(&[0.0, 1.0, -square, -damping])).collect();
        debug_assert!(blocks.len().is_multiple_of(LANES), "eight after eight");
        let zeros = vec![0.0; blocks.len()];
        Self { blocks, place: zeros.clone(), rate: zeros }
    }

    /// Tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> OscillatorStep {
        OscillatorStep::new(&self.blocks, h)
    }

    /// Takes them over a step without force.
    pub fn advance(&mut self, step: &OscillatorStep) {
        advance(&step.eights, &mut self.place, &mut self.rate);
    }
}

impl OscillatorStep {
    /// Of modes over a step of `h` \[s\].
    pub fn new(blocks: &[Split], h: f64) -> Self {
        let eight = |blocks: &[Split]| {
            let mut eight = Eight::default();
            for (k, block) in blocks.iter().enumerate() {
                let (free, force) = (block.exponential(h), block.constant(h, [0.0, 1.0]));
                for i in 0..4 {
                    eight.free[i].0[k] = free[i];
                }
                for i in 0..2 {
                    eight.force[i].0[k] = force[i];
                }
            }
            eight
        };
        Self { eights: blocks.chunks(LANES).map(eight).collect() }
    }
}

impl Eight {
    /// Place and rate of eight modes after the step without force; inside a kernel.
    #[inline(always)]
    pub fn after(&self, place: &[f64; LANES], rate: &[f64; LANES]) -> [[f64; LANES]; 2] {
        let [aa, ab, ba, bb] = &self.free;
        let by = |a: &Lane, b: &Lane| std::array::from_fn(|k| a.0[k] * place[k] + b.0[k] * rate[k]);
        [by(aa, ab), by(ba, bb)]
    }
}

kernel! {
    fn advance(step: &[Eight], place: &mut [f64], rate: &mut [f64]) {
        let modes = place.as_chunks_mut::<LANES>().0.iter_mut().zip(rate.as_chunks_mut::<LANES>().0);
        for (eight, (place, rate)) in step.iter().zip(modes) {
            [*place, *rate] = eight.after(place, rate);
        }
    }
}
