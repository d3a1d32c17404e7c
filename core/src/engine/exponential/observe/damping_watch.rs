//! Damping of whirl modes at the speeds that a run visits, from the stations of its grid.

use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::record::{At, Recorders};

/// The cell in which it was last taken.
#[derive(Debug, Default)]
pub(crate) struct DampingWatch {
    cell: Option<i64>,
}

impl DampingWatch {
    /// Takes it where the spin has come to another cell. Stations beyond those of the cell are known only where another run has been there, and have
    /// no part in it. `speed`: the spin \[rad/s\].
    #[inline]
    pub fn update(&mut self, flight: &FreeMotion, speed: f64, recorders: &mut Recorders) {
        let cell = flight.interval_index();
        if self.cell != Some(cell) {
            self.cell = Some(cell);
            let damping = flight.damping();
            let [from, to] = damping.speeds();
            recorders.see_speed(At { time: flight.time(), speed: speed.max(0.0).clamp(from, to) }, &damping);
        }
    }

    /// Takes it at the end of a run, wherever that is in a cell.
    pub fn end(mut self, flight: &FreeMotion, speed: f64, recorders: &mut Recorders) {
        self.cell = None;
        self.update(flight, speed, recorders);
    }
}
