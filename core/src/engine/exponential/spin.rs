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
//! damping of the twist takes  E(n, after impulses) - E(n+1) and the work of (2) and T b     of a step: exact, as its motion is       (5)
//! ```
//! A step: the turn over it follows from the spin and its last slope (Adams and Bashforth's second method), (3) moves the rotor, and its velocity at the end gives
//! W+ by (1), trapezoidal, and (2): nothing is solved, since (4) changes psi' and z' so that r does not. So momentum has no drift, and W no more noise than z'.
//! What of r follows the rates that are foreseen, because a step does not resolve all of the rotor's answer, feeds back into the twist ([`Spin::comes_back`]): modes that no
//! step resolves may grow by it where their phase is near half a turn a step. So the twist that is foreseen is the free one, without the torques of the step before, and
//! steps are as long as the twist's damping holds ([`Spin::holds`]). (Impulses at either end instead of (2) let none grow, but have torsional moments up to 20 times too large
//! where a step is a whole turn of a mode.)
//! (The trapezoidal rule for the power of that damping missed what impulses make of it: 2e-4 of a whipping turbine's energies.)
//!
//! Source: the Lagrangian of docs/theory/01-shaft-line.md; (1) and (2) are its equations for phi and for the twist, integrated once. Limits: all
//! gyroscopic sites turn with W; a turning rotor (what c0 holds at rest is not here). Second order in the step. Verified by `tests/exponential.rs`.

use super::ExponentialError;
use super::loaded::Loaded;
use super::oscillators::{OscillatorStep, Oscillators};
use super::rows::both_products;
use crate::engine::shaft_line::sites;
use crate::linalg::dot;
use crate::linalg::lanes::{LANES, kernel, sum};
use crate::rotor::braking_torque;
use crate::structure::Structure;
use bladeoff_model::machine::{Braking, Machine};
use nalgebra::Complex;

/// Growth over a whole run that is none.
const COMES_TO_NOTHING: f64 = 0.1;

/// Part of a bend of the spin that a turn by 1 rad forgets: one that swings passes through zero.
const FORGETS: f64 = 0.3;

/// Spin and twist under way.
#[derive(Debug, Clone)]
pub(super) struct Spin {
    /// Mean angle \[rad\] and spin \[rad/s\] of rotor and unbalances at n.
    pub angle: f64,
    pub speed: f64,
    /// P \[kg m2/s\].
    momentum: f64,
    /// The last step \[s\], and how many of it the slope foretells at most: [`Loaded::foretold`].
    last: f64,
    foretells: f64,
    /// Of the spin over the last step \[rad/s2\], and the largest change of that of late \[rad/s3\].
    slope: f64,
    bend: f64,
    loaded: Loaded,
    braking: Braking,
    gravity: [f64; 2],
    pub arms: Vec<Arm>,
    twist: Oscillators,
    /// w^2 of the elastic modes.
    elastic: Vec<f64>,
    /// Twist and its rates at the beginning of the step, after impulses there.
    begun: [Vec<f64>; 2],
    /// What its damping has taken so far \[J\].
    pub damped: f64,
    /// Those predicted for n+1.
    next_angle: f64,
    next_speed: f64,
}

/// One unbalance.
#[derive(Debug, Clone)]
pub(super) struct Arm {
    /// m d \[kg m\].
    moment: f64,
    phase: f64,
    /// Turn of its node beside the mean angle per amplitude.
    row: Vec<f64>,
    /// psi, psi', e^{i psi}, r and k at n.
    angle: f64,
    rate: f64,
    unit: Complex<f64>,
    momentum: f64,
    pull: f64,
    /// (2) over the last step \[N m\].
    torque: f64,
    /// (4) of the last step \[N s\].
    pub left: Complex<f64>,
    next_angle: f64,
    next_rate: f64,
}

/// What a step size makes of spin and twist.
#[derive(Debug, Clone)]
pub(super) struct SpinStep {
    h: f64,
    twist: OscillatorStep,
}

impl Arm {
    /// (3) at an angle, a rate and its derivative \[N\].
    fn force(&self, angle: f64, rate: f64, rate_dot: f64) -> Complex<f64> {
        let (sin, cos) = libm::sincos(angle);
        Complex::new(rate * rate, -rate_dot) * Complex::new(cos, sin) * self.moment
    }

