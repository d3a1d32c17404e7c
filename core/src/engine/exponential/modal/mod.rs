//! Lateral motion: modal bases over a grid of speeds, and exact propagation of modal states.

pub(crate) mod basis_change;
pub(crate) mod continuation;
pub(crate) mod displacement_bound;
pub(crate) mod dissipation;
pub(crate) mod grid_spacing;
pub(crate) mod impulse_response;
pub(crate) mod interval_model;
pub(crate) mod interval_tables;
pub(crate) mod modal_basis;
pub(crate) mod modal_planes;
pub(crate) mod outputs;
pub(crate) mod peak_bound;
pub(crate) mod plane_block;
pub(crate) mod propagator;
pub(crate) mod quadratic_form;
pub(crate) mod row_batch;
pub(crate) mod section_loads;
pub(crate) mod speed_grid;
pub(crate) mod speed_interval;
pub(crate) mod state_space;
pub(crate) mod step_bounds;
