//! Whirl frequencies and damping at given speeds, critical speeds, twist, axial and ring frequencies of the full
//! finite-element model. Unbalance masses are not in it, except for a point mass, which may have no other.

use super::follow::{critical_speeds, follow};
use super::quadratic::quadratic_modes;
use super::shape::Mode;
use crate::linalg::{EigenError, Matrix, symmetric_generalised};
use crate::machine::{DiaphragmKind, Machine, RotorKind};
use crate::rotor::{RotorMatrices, UnbalanceSite};
use crate::stator::RingMatrices;

/// Sense of a whirl.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whirl {
    /// With the spin.
    Forward,
    /// Against the spin.
    Backward,
    /// Neither: motion in a plane (at rest), or as much forward as backward.
    Planar,
}

impl Whirl {
    /// The word shown.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Whirl::Forward => "forward",
            Whirl::Backward => "backward",
            Whirl::Planar => "planar",
        }
    }
}

/// One damped lateral mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhirlMode {
    /// Damped circular frequency \[rad/s\].
    pub frequency: f64,
    /// Damping ratio `-Re/|lambda|` \[-\].
    pub damping_ratio: f64,
    /// Sense.
    pub whirl: Whirl,
}

impl WhirlMode {
    /// Logarithmic decrement \[-\]: `2 pi zeta/sqrt(1 - zeta^2)`, the logarithm of the ratio of two amplitudes a period apart.
    #[must_use]
    pub fn decrement(&self) -> f64 {
        decrement(self.damping_ratio)
    }
}

impl CriticalSpeed {
    /// Logarithmic decrement \[-\] of the mode there.
    #[must_use]
    pub fn decrement(&self) -> f64 {
        decrement(self.damping_ratio)
    }
}

/// `delta = 2 pi zeta/sqrt(1 - zeta^2)`.
fn decrement(ratio: f64) -> f64 {
    2.0 * std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt()
}

/// A motion that decays before it oscillates: its damping ratio is [`OVERDAMPED`] or more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverdampedMode {
    /// `-Re lambda` \[1/s\]: the motion falls to 1/e in its inverse.
    pub decay: f64,
    /// `Im lambda` \[rad/s\]; 0 where it does not oscillate at all.
    pub frequency: f64,
    /// Damping ratio \[-\]; 1 where it does not oscillate at all.
    pub damping_ratio: f64,
}

/// Modes at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedModes {
    /// Speed \[rad/s\].
    pub speed: f64,
    /// Whirl modes by frequency, each with its number: that of its shape at all speeds, from 1, by the frequencies at rest.
    pub whirl: Vec<(usize, WhirlMode)>,
    /// Overdamped motions, the slowest to decay first.
    pub overdamped: Vec<OverdampedMode>,
}

/// A speed that equals a whirl frequency (synchronous excitation).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticalSpeed {
    /// Speed \[rad/s\].
    pub speed: f64,
    /// Damping ratio of the mode there.
    pub damping_ratio: f64,
    /// Sense; unbalance excites forward modes (backward ones too on an anisotropic support).
    pub whirl: Whirl,
}

/// One ring mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingMode {
    /// Circular frequency \[rad/s\].
    pub frequency: f64,
    /// Nodal diameters: the dominant harmonic of the radial displacement around the ring.
    pub nodal_diameters: usize,
}

/// Modes of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesReport {
    /// The speeds asked for.
    pub speeds: Vec<SpeedModes>,
    /// Critical speeds, ascending.
    pub critical_speeds: Vec<CriticalSpeed>,
    /// Elastic twist frequencies, free-free \[rad/s\].
    pub twist: Vec<f64>,
    /// Axial frequencies \[rad/s\].
    pub axial: Vec<f64>,
    /// Modes of each flexible ring, by diaphragm name.
    pub rings: Vec<(String, Vec<RingMode>)>,
}

/// A motion whose `Im lambda/|lambda|` is below this does not oscillate: rounding alone splits a double real lambda by the
/// root of its own size.
const APERIODIC: f64 = 1e-6;
/// Relative distance below which two lambda are those of one pair.
const PAIR: f64 = 1e-9;

