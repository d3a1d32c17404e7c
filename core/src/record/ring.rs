//! What one diaphragm is watched for.

use super::contact::{ContactRecorder, Touch};
use super::peak::{At, Peak};
use super::row::Row;
use super::stresses::BladeRecorder;
use super::whirl::{Motion, WhirlRecorder};
use crate::structure::RingPart;
use bladeoff_model::machine::Diaphragm;

/// One instant of a diaphragm and of the rotor in it, in the diaphragm's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RingInstant<'a> {
    /// Mean spin angle \[rad\].
    pub angle: f64,
    /// Place \[m\] and velocity \[m/s\] of the rotor's centre from the diaphragm's.
    pub place: [f64; 2],
    pub velocity: [f64; 2],
    /// Contact of the step.
    pub touch: Option<Touch>,
    /// Coordinates of the flexible ring, once it moves.
    pub ring: Option<&'a [f64]>,
}

/// Recorders of one diaphragm.
#[derive(Debug, Clone)]
pub(crate) struct RingRecorders {
    pub contact: ContactRecorder,
    whirl: WhirlRecorder,
    /// Squared (one root at the end) \[m2\].
    eccentricity: Peak,
    blades: BladeRecorder,
}

impl RingRecorders {
    pub fn new(diaphragm: &Diaphragm, part: Option<&RingPart>, step: f64) -> Self {
        Self {
            contact: ContactRecorder::new(&diaphragm.contact, step),
            whirl: WhirlRecorder::new(step),
            eccentricity: Peak::default(),
            blades: BladeRecorder::new(&diaphragm.kind, part),
        }
    }

    /// Takes an instant.
    #[inline]
    pub fn see(&mut self, now: &RingInstant<'_>, at: At) {
        let ([x, y], touch) = (now.place, now.touch.as_ref());
        self.eccentricity.see(x * x + y * y, at);
        self.contact.see(touch, at);
        let motion = Motion { angle: now.angle, place: now.place, velocity: now.velocity, touches: touch.is_some() };
        self.whirl.see(&motion, at);
        if let Some(q) = now.ring {
            self.blades.see(q, at);
        }
    }

    pub(super) fn report_first_contact(of: Option<&Self>, row: &mut Row<'_>) {
        ContactRecorder::report_first(of.map(|ring| &ring.contact), row);
    }

    pub(super) fn report_contact(of: Option<&Self>, row: &mut Row<'_>) {
        let contact = of.map(|ring| &ring.contact);
        ContactRecorder::report_forces(contact, row);
        WhirlRecorder::report(of.map(|ring| &ring.whirl), row);
        ContactRecorder::report_penetration(contact, row);
        row.peak(
            "max_eccentricity",
            "m",
            "largest distance of the rotor centre from the diaphragm's centre at the contact section",
            of.map(|ring| ring.eccentricity.map(f64::sqrt)),
        );
    }

    pub(super) fn report_solves(of: Option<&Self>, row: &mut Row<'_>) {
        ContactRecorder::report_solves(of.map(|ring| &ring.contact), row);
    }

    pub(super) fn report_blades(of: Option<&Self>, row: &mut Row<'_>) {
        BladeRecorder::report(of.map(|ring| &ring.blades), row);
    }
}
