//! Free flight: a shaft line that touches nothing, in steps of any size.

use super::shared_model::SharedModel;
use super::step_kernels::{finish_kernel, impulse_kernel, propagate_kernel};
use crate::engine::beginning::initial_motion;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::modal::displacement_bound::length;
use crate::engine::exponential::modal::dissipation::DissipationBuffer;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::modal::interval_tables::IntervalTables;
use crate::engine::exponential::modal::peak_bound::WatchedPeak;
use crate::engine::exponential::modal::propagator::Propagator;
use crate::engine::exponential::modal::section_loads::{SECTIONS_AT_ONCE, StoredEnergy, sizes_of};
use crate::engine::exponential::modal::speed_grid::{CellDamping, SpeedInterval};
use crate::engine::exponential::modal::step_bounds::StateBounds;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::exponential::torsion::gyroscopic_torque::{GyroscopicMomenta, GyroscopicTorque};
use crate::engine::exponential::torsion::spin::{ContactImpulse, Spin, SpinStep};
use crate::linalg::dot;
use crate::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};
use nalgebra::Complex;
use std::sync::Arc;

/// Turn of the rotor at its first speed from one gyroscopic momentum to the next \[rad\]. It is a product of all pairs with all, 1e-5 of the spin's momentum, and changes
/// slowly: what lies between shifts the spin until the next, and adds to nothing.
const GYROSCOPIC_STEP: f64 = 0.2;
/// Change of the spin over a contact step, as a part of it, from which on it is taken at each step: a ring that stops a rotor makes it whirl faster than it turns.
const FAST_FALL: f64 = 2e-4;
/// What may come back over a contact step ([`Spin::comes_back`]) for modes of twist that the step does not resolve to be damped by it.
const MAX_WITHHELD: f64 = 0.05;
/// The trial step from which the first slope of the spin is taken, as a part of the step.
const TRIAL: f64 = 1.0 / 64.0;

/// Whirl states at n, their cell, and the unbalances' forces on their nodes \[N\].
#[derive(Debug)]
pub(crate) struct Instant {
    interval: Arc<SpeedInterval>,
    modal_state: Vec<f64>,
    forces: Vec<Complex<f64>>,
}

/// A shaft line in free flight.
#[derive(Debug, Clone)]
pub struct FreeMotion {
    shared: Arc<SharedModel>,
    cell: Arc<SpeedInterval>,
    tables: IntervalTables,
    /// Whirl states, and room for the next.
    y: Vec<f64>,
    scratch: Vec<f64>,
    /// Outputs of y.
    outputs: Vec<f64>,
    spin: Spin,
    step: f64,
    /// Time in steps.
    contact_steps: u64,
    /// Tables of `2^level` steps.
    spin_steps: Vec<SpinStep>,
    /// Of a step that the cells have no propagator for.
    trial: Option<Propagator>,
    state_bounds: StateBounds,
    /// The last gyroscopic momentum, with its time in steps, and the steps to the next.
    gyroscopic: (u64, f64),
    gyroscopic_steps: u64,
    /// Gyroscopic torques on the torsional modes, with their momenta at n.
    gyration: Option<(Arc<GyroscopicTorque>, GyroscopicMomenta)>,
}

