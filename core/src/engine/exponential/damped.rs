//! Damping of whirl modes at the speeds that a run visits, from the stations of its grid.

use super::flight::Flight;
use crate::record::{At, Recorders};

/// The cell in which it was last taken.
#[derive(Debug, Default)]
pub(super) struct Damped {
    cell: Option<i64>,
}

impl Damped {
    /// Takes it where the spin has come to another cell. Stations beyond those of the cell are known only where another run has been there, and have
    /// no part in it. `speed`: the spin \[rad/s\].
    #[inline]
    pub fn see(&mut self, flight: &Flight, speed: f64, recorders: &mut Recorders) {
        let cell = flight.cell();
        if self.cell != Some(cell) {
            self.cell = Some(cell);
            let damping = flight.damping();
            let [from, to] = damping.speeds();
            recorders.see_speed(At { time: flight.time(), speed: speed.max(0.0).clamp(from, to) }, &damping);
        }
    }

    /// Takes it at the end of a run, wherever that is in a cell.
    pub fn end(mut self, flight: &Flight, speed: f64, recorders: &mut Recorders) {
        self.cell = None;
        self.see(flight, speed, recorders);
    }
}
