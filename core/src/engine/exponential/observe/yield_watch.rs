//! Watch over the yield strengths: finds the time at which a stress first exceeds its limit to one contact step, with or without a follower.
//!
//! ```text
//! ring, blades   in a free step |sigma| <= sum s_k a_k,  a_k = sqrt(q_k^2 + q_k'^2/w_k^2) at its start: free modes only decay             (1)
//! shaft          sigma_v <= sqrt(M^2 + 3/4 T^2)/W_b,  M by its bound at n (section loads), T the largest of the run so far               (2)
//! free step      2^k contact steps,  1.25 b + 2 b' 2^k <= limit,  b of (2), b' its growth per contact step since the last step            (3)
//! ```
//! Observations of the motion are at least eight contact steps apart, and a free step covers many. Where a bound at n is above a limit that has not been exceeded, stresses are evaluated in
//! this contact step as well. Where (1) or (3) may be exceeded in a free step, free steps are single contact steps. (3) is a margin, not a bound: whirl modes grow evenly under a force. A
//! machine without yield strengths has no watch, and a limit that was exceeded is not watched any more.
//! Verified by `tests/runs/yield_times.rs`, which evaluates every step of a history, and `yield_strengths_are_watched_whoever_follows` (`tests/exponential/exponential_run.rs`): a follower changes no time.

use crate::engine::exponential::modal::section_loads::SECTIONS_AT_ONCE;
use crate::engine::exponential::stepping::transient::Transient;
use crate::record::{Peak, Recorders};

/// Factor of the shaft's bound in (3).
const MARGIN: f64 = 1.25;
/// Factor of the bound's growth in (3).
const GROWTH_MARGIN: f64 = 2.0;

/// Watch over a run of a machine with yield strengths.
pub(crate) struct YieldWatch {
    /// Largest allowed ratios of stress and yield strength of ring, blades and shaft.
    limits: [f64; 3],
    /// Time in contact steps, and bound of the shaft's ratio, at the last step.
    last_bound: Option<(u64, f64)>,
    /// Bounds of the shaft's bending moments \[N m\].
    bounds: Vec<f64>,
    /// Amplitudes a_k of the ring's modes.
    amplitudes: Vec<f64>,
}

/// Stresses to evaluate in a step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WatchResult {
    /// Evaluate stresses of the shaft at n.
    pub shaft: bool,
    /// Evaluate stresses of the ring behind the step.
    pub ring: bool,
    /// Largest free step, in doublings of the contact step.
    pub max_doublings: usize,
}

impl YieldWatch {
    /// Watch over a run; `None` where no material has a yield strength.
    pub fn new(recorders: &Recorders, limits: [f64; 3]) -> Option<Self> {
        let any = ratios(recorders).iter().any(Option::is_some);
        any.then(|| Self { limits, last_bound: None, bounds: Vec::new(), amplitudes: Vec::new() })
    }

    /// Largest allowed ratios of the ring and the blades.
    pub fn ring_limits(&self) -> [f64; 2] {
        [self.limits[0], self.limits[1]]
    }

    /// Stresses to evaluate in the step from n.
    pub fn watch(&mut self, transient: &mut Transient, recorders: &mut Recorders) -> WatchResult {
        let ratios = ratios(recorders);
        let below = |i: usize| ratios[i].is_some_and(|peak| peak.value.unwrap_or(0.0) <= self.limits[i]);
        let [ring, blades, shaft] = [0, 1, 2].map(below);
        let mut watch = WatchResult { shaft: false, ring: ring || blades, max_doublings: usize::MAX };
        let rings = transient.contacts.iter().enumerate().filter(|_| watch.ring);
        for (diaphragm, contact_step) in rings.filter_map(|(i, contact)| Some((i, contact.stator.ring()?))) {
            contact_step.ring.free_amplitudes(&mut self.amplitudes);
            let bounds = recorders.ring_ratio_bounds(diaphragm, &self.amplitudes);
            if (ring && bounds[0] > self.limits[0]) || (blades && bounds[1] > self.limits[1]) {
                watch.max_doublings = 0;
            }
        }
        if shaft {
            let (time, limit) = (transient.free_motion.contact_steps(), self.limits[2]);
            transient.free_motion.moment_bounds(&mut self.bounds);
            let blocks = recorders.elements().div_ceil(SECTIONS_AT_ONCE);
            let bound = recorders.shaft_ratio_bound(SECTIONS_AT_ONCE, &self.bounds[..blocks]);
            let growth = self
                .last_bound
                .map_or(bound, |(before, last)| (bound - last).max(0.0) / time.saturating_sub(before).max(1) as f64);
            self.last_bound = Some((time, bound));
            watch.shaft = bound > limit;
            let holds =
                |doublings: &usize| MARGIN * bound + GROWTH_MARGIN * growth * libm::exp2(*doublings as f64) <= limit;
            watch.max_doublings =
                watch.max_doublings.min((0..usize::BITS as usize / 2).take_while(holds).last().unwrap_or(0));
        }
        watch
    }
}

/// Largest ratios of ring, blades and shaft so far.
fn ratios(recorders: &Recorders) -> [Option<Peak>; 3] {
    [recorders.ring_yield(), recorders.blade_yield(), recorders.shaft_yield()]
}
