//! Torsional and bending moments of the shaft elements, and the nominal stresses that they cause.

use bladeoff_model::machine::{Shaft, ShaftElement};

use crate::rotor::shaft_blocks;

/// Section moduli of a circular section with outer diameter D and inner diameter d.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionModuli {
    /// Bending modulus `W_b = pi (D^4 - d^4)/(32 D)` \[m3\]: the bending stress is `M/W_b`.
    pub bending: f64,
    /// Torsional modulus `W_t = 2 W_b` \[m3\]: the torsional shear stress is `T/W_t`.
    pub torsion: f64,
}

/// Squared equivalent moment `M_v^2 = M^2 + 3/4 T^2` of a circular section [N2 m2]; its von Mises stress is `M_v/W_b`.
#[inline]
#[must_use]
pub fn equivalent_square(bending_square: f64, torsion: f64) -> f64 {
    bending_square + 0.75 * (torsion * torsion)
}

/// Largest moments of a section at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LargestMoments {
    /// Largest magnitude of the torsional moment `|T|` \[N m\].
    pub torsion: f64,
    /// Largest squared bending moment `|M|^2` [N2 m2].
    pub bending_square: f64,
    /// Largest squared equivalent moment [N2 m2], see [`equivalent_square`].
    pub equivalent_square: f64,
    /// Node of the largest equivalent moment.
    pub node: usize,
}

/// Coefficients from the displacements of one element to its moments.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Element {
    /// Torsional stiffness `G I_p/L` [N m/rad].
    torsion: f64,
    /// Coefficient of the deflection difference `6 E I/((1+Phi) L^2)` \[N\], at each end.
    chord: [f64; 2],
    /// Coefficient of the slope at the same end `(4+Phi) E I/((1+Phi) L)` [N m/rad], at each end.
    near: [f64; 2],
    /// Coefficient of the slope at the other end `(2-Phi) E I/((1+Phi) L)` [N m/rad].
    far: f64,
}

/// Recovery of the moments of a shaft line from its nodal displacements.
///
/// ```text
/// T = G I_p (beta_2 - beta_1)/L                                                          constant in an element
/// M = E I dS/dz,  at its ends:
/// M_1 =  6 E I (w_2 - w_1)/((1+Phi) L^2) - E I [(4+Phi) s_1 + (2-Phi) s_2]/((1+Phi) L)
/// M_2 = -6 E I (w_2 - w_1)/((1+Phi) L^2) + E I [(2-Phi) s_1 + (4+Phi) s_2]/((1+Phi) L)
/// |M| = sqrt(M_x^2 + M_y^2)                       [w, s] = [u, theta_v] in XZ, [v, -theta_u] in YZ
/// tau = |T|/W_t,  sigma = |M|/W_b
/// sigma_v = sqrt(sigma^2 + 3 tau^2) = M_v/W_b,  M_v^2 = M^2 + 3/4 T^2,  as W_t = 2 W_b           von Mises, at the surface, of one instant
/// ```
/// beta: torsion angle, w: deflection, s: slope of the section, S: slope along the element, z: axial coordinate. Source: the element's own
/// strain energy ((4) of the paper; [`crate::rotor::shaft_blocks`]). M varies linearly along an element, so its largest norm is at an end.
/// Deviation: none; the paper reports no stresses.
///
/// # Units
/// SI.
/// # Limits
/// Nominal stresses of a tapered section are upper bounds: its largest moments over its smallest moduli. A section below a layer has only
/// its own share of the moments. `tau` is torsional shear only: the transverse shear stress, which is zero at the outer fibre, is excluded.
/// Loads inside an element (its own inertia and weight) act through its nodes, so M has an error of `q L^2/12` for a load q per length;
/// refine the mesh where that matters. In the reduced engine, moments near the contact lack the truncated modes.
/// # Verified by
/// `a_cantilever_has_its_textbook_moment`, `a_twisted_bar_has_its_textbook_stress`,
/// `bending_and_torsion_make_the_von_mises_stress_of_a_point`, `tests/runs/stresses.rs`
#[derive(Debug, Clone, PartialEq)]
pub struct ShaftStresses {
    /// Coefficients of each element.
    elements: Vec<Element>,
    /// Element range of each section: first, and one past the last.
    sections: Vec<(usize, usize)>,
    /// Section of each element.
    section_of: Vec<usize>,
    /// Smallest section moduli of each section \[m3\].
    moduli: Vec<SectionModuli>,
}

impl SectionModuli {
    /// Returns the smaller moduli of the two ends of an element.
    #[must_use]
    pub fn of(element: &ShaftElement) -> Self {
        let [left, right] = [0.0, 1.0].map(|xi| Self::of_ring(element.diameters_at(xi)));
        if right.bending < left.bending { right } else { left }
    }

