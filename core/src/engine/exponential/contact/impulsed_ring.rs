//! Vibration of a ring's modes under impulses at equal times.
//!
//! ```text
//! n'' + c n' + w^2 n = phi.F                  mode of unit mass; phi: mode shape at the force                                  (1)
//! at n       n'+ = k n'- + b J                b = 1/(1 + c h/2),  k = (1 - c h/2) b;  J: modal impulse; damping acts on (n'- + n'+)/2   (2)
//! between    n, n' rotate by the phase w h    exact for the undamped mode                                                      (3)
//! train      J = F h at every n               n = F (h/2w) cot(w h/2) at n, whatever c;  a constant force F makes F/w^2        (4)
//! free step  n, n' by exp(B h)                B = [[0, 1], [-w^2, -c]], exact for any h                                        (5)
//! ```
//! n: amplitude \[m kg^0.5\] of a mode with frequency w \[rad/s\] and damping rate c \[1/s\]; h: contact step \[s\].
//!
//! Between impulses the velocity is a saw-tooth. Damping that acted on the saw-tooth would take 44 kJ of a turbine's rub at 50
//! us; (2) takes nothing of a steady train. The static correction of a mode is the difference of the two displacements in (4). It
//! is proportional to the force, like the residual flexibility of the truncated modes ([`ImpulsedRing::compliance`]), so static
//! displacements are exact at any step.
//!
//! Source: docs/theory/08-exponential-engine.md, "Contact". Verified by
//! `a_steady_train_of_impulses_makes_the_static_displacement`.

use crate::eight::{Eight, by_width};
use crate::engine::exponential::modal::plane_block::SplitBlock;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, flat, lanes_of};

/// Weight of the impulse at n in the static correction at n+1; the impulse at n-1 has the weight -1. Together they extrapolate
/// the force linearly to n+1 ([`super::contact_predictor`]).
pub(crate) const STATIC_WEIGHT: f64 = 2.0;

/// Response of a ring's truncated modes to a train of impulses.
///
/// ```text
/// x + b x' = R F                                      R: residual flexibility \[m/N\];  b: stiffness-proportional damping \[s\]
/// x(n+1)   = R (s J_n - (s - 1) J_(n-1))/h            s = 2 - b/h: the force of the time t(n+1) - b, linear in time
/// ```
/// A mode with frequency w and damping b w^2 follows a slow force with the delay b. Without this delay (s = 2) truncated modes
/// are undamped, and friction drives the kept modes through them: a ring with 24 stiff blades then flutters as soon as the
/// contact step is too small to damp it. The default contact step damps the truncated modes itself. The delay is therefore 0 at
/// the default step, and b at half of it and below.
///
/// Source: first two terms of 1/(w^2 + i W c - W^2) in W, with c = b w^2. Limits: the last two impulses cannot show a delay above
/// h; the truncated modes are then undamped. Mass-proportional damping a has a delay of a/w^2, which is neglected. Verified by
/// `tests/exponential/exponential_fine_steps.rs`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StaticCorrection {
    /// Contact step \[s\].
    h: f64,
    /// Weight s of the impulse at n.
    weight: f64,
}

impl StaticCorrection {
    /// Creates the response to impulses at intervals of `h` \[s\]; `delay`: stiffness-proportional damping b \[s\].
    pub fn new(h: f64, delay: f64) -> Self {
        let counted = if delay > h { 0.0 } else { delay };
        Self { h, weight: STATIC_WEIGHT - counted / h }
    }

    /// Force at n+1 per impulse at n, s/h \[1/s\].
    pub fn gain(self) -> f64 {
        self.weight / self.h
    }

    /// Share of the preceding impulses that is subtracted, (s - 1)/s.
    #[inline(always)]
    pub fn previous_share(self) -> f64 {
        (self.weight - 1.0) / self.weight
    }
}

