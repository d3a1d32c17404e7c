//! Truncation error of a contact: the share of the flexibility at the contact that a modal basis represents wrongly.
//!
//! Truncated modes follow a contact force at once (static residual). This is accurate for modes far above the frequencies that an impact excites. A
//! truncated mode below them is too soft at first and too stiff later, which changes the impact.
//! ```text
//! F(0) = K^-1,   F(W) = (K + W^2 M)^-1        flexibility at rest, and for a force that grows as e^{W t};  W = pi/1 ms
//! error = [F(0) - F_kept(0)] - [F(W) - F_kept(W)]  =  sum over the truncated modes of      phi^2/w^2  W^2/(w^2 + W^2)        (1)
//! error =  F(0) - F_kept(0)                        =  sum over the truncated modes of      phi^2/w^2                        (2)
//! share = (error of the rotor + error of the ring)/(F(W) of the rotor + F(0) of the stator)                                 (3)
//! ```
//! (2) applies without a static residual, when truncated modes do not yield at all: for `run.static_residual = "off"`, and for a part with a mode
//! that is not stiff (w^2 <= 0: a free ring, or bearings whose symmetric stiffness is indefinite). Share (3) is taken at the contact's node and at
//! the ring node where it is largest, in the direction in the plane where it is largest. 1 ms is the filter of the contact force; a half sine over
//! 1 ms has the angular frequency W.
//!
//! Impacts on a flexible ring may be shorter than 1 ms. Once their mean length is known, `super::short_impacts` judges them.
//!
//! Neither (1) nor (2) needs the truncated modes themselves, whose number is about that of the model's degrees of freedom. All kept modes are raised
//! to the highest kept frequency, `K' = K + sum (w_h^2 - w^2) M phi phi^T M`, which leaves the truncated modes unchanged.
//! `K'^-1 - sum phi phi^T/w_h^2` is then not a difference of large numbers, however soft a bearing is, and it exists for either sign of w^2. For
//! modes with w^2 <= 0 the denominator of (3) takes |w^2|, a lower bound (for a free ring at rest it takes F(W)). If K' is not positive definite, a
//! truncated mode is not stiff, and the share is 1.
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
//! [`MAX_TRUNCATION_ERROR`] lies between 1.8 and 5.4 %. Limits: for ring modes (3) is a bound and not an estimate, see `docs/theory/05-reduction.md`.
//! Verified by `tests/rotor/modal_basis.rs`.

use super::part::Part;
use crate::modal::{ModeSet, largest_share};
use crate::stator::Sectors;
use bladeoff_model::machine::DiaphragmKind;
use bladeoff_numerics::linalg::{Matrix, dot, mul, spd_inverse};

/// Largest share (3) of a valid run with contact; a larger one makes the run invalid (`modal_basis`).
pub const MAX_TRUNCATION_ERROR: f64 = 0.03;
/// Growth rate W of the reference force \[1/s\].
pub(super) const RATE: f64 = std::f64::consts::PI / 1e-3;
/// Largest rounding error of the plain difference, as a share of the largest static flexibility of the truncated modes at nodes in the plane.
const ROUNDED: f64 = 1e-3;

/// Flexibility of a node in the plane, `[xx, xy, yy]`; for a single degree of freedom it is the same in each direction \[m/N\].
pub(super) type Plane = [f64; 3];

/// Truncation error and flexibilities of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TruncationError {
    /// Flexibility error (1) or (2) \[m/N\].
    error: Plane,
    /// Flexibility of the truncated modes at rest \[m/N\].
    truncated_at_rest: Plane,
    /// Flexibility F(0) at rest \[m/N\].
    at_rest: Plane,
    /// Flexibility F(W) for the growing force \[m/N\].
    moving: Plane,
}

/// Matrices of a linear part before modal reduction.
#[derive(Debug, Clone, Copy)]
pub(super) struct FullPart<'a> {
    /// Stiffness matrix K.
    pub stiffness: &'a Matrix,
    /// Mass matrix M.
    pub mass: &'a Matrix,
    /// Cyclic symmetry of a ring.
    pub sectors: Option<&'a Sectors>,
    /// Number of attachment modes at the end of the basis, which are not modes of the part itself (`modal/table_modes.rs`).
    pub added: usize,
}

impl FullPart<'_> {
    fn inverse(&self, a: &Matrix) -> Option<Matrix> {
        self.sectors.map_or_else(|| spd_inverse(a), |sectors| sectors.inverse(a))
    }
}

/// Flexibility of the truncated modes on all degrees of freedom, at rest and for a force that grows with W \[m/N\].
pub(super) struct TruncatedFlexibility {
    /// Flexibility of the truncated modes at rest.
    at_rest: Matrix,
    growing: Growing,
}

/// Flexibility of the truncated modes on all degrees of freedom for a force that grows with W \[m/N\].
struct Growing {
    /// Flexibility of the raised and the truncated modes.
    all: Matrix,
    /// Contribution of a mass-normalised raised mode to it.
    raised: f64,
    /// Number of kept modes that are modes of the part. The attachment modes are not in `all`; their own flexibility is subtracted.
    own: usize,
}

