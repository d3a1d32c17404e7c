//! Largest moments and stresses of the shaft.

use super::peak::{At, Peak};
use super::row::Row;
use super::von_mises::VonMises;
use crate::stress::{ShaftStresses, equivalent_square};
use bladeoff_model::machine::RotorKind;
use bladeoff_model::outcome::Empty;
use bladeoff_numerics::linalg::Matrix;
use std::ops::Range;

/// Maximum number of shaft sections with columns of their own. The largest value over all sections is always reported.
const REPORTED_SECTIONS: usize = 12;

/// Recorder of the moments and stresses of every shaft section.
#[derive(Debug, Clone)]
pub(crate) struct StressRecorder {
    /// `None` for a point mass.
    shaft: Option<ShaftStresses>,
    /// Per section: largest |T| \[N m\].
    torsion: Vec<Peak>,
    /// Per section: largest |M|^2 [N2 m2]; the root is taken once, at the end.
    bending: Vec<Peak>,
    /// Per section: largest von Mises stress.
    mises: VonMises,
    /// Static response of the truncated modes; `None` without bearing seats off the bearing line.
    settled: Option<Settled>,
}

/// Constant part of the bending: static response of the truncated modes to the forces of bearing seats off the bearing line.
#[derive(Debug, Clone)]
struct Settled {
    /// Displacements and slopes of the nodes [m, rad].
    lateral: Vec<f64>,
    /// Bending moments of each element at both ends, in the order of [`StressRecorder::see_bending`] \[N m\].
    moments: Vec<[f64; 4]>,
    /// Larger norm of the bending moment at the two ends of each element \[N m\].
    sizes: Vec<f64>,
}

/// Torsional moment \[N m\], torsional shear stress, bending stress and von Mises stress \[Pa\] of a section.
#[derive(Default)]
struct Stresses {
    /// Torsional moment |T| \[N m\].
    moment: Peak,
    /// Torsional shear stress \[Pa\].
    shear: Peak,
    /// Bending stress \[Pa\].
    bending: Peak,
    /// Von Mises stress of bending and torsion \[Pa\].
    mises: Peak,
    /// Axial position of the largest von Mises stress \[m\].
    position: f64,
}

impl StressRecorder {
    pub fn new(rotor: &RotorKind) -> Self {
        let shaft = match rotor {
            RotorKind::Shaft(shaft) => Some(ShaftStresses::new(shaft)),
            RotorKind::PointMass(_) => None,
        };
        let none = vec![Peak::default(); shaft.as_ref().map_or(0, ShaftStresses::sections)];
        let mises = VonMises::new(rotor, shaft.as_ref());
        Self { shaft, torsion: none.clone(), bending: none, mises, settled: None }
    }

    /// Adds constant nodal displacements [m, rad], which no recorded instant includes.
    pub fn settle(&mut self, lateral: Vec<f64>) {
        let Some(shaft) = &self.shaft else { return };
        let moments: Vec<[f64; 4]> = (0..shaft.elements())
            .map(|element| {
                let [[a, b], [c, d]] = shaft.bending_moments(element, &lateral);
                [a, b, c, d]
            })
            .collect();
        let size = |[a, b, c, d]: &[f64; 4]| libm::hypot(*a, *b).max(libm::hypot(*c, *d));
        self.settled = Some(Settled { sizes: moments.iter().map(size).collect(), moments, lateral });
    }

    /// Largest constant bending moment of some elements \[N m\].
    fn settled_size(&self, elements: Range<usize>) -> f64 {
        self.settled.as_ref().map_or(0.0, |settled| settled.sizes[elements].iter().copied().fold(0.0, f64::max))
    }