    /// r without its part of psi', and k, of a unit vector, a rate and the node's velocity.
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
        let loaded = Loaded::new(machine, structure)?;
        let (angle, speed) = (machine.rotor.initial.angle, machine.rotor.initial_speed);
        let arms = sites(machine).into_iter().map(|site| Arm {
            moment: site.mass * site.radius,
            phase: site.phase,
            row: loaded.row(structure, site.twist_node),
            angle: angle + site.phase,
            rate: speed,
            unit: unit(angle + site.phase),
            momentum: 0.0,
            pull: 0.0,
            torque: 0.0,
            left: Complex::new(0.0, 0.0),
            next_angle: 0.0,
            next_rate: 0.0,
        });
        let count = loaded.modes.len();
        Ok(Self {
            angle,
            speed,
            momentum: 0.0,
            last: f64::INFINITY,
            foretells: loaded.foretold(),
            slope: 0.0,
            bend: 0.0,
            braking: machine.braking,
            gravity: machine.rotor.gravity,
            arms: arms.collect(),
            begun: [vec![0.0; count], vec![0.0; count]],
            damped: 0.0,
            twist: Oscillators::new(loaded.modes.iter().copied()),
            elastic: loaded.modes.iter().map(|mode| mode.0).collect(),
            next_angle: angle,
            next_speed: speed,
            loaded,
        })
    }

    /// Takes momenta from the motion at t = 0: velocities of the unbalances' nodes \[m/s\], gyroscopic momentum.
    pub fn begin(&mut self, velocities: &[[f64; 2]], gyroscopic: f64) {
        let mut momentum = self.loaded.inertia * self.speed + gyroscopic;
        for (s, &velocity) in velocities.iter().enumerate() {
            let given = self.given_way(s, |arm| arm.rate);
            let arm = &mut self.arms[s];
            let [carried, pull] = arm.exchange(arm.unit, arm.rate, velocity, self.gravity);
            arm.momentum = carried + given;
            arm.pull = pull;
            momentum += arm.momentum;
        }
        self.momentum = momentum;
    }

    /// Takes the slope of another that has gone a short step from here.
    pub fn learn_from(&mut self, ahead: &Spin) {
        self.slope = ahead.slope;
    }

    /// Part of r that goes with the rates.
    fn given_way(&self, s: usize, rate: impl Fn(&Arm) -> f64) -> f64 {
        self.loaded.gives_way[s].iter().zip(&self.arms).map(|(q, arm)| q * rate(arm)).sum()
    }

    /// Tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> SpinStep {
        SpinStep { h, twist: self.twist.step(h) }
    }

    /// Begins a step: the unbalances' forces in its middle \[N\].
    pub fn predict(&mut self, step: &SpinStep, forces: &mut Vec<Complex<f64>>) {
        let h = step.h;
        self.next_speed = self.speed + h.min(self.foretells * self.last) * self.slope;
        self.next_angle = self.angle + 0.5 * h * (self.speed + self.next_speed);
        self.begun[0].copy_from_slice(&self.twist.place);
        self.begun[1].copy_from_slice(&self.twist.rate);
        self.twist.advance(&step.twist);
        forces.clear();
        for s in 0..self.arms.len() {
            let moved = self.twisted(&self.arms[s].row);
            let next_angle = self.next_angle + moved[0] + self.arms[s].phase;
            let next_rate = self.next_speed + moved[1];
            let arm = &mut self.arms[s];
            (arm.next_angle, arm.next_rate) = (next_angle, next_rate);
            let middle = 0.5 * (arm.angle + next_angle);
            let gained = next_rate - arm.rate;
            forces.push(arm.force(middle, (next_angle - arm.angle) / h, gained / h));
        }
    }

    /// The spin a time ahead, if it goes on as it does \[rad/s\].
    pub fn speed_after(&self, time: f64) -> f64 {
        self.mean()[0] + time * self.slope
    }

    /// What a step of `h` \[s\] is expected to end with beside the speed that is predicted, as a part of it.
    pub fn surprise(&self, h: f64) -> f64 {
        h * h * self.bend / self.speed
    }

    /// Adds an angular impulse \[N m s\] at the beginning of the step, on a node of this elastic twist; between predict and complete.
    pub fn strike(&mut self, step: &SpinStep, impulse: f64, row: &[f64]) {
        self.momentum += impulse;
        self.twist.strike(&step.twist, impulse, row);
        self.begun[1].iter_mut().zip(row).for_each(|(rate, part)| *rate += impulse * part);
    }

    /// Turn of a node over the step that is predicted \[rad\], its elastic twist at n given; after predict.
    pub fn turn(&self, row: &[f64], twist_before: f64) -> f64 {
        self.next_angle - self.angle + dot(row, &self.twist.place) - twist_before
    }

    /// Turn of a node over the step per angular impulse on it \[rad/(N m s)\].
    pub fn rolling(&self, step: &SpinStep, row: &[f64]) -> f64 {
        step.h / self.loaded.inertia + step.twist.struck(row)
    }

    /// What a change of the gyroscopic momentum shifts the spin by, per unit \[1/(kg m2)\].
    pub fn yields(&self) -> f64 {
        1.0 / (self.loaded.inertia + self.loaded.gives_way.iter().flatten().sum::<f64>())
    }

    /// Kinetic and potential energy of spin, unbalances and twist \[J\] at a spin shifted by so much; of the unbalances what their masses on the nodes do not
    /// have. `velocities`: of their nodes \[m/s\].
    pub fn energies(&self, shift: f64, velocities: &[[f64; 2]]) -> [f64; 2] {
        let speed = self.speed + shift;
        let mut kinetic = 0.5 * self.loaded.inertia * speed * speed;
        let mut potential = 0.0;
        for (s, (arm, &velocity)) in self.arms.iter().zip(velocities).enumerate() {
            let unit = unit(arm.angle);
            let [carried, _] = arm.exchange(unit, arm.rate, velocity, [0.0; 2]);
            kinetic += (arm.rate + shift) * (0.5 * self.given_way(s, |other| other.rate + shift) + carried);
            potential -= arm.moment * (self.gravity[0] * unit.re + self.gravity[1] * unit.im);
        }
        let modes = self.twist.place.iter().zip(&self.twist.rate).zip(&self.elastic);
        for ((place, rate), square) in modes {
            kinetic += 0.5 * rate * rate;
            potential += 0.5 * square * place * place;
        }
        [kinetic, potential]
    }

    /// Amplitudes of the modes of twist.
    pub fn twist(&self) -> &[f64] {
        &self.twist.place
    }

    /// Elastic twist of all nodes \[rad\], by their rows of [`Spin::twist_of`].
    pub fn twists(&self, rows: &[Vec<f64>], twists: &mut [f64]) {
        for (twist, row) in twists.iter_mut().zip(rows) {
            *twist = dot(row, &self.twist.place);
        }
    }

    /// How much of what is foreseen of the unbalances' rates comes back over a step from what of the rotor's answer is not at once: `answers` is that of each node's
    /// velocity to an impulse on it, spread over the step \[1/kg\].
    pub fn comes_back(&self, answers: impl Iterator<Item = f64>) -> f64 {
        let of = |((s, arm), answer): ((usize, &Arm), f64)| {
            (self.loaded.gives_way[s][s] - arm.moment * arm.moment * answer).abs() * self.jump(&arm.row)
        };
        self.arms.iter().enumerate().zip(answers).map(of).sum()
    }

    /// Whether no mode of twist grows in steps of `h` \[s\] over which so much comes back: damping takes more than that of each mode that the step does not resolve, or it comes
    /// to nothing over a whole run of `time` \[s\].
    pub fn holds(&self, h: f64, back: f64, time: f64) -> bool {
        let is_held = |&(square, damping): &(f64, f64)| square * h * h < 1.0 || 0.5 * damping * h >= back;
        back <= 1.0 && (back * time < COMES_TO_NOTHING * h || self.loaded.modes.iter().all(is_held))
    }

    /// Damps modes of twist that steps of `h` \[s\] do not resolve by what comes back over them, at least.
    pub fn hold(&mut self, h: f64, back: f64) {
        for mode in self.loaded.modes.iter_mut().filter(|mode| mode.0 * h * h >= 1.0) {
            mode.1 = mode.1.max(2.0 * back / h);
        }
        self.twist = Oscillators::new(self.loaded.modes.iter().copied());
    }

    /// Jump of a node's rate per angular impulse on it \[1/(kg m2)\].
    pub fn jump(&self, row: &[f64]) -> f64 {
        1.0 / self.loaded.inertia + dot(row, row)
    }

    /// Mean spin of the rotor without unbalances \[rad/s\], and its angle \[rad\]: what is reported, and what brakes turn.
    pub fn mean(&self) -> [f64; 2] {
        let [angle, speed] = both_products([&self.twist.place, &self.twist.rate], &self.loaded.shift);
        [self.speed + speed, self.angle + angle]
    }

    /// Elastic twist of a node, per amplitude; zeros up to a multiple of eight.
    pub fn twist_of(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.loaded.twist(structure, node)
    }

    /// The turn of a node beside the mean angle of rotor and unbalances, per amplitude; zeros up to a multiple of eight.
    pub fn row_of(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.loaded.row(structure, node)
    }

    /// Ends the step with the velocities of the unbalances' nodes \[m/s\] and the gyroscopic momentum at its end, which (4) is still to be added to.
    pub fn complete(&mut self, step: &SpinStep, velocities: &[[f64; 2]], gyroscopic: f64) {
        let h = step.h;
        // braking does not turn before the rotor has stopped
        let after = self.next_speed.max(f64::MIN_POSITIVE);
        let brake = 0.5 * (braking_torque(&self.braking, self.speed) + braking_torque(&self.braking, after));
        self.momentum += h * brake;
        self.twist.add(&step.twist, brake, &self.loaded.shift);
        let mut carried_by_all = gyroscopic;
        for (s, &velocity) in velocities.iter().enumerate() {
            let given = self.given_way(s, |arm| arm.next_rate);
            let Self { arms, twist, gravity, momentum, .. } = self;
            let arm = &mut arms[s];
            arm.unit = unit(arm.next_angle);
            let [carried, pull] = arm.exchange(arm.unit, arm.next_rate, velocity, *gravity);
            let pulled = 0.5 * h * (arm.pull + pull);
            let after = carried + given;
            let exchanged = arm.momentum - after;
            (arm.momentum, arm.pull) = (after, pull);
            arm.torque = (pulled + exchanged) / h;
            twist.add(&step.twist, arm.torque, &arm.row);
            *momentum += pulled;
            carried_by_all += after;
        }
        let speed = (self.momentum - carried_by_all) / self.loaded.inertia;
        let turned = |row: &[f64]| dot(row, &self.twist.place) - dot(row, &self.begun[0]);
        let worked = self.arms.iter().map(|arm| arm.torque * turned(&arm.row)).sum::<f64>();
        // damping takes what is not there any more: (5)
        self.damped += worked + brake * turned(&self.loaded.shift) + lost(&self.begun, &self.twist, &self.elastic);
        self.bend = ((speed - self.next_speed).abs() / (h * h))
            .max((1.0 - FORGETS * h * self.speed.abs()).max(0.0) * self.bend);
        (self.last, self.slope) = (h, (speed - self.speed) / h);
        (self.angle, self.speed) = (self.next_angle, speed);
        for s in 0..self.arms.len() {
            let [place, rate] = self.twisted(&self.arms[s].row);
            let arm = &mut self.arms[s];
            (arm.angle, arm.rate) = (self.angle + place + arm.phase, speed + rate);
            let missed = arm.rate - arm.next_rate;
            arm.left = Complex::new(0.0, -missed) * arm.unit * arm.moment;
        }
    }

    /// Elastic twist of a node \[rad\] and its rate.
    pub fn twisted(&self, row: &[f64]) -> [f64; 2] {
        both_products([&self.twist.place, &self.twist.rate], row)
    }

    /// Force (3) of an unbalance at n \[N\].
    pub fn force_now(&self, s: usize) -> Complex<f64> {
        let arm = &self.arms[s];
        Complex::new(arm.rate * arm.rate, -self.slope) * arm.unit * arm.moment
    }
}

kernel! {
    /// Energy of the twist at the beginning of a step less that at its end.
    fn lost(begun: &[Vec<f64>; 2], twist: &Oscillators, squares: &[f64]) -> f64 {
        let mut sums = [0.0; LANES];
        let before = begun[0].as_chunks::<LANES>().0.iter().zip(begun[1].as_chunks::<LANES>().0);
        let after = twist.place.as_chunks::<LANES>().0.iter().zip(twist.rate.as_chunks::<LANES>().0);
        for (((n, v), (m, w)), square) in before.zip(after).zip(squares.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                sums[k] += 0.5 * ((v[k] - w[k]) * (v[k] + w[k]) + square[k] * ((n[k] - m[k]) * (n[k] + m[k])));
            }
        }
        sum(sums)
    }
}

fn unit(angle: f64) -> Complex<f64> {
    let (sin, cos) = libm::sincos(angle);
    Complex::new(cos, sin)
}
