//! Largest stresses of one diaphragm, in its ring and in its blades.

use super::peak::{At, Peak};
use super::row::{FLEXIBLE, Row};
use crate::stator::NodalForces;
use crate::stress::{Known, RingStresses};
use crate::structure::RingPart;
use bladeoff_model::machine::{DiaphragmKind, FlexibleStator};
use bladeoff_model::outcome::Empty;

/// Part that a machine needs for blade stresses.
const BLADES: &str = "a diaphragm with blades";

/// State of a flexible ring at an instant, which determines its stresses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RingState<'a> {
    /// Coordinates of the ring: nodal \[m\] or modal.
    pub coordinates: &'a [f64],
    /// Contact forces \[N\], to which the truncated modes respond statically; unused without truncated modes.
    pub forces: &'a NodalForces,
}

/// Recorder of the stresses of one diaphragm's ring and blades.
#[derive(Debug, Clone)]
pub(crate) struct RingStressRecorder {
    /// Stress recovery; `None` without a flexible ring.
    stresses: Option<RingStresses>,
    /// Yield strength of ring and blades \[Pa\].
    yield_strength: Option<f64>,
    /// Largest stress of the ring \[Pa\].
    ring: Peak,
    /// Angular position of the largest ring stress \[rad\].
    angle: f64,
    /// Largest stress of the blades, bending and axial \[Pa\].
    blades: Peak,
    /// Number of the blade with the largest stress, from 0.
    blade: usize,
    /// Largest bending stress of the blades, without axial stress \[Pa\].
    bending: Peak,
    has_ring: bool,
    has_blades: bool,
    /// Part without which the machine has no stresses of the ring, and of the blades. The columns of a machine are listed without its
    /// matrices.
    lacks: [Option<&'static str>; 2],
}

impl RingStressRecorder {
    pub fn new(kind: &DiaphragmKind, part: Option<&RingPart>) -> Self {
        let flexible: Option<(&FlexibleStator, &RingPart)> = part.and_then(|part| match kind {
            DiaphragmKind::Flexible(stator) => Some((stator, part)),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
        });
        let lacks = match kind {
            DiaphragmKind::Flexible(stator) => [None, stator.blades.is_none().then_some(BLADES)],
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => [Some(FLEXIBLE), Some(BLADES)],
        };
        let stresses = flexible.map(|(stator, part)| RingStresses::of(stator, part));
        let has_blades = stresses.as_ref().is_some_and(RingStresses::has_blades);
        // a part without contact has the stress zero
        let start = |is_there: bool| if is_there { Peak::at_start(0.0) } else { Peak::default() };
        Self {
            yield_strength: flexible.and_then(|(stator, _)| stator.yield_strength),
            ring: start(stresses.is_some()),
            angle: 0.0,
            blades: start(has_blades),
            blade: 0,
            bending: start(has_blades),
            has_ring: stresses.is_some(),
            has_blades,
            lacks,
            stresses,
        }
    }

    /// Records the state of the ring.
    pub fn see(&mut self, ring: RingState<'_>, at: At) {
        self.see_above(&self.known(), ring, at);
    }

    /// Returns whether coordinates up to these amplitudes cannot raise a maximum stress.
    pub fn rests(&mut self, amplitudes: &[f64]) -> bool {
        let known = self.known();
        self.stresses.as_mut().is_none_or(|stresses| stresses.are_below(&known, amplitudes))
    }

    /// Largest stresses so far \[Pa\].
    fn known(&self) -> Known {
        let known = |peak: &Peak| peak.value.unwrap_or(0.0);
        Known { ring: known(&self.ring), blades: known(&self.blades), bending: known(&self.bending) }
    }

    /// Records the state of the ring if stresses of ring or blades exceed the given ratios to the yield strength.
    pub fn watch(&mut self, [ring, blades]: [f64; 2], state: RingState<'_>, at: At) {
        let Some(strength) = self.yield_strength else { return };
        let known = |peak: &Peak, ratio: f64| peak.value.unwrap_or(0.0).max(ratio * strength);
        let known =
            Known { ring: known(&self.ring, ring), blades: known(&self.blades, blades), bending: f64::INFINITY };
        self.see_above(&known, state, at);
    }