/// Stiffness matrix with all modes of the part raised to the highest kept frequency, and the square of this frequency.
fn raised(whole: &FullPart<'_>, modes: &ModeSet) -> (Matrix, f64) {
    let own = modes.omega_squared.len() - whole.added;
    let (shapes, squares) = (modes.shapes.columns(0, own).into_owned(), &modes.omega_squared[..own]);
    let highest = squares.last().copied().filter(|&square| square > 0.0).unwrap_or(RATE * RATE);
    let momenta = mul(whole.mass, &shapes);
    (whole.stiffness + mul(&momenta, &scaled(&momenta, squares, |square| highest - square)), highest)
}

impl Growing {
    /// `None` if a truncated mode is not stiff. `rate`: W \[1/s\].
    fn new(whole: &FullPart<'_>, modes: &ModeSet, (raised, highest): (&Matrix, f64), rate: f64) -> Option<Self> {
        let own = modes.omega_squared.len() - whole.added;
        let mut all = whole.inverse(&(raised + whole.mass * (rate * rate)))?;
        if whole.added > 0 {
            let (shapes, squares) = (modes.shapes.columns(own, whole.added).into_owned(), &modes.omega_squared[own..]);
            all -= mul(&shapes, &scaled(&shapes, squares, |square| 1.0 / (square + rate * rate)));
        }
        Some(Self { all, raised: 1.0 / (highest + rate * rate), own })
    }
}

impl TruncatedFlexibility {
    /// `None` if a truncated mode is not stiff.
    fn new(whole: &FullPart<'_>, modes: &ModeSet) -> Option<Self> {
        let own = modes.omega_squared.len() - whole.added;
        let (raised, highest) = raised(whole, modes);
        let kept = |first: usize, count: usize, square: &dyn Fn(f64) -> f64| {
            let shapes = modes.shapes.columns(first, count).into_owned();
            mul(&shapes, &scaled(&shapes, &modes.omega_squared[first..first + count], |omega| 1.0 / square(omega)))
        };
        let mut at_rest = whole.inverse(&raised)? - kept(0, own, &|_| highest);
        let growing = Growing::new(whole, modes, (&raised, highest), RATE)?;
        if whole.added > 0 {
            at_rest -= kept(own, whole.added, &|omega| omega);
        }
        Some(Self { at_rest, growing })
    }

    /// Static residual `K^-1 - Phi omega^-2 Phi^T` of the first `size` degrees of freedom under forces on all of them; `None` if a kept mode is not
    /// stiff. `places`: degrees of freedom of the nodes.
    ///
    /// The residual is the plain difference, unless rounding dominates it: on bearings of 0.01 N/m no digit of the difference is significant.
    /// Source: residual flexibility (MacNeal 1971; Rubin 1975), quasi-static: truncated modes follow a force at once. Used by the contact and the
    /// bearing loads. Verified by `the_residual_completes_the_static_flexibility` in `tests/runs/engines.rs`,
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

/// Phi^T, each row multiplied by a function of its mode's omega^2.
fn scaled(shapes: &Matrix, squares: &[f64], factor: impl Fn(f64) -> f64) -> Matrix {
    let mut rows = shapes.transpose();
    for (j, &square) in squares.iter().enumerate() {
        rows.row_mut(j).scale_mut(factor(square));
    }
    rows
}

/// Whether every kept mode is stiff (omega^2 > 0).
fn stiff(modes: &ModeSet) -> bool {
    modes.omega_squared.iter().all(|&square| square > 0.0)
}

/// Static residual of a part and truncation errors of its nodes.
///
/// The residual covers the first `size` degrees of freedom under forces on all of them, if it is requested and exists. `places` has, for each node,
/// its two degrees of freedom in the plane (the same one twice for a single degree of freedom). Both results are empty for a full model. A part with
/// all its modes has no residual, but its flexibility enters the share (3).
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
    let of = |places| {
        let unknown = [f64::INFINITY, 0.0, f64::INFINITY];
        let still = left_out.as_ref().map_or(unknown, |some| plane(&some.at_rest, places));
        TruncationError::of(places, part, modes, still, left_out.as_ref().map(|some| &some.growing), follows, RATE)
    };
    let mut lags: Vec<TruncationError> = places.into_iter().map(of).collect();
    if are_all_kept {
        // with all modes kept, the computed difference is rounding
        lags.iter_mut().for_each(|lag| (lag.error, lag.truncated_at_rest) = ([0.0; 3], [0.0; 3]));
    }
    (residual, lags)
}