    fn of_ring([od, id]: [f64; 2]) -> Self {
        let bending = std::f64::consts::PI * (od * od * od * od - id * id * id * id) / (32.0 * od);
        Self { bending, torsion: 2.0 * bending }
    }
}

impl ShaftStresses {
    /// Prepares the recovery for a shaft with the displacements in the order of [`crate::rotor::RotorMatrices`].
    #[must_use]
    pub fn new(shaft: &Shaft) -> Self {
        let mut all = Self { elements: Vec::new(), sections: Vec::new(), section_of: Vec::new(), moduli: Vec::new() };
        let mut last = None;
        for (i, element) in shaft.elements.iter().enumerate() {
            all.elements.push(Element::new(element));
            if last != Some(element.section) {
                all.sections.push((i, i));
                all.moduli.push(SectionModuli::of(element));
                last = Some(element.section);
            }
            let moduli = SectionModuli::of(element);
            if let Some(least) = all.moduli.last_mut()
                && moduli.bending < least.bending
            {
                *least = moduli;
            }
            if let Some(section) = all.sections.last_mut() {
                section.1 = i + 1;
            }
            all.section_of.push(all.sections.len() - 1);
        }
        all
    }

    /// Number of sections.
    #[must_use]
    pub fn sections(&self) -> usize {
        self.sections.len()
    }

    /// Number of elements.
    #[must_use]
    pub fn elements(&self) -> usize {
        self.elements.len()
    }

    /// Index of the section of each element.
    #[must_use]
    pub fn section_of(&self) -> &[usize] {
        &self.section_of
    }

    /// Section moduli of a section; the smallest of its elements.
    #[must_use]
    pub fn moduli(&self, section: usize) -> SectionModuli {
        self.moduli[section]
    }

    /// Torsional moment of an element \[N m\] from the torsion angles of all nodes \[rad\], positive for an increasing angle along the
    /// shaft.
    #[must_use]
    pub fn torsional_moment(&self, element: usize, torsion_angles: &[f64]) -> f64 {
        self.elements[element].torsional_moment(&torsion_angles[element..element + 2])
    }

    /// Torsional moment of an element \[N m\] from the torsion angles of its two nodes \[rad\].
    #[must_use]
    pub fn torsional_moment_between(&self, element: usize, torsion_angles: [f64; 2]) -> f64 {
        self.elements[element].torsional_moment(&torsion_angles)
    }

    /// Bending moments at both ends of an element, in the planes XZ and YZ \[N m\], from the lateral displacements [m, rad].
    #[must_use]
    pub fn bending_moments(&self, element: usize, x: &[f64]) -> [[f64; 2]; 2] {
        let (xz, yz) = (2 * element, self.plane_size() + 2 * element);
        self.elements[element].bending_moments(&x[xz..xz + 4], &x[yz..yz + 4])
    }

    /// Number of nodal degrees of freedom per bending plane. Those of XZ come first, then those of YZ, then those of the pedestals.
    fn plane_size(&self) -> usize {
        2 * (self.elements.len() + 1)
    }

    /// Largest moments of a section, from lateral displacements [m, rad] and torsion angles \[rad\].
    #[must_use]
    pub fn largest(&self, section: usize, x: &[f64], torsion_angles: &[f64]) -> LargestMoments {
        let (from, to) = self.sections[section];
        // neighbouring elements share a node: sliding windows avoid bounds checks inside the loop
        let (xz, yz) = x.split_at(self.plane_size());
        let span = 2 * from..2 * to + 2;
        let (xz, yz) = (xz[span.clone()].windows(4).step_by(2), yz[span].windows(4).step_by(2));
        let nodes = xz.zip(yz).zip(torsion_angles[from..=to].windows(2));
        let mut largest = LargestMoments { node: from, ..LargestMoments::default() };
        for (i, (element, ((a, b), angles))) in self.elements[from..to].iter().zip(nodes).enumerate() {
            let torsion = element.torsional_moment(angles);
            largest.torsion = larger(largest.torsion, torsion.abs());
            for (end, m) in element.bending_moments(a, b).into_iter().enumerate() {
                let square = m[0] * m[0] + m[1] * m[1];
                largest.bending_square = larger(largest.bending_square, square);
                let equivalent = equivalent_square(square, torsion);
                if equivalent > largest.equivalent_square {
                    (largest.equivalent_square, largest.node) = (equivalent, from + i + end);
                }
            }
        }
        largest
    }
}

/// Larger of two values; a NaN is ignored, because it ends the run anyway.
#[inline]
fn larger(known: f64, value: f64) -> f64 {
    if value > known { value } else { known }
}