impl FreeMotion {
    /// A machine at t = 0.
    ///
    /// # Errors
    /// [`ExponentialError`] of a machine that this engine has no basis for, or does not cover.
    pub fn new(machine: &Machine, structure: &Structure, settings: StepSettings) -> Result<Self, ExponentialError> {
        if machine.run.engine == Engine::Full {
            return Err(ExponentialError::NotCovered { what: "finite-element coordinates (run.engine = \"full\")" });
        }
        if machine.rotor.speed_law.is_some() {
            return Err(ExponentialError::NotCovered { what: "a prescribed speed (rotor.speed_law)" });
        }
        let (q, velocity) = initial_motion(machine, structure)?;
        let shared = SharedModel::of(machine, structure, settings)?;
        let mut spin = Spin::new(machine, structure)?;
        let grid = &shared.grid;
        let cell = grid.interval(grid.index_of(spin.speed))?;
        let motion: Vec<f64> = q.iter().chain(&velocity).copied().collect();
        let y = cell.state_of(&motion).ok_or(ExponentialError::NoBasis { speed: spin.speed })?;
        let unbalances = spin.unbalances();
        let mut flight = Self {
            scratch: vec![0.0; y.len()],
            outputs: Vec::new(),
            state_bounds: StateBounds::default(),
            step: settings.step,
            contact_steps: 0,
            spin_steps: Vec::new(),
            trial: None,
            cell,
            tables: IntervalTables::default(),
            y,
            gyroscopic: (0, 0.0),
            gyroscopic_steps: (GYROSCOPIC_STEP / (spin.speed.abs() * settings.step)) as u64,
            spin: spin.clone(),
            gyration: None,
            shared,
        };
        flight.evaluate_outputs();
        flight.gyroscopic.1 = flight.gyroscopic_momentum();
        spin.start(flight.unbalance_velocities(), flight.gyroscopic.1);
        flight.spin = spin;
        if let Some(gyration) = GyroscopicTorque::of(machine, structure, &flight.spin) {
            flight.start_gyroscopic_torque(gyration);
        }
        let back = flight.feedback(0);
        if !flight.spin.is_stable(settings.step, back, machine.run.end_time) {
            if back > MAX_WITHHELD {
                return Err(ExponentialError::NotCovered {
                    what: "an unbalance on a bare shaft with so little damping of the twist (rotor.damping.torsional)",
                });
            }
            flight.spin.stabilise(settings.step, back);
        }
        let mut trial = flight.clone();
        trial.step = TRIAL * settings.step;
        trial.trial = Some(Propagator::new(&trial.cell.model, unbalances, trial.step));
        for _ in 0..2 {
            trial.advance(0)?;
        }
        flight.spin.copy_slope(&trial.spin);
        Ok(flight)
    }

    /// Takes a step of `2^level` times the step of the settings.
    ///
    /// # Errors
    /// [`ExponentialError`] where the spin reaches a speed that has no basis.
    pub fn advance(&mut self, level: usize) -> Result<(), ExponentialError> {
        self.propagate(level)?;
        self.complete_step(level, None)
    }

    /// The whirl states at the end of a step in which nothing is touched; the spin's follow in [`Flight::finish`].
    pub(crate) fn propagate(&mut self, level: usize) -> Result<(), ExponentialError> {
        while self.spin_steps.len() <= level {
            self.spin_steps.push(self.spin.step(self.step_length(self.spin_steps.len())));
        }
        let propagator = match &self.trial {
            Some(trial) => trial,
            None => self.cell.propagator(level, self.step),
        };
        let (step, local) = (&self.spin_steps[level], &self.cell.model);
        propagate_kernel(&mut self.spin, step, propagator, local, &mut self.y, &mut self.outputs);
        Ok(())
    }

    /// Ends a step that [`Flight::propagate`] has begun, with a blow at n where there was one.
    pub(crate) fn complete_step(&mut self, level: usize, blow: Option<ContactImpulse>) -> Result<(), ExponentialError> {
        let mut blow = blow.and_then(|blow| Some((self.cell.impulse_response(self.step)?, blow)));
        self.contact_steps += 1 << level;
        if self.gyration.is_some()
            || self.spin_falls_fast()
            || self.contact_steps - self.gyroscopic.0 >= self.gyroscopic_steps
        {
            if let Some(struck) = blow.take() {
                impulse_kernel(
                    &mut self.spin,
                    &self.spin_steps[level],
                    &self.cell.model,
                    struck,
                    &mut self.y,
                    &mut self.outputs,
                );
            }
            self.gyroscopic = (self.contact_steps, self.tables.momentum(&self.cell).value(&self.y));
            if let Some((gyration, now)) = &mut self.gyration {
                let model = &self.shared.grid.model;
                self.tables.displacements(&self.cell, model).multiply(&self.y, &mut now.places);
                self.tables.velocities(&self.cell, model).multiply(&self.y, &mut now.rates);
                gyration.update(now);
                self.spin.apply_gyroscopic_torque(&now.changes, 1.0 / self.step * libm::exp2(-(level as f64)));
            }
        }
        let (step, local) = (&self.spin_steps[level], &self.cell.model);
        finish_kernel(&mut self.spin, step, local, self.gyroscopic.1, blow, &mut self.y, &mut self.outputs);
        let grid = &self.shared.grid;
        // a rotor that has stopped goes nowhere
        if self.spin.speed <= 0.0 {
            return Ok(());
        }
        if grid.jumps_too_far(&self.cell, self.spin.speed) {
            return Err(ExponentialError::NoBasis { speed: self.spin.speed });
        }
        let mut crossed = false;
        while grid.has_left(&self.cell, self.spin.speed) {
            let up = self.spin.speed > self.cell.model.speed;
            let next = grid.interval(if up { self.cell.index + 1 } else { self.cell.index - 1 })?;
            grid.change_basis(&self.cell, &next, &mut self.y, &mut self.scratch);
            self.cell = next;
            crossed = true;
        }
        if crossed {
            // what cells differ by would move a node that a bearing all but holds, whose load would jump for a step
            let loads = self.shared.grid.model.outputs.load_rows();
            let before: Vec<[f64; 2]> = loads.iter().map(|&at| [self.outputs[at], self.outputs[at + 1]]).collect();
            self.evaluate_outputs();
            for (at, load) in loads.into_iter().zip(before) {
                self.outputs[at..at + 2].copy_from_slice(&load);
            }
        }
        Ok(())
    }

