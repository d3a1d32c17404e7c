//! Whirl modes of the shaft line on its bearings at a constant speed, in the full finite-element model: frequencies, damping, sense.
//! Unbalance masses are excluded, except for a point mass, which may have no other mass.

use std::cell::Cell;

use super::matrices::{Matrices, Reduced};
use super::quadratic::{Eigensolver, QuadraticModes, quadratic_modes_by};
use super::sense::{Whirl, excited_by_unbalance, orbits, sense};
use super::shape::Mode;
use crate::rotor::{RotorMatrices, UnbalanceSite};
use bladeoff_model::machine::{Machine, RotorKind};
use bladeoff_numerics::linalg::{Csr, EigenError, Matrix, mul};

/// A damped lateral mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhirlMode {
    /// Damped circular frequency `Im lambda` \[rad/s\].
    pub frequency: f64,
    /// Damping ratio `-Re lambda/|lambda|` \[-\]; negative for an unstable mode.
    pub damping_ratio: f64,
    /// Sense of whirl.
    pub whirl: Whirl,
    /// Net share of forward whirl \[-\]: -1 for backward circles, 1 for forward circles.
    pub share: f64,
}

impl WhirlMode {
    /// Logarithmic decrement \[-\]: `2 pi zeta/sqrt(1 - zeta^2)`, the logarithm of the ratio of two amplitudes one period apart.
    #[must_use]
    pub fn decrement(&self) -> f64 {
        decrement(self.damping_ratio)
    }
}

impl CriticalSpeed {
    /// Returns whether unbalance excites the mode, that is, whether the mode has a forward part.
    #[must_use]
    pub fn is_excited_by_unbalance(&self) -> bool {
        excited_by_unbalance(self.share)
    }

    /// Logarithmic decrement of the mode at the critical speed \[-\].
    #[must_use]
    pub fn decrement(&self) -> f64 {
        decrement(self.damping_ratio)
    }
}

/// Logarithmic decrement `delta = 2 pi zeta/sqrt(1 - zeta^2)` \[-\] of a damping ratio zeta.
fn decrement(ratio: f64) -> f64 {
    2.0 * std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt()
}

/// An overdamped motion: its damping ratio is at least [`OVERDAMPED`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverdampedMode {
    /// Decay rate `-Re lambda` \[1/s\]: the motion decays to 1/e in the time 1/decay.
    pub decay: f64,
    /// Damped circular frequency `Im lambda` \[rad/s\]; 0 for an aperiodic motion.
    pub frequency: f64,
    /// Damping ratio \[-\]; 1 for an aperiodic motion.
    pub damping_ratio: f64,
}

/// Modes at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedModes {
    /// Speed W \[rad/s\].
    pub speed: f64,
    /// Whirl modes by frequency, each with the number of its tracked mode: the same at all speeds, from 1, by frequency at rest.
    pub whirl: Vec<(usize, WhirlMode)>,
    /// Overdamped motions, slowest decay first. At rest, both motions of a pair in two planes are listed; at speed, the pair counts as one
    /// motion.
    pub overdamped: Vec<OverdampedMode>,
}

/// A critical speed: a speed that equals a whirl frequency (synchronous excitation).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticalSpeed {
    /// Critical speed \[rad/s\].
    pub speed: f64,
    /// Damping ratio of the mode at this speed \[-\].
    pub damping_ratio: f64,
    /// Sense of whirl. Unbalance excites modes of every sense except backward circles ([`CriticalSpeed::is_excited_by_unbalance`]).
    pub whirl: Whirl,
    /// Net share of forward whirl \[-\]: -1 for backward circles, 1 for forward circles.
    pub share: f64,
}

/// Ratio `Im lambda/|lambda|` below which a motion is aperiodic. Rounding alone splits a double real lambda by the square root of its
/// relative size.
pub(super) const APERIODIC: f64 = 1e-6;
/// Relative difference below which two lambda belong to one pair.
const PAIR: f64 = 1e-9;
/// Share of a mode's smaller circle above which the mode is a mixture of two circles. `NEAR`: relative distance of lambda within which its
/// partner is searched.
pub(super) const MIXED: f64 = 1e-3;
const NEAR: f64 = 1e-3;
/// Speed below which [`Lateral::barely_turning`] is tried \[rad/s\]. `SLIGHT`: it is used up to this multiple of the smallest |lambda|.
const SLOW: f64 = 0.1;
const SLIGHT: f64 = 1e-6;
/// Relative difference of two matrix entries that counts as rounding in the isotropy test.
const ALIKE: f64 = 1e-12;

