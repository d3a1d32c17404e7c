//! The spin by its momentum, and the twist: no accelerations, no rounds.
//!
//! ```text
//! psi_s = angle + t_s.e + a_s                   angle of unbalance s: mean angle, elastic twist of its node ([`super::loaded`]), phase
//! r_s   = m d Im(z_s' e^{-i psi_s}) + sum_t Q_st psi_t'                       its momentum about the axis, less A psi', which the modes have
//! P     = J W + sum_s r_s + q'^T G q/2,         P' = T(W) + sum_s k_s         J with A                                                (1)
//! k_s   = -m d psi_s' Re(z_s' e^{-i psi_s}) + m d (g_y cos psi_s - g_x sin psi_s)
//! k_s - (r_s+ - r_s)/h                          torque of the unbalance on the twist over the step                          (2)
//! force of the unbalance on the lateral motion  m d (psi'^2 - i psi'') e^{i psi},  in the middle of the step,  h psi'' = psi'(n+1) foreseen - psi'(n)     (3)
//! what (3) missed of psi', D                    -i m d D e^{i psi} is an impulse on the lateral motion at n+1                          (4)
//! damping of the twist takes  what impulses, (2) and T b put in, less the energy that is there        exact, as its motion is       (5)
//! a blow (torque tau) at n is foreseen once it is known:  psi'(n+) = psi'(n) + (1/J + t_s.t) tau,  -i m d of that jump is an impulse at n; what (3) is more by it, times h, one at n+1   (7)
//! brakes take   -T times the turn over the step of what they turn: h (W behind a blow at n + W+)/2, and that of the twist            (6)
//! ```
//! An impulse on the rotor at n makes z' jump, and by as much of every step of a rub k would be wrong that began before it: it begins behind it (energy errors of hard rubs were ten times as large, of first order in the step).
//! A step: the turn over it follows from the spin and its last slope (Adams and Bashforth's second method), (3) moves the rotor, and its velocity at the end gives
//! W+ by (1), trapezoidal, and (2): nothing is solved, since (4) changes psi' and z' so that r does not. So momentum has no drift, and W no more noise than z'.
//! What of r follows the rates that are foreseen, because a step does not resolve all of the rotor's answer, feeds back into the twist ([`Spin::comes_back`]): modes that no
//! step resolves may grow by it where their phase is near half a turn a step. So the predicted twist of these modes is the free one, without the torques of the step before, and
//! steps are as long as the twist's damping holds ([`Spin::holds`]). (Impulses at either end instead of (2) let none grow, but have torsional moments up to 20 times too large
//! where a step is a whole turn of a mode.)
//! Modes that the step resolves are predicted with the torques of the step before ([`super::twist`], (3)). Without them the jump D of (4) is t.t times (2) times h in every step, and the
//! balance of energies loses D (r+ - r)/2 per step: an error of first order in the step and of second order in the unbalance.
//! (The trapezoidal rule for the power of that damping missed what impulses make of it: 2e-4 of a whipping turbine's energies; that for the power of brakes missed what blows make of W, 1e-5 of
//! the energies of a rotor that its ring stops, and how T changes in a long step.)
//!
//! Source: the Lagrangian of docs/theory/01-shaft-line.md; (1) and (2) are its equations for phi and for the twist, integrated once. Limits: in the gyroscopic moments on the lateral motion all
//! sites turn with W, and gyroscopic torques act on the torsional modes only where they matter ([`super::gyration`]); a turning rotor (what c0 holds at rest is not here). Second order in the step. Verified by `tests/exponential.rs`.

use super::loaded_modes::LoadedModes;
use super::phasor::Phasor;
use super::torsional_modes::{TorsionalModes, TorsionalStep};
use crate::engine::exponential::ExponentialError;
use crate::engine::shaft_line::sites;
use crate::linalg::{column_of, dot};
use crate::rotor::braking_torque;
use crate::structure::Structure;
use bladeoff_model::machine::{Braking, Machine};
use nalgebra::Complex;

/// Growth over a whole run that is none.
const NEGLIGIBLE_FEEDBACK: f64 = 0.1;

/// Part of a bend of the spin that a turn by 1 rad forgets: one that swings passes through zero.
const FORGETTING: f64 = 0.3;

