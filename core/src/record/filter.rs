//! Filter of the contact force: its mean over 1 ms.
//!
//! ```text
//! F_f(t_n) = 1/(N dt) sum of F_k dt over k = n-N+1 .. n,   N = 1 ms/dt, rounded, at least one
//! ```
//! The multipliers chatter: the force of one step is not a converged quantity, but its mean over an impact is. Before the first N steps are
//! complete, the missing steps count as steps without force. Source: ours (`docs/theory/04-time-integration.md`).

use std::collections::VecDeque;

/// Length of the filter, and minimum time of an open gap that ends an impact \[s\].
pub(super) const FILTER: f64 = 1e-3;

/// Sliding sum of a force or impulse over the steps of the last 1 ms.
#[derive(Debug, Clone)]
pub struct LastMillisecond(Window<1>);

impl LastMillisecond {
    /// Filter of a run with the time step `step` \[s\].
    #[must_use]
    pub fn new(step: f64) -> Self {
        Self(Window::new(step))
    }

    /// Number of steps in 1 ms.
    #[must_use]
    pub fn length(&self) -> usize {
        self.0.length()
    }

    /// Adds the value of the next step.
    #[inline]
    pub fn slide(&mut self, value: f64) {
        self.0.slide([value]);
    }

    /// Adds several steps with the value zero.
    pub fn pass(&mut self, steps: usize) {
        self.0.pass(steps);
    }

    /// Returns the sum; `None` if all steps of the last 1 ms are zero.
    #[inline]
    pub fn sum(&mut self) -> Option<f64> {
        self.0.sums().map(|[sum]| sum)
    }
}

/// Sliding sums of several quantities over the steps of the last 1 ms. The first quantity determines whether a step counts as non-zero.
#[derive(Debug, Clone)]
pub(super) struct Window<const N: usize> {
    /// Values of the steps in the window, oldest first.
    steps: VecDeque<[f64; N]>,
    /// Number of steps in 1 ms.
    length: usize,
    /// Sums over the window.
    sums: [f64; N],
    /// Number of non-zero steps in the window.
    filled: usize,
}

impl<const N: usize> Window<N> {
    /// Window of a run with the time step `step` \[s\].
    pub fn new(step: f64) -> Self {
        // the queue grows step by step: with a step of zero length, its full capacity could not be allocated
        Self { steps: VecDeque::new(), length: ((FILTER / step).round() as usize).max(1), sums: [0.0; N], filled: 0 }
    }

    /// Number of steps in 1 ms.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Adds the values of the next step.
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

    /// Adds several steps with the value zero.
    pub fn pass(&mut self, steps: usize) {
        if self.filled == 0 || steps >= self.length {
            // missing steps count as zero
            self.steps.clear();
            (self.filled, self.sums) = (0, [0.0; N]);
            return;
        }
        (0..steps).for_each(|_| self.slide([0.0; N]));
    }

    /// Returns the sums; `None` if all steps of the last 1 ms are zero.
    #[inline]
    pub fn sums(&mut self) -> Option<[f64; N]> {
        if self.filled == 0 {
            // the rounding of the sliding sums ends with the contact
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
