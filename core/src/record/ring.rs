//! Recorders of one diaphragm.

use super::contact::{ContactRecorder, Touch};
use super::peak::{At, Peak};
use super::ring_stresses::{RingState, RingStressRecorder};
use super::row::{OfRing, Row};
use super::whirl::{Motion, WhirlRecorder};
use crate::structure::RingPart;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine};
use bladeoff_model::outcome::{Empty, EndCause};

/// Instant of a diaphragm and of the rotor in it, in the diaphragm's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RingInstant<'a> {
    /// Mean spin angle \[rad\].
    pub angle: f64,
    /// Position of the rotor's centre relative to the diaphragm's centre \[m\].
    pub place: [f64; 2],
    /// Velocity of the rotor's centre relative to the diaphragm's centre \[m/s\].
    pub velocity: [f64; 2],
    /// Contact of the step; `None` without contact.
    pub touch: Option<Touch>,
    /// State of the flexible ring, from the first motion of the ring on.
    pub ring: Option<RingState<'a>>,
}

/// Column name of the largest eccentricity.
const ECCENTRICITY: &str = "max_eccentricity";

/// Returns the name that distinguishes the columns of this diaphragm; `None` if the machine has only one.
pub(super) fn diaphragm_name<'a>(machine: &Machine, diaphragm: &'a Diaphragm) -> Option<&'a str> {
    (machine.diaphragms.len() > 1).then_some(&*diaphragm.name)
}

/// Recorders of one diaphragm.
#[derive(Debug, Clone)]
pub(crate) struct RingRecorders {
    /// Name of the diaphragm, if there are several.
    name: Option<String>,
    pub contact: ContactRecorder,
    whirl: WhirlRecorder,
    /// Largest squared eccentricity \[m2\]; the root is taken once, at the end.
    eccentricity: Peak,
    pub stresses: RingStressRecorder,
}

impl RingRecorders {
    /// `name`: name of the diaphragm, if the machine has several.
    pub fn new(diaphragm: &Diaphragm, name: Option<&str>, part: Option<&RingPart>, step: f64) -> Self {
        let width = match &diaphragm.kind {
            DiaphragmKind::Flexible(stator) => Some(stator.ring.width),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
        };
        Self {
            name: name.map(str::to_owned),
            contact: ContactRecorder::new(&diaphragm.contact, width, step),
            whirl: WhirlRecorder::new(step),
            eccentricity: Peak::default(),
            stresses: RingStressRecorder::new(&diaphragm.kind, part),
        }
    }

    /// Records an instant of one step.
    #[inline]
    pub fn see(&mut self, now: &RingInstant<'_>, at: At) {
        let ([x, y], touch) = (now.place, now.touch.as_ref());
        self.eccentricity.see(x * x + y * y, at);
        self.contact.see(touch, at);
        let motion = Motion { angle: now.angle, place: now.place, velocity: now.velocity, touches: touch.is_some() };
        self.whirl.see(&motion, at);
        if let Some(ring) = now.ring {
            self.stresses.see(ring, at);
        }
    }

    /// Records a squared eccentricity \[m2\] alone.
    pub fn see_place(&mut self, square: f64, at: At) {
        self.eccentricity.see(square, at);
    }

    /// Records an instant that several steps without contact follow.
    pub fn pass(&mut self, steps: usize, now: &RingInstant<'_>, at: At) {
        let [x, y] = now.place;
        self.eccentricity.see(x * x + y * y, at);
        self.contact.pass(steps, at);
        let motion = Motion { angle: now.angle, place: now.place, velocity: now.velocity, touches: false };
        self.whirl.pass(steps, &motion, at);
        if let Some(ring) = now.ring {
            self.stresses.see(ring, at);
        }
    }

    /// Largest distance of the rotor's centre from the diaphragm's centre \[m\].
    pub fn eccentricity(&self) -> Option<f64> {
        self.eccentricity.value.map(f64::sqrt)
    }

    /// Records the end of the run.
    pub fn finish(&mut self, cause: EndCause, at: At) {
        self.contact.finish(at);
        self.whirl.finish(cause, at.time);
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        self.eccentricity.hold();
        self.contact.hold();
        self.stresses.hold();
    }

    /// Merges the recorders of several diaphragms: the largest peaks, the sums, the first contact. `None` for fewer than two.
    pub(super) fn of_all(rings: &[Self]) -> Option<Self> {
        let [first, second, others @ ..] = rings else { return None };
        let mut all = Self { name: None, ..first.clone() };
        for ring in std::iter::once(second).chain(others) {
            all.contact.include(&ring.contact);
            all.whirl.include(&ring.whirl);
            all.eccentricity.include(&ring.eccentricity);
            all.stresses.include(&ring.stresses);
        }
        Some(all)
    }

    /// Reports the columns of each ring, in the machine's order. With several rings, the merged columns come first. A machine without a
    /// ring has the same columns as with one, without values.
    pub(super) fn report(
        (rings, all): (&[Self], Option<&Self>),
        row: &mut Row<'_>,
        columns: fn(Option<&Self>, &mut Row<'_>),
    ) {
        if rings.is_empty() {
            row.with(Empty::Absent, Some("a diaphragm"), |row| columns(None, row));
        }
        if all.is_some() {
            row.of_ring(OfRing::All);
            columns(all, row);
        }
        for ring in rings {
            row.of_ring(ring.name.as_ref().map_or(OfRing::Only, |name| OfRing::One(name.clone())));
            columns(Some(ring), row);
        }
        row.of_ring(OfRing::Only);
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
            ECCENTRICITY,
            "m",
            "largest distance of the rotor centre from the diaphragm's centre at the contact section",
            of.map(|ring| ring.eccentricity.map(f64::sqrt)),
        );
    }

    pub(super) fn report_friction(of: Option<&Self>, row: &mut Row<'_>) {
        let is_one = of.is_some_and(|ring| ring.name.is_some());
        ContactRecorder::report_friction(of.map(|ring| &ring.contact), is_one, row);
    }

    pub(super) fn report_solves(of: Option<&Self>, row: &mut Row<'_>) {
        ContactRecorder::report_solves(of.map(|ring| &ring.contact), row);
    }

    pub(super) fn report_resolution(of: Option<&Self>, row: &mut Row<'_>) {
        ContactRecorder::report_resolution(of.map(|ring| &ring.contact), row);
    }

    pub(super) fn report_stresses(of: Option<&Self>, row: &mut Row<'_>) {
        RingStressRecorder::report(of.map(|ring| &ring.stresses), row);
    }
}
