//! Modes of a machine for display: whirl and critical speeds, torsional, axial and ring frequencies of the full finite-element model.

use super::follow::{CriticalSpeeds, critical_speeds, follow};
use super::quadratic::Eigensolver;
use super::spectra::ModesError;
use super::whirl::{CriticalSpeed, Lateral, SpeedModes, Work};
use crate::rotor::RotorMatrices;
use crate::stator::RingMatrices;
use bladeoff_model::machine::{DiaphragmKind, Machine, RotorKind};
use bladeoff_numerics::linalg::{EigenError, Matrix, column_of, symmetric_generalised};

/// One ring mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingMode {
    /// Circular frequency \[rad/s\].
    pub frequency: f64,
    /// Number of nodal diameters: the dominant harmonic of the ring's displacement around the circumference.
    pub nodal_diameters: usize,
}

/// Modes of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesReport {
    /// Modes at the requested speeds.
    pub speeds: Vec<SpeedModes>,
    /// Critical speeds of whirl modes, ascending.
    pub critical_speeds: Vec<CriticalSpeed>,
    /// Critical speeds of overdamped motions ([`super::OVERDAMPED`]), ascending: no response to unbalance has a peak there. Limits: a motion whose
    /// shape changes much from one speed to the next is missing.
    pub overdamped_critical_speeds: Vec<CriticalSpeed>,
    /// Elastic torsional frequencies, free-free \[rad/s\].
    pub torsion: Vec<f64>,
    /// Axial frequencies \[rad/s\].
    pub axial: Vec<f64>,
    /// Modes of each flexible ring, by diaphragm name.
    pub rings: Vec<(String, Vec<RingMode>)>,
    /// Number of lateral eigenproblems solved.
    pub work: Work,
}

/// Modes of a machine at speeds \[rad/s\].
///
/// ```text
/// M x'' + (C + W G) x' + (K + K_skew) x = 0,  x = Re(phi e^{lambda t}),  W_crit: Im lambda(W) = W
/// ```
/// Source: conventions of the reference data (`tests/data`). Verified by `tests/rotor/linear_rotors.rs`, `tests/contact/ring.rs`.
///
/// # Errors
/// [`ModesError`].
pub fn report(machine: &Machine, speeds: &[f64]) -> Result<ModesReport, ModesError> {
    report_by(Eigensolver::Display, machine, speeds)
}

/// [`report`] with a given solver. [`Eigensolver::Own`] solves every problem in the full model.
///
/// # Errors
/// [`ModesError`].
pub fn report_by(solver: Eigensolver, machine: &Machine, speeds: &[f64]) -> Result<ModesReport, ModesError> {
    let lateral = Lateral::new(machine, solver);
    let rotor = &lateral.rotor;
    let CriticalSpeeds { whirl: critical_speeds, overdamped } = critical_speeds(&lateral)?;
    let speeds = follow(&lateral, speeds)?;
    let torsion = elastic_torsion(rotor)?;
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
    let work = lateral.work.get();
    Ok(ModesReport { speeds, critical_speeds, overdamped_critical_speeds: overdamped, torsion, axial, rings, work })
}

fn roots(k: &Matrix, m: &Matrix, what: &'static str) -> Result<Vec<f64>, EigenError> {
    let (values, _) = symmetric_generalised(k, m, what)?;
    Ok(values.iter().map(|square| square.max(0.0).sqrt()).collect())
}

/// Without the rigid rotation, which comes first.
fn elastic_torsion(rotor: &RotorMatrices) -> Result<Vec<f64>, EigenError> {
    Ok(roots(&rotor.torsional_stiffness, &rotor.torsional_mass, "torsion of the rotor")?.split_off(1))
}

/// Returns the polar moment of inertia of the whole rotor \[kg m2\].
#[must_use]
pub fn polar_inertia(machine: &Machine) -> f64 {
    RotorMatrices::assemble(&machine.rotor).torsional_mass.sum()
}

/// Returns the elastic torsional frequencies of the free shaft line \[rad/s\], ascending.
///
/// # Errors
/// The eigenproblem has no solution.
pub fn torsional_frequencies(machine: &Machine) -> Result<Vec<f64>, EigenError> {
    elastic_torsion(&RotorMatrices::assemble(&machine.rotor))
}

/// Returns the modes of a machine at speeds \[rad/s\], tracked from rest by their mode shapes; overdamped motions are separate.
///
/// # Errors
/// [`ModesError`].
pub fn followed_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<SpeedModes>, ModesError> {
    follow(&Lateral::new(machine, Eigensolver::Display), speeds)
}

fn ring_report(ring: &RingMatrices) -> Result<Vec<RingMode>, EigenError> {
    const POINTS: usize = 256;
    let (values, shapes) = ring.modes()?;
    Ok(values
        .iter()
        .enumerate()
        .map(|(j, square)| {
            let shape = column_of(&shapes, j);
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

/// Harmonic with the largest power of radial and tangential displacement. The tangential part matters for a ring that rotates on its blades
/// almost without radial motion.
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
    // a cosine's energy is spread over both signs of n, that of a constant is not
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
