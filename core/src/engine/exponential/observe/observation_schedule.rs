//! The instants at which a run is observed: a state machine of times alone, in contact steps.
//!
//! | observation | interval in contact steps |
//! |---|---|
//! | motion: section loads of the shaft, stresses of the ring, powers of the bearings' damping | 8 |
//! | dissipation: the power of all damping, with a motion | 8; 32 before the first contact; 2 while friction all but stops the spin; 1 after a disturbed start |
//! | balance: the stored energy, with a dissipation | 64 |
//!
//! Each step of a start has all three. A free step may cover more contact steps than an interval: the next observation is then late, never early.
//! The intervals were measured: with a longer one for the dissipation the energy error of machines whose shaft rings after impacts exceeds its guard
//! (docs/theory/08-exponential-engine.md).

/// Contact steps between two observations of the motion.
const MOTION_INTERVAL: u64 = 8;
/// Contact steps between two observations of the dissipation, from the first contact on.
const DISSIPATION_INTERVAL: u64 = 8;
/// Interval of the dissipation before the first contact: the shaft rings from the blade loss alone.
const CONTACT_FREE_INTERVAL: u64 = 32;
/// Interval of the dissipation while the spin falls fast, and up to a balance after that: in whip the power changes within eight contact steps.
const FAST_FALL_INTERVAL: u64 = 2;
/// Interval of the dissipation after a disturbed start, where all modes of the shaft ring.
const DISTURBED_INTERVAL: u64 = 1;
/// Contact steps between two balances of energy.
const BALANCE_INTERVAL: u64 = 64;

/// The state of a run at n that the schedule depends on.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RunState {
    /// Time in contact steps.
    pub contact_steps: u64,
    /// The run is in its first steps.
    pub is_starting: bool,
    /// The run began with a displacement or a velocity of the shaft.
    pub is_disturbed: bool,
    /// Friction all but stops the spin.
    pub spin_changes_fast: bool,
    /// The rotor has touched the ring.
    pub has_touched: bool,
}

/// The observations that are due at n; a balance includes a dissipation, a dissipation a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Due {
    /// Section loads, stresses, powers of the bearings' damping.
    pub motion: bool,
    /// Power of all damping.
    pub dissipation: bool,
    /// Stored energy.
    pub balance: bool,
}

impl Due {
    /// All observations, as at the end of a run.
    pub const ALL: Self = Self { motion: true, dissipation: true, balance: true };
}

/// Times of the last observations, in contact steps.
#[derive(Debug, Default)]
pub(crate) struct ObservationSchedule {
    motion: Option<u64>,
    dissipation: Option<u64>,
    balance: Option<u64>,
    /// The last step in which the spin fell fast.
    fast_fall: Option<u64>,
}

impl ObservationSchedule {
    /// The observations that are due at n, which are then made.
    pub fn due(&mut self, state: RunState) -> Due {
        let now = state.contact_steps;
        let is_due = |last: Option<u64>, interval: u64| last.is_none_or(|last| now - last >= interval);
        if state.spin_changes_fast {
            self.fast_fall = Some(now);
        }
        let interval = if state.is_disturbed {
            DISTURBED_INTERVAL
        } else if !is_due(self.fast_fall, BALANCE_INTERVAL) {
            FAST_FALL_INTERVAL
        } else if state.has_touched {
            DISSIPATION_INTERVAL
        } else {
            CONTACT_FREE_INTERVAL
        };
        let balance = state.is_starting || is_due(self.balance, BALANCE_INTERVAL);
        let dissipation = balance || is_due(self.dissipation, interval);
        let motion = dissipation || is_due(self.motion, MOTION_INTERVAL);
        for (is_made, last) in
            [(motion, &mut self.motion), (dissipation, &mut self.dissipation), (balance, &mut self.balance)]
        {
            if is_made {
                *last = Some(now);
            }
        }
        Due { motion, dissipation, balance }
    }
}

#[cfg(test)]
mod tests {
    use super::{Due, ObservationSchedule, RunState};

    /// Contact steps of 0..`count` at which each observation is made, in steps of one contact step.
    fn made(count: u64, state: impl Fn(u64) -> RunState) -> [Vec<u64>; 3] {
        let mut schedule = ObservationSchedule::default();
        let mut made: [Vec<u64>; 3] = Default::default();
        for contact_steps in 0..count {
            let due = schedule.due(RunState { contact_steps, ..state(contact_steps) });
            assert!(due.motion || !due.dissipation, "a dissipation includes a motion");
            assert!(due.dissipation || !due.balance, "a balance includes a dissipation");
            for (times, is_due) in made.iter_mut().zip([due.motion, due.dissipation, due.balance]) {
                times.extend(is_due.then_some(contact_steps));
            }
        }
        made
    }

    fn every(interval: u64, count: u64) -> Vec<u64> {
        (0..count).step_by(usize::try_from(interval).expect("small")).collect()
    }

    #[test]
    fn before_contact_the_dissipation_is_observed_every_32_contact_steps() {
        let made = made(130, |_| RunState::default());
        assert_eq!(made, [every(8, 130), every(32, 130), every(64, 130)]);
    }

    #[test]
    fn after_contact_the_dissipation_is_observed_with_each_motion() {
        let made = made(130, |_| RunState { has_touched: true, ..RunState::default() });
        assert_eq!(made, [every(8, 130), every(8, 130), every(64, 130)]);
    }

    #[test]
    fn a_start_has_all_observations_in_each_step() {
        let made = made(80, |now| RunState { is_starting: now < 8, ..RunState::default() });
        assert_eq!(made[2], [0, 1, 2, 3, 4, 5, 6, 7, 71]);
        assert_eq!(made[1][..9], [0, 1, 2, 3, 4, 5, 6, 7, 39]);
    }

    #[test]
    fn a_disturbed_start_is_observed_in_every_step_of_the_run() {
        let made = made(100, |_| RunState { is_disturbed: true, spin_changes_fast: true, ..RunState::default() });
        assert_eq!(made[1], every(1, 100));
    }

    #[test]
    fn while_the_spin_falls_fast_and_up_to_64_contact_steps_later_the_interval_is_two() {
        let made = made(200, |now| RunState { spin_changes_fast: now < 10, has_touched: true, ..RunState::default() });
        let expected: Vec<u64> = (0..73).step_by(2).chain((80..200).step_by(8)).collect();
        assert_eq!(made[1], expected);
    }

    #[test]
    fn a_free_step_that_is_longer_than_an_interval_delays_the_observation_to_its_end() {
        let mut schedule = ObservationSchedule::default();
        let mut due = |contact_steps| schedule.due(RunState { contact_steps, ..RunState::default() });
        assert_eq!(due(0), Due::ALL);
        assert_eq!(due(7), Due { motion: false, dissipation: false, balance: false });
        assert_eq!(due(256), Due::ALL);
        assert_eq!(due(288), Due { motion: true, dissipation: true, balance: false });
    }
}
