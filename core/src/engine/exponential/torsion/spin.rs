//! Spin from its angular momentum, with the torsional modes and the unbalances: no accelerations, no iteration.
//!
//! ```text
//! psi_s = Phi + t_s.e + a_s                                angle of unbalance s: mean angle, torsion of its node, phase                 (1)
//! P     = J W + sum_s r_s + q'^T G q/2                     angular momentum; r_s of unbalance s, gyroscopic momentum                    (2)
//! P'    = T(W) + sum_s k_s + sum_k T_k(t)                  brakes, torques k_s of the unbalances: trapezoidal rule; torques over time   (3)
//! k_s - (r_s+ - r_s)/h                                     torque of unbalance s on the torsional modes over the step                   (4)
//! f_s   in the middle of the step                          with h psi'' = predicted psi'(n+1) - psi'(n)                                 (5)
//! D_s   = psi'(n+1) - predicted psi'(n+1)                  acts as an impulse on the lateral motion at n+1                              (6)
//! psi'(n+) = psi'(n) + (1/J + t_s.t) tau + D_w             each contact impulse, with the angular impulse tau at n                       (7)
//! D_w   = -sum_s m d Im(c_s e^{-i psi_s})/J                 c_s: jump of the velocity of unbalance s by it; on a radial spring
//! brakes dissipate -T times their turn over the step       h (W(n+) + W(n+1))/2 and that of the torsion                                 (8)
//! c0 part of T of a rotor that starts at rest              -J W(n+1)/h, cut to [-c0, c0]; W(n+1) without it                              (9)
//! ```
//! W: spin \[rad/s\]; Phi: its angle; e: amplitudes of the torsional modes, t: their rows at a node; J: inertia of the loaded
//! modes ([`super::loaded_modes`]); torques over time: [`super::torques`]; r, k, f and the impulse of a jump of psi': [`super::unbalance`].
//!
//! A step has three parts:
//!
//! 1. Prediction: angles and rates at n+1 follow from the last slope of the spin (second-order Adams-Bashforth rule) and the free
//!    torsional modes. (5) then moves the rotor.
//! 2. A contact impulse changes the prediction by (7). The jump of psi' is an impulse on the lateral motion at n, and h times the
//!    change of (5) is one at n+1. The torque k starts from the velocity after the impulse. (With that before it, energy errors of
//!    hard rubs were ten times as large, and of first order in the step.)
//! 3. Completion: the velocities at n+1 give W(n+1) by (2) and (3), and the torques (4). The impulse (6) changes psi' and z' such
//!    that r stays, so no equation has to be solved. The momentum has no drift.
//!
//! Stability: the step does not resolve all of the lateral response, so a part of r follows the predicted rates and feeds back
//! into the torsion ([`Spin::feedback`]). Torsional modes above the step's resolution may grow by this where their phase is near
//! half a turn a step. They are therefore predicted without the torques of the last step, and a step is as long as the damping of
//! the torsion allows ([`Spin::is_stable`]). Modes that the step resolves are predicted with these torques
//! ([`super::torsional_modes`]). Without them D is t.t h times (4) in every step, and the energy balance loses D (r+ - r)/2 per
//! step.
//!
//! Source: equations of Phi and of the torsion of docs/theory/01-shaft-line.md, integrated once. Limits: second order in the
//! step. In the gyroscopic moments on the lateral motion all sites turn with W. Gyroscopic torques act on the torsional modes
//! only where they matter ([`super::gyroscopic_torque`]). A rotor that starts at rest may turn in both directions, and (9) holds it at rest. Verified by
//! `tests/exponential/exponential.rs`, `tests/exponential/at_rest.rs`.

use super::drive::Drive;
use super::loaded_modes::LoadedModes;
use super::phasor::Phasor;
use super::torques::Torques;
use super::torsional_modes::{TorsionalModes, TorsionalStep};
use super::unbalance::Unbalance;
use crate::engine::exponential::ExponentialError;
use crate::engine::shaft_line::sites;
use crate::engine::torques::initial_torsion;
use crate::structure::Structure;
use bladeoff_model::machine::{Braking, Machine};
use bladeoff_numerics::linalg::{column_of, dot};
use nalgebra::Complex;

/// Part of the slope's rate of change that is forgotten over a turn of 1 rad: the rate of a spin that oscillates passes through
/// zero.
const SLOPE_RATE_DECAY: f64 = 0.3;

