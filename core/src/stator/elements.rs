//! Curved ring element and straight blade element.

use nalgebra::{Matrix6, SMatrix, SVector};

use crate::rotor::GAUSS4;
use bladeoff_model::machine::{Blades, FlexibleStator, Ring};

/// 8x8 matrix of a ring element on `[u1, u_s1, v1, v_s1, u2, u_s2, v2, v_s2]`.
pub(super) type Matrix8 = SMatrix<f64, 8, 8>;
type Vector8 = SVector<f64, 8>;

/// Cubic Hermite functions at `xi` in an element of length `l`: values, first and second derivatives with respect to s.
#[inline]
pub(super) fn hermite(xi: f64, l: f64) -> [[f64; 4]; 3] {
    let x2 = xi * xi;
    let x3 = x2 * xi;
    [
        [1.0 - 3.0 * x2 + 2.0 * x3, l * (xi - 2.0 * x2 + x3), 3.0 * x2 - 2.0 * x3, l * (x3 - x2)],
        [6.0 * (x2 - xi) / l, 1.0 - 4.0 * xi + 3.0 * x2, 6.0 * (xi - x2) / l, 3.0 * x2 - 2.0 * xi],
        [(12.0 * xi - 6.0) / (l * l), (6.0 * xi - 4.0) / l, (6.0 - 12.0 * xi) / (l * l), (6.0 * xi - 2.0) / l],
    ]
}

/// Mass and stiffness of one ring element.
///
/// ```text
/// 2V = E int [S (v/R + u_s)^2 + I_z (v/R^2 + v_ss)^2] ds         membrane, change of curvature
/// 2T = rho int [S (u'^2 + v'^2) + I_z theta_z'^2] ds              theta_z = u/R - v_s
/// ```
/// Source: paper eqs (7), (8) with `w_c = theta_s = 0` and its letters u_c, v_c exchanged (erratum, docs/theory/02-diaphragm.md).
/// Cubic Hermite for both fields, 4 Gauss points (degree 6 products: exact).
///
/// # Units
/// SI. u positive with alpha, v outward.
/// # Limits
/// Thin ring (Euler-Bernoulli), small displacements; coarse thin rings lock by some per cent.
/// # Verified by
/// `rotation_has_no_strain_energy`, `free_ring_*` and `pinched_ring_*` in `tests/contact/ring.rs`
pub(super) fn ring_element(stator: &FlexibleStator) -> (Matrix8, Matrix8) {
    let Ring { mean_radius: r, thickness, width, elements } = stator.ring;
    let area = thickness * width;
    let inertia = width * thickness * thickness * thickness / 12.0;
    let l = 2.0 * std::f64::consts::PI * r / elements as f64;
    let (mut mass, mut stiffness) = (Matrix8::zeros(), Matrix8::zeros());
    for (xi, weight) in GAUSS4 {
        let [n, dn, ddn] = hermite(xi, l);
        let (mut u, mut v, mut du, mut dv, mut ddv) =
            (Vector8::zeros(), Vector8::zeros(), Vector8::zeros(), Vector8::zeros(), Vector8::zeros());
        for (k, place) in [0, 1, 4, 5].into_iter().enumerate() {
            (u[place], du[place]) = (n[k], dn[k]);
            (v[place + 2], dv[place + 2], ddv[place + 2]) = (n[k], dn[k], ddn[k]);
        }
        let membrane = v / r + du;
        let curvature = v / (r * r) + ddv;
        let rotation = u / r - dv;
        let ds = weight * l;
        stiffness += (membrane * membrane.transpose()) * (stator.young_modulus * area * ds)
            + (curvature * curvature.transpose()) * (stator.young_modulus * inertia * ds);
        mass += (u * u.transpose() + v * v.transpose()) * (stator.density * area * ds)
            + (rotation * rotation.transpose()) * (stator.density * inertia * ds);
    }
    (mass, stiffness)
}

/// Mass and stiffness of one blade element on `[a1, t1, th1, a2, t2, th2]`: axial (outward), transverse (along e_theta), slope.
///
/// Euler-Bernoulli bending with rotary inertia, linear traction. Source: paper, "Blades: straight beams".
/// Verified by `a_blade_carries_its_textbook_stiffness`.
pub(super) fn blade_element(stator: &FlexibleStator, blades: &Blades) -> (Matrix6<f64>, Matrix6<f64>) {
    let area = blades.thickness * blades.width;
    let inertia = blades.width * blades.thickness * blades.thickness * blades.thickness / 12.0;
    let l = blades.length / blades.elements as f64;
    let (e, rho) = (stator.young_modulus, stator.density);
    let (mut mass, mut stiffness) = (Matrix6::zeros(), Matrix6::zeros());
    for (a, b, m, k) in [(0, 0, 2.0, 1.0), (0, 3, 1.0, -1.0), (3, 0, 1.0, -1.0), (3, 3, 2.0, 1.0)] {
        mass[(a, b)] = m * rho * area * l / 6.0;
        stiffness[(a, b)] = k * e * area / l;
    }
    let places = [1, 2, 4, 5];
    for (xi, weight) in GAUSS4 {
        let [n, dn, ddn] = hermite(xi, l);
        let dx = weight * l;
        for i in 0..4 {
            for j in 0..4 {
                mass[(places[i], places[j])] += rho * (area * n[i] * n[j] + inertia * dn[i] * dn[j]) * dx;
                stiffness[(places[i], places[j])] += e * inertia * ddn[i] * ddn[j] * dx;
            }
        }
    }
    (mass, stiffness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::Rayleigh;

    fn stator() -> (FlexibleStator, Blades) {
        let blades = Blades { count: 4, length: 0.3, thickness: 0.02, width: 0.05, elements: 1 };
        let ring = Ring { mean_radius: 0.4, thickness: 0.03, width: 0.05, elements: 12 };
        let damping = Rayleigh::default();
        let stator = FlexibleStator {
            young_modulus: 2e11,
            poisson_ratio: 0.3,
            density: 7800.0,
            yield_strength: None,
            ring,
            blades: Some(blades),
            damping,
        };
        (stator, blades)
    }

    #[test]
    fn rotation_has_no_strain_energy() {
        let (stator, _) = stator();
        let (_, stiffness) = ring_element(&stator);
        let rotation = Vector8::from_column_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        assert!((stiffness * rotation).amax() < 1e-9 * stiffness.amax());
    }

    #[test]
    fn a_blade_carries_its_textbook_stiffness() {
        let (stator, blades) = stator();
        let (mass, k) = blade_element(&stator, &blades);
        let free = k.fixed_view::<3, 3>(3, 3).into_owned().try_inverse().expect("clamped");
        let inertia = 0.05 * 0.02f64.powi(3) / 12.0;
        assert!((free[(1, 1)] * 3.0 * 2e11 * inertia / 0.3f64.powi(3) - 1.0).abs() < 1e-11);
        assert!((free[(0, 0)] * 2e11 * 0.05 * 0.02 / 0.3 - 1.0).abs() < 1e-12);
        let total = 7800.0 * 0.05 * 0.02 * 0.3;
        let axial = mass[(0, 0)] + mass[(0, 3)] + mass[(3, 0)] + mass[(3, 3)];
        assert!((axial / total - 1.0).abs() < 1e-12);
    }
}