/// Truncation errors of nodes of a part, for a force that grows with `rate` \[1/s\] instead of pi/1 ms. `nodes`: degrees of freedom and present
/// truncation errors. `follows`: the part has a static residual; without one, the errors are 0.
pub(super) fn errors_at(
    rate: f64,
    part: &Part,
    modes: &ModeSet,
    whole: FullPart<'_>,
    follows: bool,
    nodes: impl Iterator<Item = ([usize; 2], TruncationError)>,
) -> Vec<TruncationError> {
    let (raised, highest) = raised(&whole, modes);
    let growing = Growing::new(&whole, modes, (&raised, highest), rate);
    let of = |(places, now): ([usize; 2], TruncationError)| {
        let still = now.truncated_at_rest;
        let all = TruncationError::of(places, part, modes, still, growing.as_ref(), follows, rate);
        let error = if follows { all.error } else { [0.0; 3] };
        TruncationError { error, ..all }
    };
    nodes.map(of).collect()
}

/// Flexibilities of a node, in a matrix over all degrees of freedom.
fn plane(matrix: &Matrix, [u, v]: [usize; 2]) -> Plane {
    if u == v { [matrix[(u, u)], 0.0, matrix[(u, u)]] } else { [matrix[(u, u)], matrix[(u, v)], matrix[(v, v)]] }
}

impl TruncationError {
    /// Truncation error of a part that is not modal.
    pub const NONE: Self = Self { error: [0.0; 3], truncated_at_rest: [0.0; 3], at_rest: [0.0; 3], moving: [0.0; 3] };

    /// Truncation error of one node. `still`: flexibility of the truncated modes at rest; infinite where it is unknown, and the share is then 1.
    fn of(
        [u, v]: [usize; 2],
        part: &Part,
        modes: &ModeSet,
        still: Plane,
        growing: Option<&Growing>,
        follows: bool,
        rate: f64,
    ) -> Self {
        let single = u == v;
        let plane_of = |xx: f64, xy: f64, yy: f64| if single { [xx, 0.0, xx] } else { [xx, xy, yy] };
        let (x, y) = (part.coordinates.row(u), part.coordinates.row(v));
        let least = f64::EPSILON * modes.highest() * modes.highest();
        let kept = |more: f64| {
            let product = |a: &[f64], b: &[f64]| -> f64 {
                let modes = a.iter().zip(b).zip(&modes.omega_squared);
                modes.map(|((a, b), square)| a * b / (square.abs().max(least) + more)).sum()
            };
            plane_of(product(&x, &x), product(&x, &y), product(&y, &y))
        };
        let growing = growing.map_or([0.0; 3], |some| {
            let (x, y) = (&x[..some.own], &y[..some.own]);
            let raised = plane_of(dot(x, x), dot(x, y), dot(y, y));
            let moving = plane(&some.all, [u, v]);
            std::array::from_fn(|i| moving[i] - some.raised * raised[i])
        });
        let lag = if follows { std::array::from_fn(|i| still[i] - growing[i]) } else { still };
        let moving = sum(kept(rate * rate), growing);
        // the static flexibility of a free ring is unbounded
        let at_rest = if single && !stiff(modes) { moving } else { sum(kept(0.0), still) };
        Self { error: lag, truncated_at_rest: still, at_rest, moving }
    }

    /// Share of the static flexibility that is in the truncated modes, in the direction where it is largest, 0 to 1.
    pub fn share_at_rest(&self) -> f64 {
        share(self.truncated_at_rest, self.at_rest)
    }

    /// Share of the truncated modes in the static flexibility of truncated modes and damper in series, 0 to 1. The damper's flexibility is 1/(c W),
    /// `damping` is c \[N s/m\].
    pub fn share_behind(&self, damping: f64) -> f64 {
        let damper = 1.0 / (damping * RATE);
        if damper.is_finite() {
            share(self.truncated_at_rest, sum(self.truncated_at_rest, [damper, 0.0, damper]))
        } else {
            0.0
        }
    }

    /// Share of the errors of shaft and ring in the flexibility of both for the growing force, 0 to 1.
    pub fn share_of_both(shaft: &Self, ring: &Self) -> f64 {
        share(sum(shaft.error, ring.error), sum(shaft.moving, ring.moving))
    }

    /// Share of the flexibility `part` in the static flexibility, in the direction where it is largest, 0 to 1.
    pub fn share_of(&self, part: Plane) -> f64 {
        share(part, self.at_rest)
    }
}

fn sum(a: Plane, b: Plane) -> Plane {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Largest share of one flexibility in another over all directions, 0 to 1; 1 if the share is undefined.
pub(super) fn share(part: Plane, whole: Plane) -> f64 {
    if part == [0.0; 3] {
        return 0.0;
    }
    let share = largest_share(part, whole);
    if share < 1.0 { share.max(0.0) } else { 1.0 }
}

/// Share (3) of the contact between a node of the rotor and a stator, 0 to 1. `None`, or an empty list: no mode is truncated.
pub(super) fn at_contact(rotor: Option<&TruncationError>, ring: &[TruncationError], kind: &DiaphragmKind) -> f64 {
    let none = TruncationError::NONE;
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
