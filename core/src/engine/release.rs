//! Instants at which unbalances are released during a run.
//!
//! | release | instant |
//! |---|---|
//! | at a time | that time |
//! | at a speed | first time at which the mean spin is at that speed, rising or falling: linear between two steps, which is of second order |
//!
//! The run changes its matrices at the first instant of a step at or after a release (`shaft_line/piece.rs`). Several releases in one step are sorted
//! by time, then by name. Verified by `core/tests/runs/releases.rs`.

use crate::record::At;
use crate::rotor::UnbalanceSite;
use bladeoff_model::machine::{Machine, Release};

/// Pending releases of a run.
#[derive(Debug, Clone)]
pub(super) struct Releases<'a> {
    /// Machine with all its unbalances.
    machine: &'a Machine,
    /// Indices of the pending unbalances in the machine's list.
    awaited: Vec<usize>,
    /// Previous instant of a step: time \[s\] and mean spin \[rad/s\].
    last: At,
}

/// A release that has happened by an instant of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Due {
    /// Index of the unbalance in the machine's list.
    pub unbalance: usize,
    /// Time and mean spin at the release.
    pub at: At,
}

impl<'a> Releases<'a> {
    /// Releases of a run from t = 0.
    pub fn new(machine: &'a Machine) -> Self {
        let speed = machine.rotor.initial_speed;
        let unbalances = machine.rotor.unbalances.iter().enumerate();
        let awaited = unbalances.filter(|(_, unbalance)| unbalance.is_awaited(speed)).map(|(place, _)| place);
        Self { machine, awaited: awaited.collect(), last: At { time: 0.0, speed } }
    }

    /// Whether no release is pending.
    pub fn is_over(&self) -> bool {
        self.awaited.is_empty()
    }

    /// The machine without its pending unbalances.
    pub fn present(&self) -> Machine {
        let mut present = self.machine.clone();
        let mut place = 0..;
        present.rotor.unbalances.retain(|_| place.next().is_none_or(|place| !self.awaited.contains(&place)));
        present
    }

    /// Speeds of the pending releases at a speed \[rad/s\].
    pub fn speeds(&self) -> impl Iterator<Item = f64> {
        self.awaited.iter().filter_map(|&place| match self.machine.rotor.unbalances[place].release {
            Some(Release::Speed(speed)) => Some(speed),
            _ => None,
        })
    }

    /// First release, by time and then by name, that has happened by an instant of a step.
    pub fn due(&self, now: At) -> Option<Due> {
        let At { time: from, speed: before } = self.last;
        let happened = |&unbalance: &usize| {
            let share = match self.machine.rotor.unbalances[unbalance].release? {
                Release::Time(time) => {
                    if !is_reached(time, now.time) {
                        return None;
                    }
                    if now.time > from { ((time - from) / (now.time - from)).clamp(0.0, 1.0) } else { 1.0 }
                }
                Release::Speed(speed) => {
                    let [start, end] = [before - speed, now.speed - speed];
                    if start * end > 0.0 || start == end {
                        return None;
                    }
                    start / (start - end)
                }
            };
            let at = At { time: from + share * (now.time - from), speed: before + share * (now.speed - before) };
            Some(Due { unbalance, at })
        };
        let name = |due: &Due| &self.machine.rotor.unbalances[due.unbalance].name;
        let order =
            |one: &Due, other: &Due| one.at.time.total_cmp(&other.at.time).then_with(|| name(one).cmp(name(other)));
        self.awaited.iter().filter_map(happened).min_by(order)
    }

    /// Removes a release from the pending ones and returns its unbalance at its node.
    pub fn happen(&mut self, due: &Due) -> UnbalanceSite {
        self.awaited.retain(|place| *place != due.unbalance);
        UnbalanceSite::new(&self.machine.rotor.unbalances[due.unbalance])
    }

    /// Sets the previous instant of a step.
    pub fn pass(&mut self, now: At) {
        self.last = now;
    }
}

/// Whether the instant `now` of a step has reached `time` \[s\], up to rounding of the instant.
fn is_reached(time: f64, now: f64) -> bool {
    time <= now * (1.0 + 4.0 * f64::EPSILON)
}

/// Number of the first step at or after each release at a time, for steps of `h` \[s\].
pub(super) fn release_steps(machine: &Machine, h: f64) -> impl Iterator<Item = u64> {
    machine.rotor.unbalances.iter().filter_map(move |unbalance| match unbalance.release {
        Some(Release::Time(time)) if time > 0.0 => {
            let steps = libm::floor(time / h) as u64;
            Some(if is_reached(time, steps as f64 * h) { steps } else { steps + 1 })
        }
        _ => None,
    })
}