/// Modes of a machine at speeds \[rad/s\].
///
/// ```text
/// M x'' + (C + W G) x' + (K + K_skew) x = 0,  x = Re(phi e^{lambda t}),  W_crit: Im lambda(W) = W
/// ```
/// Source: conventions of the reference data (`tests/data`). Verified by `tests/linear_rotors.rs`, `tests/ring.rs`.
///
/// # Errors
/// [`EigenError`].
pub fn report(machine: &Machine, speeds: &[f64]) -> Result<ModesReport, EigenError> {
    let lateral = Lateral::new(machine);
    let rotor = &lateral.rotor;
    let (critical_speeds, speeds) = (critical_speeds(&lateral)?, follow(&lateral, speeds)?);
    let roots = |k: &Matrix, m: &Matrix, what| -> Result<Vec<f64>, EigenError> {
        let (values, _) = symmetric_generalised(k, m, what)?;
        Ok(values.iter().map(|square| square.max(0.0).sqrt()).collect())
    };
    let twist = roots(&rotor.twist_stiffness, &rotor.twist_mass, "the rotor's twist")?.split_off(1);
    let axial = match machine.rotor.kind {
        RotorKind::Shaft(_) => roots(&rotor.axial_stiffness, &rotor.axial_mass, "the rotor's axial motion")?,
        RotorKind::PointMass(_) => Vec::new(),
    };
    let mut rings = Vec::new();
    for diaphragm in &machine.diaphragms {
        if let DiaphragmKind::Flexible(stator) = &diaphragm.kind {
            rings.push((diaphragm.name.clone(), ring_report(&RingMatrices::assemble(stator))?));
        }
    }
    Ok(ModesReport { speeds, critical_speeds, twist, axial, rings })
}

/// Modes of a machine at speeds \[rad/s\], followed from rest by their shapes, overdamped motions apart.
///
/// # Errors
/// [`EigenError`].
pub fn followed_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<SpeedModes>, EigenError> {
    follow(&Lateral::new(machine), speeds)
}

/// Every oscillating mode of a machine at speeds \[rad/s\], however damped, by frequency.
///
/// # Errors
/// [`EigenError`].
pub fn whirl_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<(f64, Vec<WhirlMode>)>, EigenError> {
    let lateral = Lateral::new(machine);
    speeds.iter().map(|&speed| Ok((speed, lateral.modes(speed)?))).collect()
}

/// Damping ratio from which a motion is overdamped: it falls below a thousandth in one period, and what a strong damper keeps
/// from oscillating at rest turns with `Im lambda` proportional to the speed, which crosses it at no speed, or at every.
pub const OVERDAMPED: f64 = 0.9;

/// Lateral model.
pub(super) struct Lateral {
    pub rotor: RotorMatrices,
    pub mass: Matrix,
    stiffness: Matrix,
    gyroscopic: Matrix,
}

impl Lateral {
    fn new(machine: &Machine) -> Self {
        let rotor = RotorMatrices::assemble(&machine.rotor);
        let mut mass = rotor.mass.clone();
        if matches!(machine.rotor.kind, RotorKind::PointMass(_)) {
            for site in machine.rotor.unbalances.iter().map(UnbalanceSite::new) {
                mass[(0, 0)] += site.mass;
                mass[(1, 1)] += site.mass;
            }
        }
        let stiffness = &rotor.stiffness + rotor.skew_stiffness();
        let gyroscopic = rotor.gyroscopic();
        Self { rotor, mass, stiffness, gyroscopic }
    }

    /// Oscillating modes at a speed, by frequency.
    fn modes(&self, speed: f64) -> Result<Vec<WhirlMode>, EigenError> {
        let all = self.spectrum(speed)?;
        Ok(all.iter().filter(|mode| mode.value[1] > 0.0).map(|mode| self.whirl(mode, speed)).collect())
    }

    /// Every solution with `Im lambda >= 0` at a speed, by frequency. What is aperiodic but for rounding has the frequency 0.
    pub fn spectrum(&self, speed: f64) -> Result<Vec<Mode>, EigenError> {
        let velocity = &self.rotor.damping + &self.gyroscopic * speed;
        let found = quadratic_modes(&self.mass, &velocity, &self.stiffness, "the spinning rotor")?;
        let mut all = Vec::new();
        for (j, &[re, im]) in found.values.iter().enumerate() {
            let least = APERIODIC * re.hypot(im);
            if im > -least {
                let value = [re, if im > least { im } else { 0.0 }];
                all.push(Mode::new(value, &found.real, &found.imaginary, j));
            }
        }
        all.sort_by(|a, b| a.value[1].total_cmp(&b.value[1]).then(b.value[0].total_cmp(&a.value[0])));
        self.turn_pairs(&mut all, &velocity);
        for mode in &mut all {
            mode.weigh(&self.rotor.stiffness, &self.mass);
        }
        Ok(all)
    }

    /// What a table shows of an oscillating mode.
    pub fn whirl(&self, mode: &Mode, speed: f64) -> WhirlMode {
        let [re, im] = mode.value;
        let whirl = if self.plane_motion(speed) { Whirl::Planar } else { self.sense(mode) };
        WhirlMode { frequency: im, damping_ratio: -re / re.hypot(im), whirl }
    }

