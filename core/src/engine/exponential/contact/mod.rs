//! Contact: points of the ring, the search for the smallest gap, and the impulses of one contact step.

pub(crate) mod broad_phase;
pub(crate) mod contact_conditions;
pub(crate) mod contact_point;
pub(crate) mod contact_predictor;
pub(crate) mod contact_step;
pub(crate) mod corrected_shape;
pub(crate) mod delassus_operator;
pub(crate) mod impact;
pub(crate) mod impulsed_ring;
pub(crate) mod penetration;
pub(crate) mod ring_kernels;
pub(crate) mod ring_points;
