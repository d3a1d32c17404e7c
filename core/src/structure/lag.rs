//! What a modal basis cannot carry of a contact: the inertia of the modes left out.
//!
//! The modes left out follow a contact force at once (static residual). That holds for those far above what an impact
//! excites. One that is not is too soft at first and too stiff later, and the impact is another one.
//! ```text
//! F(0) = K^-1,   F(W) = (K + W^2 M)^-1        flexibility at rest, and for a force that grows as e^{W t};  W = pi/1 ms
//! lag   = [F(0) - F_kept(0)] - [F(W) - F_kept(W)]  =  sum over the modes left out of  phi^2/w^2  W^2/(w^2 + W^2)        (1)
//! share = (lag of the rotor + lag of the ring)/(F(W) of the rotor + F(0) of the stator)                                 (2)
//! ```
//! at the contact's node in the plane where it is largest, and at the ring node where it is largest. 1 ms is the filter of the contact
//! force; half a sine over it turns with W. Neither (1) nor (2) needs the modes left out, whose number is that of the model.
//!
//! Measured, error of `max_filtered_contact_force_N` against 36 rotor modes (lab rig to 0.2 s; turbine with a gap of 5 mm to 0.13 s):
//!
//! | rotor modes | lab rig: share, error | turbine: share, error |
//! |---|---|---|
//! | 4 | 42 %, 295 % | 12 %, 33 % |
//! | 8 | 7.4 %, 186 % | 5.4 %, 5.4 % |
//! | 12 | 1.4 %, 1.6 % | 1.8 %, 0.02 % |
//! | 16 | 0.24 %, 0.9 % | 0.36 %, 0.1 % |
//! | 24 (default) | 0.005 %, 0.2 % | 0.29 %, 0.1 % |
//!
//! Between 1.8 and 5.4 % lies [`MODAL_LAG`]. Limits: 0 where a part has no static flexibility (a free ring): nothing of the modes left out
//! follows there. Verified by `a_basis_too_small_for_the_contact_is_said`, `the_lag_is_that_of_the_modes_left_out` in `tests/modal_basis.rs`.

use super::part::Part;
use crate::linalg::{Matrix, spd_inverse};
use crate::modal::ModeSet;
use bladeoff_model::machine::DiaphragmKind;

/// Largest share (2) of a run whose contact the modes kept carry; with contact and beyond it a run is invalid (`modal_basis`).
pub const MODAL_LAG: f64 = 0.03;
/// W \[1/s\].
const RATE: f64 = std::f64::consts::PI / 1e-3;

/// Flexibilities of one freedom \[m/N\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lag {
    /// (1).
    lag: f64,
    at_rest: f64,
    moving: f64,
}

/// Lag of freedoms of a part; empty where nothing is left out, or nothing has a static flexibility.
pub(super) fn lags(
    stiffness: &Matrix,
    mass: &Matrix,
    modes: &ModeSet,
    part: &Part,
    freedoms: impl Iterator<Item = usize>,
) -> Vec<Lag> {
    let complete = modes.omega_squared.len() == stiffness.nrows();
    if !part.coordinates.is_modal() || complete || modes.omega_squared.iter().any(|&square| square <= 0.0) {
        return Vec::new();
    }
    let inverses = spd_inverse(stiffness).zip(spd_inverse(&(stiffness + mass * (RATE * RATE))));
    let Some((at_rest, moving)) = inverses else { return Vec::new() };
    let lag = |freedom: usize| {
        let row = part.coordinates.row(freedom);
        // what the modes kept have of the difference
        let kept: f64 = row
            .iter()
            .zip(&modes.omega_squared)
            .map(|(phi, square)| phi * phi / square * RATE * RATE / (square + RATE * RATE))
            .sum();
        let (at_rest, moving) = (at_rest[(freedom, freedom)], moving[(freedom, freedom)]);
        Lag { lag: (at_rest - moving - kept).max(0.0), at_rest, moving }
    };
    freedoms.map(lag).collect()
}

/// Share (2) of the contact of a rotor's freedoms with a stator's, 0 to 1; empty where nothing is left out.
pub(super) fn share(rotor: &[Lag], ring: &[Lag], kind: &DiaphragmKind) -> f64 {
    let none = Lag { lag: 0.0, at_rest: 0.0, moving: 0.0 };
    let still = [none];
    let yielding = match kind {
        DiaphragmKind::RadialSpring { stiffness } => 1.0 / stiffness,
        DiaphragmKind::Rigid | DiaphragmKind::Flexible(_) => 0.0,
    };
    let alone = [Lag { at_rest: yielding, ..none }];
    let rotor = if rotor.is_empty() { &still } else { rotor };
    let stator = if ring.is_empty() { &alone } else { ring };
    let pairs = rotor.iter().flat_map(|rotor| stator.iter().map(move |stator| (rotor, stator)));
    pairs
        .map(|(rotor, stator)| (rotor.lag + stator.lag) / (rotor.moving + stator.at_rest))
        .filter(|share| share.is_finite())
        .fold(0.0, f64::max)
}
