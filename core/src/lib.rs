//! Blade-off transient of a turbine shaft line: physics and numerics, as pure functions.
//!
//! `(machine, settings) -> outcome`, without I/O, clock, threads or randomness. The main path:
//! [`Machine`](bladeoff_model::machine::Machine) (validated, SI) -> structure (matrices, modes)
//! -> [`engine::simulate`] -> [`Outcome`](bladeoff_model::outcome::Outcome) (one row of the result table).

pub mod contact;
mod eight;
pub mod engine;
pub mod modal;
pub mod record;
pub mod rotor;
pub mod stator;
pub mod stress;
pub mod structure;
pub mod verification;

/// Version of the numbers: raised with every change that alters a bit of any outcome ("Numbers" in CHANGELOG.md), and with the keys of machine files,
/// because they alter the identity of all machines.
pub const NUMERICS_VERSION: u32 = 13;
