//! Stepping: free motion in steps of 2^k contact steps, contact steps where the gap may close.

#[cfg(test)]
mod clearance_tests;
pub(crate) mod free_motion;
pub(crate) mod free_run;
pub(crate) mod motion_quantities;
pub(crate) mod parabola_peak;
pub(crate) mod rubbing_run;
pub(crate) mod shared_model;
pub(crate) mod step_kernels;
pub(crate) mod transient;
