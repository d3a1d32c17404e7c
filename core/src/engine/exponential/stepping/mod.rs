//! Stepping: the path of a run from n to n+1.
//!
//! - [`free_motion`]: the shaft line without contact, in steps of 2^k contact steps; [`step_kernels`] are its inner loops
//! - [`motion_quantities`]: what observers evaluate of the free motion
//! - [`transient`]: the choice between a long step of free motion and a contact step, and the step itself
//! - [`diaphragm_contact`]: contact with all diaphragms in a contact step
//! - [`shared_model`]: modal bases and ring points that all runs of one model share
//! - [`release`]: an unbalance that appears during a run
//! - [`rubbing_run`]: a whole run without observation, for tests

#[cfg(test)]
mod clearance_tests;
pub(crate) mod diaphragm_contact;
pub(crate) mod free_motion;
pub(crate) mod motion_quantities;
pub(crate) mod release;
pub(crate) mod rubbing_run;
pub(crate) mod shared_model;
pub(crate) mod step_kernels;
pub(crate) mod transient;
