//! Energies of a run. Each stored energy and each work is integrated separately, so the energy balance is a check, not a definition.

use super::end::End;
use super::peak::Sum;
use super::ring::RingRecorders;
use super::row::Row;
use bladeoff_model::outcome::{Empty, Group};

/// Stored energies at one instant and cumulative works up to it \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic energy of rotor, spin, gyroscopic coupling, unbalances and rings.
    pub kinetic: f64,
    /// Strain energy of shaft, torsion, rings, radial springs and the symmetric part of the bearing stiffness.
    pub strain: f64,
    /// Potential energy in gravity.
    pub gravity: f64,
    /// Energy dissipated by bearing damping, positive for dissipation.
    pub bearings: f64,
    /// Energy dissipated by the structural damping of the shaft, in bending and torsion.
    pub structure: f64,
    /// Energy dissipated by the damping of the stator.
    pub stator: f64,
    /// Energy removed by braking.
    pub braking: f64,
    /// Energy dissipated by contact friction.
    pub friction: f64,
    /// Energy removed by the normal contact force, positive for removal.
    pub normal: f64,
    /// Energy removed by the model work of Hyp 1's approximate gap.
    pub model: f64,
    /// Energy supplied by skew bearing stiffness.
    pub skew: f64,
    /// Energy supplied by the drive of a prescribed speed.
    pub drive: f64,
    /// Energy supplied by bearing tables, whose stiffness depends on the speed.
    pub tables: f64,
    /// Energy supplied by torques over time.
    pub torques: f64,
    /// Energy supplied by released masses, kinetic and in gravity; negative for a lost mass.
    pub released: f64,
    /// Part of the stored energies: kinetic and strain energy of the lateral motion of shaft and stators, without spin, torsion and gravity.
    pub lateral: f64,
}

impl Energies {
    /// Total stored energy \[J\].
    #[must_use]
    pub fn stored(&self) -> f64 {
        self.kinetic + self.strain + self.gravity
    }
    /// Net energy removed from the system \[J\].
    #[must_use]
    pub fn taken(&self) -> f64 {
        self.bearings + self.structure + self.stator + self.braking + self.friction + self.normal + self.model
            - self.skew
            - self.drive
            - self.tables
            - self.torques
            - self.released
    }
}

/// Number of steps between two evaluations of the balance; the works are summed at every step, from the first on.
const EVERY: u64 = 8;

/// Energy balance of a run. An engine adds the works of each step to `now`, and writes the stored energies at the steps where they are
/// needed. The first balance is the reference.
#[derive(Debug, Clone, Default)]
pub(crate) struct EnergyBalance {
    /// Present stored energies and cumulative works.
    pub now: Energies,
    /// Total energy at the start \[J\]; `None` before the first balance.
    initial: Option<f64>,
    /// Largest magnitude of the total stored energy \[J\].
    largest: f64,
    /// Largest magnitude of the balance error \[J\].
    largest_error: f64,
    /// Largest energy of the lateral motion at balances with a contact since the one before \[J\].
    largest_lateral: f64,
    /// Normal contact work at the last balance \[J\].
    normal_before: f64,
    /// Energy dissipated by friction while all guards held \[J\].
    friction_guarded: f64,
}

impl EnergyBalance {
    /// Returns whether the stored energies are needed at this step. They are needed at each of the first steps, because one of these may be
    /// the last.
    pub fn wants_stores(step: u64) -> bool {
        step.is_multiple_of(EVERY) || step < EVERY
    }

    /// Returns whether the balance is judged at this step, regardless of whether a [`super::Follower`] observes the run.
    pub fn judges(step: u64) -> bool {
        step.is_multiple_of(EVERY)
    }

    /// Records a step, after its works and, where needed, its stored energies.
    pub fn see(&mut self, step: u64) {
        if Self::judges(step) {
            self.balance();
        }
    }

    /// Records an instant after its works and stored energies, for an engine with steps of variable length.
    pub fn take(&mut self) {
        self.balance();
    }

    /// Records the end of the run. A run that is too short for a second balance is balanced at its last step.
    pub fn finish(&mut self, end: &End) {
        if end.failure.is_none() && end.steps <= EVERY {
            self.balance();
        }
    }

    /// Updates the balance error, from stored energies and works of the same step.
    fn balance(&mut self) {
        let total = self.now.stored();
        // works before the first balance belong to half a step before and after t = 0, so they are part of the start
        let initial = *self.initial.get_or_insert(total + self.now.taken());
        self.largest = self.largest.max(total.abs());
        // a whirl far from the ring, as in a critical speed before the first contact, is no measure of an impact
        if self.now.normal != self.normal_before {
            self.largest_lateral = self.largest_lateral.max(self.now.lateral);
            self.normal_before = self.now.normal;
        }
        self.largest_error = self.largest_error.max((total + self.now.taken() - initial).abs());
    }

    /// Total energy at the start \[J\]; 0 before the first balance.
    fn initial(&self) -> f64 {
        self.initial.unwrap_or(0.0)
    }

    /// Energy that the normal contact work is compared with \[J\]: the largest of the friction energy, of the energy that the lateral motion of shaft
    /// and stators has had during contact, and of a thousandth of the total energy at the start.
    ///
    /// The normal work of a converged run is not 0: where a contact begins, the node of the ring takes the velocity of the rotor at once, which
    /// takes up to 0.7 % of the energy of an impact. Friction energy alone would reject such a run where a rotor turns slowly or without friction,
    /// although its values agree between steps. Verified by `tests/contact/rolling.rs` and
    /// `tests/contact/normal_work.rs`.
    pub fn normal_work_reference(&self) -> f64 {
        self.now.friction.max(self.largest_lateral).max(1e-3 * self.initial().abs())
    }

    /// Largest balance error over the largest total energy \[-\].
    pub fn relative_error(&self) -> f64 {
        if self.largest > 0.0 { self.largest_error / self.largest } else { 0.0 }
    }

    /// Returns whether all energies are finite. Comparisons and maxima ignore a NaN, so a separate check is necessary.
    pub fn is_finite(&self) -> bool {
        (self.now.stored() + self.now.taken() + self.largest + self.largest_error).is_finite()
    }

    /// Marks the friction energy so far as guarded.
    pub fn hold(&mut self) {
        self.friction_guarded = self.now.friction;
    }

    /// Reports the energy columns. Works of contact are null without a diaphragm.
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
