//! Smallest gap between the rotor and the whole ring at an instant; for `hyp1` its own gap, at the angle of the rotor.
//!
//! The ring has the static displacement of the last impulses, as a follower is shown it. A contact step fulfils its conditions at ring points, with the force predicted at n+1
//! ([`crate::engine::exponential::contact::contact_predictor`]). The smallest gap of the whole ring is therefore also a measure of how much the forces change from step to step.

use crate::contact::{Detector, Gap, exact_gap, polar_gap};
use crate::engine::exponential::contact::contact_step_result::ContactStepResult;
use crate::engine::exponential::contact::corrected_shape::CorrectedShape;
use crate::engine::exponential::stepping::transient::Transient;
use crate::stator::Surface;
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{ContactPoints, ContactSurface, Detection, Diaphragm, DiaphragmKind, Machine};
use bladeoff_numerics::linalg::{axpy, column_of};

/// Impacts per evaluation of the whole ring, which costs about three contact steps: less than 1 % of a run.
const SAMPLE_INTERVAL: u64 = 384;
/// Phase of the ring's highest mode in a contact step \[rad\] below which the step is fine (1.8 by default): flutter needs fine steps, and these runs are slow in any case.
const FINE_STEP_ANGLE: f64 = 1.5;
/// Impacts per evaluation at a fine step, with `hyp2-frozen` and with one-point `hyp2`: their place leaves more penetration elsewhere on the ring.
const FINE_SAMPLE_INTERVAL: u64 = 8;

/// Views of the rings of all diaphragms of a machine, in its order; `None` without a flexible ring.
pub(crate) fn ring_clearances<'a>(machine: &Machine, structure: &'a Structure) -> Vec<Option<RingClearance<'a>>> {
    let part = |i: usize| structure.rings.get(i).and_then(Option::as_ref);
    machine.diaphragms.iter().enumerate().map(|(i, diaphragm)| RingClearance::new(diaphragm, part(i))).collect()
}

/// The whole ring and the rotor in it.
pub(crate) struct RingClearance<'a> {
    part: &'a RingPart,
    surface: Surface,
    detector: Detector,
    detection: Detection,
    /// Whether `hyp2` has one contact point.
    has_one_point: bool,
    /// Radius of the rotor's contact face \[m\].
    rotor_radius: f64,
    /// Impacts so far.
    impacts: u64,
    /// Stiffness-proportional damping of the ring \[s\].
    damping_time: f64,
    /// Frequency of the highest mode kept \[rad/s\].
    highest_frequency: f64,
    /// Centre of the rotor, seen from the undeformed ring's centre \[m\].
    pub place: [f64; 2],
    /// Smallest gap and its place.
    pub gap: Option<Gap>,
    /// Radial and tangential displacement of the ring there \[m\].
    pub displacement: [f64; 2],
    /// Nodal displacements of the ring, four per node.
    pub field: Vec<f64>,
}

impl<'a> RingClearance<'a> {
    /// View of the ring of a diaphragm; `None` where it has no flexible ring.
    fn new(diaphragm: &Diaphragm, part: Option<&'a RingPart>) -> Option<Self> {
        let part = part?;
        let contact = &diaphragm.contact;
        let inner = contact.surface == ContactSurface::InnerFace;
        let surface = part.matrices.surface(contact.rotor_radius + contact.gap, inner);
        Some(Self {
            part,
            detector: Detector::new(surface),
            detection: contact.detection,
            has_one_point: contact.points == ContactPoints::One,
            surface,
            rotor_radius: contact.rotor_radius,
            impacts: 0,
            damping_time: match &diaphragm.kind {
                DiaphragmKind::Flexible(stator) => stator.damping.stiffness_proportional,
                _ => 0.0,
            },
            highest_frequency: (0..part.part.coordinates.size())
                .map(|j| part.part.stiffness[(j, j)])
                .fold(0.0, f64::max)
                .sqrt(),
            place: [0.0; 2],
            gap: None,
            displacement: [0.0; 2],
            field: vec![0.0; 4 * part.matrices.nodes],
        })
    }

    /// Smallest gap that an impact leaves \[m\]: of the whole ring in one of [`SAMPLE_INTERVAL`] impacts, in one of [`FINE_SAMPLE_INTERVAL`] at fine steps, and in each where the step is
    /// below the time constant of the damping; otherwise of the ring points.
    #[inline]
    pub fn least_gap(&mut self, impact: &ContactStepResult, transient: &Transient) -> f64 {
        let diaphragm = impact.contact.diaphragm;
        self.impacts += 1;
        let h = transient.contact_step();
        let interval = match self.detection {
            _ if h < self.damping_time => 1,
            Detection::Hyp2Frozen => FINE_SAMPLE_INTERVAL,
            Detection::Hyp2 if self.has_one_point => FINE_SAMPLE_INTERVAL,
            _ if h * self.highest_frequency < FINE_STEP_ANGLE => FINE_SAMPLE_INTERVAL,
            Detection::Hyp1 | Detection::Hyp2 => SAMPLE_INTERVAL,
        };
        let contact = &transient.contacts[diaphragm];
        let Some(ring) = contact.stator.ring().filter(|_| self.impacts.is_multiple_of(interval)) else {
            return impact.gap;
        };
        let place = contact.place(&transient.free_motion, &transient.impulses);
        self.update(place, &ring.corrected_shape(place, transient.free_motion.impulse_response(diaphragm)));
        self.gap.map_or(impact.gap, |gap| gap.value.min(impact.gap))
    }

    /// Evaluates the ring at an instant, with the rotor's centre and the static displacements of the last impulses.
    pub fn update(&mut self, place: [f64; 2], settled: &CorrectedShape) {
        self.place = place;
        self.part.part.coordinates.expand_head(&settled.amplitudes, &mut self.field);
        if let Some(flexibility) = &self.part.residual {
            for &(alpha, [radial, tangential]) in &settled.pressed {
                let (element, xi) = self.surface.locate(alpha);
                for (dof, r, t) in self.surface.shapes(element, xi) {
                    let column = &column_of(flexibility, dof)[..self.field.len()];
                    axpy(radial * r + tangential * t, column, &mut self.field);
                }
            }
        }
        let gap = match self.detection {
            Detection::Hyp1 => polar_gap(&self.surface, Some(&self.field), self.rotor_radius, settled.rotor),
            Detection::Hyp2 | Detection::Hyp2Frozen => {
                let nearest = self.detector.closest(&self.field, settled.rotor);
                exact_gap(&self.surface, Some(&self.field), self.rotor_radius, settled.rotor, nearest)
            }
        };
        let point = self.surface.point(&self.field, gap.place.element, gap.place.xi);
        self.displacement = [point.radial - self.surface.radius, point.tangential];
        self.gap = Some(gap);
    }
}
