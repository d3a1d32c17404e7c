//! Least damping of the whirl modes over the speeds that a run visits, from the modal bases of its speed grid.

use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::record::{At, Recorders};

/// Watch over the damping of whirl modes during a run.
#[derive(Debug, Default)]
pub(crate) struct DampingWatch {
    /// Index of the speed interval in which damping was last recorded.
    interval: Option<i64>,
}

impl DampingWatch {
    /// Records the damping where the spin has entered another speed interval. Bases beyond those of the interval exist only where another run has computed them: they are not used, so
    /// that rows do not depend on earlier runs. `speed`: the spin \[rad/s\].
    #[inline]
    pub fn update(&mut self, motion: &FreeMotion, speed: f64, recorders: &mut Recorders) {
        let interval = motion.interval_index();
        if self.interval != Some(interval) {
            self.interval = Some(interval);
            let damping = motion.damping();
            let [from, to] = damping.speeds();
            recorders.see_speed(At { time: motion.time(), speed: speed.max(0.0).clamp(from, to) }, &damping);
        }
    }

    /// Records the damping at the end of a run, wherever in an interval that is.
    pub fn end(mut self, motion: &FreeMotion, speed: f64, recorders: &mut Recorders) {
        self.interval = None;
        self.update(motion, speed, recorders);
    }
}
