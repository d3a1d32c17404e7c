//! What damping has taken of a run: up to the last look, and up to an instant that is shown since.
//!
//! ```text
//! bearings    trapezoidal rule for the powers of their mean rates at looks                                                  (1)
//! the rest    trapezoidal rule for what all damping takes less (1), at the looks that ask for all, and what that of the twist has taken
//! ```
//! All of a contact step is the mean of the step behind the look ([`super::within`]): half a step later than a power at it.
//! Verified by the balances of `tests/exponential_run.rs`, `energies_of_shown_instants_balance` (there).

use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::record::Energies;

/// Up to the last looks.
pub(crate) struct DissipatedEnergy {
    /// Contact step \[s\].
    h: f64,
    /// The last look: its time in contact steps, and the powers that bearings' damping takes and that their skew stiffness puts in then \[W\].
    looked: Option<(u64, [f64; 2])>,
    /// The last look at what all damping takes.
    lost: Option<LastRate>,
}

struct LastRate {
    ticks: u64,
    taken: DampingPowers,
    /// Power of all without that of the bearings' mean rates \[W\].
    rest: f64,
}

/// What damping takes at an instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DampingPowers {
    /// Powers of the bearings' mean rates: what their damping takes, and what their skew stiffness puts in \[W\].
    pub bearings: [f64; 2],
    /// Power of all \[W\], the mean of a step whose middle is so many steps behind the instant, or with 0 the power at it.
    pub whole: f64,
    pub behind: f64,
    /// What the twist's damping had taken \[J\].
    pub damped: f64,
}

impl DampingPowers {
    /// Where a flight is; `room` for the bearings' motion.
    pub fn in_free_motion(flight: &mut FreeMotion, room: &mut Vec<f64>) -> Self {
        let (bearings, whole) = flight.damping_powers(true, room);
        Self { bearings, whole, behind: 0.0, damped: flight.spin().torsional_dissipation() }
    }

    fn without_bearings(&self) -> f64 {
        self.whole - (self.bearings[0] - self.bearings[1])
    }
}

impl DissipatedEnergy {
    /// Before the first look, in contact steps of `h` \[s\].
    pub fn new(h: f64) -> Self {
        Self { h, looked: None, lost: None }
    }

    /// Time of the last look in contact steps, and of that at what all damping takes.
    pub fn times(&self) -> [Option<u64>; 2] {
        [self.looked.map(|(ticks, _)| ticks), self.lost.as_ref().map(|lost| lost.ticks)]
    }

    fn half_since(&self, last: u64, ticks: u64) -> f64 {
        0.5 * (ticks - last) as f64 * self.h
    }

    /// A look at the bearings.
    pub fn add_bearing_losses(&mut self, ticks: u64, taken: &DampingPowers, works: &mut Energies) {
        self.add_bearings(ticks, taken, works);
        self.looked = Some((ticks, taken.bearings));
    }

    /// A look at all, after that at the bearings.
    pub fn add_losses(&mut self, ticks: u64, taken: DampingPowers, works: &mut Energies) {
        self.add_rest(ticks, &taken, works);
        self.lost = Some(LastRate { ticks, taken, rest: taken.without_bearings() });
    }

    /// These works with what damping has taken up to an instant.
    pub fn until(&self, ticks: u64, taken: &DampingPowers, mut works: Energies) -> Energies {
        self.add_bearings(ticks, taken, &mut works);
        self.add_rest(ticks, taken, &mut works);
        works
    }

    fn add_bearings(&self, ticks: u64, taken: &DampingPowers, works: &mut Energies) {
        if let Some((last, before)) = self.looked {
            let half = self.half_since(last, ticks);
            works.bearings += half * (before[0] + taken.bearings[0]);
            works.skew += half * (before[1] + taken.bearings[1]);
        }
    }

    fn add_rest(&self, ticks: u64, taken: &DampingPowers, works: &mut Energies) {
        if let Some(LastRate { ticks: last, taken: before, rest }) = &self.lost {
            works.structure +=
                self.half_since(*last, ticks) * (rest + taken.without_bearings()) + (taken.damped - before.damped);
            // means of steps behind are those of later instants
            works.structure -= 0.5 * self.h * (before.behind + taken.behind) * (taken.whole - before.whole);
        }
    }
}
