//! Motion of a shaft line without contact, in steps of any size.
//!
//! A step has two halves. [`FreeMotion::propagate`] takes the motion to n+1 as if nothing were touched; a contact step finds its
//! impulses there. [`FreeMotion::complete_step`] adds the response to these impulses, finds the spin from its momentum, and
//! changes the modal basis where the spin has left its speed interval.

use super::shared_model::SharedModel;
use super::step_kernels::{finish_kernel, impulse_kernel, propagate_kernel};
use crate::engine::beginning::initial_motion;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::modal::interval_tables::IntervalTables;
use crate::engine::exponential::modal::outputs::DirectFeedthrough;
use crate::engine::exponential::modal::peak_bound::WatchedPeak;
use crate::engine::exponential::modal::propagator::Propagator;
use crate::engine::exponential::modal::speed_grid::IntervalDamping;
use crate::engine::exponential::modal::speed_interval::SpeedInterval;
use crate::engine::exponential::modal::step_bounds::StateBounds;
use crate::engine::exponential::plane::length;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::exponential::torsion::gyroscopic_torque::{GyroscopicMomenta, GyroscopicTorque};
use crate::engine::exponential::torsion::spin::{ContactImpulse, Spin, SpinStep};
use crate::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_numerics::linalg::dot;
use std::sync::Arc;

/// Turn of the rotor at its initial speed, or the highest one of a prescribed speed, between two evaluations of the gyroscopic momentum \[rad\]. This momentum is a
/// quadratic form of all modal states, 1e-5 of the spin's momentum, and changes slowly. Its change between two evaluations shifts
/// the spin until the next one; these shifts do not add up.
const GYROSCOPIC_STEP: f64 = 0.2;
/// Relative change of the spin over a contact step above which the gyroscopic momentum is evaluated in every step. A rotor that
/// its ring stops whirls faster than it turns.
const FAST_SPIN_CHANGE: f64 = 2e-4;
/// Largest feedback of the unbalances on the torsion over a contact step ([`Spin::feedback`]) that added damping may stabilise.
const MAX_FEEDBACK: f64 = 0.05;
/// Length of the trial step that gives the initial slope of the spin, as a part of a contact step.
pub(super) const TRIAL_STEP: f64 = 1.0 / 64.0;

/// Shaft line without contact: the lateral modal state, the spin and the torsion at n.
#[derive(Debug, Clone)]
pub struct FreeMotion {
    pub(super) shared: Arc<SharedModel>,
    /// Speed interval that contains the spin.
    pub(super) interval: Arc<SpeedInterval>,
    /// Tables of the interval for observing the motion.
    pub(super) tables: IntervalTables,
    /// Modal state y at n: first coordinates of all modal planes, then their second ones. And a buffer of its size.
    pub(super) modal_state: Vec<f64>,
    pub(super) scratch: Vec<f64>,
    /// Outputs of y: velocities of the unbalances' nodes \[m/s\], loads \[N\], displacement \[m\] and velocity \[m/s\] at each
    /// contact.
    outputs: Vec<f64>,
    pub(super) spin: Spin,
    /// Contact step \[s\].
    pub(super) step: f64,
    /// Time in contact steps.
    contact_steps: u64,
    /// Tables of spin and torsion for steps of 2^k contact steps, by k.
    pub(super) spin_steps: Vec<SpinStep>,
    /// Propagator of the trial step at t = 0, for which the intervals have none.
    pub(super) trial: Option<Propagator>,
    /// Bounds of the state at n for the choice of the next step.
    state_bounds: StateBounds,
    /// Last gyroscopic momentum \[kg m2/s\] with its time in contact steps, and the number of contact steps to the next
    /// evaluation.
    pub(super) gyroscopic: (u64, f64),
    gyroscopic_steps: u64,
    /// Gyroscopic torques on the torsional modes with their momenta at n; `None` where they do not matter.
    gyroscopic_torque: Option<(Arc<GyroscopicTorque>, GyroscopicMomenta)>,
    /// Work of the bearing tables, whose stiffness changes with the speed \[J\].
    table_work: f64,
}

/// Motion from which the propagation of a shaft line starts.
pub(super) struct Start {
    /// Lateral coordinates and their rates.
    pub motion: [Vec<f64>; 2],
    /// Spin and torsion, before [`Spin::start`].
    pub spin: Spin,
    /// Time in contact steps, and work of the bearing tables so far \[J\].
    pub contact_steps: u64,
    pub table_work: f64,
}

