//! A ring's modes under impulses at equal times.
//!
//! ```text
//! at n      n'+ = k n'- + b J,   b = 1/(1 + ch/2),  k = (1 - ch/2) b         damping on the mean of n'- and n'+            (1)
//! between   n, n' turn by wh                                                  exact
//! steady    J = F h:  n = F (h/2w) cot(wh/2) at n, whatever c; a constant force F makes F/w^2                             (2)
//! ```
//! The velocity between impulses is a saw-tooth: damping that acted on it would take 44 kJ of a turbine's rub at 50 us, (1) takes none of a steady
//! train. The difference of (2) to the true static displacement is what a train of impulses at n lacks; it goes with the force, like the modes left
//! out ([`KickedRing::lacking`]), so that statics are exact at any step.
//! Source: the theory page of this engine. Verified by `a_steady_train_of_impulses_makes_the_static_displacement`.

use super::oscillators::{OscillatorStep, Oscillators};
use crate::linalg::lanes::{LANES, kernel, sum};

/// Modes under way. All lists have a multiple of eight entries: those behind the last mode are of modes at rest that nothing moves.
#[derive(Debug, Clone)]
pub(super) struct KickedRing {
    count: usize,
    pub modes: Oscillators,
    /// w^2 and c of each.
    squares: Vec<f64>,
    dampings: Vec<f64>,
    ones: Vec<f64>,
    /// Mean of n'- and n'+ at the last n.
    pub mean_rate: Vec<f64>,
    /// From n to n+1 without impulse.
    pub way: Vec<f64>,
    kicked: Kicked,
    step: f64,
}

/// Of each mode.
#[derive(Debug, Clone, Default)]
struct Kicked {
    cos: Vec<f64>,
    /// sin(wh)/w and w sin(wh).
    over: Vec<f64>,
    times: Vec<f64>,
    kept: Vec<f64>,
    gain: Vec<f64>,
}

impl KickedRing {
    /// At rest; w^2 > 0 and c of each mode, and the time between impulses.
    pub fn new(modes: &[(f64, f64)], h: f64) -> Self {
        let count = modes.len();
        let behind = count.next_multiple_of(LANES) - count;
        let modes: Vec<(f64, f64)> = modes.iter().copied().chain(std::iter::repeat_n((1.0, 0.0), behind)).collect();
        let mut kicked = Kicked::default();
        for &(square, damping) in &modes {
            let w = square.sqrt();
            let (sin, cos) = libm::sincos(w * h);
            let gain = 1.0 / (1.0 + 0.5 * damping * h);
            kicked.cos.push(cos);
            kicked.over.push(sin / w);
            kicked.times.push(w * sin);
            kicked.kept.push((1.0 - 0.5 * damping * h) * gain);
            kicked.gain.push(gain);
        }
        Self {
            count,
            squares: modes.iter().map(|mode| mode.0).collect(),
            dampings: modes.iter().map(|mode| mode.1).collect(),
            ones: vec![1.0; modes.len()],
            mean_rate: vec![0.0; modes.len()],
            way: vec![0.0; modes.len()],
            modes: Oscillators::new(modes.into_iter()),
            kicked,
            step: h,
        }
    }

    /// Amplitudes of the modes.
    pub fn place(&self) -> &[f64] {
        &self.modes.place[..self.count]
    }

    /// Goes from n to n+1 without impulse, but with the damping of (1).
    pub fn drift(&mut self) {
        let Self { modes, mean_rate, way, kicked, .. } = self;
        drift(&mut modes.place, &mut modes.rate, mean_rate, way, kicked);
    }

    /// Adds at n+1 what impulses J at n have made.
    pub fn kick(&mut self, impulses: &[f64]) {
        let Self { modes, mean_rate, kicked, .. } = self;
        kick(impulses, &mut modes.place, &mut modes.rate, mean_rate, kicked);
    }

    /// What (1) has taken at n \[J\].
    pub fn damped(&self) -> f64 {
        self.step * weighted_square(&self.dampings, &self.mean_rate)
    }

    /// Kinetic and strain energy \[J\].
    pub fn energies(&self) -> [f64; 2] {
        [0.5 * weighted_square(&self.ones, &self.modes.rate), 0.5 * weighted_square(&self.squares, &self.modes.place)]
    }

    /// Goes a step of any size in free flight.
    pub fn fly(&mut self, step: &OscillatorStep) {
        self.modes.advance(step);
    }

    /// Displacement at n+1 by a unit impulse at n.
    pub fn yields(&self) -> Vec<f64> {
        self.kicked.over.iter().zip(&self.kicked.gain).map(|(over, gain)| over * gain).collect()
    }