/// Spin and twist under way.
#[derive(Debug, Clone)]
pub(crate) struct Spin {
    /// Mean angle \[rad\] and spin \[rad/s\] of rotor and unbalances at n.
    pub angle: f64,
    pub speed: f64,
    /// P \[kg m2/s\].
    momentum: f64,
    /// The last step \[s\], and how many of it the slope foretells at most: [`Loaded::foretold`].
    last: f64,
    max_extrapolation: f64,
    /// Of the spin over the last step \[rad/s2\], and the largest change of that of late \[rad/s3\].
    slope: f64,
    slope_rate: f64,
    /// The slope without what a blow has made, which the next step foretells.
    slope_without_impulse: f64,
    loaded_modes: LoadedModes,
    braking: Braking,
    gravity: [f64; 2],
    arms: Vec<UnbalanceArm>,
    torsion: TorsionalModes,
    /// That of the blow of the last step \[N m s\].
    impulse_torque: f64,
    /// (6) so far \[J\].
    braked: f64,
    /// Those predicted for n+1.
    next_angle: f64,
    next_speed: f64,
}

/// One unbalance.
#[derive(Debug, Clone)]
struct UnbalanceArm {
    /// m d \[kg m\].
    moment: f64,
    phase: f64,
    /// psi, psi', e^{i psi}, r and k at n; psi that was foreseen is that of the direction.
    angle: f64,
    rate: f64,
    phasor: Phasor,
    momentum: f64,
    gravity_torque: f64,
    next_rate: f64,
    /// e^{i psi} at n, once n+1 is predicted.
    unit: Complex<f64>,
    /// (4) of the last step, (3) in its middle and at n.
    left: Complex<f64>,
    driving: Complex<f64>,
    force: Complex<f64>,
    /// Jump of psi' per angular impulse on the first diaphragm's node \[1/(kg m2)\]; (7) at n and n+1.
    compliance: f64,
    jumps: [Complex<f64>; 2],
}

/// An impulse on the first diaphragm's node at n \[N s\], and that of its torque \[N m s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactImpulse {
    pub impulse: [f64; 2],
    pub torque: f64,
}

/// What a step size makes of spin and twist.
#[derive(Debug, Clone)]
pub(crate) struct SpinStep {
    h: f64,
    /// 1/h.
    over: f64,
    twist: TorsionalStep,
}

impl UnbalanceArm {
    /// (3) in a direction, at a rate and its derivative \[N\].
    #[inline(always)]
    fn force(&self, unit: Complex<f64>, rate: f64, rate_dot: f64) -> Complex<f64> {
        let (turn, square) = (unit * self.moment, rate * rate);
        Complex::new(square * turn.re + rate_dot * turn.im, square * turn.im - rate_dot * turn.re)
    }

    /// (4) of a jump of psi' in a direction \[N s\].
    #[inline(always)]
    fn velocity_kick(&self, unit: Complex<f64>, jump: f64) -> Complex<f64> {
        let turn = unit * self.moment;
        Complex::new(jump * turn.im, -jump * turn.re)
    }

    /// r without its part of psi', and k, of a unit vector, a rate and the node's velocity.
    #[inline(always)]
    fn exchange(&self, unit: Complex<f64>, rate: f64, velocity: [f64; 2], gravity: [f64; 2]) -> [f64; 2] {
        let along = Complex::new(velocity[0], velocity[1]) * unit.conj();
        let weight = gravity[1] * unit.re - gravity[0] * unit.im;
        [self.moment * along.im, self.moment * (weight - rate * along.re)]
    }
}

