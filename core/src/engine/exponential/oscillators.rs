//! Modes that do not know of each other, twist or ring, in closed form.
//!
//! ```text
//! n'' + c n' + w^2 n = f,  f constant over the step:      (n, n')+ = exp(B h) (n, n') + g(B) (0, f),   B = [[0, 1], [-w^2, -c]]
//! ```
//! Exact for any step, damped, overdamped or free; f is what a force is on average over the step. Functions of B: [`super::block`].

use super::block::Split;
use crate::linalg::lanes::kernel;

/// Amplitudes and their rates.
#[derive(Debug, Clone)]
pub(super) struct Oscillators {
    blocks: Vec<Split>,
    pub place: Vec<f64>,
    pub rate: Vec<f64>,
}

/// What a step size makes of them.
#[derive(Debug, Clone)]
pub(super) struct OscillatorStep {
    free: [Vec<f64>; 4],
    /// Place and rate after the step of a unit force.
    force: [Vec<f64>; 2],
}

impl Oscillators {
    /// At rest; `(w^2, c)` of each \[1/s2, 1/s\].
    pub fn new(modes: impl Iterator<Item = (f64, f64)>) -> Self {
        let blocks: Vec<Split> = modes.map(|(square, damping)| Split::of(&[0.0, 1.0, -square, -damping])).collect();
        let zeros = vec![0.0; blocks.len()];
        Self { blocks, place: zeros.clone(), rate: zeros }
    }

    /// Tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> OscillatorStep {
        let free: Vec<[f64; 4]> = self.blocks.iter().map(|block| block.exponential(h)).collect();
        let force: Vec<[f64; 2]> = self.blocks.iter().map(|block| block.constant(h, [0.0, 1.0])).collect();
        OscillatorStep {
            free: std::array::from_fn(|i| free.iter().map(|block| block[i]).collect()),
            force: std::array::from_fn(|i| force.iter().map(|response| response[i]).collect()),
        }
    }

    /// Takes them over a step without force.
    pub fn advance(&mut self, step: &OscillatorStep) {
        advance(&step.free, &mut self.place, &mut self.rate);
    }

    /// Adds what a force `scale * shape` over the step has made.
    pub fn add(&mut self, step: &OscillatorStep, scale: f64, shape: &[f64]) {
        add([&step.force[0], &step.force[1]], scale, shape, &mut self.place, &mut self.rate);
    }

    /// Adds at the end of the step what an impulse along a shape at its beginning has made.
    pub fn strike(&mut self, step: &OscillatorStep, impulse: f64, shape: &[f64]) {
        add([&step.free[1], &step.free[3]], impulse, shape, &mut self.place, &mut self.rate);
    }
}

impl OscillatorStep {
    /// Displacement along a shape at the end of the step by a unit impulse along it at the beginning.
    pub fn struck(&self, shape: &[f64]) -> f64 {
        self.free[1].iter().zip(shape).map(|(moved, part)| moved * part * part).sum()
    }
}

kernel! {
    fn advance(free: &[Vec<f64>; 4], place: &mut [f64], rate: &mut [f64]) {
        let count = place.len();
        let [aa, ab, ba, bb] = free.each_ref().map(|list| &list[..count]);
        let rate = &mut rate[..count];
        for j in 0..count {
            let (n, before) = (place[j], rate[j]);
            place[j] = aa[j] * n + ab[j] * before;
            rate[j] = ba[j] * n + bb[j] * before;
        }
    }
}

kernel! {
    /// Adds what so much of a shape makes: of place and of rate, per unit.
    fn add(makes: [&[f64]; 2], scale: f64, shape: &[f64], place: &mut [f64], rate: &mut [f64]) {
        let count = place.len();
        let (of_place, of_rate) = (&makes[0][..count], &makes[1][..count]);
        let (shape, rate) = (&shape[..count], &mut rate[..count]);
        for j in 0..count {
            place[j] += of_place[j] * (scale * shape[j]);
            rate[j] += of_rate[j] * (scale * shape[j]);
        }
    }
}
