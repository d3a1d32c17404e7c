//! Quantities that observers evaluate from the free motion: an instant of it, section loads, dissipation and stored energy.
//!
//! All are functions of the modal state and of its speed interval. None of them changes the motion.

use super::free_motion::FreeMotion;
use crate::engine::exponential::modal::dissipation::DissipationBuffer;
use crate::engine::exponential::modal::row_batch::RowBatch;
use crate::engine::exponential::modal::section_loads::{StoredEnergy, sizes_of};
use crate::engine::exponential::modal::speed_interval::SpeedInterval;
use crate::engine::exponential::torsion::spin::ContactImpulse;
use nalgebra::Complex;
use std::sync::Arc;

/// Lateral motion at an instant.
#[derive(Debug)]
pub(crate) struct LateralState {
    /// Speed interval of the modal state.
    interval: Arc<SpeedInterval>,
    /// Modal state y.
    modal_state: Vec<f64>,
    /// Force of each unbalance on its node, u + i v \[N\].
    forces: Vec<Complex<f64>>,
}

impl FreeMotion {
    /// Writes the lateral coordinates q at n, zeros up to a multiple of eight.
    pub(crate) fn lateral_coordinates(&mut self, q: &mut Vec<f64>) {
        self.tables.displacements(&self.interval, &self.shared.grid.model).multiply(&self.modal_state, q);
    }

    /// Writes the rates of the lateral coordinates at n, zeros up to a multiple of eight.
    pub(crate) fn lateral_rates(&mut self, rates: &mut Vec<f64>) {
        self.tables.velocities(&self.interval, &self.shared.grid.model).multiply(&self.modal_state, rates);
    }

    /// Gyroscopic momentum of the motion at n \[kg m2/s\].
    pub(crate) fn gyroscopic_momentum(&mut self) -> f64 {
        self.tables.momentum(&self.interval).value(&self.modal_state)
    }

    /// Shift of the spin at n that follows from a gyroscopic momentum, that of n, in place of the last one that was taken
    /// \[rad/s\].
    pub(crate) fn gyroscopic_speed_shift(&self, gyroscopic: f64) -> f64 {
        (self.gyroscopic.1 - gyroscopic) * self.spin.gyroscopic_compliance()
    }

    /// Writes bounds over all phases of the motion at n: the bending moment of each group of [`SECTIONS_AT_ONCE`] elements
    /// \[N m\], then all displacements \[m, rad\].
    pub(crate) fn moment_bounds(&mut self, bounds: &mut Vec<f64>) {
        let Self { interval, tables, modal_state, scratch, shared, .. } = self;
        let (a, b) = modal_state.split_at(modal_state.len() / 2);
        let amplitudes = &mut scratch[..a.len()];
        sizes_of(a, b, amplitudes);
        tables.bounds(interval, &shared.grid.model).multiply(amplitudes, bounds);
    }

    /// Rows of the bending moments \[N m\] on the modal state, which is the second: a block of rows has the moments of
    /// [`SECTIONS_AT_ONCE`] elements.
    pub(crate) fn moment_rows(&mut self) -> (&RowBatch, &[f64]) {
        (self.tables.moments(&self.interval, &self.shared.grid.model), &self.modal_state)
    }

    /// Lateral motion at n.
    pub(crate) fn instant(&self) -> LateralState {
        LateralState {
            interval: Arc::clone(&self.interval),
            modal_state: self.modal_state.clone(),
            forces: self.spin.forces_now().collect(),
        }
    }

    /// Copies the lateral motion at n into an instant.
    pub(crate) fn copy_instant(&self, instant: &mut LateralState) {
        let LateralState { interval, modal_state, forces } = instant;
        interval.clone_from(&self.interval);
        modal_state.clone_from(&self.modal_state);
        forces.clear();
        forces.extend(self.spin.forces_now());
    }

    /// Powers at n \[W\]: dissipated by the bearings' damping, fed in by their skew stiffness, and the dissipation of all damping
    /// less the latter (0 where `with_all_damping` is false). `bearing_motion` is a buffer.
    pub(crate) fn damping_powers(&mut self, with_all_damping: bool, bearing_motion: &mut Vec<f64>) -> ([f64; 2], f64) {
        let Self { interval, tables, modal_state, shared, step, .. } = self;
        let model = &shared.grid.model;
        tables.bearings(interval, model).multiply(modal_state, bearing_motion);
        let whole =
            if with_all_damping { tables.dissipation(interval, model, *step).power_at(modal_state) } else { 0.0 };
        (model.measures.bearing_powers(bearing_motion, std::iter::empty(), &interval.table_changes), whole)
    }

    /// Powers of [`FreeMotion::damping_powers`] at an instant with contact impulses: those of the bearings take the mean of
    /// their rates before and after the impulses, that of all damping is the mean over the contact step behind them. The instant is
    /// afterwards that behind the impulses.
    pub(crate) fn damping_powers_after(
        &mut self,
        instant: &mut LateralState,
        impulses: &[ContactImpulse],
        with_all_damping: bool,
        (bearing_motion, buffer): (&mut Vec<f64>, &mut DissipationBuffer),
    ) -> ([f64; 2], f64) {
        let (LateralState { interval, modal_state, forces }, model, h) = (instant, &self.shared.grid.model, self.step);
        self.tables.bearings(interval, model).multiply(modal_state, bearing_motion);
        let by_diaphragm = impulses.iter().map(|contact| (contact.diaphragm, contact.impulse));
        let bearings = model.measures.bearing_powers(bearing_motion, by_diaphragm, &interval.table_changes);
        if !with_all_damping {
            return (bearings, 0.0);
        }
        for contact in impulses {
            interval.apply_contact_impulse(contact.diaphragm, contact.impulse, modal_state);
        }
        let table = self.tables.dissipation(interval, model, h);
        (bearings, table.power(interval.forced_dissipation(table, h), h, modal_state, forces, buffer))
    }

    /// Stored energy at n for these rates of the lateral coordinates; `q` and `buffer` have their size.
    pub(crate) fn stored_energy(&mut self, rates: &[f64], q: &mut Vec<f64>, buffer: &mut Vec<f64>) -> StoredEnergy {
        self.lateral_coordinates(q);
        let model = &self.shared.grid.model;
        let mut stored = model.measures.stored_energy([q, rates], buffer);
        stored.energy += self.table_energy(q);
        stored
    }

    /// Strain energy at n that the bearing tables add to that of their constant parts \[J\]; `q`: lateral coordinates at n.
    pub(crate) fn table_energy(&self, q: &[f64]) -> f64 {
        self.shared.grid.model.state_space.tables.strain_energy(&self.interval.table_changes, q)
    }
}
