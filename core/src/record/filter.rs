//! The filter of the contact force: its mean over 1 ms.
//!
//! ```text
//! F_f(t_n) = 1/(N dt) sum of F_k dt over k = n-N+1 .. n,   N = 1 ms/dt, rounded, at least one
//! ```
//! Multipliers chatter: the force of one step is no converged quantity, its mean over an impact is. Before N steps have been
//! done the missing ones count as steps without force. Source: ours (`docs/theory/04-time-integration.md`).

use std::collections::VecDeque;

/// Length of the filter, and how long the gap must stay open for an impact to end \[s\].
pub(super) const FILTER: f64 = 1e-3;

/// Sum of what each step of the last 1 ms had: its force, or its impulse.
#[derive(Debug, Clone)]
pub struct LastMillisecond(Window<1>);

impl LastMillisecond {
    /// Filter of a run in steps of `step` \[s\].
    #[must_use]
    pub fn new(step: f64) -> Self {
        Self(Window::new(step))
    }

    /// Steps that 1 ms has.
    #[must_use]
    pub fn length(&self) -> usize {
        self.0.length()
    }

    /// Takes what the next step had.
    #[inline]
    pub fn slide(&mut self, value: f64) {
        self.0.slide([value]);
    }

    /// Takes so many steps that had nothing.
    pub fn pass(&mut self, steps: usize) {
        self.0.pass(steps);
    }

    /// The sum; `None` where no step of the last 1 ms had anything.
    #[inline]
    pub fn sum(&mut self) -> Option<f64> {
        self.0.sums().map(|[sum]| sum)
    }
}

/// Sums of several quantities over the steps of the last 1 ms; a step has something where the first one is not zero, and then alone.
#[derive(Debug, Clone)]
pub(super) struct Window<const N: usize> {
    steps: VecDeque<[f64; N]>,
    length: usize,
    sums: [f64; N],
    /// Steps of the window that had something.
    filled: usize,
}

impl<const N: usize> Window<N> {
    /// Of a run in steps of `step` \[s\].
    pub fn new(step: f64) -> Self {
        // grown by what has happened: a step of no size would ask for more than there is
        Self { steps: VecDeque::new(), length: ((FILTER / step).round() as usize).max(1), sums: [0.0; N], filled: 0 }
    }

    /// Steps that 1 ms has.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Takes what the next step had.
    #[inline]
    pub fn slide(&mut self, values: [f64; N]) {
        let full = self.steps.len() >= self.length;
        let leaving = if full { self.steps.pop_front().unwrap_or([0.0; N]) } else { [0.0; N] };
        self.steps.push_back(values);
        self.filled -= usize::from(leaving[0] != 0.0);
        self.filled += usize::from(values[0] != 0.0);
        for (sum, (value, leaving)) in self.sums.iter_mut().zip(values.iter().zip(leaving)) {
            *sum += value - leaving;
        }
    }

    /// Takes so many steps that had nothing.
    pub fn pass(&mut self, steps: usize) {
        if self.filled == 0 || steps >= self.length {
            // missing ones count as those that had nothing
            self.steps.clear();
            (self.filled, self.sums) = (0, [0.0; N]);
            return;
        }
        (0..steps).for_each(|_| self.slide([0.0; N]));
    }

    /// The sums; `None` where no step of the last 1 ms had anything.
    #[inline]
    pub fn sums(&mut self) -> Option<[f64; N]> {
        if self.filled == 0 {
            // rounding of the sliding sums does not outlive the contact
            self.sums = [0.0; N];
            return None;
        }
        Some(self.sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_holds_the_last_millisecond_and_forgets_its_rounding() {
        let mut filter = LastMillisecond::new(1e-4);
        assert_eq!(filter.length(), 10);
        for force in [0.1, 0.2, 0.3] {
            filter.slide(force);
        }
        assert!((filter.sum().expect("something") - 0.6).abs() < 1e-15);
        for _ in 0..8 {
            filter.slide(0.0);
        }
        assert!((filter.sum().expect("the last two") - 0.5).abs() < 1e-15);
        for _ in 0..2 {
            filter.slide(0.0);
        }
        assert_eq!(filter.sum(), None);
        filter.slide(7.0);
        assert_eq!(filter.sum(), Some(7.0), "not a bit of what was before");
    }

    #[test]
    fn a_step_longer_than_the_filter_is_its_own_mean() {
        let mut filter = LastMillisecond::new(0.1);
        filter.slide(3.0);
        filter.slide(5.0);
        assert_eq!((filter.length(), filter.sum()), (1, Some(5.0)));
    }
}
