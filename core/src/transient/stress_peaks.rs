//! Largest moments and stresses of a run.

use super::monitor::Peak;
use crate::stress::{BladeStresses, ShaftStresses};
use crate::structure::Structure;
use bladeoff_model::machine::{DiaphragmKind, Machine, RotorKind};

/// Collector of one run.
#[derive(Debug, Clone)]
pub(crate) struct StressPeaks {
    shaft: Option<ShaftStresses>,
    blades: Option<BladeStresses>,
    /// Per section: |T|, and |M|^2 (one root at the end).
    torsion: Vec<Peak>,
    bending: Vec<Peak>,
    blade: Peak,
}

impl StressPeaks {
    pub fn new(machine: &Machine, structure: &Structure) -> Self {
        let shaft = match &machine.rotor.kind {
            RotorKind::Shaft(shaft) => Some(ShaftStresses::new(shaft)),
            RotorKind::PointMass(_) => None,
        };
        let ring = structure.rings.first().and_then(Option::as_ref);
        let blades = machine.diaphragms.first().zip(ring).and_then(|(diaphragm, ring)| match &diaphragm.kind {
            DiaphragmKind::Flexible(stator) => BladeStresses::new(stator, ring),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
        });
        let sections = shaft.as_ref().map_or(0, ShaftStresses::sections);
        let none = vec![Peak::default(); sections];
        // blades that nothing touches have a stress: none
        let blade = Peak { value: blades.as_ref().map(|_| 0.0), ..Peak::default() };
        Self { shaft, blades, torsion: none.clone(), bending: none, blade }
    }

    /// Displacements of the shaft line at n.
    pub fn shaft(&mut self, x: &[f64], twist: &[f64], time: f64, speed: f64) {
        let Some(shaft) = &self.shaft else { return };
        for section in 0..self.torsion.len() {
            let (torsion, bending) = shaft.largest(section, x, twist);
            self.torsion[section].see(torsion, time, speed);
            self.bending[section].see(bending, time, speed);
        }
    }

    /// Coordinates of the ring at n, once it moves.
    pub fn ring(&mut self, q: &[f64], time: f64, speed: f64) {
        if let Some(blades) = &self.blades
            && let Some(stress) = blades.above(self.blade.value.unwrap_or(0.0), q)
        {
            self.blade.see(stress, time, speed);
        }
    }

    /// Torsional moment \[N m\] and torsional shear stress \[Pa\] of a section.
    fn torsion_of(&self, section: usize) -> [Peak; 2] {
        let moment = self.torsion[section];
        let moduli = self.shaft.as_ref().map(|shaft| shaft.moduli(section).torsion);
        let stress = moment.value.zip(moduli).map(|(value, modulus)| value / modulus);
        [moment, Peak { value: stress, ..moment }]
    }

    /// Bending stress of a section \[Pa\].
    fn bending_of(&self, section: usize) -> Peak {
        let square = self.bending[section];
        let modulus = self.shaft.as_ref().map(|shaft| shaft.moduli(section).bending);
        let stress = square.value.zip(modulus).map(|(value, modulus)| value.sqrt() / modulus);
        Peak { value: stress, ..square }
    }

    /// The peak of a column named `base`: of one section (`..._section3`), or of all.
    pub fn peak(&self, base: &str) -> Option<Peak> {
        let (quantity, section) = match base.split_once("_section") {
            Some((quantity, section)) => (quantity, Some(section.parse::<usize>().ok()?)),
            None => (base, None),
        };
        let of: &dyn Fn(usize) -> Peak = match quantity {
            "max_torsional_moment" => &|section| self.torsion_of(section)[0],
            "max_shear_stress" => &|section| self.torsion_of(section)[1],
            "max_bending_stress" => &|section| self.bending_of(section),
            "max_blade_bending_stress" => return Some(self.blade),
            _ => return None,
        };
        match section {
            Some(section) => (section < self.torsion.len()).then(|| of(section)),
            None => {
                let mut all = Peak::default();
                for section in 0..self.torsion.len() {
                    let peak = of(section);
                    if let Some(value) = peak.value {
                        all.see(value, peak.time, peak.speed);
                    }
                }
                Some(all)
            }
        }
    }
}
