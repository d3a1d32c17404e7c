//! A ring's modes under impulses at equal times.
//!
//! ```text
//! at n      n'+ = k n'- + b J,   b = 1/(1 + ch/2),  k = (1 - ch/2) b         damping on the mean of n'- and n'+            (1)
//! between   n, n' turn by wh                                                  exact
//! steady    J = F h:  n = F (h/2w) cot(wh/2) at n, whatever c; a constant force F makes F/w^2                             (2)
//! flight    n, n' by exp(B h), B = [[0, 1], [-w^2, -c]]                       exact for any step (`block`)
//! ```
//! The velocity between impulses is a saw-tooth: damping that acted on it would take 44 kJ of a turbine's rub at 50 us, (1) takes none of a steady
//! train. The difference of (2) to the true static displacement is what a train of impulses at n lacks; it goes with the force, like the modes left
//! out ([`KickedRing::yields`]), so that statics are exact at any step.
//! Source: the theory page of this engine. Verified by `a_steady_train_of_impulses_makes_the_static_displacement`.

use crate::engine::exponential::modal::plane_block::SplitBlock;
use crate::linalg::eight::{Eight, by_width};
use crate::linalg::lanes::{LANES, Lane, flat, lanes_of};

/// How often the statics at n+1 have what a train lacks of the impulse at n; they have that of the one before once less, so that they are those of the force at n+1
/// ([`super::foreseen`]).
pub(crate) const AHEAD: f64 = 2.0;

/// How the truncated modes of a ring follow a train of impulses.
///
/// ```text
/// x + b x' = R F,   C = a M + b K of the ring       first order in the time scale of a truncated mode; R: their static flexibility
/// x(n+1) = R (s J_n - (s - 1) J_(n-1))/h            s = 2 - b/h, b at most h: the force of the time t(n+1) - b, linear in time
/// ```
/// A mode of frequency w and damping b w^2 follows a slow force with the lag b. Without this lag (s = 2) truncated modes are undamped, and friction drives the kept modes through them:
/// a ring with 24 stiff blades then flutters as soon as the contact step is too small to damp it. Source: the first two terms of 1/(w^2 + i W c - W^2) in W, c = b w^2.
/// At the default contact step the step itself damps them: there b does not count, at half of it and below it counts whole.
/// Limit: a lag above h is more than the last two impulses can show; there the truncated modes are undamped. Damping in proportion to the mass (a) has a lag of a/w^2, which is neglected.
/// Verified by `tests/exponential_fine_steps.rs`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StaticCorrection {
    /// Contact step \[s\].
    h: f64,
    /// s.
    ahead: f64,
}

impl StaticCorrection {
    /// Impulses at intervals of `h` \[s\], and the stiffness-proportional damping b \[s\].
    pub fn new(h: f64, lag: f64) -> Self {
        let shown = if lag > h { 0.0 } else { lag };
        Self { h, ahead: AHEAD - shown / h }
    }

    /// Force at n+1 per impulse at n: s/h \[1/s\].
    pub fn gain(self) -> f64 {
        self.ahead / self.h
    }

    /// Share of the preceding impulses that is subtracted: (s - 1)/s.
    #[inline(always)]
    pub fn before(self) -> f64 {
        (self.ahead - 1.0) / self.ahead
    }
}

/// Modes under way, by eights: those behind the last one are modes at rest that nothing moves.
#[derive(Debug, Clone)]
pub(crate) struct ImpulsedRing {
    count: usize,
    pub place: Vec<Lane>,
    pub rate: Vec<Lane>,
    /// w^2 and c of each, and 1/w^2.
    squares: Vec<Lane>,
    dampings: Vec<Lane>,
    flexibility: Vec<Lane>,
    /// Mean of n'- and n'+ at the last n.
    pub mean_rate: Vec<Lane>,
    /// From n to n+1 without impulse.
    pub way: Vec<Lane>,
    coefficients: ImpulseCoefficients,
    step: f64,
}

/// Of each mode.
#[derive(Debug, Clone, Default)]
struct ImpulseCoefficients {
    cos: Vec<Lane>,
    /// sin(wh)/w and w sin(wh).
    over: Vec<Lane>,
    times: Vec<Lane>,
    kept: Vec<Lane>,
    gain: Vec<Lane>,
}

/// What a step of free flight makes of the modes: the entries of exp(B h).
#[derive(Debug, Clone)]
pub(crate) struct RingPropagator([Vec<Lane>; 4]);

