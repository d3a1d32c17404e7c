//! Settings of the steps and of the speed grid.

/// Speed intervals between two bases of the grid.
const INTERVALS_PER_BASIS: u32 = 40;

/// Largest free step: `2^MAX_DOUBLINGS` contact steps.
pub(crate) const MAX_DOUBLINGS: usize = 8;

/// Steps and speed grid of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// Contact step \[s\]; a free step is this, doubled any number of times.
    pub step: f64,
    /// Distance of two grid speeds \[rad/s\]. By default the power of two nearest to a 37th of the initial speed, so that machines whose speeds differ little share their bases; closer at
    /// slow spins on anisotropic bearings (`GridSpacing`).
    pub spacing: Option<f64>,
    /// Speed intervals between two grid speeds, an even number.
    pub cells: u32,
    /// Fault that a test injects into the run.
    #[cfg(test)]
    pub(crate) fault: Option<Fault>,
}

/// Fault of a run that a guard, or the check before the run, must find (`observe/fault_tests.rs`).
#[cfg(test)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// The motion has the gyroscopic matrix with the opposite sign.
    GyroscopicSign,
    /// Friction exerts no torque on the spin.
    MissingTorque,
    /// The static correction of the ring's modes has the opposite sign.
    StaticCorrection,
    /// Points that begin to press have three times their normal impulse, on ring and rotor.
    Restitution,
    /// The modal state is not transformed between two speed intervals.
    LostBasisChange,
    /// The motion has 5 % more damping than the energy balance.
    Damping,
}

impl StepSettings {
    /// Settings of a contact step \[s\] with the default grid.
    #[must_use]
    pub fn of_step(step: f64) -> Self {
        Self {
            step,
            spacing: None,
            cells: INTERVALS_PER_BASIS,
            #[cfg(test)]
            fault: None,
        }
    }
}