/// Amplitudes of the ring's modes, in groups of eight. Modes behind the last one are at rest and nothing excites them.
#[derive(Debug, Clone)]
pub(crate) struct ImpulsedRing {
    count: usize,
    /// Amplitude n \[m kg^0.5\] and velocity n' of each mode.
    pub displacement: Vec<Lane>,
    pub velocity: Vec<Lane>,
    /// w^2 \[1/s2\], c \[1/s\] and 1/w^2 \[s2\] of each mode.
    squared_frequencies: Vec<Lane>,
    damping_rates: Vec<Lane>,
    flexibility: Vec<Lane>,
    /// Mean of n'- and n'+ at the last n.
    pub mean_velocity: Vec<Lane>,
    /// Displacement of each mode over the last step, before the impulses are applied.
    pub travel: Vec<Lane>,
    coefficients: ImpulseCoefficients,
    step: f64,
}

/// Coefficients of (2) and (3) for each mode.
#[derive(Debug, Clone, Default)]
struct ImpulseCoefficients {
    /// cos(w h), sin(w h)/w and w sin(w h).
    cos: Vec<Lane>,
    sin_over_w: Vec<Lane>,
    w_sin: Vec<Lane>,
    /// k and b of (2).
    retained: Vec<Lane>,
    gain: Vec<Lane>,
}

/// Propagator of a step of free motion: the entries of exp(B h) of each mode, by rows.
#[derive(Debug, Clone)]
pub(crate) struct RingPropagator([Vec<Lane>; 4]);

impl ImpulsedRing {
    /// Creates a ring at rest with these modes (w^2 > 0, c) and `h` \[s\] between impulses.
    pub fn new(modes: &[(f64, f64)], h: f64) -> Self {
        let count = modes.len();
        let padding = count.next_multiple_of(LANES) - count;
        let modes: Vec<(f64, f64)> = modes.iter().copied().chain(std::iter::repeat_n((1.0, 0.0), padding)).collect();
        let list = |of: &dyn Fn(f64, f64) -> f64| -> Vec<Lane> {
            lanes_of(&modes.iter().map(|&(square, damping)| of(square, damping)).collect::<Vec<f64>>())
        };
        let gain = |c: f64| 1.0 / (1.0 + 0.5 * c * h);
        let coefficients = ImpulseCoefficients {
            cos: list(&|square, _| libm::cos(square.sqrt() * h)),
            sin_over_w: list(&|square, _| libm::sin(square.sqrt() * h) / square.sqrt()),
            w_sin: list(&|square, _| square.sqrt() * libm::sin(square.sqrt() * h)),
            retained: list(&|_, c| (1.0 - 0.5 * c * h) * gain(c)),
            gain: list(&|_, c| gain(c)),
        };
        let zeros = vec![Lane::default(); coefficients.cos.len()];
        Self {
            count,
            displacement: zeros.clone(),
            velocity: zeros.clone(),
            squared_frequencies: list(&|square, _| square),
            damping_rates: list(&|_, c| c),
            flexibility: list(&|square, _| 1.0 / square),
            mean_velocity: zeros.clone(),
            travel: zeros,
            coefficients,
            step: h,
        }
    }

    /// Sets the motion at n, before the impulse there, that a train of these modal impulses J sustains: (4), n'- = -J/2.
    pub fn sustain(&mut self, impulses: &[Lane]) {
        let ImpulseCoefficients { cos, w_sin, .. } = &self.coefficients;
        for (i, impulse) in impulses.iter().enumerate() {
            // (1/2w) cot(wh/2) = (1 + cos wh)/(2 w sin wh)
            let displacement = |k: usize| 0.5 * impulse.0[k] * (1.0 + cos[i].0[k]) / w_sin[i].0[k];
            self.displacement[i] = Lane(std::array::from_fn(displacement));
            self.velocity[i] = Lane(impulse.0.map(|impulse| -0.5 * impulse));
        }
    }

