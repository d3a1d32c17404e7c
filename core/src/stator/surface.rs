//! Contact surface of the ring: position, tangent and shape functions of a point at angle alpha.
//!
//! ```text
//! P(alpha) = (R_i + v) e_r + u_P e_theta
//! u_P = c_u u + c_s v_s     mean line: c_u = 1, c_s = 0;  inner face: u - (R_c - R_i) theta_z, theta_z = u/R_c - v_s
//! ```
//! Source: docs/theory/03-contact.md. Gap, slip and force use the same `u_P`.
//! Verified by `derivatives_along_the_ring_match_differences`, `contact::tests`.

use super::elements::hermite;

/// Geometry of a ring's contact surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Number of ring nodes, equal to the number of elements.
    pub nodes: usize,
    /// Radius R_c of the mean line \[m\].
    mean_radius: f64,
    /// Radius R_i of the undeformed contact surface \[m\].
    pub radius: f64,
    /// Factor c_u of u in `u_P`.
    coefficient_u: f64,
    /// Factor c_s of v_s in `u_P` \[m\].
    coefficient_slope: f64,
}

/// Point of the deformed surface, in the polar basis (e_r, e_theta) of its angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Number of the element.
    pub element: usize,
    /// Position in the element, 0 to 1 along alpha.
    pub xi: f64,
    /// Radial coordinate R_i + v \[m\], v positive outwards.
    pub radial: f64,
    /// Tangential displacement u_P \[m\], positive along alpha.
    pub tangential: f64,
    /// Derivative d(R_i + v)/d alpha \[m/rad\].
    pub radial_slope: f64,
    /// Derivative d u_P/d alpha \[m/rad\].
    pub tangential_slope: f64,
}

/// Hermite shape functions at a fixed position in an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Values N on `[q1, q_s1, q2, q_s2]`: 1 for displacements, \[m\] for slopes.
    n: [f64; 4],
    /// Derivatives dN/ds along the arc: \[1/m\] for displacements, 1 for slopes.
    dn: [f64; 4],
}

/// Value of a field with nodal values `q` and shape functions `n`.
#[inline(always)]
fn along(n: &[f64; 4], q: &[f64; 4]) -> f64 {
    n[0] * q[0] + n[1] * q[1] + n[2] * q[2] + n[3] * q[3]
}

impl Surface {
    pub(super) fn new(nodes: usize, mean_radius: f64, radius: f64, inner_face: bool) -> Self {
        let (coefficient_u, coefficient_slope) =
            if inner_face { (radius / mean_radius, mean_radius - radius) } else { (1.0, 0.0) };
        Self { nodes, mean_radius, radius, coefficient_u, coefficient_slope }
    }

    /// Circle of radius `R_i` \[m\] that does not deform.
    #[must_use]
    pub fn circle(radius: f64) -> Self {
        Self { nodes: 1, mean_radius: radius, radius, coefficient_u: 1.0, coefficient_slope: 0.0 }
    }

    /// Angle subtended by one element \[rad\].
    #[must_use]
    pub fn element_angle(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.nodes as f64
    }

    /// Element and position in it at an angle \[rad\], which may be outside 0 to 2 pi.
    #[must_use]
    pub fn locate(&self, alpha: f64) -> (usize, f64) {
        let turns = alpha / (2.0 * std::f64::consts::PI);
        let place = (turns - turns.floor()) * self.nodes as f64;
        let element = (place as usize).min(self.nodes - 1);
        (element, (place - element as f64).clamp(0.0, 1.0))
    }

    /// Angle of a position in an element \[rad\].
    #[must_use]
    pub fn angle(&self, element: usize, xi: f64) -> f64 {
        (element as f64 + xi) * self.element_angle()
    }

    /// Point of the ring at a position, with nodal degrees of freedom `field`.
    #[inline]
    #[must_use]
    pub fn point(&self, field: &[f64], element: usize, xi: f64) -> SurfacePoint {
        let l = self.element_angle() * self.mean_radius;
        let [n, dn, ddn] = hermite(xi, l);
        let [u, v] = self.freedoms(field, element);
        let slope = along(&dn, &v);
        SurfacePoint {
            element,
            xi,
            radial: self.radius + along(&n, &v),
            tangential: self.coefficient_u * along(&n, &u) + self.coefficient_slope * slope,
            radial_slope: self.mean_radius * slope,
            tangential_slope: self.mean_radius
                * (self.coefficient_u * along(&dn, &u) + self.coefficient_slope * along(&ddn, &v)),
        }
    }