impl Element {
    fn new(element: &ShaftElement) -> Self {
        if element.is_tapered() {
            return Self::tapered(element);
        }
        let l = element.length;
        let (od, id) = (element.diameter, element.inner_diameter);
        let inertia = std::f64::consts::PI / 64.0 * (od * od * od * od - id * id * id * id);
        let area = std::f64::consts::PI / 4.0 * (od * od - id * id);
        let g = element.young_modulus / (2.0 * (1.0 + element.poisson_ratio));
        let rigidity = element.young_modulus * inertia;
        let phi = element.shear_coefficient.map_or(0.0, |k| 12.0 * rigidity / (k * g * area * l * l));
        let scale = rigidity / ((1.0 + phi) * l);
        Self {
            torsion: g * 2.0 * inertia / l,
            chord: [6.0 * scale / l; 2],
            near: [(4.0 + phi) * scale; 2],
            far: (2.0 - phi) * scale,
        }
    }

    /// Uses rows of the stiffness matrix of a tapered element, so that the moments are in equilibrium with its nodal forces.
    fn tapered(element: &ShaftElement) -> Self {
        let blocks = shaft_blocks(element);
        let k = &blocks.stiffness;
        Self {
            torsion: blocks.torsional_stiffness[(0, 0)],
            chord: [k[(1, 0)], k[(3, 0)]],
            near: [k[(1, 1)], k[(3, 3)]],
            far: k[(1, 3)],
        }
    }

    #[inline]
    fn torsional_moment(&self, torsion_angles: &[f64]) -> f64 {
        self.torsion * (torsion_angles[1] - torsion_angles[0])
    }

