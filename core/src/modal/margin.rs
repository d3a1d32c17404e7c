//! Amplification factor and separation margin of a critical speed.
//!
//! ```text
//! AF = 1/(2 zeta)                                                       peak over static response of a lightly damped mode        (1)
//! SM = |W_run - W_crit| / W_run                                         distance from the running speed                          (2)
//! required = min(0.17 f, 0.16)          W_crit below the running speed,  f = 1 - 1/(AF - 1.5)                                    (3)
//! required = min(0.10 + 0.17 f, 0.26)   W_crit above it                                                                          (4)
//! required = 0                          AF < 2.5: the mode is damped so well that its critical speed is no limit                 (5)
//! ```
//! Source: (2) to (5) are the definitions of API 617 (8th edition, lateral analysis), for one running speed instead of a range. That
//! standard takes AF from the width of the peak in a computed response; (1) is its limit for one lightly damped mode. Limits: (1) neglects
//! the position of the unbalance and neighbouring modes. Verified by the tests below.

use super::whirl::CriticalSpeed;

/// Amplification factor below which no margin is required.
const CRITICALLY_DAMPED: f64 = 2.5;

impl CriticalSpeed {
    /// Amplification factor (1) \[-\]: infinite without damping; `None` for an unstable mode.
    #[must_use]
    pub fn amplification(&self) -> Option<f64> {
        (self.damping_ratio >= 0.0).then(|| 0.5 / self.damping_ratio)
    }

    /// Separation margin (2) \[-\] from a running speed \[rad/s\]; `None` at rest.
    #[must_use]
    pub fn separation(&self, running: f64) -> Option<f64> {
        (running > 0.0).then(|| (self.speed - running).abs() / running)
    }

    /// Required separation margin (3) to (5) \[-\]; `None` at rest, and for modes that are unstable or not excited by unbalance.
    #[must_use]
    pub fn required_separation(&self, running: f64) -> Option<f64> {
        let factor = self.amplification().filter(|_| running > 0.0 && self.is_excited_by_unbalance())?;
        if factor < CRITICALLY_DAMPED {
            return Some(0.0);
        }
        let share = 0.17 * (1.0 - 1.0 / (factor - 1.5));
        Some(if self.speed < running { share.min(0.16) } else { (0.10 + share).min(0.26) })
    }

    /// Whether the separation margin from a running speed \[rad/s\] is smaller than the required one.
    #[must_use]
    pub fn is_too_near(&self, running: f64) -> bool {
        self.separation(running)
            .zip(self.required_separation(running))
            .is_some_and(|(margin, required)| margin < required)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::Whirl;

    fn critical(speed: f64, damping_ratio: f64, share: f64) -> CriticalSpeed {
        CriticalSpeed { speed, damping_ratio, whirl: Whirl::Forward, share }
    }

    #[test]
    fn margins_follow_from_the_amplification_factor() {
        // AF = 10: 17 % (1 - 1/8.5) = 15 % below, 25 % above
        let [below, above] = [90.0, 110.0].map(|speed| critical(speed, 0.05, 1.0));
        assert!((below.amplification().expect("stable") - 10.0).abs() < 1e-12);
        assert!((below.separation(100.0).expect("turns") - 0.1).abs() < 1e-12);
        assert!((below.required_separation(100.0).expect("excited") - 0.15).abs() < 1e-12);
        assert!((above.required_separation(100.0).expect("excited") - 0.25).abs() < 1e-12);
        assert!(below.is_too_near(100.0) && above.is_too_near(100.0));
        assert!(!critical(84.9, 0.05, 1.0).is_too_near(100.0) && !critical(125.1, 0.05, 1.0).is_too_near(100.0));
        // at AF = 2.5 the requirement begins at 0 and 10 %, and without damping it ends at 16 and 26 %
        for (speed, damping, required) in
            [(90.0, 0.2, 0.0), (110.0, 0.2, 0.10), (90.0, 0.0, 0.16), (110.0, 0.0, 0.26), (110.0, 0.2001, 0.0)]
        {
            let found = critical(speed, damping, 1.0).required_separation(100.0).expect("excited");
            assert!((found - required).abs() < 1e-12, "{speed} {damping}: {found}");
        }
    }

    #[test]
    fn what_has_no_margin_has_none() {
        let backward = critical(90.0, 0.05, -1.0);
        assert!(backward.required_separation(100.0).is_none() && !backward.is_too_near(100.0));
        assert!(backward.separation(100.0).is_some() && backward.separation(0.0).is_none());
        let unstable = critical(90.0, -0.05, 1.0);
        assert!(unstable.amplification().is_none() && unstable.required_separation(100.0).is_none());
        assert!(critical(90.0, 0.05, 1.0).required_separation(0.0).is_none());
        assert_eq!(critical(90.0, 0.0, 1.0).amplification(), Some(f64::INFINITY));
    }
}
