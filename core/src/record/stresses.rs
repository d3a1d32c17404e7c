//! Largest moments and stresses of the shaft and of the blades of a ring.

use super::peak::{At, Peak};
use super::row::Row;
use crate::stress::{BladeStresses, ShaftStresses};
use crate::structure::RingPart;
use bladeoff_model::machine::{DiaphragmKind, RotorKind};
use bladeoff_model::outcome::MAX_COLUMNS;
use std::fmt::Display;

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
                if let Some(value) = peak.value {
                    largest.see(value, peak.at);
                }
            }
        }
        all.report("", "the shaft", row);
        let room = MAX_COLUMNS.saturating_sub(row.len()) / SECTION_COLUMNS;
        for (i, section) in sections.iter().take(REPORTED_SECTIONS.min(room)).enumerate() {
            let of = format_args!("shaft section {i} (from 0, in the order of the file)");
            section.report(format_args!("_section{i}"), of, row);
        }
    }
}

impl Stresses {
    fn report(&self, place: impl Display, of: impl Display, row: &mut Row<'_>) {
        row.peak(
            format_args!("max_torsional_moment{place}"),
            "N m",
            format_args!("largest torsional moment in {of}"),
            self.moment,
        );
        row.peak(
            format_args!("max_shear_stress{place}"),
            "Pa",
            format_args!("largest torsional shear stress at the surface of {of}, nominal"),
            self.shear,
        );
        row.peak(
            format_args!("max_bending_stress{place}"),
            "Pa",
            format_args!("largest bending stress at the surface of {of}, nominal"),
            self.bending,
        );
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

    pub(super) fn report(of: Option<&Self>, row: &mut Row<'_>) {
        row.peak(
            "max_blade_bending_stress",
            "Pa",
            "largest bending stress in a blade of the diaphragm, nominal",
            of.map(|blades| blades.stress),
        );
    }
}