/// State of the spin and of the torsion at n.
#[derive(Debug, Clone)]
pub(crate) struct Spin {
    /// Mean angle \[rad\] and spin \[rad/s\] of rotor and unbalances at n.
    pub angle: f64,
    pub speed: f64,
    /// P of (2) \[kg m2/s\].
    pub(super) momentum: f64,
    /// Length of the last step \[s\], and the largest number of such steps over which its slope is extrapolated
    /// ([`LoadedModes::max_extrapolation`]).
    pub(super) last_step: f64,
    pub(super) max_extrapolation: f64,
    /// Slope of the spin over the last step \[rad/s2\], and the largest recent change of it \[rad/s3\].
    pub(super) slope: f64,
    pub(super) slope_rate: f64,
    /// Slope without the jump by the contact impulse of the step and without torques over time, used for the prediction \[rad/s2\].
    pub(super) slope_without_impulse: f64,
    pub(super) loaded_modes: LoadedModes,
    /// `None` where the spin is an unknown.
    pub(super) drive: Option<Drive>,
    /// Torques over time; `None` without.
    pub(super) torques: Option<Torques>,
    pub(super) braking: Braking,
    /// Whether the rotor starts at rest without a drive: its brake has the law (9).
    pub(super) starts_at_rest: bool,
    pub(super) gravity: [f64; 2],
    pub(super) unbalances: Vec<Unbalance>,
    pub(super) torsion: TorsionalModes,
    /// Sum of the angular impulses of the contacts in the last step \[N m s\], and of D_w of (7) \[rad/s\].
    pub(super) impulse_torque: f64,
    pub(super) speed_jump: f64,
    /// Energy that brakes have dissipated so far, (8) \[J\].
    pub(super) braking_work: f64,
    /// Predicted angle \[rad\] and spin \[rad/s\] at n+1.
    pub(super) next_angle: f64,
    pub(super) next_speed: f64,
}

/// Impulse on a diaphragm's node at n \[N s\], its angular impulse \[N m s\], and the jump of the spin that it makes through the
/// unbalances, D_w of (7) \[rad/s\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ContactImpulse {
    /// Index of the diaphragm, in the machine's order.
    pub diaphragm: usize,
    pub impulse: [f64; 2],
    pub torque: f64,
    pub speed_jump: f64,
}

/// Tables of a step: its length h \[s\] and those of the torsional modes.
#[derive(Debug, Clone)]
pub(crate) struct SpinStep {
    h: f64,
    /// 1/h \[1/s\].
    over: f64,
    torsion: TorsionalStep,
}

