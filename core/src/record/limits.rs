//! Limits of the physical model: the ratio of each quantity to its limit, and the time at which a limit is first exceeded.
//!
//! ```text
//! ratio = quantity / (run.limit.NAME.value * reference)        the limit is exceeded where ratio > 1
//! ```
//! | limit | quantity | reference |
//! |---|---|---|
//! | `ring_displacement` | eccentricity at a flexible ring less the gap | mean radius of the ring |
//! | `ring_yield`, `blade_yield`, `shaft_yield` | stress | yield strength of the material |
//! | `journal_clearance` | displacement of the journal | radial clearance of its bearing |
//! | `unstable_rotor` | growth of a whirl mode's amplitude over one of its revolutions | 1 |
//!
//! The planar ring and the linear bearing are small-displacement models, and all materials are elastic. Beyond these limits a run no longer
//! describes the machine. A limit does not change the motion; with `run.end_beyond` it ends the run. Several rings or bearings share one
//! limit: the largest ratio counts. Verified by `core/tests/runs/limits.rs`.

use super::peak::{At, Sum};
use super::row::Row;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine, ModelLimit, OnExceed};
use bladeoff_model::outcome::{CauseSet, Empty, Limit};

/// State of one limit during a run.
#[derive(Debug, Clone, Copy)]
struct Watched {
    limit: ModelLimit,
    /// Part or key whose absence prevents the limit from being judged; `None` if the limit is judged.
    lacks: Option<&'static str>,
    /// Largest ratio so far \[-\], 0 before the quantity has a value; `None` if the limit is not judged.
    largest: Option<f64>,
    /// Largest ratio while all guards held \[-\].
    guarded: f64,
    /// Time and speed at which the ratio first exceeded 1.
    exceeded: Option<At>,
}

/// Recorder of all limits of a run.
#[derive(Debug, Clone)]
pub(crate) struct LimitRecorder {
    limits: [Watched; Limit::ALL.len()],
    /// First exceeded limit with [`OnExceed::Beyond`], with its time and speed.
    beyond: Option<(Limit, At)>,
    /// Whether all guards held at that time.
    beyond_held: bool,
    /// Mean radius and gap \[m\] of each diaphragm; `None` without a flexible ring.
    rings: Vec<Option<[f64; 2]>>,
    /// Whether the values reached up to the exceeded limit have been judged ([`super::Recorders::judge`]).
    kept: bool,
    /// Time step \[s\]: the earliest reported time of an exceeded limit.
    step: f64,
    /// Radial clearance of each bearing that has one \[m\], in the machine's order.
    clearances: Vec<f64>,
}

impl LimitRecorder {
    pub fn new(machine: &Machine, step: f64) -> Self {
        let watched = |limit: ModelLimit| {
            let lacks = machine.lacks(limit.limit);
            // this limit has no ratio until a whirl mode is found
            let starts = lacks.is_none() && limit.limit != Limit::UnstableRotor;
            Watched { limit, lacks, largest: starts.then_some(0.0), guarded: 0.0, exceeded: None }
        };
        Self {
            limits: machine.run.limits.map(watched),
            beyond: None,
            beyond_held: false,
            kept: false,
            step,
            rings: machine.diaphragms.iter().map(radius_and_gap).collect(),
            clearances: machine.rotor.bearings.iter().filter_map(|bearing| bearing.clearance).collect(),
        }
    }

    /// Records the quantity of a limit over its reference \[-\], at an instant.
    #[inline]
    pub fn see(&mut self, limit: Limit, quantity: f64, at: At) {
        let watched = &mut self.limits[limit as usize];
        let ratio = quantity / watched.limit.value;
        if watched.largest.is_none_or(|largest| ratio > largest) {
            watched.largest = Some(ratio);
            if ratio > 1.0 && watched.exceeded.is_none() {
                watched.exceeded = Some(at);
                if watched.limit.on_exceed == OnExceed::Beyond && self.beyond.is_none() {
                    self.beyond = Some((limit, at));
                }
            }
        }
    }