    /// Amplitudes of the modes.
    pub fn amplitudes(&self) -> &[f64] {
        &flat(&self.displacement)[..self.count]
    }

    /// Writes bounds of the amplitudes of the modes from now on without impulses.
    pub fn free_amplitudes(&self, amplitudes: &mut Vec<f64>) {
        amplitudes.clear();
        let states = flat(&self.displacement).iter().zip(flat(&self.velocity)).zip(flat(&self.flexibility));
        amplitudes.extend(
            states
                .take(self.count)
                .map(|((n, velocity), flexibility)| (n * n + velocity * velocity * flexibility).sqrt()),
        );
    }

    /// Takes the modes from n to n+1 without impulses at n, but with the damping of (2).
    #[inline(always)]
    pub fn propagate_free<V: Eight>(&mut self) {
        let Self { displacement, velocity, mean_velocity, travel, coefficients, .. } = self;
        let states = displacement.iter_mut().zip(velocity).zip(mean_velocity).zip(travel);
        let tables =
            coefficients.cos.iter().zip(&coefficients.sin_over_w).zip(&coefficients.w_sin).zip(&coefficients.retained);
        for ((((displacement, velocity), mean), travel), (((cos, sin_over_w), w_sin), retained)) in states.zip(tables) {
            let (from, before, cos) = (V::load(displacement), V::load(velocity), V::load(cos));
            let after = V::load(retained) * before;
            let to = cos * from + V::load(sin_over_w) * after;
            (V::all(0.5) * (before + after)).store(mean);
            (cos * after - V::load(w_sin) * from).store(velocity);
            to.store(displacement);
            (to - from).store(travel);
        }
    }

    /// Adds the response at n+1 to modal impulses J at n.
    #[inline(always)]
    pub fn apply_impulses<V: Eight>(&mut self, impulses: &[Lane]) {
        let Self { displacement, velocity, mean_velocity, coefficients, .. } = self;
        let states = displacement.iter_mut().zip(velocity).zip(mean_velocity);
        let tables = coefficients.cos.iter().zip(&coefficients.sin_over_w).zip(&coefficients.gain);
        for ((((displacement, velocity), mean), ((cos, sin_over_w), gain)), impulse) in states.zip(tables).zip(impulses)
        {
            let gained = V::load(gain) * V::load(impulse);
            (V::load(mean) + V::all(0.5) * gained).store(mean);
            (V::load(displacement) + V::load(sin_over_w) * gained).store(displacement);
            (V::load(velocity) + V::load(cos) * gained).store(velocity);
        }
    }

    /// Energy that the damping of (2) takes at n \[J\].
    pub fn step_dissipation(&self) -> f64 {
        self.step * weighted_squares(&self.damping_rates, &self.mean_velocity)
    }

    /// Kinetic and strain energy \[J\].
    pub fn energies(&self) -> [f64; 2] {
        energies(&self.squared_frequencies, &self.displacement, &self.velocity).map(|energy| 0.5 * energy)
    }

    /// Propagator of a step of free motion of `h` \[s\].
    pub fn propagator(&self, h: f64) -> RingPropagator {
        let modes = flat(&self.squared_frequencies).iter().zip(flat(&self.damping_rates));
        let all: Vec<[f64; 4]> =
            modes.map(|(square, damping)| SplitBlock::of(&[0.0, 1.0, -square, -damping]).exponential(h)).collect();
        RingPropagator(std::array::from_fn(|i| lanes_of(&all.iter().map(|block| block[i]).collect::<Vec<f64>>())))
    }

    /// Takes the modes over a step of free motion.
    pub fn propagate(&mut self, step: &RingPropagator) {
        propagate_modes(&step.0, &mut self.displacement, &mut self.velocity);
    }

