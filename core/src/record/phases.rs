//! Number of steps per contact phase: the time resolution of impacts.
//!
//! ```text
//! n_i = (sum J_k)^2/(sum J_k^2)            steps k of contact phase i, J_k normal impulse of a step               (1)
//! n   = (sum J_i)/(sum J_i/n_i)            mean over all phases, weighted by their impulses J_i                    (2)
//! ```
//! For a constant force, (1) is the number of steps; for a half sine, it is 0.81 of the number of steps. A short spike at the start of a
//! long weak phase counts as a spike. A phase ends after two steps without a force; a single step without a force is chatter of the
//! multipliers.
//!
//! Source: ours. Measured on a rotor that hits a ring for 33 us (`docs/theory/convergence.md`): the exponential engine loses 21, 10, 5 and
//! 0.8 % of the impulse with n = 8, 12, 17 and 39; `reduced` loses 20, 6.5 and 3 % with n = 15, 49 and 96. Limits: a rigid stator takes an
//! impact in one step for any step size, so n does not characterise the resolution there. Verified by the tests below and
//! `core/tests/contact/short_impacts.rs`.

/// Number of steps without a force that end a phase.
const APART: usize = 2;

/// Contact phase: sum of the impulses of its steps \[N s\], and sum of their squares \[N2 s2\].
#[derive(Debug, Clone, Copy, Default)]
struct Phase {
    /// Sum of the impulses `J_k` \[N s\].
    impulse: f64,
    /// Sum of the squared impulses `J_k^2` [N2 s2].
    squares: f64,
    /// Number of steps since the last one with a force.
    open: usize,
}

/// Contact phases of one ring.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Phases {
    /// Sums of (2) over the phases that have ended: `J_i` \[N s\] and `J_i/n_i` \[N s\].
    ended: [f64; 2],
    /// Phase in progress; `None` between phases.
    current: Option<Phase>,
}

impl Phases {
    /// Records the normal impulse of a step \[N s\].
    #[inline]
    pub fn see(&mut self, impulse: f64) {
        if impulse > 0.0 {
            let phase = self.current.get_or_insert_default();
            phase.impulse += impulse;
            phase.squares += impulse * impulse;
            phase.open = 0;
        } else {
            self.pass(1);
        }
    }

    /// Records steps without a force.
    pub fn pass(&mut self, steps: usize) {
        let Some(mut phase) = self.current.take() else { return };
        phase.open += steps;
        if phase.open >= APART {
            self.ended = self.with(phase);
        } else {
            self.current = Some(phase);
        }
    }

    fn with(&self, phase: Phase) -> [f64; 2] {
        let [impulse, share] = self.ended;
        [impulse + phase.impulse, share + phase.squares / phase.impulse]
    }

    /// Mean (2) over the phases that have ended. The current phase is included if it raises the mean: its length so far is a lower bound.
    /// `None` before the first phase has ended.
    pub fn known(&self) -> Option<f64> {
        let mean = |[impulse, share]: [f64; 2]| (share > 0.0).then(|| impulse / share);
        let ended = mean(self.ended)?;
        Some(self.current.and_then(|phase| mean(self.with(phase))).map_or(ended, |all| all.max(ended)))
    }

    /// Keeps the phases of the ring with the smaller number of steps per impact.
    pub fn include(&mut self, other: &Self) {
        if let (Some(own), Some(others)) = (self.steps(), other.steps()) {
            if others < own {
                *self = *other;
            }
        } else if self.steps().is_none() {
            *self = *other;
        }
    }

    /// Mean (2); if no phase has ended, (1) of the current phase; `None` without contact.
    pub fn steps(&self) -> Option<f64> {
        self.known().or_else(|| self.current.map(|phase| phase.impulse * phase.impulse / phase.squares))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Option<f64>, expected: f64) {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-12 * expected), "{found:?}, not {expected}");
    }

    #[test]
    fn phases_count_by_their_impulses() {
        let mut phases = Phases::default();
        assert_eq!((phases.steps(), phases.known()), (None, None));
        (0..10).for_each(|_| phases.see(3.0));
        assert_eq!(phases.known(), None);
        close(phases.steps(), 10.0);
        phases.pass(2);
        close(phases.known(), 10.0);
        // a spike of one step with the same impulse: (30 + 30)/(3 + 30)
        phases.see(30.0);
        close(phases.known(), 10.0);
        phases.pass(100);
        close(phases.known(), 60.0 / 33.0);
    }

    #[test]
    fn a_spike_within_a_long_weak_phase_counts_as_a_spike() {
        let mut phases = Phases::default();
        phases.see(1.0);
        (0..100).for_each(|_| phases.see(1e-4));
        phases.pass(2);
        assert!(phases.known().is_some_and(|steps| steps < 1.03));
    }

    #[test]
    fn one_step_without_force_is_chatter() {
        let mut phases = Phases::default();
        for step in 0..40 {
            phases.see(if step % 2 == 0 { 1.0 } else { 0.0 });
        }
        phases.pass(5);
        close(phases.known(), 20.0);
    }

    #[test]
    fn a_long_phase_that_has_not_ended_raises_the_mean() {
        let mut phases = Phases::default();
        phases.see(1.0);
        phases.pass(3);
        (0..99).for_each(|_| phases.see(1.0));
        close(phases.known(), 100.0 / 2.0);
    }
}
