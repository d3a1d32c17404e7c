//! Mean contact force to which the truncated modes of a ring respond.
//!
//! ```text
//! f = mean of the contact forces over the last 1.8/w \[s\];  w: highest frequency of the modes kept                                      (1)
//! ```
//! Truncated modes are faster than w and respond statically to a force that varies slowly compared with 1/w. With a fine step, a contact
//! force also varies from step to step; the stress then follows the mean force. The window (1) is the default contact step of the
//! exponential engine, which therefore uses the force of its step. Without (1), the ring stress grows as the step is refined: by 5 % from
//! 10 us to 1 us with 40 blades (1 % with it).
//!
//! Verified by `a_mean_is_taken_over_the_window`, `tests/runs/ring_stresses.rs`.

use crate::stator::NodalForces;
use crate::structure::RingPart;
use std::collections::VecDeque;

/// Length of the window times w \[rad\].
const WINDOW: f64 = 1.8;
/// Maximum number of parts of the window. With finer steps, a part is the sum of several steps.
const MOST_PARTS: usize = 16;

/// Sliding mean of the contact forces on a ring.
#[derive(Debug, Clone, Default)]
pub(crate) struct ForceAverage {
    /// Number of steps per part; 0 without truncated modes.
    steps: usize,
    /// Number of parts per window; 0 without truncated modes.
    parts: usize,
    /// Sums of the forces of the last parts \[N\], newest last.
    recent: VecDeque<NodalForces>,
    /// Number of steps in the newest part.
    taken: usize,
    /// Mean forces of the last update \[N\].
    mean: NodalForces,
}

impl ForceAverage {
    /// Mean over steps of length `h` \[s\].
    pub fn new(part: &RingPart, h: f64) -> Self {
        if part.residual.is_none() {
            return Self::default();
        }
        let all = (libm::round(WINDOW / (part.part.highest * h)) as usize).max(1);
        let steps = all.div_ceil(MOST_PARTS);
        Self { steps, parts: all.div_ceil(steps), ..Self::default() }
    }

    /// Returns whether the mean covers more than one step, so that the forces of each step must be recorded.
    pub fn needs_each_step(&self) -> bool {
        self.steps * self.parts > 1
    }

    /// Adds the forces of a step.
    pub fn take(&mut self, forces: &NodalForces) {
        if self.parts == 0 {
            return;
        }
        if self.taken == self.steps || self.recent.is_empty() {
            let is_full = self.recent.len() == self.parts;
            let mut part = if is_full { self.recent.pop_front().unwrap_or_default() } else { NodalForces::none() };
            part.clear();
            self.recent.push_back(part);
            self.taken = 0;
        }
        self.taken += 1;
        if let Some(newest) = self.recent.back_mut() {
            newest.add_scaled(1.0, forces);
        }
    }

    /// Clears all forces.
    pub fn clear(&mut self) {
        self.recent.clear();
        self.mean.clear();
    }

    /// Returns the mean for direct writing, if the window is a single step.
    pub fn single(&mut self) -> &mut NodalForces {
        &mut self.mean
    }

    /// Computes the mean over the recorded steps.
    pub fn update(&mut self) {
        self.mean.clear();
        let share = 1.0 / (self.steps * self.parts) as f64;
        for part in self.recent.iter().filter(|part| !part.is_empty()) {
            self.mean.add_scaled(share, part);
        }
    }

    /// Returns the mean of the last [`ForceAverage::update`].
    pub fn mean(&self) -> &NodalForces {
        &self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stator::steel_ring;

    /// Forces of 2 N times a factor at a node, and the factor in the mean.
    #[test]
    fn a_mean_is_taken_over_the_window() {
        let surface = steel_ring(8, 0.4, 0.37, false);
        let mut two = NodalForces::none();
        two.add_at(&surface, (3, 0.0), [2.0, 0.0]);
        for (steps, parts) in [(1, 1), (1, 4), (3, 4)] {
            let mut average = ForceAverage { steps, parts, ..ForceAverage::default() };
            assert_eq!(average.needs_each_step(), steps * parts > 1);
            let value = |average: &mut ForceAverage| {
                average.update();
                average.mean().all().iter().map(|(_, force)| force).sum::<f64>() / 2.0
            };
            // a force in every second step
            let (all, none) = (steps * parts, NodalForces::none());
            for step in 0..4 * all {
                average.take(if step % 2 == 0 { &two } else { &none });
            }
            let expected = if all == 1 { 0.0 } else { 0.5 };
            assert!((value(&mut average) - expected).abs() < 1e-12, "{steps} {parts}");
            (0..all).for_each(|_| average.take(&two));
            assert!((value(&mut average) - 1.0).abs() < 1e-12);
            (0..all).for_each(|_| average.take(&none));
            assert!(value(&mut average).abs() < 1e-12 && average.mean().is_empty());
        }
    }
}