    /// Compliance of each mode over a contact step \[s\]: displacement at n+1 by a unit impulse at n, static correction included;
    /// and the static correction alone.
    pub fn compliance(&self) -> [Vec<Lane>; 2] {
        let ImpulseCoefficients { cos, sin_over_w, w_sin, gain, .. } = &self.coefficients;
        let correction = |i: usize, k: usize| {
            // (1/2w) cot(wh/2) = (1 + cos wh)/(2 w sin wh)
            1.0 / (self.squared_frequencies[i].0[k] * self.step) - 0.5 * (1.0 + cos[i].0[k]) / w_sin[i].0[k]
        };
        let lane = |i: usize, of: &dyn Fn(usize, usize) -> f64| Lane(std::array::from_fn(|k| of(i, k)));
        let list = |of: &dyn Fn(usize, usize) -> f64| (0..cos.len()).map(|i| lane(i, of)).collect();
        [list(&|i, k| sin_over_w[i].0[k] * gain[i].0[k] + correction(i, k)), list(&correction)]
    }

    /// Displacement bound of the ring from now on without impulses \[m\]; `of_modes`: largest displacement per amplitude of
    /// each mode.
    pub fn reach(&self, of_modes: &[Lane]) -> f64 {
        reach(of_modes, &self.displacement, &self.velocity, &self.flexibility)
    }
}

by_width! { fn propagate_modes(free: &[Vec<Lane>; 4], displacement: &mut [Lane], velocity: &mut [Lane]) = propagate_modes_kernel }

#[inline(always)]
fn propagate_modes_kernel<V: Eight>(
    [aa, ab, ba, bb]: &[Vec<Lane>; 4],
    displacement: &mut [Lane],
    velocity: &mut [Lane],
) {
    let tables = aa.iter().zip(ab).zip(ba.iter().zip(bb));
    for ((displacement, velocity), ((aa, ab), (ba, bb))) in displacement.iter_mut().zip(velocity).zip(tables) {
        let (n, before) = (V::load(displacement), V::load(velocity));
        (V::load(aa) * n + V::load(ab) * before).store(displacement);
        (V::load(ba) * n + V::load(bb) * before).store(velocity);
    }
}

by_width! {
    /// `sum_j a_j x_j^2`.
    fn weighted_squares(a: &[Lane], x: &[Lane]) -> f64 = weighted_squares_kernel
}

#[inline(always)]
fn weighted_squares_kernel<V: Eight>(a: &[Lane], x: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for (a, x) in a.iter().zip(x) {
        let x = V::load(x);
        sums = sums + V::load(a) * x * x;
    }
    sums.sum()
}

by_width! {
    /// `sum_j n'_j^2` and `sum_j w_j^2 n_j^2`.
    fn energies(squared_frequencies: &[Lane], displacement: &[Lane], velocity: &[Lane]) -> [f64; 2] = energies_kernel
}

#[inline(always)]
fn energies_kernel<V: Eight>(squared_frequencies: &[Lane], displacement: &[Lane], velocity: &[Lane]) -> [f64; 2] {
    let mut sums = [V::all(0.0); 2];
    for ((square, n), velocity) in squared_frequencies.iter().zip(displacement).zip(velocity) {
        let (n, velocity) = (V::load(n), V::load(velocity));
        sums[0] = sums[0] + velocity * velocity;
        sums[1] = sums[1] + V::load(square) * n * n;
    }
    sums.map(V::sum)
}

by_width! {
    /// `sum_j reach_j sqrt(n_j^2 + n'_j^2/w_j^2)`.
    fn reach(of_modes: &[Lane], displacement: &[Lane], velocity: &[Lane], flexibility: &[Lane]) -> f64 = reach_kernel
}

