//! Contact surface of a stator, and the gap between rotor and stator.

use super::left_out::LeftOut;
use super::ring::Ring;
use crate::contact::{Gap, Place, exact_gap, polar_gap};
use crate::stator::Surface;
use crate::structure::RingPart;
use bladeoff_model::machine::{ContactSurface, Detection, Diaphragm};

/// The stator of one diaphragm.
pub(super) struct Stator<'a> {
    /// Geometry of the contact surface.
    pub surface: Surface,
    /// Motion of the flexible ring; `None` for a stator without degrees of freedom.
    pub ring: Option<Ring<'a>>,
    /// Contact detection: Hyp 1, Hyp 2 or its frozen form.
    pub detection: Detection,
    /// Radius R_r of the rotor section \[m\].
    pub rotor_radius: f64,
    /// Clearance between rotor and ring at rest \[m\].
    pub gap: f64,
}

impl<'a> Stator<'a> {
    /// Stator of a diaphragm; `None` if the operator of the ring is singular.
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

    /// Gap for a rotor centre `x` and the present field of the ring, in the run's own gap function.
    pub fn own_gap(&mut self, x: [f64; 2]) -> Gap {
        match (&mut self.ring, self.detection) {
            (ring, Detection::Hyp1) => {
                polar_gap(&self.surface, ring.as_ref().map(|r| r.field.as_slice()), self.rotor_radius, x)
            }
            (Some(ring), Detection::Hyp2 | Detection::Hyp2Frozen) => {
                let place = ring.detector.closest(&ring.field, x);
                exact_gap(&self.surface, Some(&ring.field), self.rotor_radius, x, place)
            }
            // the closest point of an undeformed circle is at the angle of the rotor centre, so both gap functions agree
            (None, _) => polar_gap(&self.surface, None, self.rotor_radius, x),
        }
    }

    /// Exact gap at a fixed place.
    pub fn fixed_gap(&self, x: [f64; 2], place: Place) -> Gap {
        exact_gap(&self.surface, self.field(), self.rotor_radius, x, place)
    }

    /// Gap record for a force that acts at the angle `alpha` instead of the place of `gap`.
    pub fn acting_at(&self, alpha: f64, x: [f64; 2], gap: &Gap) -> Gap {
        let place = Place::at_angle(self.ring.as_ref().map(|_| &self.surface), alpha);
        match self.detection {
            Detection::Hyp1 => Gap { place, ..*gap },
            Detection::Hyp2 | Detection::Hyp2Frozen => self.fixed_gap(x, place),
        }
    }

    /// Exact gaps at all local minima of the distance, the deepest first; `places` is scratch.
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

    /// Whether contact in the predicted step is excluded by a bound of the ring's radial displacement.
    pub fn is_far(&self, x: [f64; 2]) -> bool {
        let room = self.gap - (x[0] * x[0] + x[1] * x[1]).sqrt();
        match &self.ring {
            None => room > 0.0,
            Some(ring) => room > ring.radial_reach(),
        }
    }

    /// Gap at n in the run's own gap function; the rotor centre is given without the truncated modes.
    pub fn gap_at_n(&mut self, [x, y]: [f64; 2], left_out: &LeftOut<'_>) -> Gap {
        self.field_at_n(left_out);
        self.own_gap([x + left_out.shift_before[0], y + left_out.shift_before[1]])
    }

    /// Whether a rotor centre at n is outside the ring's contact line, at its own angle. Detection would then find the outside of the ring, or no
    /// contact. A centre beyond the undeformed line counts as outside for any deformation of the ring. Otherwise a ring pushed by the rotor (Hyp 1
    /// puts its force at the rotor's own angle) would be detected late.
    pub fn is_outside(&mut self, x: [f64; 2], left_out: &LeftOut<'_>) -> bool {
        let distance = (x[0] * x[0] + x[1] * x[1]).sqrt();
        // well inside for any deformation of the ring
        if distance <= self.gap + 0.5 * self.rotor_radius {
            return false;
        }
        if self.is_beyond(x) {
            return true;
        }
        self.field_at_n(left_out);
        polar_gap(&self.surface, self.field(), 0.0, x).value <= 0.0
    }

    /// Whether a position is outside the undeformed contact line. No linear ring model is valid for such a displacement.
    pub fn is_beyond(&self, x: [f64; 2]) -> bool {
        (x[0] * x[0] + x[1] * x[1]).sqrt() >= self.surface.radius
    }

    /// Sets the ring's field at n, under the forces of the previous step, which led there.
    fn field_at_n(&mut self, left_out: &LeftOut<'_>) {
        if let Some(ring) = &mut self.ring {
            ring.field_at_n(left_out.of_ring_before());
        }
    }

    /// Sets the ring's field at n+1 from its present increment, under the forces of the step.
    pub fn field_after(&mut self, left_out: &LeftOut<'_>) {
        if let Some(ring) = &mut self.ring {
            ring.field_after(left_out.of_ring());
        }
    }

    /// Nodal degrees of freedom of the ring, from the last call that set them.
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
