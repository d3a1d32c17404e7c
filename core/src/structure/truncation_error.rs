//! Error of a contact by truncated modes: how much of the flexibility at the contact a modal basis represents wrongly.
//!
//! The truncated modes follow a contact force at once (static residual). That holds for modes far above the frequencies that an impact
//! excites. A truncated mode below them is too soft at first and too stiff later, which changes the impact.
//! ```text
//! F(0) = K^-1,   F(W) = (K + W^2 M)^-1        flexibility at rest, and for a force that grows as e^{W t};  W = pi/1 ms
//! error = [F(0) - F_kept(0)] - [F(W) - F_kept(W)]  =  sum over the truncated modes of      phi^2/w^2  W^2/(w^2 + W^2)        (1)
//! error =  F(0) - F_kept(0)                        =  sum over the truncated modes of      phi^2/w^2                        (2)
//! share = (error of the rotor + error of the ring)/(F(W) of the rotor + F(0) of the stator)                                 (3)
//! ```
//! (2) without a static residual: truncated modes do not yield at all. `run.static_residual = "off"` asks for that, and a part with a mode that is not
//! stiff (w^2 <= 0: a free ring, bearings whose symmetric part is indefinite) has none. Share (3) is that in the plane where it is largest, whichever
//! way the axes lie, at the contact's node, and at the ring node where it is largest. 1 ms is the filter of the contact force; half a sine over it turns with W.
//!
//! Neither needs the truncated modes, whose number is that of the model. All modes kept are raised to the highest of them, `K' = K + sum (w_h^2 - w^2) M phi
//! phi^T M`, which leaves the others as they are: `K'^-1 - sum phi phi^T/w_h^2` is no difference of large numbers however soft a bearing is, and
//! there is one for every sign of w^2. Of modes with w^2 <= 0 the denominator takes |w^2|, which bounds it from below (nothing of a free ring at rest: F(W)).
//! Where K' is not positive definite, modes that are left out are not stiff themselves: the share is 1.
//!
//! Measured, error of `max_filtered_contact_force_N` against 36 rotor modes (lab rig to 0.2 s; turbine with a gap of 5 mm to 0.13 s):
//!
//! | rotor modes | lab rig: share, error | turbine: share, error |
//! |---|---|---|
//! | 4 | 42 %, 295 % | 12 %, 33 % |
//! | 8 | 7.4 %, 186 % | 5.4 %, 5.4 % |
//! | 12 | 1.4 %, 1.6 % | 1.8 %, 0.02 % |
//! | 16 | 0.24 %, 0.9 % | 0.36 %, 0.1 % |
//! | 24 (default) | 0.005 %, 0.2 % | 0.29 %, 0.1 % |
//!
//! Between 1.8 and 5.4 % lies [`MAX_TRUNCATION_ERROR`]. Limits: of ring modes (3) is a bound and no estimate, see `docs/theory/05-reduction.md`.
//! Verified by `tests/rotor/modal_basis.rs`.

use super::part::Part;
use crate::modal::{ModeSet, largest_share};
use crate::stator::Sectors;
use bladeoff_model::machine::DiaphragmKind;
use bladeoff_numerics::linalg::{Matrix, dot, mul, spd_inverse};

/// Largest share (3) of a valid run with contact; above it the run is invalid (`modal_basis`).
pub const MAX_TRUNCATION_ERROR: f64 = 0.03;
/// W \[1/s\].
const RATE: f64 = std::f64::consts::PI / 1e-3;
/// Part of the largest static flexibility left out, of nodes in the plane, by which a plain difference may be off by rounding.
const ROUNDED: f64 = 1e-3;

/// Flexibility of a node in the plane, `[xx, xy, yy]`, or of one freedom, the same in each direction \[m/N\].
pub(super) type Plane = [f64; 3];

/// Truncation error and flexibilities of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TruncationError {
    /// (1) or (2).
    error: Plane,
    /// Flexibility of the truncated modes at rest.
    truncated_at_rest: Plane,
    /// F(0).
    at_rest: Plane,
    /// F(W).
    moving: Plane,
}

/// Matrices of a linear part before modal reduction.
#[derive(Debug, Clone, Copy)]
pub(super) struct FullPart<'a> {
    pub stiffness: &'a Matrix,
    pub mass: &'a Matrix,
    /// Cyclic symmetry of a ring.
    pub sectors: Option<&'a Sectors>,
    /// Number of modes at the end of the basis that are no modes of the part itself (`modal/table_modes.rs`).
    pub added: usize,
}

impl FullPart<'_> {
    fn inverse(&self, a: &Matrix) -> Option<Matrix> {
        self.sectors.map_or_else(|| spd_inverse(a), |sectors| sectors.inverse(a))
    }
}

