//! The reduced basis: lateral and torsional modes of the rotor, and modes of each flexible ring.
//!
//! The lateral modes solve `K phi = omega^2 M phi` with the symmetric part of the bearing stiffness and without unbalance masses. Damping,
//! skew stiffness, gyroscopic terms and unbalance are projected on the modes or evaluated at the nodes. A pair of modes with equal
//! frequency is never split, and the two modes of a pair have a fixed orientation. So the basis is a function of the structure alone. The
//! basis is computed once and frozen: a later build may compute different last digits.

use super::key::modal_key;
use super::table_modes::table_modes;
use crate::rotor::RotorMatrices;
use crate::stator::RingMatrices;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine, RotorKind};
use bladeoff_numerics::linalg::{EigenError, Matrix, column_of, symmetric_generalised};

/// Modes of one part of the machine: mass-normalised mode shapes in columns, by ascending frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeSet {
    /// Squared circular frequencies omega^2 \[rad2/s2\], ascending.
    pub omega_squared: Vec<f64>,
    /// Mode shapes phi over the finite-element degrees of freedom, one mode per column, `phi^T M phi = 1`.
    pub shapes: Matrix,
    /// Highest circular frequency of the complete finite-element model of the part \[rad/s\], truncated modes included: the stability limit
    /// of its step.
    pub full_limit: f64,
}

impl ModeSet {
    /// Highest retained frequency \[rad/s\].
    #[must_use]
    pub fn highest(&self) -> f64 {
        self.omega_squared.last().map_or(0.0, |&square| square.max(0.0).sqrt())
    }
}

/// Reduced basis of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// Hash of all data that determine the modes.
    pub key: [u8; 32],
    /// Lateral modes. Empty for a point mass, whose two degrees of freedom are used directly.
    pub lateral: ModeSet,
    /// Torsional modes. The first is the rigid rotation.
    pub torsion: ModeSet,
    /// Modes of each flexible ring, in the order of the machine's flexible diaphragms.
    pub rings: Vec<ModeSet>,
}

/// Error in computing or reading a basis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BasisError {
    /// Failure of an eigenvalue problem.
    #[error(transparent)]
    Eigen(#[from] EigenError),
    /// Frozen basis of another structure.
    #[error("the frozen basis belongs to another structure (its key is {found}, this machine's is {expected})")]
    OtherStructure {
        /// Key of the machine.
        expected: String,
        /// Key in the basis.
        found: String,
    },
    /// Malformed bytes of a frozen basis.
    #[error("not a basis file of version {version}: {detail} at byte {offset}")]
    Malformed {
        /// Version of the format that this build reads.
        version: u32,
        /// Description of the fault.
        detail: &'static str,
        /// Byte offset of the fault.
        offset: usize,
    },
}

/// Minimum number of lateral rotor modes, unless the machine file sets the number.
pub const DEFAULT_ROTOR_MODES: usize = 24;
/// Largest share of a bearing's static flexibility in the truncated modes. Above this share, more lateral modes are kept: a truncated mode
/// follows a force quasi-statically, and so does its part of the bearing load. Verified by `stiff_bearings_carry_what_stands_on_them` in
/// `tests/runs/engines.rs`.
const LEFT_OUT_AT_BEARINGS: f64 = 0.02;
/// Limit of the additional lateral modes, so that they do not govern the time step: the highest ring frequency, or without a flexible ring
/// this multiple of the highest default mode.
const WITHOUT_RING: f64 = 8.0;
/// Minimum number of modes of each ring, unless the machine file sets the number.
pub const DEFAULT_RING_MODES: usize = 36;
/// Largest truncation error of a ring under a contact force of 1 ms: the share of the ring's flexibility in truncated modes whose inertia
/// the force feels. Above this share, more ring modes are kept. The run is invalid from 3 % on ([`crate::structure::MAX_TRUNCATION_ERROR`],
/// relative to the flexibility of rotor and ring). Modes of bladed rings are closely spaced: a ring of 40 blades has 81 modes below twice
/// the lowest blade frequency. Verified by `a_ring_of_many_blades_keeps_more_modes` in `tests/rotor/modal_basis.rs`.
const RING_TRUNCATION: f64 = 0.01;
/// Circular frequency W of a contact force whose half period is 1 ms \[1/s\], as in `structure::truncation_error`.
const CONTACT_RATE: f64 = std::f64::consts::PI / 1e-3;
/// Relative difference of omega^2 below which two modes are a pair.
const PAIR: f64 = 1e-7;

