//! Mass matrices of a shaft element.
//!
//! ```text
//! M = rho S L/(840 (1+Phi)^2) M_t + rho I/(30 L (1+Phi)^2) M_r     in [w1, s1, w2, s2], deflection and slope of both ends      (1)
//! J = rho I_p L/6 [2 1; 1 2],  I_p = 2 I                           in [psi1, psi2]                                            (2)
//! Phi = 12 E I/(k G S L^2)                                         0 without shear deformation
//! ```
//! (1) is the consistent mass of the Timoshenko beam, translation and rotary inertia, with the static shape functions integrated in closed
//! form. The solver integrates the same functions numerically.
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), chapter 11. Verified by `what_a_node_has_is_that_of_the_matrices`
//! (`tests/rotor/lost_masses.rs` of the core) against that quadrature, and the tests below.

use crate::machine::model::ShaftElement;
use crate::machine::section::GAUSS5;

/// Mass matrix (1) [kg, kg m, kg m2]; for a tapered element by quadrature.
pub(super) fn element_mass(element: &ShaftElement) -> [[f64; 4]; 4] {
    let (l, rho) = (element.length, element.density);
    let phi = element.shear_parameter();
    if element.is_tapered() {
        let mut mass = [[0.0; 4]; 4];
        for (xi, weight) in GAUSS5 {
            let [w, s, _] = element.shapes(xi, phi);
            let (area, inertia) = (element.area_at(xi), element.inertia_at(xi));
            for (a, row) in mass.iter_mut().enumerate() {
                for (b, entry) in row.iter_mut().enumerate() {
                    *entry += rho * weight * l * (area * w[a] * w[b] + inertia * s[a] * s[b]);
                }
            }
        }
        return mass;
    }
    let (area, inertia) = (element.area_at(0.0), element.inertia_at(0.0));
    let squared = phi * phi;
    let scale = 1.0 / ((1.0 + phi) * (1.0 + phi));
    let (t, r) = (rho * area * l / 840.0 * scale, rho * inertia / (30.0 * l) * scale);

    let ww = t * (312.0 + 588.0 * phi + 280.0 * squared) + r * 36.0;
    let ws = (t * (44.0 + 77.0 * phi + 35.0 * squared) + r * (3.0 - 15.0 * phi)) * l;
    let ss = (t * (8.0 + 14.0 * phi + 7.0 * squared) + r * (4.0 + 5.0 * phi + 10.0 * squared)) * l * l;
    // coupling of the two ends
    let w_w = t * (108.0 + 252.0 * phi + 140.0 * squared) - r * 36.0;
    let w_s = (-t * (26.0 + 63.0 * phi + 35.0 * squared) + r * (3.0 - 15.0 * phi)) * l;
    let s_s = (-t * (6.0 + 14.0 * phi + 7.0 * squared) + r * (-1.0 - 5.0 * phi + 5.0 * squared)) * l * l;
    [[ww, ws, w_w, w_s], [ws, ss, -w_s, s_s], [w_w, -w_s, ww, -ws], [w_s, s_s, -ws, ss]]
}

/// Torsional mass matrix (2) \[kg m2\]; for a tapered element by quadrature.
pub(super) fn element_torsional_mass(element: &ShaftElement) -> [[f64; 2]; 2] {
    if element.is_tapered() {
        let mut mass = [[0.0; 2]; 2];
        for (xi, weight) in GAUSS5 {
            let polar = element.density * 2.0 * element.inertia_at(xi) * weight * element.length;
            let ends = [1.0 - xi, xi];
            (0..4).for_each(|i| mass[i / 2][i % 2] += polar * ends[i / 2] * ends[i % 2]);
        }
        return mass;
    }
    let third = element.density * 2.0 * element.inertia_at(0.0) * element.length / 3.0;
    [[third, third / 2.0], [third / 2.0, third]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn rigid_motions_carry_the_mass_and_the_inertia_of_a_rod() {
        for shear_coefficient in [None, Some(0.9)] {
            let element = ShaftElement {
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
            };
            let mass = element_mass(&element);
            let energy = |motion: [f64; 4]| -> f64 {
                (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).map(|(i, j)| motion[i] * mass[i][j] * motion[j]).sum()
            };
            let rod = 7850.0 * PI / 4.0 * (0.2f64.powi(2) - 0.05f64.powi(2)) * 0.7;
            assert!((energy([1.0, 0.0, 1.0, 0.0]) / rod - 1.0).abs() < 1e-12);
            // about a diameter at the end of a hollow rod: m (r_o^2 + r_i^2)/4 + m L^2/3
            let about_end = rod * ((0.1f64.powi(2) + 0.025f64.powi(2)) / 4.0 + 0.7 * 0.7 / 3.0);
            assert!((energy([0.0, 1.0, 0.7, 1.0]) / about_end - 1.0).abs() < 1e-12);
            let torsion: f64 = element_torsional_mass(&element).iter().flatten().sum();
            assert!((torsion / (rod * (0.1f64.powi(2) + 0.025f64.powi(2)) / 2.0) - 1.0).abs() < 1e-12);
        }
    }
}
