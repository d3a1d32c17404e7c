//! Two-node Timoshenko shaft element: matrices of one bending plane, of torsion and of axial motion.

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

use bladeoff_model::machine::{GAUSS5, ShaftElement};

/// Matrices of a shaft element, for `[w1, s1, w2, s2]` in a bending plane (deflection and slope of the section at both ends).
#[derive(Debug, Clone, PartialEq)]
pub struct ShaftBlocks {
    /// Bending mass matrix: translational and rotary inertia [kg, kg m, kg m2].
    pub mass: Matrix4<f64>,
    /// Bending stiffness matrix [N/m, N, N m].
    pub stiffness: Matrix4<f64>,
    /// Gyroscopic matrix `H = int rho I_p N_s^T N_s dz` of a bending plane, before the signs of the two planes [kg, kg m, kg m2].
    pub gyroscopic: Matrix4<f64>,
    /// Torsional inertia matrix \[kg m2\].
    pub torsional_mass: Matrix2<f64>,
    /// Torsional stiffness matrix [N m/rad].
    pub torsional_stiffness: Matrix2<f64>,
    /// Axial mass matrix \[kg\].
    pub axial_mass: Matrix2<f64>,
    /// Axial stiffness matrix \[N/m\].
    pub axial_stiffness: Matrix2<f64>,
}

/// Abscissae and weights of the 4-point Gauss rule on [0, 1], exact up to degree 7; the products along a cylinder have degree 6.
pub(crate) const GAUSS4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

impl ShaftBlocks {
    /// Adds the matrices of another beam between the same nodes.
    pub fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.stiffness += other.stiffness;
        self.gyroscopic += other.gyroscopic;
        self.torsional_mass += other.torsional_mass;
        self.torsional_stiffness += other.torsional_stiffness;
        self.axial_mass += other.axial_mass;
        self.axial_stiffness += other.axial_stiffness;
    }
}

/// Computes the matrices of one shaft element.
///
/// ```text
/// Phi = 12 E I/(k G S L^2)                                       shear parameter of the middle; 0 without shear deformation
/// M = int rho S N_w^T N_w + rho I N_s^T N_s dz                    consistent mass, translation and rotary inertia
/// K = int E I N_s'^T N_s' + k G S (N_w' - N_s)^T (N_w' - N_s) dz  strain energy (4) of the paper
/// H = int rho I_p N_s^T N_s dz,  I_p = 2 I
/// ```
/// E, G: Young's and shear modulus; rho: density; S, I: area and second moment of area; k: shear coefficient; N_w, N_s: shape functions of
/// deflection and slope. S and I of a tapered element vary along it; the integrals are exact. Source: paper eqs (3), (4); static shape
/// functions of the Timoshenko beam (Przemieniecki 1968), in the conventions of the reference data; for tapers Genta and Gugliotta (1988).
/// Deviation: none.
///
/// # Units
/// SI; the degrees of freedom of a plane are `[u, theta_v]` in XZ and `[v, -theta_u]` in YZ.
/// # Limits
/// Round section, small rotations; no axial-force or torque-bending coupling (third order, neglected as in the paper). A tapered element
/// uses the shape functions of a cylinder, so a strong taper needs several elements.
/// # Verified by
/// `rigid_motions_cost_nothing_and_carry_the_section_s_inertia`, `reference_rotors_*` in `tests/rotor/linear_rotors.rs`, `tests/rotor/tapers.rs`
#[must_use]
pub fn shaft_blocks(element: &ShaftElement) -> ShaftBlocks {
    let l = element.length;
    let (e, rho, g) = (element.young_modulus, element.density, element.shear_modulus());
    let phi = element.shear_parameter();
    let mut blocks = ShaftBlocks {
        mass: Matrix4::zeros(),
        stiffness: Matrix4::zeros(),
        gyroscopic: Matrix4::zeros(),
        torsional_mass: Matrix2::zeros(),
        torsional_stiffness: Matrix2::zeros(),
        axial_mass: Matrix2::zeros(),
        axial_stiffness: Matrix2::zeros(),
    };
    let points: &[(f64, f64)] = if element.is_tapered() { &GAUSS5 } else { &GAUSS4 };
    for &(xi, weight) in points {
        let [w, s, ds] = element.shapes(xi, phi).map(Vector4::from);
        let (area, inertia) = (element.area_at(xi), element.inertia_at(xi));
        let polar = 2.0 * inertia;
        let dz = weight * l;
        blocks.mass += (w * w.transpose()) * (rho * area * dz) + (s * s.transpose()) * (rho * inertia * dz);
        blocks.stiffness += (ds * ds.transpose()) * (e * inertia * dz);
        blocks.gyroscopic += (s * s.transpose()) * (rho * polar * dz);
    }
    if let Some(rigidity) = element.shear_coefficient.map(|k| k * g * element.mean_area()) {
        // w' - s is constant along the element: -Phi/(1+Phi) times the strain of pure bending
        let shear = Vector4::new(-1.0 / l, -0.5, 1.0 / l, -0.5) * (phi / (1.0 + phi));
        blocks.stiffness += (shear * shear.transpose()) * (rigidity * l);
    }
    add_linear(element, &mut blocks);
    blocks
}