/// Initial speed, or the highest one of a prescribed speed \[rad/s\].
fn highest_speed(machine: &Machine) -> f64 {
    let law = machine.rotor.speed_law.iter().flat_map(|law| law.speeds.iter().copied());
    law.fold(machine.rotor.initial_speed.abs(), f64::max)
}

impl FreeMotion {
    /// Creates the motion of a machine at t = 0.
    ///
    /// # Errors
    /// [`ExponentialError`] for a machine without a modal basis, or one that this engine does not cover.
    pub fn new(machine: &Machine, structure: &Structure, settings: StepSettings) -> Result<Self, ExponentialError> {
        if machine.run.engine == Engine::Full {
            return Err(ExponentialError::NotCovered { what: "finite-element coordinates (run.engine = \"full\")" });
        }
        let (q, velocity) = initial_motion(machine, structure)?;
        let shared = SharedModel::of(machine, structure, settings)?;
        let spin = Spin::new(machine, structure)?;
        let start = Start { motion: [q, velocity], spin, contact_steps: 0, table_work: 0.0 };
        Self::begin(machine, structure, settings, shared, start)
    }

    /// Begins the motion of a machine from a start.
    ///
    /// # Errors
    /// As [`FreeMotion::new`].
    pub(super) fn begin(
        machine: &Machine,
        structure: &Structure,
        settings: StepSettings,
        shared: Arc<SharedModel>,
        start: Start,
    ) -> Result<Self, ExponentialError> {
        let Start { motion: [q, velocity], mut spin, contact_steps, table_work } = start;
        let grid = &shared.grid;
        let interval = grid.interval(grid.index_of(spin.speed))?;
        let initial: Vec<f64> = q.iter().chain(&velocity).copied().collect();
        let modal_state = interval.state_of(&initial).ok_or(ExponentialError::NoBasis { speed: spin.speed })?;
        let unbalances = spin.unbalance_count();
        let mut motion = Self {
            scratch: vec![0.0; modal_state.len()],
            outputs: Vec::new(),
            state_bounds: StateBounds::default(),
            step: settings.step,
            contact_steps,
            spin_steps: Vec::new(),
            trial: None,
            interval,
            tables: IntervalTables::default(),
            modal_state,
            gyroscopic: (contact_steps, 0.0),
            gyroscopic_steps: (GYROSCOPIC_STEP / (highest_speed(machine) * settings.step)) as u64,
            spin: spin.clone(),
            gyroscopic_torque: None,
            table_work,
            shared,
        };
        motion.evaluate_outputs();
        motion.gyroscopic.1 = motion.gyroscopic_momentum();
        spin.start(motion.unbalance_velocities(), motion.gyroscopic.1);
        motion.spin = spin;
        if let Some(torque) = GyroscopicTorque::of(machine, structure, &motion.spin) {
            motion.start_gyroscopic_torque(torque);
        }
        let feedback = motion.feedback(0);
        if !motion.spin.is_stable(settings.step, feedback, machine.run.end_time) {
            if feedback > MAX_FEEDBACK {
                return Err(ExponentialError::NotCovered {
                    what: "an unbalance on a bare shaft with so little torsional damping (rotor.damping.torsional)",
                });
            }
            motion.spin.stabilise(settings.step, feedback);
        }
        let mut trial = motion.clone();
        trial.step = TRIAL_STEP * settings.step;
        trial.trial = Some(Propagator::new(&trial.interval.model, unbalances, trial.step));
        for _ in 0..2 {
            trial.advance(0)?;
        }
        motion.spin.copy_slope(&trial.spin);
        Ok(motion)
    }

    /// Takes a step of `2^doublings` contact steps without contact.
    ///
    /// # Errors
    /// [`ExponentialError`] where the spin reaches a speed without a modal basis.
    pub fn advance(&mut self, doublings: usize) -> Result<(), ExponentialError> {
        self.propagate(doublings)?;
        self.complete_step(doublings, &[])
    }

    /// Takes the lateral motion to the end of a step of `2^doublings` contact steps as if nothing were touched. The step ends
    /// with [`FreeMotion::complete_step`].
    pub(crate) fn propagate(&mut self, doublings: usize) -> Result<(), ExponentialError> {
        while self.spin_steps.len() <= doublings {
            self.spin_steps.push(self.spin.step(self.step_length(self.spin_steps.len())));
        }
        let propagator = match &self.trial {
            Some(trial) => trial,
            None => self.interval.propagator(doublings, self.step),
        };
        let (step, model) = (&self.spin_steps[doublings], &self.interval.model);
        propagate_kernel(&mut self.spin, step, propagator, model, &mut self.modal_state, &mut self.outputs);
        Ok(())
    }

