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
//! Where the run exceeds a limit of the model, (2) is judged at this instant, but not within 1 ms of the first touch. Fine steps separate light touches
//! of a few microseconds from the long contact after them; a coarse step does not. A coarse step has too small a force, so what exceeds the limit with it
//! exceeds the limit.
//!
//! Source: ours. Measured on a rotor that hits a ring for 33 us (`docs/theory/short-impacts.md`): the exponential engine loses 21, 10, 5 and
//! 0.8 % of the impulse with n = 8, 12, 17 and 39; `reduced` loses 20, 6.5 and 3 % with n = 15, 49 and 96. Limits: a rigid stator takes an
//! impact in one step for any step size, so n does not characterise the resolution there. Verified by the tests below and
//! `core/tests/contact/{short_impacts,light_touch}.rs`.

/// Number of steps without a force that end a phase.
const APART: usize = 2;

/// Time after the first touch within which the phases are not judged at a limit \[s\].
const FIRST: f64 = 1e-3;

/// Contact phase: sum of the impulses of its steps \[N s\], and sum of their squares \[N2 s2\].
#[derive(Debug, Clone, Copy, Default)]
struct Phase {
    /// Sum of the impulses `J_k` \[N s\].
    impulse: f64,
    /// Sum of the squared impulses `J_k^2` [N2 s2].
    squares: f64,
    /// Number of steps since the last one with a force.
    open: usize,
    /// Start of its first step and end of its last step with a force \[s\].
    begin: f64,
    end: f64,
}

/// Judgement at the instant at which the run exceeds a limit of the model.
#[derive(Debug, Clone, Copy)]
struct AtLimit {
    /// Mean (2); `None` while no phase counts.
    steps: Option<f64>,
    /// Whether the run continues, so that later phases are judged too.
    continues: bool,
}

/// Contact phases of one ring.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Phases {
    /// Sums of (2) over the phases that have ended: `J_i` \[N s\] and `J_i/n_i` \[N s\].
    ended: [f64; 2],
    /// Phase in progress; `None` between phases.
    current: Option<Phase>,
    /// Time of the first touch \[s\].
    first: Option<f64>,
    at_limit: Option<AtLimit>,
}

