//! Reduced basis for tracking modes over speed: mode shapes of the full model at a few speeds.
//!
//! ```text
//! x = V y,  V = [Phi 0; 0 S Phi],   V^T (lambda^2 M + lambda (C + W G) + K) V y = 0                            (1)
//! e = |L^-1 P(lambda, W) V y| / |L^T V y|        P of the full model, K = L L^T + K_skew                        (2)
//! ```
//! Phi spans the mode shapes, in both planes, of all modes up to [`REACH`] times the highest speed: at rest, at the highest speed, and at
//! the speeds with the largest error. S rotates the XZ plane into the YZ plane. (2) estimates the error of a mode shape in the norm of the
//! strain energy; the error of lambda is of second order in it. Source: Galerkin projection on snapshots with greedy selection (reduced
//! basis method). Limits: modes above the highest speed are inaccurate. Verified by `both_solvers_agree_on_every_kind_of_machine` in
//! `tests/rotor/display_modes.rs`.

use super::matrices::Reduced;
use super::refine::Refinement;
use super::shape::Mode;
use super::whirl::{Lateral, whirls};
use bladeoff_numerics::linalg::{EigenError, Matrix, axpy, cholesky, dot, mul_transposed_vec, mul_vec, solve_upper};

/// Highest |lambda| of the basis, as a multiple of the highest speed.
const REACH: f64 = 1.25;
/// Norm below which a remainder of a mode shape (of unit strain energy) does not extend the basis.
const LEFT_OUT: f64 = 2e-4;
/// Largest allowed error (2) of a mode below the highest speed.
const ALLOWED: f64 = 1e-3;
/// Largest relative difference of lambda from that of the full model.
const SAME: f64 = 1e-4;
/// Number of intervals between the speeds at which (2) is evaluated.
const CHECKS: usize = 8;
/// Maximum number of speeds at which the full model is solved, including rest.
const MOST: usize = 6;
/// Largest share of the degrees of freedom at which the reduced problem is worth its cost.
const WORTH: f64 = 0.6;

/// Returns a basis that is accurate for the modes up to the speed `top` \[rad/s\], from rest to that speed; `None`: no such basis is worth
/// its cost. `rest`: modes of the full model at rest.
///
/// # Errors
/// [`EigenError`].
pub(super) fn checked_basis(full: &Refinement<'_>, rest: Vec<Mode>, top: f64) -> Result<Option<Reduced>, EigenError> {
    // at the highest speed the mode shapes differ most from those at rest
    let mut known = vec![(0.0, rest), (top, full.lateral.spectrum(top)?)];
    loop {
        let Some(reduced) = basis_of(full, known.iter().flat_map(|(_, modes)| modes), top) else { return Ok(None) };
        let mut worst = (0.0, 0.0);
        for check in 0..=CHECKS {
            let speed = top * check as f64 / CHECKS as f64;
            let modes = full.lateral.spectrum_in(Some(&reduced), speed)?;
            let lacks = known.iter().any(|(at, exact)| *at == speed && !has_all(&modes, exact, top));
            let error = if lacks { f64::INFINITY } else { error(full, &modes, speed, top) };
            if error > worst.0 {
                worst = (error, speed);
            }
        }
        let (error, speed) = worst;
        if error <= ALLOWED {
            return Ok(Some(reduced));
        }
        if known.len() == MOST || known.iter().any(|(at, _)| *at == speed) {
            return Ok(None);
        }
        known.push((speed, full.lateral.spectrum(speed)?));
    }
}

