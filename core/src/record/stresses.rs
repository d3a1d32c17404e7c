//! Largest moments and stresses of the shaft and of the blades of a ring.

use super::peak::{At, Peak};
use super::row::Row;
use crate::linalg::Matrix;
use crate::stress::{BladeStresses, ShaftStresses};
use crate::structure::RingPart;
use bladeoff_model::machine::{DiaphragmKind, RotorKind};
use bladeoff_model::outcome::MAX_COLUMNS;
use std::ops::Range;

/// Shaft sections with columns of their own at most; the largest over all sections is always there.
const REPORTED_SECTIONS: usize = 12;
/// Columns of one section: three peaks.
const SECTION_COLUMNS: usize = 9;

/// Watches every section of the shaft.
#[derive(Debug, Clone)]
pub(crate) struct StressRecorder {
    /// `None` for a point mass.
    shaft: Option<ShaftStresses>,
    /// Per section: |T|, and |M|^2 (one root at the end).
    torsion: Vec<Peak>,
    bending: Vec<Peak>,
}

/// Torsional moment \[N m\], torsional shear stress and bending stress \[Pa\].
#[derive(Default)]
struct Stresses {
    moment: Peak,
    shear: Peak,
    bending: Peak,
}

impl StressRecorder {
    pub fn new(rotor: &RotorKind) -> Self {
        let shaft = match rotor {
            RotorKind::Shaft(shaft) => Some(ShaftStresses::new(shaft)),
            RotorKind::PointMass(_) => None,
        };
        let none = vec![Peak::default(); shaft.as_ref().map_or(0, ShaftStresses::sections)];
        Self { shaft, torsion: none.clone(), bending: none }
    }

    /// Nodal displacements [m, rad] and twists \[rad\] of the shaft line.
    pub fn see(&mut self, x: &[f64], twist: &[f64], at: At) {
        let Some(shaft) = &self.shaft else { return };
        for section in 0..self.torsion.len() {
            let (torsion, bending) = shaft.largest(section, x, twist);
            self.torsion[section].see(torsion, at);
            self.bending[section].see(bending, at);
        }
    }

    /// Elements of the shaft.
    pub fn elements(&self) -> usize {
        self.shaft.as_ref().map_or(0, ShaftStresses::elements)
    }

    /// Torsional moments of all elements per unit of modes of twist, whose shapes are given node by node.
    pub fn torsional_rows(&self, twists: &[Vec<f64>]) -> Matrix {
        let modes = twists.first().map_or(0, Vec::len);
        Matrix::from_fn(self.elements(), modes, |element, mode| {
            let ends = [twists[element][mode], twists[element + 1][mode]];
            self.shaft.as_ref().map_or(0.0, |shaft| shaft.torsional_moment_between(element, ends))
        })
    }

    /// Torsional moments of all elements \[N m\].
    pub fn see_torsion(&mut self, moments: &[f64], at: At) {
        let Some(shaft) = &self.shaft else { return };
        for (moment, section) in moments.iter().zip(shaft.section_of()) {
            self.torsion[*section].see(moment.abs(), at);
        }
    }

    /// The least of the largest |M| of the sections of some elements; below all numbers before there is any.
    pub fn least_bending(&self, elements: Range<usize>) -> f64 {
        let Some(shaft) = &self.shaft else { return f64::INFINITY };
        let squares = shaft.section_of()[elements].iter().map(|&section| self.bending[section].value);
        squares
            .min_by(|one, other| one.unwrap_or(-1.0).total_cmp(&other.unwrap_or(-1.0)))
            .map_or(f64::INFINITY, |least| least.map_or(f64::NEG_INFINITY, f64::sqrt))
    }

    /// Bending moments of some elements \[N m\], four each.
    pub fn see_bending(&mut self, elements: Range<usize>, moments: &[f64], at: At) {
        let Some(shaft) = &self.shaft else { return };
        for (m, section) in moments.as_chunks::<4>().0.iter().zip(&shaft.section_of()[elements]) {
            for [x, y] in [[m[0], m[1]], [m[2], m[3]]] {
                self.bending[*section].see(x * x + y * y, at);
            }
        }
    }

    /// All guards hold.
    pub fn hold(&mut self) {
        self.torsion.iter_mut().chain(&mut self.bending).for_each(Peak::hold);
    }

    /// Largest torsional moment of all sections \[N m\].
    pub fn largest_torsion(&self) -> Option<f64> {
        self.torsion.iter().filter_map(|peak| peak.value).reduce(f64::max)
    }

    /// Of each section.
    fn sections(&self) -> Vec<Stresses> {
        let of = |shaft: &ShaftStresses, section: usize| {
            let (moment, moduli) = (self.torsion[section], shaft.moduli(section));
            Stresses {
                moment,
                shear: moment.map(|moment| moment / moduli.torsion),
                bending: self.bending[section].map(|square| square.sqrt() / moduli.bending),
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
        }
        let all = self.shaft.as_ref().map(|_| &all);
        Stresses::report(all, None, row);
        let room = MAX_COLUMNS.saturating_sub(row.len()) / SECTION_COLUMNS;
        for (i, section) in sections.iter().take(REPORTED_SECTIONS.min(room)).enumerate() {
            Stresses::report(Some(section), Some(i), row);
        }
    }
}

impl Stresses {
    /// Of the whole shaft, or of one section; `of` is `None` for a rotor without any.
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
            match section {
                None => row.peak(name, unit, meaning, peak),
                Some(_) => row.peak_of_one(name, unit, meaning, peak),
            }
        }
    }
}

/// Watches the blades of one ring.
#[derive(Debug, Clone)]
pub(crate) struct BladeRecorder {
    blades: Option<BladeStresses>,
    stress: Peak,
}

impl BladeRecorder {
    pub fn new(kind: &DiaphragmKind, part: Option<&RingPart>) -> Self {
        let blades = part.and_then(|part| match kind {
            DiaphragmKind::Flexible(stator) => BladeStresses::new(stator, part),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
        });
        // blades that nothing touches have a stress: none
        let stress = if blades.is_some() { Peak::at_start(0.0) } else { Peak::default() };
        Self { blades, stress }
    }

    /// Coordinates of the ring.
    pub fn see(&mut self, q: &[f64], at: At) {
        if let Some(blades) = &self.blades
            && let Some(stress) = blades.above(self.stress.value.unwrap_or(0.0), q)
        {
            self.stress.see(stress, at);
        }
    }

    /// All guards hold.
    pub fn hold(&mut self) {
        self.stress.hold();
    }

    pub(super) fn report(of: Option<&Self>, row: &mut Row<'_>) {
        row.peak(
            "max_blade_bending_stress",
            "Pa",
            "largest bending stress in a blade of the diaphragm, nominal",
            of.filter(|blades| blades.blades.is_some()).map(|blades| blades.stress),
        );
    }
}
