//! Energy that damping has taken in a run, up to the last observation, or up to an instant that is shown after it.
//!
//! ```text
//! bearings    trapezoidal rule over the power of their damping, at each observation of the motion                                       (1)
//! the rest    trapezoidal rule over the power of all damping less (1), at each observation of the dissipation, and the energy taken by torsional damping
//! ```
//! In a contact step the power of all damping is the mean over the step behind n ([`crate::engine::exponential::modal::dissipation`]), which is the power half a step later.
//! Verified by the balances of `tests/exponential/exponential_run.rs`, `energies_of_shown_instants_balance` (there).

use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::record::Energies;

/// Energy that damping has taken, and the powers at the last observations.
pub(crate) struct DissipatedEnergy {
    /// Contact step \[s\].
    h: f64,
    /// Last observation of the bearings: time in contact steps, power taken by their damping, and power put in by the skew part of their stiffness \[W\].
    bearings: Option<(u64, [f64; 2])>,
    /// Last observation of all damping.
    last: Option<LastRate>,
}

struct LastRate {
    /// Time in contact steps.
    time: u64,
    powers: DampingPowers,
    /// Power of all damping but that of the bearings \[W\].
    rest: f64,
}

/// Powers of damping at an instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DampingPowers {
    /// Power taken by the bearings' damping, and power put in by the skew part of their stiffness, both of the mean velocity \[W\].
    pub bearings: [f64; 2],
    /// Power taken by all damping less the power put in \[W\].
    pub whole: f64,
    /// Time of `whole` behind the instant, in contact steps: 0.5 where it is the mean over a step.
    pub behind: f64,
    /// Energy that torsional damping had taken \[J\].
    pub damped: f64,
}

impl DampingPowers {
    /// Powers at the present instant of a free motion; `buffer` holds the motion of the bearings.
    pub fn in_free_motion(motion: &mut FreeMotion, buffer: &mut Vec<f64>) -> Self {
        let (bearings, whole) = motion.damping_powers(true, buffer);
        Self { bearings, whole, behind: 0.0, damped: motion.spin().torsional_dissipation() }
    }

    fn without_bearings(&self) -> f64 {
        self.whole - (self.bearings[0] - self.bearings[1])
    }
}

impl DissipatedEnergy {
    /// Energy 0 before the first observation, in contact steps of `h` \[s\].
    pub fn new(h: f64) -> Self {
        Self { h, bearings: None, last: None }
    }

    fn half_since(&self, last: u64, time: u64) -> f64 {
        0.5 * (time - last) as f64 * self.h
    }

    /// Adds the energy taken by the bearings since their last observation.
    pub fn add_bearing_losses(&mut self, time: u64, powers: &DampingPowers, works: &mut Energies) {
        self.add_bearings(time, powers, works);
        self.bearings = Some((time, powers.bearings));
    }

    /// Adds the energy taken by all other damping since its last observation.
    pub fn add_losses(&mut self, time: u64, powers: DampingPowers, works: &mut Energies) {
        self.add_rest(time, &powers, works);
        self.last = Some(LastRate { time, powers, rest: powers.without_bearings() });
    }

    /// These works, with the energy that damping takes up to an instant after the last observation.
    pub fn until(&self, time: u64, powers: &DampingPowers, mut works: Energies) -> Energies {
        self.add_bearings(time, powers, &mut works);
        self.add_rest(time, powers, &mut works);
        works
    }

    fn add_bearings(&self, time: u64, powers: &DampingPowers, works: &mut Energies) {
        if let Some((last, before)) = self.bearings {
            let half = self.half_since(last, time);
            works.bearings += half * (before[0] + powers.bearings[0]);
            works.skew += half * (before[1] + powers.bearings[1]);
        }
    }

    fn add_rest(&self, time: u64, powers: &DampingPowers, works: &mut Energies) {
        if let Some(LastRate { time: last, powers: before, rest }) = &self.last {
            works.structure +=
                self.half_since(*last, time) * (rest + powers.without_bearings()) + (powers.damped - before.damped);
            // a mean over a step is the power half a step later
            works.structure -= 0.5 * self.h * (before.behind + powers.behind) * (powers.whole - before.whole);
        }
    }
}
