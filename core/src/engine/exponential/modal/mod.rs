//! Lateral motion of the shaft line: modal bases over a grid of speeds, exact propagation of the modal state, and everything that is derived from it.
//!
//! 1. `state_space`: the equations of motion at a spin W as a first-order system `x' = A(W) x + B F`; `bearing_tables`: coefficients of bearings that change with W.
//! 2. `modal_planes`: the invariant planes of A, one per oscillating mode or per two overdamped ones; `continuation` finds them from those of a neighbouring speed.
//! 3. `modal_basis`: the basis of these planes at one speed of the grid (`grid_spacing`), with the modal state y, a 2 x 2 `plane_block` per plane, input vectors and output rows.
//! 4. `speed_grid`: the chain of bases that runs visit; `speed_interval`: an interval between two bases, in which the `interval_model` is constant; `basis_change`: y from one interval to the next.
//! 5. `propagator`: the exact change of y over a step of any length; `impulse_response`: the response to contact impulses at its beginning.
//! 6. `outputs`: velocities of the unbalances' nodes, bearing loads, motion of the contact node; `support_loads`: loads with bearing tables.
//! 7. `step_bounds`: the longest free step, by `displacement_bound` (contact) and `peak_bound` (peaks between the ends of a step).
//! 8. `section_loads`, `dissipation`: bending moments, stored energy and damping losses at an observation; `interval_tables` interpolates them for a run.
//! 9. `quadratic_form`, `row_batch`: products of many rows with one modal state, eight rows at a time.
//!
//! Theory and measurements: docs/theory/08-exponential-engine.md, "Whirl states".

pub(crate) mod basis_change;
pub(crate) mod bearing_tables;
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
pub(crate) mod support_loads;