#[inline(always)]
fn reach_kernel<V: Eight>(of_modes: &[Lane], displacement: &[Lane], velocity: &[Lane], flexibility: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for ((reach, n), (velocity, flexibility)) in of_modes.iter().zip(displacement).zip(velocity.iter().zip(flexibility))
    {
        let (n, velocity) = (V::load(n), V::load(velocity));
        sums = sums + V::load(reach) * (n * n + velocity * velocity * V::load(flexibility)).root();
    }
    sums.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eight::Plain;

    #[test]
    fn a_steady_train_of_impulses_makes_the_static_displacement() {
        let (square, damping, h) = (9e6_f64, 200.0, 1e-4);
        let mut ring = ImpulsedRing::new(&[(square, damping)], h);
        let force = 5.0;
        let mut impulses = [Lane::default()];
        impulses[0].0[0] = force * h;
        for _ in 0..4000 {
            ring.propagate_free::<Plain>();
            ring.apply_impulses::<Plain>(&impulses);
        }
        let reached = [ring.displacement[0].0[0], ring.velocity[0].0[0]];
        ring.sustain(&impulses);
        let sustained = [ring.displacement[0].0[0], ring.velocity[0].0[0]];
        ring.propagate_free::<Plain>();
        ring.apply_impulses::<Plain>(&impulses);
        for (part, scale) in [(0, force / square), (1, force * h)] {
            let after = [&ring.displacement, &ring.velocity][part][0].0[0];
            assert!((reached[part] - sustained[part]).abs() < 1e-10 * scale, "{reached:?} {sustained:?}");
            assert!((after - sustained[part]).abs() < 1e-14 * scale, "{after} {sustained:?}");
        }
        let whole = reached[0] + ring.compliance()[1][0].0[0] * force * h;
        assert!((whole * square / force - 1.0).abs() < 1e-10, "{whole}");
        // as large a correction as the mode's own displacement needs at this step: w h = 0.3
        assert!((reached[0] * square / force - 1.0).abs() > 5e-3);
    }

    #[test]
    fn no_free_mode_exceeds_its_amplitude() {
        let h = 1e-4;
        // undamped, damped, nearly critical and overdamped, from slow to as fast as a contact step resolves
        let modes: Vec<(f64, f64)> = (1..=12)
            .map(|j| {
                let w = 1500.0 * f64::from(j);
                (w * w, [0.0, 0.01, 0.9, 3.0][j as usize % 4] * 2.0 * w)
            })
            .collect();
        let mut ring = ImpulsedRing::new(&modes, h);
        for (j, &(square, _)) in modes.iter().enumerate() {
            let phase = 0.7 * j as f64;
            (ring.displacement[j / LANES].0[j % LANES], ring.velocity[j / LANES].0[j % LANES]) =
                (phase.cos(), square.sqrt() * phase.sin());
        }
        let (mut amplitudes, mut largest_ratio) = (Vec::new(), 0.0_f64);
        ring.free_amplitudes(&mut amplitudes);
        let propagators = [ring.propagator(h), ring.propagator(16.0 * h)];
        for step in 0..30_000 {
            match step % 3 {
                0 => ring.propagate_free::<Plain>(),
                kind => ring.propagate(&propagators[kind - 1]),
            }
            for (n, amplitude) in ring.amplitudes().iter().zip(&amplitudes) {
                assert!(n.abs() <= amplitude * (1.0 + 1e-9), "step {step}: {n} {amplitude}");
                largest_ratio = largest_ratio.max(n.abs() / amplitude);
            }
        }
        assert!(largest_ratio > 0.999_999, "undamped modes reach their amplitude: {largest_ratio}");
    }

    #[test]
    fn between_impulses_a_mode_decays_as_it_should() {
        let (square, damping, h) = (9e6_f64, 200.0, 1e-5);
        let mut ring = ImpulsedRing::new(&[(square, damping)], h);
        ring.displacement[0].0[0] = 1.0;
        for _ in 0..1000 {
            ring.propagate_free::<Plain>();
        }
        let exact = (-0.5 * damping * 1e-2_f64).exp();
        let mut reach = [Lane::default()];
        reach[0].0[0] = 1.0;
        assert!((ring.reach(&reach) / exact - 1.0).abs() < 0.02, "{} {exact}", ring.reach(&reach));
    }
}
