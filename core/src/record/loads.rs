//! Largest loads of the bearings.

use super::peak::{At, Peak};
use super::row::Row;
use bladeoff_model::machine::Bearing;
use bladeoff_model::outcome::Empty;

/// Watches the norm of each bearing's load in the X-Y plane.
#[derive(Debug, Clone)]
pub(crate) struct LoadRecorder {
    /// Name and |F|^2 (one root at the end) of each bearing.
    bearings: Vec<(String, Peak)>,
    any: Peak,
}

impl LoadRecorder {
    pub fn new(bearings: &[Bearing]) -> Self {
        let named = |bearing: &Bearing| (bearing.name.clone(), Peak::default());
        Self { bearings: bearings.iter().map(named).collect(), any: Peak::default() }
    }

    /// Loads in the machine's order \[N\].
    pub fn see(&mut self, loads: &[[f64; 2]], at: At) {
        for ((_, peak), load) in self.bearings.iter_mut().zip(loads) {
            let square = load[0] * load[0] + load[1] * load[1];
            peak.see(square, at);
            self.any.see(square, at);
        }
    }

    /// All guards hold.
    pub fn hold(&mut self) {
        self.bearings.iter_mut().for_each(|(_, peak)| peak.hold());
        self.any.hold();
    }

    /// Largest load of all bearings \[N\]; `None` where none has been seen.
    pub fn largest(&self) -> Option<f64> {
        self.any.map(f64::sqrt).value.filter(|load| load.is_finite())
    }

    pub(super) fn report(&self, row: &mut Row<'_>) {
        let has_bearings = !self.bearings.is_empty();
        row.with(Empty::Absent, (!has_bearings).then_some("a bearing"), |row| {
            row.peak(
                "max_bearing_load",
                "N",
                "largest bearing load of all bearings, norm in the X-Y plane",
                has_bearings.then(|| self.any.map(f64::sqrt)),
            );
        });
        for (name, peak) in &self.bearings {
            row.peak_of_one(
                format_args!("max_bearing_load_{name}"),
                "N",
                format_args!("largest load of bearing {name}, norm in the X-Y plane"),
                Some(peak.map(f64::sqrt)),
            );
        }
    }
}