impl Phases {
    /// Records the normal impulse \[N s\] of a step that begins at `time` \[s\] and lasts `step` \[s\].
    #[inline]
    pub fn see(&mut self, impulse: f64, time: f64, step: f64) {
        if impulse > 0.0 {
            self.first.get_or_insert(time);
            let phase = self.current.get_or_insert(Phase { begin: time, ..Phase::default() });
            phase.end = time + step;
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
    fn mean(&self) -> Option<f64> {
        let mean = |[impulse, share]: [f64; 2]| (share > 0.0).then(|| impulse / share);
        let ended = mean(self.ended)?;
        Some(self.current.and_then(|phase| mean(self.with(phase))).map_or(ended, |all| all.max(ended)))
    }

    /// Length of the phase in progress \[s\]; `None` between phases.
    pub fn open_length(&self) -> Option<f64> {
        self.current.map(|phase| phase.end - phase.begin)
    }

    /// Judges the phases at the instant `now` \[s\], at which the run exceeds a limit of the model.
    pub fn judge_at_limit(&mut self, now: f64) {
        let steps = self.first.filter(|first| now - first >= FIRST).and_then(|_| self.mean());
        self.at_limit = Some(AtLimit { steps, continues: false });
    }

    /// Declares that the run continues beyond the limit.
    pub fn continue_beyond(&mut self) {
        if let Some(at_limit) = &mut self.at_limit {
            at_limit.continues = true;
        }
    }

    /// Number of steps per impact that the guard judges: mean (2), or that at an exceeded limit if it is smaller or the run ends there. `None`
    /// while no phase counts.
    pub fn judged(&self) -> Option<f64> {
        match self.at_limit {
            Some(AtLimit { steps, continues: false }) => steps,
            Some(AtLimit { steps, continues: true }) => [steps, self.mean()].into_iter().flatten().reduce(f64::min),
            None => self.mean(),
        }
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

    /// Number of steps per impact of the row: the judged one, otherwise mean (2), otherwise (1) of the current phase; `None` without contact.
    pub fn steps(&self) -> Option<f64> {
        let current = || self.current.map(|phase| phase.impulse * phase.impulse / phase.squares);
        self.judged().or_else(|| self.mean()).or_else(current)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Option<f64>, expected: f64) {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-12 * expected), "{found:?}, not {expected}");
    }

    /// Phases of steps of 1 s.
    #[derive(Default)]
    struct Steps {
        phases: Phases,
        now: f64,
    }

    impl Steps {
        fn see(&mut self, impulse: f64) {
            self.phases.see(impulse, self.now, 1.0);
            self.now += 1.0;
        }
        fn pass(&mut self, steps: usize) {
            self.phases.pass(steps);
            self.now += steps as f64;
        }
    }

    #[test]
    fn phases_count_by_their_impulses() {
        let mut steps = Steps::default();
        assert_eq!((steps.phases.steps(), steps.phases.judged()), (None, None));
        (0..10).for_each(|_| steps.see(3.0));
        assert_eq!(steps.phases.judged(), None);
        close(steps.phases.steps(), 10.0);
        steps.pass(2);
        close(steps.phases.judged(), 10.0);
        // a spike of one step with the same impulse: (30 + 30)/(3 + 30)
        steps.see(30.0);
        close(steps.phases.judged(), 10.0);
        steps.pass(100);
        close(steps.phases.judged(), 60.0 / 33.0);
    }

    #[test]
    fn a_spike_within_a_long_weak_phase_counts_as_a_spike() {
        let mut steps = Steps::default();
        steps.see(1.0);
        (0..100).for_each(|_| steps.see(1e-4));
        steps.pass(2);
        assert!(steps.phases.judged().is_some_and(|steps| steps < 1.03));
    }

    #[test]
    fn one_step_without_force_is_chatter() {
        let mut steps = Steps::default();
        for step in 0..40 {
            steps.see(if step % 2 == 0 { 1.0 } else { 0.0 });
        }
        steps.pass(5);
        close(steps.phases.judged(), 20.0);
    }

    #[test]
    fn a_long_phase_that_has_not_ended_raises_the_mean() {
        let mut steps = Steps::default();
        steps.see(1.0);
        steps.pass(3);
        (0..99).for_each(|_| steps.see(1.0));
        close(steps.phases.judged(), 100.0 / 2.0);
    }

    #[test]
    fn light_touches_do_not_count_at_a_limit_soon_after_the_first() {
        let mut phases = Phases::default();
        phases.see(1.0, 0.5, 1e-5);
        phases.pass(2);
        let at_limit = |now: f64| {
            let mut phases = phases;
            phases.judge_at_limit(now);
            phases.judged()
        };
        close(phases.judged(), 1.0);
        assert_eq!(at_limit(0.5009), None);
        close(at_limit(0.5011), 1.0);
    }

    #[test]
    fn a_run_that_continues_beyond_its_limit_has_the_smaller_number() {
        let mut steps = Steps::default();
        steps.see(1.0);
        steps.pass(100);
        steps.phases.judge_at_limit(steps.now);
        steps.phases.continue_beyond();
        (0..99).for_each(|_| steps.see(1.0));
        steps.pass(100);
        close(steps.phases.judged(), 1.0);
        close(steps.phases.steps(), 1.0);
        // a limit while all impacts are long
        let mut steps = Steps::default();
        (0..99).for_each(|_| steps.see(1.0));
        steps.pass(200);
        steps.phases.judge_at_limit(steps.now);
        steps.phases.continue_beyond();
        steps.see(1.0);
        steps.pass(100);
        close(steps.phases.judged(), 100.0 / 2.0);
    }
}
