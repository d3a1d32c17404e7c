//! Gap functions and their gradients.
//!
//! ```text
//! exact (Hyp 2):  g = |P(alpha) - x| - R_r             dg/dx = -n,  dg/dP = n                       at the minimiser
//! polar (Hyp 1):  g = R_i + v(gamma) - |x| - R_r       dg/dx = -e_r + v_alpha/|x| e_theta,  dg/dv = 1,  n = e_r
//! ```
//! Source: docs/theory/03-contact.md (envelope theorem for the exact gap); paper, section 2. All vectors are in the polar basis
//! `(e_r, e_theta)` of the place. Verified by `gradients_match_differences`, `detection_equals_brute_force_on_two_thousand_deformed_rings`.

use crate::stator::{Surface, SurfacePoint};

/// Place on the ring: element, position in it, and the polar basis of its angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Number of the element (0 for a stator without elements).
    pub element: usize,
    /// Position in the element, 0 to 1.
    pub xi: f64,
    /// Angle alpha in the stator's frame \[rad\].
    pub alpha: f64,
    /// sin and cos of alpha.
    pub angle: (f64, f64),
}

impl Place {
    /// Place at an angle \[rad\]; `surface` as for [`exact_gap`].
    #[must_use]
    pub fn at_angle(surface: Option<&Surface>, alpha: f64) -> Self {
        let (element, xi) = surface.map_or((0, 0.0), |surface| surface.locate(alpha));
        Self { element, xi, alpha, angle: libm::sincos(alpha) }
    }

    /// Place at a position in an element.
    #[must_use]
    pub fn in_element(surface: &Surface, element: usize, xi: f64) -> Self {
        let alpha = surface.angle(element, xi);
        Self { element, xi, alpha, angle: libm::sincos(alpha) }
    }

    /// Converts a Cartesian vector to the polar basis of the place.
    #[inline]
    #[must_use]
    pub fn polar(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// Converts a vector in the polar basis of the place to Cartesian components.
    #[inline]
    #[must_use]
    pub fn cartesian(&self, [r, t]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * r - sin * t, sin * r + cos * t]
    }
}

/// Gap and its linearisation, with vectors in the polar basis of the place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Place on the ring where the gap is measured.
    pub place: Place,
    /// Gap g \[m\]; negative for penetration.
    pub value: f64,
    /// Unit normal n, from the rotor to the ring.
    pub normal: [f64; 2],
    /// Gradient dg/dP on the ring, P in components (radial, tangential).
    pub ring_gradient: [f64; 2],
    /// Gradient dg/dx with respect to the rotor centre.
    pub rotor_gradient: [f64; 2],
    /// Slope `v_alpha/|x|` of the polar gap, for the model work `-lambda v_alpha gamma'` with `gamma' = x'.e_theta/|x|`; 0 for the exact gap.
    pub model_slope: f64,
}

fn surface_point(surface: &Surface, field: Option<&[f64]>, place: &Place) -> SurfacePoint {
    match field {
        Some(field) => surface.point(field, place.element, place.xi),
        None => SurfacePoint {
            element: place.element,
            xi: place.xi,
            radial: surface.radius,
            tangential: 0.0,
            radial_slope: 0.0,
            tangential_slope: 0.0,
        },
    }
}

/// Exact gap at a fixed place; `field` has the ring's nodal degrees of freedom, `None` for an undeformed circle.
///
/// At the closest place it is the gap of Hyp 2, and its gradient is exact (envelope theorem).
#[must_use]
pub fn exact_gap(surface: &Surface, field: Option<&[f64]>, rotor_radius: f64, x: [f64; 2], place: Place) -> Gap {
    let point = surface_point(surface, field, &place);
    let x = place.polar(x);
    let d = [point.radial - x[0], point.tangential - x[1]];
    let distance = (d[0] * d[0] + d[1] * d[1]).sqrt();
    // |d| = 0 would require the rotor centre on the ring; the direction of the place is used
    let normal = if distance > 0.0 { [d[0] / distance, d[1] / distance] } else { [1.0, 0.0] };
    Gap {
        place,
        value: distance - rotor_radius,
        normal,
        ring_gradient: normal,
        rotor_gradient: [-normal[0], -normal[1]],
        model_slope: 0.0,
    }
}

/// Gap of Hyp 1, measured at the angle of the rotor centre.
///
/// At `|x| = 0` the angle is undefined: alpha = 0 is used without the rotation term, which avoids NaN.
#[must_use]
pub fn polar_gap(surface: &Surface, field: Option<&[f64]>, rotor_radius: f64, x: [f64; 2]) -> Gap {
    let eccentricity = (x[0] * x[0] + x[1] * x[1]).sqrt();
    let alpha = if eccentricity > 0.0 { libm::atan2(x[1], x[0]) } else { 0.0 };
    let mut place = Place::at_angle(field.map(|_| surface), alpha);
    if eccentricity > 0.0 {
        place.angle = (x[1] / eccentricity, x[0] / eccentricity);
    }
    let point = surface_point(surface, field, &place);
    let negligible = 1e-12 * surface.radius;
    let model_slope = if eccentricity > negligible { point.radial_slope / eccentricity } else { 0.0 };
    Gap {
        place,
        value: point.radial - eccentricity - rotor_radius,
        normal: [1.0, 0.0],
        ring_gradient: [1.0, 0.0],
        rotor_gradient: [-1.0, model_slope],
        model_slope,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stator::steel_ring;

    fn ring() -> Surface {
        steel_ring(12, 0.353, 0.328, true)
    }

    fn wavy(scale: f64) -> Vec<f64> {
        (0..48).map(|i| scale * (f64::from((i * i * 7 + 3 * i) % 23) - 11.0)).collect()
    }

    #[test]
    fn gradients_match_differences() {
        let surface = ring();
        let field = wavy(2e-4);
        let x = [5.1e-3, -4.2e-3];
        let h = 1e-7;
        let fixed = Place::at_angle(Some(&surface), -0.6);
        let exact = |field: &[f64], x: [f64; 2]| exact_gap(&surface, Some(field), 0.32, x, fixed);
        let polar = |field: &[f64], x: [f64; 2]| polar_gap(&surface, Some(field), 0.32, x);
        for gap in [&exact as &dyn Fn(&[f64], [f64; 2]) -> Gap, &polar] {
            let g = gap(&field, x);
            let gradient = g.place.cartesian(g.rotor_gradient);
            for axis in 0..2 {
                let (mut up, mut down) = (x, x);
                up[axis] += h;
                down[axis] -= h;
                let difference = (gap(&field, up).value - gap(&field, down).value) / (2.0 * h);
                assert!((gradient[axis] - difference).abs() < 1e-6, "{axis}: {} {difference}", gradient[axis]);
            }
            for (dof, radial, tangential) in surface.shapes(g.place.element, g.place.xi) {
                let (mut up, mut down) = (field.clone(), field.clone());
                up[dof] += h;
                down[dof] -= h;
                let difference = (gap(&up, x).value - gap(&down, x).value) / (2.0 * h);
                let analytic = g.ring_gradient[0] * radial + g.ring_gradient[1] * tangential;
                assert!((analytic - difference).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_centred_rotor_has_a_gap_and_no_nan() {
        let surface = ring();
        for field in [None, Some(wavy(1e-4))] {
            let gap = polar_gap(&surface, field.as_deref(), 0.32, [0.0, 0.0]);
            assert!(gap.value.is_finite() && gap.rotor_gradient.iter().all(|g| g.is_finite()));
        }
    }
}
