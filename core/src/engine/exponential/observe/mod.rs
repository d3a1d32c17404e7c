//! Observation: what a run records of the motion, and the loop of a run.

pub(crate) mod damping_watch;
pub(crate) mod dissipated_energy;
pub(crate) mod energy_balance;
pub(crate) mod energy_terms;
#[cfg(test)]
mod fault_tests;
pub(crate) mod frame_sampler;
pub(crate) mod nodal_motion;
pub(crate) mod observation_schedule;
pub(crate) mod observer;
pub(crate) mod ring_clearance;
pub(crate) mod ring_stress_check;
pub(crate) mod run;
pub(crate) mod shaft_stresses;
pub(crate) mod yield_watch;