/// Returns every oscillating mode of a machine at given speeds \[rad/s\], regardless of damping, by frequency.
///
/// # Errors
/// [`EigenError`].
pub fn whirl_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<(f64, Vec<WhirlMode>)>, EigenError> {
    let lateral = Lateral::new(machine, Eigensolver::Display);
    speeds.iter().map(|&speed| Ok((speed, lateral.modes(speed)?))).collect()
}

/// Sets the damping of an oscillating lambda to zero if its damping ratio is within the numerical noise of the eigenvalue problem.
fn without_noise(value: [f64; 2], of: &QuadraticModes) -> [f64; 2] {
    undamped_below(of.noise(value), value)
}

/// Sets the damping of an oscillating lambda to zero if the magnitude of its damping ratio is at most `noise`.
pub(super) fn undamped_below(noise: f64, [re, im]: [f64; 2]) -> [f64; 2] {
    let is_noise = im > 0.0 && re.abs() <= noise * libm::hypot(re, im);
    [if is_noise { 0.0 } else { re }, im]
}

/// Damping ratio from which a motion is overdamped: it decays below a thousandth in one period, and no response has a peak at its critical
/// speed. A strong damper suppresses oscillation at rest; at speed, the gyroscopic effect gives such a motion an `Im lambda` proportional to
/// the speed, which is not tracked by shape. So critical speeds of overdamped motions are listed separately.
pub const OVERDAMPED: f64 = 0.9;

/// Number of solved eigenproblems.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// In the full model.
    pub full: usize,
    /// In a reduced basis.
    pub reduced: usize,
}

/// Returns whether a motion is a whirl mode: oscillating and not overdamped.
pub(super) fn whirls(mode: &Mode) -> bool {
    let [re, im] = mode.value;
    im > 0.0 && -re < OVERDAMPED * libm::hypot(re, im)
}

/// Lateral model of a machine at constant speed.
pub(super) struct Lateral {
    pub rotor: RotorMatrices,
    /// Lateral matrices without bearing tables.
    pub matrices: Matrices,
    /// M and the symmetric part of K, for [`Mode::weigh`].
    sparse: [Csr; 2],
    /// All lateral directions are equivalent.
    pub isotropic: bool,
    pub solver: Eigensolver,
    pub work: Cell<Work>,
}

impl Lateral {
    pub fn new(machine: &Machine, solver: Eigensolver) -> Self {
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
        let isotropic =
            rotor.tables.is_empty() && Self::all_alike(&rotor, &[&mass, &stiffness, &rotor.damping, &gyroscopic]);
        let sparse = [&mass, &rotor.stiffness].map(Csr::from_dense);
        let matrices = Matrices { mass, damping: rotor.damping.clone(), stiffness, gyroscopic };
        Self { rotor, matrices, sparse, isotropic, solver, work: Cell::default() }
    }

    /// Returns C + W G and K + K_skew at a speed W \[rad/s\], bearing tables included.
    pub fn at(&self, reduced: Option<&Reduced>, speed: f64) -> [Matrix; 2] {
        let matrices = reduced.map_or(&self.matrices, |reduced| &reduced.matrices);
        let mut velocity = &matrices.damping + &matrices.gyroscopic * speed;
        let mut stiffness = matrices.stiffness.clone();
        if let Some(changes) = self.rotor.change_at(speed) {
            let [k, c] = changes.map(|change| reduced.map_or(change.clone(), |reduced| reduced.projected(&change)));
            velocity += c;
            stiffness += k;
        }
        [velocity, stiffness]
    }

    /// Computes the products that the comparison of a mode with others needs.
    pub fn weigh(&self, mode: &mut Mode) {
        mode.weigh(&self.sparse[1], &self.sparse[0]);
    }

    fn solve(
        &self,
        is_reduced: bool,
        matrices: [&Matrix; 3],
        what: &'static str,
    ) -> Result<QuadraticModes, EigenError> {
        let Work { full, reduced } = self.work.get();
        self.work.set(Work { full: full + usize::from(!is_reduced), reduced: reduced + usize::from(is_reduced) });
        quadratic_modes_by(self.solver, matrices, what)
    }

    /// Returns the oscillating modes at a speed, by frequency.
    fn modes(&self, speed: f64) -> Result<Vec<WhirlMode>, EigenError> {
        let all = self.spectrum(speed)?;
        Ok(all.iter().filter(|mode| mode.value[1] > 0.0).map(|mode| self.whirl(mode, speed)).collect())
    }

