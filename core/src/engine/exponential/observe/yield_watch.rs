//! Times at which stresses first exceed limits of the yield strength: to one contact step, with or without a follower.
//!
//! ```text
//! ring, blades   in flight |sigma| <= sum s_k a_k,  a_k = sqrt(n_k^2 + n_k'^2/w_k^2) at its start: free modes only decay                 (1)
//! shaft          sigma_v <= sqrt(M^2 + 3/4 T^2)/W_b,  M by its bound at n (`measured`), T the largest of the run so far                  (2)
//! flight         2^level contact steps,  1.25 b + 2 b' 2^level <= limit,  b of (2), b' its growth per contact step since the last step     (3)
//! ```
//! Looks are eight contact steps apart at least, and a step in flight covers many. Where a bound at n is above a limit that has not been exceeded, stresses are looked at in this contact step as well, and
//! where (1) or (3) may be exceeded in flight, flights are single contact steps. (3) is a margin, not a bound: pairs grow evenly under a force. A machine without yield strengths has none of this, and what has
//! exceeded its limit is not watched any more.
//! Verified by `tests/yield_times.rs`, which evaluates every step of a history, and `yield_strengths_are_watched_whoever_follows` (`tests/exponential_run.rs`): a follower changes no time.

use crate::engine::exponential::modal::section_loads::SECTIONS_AT_ONCE;
use crate::engine::exponential::stepping::transient::Transient;
use crate::record::{Peak, Recorders};

/// Room that a bound of the shaft has to have for a flight, and how much faster it may grow than it did.
const ROOM: f64 = 1.25;
const GROWS: f64 = 2.0;

/// Watches a run of a machine with yield strengths.
pub(crate) struct YieldWatch {
    /// Ratios of stress and yield strength of rings, blades and shaft beyond which nothing is watched.
    limits: [f64; 3],
    /// Time in contact steps and bound of the shaft's ratio at the last step.
    before: Option<(u64, f64)>,
    bounds: Vec<f64>,
    amplitudes: Vec<f64>,
}

/// Stresses to look at in a step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WatchResult {
    /// The shaft's moments at n.
    pub shaft: bool,
    /// The ring behind the step.
    pub ring: bool,
    /// Level of the longest flight.
    pub most: usize,
}

impl YieldWatch {
    /// Watch over a run; `None` where no material has a yield strength.
    pub fn new(recorders: &Recorders, limits: [f64; 3]) -> Option<Self> {
        let any = ratios(recorders).iter().any(Option::is_some);
        any.then(|| Self { limits, before: None, bounds: Vec::new(), amplitudes: Vec::new() })
    }

    /// Limits of the ring's and the blades' ratios.
    pub fn of_ring(&self) -> [f64; 2] {
        [self.limits[0], self.limits[1]]
    }

    /// Stresses to look at in the step from n.
    pub fn watch(&mut self, transient: &mut Transient, recorders: &mut Recorders) -> WatchResult {
        let ratios = ratios(recorders);
        let below = |i: usize| ratios[i].is_some_and(|peak| peak.value.unwrap_or(0.0) <= self.limits[i]);
        let [ring, blades, shaft] = [0, 1, 2].map(below);
        let mut watch = WatchResult { shaft: false, ring: ring || blades, most: usize::MAX };
        if let (true, Some(contact)) = (watch.ring, &transient.contact) {
            contact.contact_step.ring.free_amplitudes(&mut self.amplitudes);
            let bounds = recorders.ring_ratio_bounds(&self.amplitudes);
            if (ring && bounds[0] > self.limits[0]) || (blades && bounds[1] > self.limits[1]) {
                watch.most = 0;
            }
        }
        if shaft {
            let (ticks, limit) = (transient.free_motion.contact_steps(), self.limits[2]);
            transient.free_motion.moment_bounds(&mut self.bounds);
            let blocks = recorders.elements().div_ceil(SECTIONS_AT_ONCE);
            let bound = recorders.shaft_ratio_bound(SECTIONS_AT_ONCE, &self.bounds[..blocks]);
            let growth = self
                .before
                .map_or(bound, |(before, last)| (bound - last).max(0.0) / ticks.saturating_sub(before).max(1) as f64);
            self.before = Some((ticks, bound));
            watch.shaft = bound > limit;
            let holds = |level: &usize| ROOM * bound + GROWS * growth * libm::exp2(*level as f64) <= limit;
            watch.most = watch.most.min((0..usize::BITS as usize / 2).take_while(holds).last().unwrap_or(0));
        }
        watch
    }
}

/// Largest ratios of rings, blades, shaft.
fn ratios(recorders: &Recorders) -> [Option<Peak>; 3] {
    [recorders.ring_yield(), recorders.blade_yield(), recorders.shaft_yield()]
}