    /// Takes the momenta of the torsional modes at the start.
    fn start_gyroscopic_torque(&mut self, gyration: GyroscopicTorque) {
        let mut now = GyroscopicMomenta::default();
        self.lateral_coordinates(&mut now.places);
        self.lateral_rates(&mut now.rates);
        gyration.update(&mut now);
        self.spin.apply_gyroscopic_torque(&now.changes, 0.0);
        self.gyration = Some((Arc::new(gyration), now));
    }

    /// Whether the spin changes so fast that what is looked at from time to time is looked at more often.
    pub(crate) fn spin_falls_fast(&self) -> bool {
        self.spin.slope().abs() * self.step > FAST_FALL * self.spin.speed.abs()
    }

    /// Length of a step of `2^level` steps \[s\].
    pub(crate) fn step_length(&self, level: usize) -> f64 {
        self.step * libm::exp2(level as f64)
    }

    /// Whether no mode of twist grows in steps of a level over a run of `time` \[s\]: [`Spin::holds`].
    pub(crate) fn is_stable(&self, level: usize, time: f64) -> bool {
        self.spin.is_stable(self.step_length(level), self.feedback(level), time)
    }

    /// [`Spin::comes_back`] over steps of a level.
    fn feedback(&self, level: usize) -> f64 {
        let (local, h) = (&self.cell.model, self.step_length(level));
        let propagator = self.cell.propagator(level, self.step);
        let answers = (0..self.spin.unbalances()).map(|s| dot(&local.output_rows[2 * s], &propagator.of_force(s)) / h);
        self.spin.feedback(answers)
    }