/// Minimum default numbers of elastic torsional modes: without and with a rigid ring or a radial spring. Such a stator has no frequencies
/// that raise the number, while its friction torque acts at one node of the shaft. On the test rig with a spring, 3 modes give a thirteenth
/// of the largest torsional moment of `full`; 6 modes give the moment of `full`; the turbine needs 12. Verified by
/// `the_torque_of_a_rub_on_a_spring_reaches_the_shaft`.
const LEAST_TWIST: usize = 3;
const LEAST_TWIST_IN_CONTACT: usize = 16;

impl Basis {
    /// Computes the basis of a machine.
    ///
    /// # Errors
    /// [`BasisError::Eigen`].
    pub fn compute(machine: &Machine, rotor: &RotorMatrices, rings: &[RingMatrices]) -> Result<Self, BasisError> {
        let ring_sets =
            rings.iter().map(|ring| ring_modes(ring, machine.run.ring_modes)).collect::<Result<Vec<_>, _>>()?;
        Self::beside(machine, rotor, ring_sets)
    }

    /// Computes the basis of a machine with given ring modes.
    pub(crate) fn beside(
        machine: &Machine,
        rotor: &RotorMatrices,
        ring_sets: Vec<ModeSet>,
    ) -> Result<Self, BasisError> {
        let run = &machine.run;
        let lateral = match machine.rotor.kind {
            RotorKind::Shaft(_) => {
                let ceiling = ring_sets.iter().map(ModeSet::highest).fold(0.0, f64::max);
                lateral_modes(rotor, run.rotor_modes, ceiling)?
            }
            RotorKind::PointMass(_) => {
                ModeSet { omega_squared: Vec::new(), shapes: Matrix::zeros(rotor.lateral_size(), 0), full_limit: 0.0 }
            }
        };
        // default: every torsional mode that does not govern the step; these modes are cheap and carry the torsional moments
        let ceiling = ring_sets.iter().map(ModeSet::highest).fold(lateral.highest(), f64::max);
        let is_rigid = |diaphragm: &Diaphragm| !matches!(diaphragm.kind, DiaphragmKind::Flexible(_));
        let least = if machine.diaphragms.iter().any(is_rigid) { LEAST_TWIST_IN_CONTACT } else { LEAST_TWIST };
        let torsion = torsional_modes(rotor, run.torsional_modes, (ceiling, least))?;
        Ok(Self { key: modal_key(machine), lateral, torsion, rings: ring_sets })
    }
}

fn lateral_modes(rotor: &RotorMatrices, wanted: Option<usize>, ceiling: f64) -> Result<ModeSet, BasisError> {
    let [xz, yz] = rotor.planes();
    let coupled = xz.iter().any(|&i| yz.iter().any(|&j| rotor.stiffness[(i, j)] != 0.0 || rotor.mass[(i, j)] != 0.0));
    let (values, shapes) = if coupled {
        symmetric_generalised(&rotor.stiffness, &rotor.mass, "the rotor")?
    } else {
        // each plane separately; identical planes get identical modes, digit for digit
        let plane = |dofs: &[usize], slope: f64| {
            // theta_u = -v,z: with the sign of its slopes reversed, the YZ plane has the matrices of the XZ plane
            let flip = |order: usize| if rotor.turn_sign(order) < 0.0 { slope } else { 1.0 };
            let part =
                |a: &Matrix| Matrix::from_fn(dofs.len(), dofs.len(), |i, j| flip(i) * flip(j) * a[(dofs[i], dofs[j])]);
            (part(&rotor.stiffness), part(&rotor.mass))
        };
        let (kx, mx) = plane(&xz, 1.0);
        let (ky, my) = plane(&yz, -1.0);
        let (values_x, shapes_x) = symmetric_generalised(&kx, &mx, "the rotor in the XZ plane")?;
        let same = kx == ky && mx == my;
        let (values_y, shapes_y) = if same {
            (values_x.clone(), shapes_x.clone())
        } else {
            symmetric_generalised(&ky, &my, "the rotor in the YZ plane")?
        };
        merge_planes(rotor, (&xz, &values_x, &shapes_x), (&yz, &values_y, &shapes_y))
    };
    let wanted = wanted.unwrap_or_else(|| {
        let default = DEFAULT_ROTOR_MODES.min(values.len());
        let highest = values[..default].last().map_or(0.0, |&square| square.max(0.0).sqrt());
        let ceiling = if ceiling > 0.0 { ceiling } else { WITHOUT_RING * highest };
        let within = values.iter().filter(|&&square| square <= ceiling * ceiling).count();
        default.max(enough_for_bearings(rotor, &values, &shapes).min(within))
    });
    if rotor.tables.is_empty() {
        return Ok(select(values, shapes, wanted, |_, _| {}));
    }
    let mut modes = select(values.clone(), shapes.clone(), wanted, |_, _| {});
    let added = table_modes(rotor, (&values, &shapes), modes.omega_squared.len(), coupled)?;
    let columns = added.iter().flat_map(|(_, shape)| shape).copied();
    let columns: Vec<f64> = modes.shapes.as_slice().iter().copied().chain(columns).collect();
    modes.omega_squared.extend(added.iter().map(|(square, _)| *square));
    modes.shapes = Matrix::from_vec(modes.shapes.nrows(), modes.omega_squared.len(), columns);
    Ok(modes)
}