    /// Takes the motion to the end of a trial step, without what completes a step.
    pub(super) fn propagate_first(&mut self) {
        let step = self.spin.step(self.step);
        if let Some(propagator) = &self.trial {
            let model = &self.interval.model;
            propagate_kernel(&mut self.spin, &step, propagator, model, &mut self.modal_state, &mut self.outputs);
        }
    }

    /// Ends a step that [`FreeMotion::propagate`] has begun, with the contact impulses at n.
    pub(crate) fn complete_step(
        &mut self,
        doublings: usize,
        impulses: &[ContactImpulse],
    ) -> Result<(), ExponentialError> {
        self.contact_steps += 1 << doublings;
        let needs_momentum = self.gyroscopic_torque.is_some()
            || self.spin_changes_fast()
            || self.contact_steps - self.gyroscopic.0 >= self.gyroscopic_steps;
        let mut contact = None;
        for impulse in impulses {
            let response = (self.interval.impulse_response(impulse.diaphragm, self.step), *impulse);
            // one impulse is added as the step ends
            if impulses.len() == 1 && !needs_momentum {
                contact = Some(response);
            } else {
                impulse_kernel(
                    &mut self.spin,
                    &self.spin_steps[doublings],
                    &self.interval.model,
                    response,
                    &mut self.modal_state,
                    &mut self.outputs,
                );
            }
        }
        if needs_momentum {
            self.gyroscopic = (self.contact_steps, self.tables.momentum(&self.interval).value(&self.modal_state));
            if let Some((torque, momenta)) = &mut self.gyroscopic_torque {
                let model = &self.shared.grid.model;
                self.tables.displacements(&self.interval, model).multiply(&self.modal_state, &mut momenta.coordinates);
                self.tables.velocities(&self.interval, model).multiply(&self.modal_state, &mut momenta.rates);
                torque.update(momenta);
                self.spin.apply_gyroscopic_torque(&momenta.changes, 1.0 / self.step * libm::exp2(-(doublings as f64)));
            }
        }
        let (step, model) = (&self.spin_steps[doublings], &self.interval.model);
        finish_kernel(
            &mut self.spin,
            step,
            model,
            self.gyroscopic.1,
            contact,
            &mut self.modal_state,
            &mut self.outputs,
        );
        let grid = &self.shared.grid;
        // a rotor that has stopped stays in its speed interval
        if self.spin.speed <= 0.0 && !self.spin.starts_at_rest() {
            return Ok(());
        }
        if grid.jumps_too_far(&self.interval, self.spin.speed) {
            return Err(ExponentialError::NoBasis { speed: self.spin.speed });
        }
        let mut changed = false;
        while grid.has_left(&self.interval, self.spin.speed) {
            let up = self.spin.speed > self.interval.model.speed;
            let next = grid.interval(if up { self.interval.index + 1 } else { self.interval.index - 1 })?;
            grid.change_basis(&self.interval, &next, &mut self.modal_state, &mut self.scratch);
            if !next.table_changes.is_empty() {
                let (measures, motion) = (&grid.model.measures, &mut self.scratch);
                self.tables.bearings(&next, &grid.model).multiply(&self.modal_state, motion);
                self.table_work += measures.table_work(motion, [&self.interval.table_changes, &next.table_changes]);
                motion.resize(self.modal_state.len(), 0.0);
            }
            self.interval = next;
            changed = true;
        }
        if changed {
            // loads at n+1 are those of the old interval: the bases of two intervals differ a little, and at a node that a
            // bearing with strong damping almost holds this difference would be a jump of the load for one step
            let load_rows = self.shared.grid.model.outputs.load_rows();
            let before: Vec<[f64; 2]> =
                load_rows.iter().map(|&row| [self.outputs[row], self.outputs[row + 1]]).collect();
            self.evaluate_outputs();
            for (row, load) in load_rows.into_iter().zip(before) {
                self.outputs[row..row + 2].copy_from_slice(&load);
            }
        }
        Ok(())
    }

