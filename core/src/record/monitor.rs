//! Shaft displacements at the positions of `[monitors]`: the largest value, and the time above a clearance.
//!
//! ```text
//! T = sum over steps of h s,    s: part of the step with |x| > gap, |x| between both ends of the step a straight line
//! ```
//! x: displacement of the shaft from the bearing line \[m\]. Limits: a monitor causes no contact. A free-motion step of the exponential
//! engine spans up to 0.075 rad of the spin and of the lowest mode, so T has an error of second order in the step length. Verified by
//! `core/tests/runs/monitors.rs`.

use super::peak::{At, Peak, Sum};
use super::row::Row;
use bladeoff_model::machine::Monitor;

/// Record of one monitor.
#[derive(Debug, Clone)]
struct Watched {
    name: String,
    /// Clearance \[m\].
    gap: f64,
    /// Largest displacement from the bearing line \[m\].
    displacement: Peak,
    /// Time T with a displacement above the clearance \[s\].
    above: Sum,
    /// Time \[s\] and displacement minus clearance \[m\] at the last instant.
    last: Option<[f64; 2]>,
}

impl Watched {
    fn see(&mut self, [x, y]: [f64; 2], at: At) {
        let size = libm::hypot(x, y);
        self.displacement.see(size, at);
        let beyond = size - self.gap;
        if let Some([time, before]) = self.last {
            let share = match (before > 0.0, beyond > 0.0) {
                (true, true) => 1.0,
                (false, false) => 0.0,
                _ => before.max(beyond) / (before - beyond).abs(),
            };
            self.above.value += share * (at.time - time);
        }
        self.last = Some([at.time, beyond]);
    }
}

/// Recorder of a machine's monitors, in the order of the file.
#[derive(Debug, Clone)]
pub(crate) struct MonitorRecorder(Vec<Watched>);

impl MonitorRecorder {
    pub fn new(monitors: &[Monitor]) -> Self {
        let watched = |monitor: &Monitor| Watched {
            name: monitor.name.clone(),
            gap: monitor.gap,
            displacement: Peak::default(),
            above: Sum::default(),
            last: None,
        };
        Self(monitors.iter().map(watched).collect())
    }

    /// Records the displacements at an instant \[m\].
    #[inline]
    pub fn see(&mut self, displacements: &[[f64; 2]], at: At) {
        for (watched, displacement) in self.0.iter_mut().zip(displacements) {
            watched.see(*displacement, at);
        }
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        for watched in &mut self.0 {
            watched.displacement.hold();
            watched.above.hold();
        }
    }

    pub(super) fn report(&self, row: &mut Row<'_>) {
        for Watched { name, displacement, above, .. } in &self.0 {
            row.peak(
                format_args!("max_displacement_{name}"),
                "m",
                format_args!("largest displacement of the shaft at monitor {name} from the bearing line"),
                Some(*displacement),
            );
            row.sum(
                &format!("time_above_gap_{name}_s"),
                "s",
                &format!("time with a displacement above the gap of monitor {name}"),
                Some(*above),
            );
        }
    }
}
