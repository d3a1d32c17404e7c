//! The shaft line: elements, discs, bearings assembled to finite-element matrices, gyroscopic sites, unbalance, braking.
//!
//! Lateral degrees of freedom stand plane by plane: `[u, theta_v]` of every node, then `[v, theta_u]` of every node (a
//! point-mass rotor has `[u]`, `[v]`); use [`RotorMatrices::u`] and its siblings for places. Pedestals stand behind all nodes, X and Y of each. Twist stands as one absolute angle `psi_i = phi + beta_i` per node, axial as one `w` per node (docs/theory/01-shaft-line.md).

mod assembly;
mod bearing_site;
mod braking;
mod constant_forces;
mod element;
mod gyro;
mod unbalance;

pub use assembly::RotorMatrices;
pub use bearing_site::BearingSite;
pub use braking::{braking_torque, constant_torque};
pub(crate) use element::GAUSS4;
pub use element::{ShaftBlocks, deflection, shaft_blocks};
pub use gyro::GyroSite;
pub use unbalance::{Turn, UnbalanceSite};