impl Spin {
    /// At t = 0, without twist.
    ///
    /// # Errors
    /// [`ExponentialError`] of [`Loaded::new`].
    pub fn new(machine: &Machine, structure: &Structure) -> Result<Self, ExponentialError> {
        let loaded = LoadedModes::new(machine, structure)?;
        let (angle, speed) = (machine.rotor.initial.angle, machine.rotor.initial_speed);
        let arms = sites(machine).into_iter().map(|site| UnbalanceArm {
            moment: site.mass * site.radius,
            phase: site.phase,
            angle: angle + site.phase,
            rate: speed,
            phasor: Phasor::of(angle + site.phase),
            momentum: 0.0,
            gravity_torque: 0.0,
            next_rate: 0.0,
            unit: Complex::new(1.0, 0.0),
            left: Complex::new(0.0, 0.0),
            driving: Complex::new(0.0, 0.0),
            force: Complex::new(0.0, 0.0),
            compliance: 0.0,
            jumps: [Complex::new(0.0, 0.0); 2],
        });
        let nodes = sites(machine).into_iter().map(|site| site.twist_node);
        let contact = machine.diaphragms.first().map(|diaphragm| diaphragm.contact.node);
        let mut rows: Vec<Vec<f64>> = nodes.map(|node| loaded.row(structure, node)).collect();
        rows.push(loaded.shift.clone());
        let acting = rows.len();
        rows.extend(contact.map(|node| loaded.row(structure, node)));
        let answers = |mut arm: UnbalanceArm, row: &Vec<f64>| {
            arm.compliance = rows.get(acting).map_or(0.0, |contact| 1.0 / loaded.inertia + dot(contact, row));
            arm
        };
        let mut spin = Self {
            angle,
            speed,
            momentum: 0.0,
            last: f64::INFINITY,
            max_extrapolation: loaded.max_extrapolation(),
            slope: 0.0,
            slope_rate: 0.0,
            slope_without_impulse: 0.0,
            braking: machine.braking,
            gravity: machine.rotor.gravity,
            arms: arms.zip(&rows).map(|(arm, row)| answers(arm, row)).collect(),
            torsion: TorsionalModes::new(&loaded.modes, &rows, acting),
            impulse_torque: 0.0,
            braked: 0.0,
            next_angle: angle,
            next_speed: speed,
            loaded_modes: loaded,
        };
        spin.force();
        Ok(spin)
    }

    /// Takes momenta from the motion at t = 0: velocities of the unbalances' nodes \[m/s\], gyroscopic momentum.
    pub fn start(&mut self, velocities: &[[f64; 2]], gyroscopic: f64) {
        let mut momentum = self.loaded_modes.inertia * self.speed + gyroscopic;
        for (s, &velocity) in velocities.iter().enumerate() {
            let given = self.torsional_yield(s, |arm| arm.rate);
            let arm = &mut self.arms[s];
            let [carried, pull] = arm.exchange(arm.phasor.unit, arm.rate, velocity, self.gravity);
            arm.momentum = carried + given;
            arm.gravity_torque = pull;
            momentum += arm.momentum;
        }
        self.momentum = momentum;
    }

    /// Takes the slope of another that has gone a short step from here.
    pub fn copy_slope(&mut self, ahead: &Spin) {
        (self.slope, self.slope_without_impulse) = (ahead.slope, ahead.slope_without_impulse);
        self.force();
    }

    /// (3) at n.
    fn force(&mut self) {
        for arm in &mut self.arms {
            arm.force = arm.force(arm.phasor.unit, arm.rate, self.slope);
        }
    }

    /// Part of r that goes with the rates.
    #[inline(always)]
    fn torsional_yield(&self, s: usize, rate: impl Fn(&UnbalanceArm) -> f64) -> f64 {
        column_of(&self.loaded_modes.compliance_inertia, s).iter().zip(&self.arms).map(|(q, arm)| q * rate(arm)).sum()
    }

