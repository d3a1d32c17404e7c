//! Whirl frequencies and damping at given speeds, critical speeds, twist, axial and ring frequencies of the full
//! finite-element model. Unbalance masses are not in it, except for a point mass, which may have no other.

use super::quadratic::quadratic_modes;
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
    /// For each speed asked for \[rad/s\], its whirl modes by frequency.
    pub speeds: Vec<(f64, Vec<WhirlMode>)>,
    /// Critical speeds, ascending.
    pub critical_speeds: Vec<CriticalSpeed>,
    /// Elastic twist frequencies, free-free \[rad/s\].
    pub twist: Vec<f64>,
    /// Axial frequencies \[rad/s\].
    pub axial: Vec<f64>,
    /// Modes of each flexible ring, by diaphragm name.
    pub rings: Vec<(String, Vec<RingMode>)>,
}

/// Whirl modes at rest below which critical speeds are looked for.
const CRITICAL_MODES: usize = 12;
/// Intervals of the search for critical speeds.
const CRITICAL_INTERVALS: usize = 64;
/// An interval in which the number of modes changes is halved at most so many times.
const CRITICAL_HALVINGS: usize = 10;
/// A motion whose `Im lambda/|lambda|` is below this does not oscillate: rounding alone splits a double real lambda by the
/// root of its own size.
const APERIODIC: f64 = 1e-6;
/// Damping ratio from which a mode has no critical speed. What a strong damper keeps from oscillating at rest turns with
/// `Im lambda` proportional to the speed, which crosses it at no speed, or at every.
const NO_RESONANCE: f64 = 0.99;

/// Modes of a machine at speeds \[rad/s\].
///
/// ```text
/// M x'' + (C + W G) x' + (K + K_skew) x = 0,  x = Re(phi e^{lambda t}),  W_crit: Im lambda(W) = W, damping ratio < 0.99
/// ```
/// Source: conventions of the reference data (`tests/data`). Verified by `tests/linear_rotors.rs`, `tests/ring.rs`.
///
/// # Errors
/// [`EigenError`].
pub fn report(machine: &Machine, speeds: &[f64]) -> Result<ModesReport, EigenError> {
    let lateral = Lateral::new(machine);
    let rotor = &lateral.rotor;
    let speeds = whirl_modes(machine, speeds)?;
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
    Ok(ModesReport { speeds, critical_speeds: lateral.critical_speeds()?, twist, axial, rings })
}

/// Whirl modes of a machine at speeds \[rad/s\], by frequency.
///
/// # Errors
/// [`EigenError`].
pub fn whirl_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<(f64, Vec<WhirlMode>)>, EigenError> {
    let lateral = Lateral::new(machine);
    speeds.iter().map(|&speed| Ok((speed, lateral.modes(speed)?))).collect()
}