    /// Records the stresses at nodal displacements `x` [m, rad] and torsion angles \[rad\] of the shaft line.
    pub fn see(&mut self, x: &[f64], torsion_angles: &[f64], at: At) {
        let Some(shaft) = &self.shaft else { return };
        let shifted: Vec<f64>;
        let x = match &self.settled {
            None => x,
            Some(settled) => {
                shifted = x.iter().zip(&settled.lateral).map(|(x, shift)| x + shift).collect();
                &shifted
            }
        };
        for section in 0..self.torsion.len() {
            let largest = shaft.largest(section, x, torsion_angles);
            self.torsion[section].see(largest.torsion, at);
            self.bending[section].see(largest.bending_square, at);
            self.mises.see(section, largest.equivalent_square, largest.node, at);
        }
    }

    /// Number of shaft elements.
    pub fn elements(&self) -> usize {
        self.shaft.as_ref().map_or(0, ShaftStresses::elements)
    }

    /// Torsional moments of all elements per unit amplitude of each torsional mode \[N m\], from the mode shapes at the nodes.
    pub fn torsional_rows(&self, mode_shapes: &[Vec<f64>]) -> Matrix {
        let modes = mode_shapes.first().map_or(0, Vec::len);
        Matrix::from_fn(self.elements(), modes, |element, mode| {
            let ends = [mode_shapes[element][mode], mode_shapes[element + 1][mode]];
            self.shaft.as_ref().map_or(0.0, |shaft| shaft.torsional_moment_between(element, ends))
        })
    }

    /// Records the torsional moments of all elements \[N m\].
    pub fn see_torsion(&mut self, moments: &[f64], at: At) {
        let Some(shaft) = &self.shaft else { return };
        for (moment, section) in moments.iter().zip(shaft.section_of()) {
            self.torsion[*section].see(moment.abs(), at);
        }
    }

    /// Returns whether bending moments up to `bound` \[N m\] can raise a maximum in the sections of some elements, with the torsional
    /// moments `torsion` \[N m\].
    #[inline(always)]
    pub fn asks_for_bending(&self, elements: Range<usize>, bound: f64, torsion: &[f64]) -> bool {
        let Some(shaft) = &self.shaft else { return false };
        let bound = bound + self.settled_size(elements.clone());
        let square = bound * bound;
        shaft.section_of()[elements].iter().zip(torsion).any(|(&section, &torsion)| {
            self.bending[section].value.is_none_or(|known| square > known)
                || self.mises.known(section).is_none_or(|known| equivalent_square(square, torsion) > known)
        })
    }

    /// Records bending and torsional moments of some elements at one instant \[N m\]: four bending components (two ends) and one torsional
    /// moment per element.
    #[inline(always)]
    pub fn see_bending(&mut self, elements: Range<usize>, moments: &[f64], torsion: &[f64], at: At) {
        let Self { shaft, bending, mises, settled, .. } = self;
        let Some(shaft) = shaft else { return };
        let sections = &shaft.section_of()[elements.clone()];
        for (element, ((m, &section), &torsion)) in
            elements.zip(moments.as_chunks::<4>().0.iter().zip(sections).zip(torsion))
        {
            let m = match settled {
                Some(settled) => std::array::from_fn(|i| m[i] + settled.moments[element][i]),
                None => *m,
            };
            // the torsional moment is the same at both ends
            let [near, far] = [m[0] * m[0] + m[1] * m[1], m[2] * m[2] + m[3] * m[3]];
            let (square, node) = if far > near { (far, element + 1) } else { (near, element) };
            bending[section].see(square, at);
            mises.see(section, equivalent_square(square, torsion), node, at);
        }
    }

    /// Largest ratio of von Mises stress to yield strength \[-\], each section with its own; `None` if no section has a yield strength.
    pub fn yield_ratio(&self) -> Option<Peak> {
        self.mises.yield_ratio()
    }