    /// Shape functions at a position in an element, for [`Surface::displaced`].
    #[must_use]
    pub fn sample(&self, xi: f64) -> Sample {
        let [n, dn, _] = hermite(xi, self.element_angle() * self.mean_radius);
        Sample { n, dn }
    }

    /// Radial coordinate and tangential displacement \[m\] of [`Surface::point`], at a sample of an element.
    #[inline]
    #[must_use]
    pub fn displaced(&self, field: &[f64], element: usize, sample: &Sample) -> [f64; 2] {
        let [u, v] = self.freedoms(field, element);
        let slope = along(&sample.dn, &v);
        [self.radius + along(&sample.n, &v), self.coefficient_u * along(&sample.n, &u) + self.coefficient_slope * slope]
    }

    /// Nodal values `[u, u_s]` and `[v, v_s]` at both ends of an element.
    #[inline(always)]
    fn freedoms(&self, field: &[f64], element: usize) -> [[f64; 4]; 2] {
        let (a, b) = (4 * element, if element + 1 == self.nodes { 0 } else { 4 * (element + 1) });
        [[field[a], field[a + 1], field[b], field[b + 1]], [field[a + 2], field[a + 3], field[b + 2], field[b + 3]]]
    }

    /// Shape functions of `(R_i + v, u_P)` at a position: `(degree of freedom, d radial, d tangential)` of its eight degrees of freedom.
    #[inline]
    #[must_use]
    pub fn shapes(&self, element: usize, xi: f64) -> [(usize, f64, f64); 8] {
        let l = self.element_angle() * self.mean_radius;
        let [n, dn, _] = hermite(xi, l);
        let (a, b) = (4 * element, if element + 1 == self.nodes { 0 } else { 4 * (element + 1) });
        let (cu, cs) = (self.coefficient_u, self.coefficient_slope);
        [
            (a, 0.0, cu * n[0]),
            (a + 1, 0.0, cu * n[1]),
            (a + 2, n[0], cs * dn[0]),
            (a + 3, n[1], cs * dn[1]),
            (b, 0.0, cu * n[2]),
            (b + 1, 0.0, cu * n[3]),
            (b + 2, n[2], cs * dn[2]),
            (b + 3, n[3], cs * dn[3]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_along_the_ring_match_differences() {
        for inner_face in [false, true] {
            let surface = Surface::new(8, 0.4, 0.37, inner_face);
            let field: Vec<f64> = (0..32).map(|i| 1e-3 * (f64::from(i * i % 17) - 8.0)).collect();
            for element in 0..8 {
                let (xi, h) = (0.37, 1e-6);
                let at = |xi| surface.point(&field, element, xi);
                let d_alpha = 2.0 * h * surface.element_angle();
                let point = at(xi);
                let radial = (at(xi + h).radial - at(xi - h).radial) / d_alpha;
                let tangential = (at(xi + h).tangential - at(xi - h).tangential) / d_alpha;
                assert!((point.radial_slope - radial).abs() < 1e-8);
                assert!((point.tangential_slope - tangential).abs() < 1e-8);
                let through: (f64, f64) = surface
                    .shapes(element, xi)
                    .iter()
                    .fold((0.0, 0.0), |sum, &(dof, r, t)| (sum.0 + r * field[dof], sum.1 + t * field[dof]));
                assert!((through.0 + 0.37 - point.radial).abs() < 1e-14);
                assert!((through.1 - point.tangential).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_rigid_rotation_turns_the_inner_face_as_a_body() {
        let surface = Surface::new(8, 0.4, 0.37, true);
        let mut field = vec![0.0; 32];
        for node in 0..8 {
            field[4 * node] = 0.4 * 1e-3;
        }
        let point = surface.point(&field, 3, 0.2);
        assert!((point.tangential - 0.37e-3).abs() < 1e-15);
    }

    #[test]
    fn angles_and_places_go_there_and_back() {
        let surface = Surface::new(48, 0.4, 0.37, true);
        for k in -100..100 {
            let alpha = f64::from(k) * 0.1237;
            let (element, xi) = surface.locate(alpha);
            let back = surface.angle(element, xi);
            let turns = (back - alpha) / (2.0 * std::f64::consts::PI);
            assert!((turns - turns.round()).abs() < 1e-12);
        }
    }
}
