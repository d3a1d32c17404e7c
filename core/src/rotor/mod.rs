//! The shaft line: finite-element matrices of shaft elements, discs and bearings, gyroscopic sites, unbalance, static torsion.
//!
//! Lateral degrees of freedom are ordered plane by plane: `[u, theta_v]` of every node, then `[v, theta_u]` of every node. A point mass has
//! `[u]`, then `[v]`. Pedestals follow after all nodes, X and Y of each. Use [`RotorMatrices::u`] and its siblings for indices. The
//! torsional degree of freedom of a node is its absolute angle `psi_i = phi + beta_i`, the axial one its displacement `w`
//! (docs/theory/01-shaft-line.md).

mod assembly;
mod bearing_site;
mod constant_forces;
mod element;
mod gyro;
mod static_torsion;
mod unbalance;

pub use assembly::RotorMatrices;
pub use bearing_site::BearingSite;
pub(crate) use element::GAUSS4;
pub use element::{ShaftBlocks, deflection, shaft_blocks};
pub use gyro::GyroSite;
pub use unbalance::{Turn, UnbalanceSite};