impl ImpulsedRing {
    /// At rest; w^2 > 0 and c of each mode, and the time between impulses.
    pub fn new(modes: &[(f64, f64)], h: f64) -> Self {
        let count = modes.len();
        let behind = count.next_multiple_of(LANES) - count;
        let modes: Vec<(f64, f64)> = modes.iter().copied().chain(std::iter::repeat_n((1.0, 0.0), behind)).collect();
        let list = |of: &dyn Fn(f64, f64) -> f64| -> Vec<Lane> {
            lanes_of(&modes.iter().map(|&(square, damping)| of(square, damping)).collect::<Vec<f64>>())
        };
        let gain = |c: f64| 1.0 / (1.0 + 0.5 * c * h);
        let kicked = ImpulseCoefficients {
            cos: list(&|square, _| libm::cos(square.sqrt() * h)),
            over: list(&|square, _| libm::sin(square.sqrt() * h) / square.sqrt()),
            times: list(&|square, _| square.sqrt() * libm::sin(square.sqrt() * h)),
            kept: list(&|_, c| (1.0 - 0.5 * c * h) * gain(c)),
            gain: list(&|_, c| gain(c)),
        };
        let zeros = vec![Lane::default(); kicked.cos.len()];
        Self {
            count,
            place: zeros.clone(),
            rate: zeros.clone(),
            squares: list(&|square, _| square),
            dampings: list(&|_, c| c),
            flexibility: list(&|square, _| 1.0 / square),
            mean_rate: zeros.clone(),
            way: zeros,
            coefficients: kicked,
            step: h,
        }
    }

    /// Amplitudes of the modes.
    pub fn amplitudes(&self) -> &[f64] {
        &flat(&self.place)[..self.count]
    }

    /// Amplitudes that the modes have at most from now on without impulses.
    pub fn free_amplitudes(&self, amplitudes: &mut Vec<f64>) {
        amplitudes.clear();
        let states = flat(&self.place).iter().zip(flat(&self.rate)).zip(flat(&self.flexibility));
        amplitudes.extend(states.take(self.count).map(|((n, rate), soft)| (n * n + rate * rate * soft).sqrt()));
    }

    /// Goes from n to n+1 without impulse, but with the damping of (1).
    #[inline(always)]
    pub fn propagate_free<V: Eight>(&mut self) {
        let Self { place, rate, mean_rate, way, coefficients: kicked, .. } = self;
        let states = place.iter_mut().zip(rate).zip(mean_rate).zip(way);
        let tables = kicked.cos.iter().zip(&kicked.over).zip(&kicked.times).zip(&kicked.kept);
        for ((((place, rate), mean), way), (((cos, over), times), kept)) in states.zip(tables) {
            let (from, before, cos) = (V::load(place), V::load(rate), V::load(cos));
            let after = V::load(kept) * before;
            let to = cos * from + V::load(over) * after;
            (V::all(0.5) * (before + after)).store(mean);
            (cos * after - V::load(times) * from).store(rate);
            to.store(place);
            (to - from).store(way);
        }
    }

    /// Adds at n+1 what impulses J at n have made.
    #[inline(always)]
    pub fn apply_impulses<V: Eight>(&mut self, impulses: &[Lane]) {
        let Self { place, rate, mean_rate, coefficients: kicked, .. } = self;
        let states = place.iter_mut().zip(rate).zip(mean_rate);
        let tables = kicked.cos.iter().zip(&kicked.over).zip(&kicked.gain);
        for ((((place, rate), mean), ((cos, over), gain)), impulse) in states.zip(tables).zip(impulses) {
            let gained = V::load(gain) * V::load(impulse);
            (V::load(mean) + V::all(0.5) * gained).store(mean);
            (V::load(place) + V::load(over) * gained).store(place);
            (V::load(rate) + V::load(cos) * gained).store(rate);
        }
    }

    /// What (1) has taken at n \[J\].
    pub fn step_dissipation(&self) -> f64 {
        self.step * squared(&self.dampings, &self.mean_rate)
    }

    /// Kinetic and strain energy \[J\].
    pub fn energies(&self) -> [f64; 2] {
        energies(&self.squares, &self.place, &self.rate).map(|energy| 0.5 * energy)
    }

    /// The step of free flight of `h` \[s\].
    pub fn propagator(&self, h: f64) -> RingPropagator {
        let modes = flat(&self.squares).iter().zip(flat(&self.dampings));
        let all: Vec<[f64; 4]> =
            modes.map(|(square, damping)| SplitBlock::of(&[0.0, 1.0, -square, -damping]).exponential(h)).collect();
        RingPropagator(std::array::from_fn(|i| lanes_of(&all.iter().map(|block| block[i]).collect::<Vec<f64>>())))
    }

    /// Goes a step of free flight.
    pub fn propagate(&mut self, step: &RingPropagator) {
        fly(&step.0, &mut self.place, &mut self.rate);
    }

    /// Displacement at n+1 by a unit impulse at n, with what (2) lacks; and the latter.
    pub fn compliance(&self) -> [Vec<Lane>; 2] {
        let ImpulseCoefficients { cos, over, times, gain, .. } = &self.coefficients;
        let lacks = |i: usize, k: usize| {
            // (1/2w) cot(wh/2) = (1 + cos wh)/(2 w sin wh)
            1.0 / (self.squares[i].0[k] * self.step) - 0.5 * (1.0 + cos[i].0[k]) / times[i].0[k]
        };
        let lane = |i: usize, of: &dyn Fn(usize, usize) -> f64| Lane(std::array::from_fn(|k| of(i, k)));
        let list = |of: &dyn Fn(usize, usize) -> f64| (0..cos.len()).map(|i| lane(i, of)).collect();
        [list(&|i, k| over[i].0[k] * gain[i].0[k] + lacks(i, k)), list(&lacks)]
    }