    /// Time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.contact_steps as f64 * self.step
    }

    /// Spin \[rad/s\].
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.spin.mean()[0]
    }

    /// Mean spin angle \[rad\].
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.spin.mean()[1]
    }

    /// Load of a bearing, in the machine's order \[N\].
    #[must_use]
    pub fn load(&self, bearing: usize) -> [f64; 2] {
        let first = self.shared.grid.model.outputs.load_row(bearing);
        let direct = &self.shared.feedthrough[bearing];
        let mut load = [0, 1].map(|i| self.outputs[first + i] + direct.constant[i]);
        for (at_once, force) in direct.of_force.iter().zip(self.spin.forces_now()) {
            load[0] += at_once[0] * force.re + at_once[1] * force.im;
            load[1] += at_once[2] * force.re + at_once[3] * force.im;
        }
        load
    }

    /// What a bearing's load has at once of a force on the first diaphragm's node \[N\].
    pub(crate) fn load_with_feedthrough(&self, bearing: usize, force: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.shared.feedthrough[bearing].of_contact[0];
        [a * force[0] + b * force[1], c * force[0] + d * force[1]]
    }

    /// Displacement \[m\] and velocity \[m/s\] of the rotor at a diaphragm's contact.
    #[must_use]
    pub fn contact_motion(&self, diaphragm: usize) -> [[f64; 2]; 2] {
        let first = self.shared.grid.model.outputs.contact_row(diaphragm);
        let at = &self.outputs[first..first + 4];
        [[at[0], at[1]], [at[2], at[3]]]
    }

    /// Displacement of the rotor at a diaphragm's contact \[m\].
    pub(crate) fn contact_displacement(&self, diaphragm: usize) -> [f64; 2] {
        let first = self.shared.grid.model.outputs.contact_row(diaphragm);
        [self.outputs[first], self.outputs[first + 1]]
    }

    /// Number of the cell in the grid.
    #[inline]
    pub(crate) fn interval_index(&self) -> i64 {
        self.cell.index
    }

    /// Damping of whirl modes, at the stations of the cell first.
    pub(crate) fn damping(&self) -> CellDamping<'_> {
        self.shared.grid.damping(&self.cell)
    }

    /// Time in contact steps.
    pub(crate) fn contact_steps(&self) -> u64 {
        self.contact_steps
    }

    /// Speeds of the grid that have been computed, and a bound of the condition of their bases.
    #[must_use]
    pub fn visited_bases(&self) -> (usize, f64) {
        self.shared.grid.visited_bases()
    }

    /// Lateral coordinates, and zeros up to a multiple of eight.
    pub(crate) fn lateral_coordinates(&mut self, q: &mut Vec<f64>) {
        self.tables.displacements(&self.cell, &self.shared.grid.model).multiply(&self.y, q);
    }

    /// Their rates, and zeros up to a multiple of eight.
    pub(crate) fn lateral_rates(&mut self, rates: &mut Vec<f64>) {
        self.tables.velocities(&self.cell, &self.shared.grid.model).multiply(&self.y, rates);
    }

    /// Gyroscopic momentum of now.
    pub(crate) fn gyroscopic_momentum(&mut self) -> f64 {
        self.tables.momentum(&self.cell).value(&self.y)
    }

    /// What the spin has to be shifted by to have this gyroscopic momentum, that of now, instead of the last one that was taken \[rad/s\].
    pub(crate) fn gyroscopic_speed_shift(&self, gyroscopic: f64) -> f64 {
        (self.gyroscopic.1 - gyroscopic) * self.spin.compliance()
    }

    /// Bounds of what is measured of the whole motion at n: the bending moment of each [`BESIDE`] elements \[N m\], then all displacements [m, rad].
    pub(crate) fn moment_bounds(&mut self, bounds: &mut Vec<f64>) {
        let Self { cell, tables, y, scratch, shared, .. } = self;
        let (a, b) = y.split_at(y.len() / 2);
        let amplitudes = &mut scratch[..a.len()];
        sizes_of(a, b, amplitudes);
        tables.bounds(cell, &shared.grid.model).multiply(amplitudes, bounds);
    }

    /// Bending moments of so many elements from `BESIDE block` on \[N m\].
    pub(crate) fn moments(&mut self, block: usize) -> [f64; 4 * SECTIONS_AT_ONCE] {
        self.tables.moments(&self.cell, &self.shared.grid.model).multiply_block(block, &self.y)
    }

    /// The whirl states at n.
    pub(crate) fn instant(&self) -> Instant {
        Instant {
            interval: Arc::clone(&self.cell),
            modal_state: self.y.clone(),
            forces: self.spin.forces_now().collect(),
        }
    }

    /// Makes an instant that of n.
    pub(crate) fn copy_instant(&self, instant: &mut Instant) {
        let Instant { interval: cell, modal_state: y, forces } = instant;
        cell.clone_from(&self.cell);
        y.clone_from(&self.y);
        forces.clear();
        forces.extend(self.spin.forces_now());
    }

    /// Powers at n that bearings' damping takes and that their skew stiffness puts in, and what all damping takes less the latter \[W\], 0 where that is not asked for; `room` for the bearings' motion.
    pub(crate) fn damping_powers(&mut self, loses: bool, room: &mut Vec<f64>) -> ([f64; 2], f64) {
        let Self { cell, tables, y, shared, step, .. } = self;
        let model = &shared.grid.model;
        tables.bearings(cell, model).multiply(y, room);
        let whole = if loses { tables.dissipation(cell, model, *step).power_at(y) } else { 0.0 };
        (model.measures.bearing_powers(room, [0.0; 2]), whole)
    }

    /// The same at an instant with an impulse: those of the bearings' mean rates there, and the mean of what all damping takes over the contact step behind it. The instant is that behind the impulse then.
    pub(crate) fn damping_powers_after(
        &mut self,
        instant: &mut Instant,
        impulse: [f64; 2],
        loses: bool,
        (room, within): (&mut Vec<f64>, &mut DissipationBuffer),
    ) -> ([f64; 2], f64) {
        let (Instant { interval: cell, modal_state: y, forces }, model, h) =
            (instant, &self.shared.grid.model, self.step);
        self.tables.bearings(cell, model).multiply(y, room);
        let bearings = model.measures.bearing_powers(room, impulse);
        if !loses {
            return (bearings, 0.0);
        }
        cell.apply_contact_impulse(impulse, y);
        let table = self.tables.dissipation(cell, model, h);
        (bearings, table.power(cell.forced_dissipation(table, h), h, y, forces, within))
    }

    /// Energies at n, of the rates there; `q` and `room`: of their size.
    pub(crate) fn stored_energy(&mut self, rates: &[f64], q: &mut Vec<f64>, room: &mut Vec<f64>) -> StoredEnergy {
        self.lateral_coordinates(q);
        self.shared.grid.model.measures.stored_energy([q, rates], room)
    }

    /// Sees what is ahead of n: the velocity of the first diaphragm's node in its cell \[m/s\].
    pub(crate) fn bound_states(&mut self) -> [f64; 2] {
        let Self { cell, y, state_bounds: sight, spin, step, .. } = self;
        cell.step_bounds(*step).bound_states(y, spin.forces_now(), sight)
    }

    /// The longest of the steps up to a level after which the first diaphragm's node, which is at x and moves with a velocity, is within a distance
    /// all the time; `None` where none is. After [`Flight::see_ahead`].
    pub(crate) fn longest_step_within(
        &self,
        lengths: &[f64],
        [x, velocity]: [[f64; 2]; 2],
        within: f64,
        most: usize,
    ) -> Option<usize> {
        let here = length(x);
        (0..=most).rev().find(|&level| {
            let h = lengths[level];
            let there = length([x[0] + h * velocity[0], x[1] + h * velocity[1]]);
            here.max(there) + self.max_deviation(level) < within
        })
    }

    /// How far the first diaphragm's node may be after a step of a level from where its velocity would take it \[m\]; after [`Flight::see_ahead`].
    pub(crate) fn max_deviation(&self, level: usize) -> f64 {
        let Self { cell, state_bounds: sight, spin, step, shared, .. } = self;
        let row = shared.grid.model.outputs.contact_row(0);
        cell.step_bounds(*step).max_deviation(&cell.model, row, level, sight, spin.speed)
    }

    /// The longest of the steps up to a level over which no peak of what is watched is missed: the loads of the bearings, and the place of the first
    /// diaphragm's node; after [`Flight::see_ahead`].
    pub(crate) fn longest_resolved_step(&self, watched: &[WatchedPeak], most: usize) -> usize {
        self.cell.step_bounds(self.step).longest_resolved_step(&self.cell.model, watched, &self.state_bounds, most)
    }

    /// What a bearing's load has whatever the motion is \[N\].
    pub(crate) fn constant_load(&self, bearing: usize) -> [f64; 2] {
        self.shared.feedthrough[bearing].constant
    }

    /// What impulses on the first diaphragm's node make in a contact step; `None` without one.
    pub(crate) fn impulse_response(&self) -> Option<&ImpulseResponse> {
        self.cell.impulse_response(self.step)
    }

    /// The spin.
    pub(crate) fn spin(&self) -> &Spin {
        &self.spin
    }

    /// Velocities of the unbalances' nodes \[m/s\].
    pub(crate) fn unbalance_velocities(&self) -> &[[f64; 2]] {
        &self.outputs.as_chunks::<2>().0[..self.spin.unbalances()]
    }

    /// What runs of this model share.
    pub(crate) fn shared(&self) -> &Arc<SharedModel> {
        &self.shared
    }

    fn evaluate_outputs(&mut self) {
        self.cell.model.output_matrix.multiply(&self.y, &mut self.outputs);
    }
}