    fn see_above(&mut self, known: &Known, ring: RingState<'_>, at: At) {
        let Some(stresses) = &mut self.stresses else { return };
        let RingState { coordinates, forces } = ring;
        let largest = stresses.above(known, coordinates, forces);
        if let Some(stress) = largest.ring.filter(|stress| *stress > known.ring) {
            self.ring.see(stress, at);
            self.angle = stresses.angle_of(stress, coordinates, forces);
        }
        if let Some(stress) = largest.blades.filter(|stress| *stress > known.blades) {
            self.blades.see(stress, at);
            self.blade = stresses.blade_of(stress, coordinates, forces);
        }
        if let Some(stress) = largest.bending {
            self.bending.see(stress, at);
        }
    }

    /// Largest ratios of stress to yield strength of ring and blades \[-\]; `None` if the material has no yield strength or the diaphragm
    /// lacks the part.
    pub fn yield_ratios(&self) -> [Option<Peak>; 2] {
        let of = |peak: Peak| self.yield_strength.map(|strength| peak.map(|stress| stress / strength));
        [of(self.ring).filter(|_| self.stresses.is_some()), of(self.blades).filter(|_| self.has_blades)]
    }

    /// Bounds of those ratios \[-\], for coordinates or for bounds of their amplitudes; 0 without a yield strength.
    pub fn ratio_bounds(&mut self, amplitudes: &[f64]) -> [f64; 2] {
        match (&mut self.stresses, self.yield_strength) {
            (Some(stresses), Some(strength)) => stresses.bounds(amplitudes).map(|bound| bound / strength),
            _ => [0.0; 2],
        }
    }

    /// Merges the larger stresses of another ring.
    pub fn include(&mut self, other: &Self) {
        if other.ring.value > self.ring.value {
            self.angle = other.angle;
        }
        if other.blades.value > self.blades.value {
            self.blade = other.blade;
        }
        self.ring.include(&other.ring);
        self.blades.include(&other.blades);
        self.bending.include(&other.bending);
        self.has_blades |= other.has_blades;
        self.has_ring |= other.has_ring;
        for (own, others) in self.lacks.iter_mut().zip(other.lacks) {
            *own = own.and(others);
        }
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        self.ring.hold();
        self.blades.hold();
        self.bending.hold();
    }

    pub(super) fn report(of: Option<&Self>, row: &mut Row<'_>) {
        let [ring, blades] = of.map_or([Some(FLEXIBLE), Some(BLADES)], |ring| ring.lacks);
        row.with(Empty::Absent, blades, |row| Self::report_bending(of, row));
        row.with(Empty::Absent, ring, |row| Self::report_ring(of, row));
        row.with(Empty::Absent, blades, |row| Self::report_blades(of, row));
    }

    fn report_bending(of: Option<&Self>, row: &mut Row<'_>) {
        let with_blades = of.filter(|ring| ring.has_blades);
        row.peak(
            "max_blade_bending_stress",
            "Pa",
            "largest bending stress in a blade of the diaphragm, nominal",
            with_blades.map(|ring| ring.bending),
        );
    }

    fn report_ring(of: Option<&Self>, row: &mut Row<'_>) {
        let with_ring = of.filter(|ring| ring.has_ring);
        row.peak(
            "max_ring_stress",
            "Pa",
            "largest hoop plus bending stress at a face of the diaphragm's ring, nominal; engine exponential without a yield limit: up to about 4 % too small",
            with_ring.map(|ring| ring.ring),
        );
        row.real(
            "max_ring_stress_angle_rad",
            "rad",
            "place around the ring of max_ring_stress_Pa, from blade 0 with positive spin; null without stress",
            with_ring.filter(|ring| ring.ring.value > Some(0.0)).map(|ring| ring.angle),
        );
    }

    fn report_blades(of: Option<&Self>, row: &mut Row<'_>) {
        let with_blades = of.filter(|ring| ring.has_blades);
        row.peak(
            "max_blade_stress",
            "Pa",
            "largest axial plus bending stress in a blade of the diaphragm, nominal; engine exponential without a yield limit: up to about 1 % too small",
            with_blades.map(|ring| ring.blades),
        );
        row.real(
            "max_blade_stress_blade",
            "",
            "number of the blade of max_blade_stress_Pa, from 0; null without stress",
            with_blades.filter(|ring| ring.blades.value > Some(0.0)).map(|ring| ring.blade as f64),
        );
    }
}
