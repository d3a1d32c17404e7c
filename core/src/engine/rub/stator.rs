//! What a rotor may touch: the surface of a stator, and the gap to it.

use super::left_out::LeftOut;
use super::ring::Ring;
use crate::contact::{Gap, Place, exact_gap, polar_gap};
use crate::stator::Surface;
use crate::structure::RingPart;
use bladeoff_model::machine::{ContactSurface, Detection, Diaphragm};

/// The stator of one diaphragm.
pub(super) struct Stator<'a> {
    pub surface: Surface,
    /// `None` where it has no freedoms.
    pub ring: Option<Ring<'a>>,
    pub detection: Detection,
    pub rotor_radius: f64,
    /// Clearance \[m\].
    pub gap: f64,
}

impl<'a> Stator<'a> {
    /// `None` if the operator of the ring is singular.
    pub fn new(diaphragm: &Diaphragm, part: Option<&'a RingPart>, dt: f64) -> Option<Self> {
        let contact = &diaphragm.contact;
        let radius = contact.rotor_radius + contact.gap;
        let inner = contact.surface == ContactSurface::InnerFace;
        let surface = match part {
            Some(ring) => ring.matrices.surface(radius, inner),
            None => Surface::circle(radius),
        };
        let ring = match part {
            None => None,
            Some(part) => Some(Ring::new(part, surface, dt)?),
        };
        let (detection, rotor_radius, gap) = (contact.detection, contact.rotor_radius, contact.gap);
        Some(Self { surface, ring, detection, rotor_radius, gap })
    }

    /// Gap of a rotor centre and the ring's field in the run's own gap function.
    pub fn own_gap(&mut self, x: [f64; 2]) -> Gap {
        match (&mut self.ring, self.detection) {
            (ring, Detection::Hyp1) => {
                polar_gap(&self.surface, ring.as_ref().map(|r| r.field.as_slice()), self.rotor_radius, x)
            }
            (Some(ring), Detection::Hyp2 | Detection::Hyp2Frozen) => {
                let place = ring.detector.closest(&ring.field, x);
                exact_gap(&self.surface, Some(&ring.field), self.rotor_radius, x, place)
            }
            // an undeformed circle is closest at the angle of the rotor centre: both gaps are one
            (None, _) => polar_gap(&self.surface, None, self.rotor_radius, x),
        }
    }

    /// Exact gap at a place that is kept.
    pub fn fixed_gap(&self, x: [f64; 2], place: Place) -> Gap {
        exact_gap(&self.surface, self.field(), self.rotor_radius, x, place)
    }

    /// The gap record of a force that acts at another angle than the gap's own.
    pub fn acting_at(&self, alpha: f64, x: [f64; 2], gap: &Gap) -> Gap {
        let place = Place::at_angle(self.ring.as_ref().map(|_| &self.surface), alpha);
        match self.detection {
            Detection::Hyp1 => Gap { place, ..*gap },
            Detection::Hyp2 | Detection::Hyp2Frozen => self.fixed_gap(x, place),
        }
    }

    /// The exact gaps at all minima of the distance, the deepest first; `places` is scratch.
    pub fn minima(&mut self, x: [f64; 2], places: &mut Vec<Place>) -> Vec<Gap> {
        if let Some(ring) = &mut self.ring {
            ring.detector.minima(&ring.field, x, places);
        }
        let mut gaps: Vec<Gap> = places.iter().map(|&place| self.fixed_gap(x, place)).collect();
        gaps.sort_by(|a, b| a.value.total_cmp(&b.value));
        gaps
    }

    /// Whether the rotor penetrates the ring at more than one local minimum, by the search of [`Stator::own_gap`].
    pub fn several_minima(&self) -> bool {
        let searched = self.ring.as_ref().filter(|_| self.detection != Detection::Hyp1);
        searched.is_some_and(|ring| ring.detector.minima_within(self.rotor_radius) > 1)
    }

    /// Whether the predicted step cannot touch, from a bound on the ring's radial displacement.
    pub fn is_far(&self, x: [f64; 2]) -> bool {
        let room = self.gap - (x[0] * x[0] + x[1] * x[1]).sqrt();
        match &self.ring {
            None => room > 0.0,
            Some(ring) => room > ring.radial_reach(),
        }
    }

    /// The gap at n, of a rotor centre without the modes left out, in the run's own gap function.
    pub fn gap_at_n(&mut self, [x, y]: [f64; 2], left_out: &LeftOut<'_>) -> Gap {
        self.field_at_n(left_out);
        self.own_gap([x + left_out.shift_before[0], y + left_out.shift_before[1]])
    }

    /// Whether a rotor centre at n is beyond the line of the ring that touches, at its own angle: detection would find the
    /// ring's outside there, or no contact. Beyond the undeformed line it is outside wherever the ring may be: one that is pushed
    /// along (Hyp 1 puts its force at the rotor's own angle) would be found out late.
    pub fn is_outside(&mut self, x: [f64; 2], left_out: &LeftOut<'_>) -> bool {
        let distance = (x[0] * x[0] + x[1] * x[1]).sqrt();
        // far inside, whatever the ring does
        if distance <= self.gap + 0.5 * self.rotor_radius {
            return false;
        }
        if self.is_beyond(x) {
            return true;
        }
        self.field_at_n(left_out);
        polar_gap(&self.surface, self.field(), 0.0, x).value <= 0.0
    }

    /// Whether a place is beyond the line of the undeformed ring that touches: no linear ring is pushed so far.
    pub fn is_beyond(&self, x: [f64; 2]) -> bool {
        (x[0] * x[0] + x[1] * x[1]).sqrt() >= self.surface.radius
    }

    /// The ring's field at n, under the forces that led there: those of the step before.
    fn field_at_n(&mut self, left_out: &LeftOut<'_>) {
        if let Some(ring) = &mut self.ring {
            ring.field_at_n(left_out.of_ring_before());
        }
    }

    /// The ring's field at n+1 with its present increment, under the forces of the step.
    pub fn field_after(&mut self, left_out: &LeftOut<'_>) {
        if let Some(ring) = &mut self.ring {
            ring.field_after(left_out.of_ring());
        }
    }

    /// Nodal freedoms of the ring, as asked for last.
    pub fn field(&self) -> Option<&[f64]> {
        self.ring.as_ref().map(|ring| ring.field.as_slice())
    }

    /// Radial and tangential displacement of the ring's field at a place \[m\].
    pub fn displacement(&self, place: &Place) -> [f64; 2] {
        self.ring.as_ref().map_or([0.0; 2], |ring| {
            let point = self.surface.point(&ring.field, place.element, place.xi);
            [point.radial - self.surface.radius, point.tangential]
        })
    }
}