    /// Records the squared eccentricity of the rotor in a ring \[m2\].
    #[inline]
    pub fn see_eccentricity(&mut self, ring: usize, square: f64, at: At) {
        let Some([radius, gap]) = self.rings.get(ring).copied().flatten() else { return };
        let watched = &self.limits[Limit::RingDisplacement as usize];
        // take the root only if the ratio may grow
        let least = gap + watched.largest.unwrap_or(0.0) * watched.limit.value * radius;
        if square > least * least || watched.largest.is_none() {
            let quantity = (square.sqrt() - gap).max(0.0) / radius;
            self.see(Limit::RingDisplacement, quantity, at);
        }
    }

    /// Records the displacements of the journals in bearings with a clearance, in the machine's order \[m\].
    #[inline]
    pub fn see_journals(&mut self, displacements: &[[f64; 2]], at: At) {
        for place in 0..self.clearances.len().min(displacements.len()) {
            let [x, y] = displacements[place];
            self.see(Limit::JournalClearance, (x * x + y * y).sqrt() / self.clearances[place], at);
        }
    }

    /// Returns the first exceeded limit with [`OnExceed::Beyond`], with its time and speed.
    pub fn beyond(&self) -> Option<(Limit, At)> {
        self.beyond
    }

    /// Returns when the run has exceeded such a limit, if it has since the last judgement.
    #[inline]
    pub fn newly_beyond(&self) -> Option<At> {
        self.beyond.filter(|_| !self.kept).map(|(_, at)| at)
    }

    /// Marks the ratios reached so far as guarded.
    pub fn hold(&mut self) {
        self.limits.iter_mut().for_each(|watched| watched.guarded = watched.largest.unwrap_or(0.0));
        self.beyond_held = self.beyond.is_some();
    }

    /// Returns whether values still count as reached within the model, and updates that state. The step in which the limit is exceeded is
    /// the last one that counts.
    pub fn keeps(&mut self) -> bool {
        let keeps = !self.kept;
        self.kept |= self.beyond.is_some();
        keeps
    }

    /// Returns whether the run ends here because of `run.end_beyond`.
    #[inline]
    pub fn ends(&self, machine: &Machine) -> bool {
        self.beyond.is_some() && machine.run.end_beyond
    }

    /// Returns the exceeded limits with a given `on_exceed`.
    pub fn exceeded(&self, on_exceed: OnExceed) -> CauseSet {
        let mut causes = CauseSet::default();
        let exceeded = self.limits.iter().filter(|watched| watched.exceeded.is_some());
        exceeded.filter(|watched| watched.limit.on_exceed == on_exceed).for_each(|watched| {
            causes.insert(watched.limit.limit.cause());
        });
        causes
    }

    pub(super) fn report_time(&self, row: &mut Row<'_>) {
        let time = self.beyond.map(|(_, at)| at.time.max(self.step));
        row.once(
            "beyond_s",
            "time at which the run first exceeded a limit of the model whose on_exceed is beyond, at least one step; null without one",
            time,
            time.filter(|_| self.beyond_held),
        );
    }

    pub(super) fn report(&self, row: &mut Row<'_>) {
        for watched in &self.limits {
            let limit = watched.limit.limit;
            let (name, word) = (limit.quantity(), limit.word());
            let ratio = watched.largest.map(|value| Sum { value, guarded: watched.guarded });
            let meaning = format!(
                "{name}, over run.limit.{word}.value; above 1 the limit is exceeded; null where it is not judged"
            );
            row.with(Empty::Unjudged, watched.lacks, |row| {
                row.sum(&format!("limit_ratio_{word}"), "", &meaning, ratio);
            });
        }
    }
}

/// Mean radius and gap of a flexible ring \[m\]. A rigid ring and a massless radial spring have no displacement to limit.
fn radius_and_gap(diaphragm: &Diaphragm) -> Option<[f64; 2]> {
    match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => Some([stator.ring.mean_radius, diaphragm.contact.gap]),
        DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
    }
}
