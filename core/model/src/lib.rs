//! Machines and outcomes. The text of a machine file becomes a [`machine::MachineDef`] (values that may be varied by path), then a
//! [`machine::Machine`] (validated, SI). The result of a run is an [`outcome::Outcome`], a row of the result table. This crate has no
//! matrices, modes or time steps; the crates that compute or vary machines depend on it.
//!
//! A [`machine::Machine`] has passed every check, including that of lost masses against the mass and inertia of the rotor. So no caller can
//! forget a check, and all mistakes of a file are reported at once.

pub mod machine;
pub mod outcome;
