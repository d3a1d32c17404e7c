//! How finely a run is computed.

/// Cells between two stations of the grid.
const INTERVALS_PER_BASIS: u32 = 40;

/// A flight step has at most `2^LEVELS` contact steps.
pub(crate) const MAX_DOUBLINGS: usize = 8;

/// Steps and grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// Contact step \[s\]; a flight may take it doubled any number of times.
    pub step: f64,
    /// Distance of the grid's speeds \[rad/s\]; by default the power of two nearest to a 37th of the initial speed, so that it is one for speeds that differ
    /// a little; closer at slow spins on bearings that are not the same in all directions (`scale`).
    pub spacing: Option<f64>,
    /// Cells between two of them, even.
    pub cells: u32,
}

impl StepSettings {
    /// With the default grid.
    #[must_use]
    pub fn of_step(step: f64) -> Self {
        Self { step, spacing: None, cells: INTERVALS_PER_BASIS }
    }
}