/// Flexibility of the truncated modes, at rest and for a force that grows with W, on all degrees of freedom.
pub(super) struct TruncatedFlexibility {
    at_rest: Matrix,
    /// That of the raised modes and those left out, for a force that grows with W, and what of it a mode kept has.
    moving: Matrix,
    kept: f64,
    /// Number of the modes kept that are modes of the part; the others are left out of `moving` with their own flexibility.
    own: usize,
}

impl TruncatedFlexibility {
    /// `None` where a mode that is left out is not stiff.
    fn new(whole: &FullPart<'_>, modes: &ModeSet) -> Option<Self> {
        let &FullPart { stiffness, mass, added, .. } = whole;
        let own = modes.omega_squared.len() - added;
        let (shapes, squares) = (modes.shapes.columns(0, own).into_owned(), &modes.omega_squared[..own]);
        let highest = squares.last().copied().filter(|&square| square > 0.0).unwrap_or(RATE * RATE);
        let momenta = mul(mass, &shapes);
        let raised = stiffness + mul(&momenta, &scaled(&momenta, squares, |square| highest - square));
        let kept = mul(&shapes, &scaled(&shapes, squares, |_| 1.0 / highest));
        let mut at_rest = whole.inverse(&raised)? - kept;
        let mut moving = whole.inverse(&(raised + mass * (RATE * RATE)))?;
        if added > 0 {
            let (shapes, squares) = (modes.shapes.columns(own, added).into_owned(), &modes.omega_squared[own..]);
            at_rest -= mul(&shapes, &scaled(&shapes, squares, |square| 1.0 / square));
            moving -= mul(&shapes, &scaled(&shapes, squares, |square| 1.0 / (square + RATE * RATE)));
        }
        Some(Self { at_rest, moving, kept: 1.0 / (highest + RATE * RATE), own })
    }

    /// Static residual `K^-1 - Phi omega^-2 Phi^T` of the first `size` degrees of freedom under forces on all of them; `None` where a mode kept is not
    /// stiff. `places`: of nodes.
    ///
    /// The plain difference, unless that is rounding: of a rotor on bearings of 0.01 N/m nothing of it is left.
    /// Source: residual flexibility (MacNeal 1971; Rubin 1975), quasi-static: the truncated modes follow a force at once. Used by
    /// the contact and bearing loads. Verified by `the_residual_completes_the_static_flexibility` in `tests/runs/engines.rs`,
    /// `a_rotor_on_hardly_any_bearings_has_the_contact_of_the_full_engine` in `tests/rotor/modal_basis.rs`.
    fn residual(&self, whole: &FullPart<'_>, modes: &ModeSet, size: usize, places: &[[usize; 2]]) -> Option<Matrix> {
        if !stiff(modes) {
            return None;
        }
        let rows = |whole: &Matrix| whole.view((0, 0), (size, whole.ncols())).into_owned();
        let complement = rows(&self.at_rest);
        let kept = mul(&modes.shapes, &scaled(&modes.shapes, &modes.omega_squared, |square| 1.0 / square));
        let difference = whole.inverse(whole.stiffness).map(|all| rows(&(all - kept)));
        let largest = |of: &dyn Fn(usize) -> f64| places.iter().flatten().map(|&i| of(i).abs()).fold(0.0, f64::max);
        let sound = |difference: &Matrix| {
            let off = largest(&|i| difference[(i, i)] - complement[(i, i)]);
            off <= ROUNDED * largest(&|i| complement[(i, i)])
        };
        Some(difference.filter(sound).unwrap_or(complement))
    }
}

/// Phi^T, each row times what its mode's omega^2 says.
fn scaled(shapes: &Matrix, squares: &[f64], factor: impl Fn(f64) -> f64) -> Matrix {
    let mut rows = shapes.transpose();
    for (j, &square) in squares.iter().enumerate() {
        rows.row_mut(j).scale_mut(factor(square));
    }
    rows
}

/// Whether every mode kept has a frequency.
fn stiff(modes: &ModeSet) -> bool {
    modes.omega_squared.iter().all(|&square| square > 0.0)
}

/// Static residual of a part on its first `size` degrees of freedom by forces on all, where it is asked for and there is one, and the lags of nodes, each with its
/// two degrees of freedom in the plane (twice the same where it has one); empty for a full model. A part whose modes are all kept has no residual, but its
/// flexibility belongs to the share (3).
pub(super) fn truncated_flexibility(
    part: &Part,
    modes: &ModeSet,
    whole: FullPart<'_>,
    correct: bool,
    size: usize,
    places: impl Iterator<Item = [usize; 2]>,
) -> (Option<Matrix>, Vec<TruncationError>) {
    if !part.coordinates.is_modal() {
        return (None, Vec::new());
    }
    let are_all_kept = modes.omega_squared.len() == whole.stiffness.nrows();
    let left_out = TruncatedFlexibility::new(&whole, modes);
    if are_all_kept && left_out.is_none() {
        return (None, Vec::new());
    }
    let places: Vec<[usize; 2]> = places.collect();
    let correct = correct && !are_all_kept;
    let residual = left_out.as_ref().filter(|_| correct).and_then(|some| some.residual(&whole, modes, size, &places));
    let follows = residual.is_some();
    let mut lags: Vec<TruncationError> =
        places.into_iter().map(|places| TruncationError::of(places, part, modes, left_out.as_ref(), follows)).collect();
    if are_all_kept {
        // what is found is rounding
        lags.iter_mut().for_each(|lag| (lag.error, lag.truncated_at_rest) = ([0.0; 3], [0.0; 3]));
    }
    (residual, lags)
}

