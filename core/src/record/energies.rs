//! Energies of a run: every store and every flow integrated on its own, so that their balance is a check and not a definition.

use super::end::End;
use super::peak::Sum;
use super::ring::RingRecorders;
use super::row::Row;
use bladeoff_model::outcome::{Empty, Group};

/// Energies of one instant and the work done up to it \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic: rotor, spin, gyroscopic coupling, unbalance, ring.
    pub kinetic: f64,
    /// Strain: shaft, bearings' potential part, torsion, ring, radial spring.
    pub strain: f64,
    /// Gravity.
    pub gravity: f64,
    /// Dissipated by bearings.
    pub bearings: f64,
    /// Dissipated by structural damping of the shaft, in bending and torsion.
    pub structure: f64,
    /// Dissipated by the stator's damping.
    pub stator: f64,
    /// Taken by braking.
    pub braking: f64,
    /// Dissipated by contact friction.
    pub friction: f64,
    /// Taken out by the normal contact force.
    pub normal: f64,
    /// Hyp 1's model work, taken out.
    pub model: f64,
    /// Put in by skew bearing stiffness.
    pub skew: f64,
    /// Put in by the drive of a prescribed speed.
    pub drive: f64,
    /// Put in by bearing tables, whose stiffness changes with the speed.
    pub tables: f64,
    /// Put in by masses that were released: kinetic and in gravity, negative of a lost mass.
    pub released: f64,
}

impl Energies {
    /// Energy stored.
    #[must_use]
    pub fn stored(&self) -> f64 {
        self.kinetic + self.strain + self.gravity
    }
    /// Energy that has left.
    #[must_use]
    pub fn taken(&self) -> f64 {
        self.bearings + self.structure + self.stator + self.braking + self.friction + self.normal + self.model
            - self.skew
            - self.drive
            - self.tables
            - self.released
    }
}

/// The balance is evaluated every so many steps (the works are summed at each), from the first on.
const EVERY: u64 = 8;

/// Keeps the balance of a run: an engine adds works to `now` at each step, and writes the stores where they are wanted. The first
/// balance is the reference.
#[derive(Debug, Clone, Default)]
pub(crate) struct EnergyBalance {
    pub now: Energies,
    /// Energy at the start; `None` before the first balance.
    initial: Option<f64>,
    largest: f64,
    largest_error: f64,
    /// Energy dissipated by friction while all guards held.
    friction_guarded: f64,
}

impl EnergyBalance {
    /// Whether the stores of this step are needed: also of each of the first, one of which may be the last.
    pub fn wants_stores(step: u64) -> bool {
        step.is_multiple_of(EVERY) || step < EVERY
    }

    /// Whether the balance is judged with this step: at the same steps whoever looks.
    pub fn judges(step: u64) -> bool {
        step.is_multiple_of(EVERY)
    }

    /// Takes a step, with its works added and its stores written where they are wanted.
    pub fn see(&mut self, step: u64) {
        if Self::judges(step) {
            self.balance();
        }
    }

    /// Takes an instant with its works added and its stores written, of an engine whose steps are not equal.
    pub fn take(&mut self) {
        self.balance();
    }

    /// Takes the end of the run: one too short for a second balance has it at its last step.
    pub fn finish(&mut self, end: &End) {
        if end.failure.is_none() && end.steps <= EVERY {
            self.balance();
        }
    }

    /// The error of the balance, with stores and works of the same step.
    fn balance(&mut self) {
        let total = self.now.stored();
        // the works before the first one are those of half a step before and after t = 0: they belong to the start
        let initial = *self.initial.get_or_insert(total + self.now.taken());
        self.largest = self.largest.max(total.abs());
        self.largest_error = self.largest_error.max((total + self.now.taken() - initial).abs());
    }

    /// Energy at the start \[J\]; 0 before the first balance.
    pub fn initial(&self) -> f64 {
        self.initial.unwrap_or(0.0)
    }

    /// Largest balance error over the largest total energy.
    pub fn relative_error(&self) -> f64 {
        if self.largest > 0.0 { self.largest_error / self.largest } else { 0.0 }
    }

    /// Whether all is finite: comparisons and largest values pass over what is no number.
    pub fn is_finite(&self) -> bool {
        (self.now.stored() + self.now.taken() + self.largest + self.largest_error).is_finite()
    }

    /// All guards hold.
    pub fn hold(&mut self) {
        self.friction_guarded = self.now.friction;
    }

    /// Works of contact are null without a ring.
    pub(super) fn report(&self, rings: &[RingRecorders], row: &mut Row<'_>) {
        let diaphragm = rings.is_empty().then_some("a diaphragm");
        row.with(Empty::Absent, diaphragm, |row| self.report_contact(rings, row));
        row.of(Group::Numerics).real(
            "energy_error",
            "",
            "largest error of the energy balance over the largest total energy",
            self.relative_error(),
        );
    }

    fn report_contact(&self, rings: &[RingRecorders], row: &mut Row<'_>) {
        let work = |joules: f64| (!rings.is_empty()).then_some(joules);
        let models = rings.iter().any(|ring| ring.contact.does_model_work());
        let friction = Sum { value: self.now.friction, guarded: self.friction_guarded };
        let friction = (!rings.is_empty()).then_some(friction);
        row.sum("friction_energy_J", "J", "energy dissipated by contact friction", friction);
        row.real(
            "normal_work_J",
            "J",
            "energy that the normal contact force took out (positive) or put in (negative), Hyp 1's model work apart",
            work(self.now.normal),
        );
        let lacks = (!models).then_some("a diaphragm with `contact.detection = \"hyp1\"`");
        row.with(Empty::Unjudged, lacks, |row| {
            row.real(
                "model_work_J",
                "J",
                "work of the normal force that Hyp 1's approximate gap does not account for; null with other detections",
                models.then_some(self.now.model),
            );
        });
    }
}
