//! Contact of one stator with the rotor inside it.
//!
//! - [`ring_points`]: points of the ring at fixed angles, with the mode shapes and the residual flexibility there
//! - [`impulsed_ring`]: the ring's modes under impulses at the beginning of each contact step
//! - [`contact_predictor`]: ring and rotor at the end of the step if the last impulses act again
//! - [`broad_phase`], [`gap_minimum`]: ring points near the rotor, and the minima of the gap between them
//! - [`delassus_operator`]: gap and slip of the contact points as functions of their impulses
//! - [`penetration`]: ring points that the impulses leave closed; they become contact points
//! - [`single_place`]: the place of a step where contact acts at one place (`hyp1`, `hyp2-frozen`)
//! - [`contact_step`]: the step that uses all of these; [`contact_step_result`] is its result
//! - [`fixed_point`]: the one place of `hyp2` with one contact point
//! - [`radial_spring`]: a massless radial spring in place of a ring; [`stator`] is either of them, [`stator_axes`] its place
//! - [`static_compliance`]: displacement of a ring under a constant force; [`compliance_check`] compares the contact step with it before the run
//! - [`corrected_shape`]: ring and rotor with static corrections, for observers; [`ring_kernels`] are products over the modes

pub(crate) mod broad_phase;
pub(crate) mod compliance_check;
pub(crate) mod contact_point;
pub(crate) mod contact_predictor;
pub(crate) mod contact_step;
pub(crate) mod contact_step_result;
pub(crate) mod corrected_shape;
pub(crate) mod delassus_operator;
mod fixed_point;
pub(crate) mod gap_minimum;
pub(crate) mod impulsed_ring;
pub(crate) mod penetration;
pub(crate) mod radial_spring;
pub(crate) mod ring_kernels;
pub(crate) mod ring_points;
pub(crate) mod single_place;
pub(crate) mod static_compliance;
pub(crate) mod stator;
pub(crate) mod stator_axes;
