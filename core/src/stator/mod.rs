//! The diaphragm: a ring of curved beams on radial blades, clamped at the casing; planar model (docs/theory/02-diaphragm.md).
//!
//! Coordinates: `[u, u_s, v, v_s]` per ring node (u tangential, v radial, subscript s along the arc), then three per
//! inner blade node `[axial, transverse, slope]`. Angles are local to the stator: blade 0 at alpha = 0.

mod assembly;
mod elements;
mod nodal_forces;
mod sectors;
mod surface;

pub use assembly::RingMatrices;
pub(crate) use nodal_forces::NodalForces;
pub use sectors::Sectors;
pub use surface::{Sample, Surface, SurfacePoint};

/// Contact surface of a steel ring without blades, for tests.
#[cfg(test)]
pub(crate) fn steel_ring(elements: usize, mean_radius: f64, radius: f64, inner_face: bool) -> Surface {
    use bladeoff_model::machine::{FlexibleStator, Rayleigh, Ring};
    let stator = FlexibleStator {
        young_modulus: 2e11,
        poisson_ratio: 0.3,
        density: 7850.0,
        yield_strength: None,
        ring: Ring { mean_radius, thickness: 0.05, width: 0.1, elements },
        blades: None,
        damping: Rayleigh::default(),
    };
    RingMatrices::assemble(&stator).surface(radius, inner_face)
}
