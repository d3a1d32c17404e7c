//! Flexibility at a bearing that the modes of a run do not follow, and so the part of the bearing load that is missing or wrong.
//!
//! ```text
//! F(0) = sum over all modes of phi^2/w^2      static flexibility of the bearing's node on all bearings
//! R    = sum over the truncated modes of phi^2/w^2
//! share at rest       = R/F(0)                            (1)
//! share behind damper = R/(R + 1/(c W)),  W = pi/1 ms     (2)
//! share that is fast  = sum over the kept modes with w > rate of phi^2/w^2 / F(0)        (3)
//! ```
//! Each share is taken in the direction where it is largest, 0 to 1, with bearings in the machine's order.
//! - (1) is the share of the load without inertia, or the missing share if there is no [`Structure::lateral_residual`].
//! - (2) is (1) for a bearing as stiff as the damper is in an impact of 1 ms. The damper holds the node, and the shaft yields next
//!   to it in truncated modes.
//! - (3) is the share of modes too fast to be resolved by a step of 1/rate.
//!
//! A full model has no truncated modes, so (1) and (2) are 0.
//!
//! Source: residual flexibility (MacNeal 1971), W as in `truncation_error`.
//! Limits: (2) takes only the dampers of the node itself, and the largest of their principal values.
//! Measured in `docs/theory/05-reduction.md`, "Bearings". Verified by `tests/rotor/modal_basis.rs`: `a_damper_that_holds_the_shaft_*`, and by the
//! program's `terminal/bearings.rs`.

use super::Structure;
use super::truncation_error::{Plane, TruncationError, share};
use crate::rotor::BearingSite;

impl Structure {
    /// Share (1) of the truncated modes at rest, by bearing.
    #[must_use]
    pub fn left_out_at_bearings(&self) -> Vec<f64> {
        self.of_bearings(|_, lag| lag.map_or(0.0, TruncationError::share_at_rest))
    }

    /// Share (2) of the truncated modes behind the dampers, by bearing.
    #[must_use]
    pub fn left_out_behind_dampers(&self) -> Vec<f64> {
        let bearings = &self.rotor.bearings;
        self.of_bearings(|bearing, lag| {
            let mut c = [[0.0; 2]; 2];
            for other in bearings.iter().filter(|other| other.node == bearing.node) {
                (0..4).for_each(|i| c[i / 2][i % 2] += other.damping[i / 2][i % 2]);
            }
            lag.map_or(0.0, |lag| lag.share_behind(largest(&c)))
        })
    }

    /// Share (3) of modes faster than `rate` \[rad/s\], by bearing, and the highest frequency w among them \[rad/s\]; 0 if there is no such mode or
    /// the coordinates are nodal.
    #[must_use]
    pub fn fast_at_bearings(&self, rate: f64) -> Vec<(f64, f64)> {
        let part = &self.lateral;
        self.of_bearings(|bearing, lag| {
            if !part.coordinates.is_modal() {
                return (0.0, 0.0);
            }
            let [x, y] = self.rotor.plane_places(bearing.node).map(|place| part.coordinates.row(place));
            let squares = || (0..x.len()).map(|mode| (mode, part.stiffness[(mode, mode)]));
            let above = |least: f64| {
                squares().filter(|(_, square)| *square > least).fold([0.0; 3], |sum: Plane, (mode, square)| {
                    let (a, b) = (x[mode], y[mode]);
                    [sum[0] + a * a / square, sum[1] + a * b / square, sum[2] + b * b / square]
                })
            };
            let fast = above(rate * rate);
            let share = lag.map_or_else(|| share(fast, above(0.0)), |lag| lag.share_of(fast));
            // a mode that hardly moves the bearing does not count as fast at this bearing
            let counts = |mode: usize, square: f64| {
                (x[mode] * x[mode] + y[mode] * y[mode]) / square > 0.01 * (fast[0] + fast[2])
            };
            let highest = squares().filter(|&(mode, square)| square > rate * rate && counts(mode, square));
            (share, highest.map(|(_, square)| square.sqrt()).fold(0.0, f64::max))
        })
    }

    fn of_bearings<T>(&self, what: impl Fn(&BearingSite, Option<&TruncationError>) -> T) -> Vec<T> {
        self.rotor
            .bearings
            .iter()
            .map(|bearing| what(bearing, self.rotor_truncation_errors.get(bearing.node)))
            .collect()
    }
}

/// Largest principal value of the symmetric part \[N s/m\].
fn largest(c: &[[f64; 2]; 2]) -> f64 {
    let (mean, half) = (0.5 * (c[0][0] + c[1][1]), 0.5 * (c[0][0] - c[1][1]));
    mean + libm::hypot(half, 0.5 * (c[0][1] + c[1][0]))
}
