//! Cross-sections and shape functions along a shaft element.
//!
//! Diameters are linear between the ends. Shape functions are the static ones of a Timoshenko beam with the section at the middle of the element:
//!
//! ```text
//! Phi = 12 E I/(k G S L^2)          at the middle; 0 without shear deformation
//! S = pi/4 (D^2 - d^2),  I = pi/64 (D^4 - d^4)
//! ```
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), for a cylinder; Genta and Gugliotta, A conical element for finite element rotor
//! dynamics, J. Sound Vib. 120 (1988), for a taper. Verified by `tests/rotor/tapers.rs` of the core.

use std::f64::consts::PI;

use super::model::ShaftElement;

/// Abscissae and weights of the 5-point Gauss rule on [0, 1]: exact to degree 9, products along a tapered element reach 8.
pub const GAUSS5: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

impl ShaftElement {
    /// Whether the sections at both ends differ.
    #[must_use]
    pub fn is_tapered(&self) -> bool {
        self.end_diameter != self.diameter || self.end_inner_diameter != self.inner_diameter
    }

    /// Outer and inner diameter \[m\] at `xi = z/L`.
    #[must_use]
    pub fn diameters_at(&self, xi: f64) -> [f64; 2] {
        [
            self.diameter + xi * (self.end_diameter - self.diameter),
            self.inner_diameter + xi * (self.end_inner_diameter - self.inner_diameter),
        ]
    }

    /// Area \[m2\] at `xi`.
    #[must_use]
    pub fn area_at(&self, xi: f64) -> f64 {
        let [od, id] = self.diameters_at(xi);
        PI / 4.0 * (od * od - id * id)
    }

    /// Second moment of area about a diameter \[m4\] at `xi`.
    #[must_use]
    pub fn inertia_at(&self, xi: f64) -> f64 {
        let [od, id] = self.diameters_at(xi);
        PI / 64.0 * (od * od * od * od - id * id * id * id)
    }

    /// Mean area \[m2\]: Simpson's rule, exact because the area is a parabola.
    #[must_use]
    pub fn mean_area(&self) -> f64 {
        if !self.is_tapered() {
            return self.area_at(0.0);
        }
        (self.area_at(0.0) + 4.0 * self.area_at(0.5) + self.area_at(1.0)) / 6.0
    }

    /// Shear modulus \[Pa\].
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))
    }

    /// `Phi` at the middle, 0 without shear deformation.
    #[must_use]
    pub fn shear_parameter(&self) -> f64 {
        let (area, inertia, l) = (self.area_at(0.5), self.inertia_at(0.5), self.length);
        let rigidity = self.shear_coefficient.map(|k| k * self.shear_modulus() * area);
        rigidity.map_or(0.0, |rigidity| 12.0 * self.young_modulus * inertia / (rigidity * l * l))
    }

    /// Deflection, section angle and its derivative along z at `xi`, each as coefficients of `[w1, s1, w2, s2]` of both ends in one plane.
    #[must_use]
    pub fn shapes(&self, xi: f64, phi: f64) -> [[f64; 4]; 3] {
        let l = self.length;
        let (x2, x3, c) = (xi * xi, xi * xi * xi, 1.0 / (1.0 + phi));
        let bubble = 0.5 * phi * (xi - x2);
        let w = [
            c * (1.0 - 3.0 * x2 + 2.0 * x3 + phi * (1.0 - xi)),
            c * l * (xi - 2.0 * x2 + x3 + bubble),
            c * (3.0 * x2 - 2.0 * x3 + phi * xi),
            c * l * (x3 - x2 - bubble),
        ];
        let s = [
            c * 6.0 * (x2 - xi) / l,
            c * (1.0 - 4.0 * xi + 3.0 * x2 + phi * (1.0 - xi)),
            c * 6.0 * (xi - x2) / l,
            c * (3.0 * x2 - 2.0 * xi + phi * xi),
        ];
        let ds = [
            c * 6.0 * (2.0 * xi - 1.0) / (l * l),
            c * (6.0 * xi - 4.0 - phi) / l,
            c * 6.0 * (1.0 - 2.0 * xi) / (l * l),
            c * (6.0 * xi - 2.0 + phi) / l,
        ];
        [w, s, ds]
    }

    /// The part of the element between two fractions of its length, with a given length \[m\] and the same shear coefficient.
    #[must_use]
    pub fn part(&self, [from, to]: [f64; 2], length: f64) -> Self {
        let ([diameter, inner_diameter], [end_diameter, end_inner_diameter]) =
            (self.diameters_at(from), self.diameters_at(to));
        Self { length, diameter, inner_diameter, end_diameter, end_inner_diameter, ..*self }
    }
}