impl TruncationError {
    /// Without `left_out` nothing is known of it: it counts as all there is.
    fn of(
        [u, v]: [usize; 2],
        part: &Part,
        modes: &ModeSet,
        left_out: Option<&TruncatedFlexibility>,
        follows: bool,
    ) -> Self {
        let single = u == v;
        let plane = |xx: f64, xy: f64, yy: f64| if single { [xx, 0.0, xx] } else { [xx, xy, yy] };
        let (x, y) = (part.coordinates.row(u), part.coordinates.row(v));
        let least = f64::EPSILON * modes.highest() * modes.highest();
        let kept = |more: f64| {
            let product = |a: &[f64], b: &[f64]| -> f64 {
                let modes = a.iter().zip(b).zip(&modes.omega_squared);
                modes.map(|((a, b), square)| a * b / (square.abs().max(least) + more)).sum()
            };
            plane(product(&x, &x), product(&x, &y), product(&y, &y))
        };
        let of = |matrix: &Matrix| plane(matrix[(u, u)], matrix[(u, v)], matrix[(v, v)]);
        let own = left_out.map_or(0, |some| some.own);
        let (x, y) = (&x[..own], &y[..own]);
        let raised = plane(dot(x, x), dot(x, y), dot(y, y));
        let unknown = [f64::INFINITY, 0.0, f64::INFINITY];
        let (still, growing) = left_out.map_or((unknown, [0.0; 3]), |some| {
            let moving = of(&some.moving);
            (of(&some.at_rest), std::array::from_fn(|i| moving[i] - some.kept * raised[i]))
        });
        let lag = if follows { std::array::from_fn(|i| still[i] - growing[i]) } else { still };
        let moving = sum(kept(RATE * RATE), growing);
        // a free ring yields without bounds
        let at_rest = if single && !stiff(modes) { moving } else { sum(kept(0.0), still) };
        Self { error: lag, truncated_at_rest: still, at_rest, moving }
    }

    /// Part of its static flexibility that is in the truncated modes, in the plane where it is largest, 0 to 1.
    pub fn share_at_rest(&self) -> f64 {
        share(self.truncated_at_rest, self.at_rest)
    }

    /// Part that the truncated modes have of their own static flexibility and that of a damper, 1/(c W), one behind the other, 0 to 1. `damping` \[N s/m\].
    pub fn share_behind(&self, damping: f64) -> f64 {
        let damper = 1.0 / (damping * RATE);
        if damper.is_finite() {
            share(self.truncated_at_rest, sum(self.truncated_at_rest, [damper, 0.0, damper]))
        } else {
            0.0
        }
    }

    /// Part of its static flexibility that is in so much of it, in the plane where it is largest, 0 to 1.
    pub fn share_of(&self, part: Plane) -> f64 {
        share(part, self.at_rest)
    }
}

fn sum(a: Plane, b: Plane) -> Plane {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Largest share of one flexibility in another, 0 to 1; 1 where there is no number for it.
pub(super) fn share(part: Plane, whole: Plane) -> f64 {
    if part == [0.0; 3] {
        return 0.0;
    }
    let share = largest_share(part, whole);
    if share < 1.0 { share.max(0.0) } else { 1.0 }
}

/// Share (3) of the contact of a rotor's node with a stator, 0 to 1. Empty, or `None`: no mode is left out.
pub(super) fn at_contact(rotor: Option<&TruncationError>, ring: &[TruncationError], kind: &DiaphragmKind) -> f64 {
    let none = TruncationError { error: [0.0; 3], truncated_at_rest: [0.0; 3], at_rest: [0.0; 3], moving: [0.0; 3] };
    let rotor = rotor.unwrap_or(&none);
    let yielding = match kind {
        DiaphragmKind::RadialSpring { stiffness } => 1.0 / stiffness,
        DiaphragmKind::Rigid | DiaphragmKind::Flexible(_) => 0.0,
    };
    let alone = [TruncationError { at_rest: [yielding, 0.0, yielding], ..none }];
    let stator = if ring.is_empty() { &alone } else { ring };
    let shares = stator.iter().map(|at| share(sum(rotor.error, at.error), sum(rotor.moving, at.at_rest)));
    shares.fold(0.0, f64::max)
}