/// Builds the basis from modes of the full model.
fn basis_of<'a>(full: &Refinement<'_>, modes: impl Iterator<Item = &'a Mode>, top: f64) -> Option<Reduced> {
    let Lateral { rotor, matrices, .. } = full.lateral;
    let [xz, yz] = rotor.planes();
    let half = xz.len();
    let turned: Vec<f64> = (0..half).map(|order| rotor.turn_sign(order)).collect();
    let stiffness = &matrices.stiffness;
    let sum = Matrix::from_fn(half, half, |i, j| {
        let [x, y] = [&xz, &yz].map(|places| stiffness[(places[i], places[j])] + stiffness[(places[j], places[i])]);
        0.5 * (x + turned[i] * turned[j] * y)
    });
    let factor = cholesky(&sum)?;
    // L^T x of the four parts of each shape; their squares add up to 1
    let mut left: Vec<Vec<f64>> = Vec::new();
    for mode in modes.filter(|mode| libm::hypot(mode.value[0], mode.value[1]) <= REACH * top) {
        let parts = mode.parts().into_iter().flat_map(|part| {
            let x: Vec<f64> = xz.iter().map(|&place| part[place]).collect();
            let y: Vec<f64> = yz.iter().zip(&turned).map(|(&place, sign)| sign * part[place]).collect();
            [x, y]
        });
        let mut parts: Vec<Vec<f64>> = parts
            .map(|part| {
                let mut product = vec![0.0; half];
                mul_transposed_vec(&factor, &part, &mut product);
                product
            })
            .collect();
        let size = parts.iter().map(|part| dot(part, part)).sum::<f64>().sqrt();
        parts.iter_mut().flatten().for_each(|entry| *entry /= size);
        left.append(&mut parts);
    }
    let basis = orthonormal(left, (WORTH * half as f64) as usize)?;
    let phi = solve_upper(&factor, &basis);
    let count = phi.ncols();
    let mut shapes = Matrix::zeros(2 * half, 2 * count);
    for (order, (&x, &y)) in xz.iter().zip(&yz).enumerate() {
        for column in 0..count {
            shapes[(x, column)] = phi[(order, column)];
            shapes[(y, count + column)] = turned[order] * phi[(order, column)];
        }
    }
    Some(Reduced::new(shapes, matrices))
}

/// Orthonormal columns that span the vectors up to [`LEFT_OUT`], largest remainder first; `None` if more than `most` are needed.
fn orthonormal(mut left: Vec<Vec<f64>>, most: usize) -> Option<Matrix> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    loop {
        let size = |vector: &[f64]| dot(vector, vector).sqrt();
        let (at, largest) = left
            .iter()
            .enumerate()
            .map(|(at, vector)| (at, size(vector)))
            .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
        if largest <= LEFT_OUT {
            break;
        }
        if basis.len() == most {
            return None;
        }
        let mut unit = left.swap_remove(at);
        // second orthogonalisation: after many steps a remainder is no longer orthogonal to the first columns
        for column in &basis {
            axpy(-dot(column, &unit), column, &mut unit);
        }
        let length = size(&unit);
        unit.iter_mut().for_each(|entry| *entry /= length);
        for vector in &mut left {
            axpy(-dot(&unit, vector), &unit, vector);
        }
        basis.push(unit);
    }
    let rows = basis.first()?.len();
    Some(Matrix::from_fn(rows, basis.len(), |i, j| basis[j][i]))
}

/// Returns whether the modes of the reduced basis include each whirl mode of the full model below a speed.
fn has_all(modes: &[Mode], exact: &[Mode], top: f64) -> bool {
    exact.iter().filter(|mode| whirls(mode) && mode.value[1] <= top).all(|mode| {
        let near = |other: &Mode| libm::hypot(other.value[0] - mode.value[0], other.value[1] - mode.value[1]);
        modes.iter().any(|other| whirls(other) && near(other) <= SAME * libm::hypot(mode.value[0], mode.value[1]))
    })
}

/// Largest error (2) of the whirl modes below `top`, at a speed.
fn error(full: &Refinement<'_>, modes: &[Mode], speed: f64, top: f64) -> f64 {
    let matrices = full.at(speed);
    let of = |mode: &Mode| {
        let [re, im] = full.coordinates(mode);
        let [r, w] = mode.value;
        let (s, t) = (r * r - w * w, 2.0 * r * w);
        let products = [&re, &im].map(|part| {
            [0, 1, 2].map(|at| {
                let mut product = vec![0.0; part.len()];
                mul_vec(&matrices[at], part, &mut product);
                product
            })
        });
        let [[mr, cr, kr], [mi, ci, ki]] = &products;
        let square: f64 = (0..re.len())
            .map(|i| {
                let real = s * mr[i] - t * mi[i] + r * cr[i] - w * ci[i] + kr[i];
                let imaginary = s * mi[i] + t * mr[i] + r * ci[i] + w * cr[i] + ki[i];
                real * real + imaginary * imaginary
            })
            .sum();
        (square / (dot(&re, &re) + dot(&im, &im))).sqrt()
    };
    modes.iter().filter(|mode| whirls(mode) && mode.value[1] <= top).map(of).fold(0.0, f64::max)
}
