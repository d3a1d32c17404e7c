//! Spin and torsion of the shaft line.
//!
//! - [`spin`]: the spin from its angular momentum, without accelerations or iteration
//! - `unbalance`: force of an unbalance on the lateral motion, and its exchange of angular momentum with the spin
//! - [`loaded_modes`]: torsional modes of the shaft line that carries its unbalances
//! - [`torsional_modes`], [`oscillators`]: these modes over a step, in closed form
//! - `torques`: torques over time; `drive`: a prescribed speed
//! - [`gyroscopic_torque`]: gyroscopic torques on the torsional modes, for machines where they matter
//! - `release`: the same rotation in the modes of a machine with other unbalances
//! - [`phasor`]: e^{i psi} for small changes of psi; `spin_quantities`: what other modules read of the spin

mod drive;
pub(crate) mod gyroscopic_torque;
mod loaded_modes;
pub(crate) mod oscillators;
pub(crate) mod phasor;
mod release;
pub(crate) mod spin;
mod spin_quantities;
mod torques;
pub(crate) mod torsional_modes;
mod unbalance;