/// Returns the number of lowest lateral modes that leave at most [`LEFT_OUT_AT_BEARINGS`] of the static flexibility to the truncated modes,
/// at every bearing without a table and in every direction. Bearings with a table have modes of their own. A mode with negative omega^2
/// (indefinite symmetric part of the bearing stiffness) counts with the magnitude of its omega^2. Verified by
/// `as_many_modes_are_kept_however_bearings_are_turned` in `tests/rotor/invariance.rs`,
/// `stiff_journal_bearings_keep_as_many_modes_as_others` in `tests/rotor/modal_basis.rs`.
fn enough_for_bearings(rotor: &RotorMatrices, values: &[f64], shapes: &Matrix) -> usize {
    let least = f64::EPSILON * values.last().map_or(0.0, |square| square.abs());
    let enough = |[u, v]: [usize; 2]| {
        let part = |j: usize| {
            let (x, y, square) = (shapes[(u, j)], shapes[(v, j)], values[j].abs().max(least));
            [x * x / square, x * y / square, y * y / square]
        };
        let add = |sum: [f64; 3], part: [f64; 3]| [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]];
        let all = (0..values.len()).map(part).fold([0.0; 3], add);
        let mut left_out = [0.0; 3];
        // from the stiffest mode down to the first that must be kept
        let from_above = (0..values.len()).rposition(|j| {
            left_out = add(left_out, part(j));
            largest_share(left_out, all) > LEFT_OUT_AT_BEARINGS
        });
        from_above.map_or(0, |last| last + 1)
    };
    let has_table = |at: usize| rotor.tables.iter().any(|(bearing, _)| *bearing == at);
    let supports = rotor.supports().enumerate().filter(|(at, _)| !has_table(*at));
    supports.map(|(_, site)| enough(site.places)).max().unwrap_or(0)
}

/// Largest ratio `x^T A x / x^T B x` over all directions x of the plane: the larger root s of `det(A - s B) = 0`. `a`, `b`: symmetric 2x2
/// matrices `[xx, xy, yy]`, B positive definite. The ratio does not depend on the orientation of the axes.
pub(crate) fn largest_share(a: [f64; 3], b: [f64; 3]) -> f64 {
    // L^-1 A L^-T with B = L L^T
    let root = b[0].sqrt();
    let below = b[1] / root;
    let corner = (b[2] - below * below).sqrt();
    let xx = a[0] / b[0];
    let xy = (a[1] / root - xx * below) / corner;
    let yy = (a[2] - 2.0 * below * a[1] / root + below * below * xx) / (corner * corner);
    0.5 * (xx + yy) + libm::hypot(0.5 * (xx - yy), xy)
}

fn merge_planes(
    rotor: &RotorMatrices,
    (xz, values_x, shapes_x): (&[usize], &[f64], &Matrix),
    (yz, values_y, shapes_y): (&[usize], &[f64], &Matrix),
) -> (Vec<f64>, Matrix) {
    let size = rotor.lateral_size();
    let mut values = Vec::with_capacity(size);
    let mut shapes = Matrix::zeros(size, size);
    let (mut i, mut j) = (0, 0);
    while values.len() < size {
        let x_first = j == values_y.len() || (i < values_x.len() && values_x[i] <= values_y[j] * (1.0 + PAIR));
        let column = values.len();
        if x_first {
            for (row, &dof) in xz.iter().enumerate() {
                shapes[(dof, column)] = shapes_x[(row, i)];
            }
            values.push(values_x[i]);
            i += 1;
        } else {
            for (row, &dof) in yz.iter().enumerate() {
                shapes[(dof, column)] = rotor.turn_sign(row) * shapes_y[(row, j)];
            }
            values.push(values_y[j]);
            j += 1;
        }
    }
    (values, shapes)
}

/// Returns the torsional modes. `default`: frequency up to which all modes are kept \[rad/s\], and the minimum number of elastic modes.
fn torsional_modes(rotor: &RotorMatrices, wanted: Option<usize>, default: (f64, usize)) -> Result<ModeSet, BasisError> {
    let (ceiling, least) = default;
    let (mut values, mut shapes) =
        symmetric_generalised(&rotor.torsional_stiffness, &rotor.torsional_mass, "torsion of the rotor")?;
    // the rigid rotation is exact
    let inertia: f64 = rotor.torsional_mass.sum();
    values[0] = 0.0;
    shapes.column_mut(0).fill(1.0 / inertia.sqrt());
    let wanted = 1 + wanted.unwrap_or_else(|| {
        let below = values[1..].iter().filter(|&&square| square <= ceiling * ceiling).count();
        below.max(least)
    });
    Ok(select(values, shapes, wanted, |_, _| {}))
}