/// Torsion and axial motion: mass from linear shape functions, stiffness from the static flexibility.
fn add_linear(element: &ShaftElement, blocks: &mut ShaftBlocks) {
    let (l, e, rho, g) = (element.length, element.young_modulus, element.density, element.shear_modulus());
    let (consistent, pair) = (Matrix2::new(2.0, 1.0, 1.0, 2.0), Matrix2::new(1.0, -1.0, -1.0, 1.0));
    if !element.is_tapered() {
        let (area, polar) = (element.area_at(0.0), 2.0 * element.inertia_at(0.0));
        blocks.torsional_mass = consistent * (rho * polar * l / 6.0);
        blocks.torsional_stiffness = pair * (g * polar / l);
        blocks.axial_mass = consistent * (rho * area * l / 6.0);
        blocks.axial_stiffness = pair * (e * area / l);
        return;
    }
    let (mut torsion, mut axial) = (0.0, 0.0);
    for (xi, weight) in GAUSS5 {
        let ends = Vector2::new(1.0 - xi, xi);
        let (area, polar, outer) = (element.area_at(xi), 2.0 * element.inertia_at(xi), ends * ends.transpose());
        blocks.torsional_mass += outer * (rho * polar * weight * l);
        blocks.axial_mass += outer * (rho * area * weight * l);
        torsion += weight * l / (g * polar);
        axial += weight * l / (e * area);
    }
    (blocks.torsional_stiffness, blocks.axial_stiffness) = (pair / torsion, pair / axial);
}

/// Deflection \[m\] at `xi = z/L` between the ends of an element, from its end values `[w1, s1, w2, s2]`.
///
/// Source: the element's own static shape functions ([`shaft_blocks`]). Verified by
/// `a_deflection_between_the_nodes_is_that_of_the_beam`.
#[must_use]
pub fn deflection(element: &ShaftElement, ends: [f64; 4], xi: f64) -> f64 {
    let [w, _, _] = element.shapes(xi, element.shear_parameter());
    Vector4::from(w).dot(&Vector4::from(ends))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(shear_coefficient: Option<f64>) -> ShaftElement {
        ShaftElement {
            length: 0.7,
            diameter: 0.2,
            inner_diameter: 0.05,
            end_diameter: 0.2,
            end_inner_diameter: 0.05,
            young_modulus: 2.1e11,
            poisson_ratio: 0.3,
            density: 7850.0,
            shear_coefficient,
            yield_strength: None,
            section: 0,
        }
    }

    /// Cantilever of one element under an end force: `w(z) = F (z^2 (3 L - z)/(6 E I) + z/(k G S))`, slope without the shear.
    #[test]
    fn a_deflection_between_the_nodes_is_that_of_the_beam() {
        let pi = std::f64::consts::PI;
        for shear in [None, Some(0.9)] {
            let element = element(shear);
            let (l, e, force) = (element.length, element.young_modulus, 1e4);
            let inertia = pi / 64.0 * (0.2f64.powi(4) - 0.05f64.powi(4));
            let rigidity = shear.map(|k| k * e / 2.6 * pi / 4.0 * (0.04 - 0.0025));
            let beam = |z: f64| force * (z * z * (3.0 * l - z) / (6.0 * e * inertia) + rigidity.map_or(0.0, |r| z / r));
            let ends = [0.0, 0.0, beam(l), force * l * l / (2.0 * e * inertia)];
            for xi in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let (found, expected) = (deflection(&element, ends, xi), beam(xi * l));
                assert!((found - expected).abs() < 1e-12 * beam(l), "{shear:?} {xi}: {found} {expected}");
            }
        }
    }

    #[test]
    fn rigid_motions_cost_nothing_and_carry_the_section_s_inertia() {
        for shear in [None, Some(0.9)] {
            let e = element(shear);
            let b = shaft_blocks(&e);
            let area = std::f64::consts::PI / 4.0 * (0.2f64.powi(2) - 0.05f64.powi(2));
            let translation = Vector4::new(1.0, 0.0, 1.0, 0.0);
            let rotation = Vector4::new(0.0, 1.0, 0.7, 1.0);
            assert!((b.stiffness * translation).amax() < 1e-6 * b.stiffness.amax());
            assert!((b.stiffness * rotation).amax() < 1e-9 * b.stiffness.amax());
            let mass = 7850.0 * area * 0.7;
            assert!(((translation.transpose() * b.mass * translation)[0] / mass - 1.0).abs() < 1e-12);
            let polar = 7850.0 * std::f64::consts::PI / 32.0 * (0.2f64.powi(4) - 0.05f64.powi(4)) * 0.7;
            assert!(((rotation.transpose() * b.gyroscopic * rotation)[0] / polar - 1.0).abs() < 1e-12);
            let about_end = mass * 0.7 * 0.7 / 3.0 + polar / 2.0;
            assert!(((rotation.transpose() * b.mass * rotation)[0] / about_end - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_cantilever_deflects_by_bending_and_shear() {
        let e = element(Some(0.9));
        let k = shaft_blocks(&e).stiffness;
        let free = k.fixed_view::<2, 2>(2, 2).into_owned();
        let tip = free.try_inverse().expect("clamped")[(0, 0)];
        let inertia = std::f64::consts::PI / 64.0 * (0.2f64.powi(4) - 0.05f64.powi(4));
        let area = std::f64::consts::PI / 4.0 * (0.2f64.powi(2) - 0.05f64.powi(2));
        let expected = 0.7f64.powi(3) / (3.0 * 2.1e11 * inertia) + 0.7 / (0.9 * 2.1e11 / 2.6 * area);
        assert!((tip / expected - 1.0).abs() < 1e-11, "{tip} {expected}");
    }
}