    /// Starts the gyroscopic torques with the momenta of the initial motion.
    fn start_gyroscopic_torque(&mut self, torque: GyroscopicTorque) {
        let mut momenta = GyroscopicMomenta::default();
        self.lateral_coordinates(&mut momenta.coordinates);
        self.lateral_rates(&mut momenta.rates);
        torque.update(&mut momenta);
        self.spin.apply_gyroscopic_torque(&momenta.changes, 0.0);
        self.gyroscopic_torque = Some((Arc::new(torque), momenta));
    }

    /// Whether the spin changes over a contact step by more than the fraction [`FAST_SPIN_CHANGE`] of its value. Dissipation and energies are then
    /// observed at shorter intervals.
    pub(crate) fn spin_changes_fast(&self) -> bool {
        self.spin.slope().abs() * self.step > FAST_SPIN_CHANGE * self.spin.speed.abs()
    }

    /// Length of a step of `2^doublings` contact steps \[s\].
    pub(crate) fn step_length(&self, doublings: usize) -> f64 {
        self.step * libm::exp2(doublings as f64)
    }

    /// Whether no torsional mode grows over a run of `time` \[s\] in steps of `2^doublings` contact steps ([`Spin::is_stable`]).
    pub(crate) fn is_stable(&self, doublings: usize, time: f64) -> bool {
        self.spin.is_stable(self.step_length(doublings), self.feedback(doublings), time)
    }

    /// Feedback of the unbalances on the torsion over a step of `2^doublings` contact steps ([`Spin::feedback`]).
    fn feedback(&self, doublings: usize) -> f64 {
        let (model, h) = (&self.interval.model, self.step_length(doublings));
        let propagator = self.interval.propagator(doublings, self.step);
        let responses =
            (0..self.spin.unbalance_count()).map(|s| dot(&model.output_rows[2 * s], &propagator.of_force(s)) / h);
        self.spin.feedback(responses)
    }