/// Lateral model.
struct Lateral {
    rotor: RotorMatrices,
    mass: Matrix,
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
        let velocity = &self.rotor.damping + &self.gyroscopic * speed;
        let found = quadratic_modes(&self.mass, &velocity, &self.stiffness, "the spinning rotor")?;
        let mut modes: Vec<WhirlMode> = found
            .values
            .iter()
            .enumerate()
            .filter(|(_, [re, im])| *im > APERIODIC * re.hypot(*im))
            .map(|(j, &[re, im])| WhirlMode {
                frequency: im,
                damping_ratio: -re / re.hypot(im),
                whirl: if self.plane_motion(speed) {
                    Whirl::Planar
                } else {
                    self.sense(j, &found.real, &found.imaginary)
                },
            })
            .collect();
        modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        Ok(modes)
    }

    /// Whether nothing turns the motion: at rest, and no skew or cross-coupled bearing term. The two modes of an isotropic
    /// pair may then be combined at will, and an eigenvector's sense is an accident.
    fn plane_motion(&self, speed: f64) -> bool {
        speed == 0.0
            && self.rotor.bearings.iter().all(|b| b.skew == 0.0 && b.damping[0][1] == 0.0 && b.damping[1][0] == 0.0)
    }

    /// Forward whirl carries x towards y: `v = -i u`, so that `Im(conj(u) v) < 0`.
    fn sense(&self, mode: usize, real: &Matrix, imaginary: &Matrix) -> Whirl {
        let (mut turning, mut size) = (0.0, 0.0);
        for node in 0..self.rotor.nodes {
            let [u, v] = self.rotor.plane_places(node);
            let (ur, ui) = (real[(u, mode)], imaginary[(u, mode)]);
            let (vr, vi) = (real[(v, mode)], imaginary[(v, mode)]);
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

    /// The modes that may be critical, by frequency.
    fn resonances(&self, speed: f64) -> Result<Vec<WhirlMode>, EigenError> {
        let mut modes = self.modes(speed)?;
        modes.retain(|mode| mode.damping_ratio < NO_RESONANCE);
        Ok(modes)
    }

    /// Speeds at which a whirl frequency equals the speed, by sign changes of the sorted curves.
    fn critical_speeds(&self) -> Result<Vec<CriticalSpeed>, EigenError> {
        let at_rest = self.resonances(0.0)?;
        let Some(last) = at_rest.get(CRITICAL_MODES - 1).or(at_rest.last()) else { return Ok(Vec::new()) };
        let top = 1.05 * last.frequency;
        let mut found = Vec::new();
        let (mut from, mut modes_from) = (0.0, at_rest);
        for interval in 1..=CRITICAL_INTERVALS {
            let to = top * interval as f64 / CRITICAL_INTERVALS as f64;
            let modes_to = self.resonances(to)?;
            self.critical_between((from, &modes_from), (to, &modes_to), CRITICAL_HALVINGS, &mut found)?;
            (from, modes_from) = (to, modes_to);
        }
        found.sort_by(|a: &CriticalSpeed, b| a.speed.total_cmp(&b.speed));
        Ok(found)
    }

    /// Critical speeds of one interval, given the modes at its ends. Where a mode comes or goes the sorted curves jump: the
    /// interval is halved until only a sliver has that.
    fn critical_between(
        &self,
        (from, modes_from): (f64, &[WhirlMode]),
        (to, modes_to): (f64, &[WhirlMode]),
        halvings: usize,
        found: &mut Vec<CriticalSpeed>,
    ) -> Result<(), EigenError> {
        if modes_from.len() != modes_to.len() && halvings > 0 {
            let middle = 0.5 * (from + to);
            let modes = self.resonances(middle)?;
            self.critical_between((from, modes_from), (middle, &modes), halvings - 1, found)?;
            return self.critical_between((middle, &modes), (to, modes_to), halvings - 1, found);
        }
        let below = |modes: &[WhirlMode], speed: f64| modes.iter().filter(|mode| mode.frequency < speed).count();
        let (a, b) = (below(modes_from, from), below(modes_to, to));
        for k in a.min(b)..a.max(b) {
            let (Some(first), Some(last)) = (modes_from.get(k), modes_to.get(k)) else { continue };
            let ends = (first.frequency - from, last.frequency - to);
            found.extend(self.crossing(k, (from, to), ends)?);
        }
        Ok(())
    }

    /// Root of `omega_k(W) - W` in an interval, by regula falsi (Illinois).
    fn crossing(
        &self,
        k: usize,
        (mut a, mut b): (f64, f64),
        (mut fa, mut fb): (f64, f64),
    ) -> Result<Option<CriticalSpeed>, EigenError> {
        let mut side = 0;
        for _ in 0..80 {
            let c = (a * fb - b * fa) / (fb - fa);
            let Some(mode) = self.resonances(c)?.get(k).copied() else { return Ok(None) };
            let fc = mode.frequency - c;
            // a jump of the curve is no crossing
            if (b - a).abs() < 1e-13 * c && fc.abs() > 1e-6 * c {
                return Ok(None);
            }
            if fc.abs() < 1e-12 * c || (b - a).abs() < 1e-13 * c {
                return Ok(Some(CriticalSpeed { speed: c, damping_ratio: mode.damping_ratio, whirl: mode.whirl }));
            }
            if (fc > 0.0) == (fa > 0.0) {
                (a, fa) = (c, fc);
                if side == -1 {
                    fb *= 0.5;
                }
                side = -1;
            } else {
                (b, fb) = (c, fc);
                if side == 1 {
                    fa *= 0.5;
                }
                side = 1;
            }
        }
        Ok(None)
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