    /// Modes of equal lambda may be combined at will: where a circle is one of their motions, the forward and the backward
    /// circle are taken.
    fn turn_pairs(&self, all: &mut [Mode], velocity: &Matrix) {
        for j in 1..all.len() {
            let ([a, b], [c, d]) = (all[j - 1].value, all[j].value);
            if b == 0.0 || (a - c).hypot(b - d) > PAIR * a.hypot(b) {
                continue;
            }
            let circle = |forward: bool| {
                let both = [&all[j - 1], &all[j]].map(|mode| mode.circular(&self.rotor, forward));
                let [x, y] = both;
                let larger = if x.size() >= y.size() { x } else { y };
                let residual = larger.residual(&self.mass, velocity, &self.stiffness);
                (residual < 1e3 * PAIR).then_some(larger)
            };
            if let (Some(backward), Some(forward)) = (circle(false), circle(true)) {
                (all[j - 1], all[j]) = (backward, forward);
                // one value: what tells them apart is rounding
                let value = [0.5 * (a + c), 0.5 * (b + d)];
                (all[j - 1].value, all[j].value) = (value, value);
            }
        }
    }

    /// Whether nothing turns the motion: at rest, and no skew or cross-coupled bearing term. The two modes of an isotropic
    /// pair may then be combined at will, and an eigenvector's sense is an accident.
    fn plane_motion(&self, speed: f64) -> bool {
        speed == 0.0
            && self.rotor.bearings.iter().all(|b| b.skew == 0.0 && b.damping[0][1] == 0.0 && b.damping[1][0] == 0.0)
    }

    /// Forward whirl carries x towards y: `v = -i u`, so that `Im(conj(u) v) < 0`.
    fn sense(&self, mode: &Mode) -> Whirl {
        let (mut turning, mut size) = (0.0, 0.0);
        for node in 0..self.rotor.nodes {
            let [[ur, ui], [vr, vi]] = self.rotor.plane_places(node).map(|place| mode.at(place));
            turning -= ur * vi - ui * vr;
            size += ur * ur + ui * ui + vr * vr + vi * vi;
        }
        let share = 2.0 * turning / size;
        if share > 1e-6 {
            Whirl::Forward
        } else if share < -1e-6 {
            Whirl::Backward
        } else {
            Whirl::Planar
        }
    }
}

fn ring_report(ring: &RingMatrices) -> Result<Vec<RingMode>, EigenError> {
    const POINTS: usize = 256;
    let (values, shapes) = symmetric_generalised(&ring.stiffness, &ring.mass, "the ring")?;
    Ok(values
        .iter()
        .enumerate()
        .map(|(j, square)| {
            let shape = crate::linalg::column_of(&shapes, j);
            let surface = ring.surface(ring.mean_radius, false);
            let tangential: Vec<f64> = (0..POINTS)
                .map(|k| {
                    let (element, xi) = surface.locate(2.0 * std::f64::consts::PI * k as f64 / POINTS as f64);
                    surface.point(&shape[..4 * ring.nodes], element, xi).tangential
                })
                .collect();
            let radial = ring.radial(shape, POINTS);
            RingMode { frequency: square.max(0.0).sqrt(), nodal_diameters: dominant_harmonic(&[radial, tangential]) }
        })
        .collect())
}

/// Harmonic with the most power, radial and tangential together: a ring that turns on its blades moves hardly any other way.
fn dominant_harmonic(fields: &[Vec<f64>; 2]) -> usize {
    let count = fields[0].len();
    let power = |n: usize| -> f64 { fields.iter().map(|samples| harmonic_power(samples, n)).sum() };
    (0..=count / 4).map(|n| (n, power(n))).fold((0, -1.0), |best, next| if next.1 > best.1 { next } else { best }).0
}

fn harmonic_power(samples: &[f64], n: usize) -> f64 {
    let count = samples.len();
    let (mut c, mut s) = (0.0, 0.0);
    for (k, value) in samples.iter().enumerate() {
        let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * ((n * k) % count) as f64 / count as f64);
        c += value * cos;
        s += value * sin;
    }
    // a cosine's energy is spread over both signs of n, a constant's is not
    if n == 0 { 0.5 * c * c } else { c * c + s * s }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_told_apart() {
        for n in [0, 1, 2, 5] {
            let samples: Vec<f64> =
                (0..256).map(|k| (2.0 * std::f64::consts::PI * f64::from(n * k) / 256.0 + 0.3).cos()).collect();
            let quiet: Vec<f64> =
                samples.iter().enumerate().map(|(k, _)| if k % 16 == 0 { 1e-3 } else { 0.0 }).collect();
            let n = usize::try_from(n).expect("small");
            assert_eq!(dominant_harmonic(&[samples.clone(), quiet.clone()]), n);
            assert_eq!(dominant_harmonic(&[quiet, samples]), n);
        }
    }
}