fn ring_modes(ring: &RingMatrices, wanted: Option<usize>) -> Result<ModeSet, BasisError> {
    let (mut values, shapes) = ring.modes()?;
    let highest = values.last().copied().unwrap_or(0.0);
    for value in &mut values {
        if value.abs() < 1e-10 * highest {
            *value = 0.0;
        }
    }
    let wanted = wanted.unwrap_or_else(|| enough_for_contact(ring.nodes, &values, &shapes));
    Ok(select(values, shapes, wanted, orient_pair))
}

/// Returns the number of lowest ring modes whose truncation error under a radial force of 1 ms is at most [`RING_TRUNCATION`] at every ring
/// node:
///
/// ```text
/// sum over the truncated modes of phi^2/w^2 W^2/(w^2 + W^2)  <=  RING_TRUNCATION  sum over all modes of phi^2/w^2
/// ```
/// phi: radial displacement of a mode at the node; w: its circular frequency; W: [`CONTACT_RATE`]. The number is at least
/// [`DEFAULT_RING_MODES`], and equal to it for a ring with a rigid-body or negative mode.
fn enough_for_contact(nodes: usize, values: &[f64], shapes: &Matrix) -> usize {
    if values.iter().any(|&square| square <= 0.0) {
        return DEFAULT_RING_MODES;
    }
    let wanted = |node: usize| {
        let row = shapes.row(4 * node + 2);
        let flexibility = || row.iter().zip(values).map(|(phi, square)| (phi * phi / square, square));
        let allowed = RING_TRUNCATION * flexibility().map(|(part, _)| part).sum::<f64>();
        let error = flexibility()
            .map(|(part, square)| part * CONTACT_RATE * CONTACT_RATE / (square + CONTACT_RATE * CONTACT_RATE));
        let errors: Vec<f64> = error.collect();
        let mut truncated = 0.0;
        let fits = errors.iter().rev().take_while(|&&error| {
            truncated += error;
            truncated <= allowed
        });
        values.len() - fits.count()
    };
    (0..nodes).map(wanted).fold(DEFAULT_RING_MODES, usize::max)
}

/// Selects the lowest modes without splitting a pair, fixes the signs of the shapes, and orients each pair through `orient`.
fn select(values: Vec<f64>, mut shapes: Matrix, wanted: usize, orient: impl Fn(&mut Matrix, usize)) -> ModeSet {
    let is_pair = |i: usize| {
        i + 1 < values.len() && (values[i + 1] - values[i]).abs() <= PAIR * values[i + 1].abs().max(f64::MIN_POSITIVE)
    };
    let mut kept = wanted.min(values.len());
    while kept > 0 && kept < values.len() && is_pair(kept - 1) {
        kept += 1;
    }
    let mut i = 0;
    while i < kept {
        if is_pair(i) && !is_pair(i + 1) {
            orient(&mut shapes, i);
            i += 1;
        }
        i += 1;
    }
    for j in 0..kept {
        let column = column_of(&shapes, j);
        let largest = column.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
        let leading = column.iter().find(|value| value.abs() >= 0.999 * largest).copied().unwrap_or(1.0);
        if leading < 0.0 {
            shapes.column_mut(j).neg_mut();
        }
    }
    let full_limit = values.last().map_or(0.0, |&square| square.max(0.0).sqrt());
    ModeSet { omega_squared: values[..kept].to_vec(), shapes: shapes.columns(0, kept).into_owned(), full_limit }
}

/// Rotates a pair of ring modes in its plane so that the second mode has no radial displacement at alpha = 0. If neither mode has a radial
/// displacement there, the tangential displacement is used.
fn orient_pair(shapes: &mut Matrix, first: usize) {
    let scale = shapes.columns(first, 2).amax();
    let row = if libm::hypot(shapes[(2, first)], shapes[(2, first + 1)]) > 1e-6 * scale { 2 } else { 0 };
    let (a, b) = (shapes[(row, first)], shapes[(row, first + 1)]);
    let length = (a * a + b * b).sqrt();
    if length <= 1e-9 * scale {
        return;
    }
    let (c, s) = (a / length, b / length);
    for i in 0..shapes.nrows() {
        let (x, y) = (shapes[(i, first)], shapes[(i, first + 1)]);
        shapes[(i, first)] = c * x + s * y;
        shapes[(i, first + 1)] = c * y - s * x;
    }
}
