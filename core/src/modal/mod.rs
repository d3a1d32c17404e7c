//! Eigenmodes: the reduced basis of the production engine, whirl frequencies, critical speeds, ring frequencies.

mod basis;
mod codec;
mod quadratic;
mod unbalance;
mod whirl;

pub(crate) use basis::modal_key;
pub use basis::{Basis, BasisError, DEFAULT_RING_MODES, DEFAULT_ROTOR_MODES, ModeSet};
pub use quadratic::{QuadraticModes, quadratic_modes};
pub use unbalance::{UnbalanceResponse, unbalance_response};
pub use whirl::{CriticalSpeed, ModesReport, RingMode, Whirl, WhirlMode, report, whirl_modes};