    /// Tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> SpinStep {
        SpinStep { h, over: 1.0 / h, twist: self.torsion.step(h) }
    }

    /// Begins a step: the unbalances' forces in its middle are [`Spin::driving`] then; inside a kernel.
    #[inline(always)]
    pub fn predict(&mut self, step: &SpinStep) {
        let h = step.h;
        self.next_speed = self.speed + h.min(self.max_extrapolation * self.last) * self.slope_without_impulse;
        self.next_angle = self.angle + 0.5 * h * (self.speed + self.next_speed);
        self.torsion.propagate_free(&step.twist);
        self.impulse_torque = 0.0;
        let over = step.over;
        for (s, arm) in self.arms.iter_mut().enumerate() {
            let [turned, rate] = self.torsion.predicted_at_row(s);
            let next_angle = self.next_angle + turned + arm.phase;
            arm.next_rate = self.next_speed + rate;
            arm.unit = arm.phasor.unit;
            let middle = arm.phasor.at(0.5 * (arm.angle + next_angle));
            arm.phasor = middle.at(next_angle);
            let gained = arm.next_rate - arm.rate;
            arm.driving = arm.force(middle.unit, (next_angle - arm.angle) * over, gained * over);
        }
    }

    /// Slope of the spin over the last step \[rad/s2\].
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// The spin a time ahead, if it goes on as it does \[rad/s\].
    pub fn speed_after(&self, time: f64) -> f64 {
        self.mean()[0] + time * self.slope
    }

    /// How fast brakes take the momentum by what of them depends on the spin, dT/dW over J at n \[1/s\].
    pub fn braking_torque(&self, braking: &Braking) -> f64 {
        (braking.linear + 2.0 * braking.quadratic * self.speed.abs()) / self.loaded_modes.inertia
    }

    /// What a step of `h` \[s\] is expected to end with beside the speed that is predicted, as a part of it.
    pub fn prediction_error(&self, h: f64) -> f64 {
        h * h * self.slope_rate / self.speed
    }

    /// Adds a blow at the beginning of the step, on the first diaphragm's node; `velocities`: jumps of those of the unbalances' nodes per impulse, from behind which k goes on. What it makes of psi' is
    /// foreseen then: (7). Between predict and complete, inside a kernel.
    #[inline(always)]
    pub fn apply_impulse(
        &mut self,
        step: &SpinStep,
        ContactImpulse { impulse: [u, v], torque }: ContactImpulse,
        velocities: &[[[f64; 2]; 2]],
    ) {
        let SpinStep { h, over, .. } = *step;
        self.momentum += torque;
        self.impulse_torque = torque;
        self.torsion.apply_impulse(&step.twist, torque);
        let jump = torque / self.loaded_modes.inertia;
        self.next_speed += jump;
        self.next_angle += h * jump;
        for (s, (arm, [x, y])) in self.arms.iter_mut().zip(velocities).enumerate() {
            let velocity = Complex::new(x[0] * u + x[1] * v, y[0] * u + y[1] * v);
            arm.gravity_torque -= arm.moment * arm.rate * (velocity * arm.unit.conj()).re;
            let ([turned, rate], jump) = (self.torsion.predicted_at_row(s), arm.compliance * torque);
            let next_angle = self.next_angle + turned + arm.phase;
            arm.next_rate = self.next_speed + rate;
            let middle = arm.phasor.at(0.5 * (arm.angle + next_angle));
            arm.phasor = middle.at(next_angle);
            let gained = arm.next_rate - arm.rate - jump;
            let driving = arm.force(middle.unit, (next_angle - arm.angle) * over, gained * over);
            arm.jumps = [arm.velocity_kick(arm.unit, jump), (driving - arm.driving) * h];
        }
    }

    /// Jump of the velocity of the first diaphragm's node by (7) at n, of a blow with this torque \[m/s\]; `velocities` as of [`Spin::strike`].
    #[inline(always)]
    pub fn impulse_answer(&self, torque: f64, velocities: &[[[f64; 2]; 2]]) -> [f64; 2] {
        let mut jump = [0.0; 2];
        for (arm, [x, y]) in self.arms.iter().zip(velocities) {
            let kick = arm.velocity_kick(arm.unit, arm.compliance * torque);
            // the answer there to an impulse here is that here to one there
            jump = [0, 1].map(|i| jump[i] + x[i] * kick.re + y[i] * kick.im);
        }
        jump
    }

    /// (7) of the blow that was added, of each unbalance, at n and n+1 \[N s\].
    #[inline(always)]
    pub fn jumps(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        self.arms.iter().map(|arm| arm.jumps.map(|kick| [kick.re, kick.im]))
    }

    /// Turn of the first diaphragm's node beside the mean angle \[rad\], and its rate: at n, after predict those foreseen for n+1.
    pub fn at_contact(&self) -> [f64; 2] {
        self.torsion.at_row(self.arms.len() + 1)
    }

    /// Turn of that node over the step that is predicted \[rad\], its turn at n given; after predict.
    pub fn turn(&self, before: f64) -> f64 {
        self.next_angle - self.angle + self.at_contact()[0] - before
    }

    /// Turn of the first diaphragm's node over the step per angular impulse on it \[rad/(N m s)\].
    pub fn rolling(&self, step: &SpinStep) -> f64 {
        step.h / self.loaded_modes.inertia + self.torsion.impulse_compliance(&step.twist)
    }

    /// What a change of the gyroscopic momentum shifts the spin by, per unit \[1/(kg m2)\].
    pub fn compliance(&self) -> f64 {
        1.0 / (self.loaded_modes.inertia + self.loaded_modes.compliance_inertia.iter().sum::<f64>())
    }

    /// Kinetic and potential energy of spin, unbalances and twist \[J\] at a spin shifted by so much; of the unbalances what their masses on the nodes do not
    /// have. `velocities`: of their nodes \[m/s\].
    pub fn energies(&self, shift: f64, velocities: &[[f64; 2]]) -> [f64; 2] {
        let speed = self.speed + shift;
        let mut kinetic = 0.5 * self.loaded_modes.inertia * speed * speed;
        let mut potential = 0.0;
        for (s, (arm, &velocity)) in self.arms.iter().zip(velocities).enumerate() {
            let unit = arm.phasor.at(arm.angle).unit;
            let [carried, _] = arm.exchange(unit, arm.rate, velocity, [0.0; 2]);
            kinetic += (arm.rate + shift) * (0.5 * self.torsional_yield(s, |other| other.rate + shift) + carried);
            potential -= arm.moment * (self.gravity[0] * unit.re + self.gravity[1] * unit.im);
        }
        let twist = self.torsion.energies();
        [kinetic + twist[0], potential + twist[1]]
    }

    /// Amplitudes of the modes of twist.
    pub fn torsional_amplitudes(&self) -> &[f64] {
        self.torsion.displacement()
    }

    /// What a train of blows in contact steps of `h` \[s\] lacks of the static twist, in amplitudes per angular impulse.
    pub fn static_correction(&self, h: f64) -> Vec<f64> {
        self.torsion.static_correction(h)
    }

    /// The blow of the last step \[N m s\].
    pub fn impulse_torque(&self) -> f64 {
        self.impulse_torque
    }

    /// Elastic twist of all nodes \[rad\], by their rows of [`Spin::twist_of`].
    pub fn torsion_angles(&self, rows: &[Vec<f64>], twists: &mut [f64]) {
        for (twist, row) in twists.iter_mut().zip(rows) {
            *twist = self.torsion.along(row);
        }
    }

    /// How much of what is foreseen of the unbalances' rates comes back over a step from what of the rotor's answer is not at once: `answers` is that of each node's
    /// velocity to an impulse on it, spread over the step \[1/kg\].
    pub fn feedback(&self, answers: impl Iterator<Item = f64>) -> f64 {
        let of = |((s, arm), answer): ((usize, &UnbalanceArm), f64)| {
            (self.loaded_modes.compliance_inertia[(s, s)] - arm.moment * arm.moment * answer).abs()
                * self.jump(self.torsion.row(s))
        };
        self.arms.iter().enumerate().zip(answers).map(of).sum()
    }

    /// Whether no mode of twist grows in steps of `h` \[s\] over which so much comes back: damping takes more than that of each mode that the step does not resolve, or it comes
    /// to nothing over a whole run of `time` \[s\].
    pub fn is_stable(&self, h: f64, back: f64, time: f64) -> bool {
        let is_held = |&(square, damping): &(f64, f64)| square * h * h < 1.0 || 0.5 * damping * h >= back;
        back <= 1.0 && (back * time < NEGLIGIBLE_FEEDBACK * h || self.loaded_modes.modes.iter().all(is_held))
    }

    /// Damps modes of twist that steps of `h` \[s\] do not resolve by what comes back over them, at least.
    pub fn stabilise(&mut self, h: f64, back: f64) {
        for mode in self.loaded_modes.modes.iter_mut().filter(|mode| mode.0 * h * h >= 1.0) {
            mode.1 = mode.1.max(2.0 * back / h);
        }
        self.torsion.damp(&self.loaded_modes.modes);
    }

    /// Jump of a node's rate per angular impulse on it \[1/(kg m2)\].
    pub fn jump(&self, row: &[f64]) -> f64 {
        1.0 / self.loaded_modes.inertia + dot(row, row)
    }

    /// Mean spin of the rotor without unbalances \[rad/s\], and its angle \[rad\]: what is reported, and what brakes turn.
    pub fn mean(&self) -> [f64; 2] {
        let [angle, speed] = self.torsion.at_row(self.arms.len());
        [self.speed + speed, self.angle + angle]
    }

    /// What the damping of the twist has taken so far \[J\].
    pub fn torsional_dissipation(&self) -> f64 {
        self.torsion.damped()
    }

    /// Elastic twist of a node, per amplitude; zeros up to a multiple of eight.
    pub fn torsion_row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.loaded_modes.twist(structure, node)
    }

    /// The turn of a node beside the mean angle of rotor and unbalances, per amplitude; zeros up to a multiple of eight.
    pub fn rotation_row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.loaded_modes.row(structure, node)
    }

    /// Ends the step with the velocities of the unbalances' nodes \[m/s\] and the gyroscopic momentum at its end, which (4) is still to be added to; inside a kernel.
    #[inline(always)]
    pub fn finish_step(&mut self, step: &SpinStep, velocities: &[[f64; 2]], gyroscopic: f64) {
        let SpinStep { h, over, .. } = *step;
        let behind = self.speed + self.impulse_torque / self.loaded_modes.inertia;
        // braking does not turn before the rotor has stopped
        let [begun, after] = [behind, self.next_speed].map(|speed| speed.max(f64::MIN_POSITIVE));
        let brake = 0.5 * (braking_torque(&self.braking, begun) + braking_torque(&self.braking, after));
        self.momentum += h * brake;
        let mut carried_by_all = gyroscopic;
        for (s, &velocity) in velocities.iter().enumerate() {
            let given = self.torsional_yield(s, |arm| arm.next_rate);
            let arm = &mut self.arms[s];
            let [carried, pull] = arm.exchange(arm.phasor.unit, arm.next_rate, velocity, self.gravity);
            let pulled = 0.5 * h * (arm.gravity_torque + pull);
            let after = carried + given;
            let exchanged = arm.momentum - after;
            (arm.momentum, arm.gravity_torque) = (after, pull);
            self.torsion.torques()[s] = (pulled + exchanged) * over;
            self.momentum += pulled;
            carried_by_all += after;
        }
        self.torsion.torques()[velocities.len()] = brake;
        self.torsion.apply_torques(&step.twist);
        let speed = (self.momentum - carried_by_all) / self.loaded_modes.inertia;
        self.braked -= brake * (0.5 * h * (behind + speed) + self.torsion.turn(velocities.len()));
        self.slope_rate = ((speed - self.next_speed).abs() * (over * over))
            .max((1.0 - FORGETTING * h * self.speed.abs()).max(0.0) * self.slope_rate);
        (self.last, self.slope, self.slope_without_impulse) = (h, (speed - self.speed) * over, (speed - behind) * over);
        (self.angle, self.speed) = (self.next_angle, speed);
        for (s, arm) in self.arms.iter_mut().enumerate() {
            let [turned, rate] = self.torsion.at_row(s);
            (arm.angle, arm.rate) = (self.angle + turned + arm.phase, speed + rate);
            arm.left = arm.velocity_kick(arm.phasor.unit, arm.rate - arm.next_rate);
            arm.force = arm.force(arm.phasor.unit, arm.rate, self.slope);
        }
    }

    /// Forces (3) of the unbalances in the middle of the step that is predicted \[N\].
    #[inline(always)]
    pub fn driving(&self) -> impl Iterator<Item = Complex<f64>> + Clone {
        self.arms.iter().map(|arm| arm.driving)
    }

    /// The same at n.
    pub fn forces_now(&self) -> impl Iterator<Item = Complex<f64>> {
        self.arms.iter().map(|arm| arm.force)
    }

    /// (4) of the last step, of each unbalance \[N s\].
    #[inline(always)]
    pub fn left(&self) -> impl Iterator<Item = Complex<f64>> {
        self.arms.iter().map(|arm| arm.left)
    }

    /// What brakes have taken so far \[J\].
    pub fn braking_work(&self) -> f64 {
        self.braked
    }

    /// Gyroscopic torques on the torsional modes over a step of 1/`over` \[s\], by what their momenta have changed by \[kg m2/s\]; between predict and complete, and once, with 0, before the first step.
    pub fn apply_gyroscopic_torque(&mut self, changes: &[f64], over: f64) {
        self.torsion.add_torques(changes, over);
    }

    /// How many unbalances.
    pub fn unbalances(&self) -> usize {
        self.arms.len()
    }
}