    /// Bound of that ratio \[-\] from bounds of the bending moments \[N m\] of groups of `together` elements, with the largest torsional
    /// moments so far.
    pub fn ratio_bound(&self, together: usize, bounds: &[f64]) -> f64 {
        let Some(shaft) = &self.shaft else { return 0.0 };
        let ratio = |section: usize, bound: f64| {
            let torsion = self.torsion[section].value.unwrap_or(0.0);
            self.mises.ratio_of(section, equivalent_square(bound * bound, torsion))
        };
        let blocks = shaft.section_of().chunks(together).zip(bounds).enumerate();
        let all = blocks.flat_map(|(block, (sections, &bound))| {
            let bound = bound + self.settled_size(block * together..block * together + sections.len());
            sections.iter().map(move |&section| (section, bound))
        });
        all.map(|(section, bound)| ratio(section, bound)).fold(0.0, f64::max)
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        self.torsion.iter_mut().chain(&mut self.bending).for_each(Peak::hold);
        self.mises.hold();
    }

    /// Largest torsional moment of all sections \[N m\].
    pub fn largest_torsion(&self) -> Option<f64> {
        self.torsion.iter().filter_map(|peak| peak.value).reduce(f64::max)
    }

    /// Largest moments and stresses of each section.
    fn sections(&self) -> Vec<Stresses> {
        let of = |shaft: &ShaftStresses, section: usize| {
            let (moment, moduli) = (self.torsion[section], shaft.moduli(section));
            Stresses {
                moment,
                shear: moment.map(|moment| moment / moduli.torsion),
                bending: self.bending[section].map(|square| square.sqrt() / moduli.bending),
                mises: self.mises.of(section).map(|square| square.sqrt() / moduli.bending),
                position: self.mises.position(section),
            }
        };
        self.shaft.iter().flat_map(|shaft| (0..self.torsion.len()).map(move |section| of(shaft, section))).collect()
    }

    pub(super) fn report(&self, row: &mut Row<'_>) {
        let sections = self.sections();
        let mut all = Stresses::default();
        for section in &sections {
            for (largest, peak) in [
                (&mut all.moment, &section.moment),
                (&mut all.shear, &section.shear),
                (&mut all.bending, &section.bending),
            ] {
                largest.include(peak);
            }
            if section.mises.value > all.mises.value {
                all.position = section.position;
            }
            all.mises.include(&section.mises);
        }
        let all = self.shaft.as_ref().map(|_| &all);
        let lacks = all.is_none().then_some("a shaft: `rotor.shaft`");
        row.with(Empty::Absent, lacks, |row| Stresses::report(all, None, row));
        for (i, section) in sections.iter().take(REPORTED_SECTIONS).enumerate() {
            Stresses::report(Some(section), Some(i), row);
        }
    }
}

impl Stresses {
    /// Reports the whole shaft (`section`: `None`) or one section. `of`: `None` for a point mass.
    fn report(of: Option<&Self>, section: Option<usize>, row: &mut Row<'_>) {
        let (suffix, place) = match section {
            None => (String::new(), "the shaft".to_owned()),
            Some(i) => (format!("_section{i}"), format!("shaft section {i} (from 0, in the order of the file)")),
        };
        let surface = format!("at the surface of {place}, nominal");
        for (name, unit, meaning, peak) in [
            ("torsional_moment", "N m", format!("largest torsional moment in {place}"), of.map(|s| s.moment)),
            ("shear_stress", "Pa", format!("largest torsional shear stress {surface}"), of.map(|s| s.shear)),
            ("bending_stress", "Pa", format!("largest bending stress {surface}"), of.map(|s| s.bending)),
        ] {
            let name = format!("max_{name}{suffix}");
            row.peak(name, unit, meaning, peak);
        }
        let name = format!("max_shaft_von_mises{suffix}");
        let meaning = format!("largest von Mises stress of bending and torsion at one instant {surface}");
        let mises = of.map(|s| s.mises);
        row.peak(&name, "Pa", meaning, mises);
        if section.is_some() {
            return;
        }
        let position = of.filter(|s| s.mises.value.is_some()).map(|s| s.position);
        row.real(format!("{name}_position_m"), "m", format!("place along the shaft of {name}_Pa"), position);
    }
}