    /// Returns every solution with `Im lambda >= 0` at a speed, by frequency. A motion that is aperiodic except for rounding has the
    /// frequency 0.
    pub fn spectrum(&self, speed: f64) -> Result<Vec<Mode>, EigenError> {
        self.spectrum_in(None, speed)
    }

    /// [`Lateral::spectrum`] from a reduced basis; the mode shapes are in nodal coordinates.
    pub fn spectrum_in(&self, reduced: Option<&Reduced>, speed: f64) -> Result<Vec<Mode>, EigenError> {
        if self.isotropic && self.plane_motion(0.0) && speed < SLOW {
            let all = self.barely_turning(reduced, speed)?;
            let slowest =
                all.iter().map(|mode| libm::hypot(mode.value[0], mode.value[1])).fold(f64::INFINITY, f64::min);
            if speed <= SLIGHT * slowest {
                return Ok(all);
            }
        }
        let mass = reduced.map_or(&self.matrices.mass, |reduced| &reduced.matrices.mass);
        let [velocity, stiffness] = self.at(reduced, speed);
        let mut found = self.solve(reduced.is_some(), [mass, &velocity, &stiffness], "the spinning rotor")?;
        if let Some(reduced) = reduced {
            found.real = mul(&reduced.shapes, &found.real);
            found.imaginary = mul(&reduced.shapes, &found.imaginary);
        }
        let mut all = Vec::new();
        for (j, &[re, im]) in found.values.iter().enumerate() {
            let least = APERIODIC * libm::hypot(re, im);
            if im > -least {
                let value = without_noise([re, if im > least { im } else { 0.0 }], &found);
                all.push(Mode::new(value, &found.real, &found.imaginary, j));
            }
        }
        all.sort_by(|a, b| a.value[1].total_cmp(&b.value[1]).then(b.value[0].total_cmp(&a.value[0])));
        if self.isotropic {
            self.take_circles(&mut all);
        }
        for mode in &mut all {
            self.weigh(mode);
        }
        Ok(all)
    }

    /// [`Lateral::spectrum`] of an isotropic rotor whose planes are almost uncoupled: the motions of one plane as backward and forward
    /// circles (backward first), with lambda to first order in the speed
    ///
    /// ```text
    /// d lambda = -+ lambda W b^T G f / b^T (2 lambda M + C) f,  f, b the forward and backward circle
    /// ```
    /// The full matrices give wrong mode shapes here, because each lambda is double except for rounding.
    fn barely_turning(&self, reduced: Option<&Reduced>, speed: f64) -> Result<Vec<Mode>, EigenError> {
        let [xz, _] = self.rotor.planes();
        let matrices = reduced.map_or(&self.matrices, |reduced| &reduced.matrices);
        let first = match reduced {
            Some(reduced) => (0..reduced.per_plane()).collect(),
            None => xz.clone(),
        };
        let plane = |a: &Matrix| a.select_rows(&first).select_columns(&first);
        let [mass, damping, stiffness] = [&matrices.mass, &matrices.damping, &matrices.stiffness].map(plane);
        let found = self.solve(reduced.is_some(), [&mass, &damping, &stiffness], "the resting rotor")?;
        let both = |shapes: &Matrix| {
            if let Some(reduced) = reduced {
                return mul(&reduced.shapes.columns(0, first.len()).into_owned(), shapes);
            }
            let mut both = Matrix::zeros(self.rotor.lateral_size(), shapes.ncols());
            for (row, &place) in xz.iter().enumerate() {
                both.set_row(place, &shapes.row(row));
            }
            both
        };
        let (real, imaginary) = (both(&found.real), both(&found.imaginary));
        let mut all = Vec::new();
        for (j, &[re, im]) in found.values.iter().enumerate() {
            let least = APERIODIC * libm::hypot(re, im);
            if im > -least {
                let value = without_noise([re, if im > least { im } else { 0.0 }], &found);
                let mode = Mode::new(value, &real, &imaginary, j);
                let [mut backward, mut forward] = [false, true].map(|way| mode.circular(&self.rotor, way));
                if im > least && speed > 0.0 {
                    let [g, m, c] = [&self.matrices.gyroscopic, &self.matrices.mass, &self.matrices.damping]
                        .map(|matrix| backward.through(matrix, &forward));
                    let [p, q] = [2.0 * (re * m[0] - im * m[1]) + c[0], 2.0 * (re * m[1] + im * m[0]) + c[1]];
                    let (x, y) = (re * g[0] - im * g[1], re * g[1] + im * g[0]);
                    let share = speed / (p * p + q * q);
                    let change = [share * (x * p + y * q), share * (y * p - x * q)];
                    backward.value = [re + change[0], im + change[1]];
                    forward.value = [re - change[0], im - change[1]];
                }
                all.extend([backward, forward]);
            }
        }
        // stable sort: the backward circle stays first
        all.sort_by(|a, b| a.value[1].total_cmp(&b.value[1]).then(b.value[0].total_cmp(&a.value[0])));
        for mode in &mut all {
            self.weigh(mode);
        }
        Ok(all)
    }

