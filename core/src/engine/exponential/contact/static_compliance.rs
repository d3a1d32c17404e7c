//! Displacement of a ring under a constant force by its stiffness, with which [`super::compliance_check`] compares the contact steps.
//!
//! ```text
//! u = v^T K^-1 v             K: stiffness of ring and blades
//! ```
//! u: radial displacement of a ring point per radial force there \[m/N\]; v: shape functions of the point on the degrees of freedom. With
//! `run.static_residual = "off"` truncated modes do not follow a force, and u is `sum_j V_j^2/w_j^2` over the kept modes, V: radial mode
//! shapes at the point. Verified by `rings_have_the_compliance_of_their_stiffness`.

use crate::stator::Surface;
use crate::structure::RingPart;

/// Compliance of a ring at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StaticCompliance {
    /// Number of the ring point.
    pub point: usize,
    /// Radial displacement per radial force \[m/N\].
    pub compliance: f64,
}

impl StaticCompliance {
    /// Compliances at the first of `count` points with these locations, which is next to a blade, and half-way to the next of `sectors`
    /// blades. Empty for a ring without stiffness in some direction.
    pub fn of(part: &RingPart, surface: &Surface, locations: &[(usize, f64)], sectors: usize) -> Vec<Self> {
        let (stiffness, coordinates) = (&part.matrices.stiffness, &part.part.coordinates);
        let follows = part.residual.is_some() || coordinates.size() == stiffness.nrows();
        let are_stiff = (0..coordinates.size()).all(|j| part.part.stiffness[(j, j)] > 0.0);
        let Some(inverse) = part.matrices.sectors.inverse(stiffness).filter(|_| are_stiff) else { return Vec::new() };
        let points = [0, locations.len() / (2 * sectors)];
        let create = |point: usize| {
            let (element, xi) = locations[point];
            let shapes = surface.shapes(element, xi);
            let compliance = if follows {
                let row = |i: usize| shapes.iter().map(|&(j, radial, _)| radial * inverse[(i, j)]).sum::<f64>();
                shapes.iter().map(|&(i, radial, _)| radial * row(i)).sum()
            } else {
                let mut modes = vec![0.0; coordinates.size()];
                shapes.iter().for_each(|&(dof, radial, _)| coordinates.add_row(dof, radial, &mut modes));
                modes.iter().enumerate().map(|(j, v)| v * v / part.part.stiffness[(j, j)]).sum()
            };
            Self { point, compliance }
        };
        points.map(create).to_vec()
    }
}