    /// What (2) lacks, per unit impulse.
    pub fn lacking(&self) -> Vec<f64> {
        let of = |((cos, times), square): ((&f64, &f64), &f64)| {
            // (1/2w) cot(wh/2) = (1 + cos wh)/(2 w sin wh)
            1.0 / (square * self.step) - 0.5 * (1.0 + cos) / times
        };
        self.kicked.cos.iter().zip(&self.kicked.times).zip(&self.squares).map(of).collect()
    }

    /// Sum of the largest displacements of all modes from now on, without impulses, times weights.
    pub fn reach(&self, weights: &[f64]) -> f64 {
        reach(weights, &self.modes.place, &self.modes.rate, &self.squares)
    }
}

kernel! {
    /// `sum_j w_j sqrt(n_j^2 + n_j'^2/w_j^2)`; no more weights than modes.
    fn reach(weights: &[f64], place: &[f64], rate: &[f64], squares: &[f64]) -> f64 {
        let mut sums = [0.0; LANES];
        let modes = place.as_chunks::<LANES>().0.iter().zip(rate.as_chunks::<LANES>().0).zip(squares.as_chunks::<LANES>().0);
        for (weights, ((n, rate), square)) in weights.chunks(LANES).zip(modes) {
            let mut sizes = [0.0; LANES];
            for k in 0..LANES {
                sizes[k] = (n[k] * n[k] + rate[k] * rate[k] / square[k]).sqrt();
            }
            if let Some(weights) = weights.first_chunk::<LANES>() {
                for k in 0..LANES {
                    sums[k] += weights[k] * sizes[k];
                }
            } else {
                for (k, weight) in weights.iter().enumerate() {
                    sums[k] += weight * sizes[k];
                }
            }
        }
        sum(sums)
    }
}

kernel! {
    /// `sum_j w_j x_j^2`.
    fn weighted_square(weights: &[f64], x: &[f64]) -> f64 {
        let mut sums = [0.0; LANES];
        for (w, x) in weights.as_chunks::<LANES>().0.iter().zip(x.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                sums[k] += w[k] * (x[k] * x[k]);
            }
        }
        sum(sums)
    }
}

kernel! {
    fn drift(place: &mut [f64], rate: &mut [f64], mean: &mut [f64], way: &mut [f64], kicked: &Kicked) {
        let count = place.len();
        let (cos, over) = (&kicked.cos[..count], &kicked.over[..count]);
        let (times, kept) = (&kicked.times[..count], &kicked.kept[..count]);
        let (rate, mean, way) = (&mut rate[..count], &mut mean[..count], &mut way[..count]);
        for j in 0..count {
            let (from, before) = (place[j], rate[j]);
            let after = kept[j] * before;
            let to = cos[j] * from + over[j] * after;
            mean[j] = 0.5 * (before + after);
            rate[j] = cos[j] * after - times[j] * from;
            place[j] = to;
            way[j] = to - from;
        }
    }
}

kernel! {
    fn kick(impulses: &[f64], place: &mut [f64], rate: &mut [f64], mean: &mut [f64], kicked: &Kicked) {
        let count = place.len();
        let (cos, over, gain) = (&kicked.cos[..count], &kicked.over[..count], &kicked.gain[..count]);
        let (rate, mean, impulses) = (&mut rate[..count], &mut mean[..count], &impulses[..count]);
        for j in 0..count {
            let gained = gain[j] * impulses[j];
            mean[j] += 0.5 * gained;
            place[j] += over[j] * gained;
            rate[j] += cos[j] * gained;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_train_of_impulses_makes_the_static_displacement() {
        let (square, damping, h) = (9e6_f64, 200.0, 1e-4);
        let mut ring = KickedRing::new(&[(square, damping)], h);
        let force = 5.0;
        let mut impulses = [0.0; LANES];
        impulses[0] = force * h;
        for _ in 0..4000 {
            ring.drift();
            ring.kick(&impulses);
        }
        let whole = ring.modes.place[0] + ring.lacking()[0] * force * h;
        assert!((whole * square / force - 1.0).abs() < 1e-10, "{whole}");
        // as large a correction as the mode's own displacement needs at this step: w h = 0.3
        assert!((ring.modes.place[0] * square / force - 1.0).abs() > 5e-3);
    }

    #[test]
    fn between_impulses_a_mode_decays_as_it_should() {
        let (square, damping, h) = (9e6_f64, 200.0, 1e-5);
        let mut ring = KickedRing::new(&[(square, damping)], h);
        ring.modes.place[0] = 1.0;
        for _ in 0..1000 {
            ring.drift();
        }
        let exact = (-0.5 * damping * 1e-2_f64).exp();
        let found = ring.reach(&[1.0]);
        assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
    }
}