    /// Returns frequency, damping ratio and sense of an oscillating mode.
    pub fn whirl(&self, mode: &Mode, speed: f64) -> WhirlMode {
        let [re, im] = mode.value;
        let (whirl, share) =
            if self.plane_motion(speed) { (Whirl::Planar, 0.0) } else { sense(&orbits(mode, &self.rotor)) };
        // 0 - re avoids a negative zero
        WhirlMode { frequency: im, damping_ratio: (0.0 - re) / libm::hypot(re, im), whirl, share }
    }

    /// Splits the modes of an isotropic rotor into circles. Every motion of such a rotor is a circle or a sum of two circles, and only
    /// circles continue into the modes at other speeds. Modes whose lambda are equal except for rounding come out in an arbitrary mixture;
    /// they are replaced by their circles, backward first.
    fn take_circles(&self, all: &mut [Mode]) {
        let parts: Vec<_> = all.iter().map(|mode| [false, true].map(|way| mode.circular(&self.rotor, way))).collect();
        let shares: Vec<f64> = parts.iter().map(|[b, f]| f.size() / (b.size() + f.size())).collect();
        let mut mixed = Vec::new();
        for (j, mode) in all.iter_mut().enumerate().filter(|(_, mode)| mode.value[1] > 0.0) {
            if shares[j].min(1.0 - shares[j]) > MIXED {
                mixed.push(j);
            } else {
                *mode = parts[j][usize::from(shares[j] > 0.5)].clone();
            }
        }
        let mut near = Vec::new();
        for (at, &j) in mixed.iter().enumerate() {
            for &k in &mixed[at + 1..] {
                let ([a, b], [c, d]) = (all[j].value, all[k].value);
                near.push((libm::hypot(a - c, b - d) / libm::hypot(a, b), j, k));
            }
        }
        near.retain(|pair| pair.0 < NEAR);
        near.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        for (distance, j, k) in near {
            if !(mixed.contains(&j) && mixed.contains(&k)) {
                continue;
            }
            mixed.retain(|&other| other != j && other != k);
            let ([a, b], [c, d]) = (all[j].value, all[k].value);
            let alike = distance <= PAIR;
            // one value: the two lambda differ by rounding only
            let middle = [0.5 * (a + c), 0.5 * (b + d)];
            let (backward, forward) = if alike || shares[j] <= shares[k] { (j, k) } else { (k, j) };
            for (place, way) in [(backward, 0), (forward, 1)] {
                let value = if alike { middle } else { all[place].value };
                let larger = if parts[j][way].size() >= parts[k][way].size() { j } else { k };
                all[place] = parts[larger][way].clone();
                all[place].value = value;
            }
        }
    }

    /// Returns whether all lateral directions are equivalent: a rotation of the machine by a right angle does not change the matrices.
    fn all_alike(rotor: &RotorMatrices, matrices: &[&Matrix]) -> bool {
        let [xz, yz] = rotor.planes();
        let half = xz.len();
        matrices.iter().all(|matrix| {
            // terms of two elements may cancel except for rounding
            let sizes: Vec<f64> = (0..2 * half).map(|row| matrix.row(row).amax()).collect();
            (0..half * half).all(|place| {
                let (i, j) = (place / half, place % half);
                let turn = rotor.turn_sign(i) * rotor.turn_sign(j);
                let direct = matrix[(xz[i], xz[j])] - turn * matrix[(yz[i], yz[j])];
                let cross = matrix[(xz[i], yz[j])] + turn * matrix[(yz[i], xz[j])];
                direct.abs().max(cross.abs()) <= ALIKE * (sizes[xz[i]] * sizes[xz[j]]).sqrt()
            })
        })
    }

    /// Returns whether every motion may remain in one plane: at rest, without skew or cross-coupled bearing terms. The two modes of an
    /// isotropic pair may then be combined arbitrarily, so the sense of an eigenvector has no meaning.
    pub fn plane_motion(&self, speed: f64) -> bool {
        speed == 0.0
            && self.rotor.tables.is_empty()
            && self.rotor.bearings.iter().all(|b| b.skew == 0.0 && b.damping[0][1] == 0.0 && b.damping[1][0] == 0.0)
    }
}