    /// Time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.contact_steps as f64 * self.step
    }

    /// Mean spin of the rotor without unbalances \[rad/s\].
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.spin.rotor_rotation()[0]
    }

    /// Mean angle of the rotor without unbalances \[rad\].
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.spin.rotor_rotation()[1]
    }

    /// Load of a bearing at n, in the machine's order \[N\].
    #[must_use]
    #[inline]
    pub fn load(&self, bearing: usize) -> [f64; 2] {
        let first = self.shared.grid.model.outputs.load_row(bearing);
        let feedthrough = self.feedthrough(bearing);
        let mut load = [0, 1].map(|i| self.outputs[first + i] + feedthrough.constant[i]);
        for (direct, force) in feedthrough.of_force.iter().zip(self.spin.forces_now()) {
            load[0] += direct[0] * force.re + direct[1] * force.im;
            load[1] += direct[2] * force.re + direct[3] * force.im;
        }
        load
    }

    /// Load of a bearing that follows a force on a diaphragm's node instantly, through the truncated modes \[N\].
    pub(crate) fn load_with_feedthrough(&self, bearing: usize, diaphragm: usize, force: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.feedthrough(bearing).of_contact[diaphragm];
        [a * force[0] + b * force[1], c * force[0] + d * force[1]]
    }

    /// Displacement \[m\] and velocity \[m/s\] of the rotor at a diaphragm's contact, in the machine's axes.
    #[must_use]
    pub fn contact_motion(&self, diaphragm: usize) -> [[f64; 2]; 2] {
        let first = self.shared.grid.model.outputs.contact_row(diaphragm);
        let at = &self.outputs[first..first + 4];
        [[at[0], at[1]], [at[2], at[3]]]
    }

    /// Displacement of the rotor at a diaphragm's contact, in the machine's axes \[m\].
    pub(crate) fn contact_displacement(&self, diaphragm: usize) -> [f64; 2] {
        let first = self.shared.grid.model.outputs.contact_row(diaphragm);
        [self.outputs[first], self.outputs[first + 1]]
    }

    /// Index of the speed interval in the grid.
    #[inline]
    pub(crate) fn interval_index(&self) -> i64 {
        self.interval.index
    }

    /// Damping of the whirl modes at both grid speeds of the interval.
    pub(crate) fn damping(&self) -> IntervalDamping<'_> {
        self.shared.grid.damping(&self.interval)
    }

    /// Time in contact steps.
    pub(crate) fn contact_steps(&self) -> u64 {
        self.contact_steps
    }

    /// Number of grid speeds whose modal basis has been computed, and a bound of the condition of these bases.
    #[must_use]
    pub fn visited_bases(&self) -> (usize, f64) {
        self.shared.grid.visited_bases()
    }

    /// Evaluates the bounds of the state at n for the choice of the next step.
    pub(crate) fn bound_states(&mut self) {
        let Self { interval, modal_state, state_bounds, spin, step, .. } = self;
        interval.step_bounds(*step).bound_states(modal_state, spin.forces_now(), state_bounds);
    }

    /// Velocity of a diaphragm's node in the model of the interval \[m/s\], evaluated by [`FreeMotion::bound_states`].
    pub(crate) fn bounded_velocity(&self, diaphragm: usize) -> [f64; 2] {
        self.state_bounds.velocities[diaphragm]
    }

    /// Doublings of the longest step during which a diaphragm's node, now at x with a velocity \[m, m/s\], stays within a
    /// clearance of the ring's centre \[m\]; `None` where no step does. Uses the bounds of [`FreeMotion::bound_states`].
    #[inline(always)]
    pub(crate) fn longest_step_within(
        &self,
        diaphragm: usize,
        lengths: &[f64],
        [x, velocity]: [[f64; 2]; 2],
        clearance: f64,
        max_doublings: usize,
    ) -> Option<usize> {
        let distance = length(x);
        (0..=max_doublings).rev().find(|&doublings| {
            let h = lengths[doublings];
            let end_distance = length([x[0] + h * velocity[0], x[1] + h * velocity[1]]);
            distance.max(end_distance) + self.max_deviation(diaphragm, doublings) < clearance
        })
    }

    /// Displacement bound of a diaphragm's node over a step of `2^doublings` contact steps, from the straight line that
    /// its velocity gives \[m\]. Uses the bounds of [`FreeMotion::bound_states`].
    pub(crate) fn max_deviation(&self, diaphragm: usize, doublings: usize) -> f64 {
        let Self { interval, state_bounds, spin, step, .. } = self;
        interval.step_bounds(*step).max_deviation(&interval.model, diaphragm, doublings, state_bounds, spin.speed)
    }

    /// Doublings of the longest step that misses no peak of the watched quantities: bearing loads, journals, and displacements of
    /// the diaphragms' nodes. Uses the bounds of [`FreeMotion::bound_states`].
    pub(crate) fn longest_resolved_step(&self, watched: &[WatchedPeak], max_doublings: usize) -> usize {
        self.interval.step_bounds(self.step).longest_resolved_step(
            &self.interval.model,
            watched,
            &self.state_bounds,
            max_doublings,
        )
    }

    /// Direct feedthrough of a bearing's load.
    #[inline]
    fn feedthrough(&self, bearing: usize) -> &DirectFeedthrough {
        self.interval.feedthrough.get(bearing).unwrap_or_else(|| &self.shared.feedthrough[bearing])
    }

    /// Work of the bearing tables so far \[J\].
    pub(crate) fn table_work(&self) -> f64 {
        self.table_work
    }

    /// Lowest and highest speed of the bearing tables \[rad/s\]; 0 and infinity without tables.
    pub(crate) fn table_range(&self) -> [f64; 2] {
        self.shared.grid.model.state_space.tables.range()
    }

    /// Load of a bearing that does not depend on the motion: weight on the truncated modes \[N\].
    pub(crate) fn constant_load(&self, bearing: usize) -> [f64; 2] {
        self.feedthrough(bearing).constant
    }

    /// Response over a contact step to impulses on a diaphragm's node.
    pub(crate) fn impulse_response(&self, diaphragm: usize) -> &ImpulseResponse {
        self.interval.impulse_response(diaphragm, self.step)
    }

    /// Spin and torsion.
    pub(crate) fn spin(&self) -> &Spin {
        &self.spin
    }

    /// Velocities of the unbalances' nodes at n \[m/s\].
    pub(crate) fn unbalance_velocities(&self) -> &[[f64; 2]] {
        &self.outputs.as_chunks::<2>().0[..self.spin.unbalance_count()]
    }

    /// Modal bases and outputs that all runs of this model share.
    pub(crate) fn shared(&self) -> &Arc<SharedModel> {
        &self.shared
    }

    /// Evaluates the outputs of the modal state at n.
    fn evaluate_outputs(&mut self) {
        self.interval.model.output_matrix.multiply(&self.modal_state, &mut self.outputs);
    }
}
