//! What damping has taken of a run: up to the last look, and up to an instant that is shown since.
//!
//! ```text
//! bearings    trapezoidal rule for the powers of their mean rates at looks                                                  (1)
//! the rest    trapezoidal rule for what all damping takes less (1), at the looks that ask for all, and what that of the twist has taken
//! ```
//! All of a contact step is the mean of the step behind the look ([`super::within`]): half a step later than a power at it.
//! Verified by the balances of `tests/exponential_run.rs`, `energies_of_shown_instants_balance` (there).

use super::flight::Flight;
use crate::record::Energies;

/// Up to the last looks.
pub(super) struct Losses {
    /// Contact step \[s\].
    h: f64,
    /// The last look: its time in contact steps, and the powers that bearings' damping takes and that their skew stiffness puts in then \[W\].
    looked: Option<(u64, [f64; 2])>,
    /// The last look at what all damping takes.
    lost: Option<Lost>,
}

struct Lost {
    ticks: u64,
    taken: Taken,
    /// Power of all without that of the bearings' mean rates \[W\].
    rest: f64,
}

/// What damping takes at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    /// Powers of the bearings' mean rates: what their damping takes, and what their skew stiffness puts in \[W\].
    pub bearings: [f64; 2],
    /// Power of all \[W\], the mean of a step whose middle is so many steps behind the instant, or with 0 the power at it.
    pub whole: f64,
    pub behind: f64,
    /// What the twist's damping had taken \[J\].
    pub damped: f64,
}

impl Taken {
    /// Where a flight is; `room` for the bearings' motion.
    pub fn in_flight(flight: &mut Flight, room: &mut Vec<f64>) -> Self {
        let (bearings, whole) = flight.powers(true, room);
        Self { bearings, whole, behind: 0.0, damped: flight.spin().damped() }
    }

    fn rest(&self) -> f64 {
        self.whole - (self.bearings[0] - self.bearings[1])
    }
}

impl Losses {
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
    pub fn look(&mut self, ticks: u64, taken: &Taken, works: &mut Energies) {
        self.add_bearings(ticks, taken, works);
        self.looked = Some((ticks, taken.bearings));
    }

    /// A look at all, after that at the bearings.
    pub fn lose(&mut self, ticks: u64, taken: Taken, works: &mut Energies) {
        self.add_rest(ticks, &taken, works);
        self.lost = Some(Lost { ticks, taken, rest: taken.rest() });
    }

    /// These works with what damping has taken up to an instant.
    pub fn until(&self, ticks: u64, taken: &Taken, mut works: Energies) -> Energies {
        self.add_bearings(ticks, taken, &mut works);
        self.add_rest(ticks, taken, &mut works);
        works
    }

    fn add_bearings(&self, ticks: u64, taken: &Taken, works: &mut Energies) {
        if let Some((last, before)) = self.looked {
            let half = self.half_since(last, ticks);
            works.bearings += half * (before[0] + taken.bearings[0]);
            works.skew += half * (before[1] + taken.bearings[1]);
        }
    }

    fn add_rest(&self, ticks: u64, taken: &Taken, works: &mut Energies) {
        if let Some(Lost { ticks: last, taken: before, rest }) = &self.lost {
            works.structure += self.half_since(*last, ticks) * (rest + taken.rest()) + (taken.damped - before.damped);
            // means of steps behind are those of later instants
            works.structure -= 0.5 * self.h * (before.behind + taken.behind) * (taken.whole - before.whole);
        }
    }
}