impl Spin {
    /// Creates the spin of a machine at t = 0, with the static torsion of its torques.
    ///
    /// # Errors
    /// [`ExponentialError`] of [`LoadedModes::new`].
    pub fn new(machine: &Machine, structure: &Structure) -> Result<Self, ExponentialError> {
        let loaded_modes = LoadedModes::new(machine, structure)?;
        let (angle, speed) = (machine.rotor.initial.angle, machine.rotor.initial_speed);
        let unbalances = sites(machine).into_iter().map(|site| Unbalance {
            moment: site.mass * site.radius,
            phase: site.phase,
            angle: angle + site.phase,
            rate: speed,
            phasor: Phasor::of(angle + site.phase),
            momentum: 0.0,
            torque: 0.0,
            next_rate: 0.0,
            unit: Complex::new(1.0, 0.0),
            correction_impulse: Complex::new(0.0, 0.0),
            mid_step_force: Complex::new(0.0, 0.0),
            force: Complex::new(0.0, 0.0),
            compliance: Vec::new(),
            jump: 0.0,
            response_impulses: [Complex::new(0.0, 0.0); 2],
        });
        let nodes = sites(machine).into_iter().map(|site| site.torsional_node);
        let contacts = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.node);
        let mut rows: Vec<Vec<f64>> = nodes.map(|node| loaded_modes.row(structure, node)).collect();
        rows.push(loaded_modes.shift.clone());
        let acting = rows.len();
        rows.extend(contacts.map(|node| loaded_modes.row(structure, node)));
        let with_compliance = |mut unbalance: Unbalance, row: &Vec<f64>| {
            unbalance.compliance =
                rows[acting..].iter().map(|contact| 1.0 / loaded_modes.inertia + dot(contact, row)).collect();
            unbalance
        };
        let drive = machine.rotor.speed_law.clone().map(|law| {
            let inertias = loaded_modes.unbalance_inertias.clone();
            Drive::new(law, angle, structure.rotor.torsional_mass.sum(), inertias)
        });
        let mut spin = Self {
            drive,
            torques: Torques::new(machine, structure, &loaded_modes),
            angle,
            speed,
            momentum: 0.0,
            last_step: f64::INFINITY,
            max_extrapolation: loaded_modes.max_extrapolation(),
            slope: 0.0,
            slope_rate: 0.0,
            slope_without_impulse: 0.0,
            braking: machine.braking.clone(),
            starts_at_rest: speed == 0.0 && machine.rotor.speed_law.is_none(),
            gravity: machine.rotor.gravity,
            unbalances: unbalances.zip(&rows).map(|(unbalance, row)| with_compliance(unbalance, row)).collect(),
            torsion: TorsionalModes::new(&loaded_modes.modes, &rows, acting),
            impulse_torque: 0.0,
            speed_jump: 0.0,
            braking_work: 0.0,
            next_angle: angle,
            next_speed: speed,
            loaded_modes,
        };
        if let Some(torsion) = initial_torsion(machine, structure) {
            spin.torsion.expect_course();
            // without an unbalance nothing feeds the predicted spin back
            if spin.unbalances.is_empty() {
                spin.max_extrapolation = f64::INFINITY;
            }
            let (angle, displacement) =
                spin.loaded_modes.of_bare(angle, &spin.loaded_modes.bare_torsion(structure, &torsion))?;
            spin.torsion.start(&displacement, &vec![0.0; displacement.len()], 0.0);
            (spin.angle, spin.next_angle) = (angle, angle);
            spin.place_unbalances();
        }
        spin.update_forces();
        Ok(spin)
    }

    /// Sets angles and rates of the unbalances from spin and torsion.
    pub(super) fn place_unbalances(&mut self) {
        for (s, unbalance) in self.unbalances.iter_mut().enumerate() {
            let [turn, rate] = self.torsion.at_row(s);
            (unbalance.angle, unbalance.rate) = (self.angle + turn + unbalance.phase, self.speed + rate);
            unbalance.phasor = Phasor::of(unbalance.angle);
        }
    }

    /// Sets the momenta from the motion at t = 0: velocities of the unbalances' nodes \[m/s\], gyroscopic momentum \[kg m2/s\].
    pub fn start(&mut self, velocities: &[[f64; 2]], gyroscopic: f64) {
        let mut momentum = self.mean_momentum(self.speed) + gyroscopic;
        for (s, &velocity) in velocities.iter().enumerate() {
            let compliance_part = self.compliance_momentum(s, |unbalance| unbalance.rate);
            let unbalance = &mut self.unbalances[s];
            let [whirl_part, torque] =
                unbalance.exchange(unbalance.phasor.unit, unbalance.rate, velocity, self.gravity);
            unbalance.momentum = whirl_part + compliance_part;
            unbalance.torque = torque;
            momentum += unbalance.momentum;
        }
        self.momentum = momentum;
    }

    /// Angular momentum of the mean rotation at a spin \[kg m2/s\].
    #[inline(always)]
    fn mean_momentum(&self, speed: f64) -> f64 {
        match &self.drive {
            None => self.loaded_modes.inertia * speed,
            Some(drive) => drive.momentum(speed, self.unbalances.iter().map(|unbalance| unbalance.rate)),
        }
    }

    /// Takes the slope of a spin that has gone a short step from here.
    pub fn copy_slope(&mut self, ahead: &Spin) {
        (self.slope, self.slope_without_impulse) = (ahead.slope, ahead.slope_without_impulse);
        self.update_forces();
    }

    /// Updates the forces of the unbalances at n.
    pub(super) fn update_forces(&mut self) {
        for unbalance in &mut self.unbalances {
            unbalance.force = unbalance.force(unbalance.phasor.unit, unbalance.rate, self.slope);
        }
    }

    /// Part of r_s that is proportional to the rates: sum_t Q_st psi_t' \[kg m2/s\].
    #[inline(always)]
    pub(super) fn compliance_momentum(&self, s: usize, rate: impl Fn(&Unbalance) -> f64) -> f64 {
        column_of(&self.loaded_modes.compliance_inertia, s)
            .iter()
            .zip(&self.unbalances)
            .map(|(q, unbalance)| q * rate(unbalance))
            .sum()
    }

    /// Creates the tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> SpinStep {
        SpinStep { h, over: 1.0 / h, torsion: self.torsion.step(h) }
    }

    /// Predicts angles and rates at n+1, and the forces [`Spin::mid_step_forces`]; inside a kernel.
    #[inline(always)]
    pub fn predict(&mut self, step: &SpinStep) {
        let h = step.h;
        self.next_speed = self.speed + h.min(self.max_extrapolation * self.last_step) * self.slope_without_impulse;
        self.next_angle = self.angle + 0.5 * h * (self.speed + self.next_speed);
        if let Some(drive) = &self.drive {
            [self.next_angle, self.next_speed] = drive.after(h);
        }
        self.torsion.propagate_free(&step.torsion);
        if let Some(torques) = &mut self.torques {
            torques.begin_step(h);
            self.torsion.drive(&step.torsion, &torques.on_modes);
            if self.drive.is_none() {
                let [speed, angle] = torques.turn();
                self.next_speed += speed;
                self.next_angle += 0.5 * h * speed + angle;
            }
        }
        (self.impulse_torque, self.speed_jump) = (0.0, 0.0);
        let over = step.over;
        for (s, unbalance) in self.unbalances.iter_mut().enumerate() {
            let [torsion, rate] = self.torsion.predicted_at_row(s);
            let next_angle = self.next_angle + torsion + unbalance.phase;
            unbalance.next_rate = self.next_speed + rate;
            unbalance.unit = unbalance.phasor.unit;
            let middle = unbalance.phasor.at(0.5 * (unbalance.angle + next_angle));
            unbalance.phasor = middle.at(next_angle);
            let rate_change = unbalance.next_rate - unbalance.rate;
            unbalance.mid_step_force =
                unbalance.force(middle.unit, (next_angle - unbalance.angle) * over, rate_change * over);
            unbalance.jump = 0.0;
        }
    }

    /// Adds a contact impulse on a diaphragm's node at n to the prediction, by (7); inside a kernel. `velocities`: jumps of the
    /// velocities of the unbalances' nodes per impulse \[m/s/(N s)\].
    #[inline(always)]
    pub fn apply_impulse(
        &mut self,
        step: &SpinStep,
        ContactImpulse { diaphragm, impulse: [u, v], torque, speed_jump }: ContactImpulse,
        velocities: &[[[f64; 2]; 2]],
    ) {
        let SpinStep { h, over, .. } = *step;
        self.momentum += torque;
        self.impulse_torque += torque;
        self.speed_jump += speed_jump;
        self.torsion.apply_impulse(&step.torsion, diaphragm, torque);
        let jump = torque / self.loaded_modes.inertia + speed_jump;
        self.next_speed += jump;
        self.next_angle += h * jump;
        for (s, (unbalance, [x, y])) in self.unbalances.iter_mut().zip(velocities).enumerate() {
            let velocity = Complex::new(x[0] * u + x[1] * v, y[0] * u + y[1] * v);
            unbalance.torque -= unbalance.moment * unbalance.rate * (velocity * unbalance.unit.conj()).re;
            let jump = unbalance.compliance[diaphragm] * torque + speed_jump;
            if speed_jump != 0.0 {
                unbalance.jump_torque(jump, self.gravity);
            }
            unbalance.jump += jump;
            let [torsion, rate] = self.torsion.predicted_at_row(s);
            let next_angle = self.next_angle + torsion + unbalance.phase;
            unbalance.next_rate = self.next_speed + rate;
            let middle = unbalance.phasor.at(0.5 * (unbalance.angle + next_angle));
            unbalance.phasor = middle.at(next_angle);
            let rate_change = unbalance.next_rate - unbalance.rate - unbalance.jump;
            let mid_step_force =
                unbalance.force(middle.unit, (next_angle - unbalance.angle) * over, rate_change * over);
            unbalance.response_impulses =
                [unbalance.rate_jump_impulse(unbalance.unit, jump), (mid_step_force - unbalance.mid_step_force) * h];
            unbalance.mid_step_force = mid_step_force;
        }
    }

    /// Jump of the velocity of a diaphragm's node at n by the unbalances' response to a contact impulse on the node of another
    /// \[m/s\]; `velocities` as in [`Spin::apply_impulse`], per impulse on the first of the two.
    #[inline(always)]
    pub fn contact_velocity_jump(
        &self,
        ContactImpulse { diaphragm, torque, speed_jump, .. }: ContactImpulse,
        velocities: &[[[f64; 2]; 2]],
    ) -> [f64; 2] {
        let mut jump = [0.0; 2];
        for (unbalance, [x, y]) in self.unbalances.iter().zip(velocities) {
            let impulse =
                unbalance.rate_jump_impulse(unbalance.unit, unbalance.compliance[diaphragm] * torque + speed_jump);
            // reciprocity: the response at the contact to an impulse here is the response here to one at the contact
            jump = [0, 1].map(|i| jump[i] + x[i] * impulse.re + y[i] * impulse.im);
        }
        jump
    }

    /// D_w of (7) for a contact impulse \[N s\]; `velocities` as in [`Spin::apply_impulse`].
    pub fn speed_jump(&self, [u, v]: [f64; 2], velocities: &[[[f64; 2]; 2]]) -> f64 {
        let mut momentum = 0.0;
        for (unbalance, [x, y]) in self.unbalances.iter().zip(velocities) {
            let velocity = Complex::new(x[0] * u + x[1] * v, y[0] * u + y[1] * v);
            momentum -= unbalance.moment * (velocity * unbalance.unit.conj()).im;
        }
        momentum / self.loaded_modes.inertia
    }

    /// Impulses of each unbalance on the lateral motion at n and n+1, by the contact impulse that was added \[N s\].
    #[inline(always)]
    pub fn response_impulses(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        self.unbalances.iter().map(|unbalance| unbalance.response_impulses.map(|impulse| [impulse.re, impulse.im]))
    }

    /// Rotation of a diaphragm's node beside the mean angle \[rad\], and its rate \[rad/s\]: at n, after [`Spin::predict`] the
    /// predicted ones at n+1.
    pub fn contact_rotation(&self, diaphragm: usize) -> [f64; 2] {
        self.torsion.at_row(self.unbalances.len() + 1 + diaphragm)
    }

    /// Turn of a diaphragm's node over the predicted step \[rad\], for its rotation at n; after [`Spin::predict`].
    pub fn contact_turn(&self, diaphragm: usize, before: f64) -> f64 {
        self.next_angle - self.angle + self.contact_rotation(diaphragm)[0] - before
    }

    /// Turn of a diaphragm's node over the step per angular impulse on the node of another \[rad/(N m s)\].
    pub fn contact_turn_compliance(&self, step: &SpinStep, at: usize, acting: usize) -> f64 {
        step.h / self.loaded_modes.inertia + self.torsion.impulse_compliance(&step.torsion, at, acting)
    }

    /// Raises the damping of the torsional modes that steps of `h` \[s\] do not resolve to this feedback per step.
    pub fn stabilise(&mut self, h: f64, feedback: f64) {
        for mode in self.loaded_modes.modes.iter_mut().filter(|mode| mode.0 * h * h >= 1.0) {
            mode.1 = mode.1.max(2.0 * feedback / h);
        }
        self.torsion.set_damping(&self.loaded_modes.modes);
    }

    /// Jump of a node's rate per angular impulse on another \[1/(kg m2)\], for their rows on the torsional modes.
    pub fn rate_jump(&self, row: &[f64], acting: &[f64]) -> f64 {
        1.0 / self.loaded_modes.inertia + dot(row, acting)
    }

    /// Braking torque at a spin \[N m\], which keeps its sign until the rotor has stopped; without the part (9).
    #[inline(always)]
    fn brake_at(&self, speed: f64) -> f64 {
        if self.starts_at_rest {
            return self.braking.torque(speed) - self.braking.constant_torque(speed);
        }
        self.braking.torque(speed.max(f64::MIN_POSITIVE))
    }

    /// Completes the step with the velocities of the unbalances' nodes \[m/s\] and the gyroscopic momentum \[kg m2/s\] at n+1,
    /// before the impulses [`Spin::correction_impulses`]; inside a kernel.
    #[inline(always)]
    pub fn finish_step(&mut self, step: &SpinStep, velocities: &[[f64; 2]], gyroscopic: f64) {
        let SpinStep { h, over, .. } = *step;
        let speed_after_impulse = self.speed + self.impulse_torque / self.loaded_modes.inertia + self.speed_jump;
        let mut brake = 0.5 * (self.brake_at(speed_after_impulse) + self.brake_at(self.next_speed));
        self.momentum += h * brake;
        if let Some(torques) = &self.torques {
            self.momentum += torques.moments[0];
        }
        let mut momentum_sum = gyroscopic;
        for (s, &velocity) in velocities.iter().enumerate() {
            let compliance_part = self.compliance_momentum(s, |unbalance| unbalance.next_rate);
            let unbalance = &mut self.unbalances[s];
            let [whirl_part, torque] =
                unbalance.exchange(unbalance.phasor.unit, unbalance.next_rate, velocity, self.gravity);
            let torque_impulse = 0.5 * h * (unbalance.torque + torque);
            let new_momentum = whirl_part + compliance_part;
            let momentum_loss = unbalance.momentum - new_momentum;
            (unbalance.momentum, unbalance.torque) = (new_momentum, torque);
            self.torsion.torques()[s] = (torque_impulse + momentum_loss) * over;
            self.momentum += torque_impulse;
            momentum_sum += new_momentum;
        }
        if self.starts_at_rest {
            let c0 = self.braking.at_rest();
            let held = ((momentum_sum - self.momentum) * over).clamp(-c0, c0);
            self.momentum += h * held;
            brake += held;
        }
        if let Some(drive) = &self.drive {
            let slope = (self.next_speed - self.speed) * over;
            for s in 0..velocities.len() {
                self.torsion.torques()[s] -= drive.unbalance_inertia(s) * slope;
            }
        }
        self.torsion.torques()[velocities.len()] = brake;
        self.torsion.apply_torques(&step.torsion);
        let speed = match &self.drive {
            None => (self.momentum - momentum_sum) / self.loaded_modes.inertia,
            Some(_) => self.next_speed,
        };
        self.braking_work -= brake * (0.5 * h * (speed_after_impulse + speed) + self.torsion.turn(velocities.len()));
        self.slope_rate = ((speed - self.next_speed).abs() * (over * over))
            .max((1.0 - SLOPE_RATE_DECAY * h * self.speed.abs()).max(0.0) * self.slope_rate);
        (self.last_step, self.slope, self.slope_without_impulse) =
            (h, (speed - self.speed) * over, (speed - speed_after_impulse) * over);
        if let Some(torques) = &mut self.torques {
            self.slope_without_impulse -= torques.turn()[0] * over;
            torques.finish_step(h, 0.5 * (speed_after_impulse + speed), self.torsion.course_work());
        }
        let (turn, start_speed) = (self.next_angle - self.angle, self.speed);
        (self.angle, self.speed) = (self.next_angle, speed);
        for (s, unbalance) in self.unbalances.iter_mut().enumerate() {
            let [torsion, rate] = self.torsion.at_row(s);
            (unbalance.angle, unbalance.rate) = (self.angle + torsion + unbalance.phase, speed + rate);
            unbalance.correction_impulse =
                unbalance.rate_jump_impulse(unbalance.phasor.unit, unbalance.rate - unbalance.next_rate);
            unbalance.force = unbalance.force(unbalance.phasor.unit, unbalance.rate, self.slope);
        }
        if self.drive.is_some() {
            momentum_sum += self.mean_momentum(speed);
        }
        if let Some(drive) = &mut self.drive {
            let momentum = momentum_sum;
            drive.finish_step(h, [momentum - self.momentum, self.impulse_torque], [start_speed, turn]);
            self.momentum = momentum;
        }
    }

    /// Forces (5) of the unbalances in the middle of the predicted step \[N\].
    #[inline(always)]
    pub fn mid_step_forces(&self) -> impl Iterator<Item = Complex<f64>> + Clone {
        self.unbalances.iter().map(|unbalance| unbalance.mid_step_force)
    }

    /// Impulses (6) of the unbalances on the lateral motion at n+1 \[N s\].
    #[inline(always)]
    pub fn correction_impulses(&self) -> impl Iterator<Item = Complex<f64>> {
        self.unbalances.iter().map(|unbalance| unbalance.correction_impulse)
    }

    /// Adds gyroscopic torques on the torsional modes over a step of 1/`over` \[s\], from the changes of their momenta
    /// \[kg m2/s\]: between [`Spin::predict`] and [`Spin::finish_step`], and once, with `over = 0`, before the first step.
    pub fn apply_gyroscopic_torque(&mut self, changes: &[f64], over: f64) {
        self.torsion.add_torques(changes, over);
    }
}
