//! Spin and torsion: the spin from its angular momentum, torsional modes in closed form, the unbalances.

pub(crate) mod gyroscopic_torque;
pub(crate) mod loaded_modes;
pub(crate) mod oscillators;
pub(crate) mod phasor;
pub(crate) mod spin;
pub(crate) mod torsional_modes;