    /// Bending moments from `[u1, theta_v1, u2, theta_v2]` and `[v1, theta_u1, v2, theta_u2]`; the slope of the YZ plane is `-theta_u`.
    #[inline]
    fn bending_moments(&self, a: &[f64], b: &[f64]) -> [[f64; 2]; 2] {
        let (x, y) = (a[2] - a[0], b[2] - b[0]);
        let ([left, right], [near, far_end], far) = (self.chord, self.near, self.far);
        [
            [left * x - near * a[1] - far * a[3], left * y + near * b[1] + far * b[3]],
            [far * a[1] + far_end * a[3] - right * x, -far * b[1] - far_end * b[3] - right * y],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotor::RotorMatrices;
    use bladeoff_model::machine::{Rayleigh, Rotor, RotorKind};

    /// Two sections of different diameter, four elements of 0.25 m.
    fn shaft(shear: Option<f64>) -> Shaft {
        let element = |section: usize| ShaftElement {
            length: 0.25,
            diameter: if section == 0 { 0.1 } else { 0.08 },
            inner_diameter: 0.02,
            end_diameter: if section == 0 { 0.1 } else { 0.08 },
            end_inner_diameter: 0.02,
            young_modulus: 2.1e11,
            poisson_ratio: 0.3,
            density: 7850.0,
            shear_coefficient: shear,
            yield_strength: None,
            section,
        };
        Shaft {
            nodes: vec![0.0, 0.25, 0.5, 0.75, 1.0],
            elements: vec![element(0), element(0), element(1), element(1)],
            layers: Vec::new(),
            discs: Vec::new(),
        }
    }

    fn matrices(shaft: &Shaft) -> RotorMatrices {
        RotorMatrices::assemble(&Rotor {
            kind: RotorKind::Shaft(shaft.clone()),
            initial_speed: 0.0,
            gravity: [0.0; 2],
            speed_law: None,
            initial: bladeoff_model::machine::InitialState::default(),
            bearings: Vec::new(),
            unbalances: Vec::new(),
            damping: Rayleigh::default(),
            torsional_damping: 0.0,
        })
    }

    /// Displacements with fixed degrees of freedom `fixed`.
    fn clamped(stiffness: &bladeoff_numerics::linalg::Matrix, fixed: &[usize], force: &[f64]) -> Vec<f64> {
        let free: Vec<usize> = (0..force.len()).filter(|i| !fixed.contains(i)).collect();
        let k =
            bladeoff_numerics::linalg::Matrix::from_fn(free.len(), free.len(), |i, j| stiffness[(free[i], free[j])]);
        let f = bladeoff_numerics::linalg::Vector::from_iterator(free.len(), free.iter().map(|&i| force[i]));
        let solution = bladeoff_numerics::linalg::solve(&k, &f).expect("clamped");
        let mut x = vec![0.0; force.len()];
        for (value, &i) in solution.iter().zip(&free) {
            x[i] = *value;
        }
        x
    }

    #[test]
    fn a_cantilever_has_its_textbook_moment() {
        for shear in [None, Some(0.9)] {
            let shaft = shaft(shear);
            let rotor = matrices(&shaft);
            let stresses = ShaftStresses::new(&shaft);
            let fixed = [0, 1, rotor.v(0), rotor.v(0) + 1];
            let mut force = vec![0.0; rotor.lateral_size()];
            rotor.add_at(4, [300.0, -400.0], &mut force);
            let x = clamped(&rotor.stiffness, &fixed, &force);
            for element in 0..4 {
                let ends = stresses.bending_moments(element, &x);
                for (end, moment) in ends.iter().enumerate() {
                    let arm = 1.0 - 0.25 * (element + end) as f64;
                    let norm = (moment[0] * moment[0] + moment[1] * moment[1]).sqrt();
                    assert!((norm - 500.0 * arm).abs() < 1e-6, "element {element} end {end}: {norm}");
                    // the plane of the moment is that of the force
                    assert!((moment[0] * -400.0 - moment[1] * 300.0).abs() < 1e-3);
                }
            }
            let square = stresses.largest(0, &x, &[0.0; 5]).bending_square;
            let stress = square.sqrt() / stresses.moduli(0).bending;
            let pi = std::f64::consts::PI;
            let expected = 500.0 * 0.05 / (pi / 64.0 * (0.1f64.powi(4) - 0.02f64.powi(4)));
            assert!((stress / expected - 1.0).abs() < 1e-9);
            let square = stresses.largest(1, &x, &[0.0; 5]).bending_square;
            assert!((square.sqrt() - 250.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_twisted_bar_has_its_textbook_stress() {
        let shaft = shaft(Some(0.9));
        let rotor = matrices(&shaft);
        let stresses = ShaftStresses::new(&shaft);
        let mut torque = vec![0.0; 5];
        torque[4] = 1000.0;
        let torsion_angles = clamped(&rotor.torsional_stiffness, &[0], &torque);
        let pi = std::f64::consts::PI;
        for (section, diameter) in [(0, 0.1f64), (1, 0.08)] {
            let moment = stresses.largest(section, &[0.0; 20], &torsion_angles).torsion;
            assert!((moment - 1000.0).abs() < 1e-8);
            let polar = pi / 32.0 * (diameter.powi(4) - 0.02f64.powi(4));
            let expected = 1000.0 * 0.5 * diameter / polar;
            assert!((moment / stresses.moduli(section).torsion / expected - 1.0).abs() < 1e-9);
        }
    }

    /// A cantilever under a tip force and a torque: textbook sigma and tau at the clamp and at the diameter step.
    #[test]
    fn bending_and_torsion_make_the_von_mises_stress_of_a_point() {
        let shaft = shaft(Some(0.9));
        let rotor = matrices(&shaft);
        let stresses = ShaftStresses::new(&shaft);
        let mut force = vec![0.0; rotor.lateral_size()];
        rotor.add_at(4, [300.0, -400.0], &mut force);
        let x = clamped(&rotor.stiffness, &[0, 1, rotor.v(0), rotor.v(0) + 1], &force);
        let mut torque = vec![0.0; 5];
        torque[4] = 700.0;
        let torsion_angles = clamped(&rotor.torsional_stiffness, &[0], &torque);
        for (section, diameter, arm, node) in [(0, 0.1f64, 1.0, 0), (1, 0.08, 0.5, 2)] {
            let inertia = std::f64::consts::PI / 64.0 * (diameter.powi(4) - 0.02f64.powi(4));
            let sigma = 500.0 * arm * 0.5 * diameter / inertia;
            let tau = 700.0 * 0.5 * diameter / (2.0 * inertia);
            let largest = stresses.largest(section, &x, &torsion_angles);
            let found = largest.equivalent_square.sqrt() / stresses.moduli(section).bending;
            assert!((found / (sigma * sigma + 3.0 * tau * tau).sqrt() - 1.0).abs() < 1e-8, "{section}: {found}");
            assert_eq!(largest.node, node);
        }
    }

    #[test]
    fn a_rigid_motion_has_no_moment() {
        let shaft = shaft(Some(0.9));
        let rotor = matrices(&shaft);
        let stresses = ShaftStresses::new(&shaft);
        let mut x = rotor.uniform([1e-3, -2e-3]);
        for node in 0..5 {
            // a small rotation about X and Y
            let z = 0.25 * node as f64;
            rotor.add_at(node, [1e-3 * z, 2e-3 * z], &mut x);
            x[rotor.u(node) + 1] += 1e-3;
            x[rotor.v(node) + 1] -= 2e-3;
        }
        let largest = stresses.largest(0, &x, &[0.3; 5]);
        assert_eq!(largest.torsion, 0.0);
        assert!(largest.equivalent_square.sqrt() < 1e-6, "{largest:?}");
    }
}
