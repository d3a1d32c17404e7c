//! Additional modes for the forces of bearing tables, in addition to the lowest modes of the shaft.
//!
//! ```text
//! r     = sum over truncated modes  phi (phi^T b)/w^2                 displacement of the truncated modes by a unit force b across a bearing            (1)
//! modes of K x = w^2 M x within the space of all r                      mass-normalised, uncoupled, orthogonal to the modes kept                     (2)
//! ```
//! The lowest modes are those of the shaft on the largest stiffnesses of its tables. At a given speed, the actual stiffness and damping
//! differ from these by forces across the bearings. These forces may be large: a strongly damped bearing almost fixes its node. With the
//! modes (2), the basis includes the static response to such forces. So shafts with bearings of any stiffness and damping converge as fast
//! as with free bearings. Two additional modes per bearing have the effect of twice the number of lowest modes
//! (docs/theory/05-reduction.md, "Bearing tables").
//!
//! Source: attachment modes (Craig, Kurdila, Fundamentals of Structural Dynamics, 2nd ed., chapter 17; Rubin 1975). Limits: only bearings
//! with a table have such modes, so the basis of all other machines is unaffected. Verified by
//! `the_loads_of_strongly_damped_tables_are_those_of_the_full_engine` (`tests/rotor/bearing_tables.rs`).

use crate::rotor::{BearingSite, RotorMatrices};
use bladeoff_numerics::linalg::{EigenError, Matrix, column_of, dot, mul, symmetric_generalised};

/// Smallest norm of the component of a vector (1) orthogonal to the previous ones, relative to the vector's norm.
const INDEPENDENT: f64 = 1e-6;
/// Largest residual of the eigenvalue equation for a mode of the shaft, relative to the largest `w^2 M phi`.
const EIGEN_ERROR: f64 = 1e-6;

/// Returns the modes (2) as omega^2 \[rad2/s2\] and mode shape, ascending. `(values, shapes)`: omega^2 and shapes of all modes of the
/// shaft, of which the first `kept` are retained. `coupled`: the planes XZ and YZ are coupled.
pub(super) fn table_modes(
    rotor: &RotorMatrices,
    (values, shapes): (&[f64], &Matrix),
    kept: usize,
    coupled: bool,
) -> Result<Vec<(f64, Vec<f64>)>, EigenError> {
    let first = kept;
    // a mode without stiffness has no static response
    if values[first..].iter().any(|square| *square <= 0.0) {
        return Ok(Vec::new());
    }
    let truncated = shapes.columns(first, values.len() - first).into_owned();
    let sites = || rotor.tables.iter().map(|(place, _)| &rotor.bearings[*place]);
    let response = |site: &BearingSite, axis: usize| -> Vec<f64> {
        let across = site.rows(|place| truncated.row(place).iter().copied().collect());
        across[axis].iter().zip(&values[first..]).map(|(part, square)| part / square).collect()
    };
    let axes: &[&[usize]] = if coupled { &[&[0, 1]] } else { &[&[0], &[1]] };
    let mut added: Vec<(f64, Vec<f64>)> = Vec::new();
    for axes in axes {
        let responses = sites().flat_map(|site| axes.iter().map(move |axis| (site, *axis)));
        let Some(space) = orthonormal(responses.map(|(site, axis)| response(site, axis))) else { continue };
        let stiffness = Matrix::from_fn(space.ncols(), space.ncols(), |i, j| {
            (0..space.nrows()).map(|k| space[(k, i)] * values[first + k] * space[(k, j)]).sum()
        });
        let unit = Matrix::identity(space.ncols(), space.ncols());
        let (squares, vectors) = symmetric_generalised(&stiffness, &unit, "the modes of bearing tables")?;
        let shapes = mul(&truncated, &mul(&space, &vectors));
        added.extend(squares.into_iter().enumerate().map(|(j, square)| (square, oriented(column_of(&shapes, j)))));
    }
    added.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    Ok(added)
}

/// Returns the number of modes (2) at the end of a set of modes, given by omega^2 and shapes: all from the first that is not a mode of the
/// shaft itself.
pub(crate) fn table_mode_count(rotor: &RotorMatrices, (squares, shapes): (&[f64], &Matrix)) -> usize {
    if rotor.tables.is_empty() {
        return 0;
    }
    let (forces, momenta) = (mul(&rotor.stiffness, shapes), mul(&rotor.mass, shapes));
    let highest = squares.iter().enumerate().map(|(j, square)| square.abs() * momenta.column(j).norm());
    let limit = EIGEN_ERROR * highest.fold(0.0, f64::max);
    let departs = |j: &usize| (forces.column(*j) - momenta.column(*j) * squares[*j]).norm() > limit;
    // a mode (2) that is also a mode of the shaft may follow one that is not
    squares.len() - (0..squares.len()).find(departs).unwrap_or(squares.len())
}

/// Orthonormal columns that span the given columns; `None` without columns.
fn orthonormal(columns: impl Iterator<Item = Vec<f64>>) -> Option<Matrix> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let length = dot(&column, &column).sqrt();
        // twice: the first pass leaves the rounding of its own differences
        for _ in 0..2 {
            for unit in &basis {
                let share = dot(unit, &column);
                column.iter_mut().zip(unit).for_each(|(part, unit)| *part -= share * unit);
            }
        }
        let rest = dot(&column, &column).sqrt();
        if rest > INDEPENDENT * length {
            column.iter_mut().for_each(|part| *part /= rest);
            basis.push(column);
        }
    }
    let rows = basis.first()?.len();
    Some(Matrix::from_vec(rows, basis.len(), basis.concat()))
}

/// Changes the sign of a mode shape so that its first large entry is positive.
fn oriented(shape: &[f64]) -> Vec<f64> {
    let largest = shape.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let leading = shape.iter().find(|entry| entry.abs() >= 0.999 * largest).copied().unwrap_or(1.0);
    shape.iter().map(|entry| if leading < 0.0 { -entry } else { *entry }).collect()
}
