//! The diaphragm: a ring of curved beams on radial blades, clamped at the casing; planar model (docs/theory/02-diaphragm.md).
//!
//! Degrees of freedom: `[u, u_s, v, v_s]` per ring node (u tangential, v radial, subscript s along the arc), then three per
//! inner blade node `[axial, transverse, slope]`. Angles are local to the stator: blade 0 at alpha = 0.

mod assembly;
mod elements;
mod sectors;
mod surface;

pub use assembly::RingMatrices;
pub use sectors::Sectors;
pub use surface::{Sample, Surface, SurfacePoint};