    /// Bound of a displacement from now on without impulses, of the largest that each mode makes per amplitude \[m\].
    pub fn reach(&self, of_modes: &[Lane]) -> f64 {
        reach(of_modes, &self.place, &self.rate, &self.flexibility)
    }
}

by_width! { fn fly(free: &[Vec<Lane>; 4], place: &mut [Lane], rate: &mut [Lane]) = propagated }

#[inline(always)]
fn propagated<V: Eight>([aa, ab, ba, bb]: &[Vec<Lane>; 4], place: &mut [Lane], rate: &mut [Lane]) {
    let tables = aa.iter().zip(ab).zip(ba.iter().zip(bb));
    for ((place, rate), ((aa, ab), (ba, bb))) in place.iter_mut().zip(rate).zip(tables) {
        let (n, before) = (V::load(place), V::load(rate));
        (V::load(aa) * n + V::load(ab) * before).store(place);
        (V::load(ba) * n + V::load(bb) * before).store(rate);
    }
}

by_width! {
    /// `sum_j a_j x_j^2`.
    fn squared(a: &[Lane], x: &[Lane]) -> f64 = squared_in
}

#[inline(always)]
fn squared_in<V: Eight>(a: &[Lane], x: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for (a, x) in a.iter().zip(x) {
        let x = V::load(x);
        sums = sums + V::load(a) * x * x;
    }
    sums.sum()
}

by_width! {
    /// `sum_j n'_j^2` and `sum_j w_j^2 n_j^2`.
    fn energies(squares: &[Lane], place: &[Lane], rate: &[Lane]) -> [f64; 2] = energies_in
}

#[inline(always)]
fn energies_in<V: Eight>(squares: &[Lane], place: &[Lane], rate: &[Lane]) -> [f64; 2] {
    let mut sums = [V::all(0.0); 2];
    for ((square, n), rate) in squares.iter().zip(place).zip(rate) {
        let (n, rate) = (V::load(n), V::load(rate));
        sums[0] = sums[0] + rate * rate;
        sums[1] = sums[1] + V::load(square) * n * n;
    }
    sums.map(V::sum)
}

by_width! {
    /// `sum_j reach_j sqrt(n_j^2 + n'_j^2/w_j^2)`.
    fn reach(of_modes: &[Lane], place: &[Lane], rate: &[Lane], soft: &[Lane]) -> f64 = reach_in
}

#[inline(always)]
fn reach_in<V: Eight>(of_modes: &[Lane], place: &[Lane], rate: &[Lane], soft: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for ((reach, n), (rate, soft)) in of_modes.iter().zip(place).zip(rate.iter().zip(soft)) {
        let (n, rate) = (V::load(n), V::load(rate));
        sums = sums + V::load(reach) * (n * n + rate * rate * V::load(soft)).root();
    }
    sums.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::eight::Plain;

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
        let whole = ring.place[0].0[0] + ring.compliance()[1][0].0[0] * force * h;
        assert!((whole * square / force - 1.0).abs() < 1e-10, "{whole}");
        // as large a correction as the mode's own displacement needs at this step: w h = 0.3
        assert!((ring.place[0].0[0] * square / force - 1.0).abs() > 5e-3);
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
            (ring.place[j / LANES].0[j % LANES], ring.rate[j / LANES].0[j % LANES]) =
                (phase.cos(), square.sqrt() * phase.sin());
        }
        let (mut amplitudes, mut closest) = (Vec::new(), 0.0_f64);
        ring.free_amplitudes(&mut amplitudes);
        let flights = [ring.propagator(h), ring.propagator(16.0 * h)];
        for step in 0..30_000 {
            match step % 3 {
                0 => ring.propagate_free::<Plain>(),
                kind => ring.propagate(&flights[kind - 1]),
            }
            for (n, most) in ring.amplitudes().iter().zip(&amplitudes) {
                assert!(n.abs() <= most * (1.0 + 1e-9), "step {step}: {n} {most}");
                closest = closest.max(n.abs() / most);
            }
        }
        assert!(closest > 0.999_999, "undamped modes reach it: {closest}");
    }

    #[test]
    fn between_impulses_a_mode_decays_as_it_should() {
        let (square, damping, h) = (9e6_f64, 200.0, 1e-5);
        let mut ring = ImpulsedRing::new(&[(square, damping)], h);
        ring.place[0].0[0] = 1.0;
        for _ in 0..1000 {
            ring.propagate_free::<Plain>();
        }
        let exact = (-0.5 * damping * 1e-2_f64).exp();
        let mut reach = [Lane::default()];
        reach[0].0[0] = 1.0;
        assert!((ring.reach(&reach) / exact - 1.0).abs() < 0.02, "{} {exact}", ring.reach(&reach));
    }
}
