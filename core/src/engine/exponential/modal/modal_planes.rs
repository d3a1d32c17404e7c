//! Modal planes: the real invariant planes of A that a modal basis consists of.
//!
//! An oscillating motion spans a plane with its complex conjugate; of the real (overdamped) motions, two share a plane. In its plane the system is a
//! real 2 x 2 block (`plane_block`). A conjugate pair that becomes critically damped and splits into two real motions therefore stays one
//! plane: its two eigenvectors become parallel, but the plane remains well defined. Real motions are paired so that motions that may merge
//! share a plane: those that are nearly parallel, or those that share a plane in the neighbouring basis.
//!
//! ```text
//! V   = 2n x 2n, columns k and n + k span plane k
//! without a neighbour     the columns of a plane are orthonormal; real and imaginary part of the eigenvector if it oscillates well
//! S_k = [L' V]_kk,  R = V S^-1        with a neighbour of left vectors L': each plane is transformed so that [L' R]_kk = 1            (1)
//! (A - lambda) g = r                  generalised eigenvector: second vector of a plane whose two motions are equal to rounding (critical damping)
//! ```
//! `r`: eigenvector of the double eigenvalue `lambda`. (1) is a parallel transport: between neighbouring bases no plane rotates or grows in itself, and
//! no phase of an eigenvector has to be tracked. Verified by `a_continued_basis_equals_that_of_its_eigenvalue_problem` (`continuation.rs`).

use super::state_space::EigenMotion;
use bladeoff_numerics::linalg::{Matrix, Vector, column_of, dot, mul_vec};

/// Ratio of minor to major axis of an oscillating motion below which its plane gets orthonormal vectors; reached at a damping ratio of 0.98.
const MIN_AXIS_RATIO: f64 = 0.1;
/// Smallest determinant of an S_k for which a plane and that of the neighbour count as the same.
const MIN_PLANE_DETERMINANT: f64 = 0.1;
/// Sine of the angle below which two vectors count as parallel.
const MIN_ANGLE: f64 = 1e-5;

/// Columns V of all modal planes of the system matrix `a`, without a neighbouring basis.
///
/// Real motions are paired by angle, nearly parallel ones first. `None` if the motions do not fill the state space.
pub(crate) fn from_eigenmotions(motions: &[EigenMotion], a: &Matrix) -> Option<Matrix> {
    let (oscillating, real_motions): (Vec<&EigenMotion>, Vec<&EigenMotion>) =
        motions.iter().partition(|m| m.imaginary.is_some());
    let mut planes = oscillating.into_iter().map(|motion| real_plane(motion, a)).collect::<Option<Vec<_>>>()?;
    let mut unpaired: Vec<&[f64]> = real_motions.into_iter().map(|motion| motion.real.as_slice()).collect();
    while unpaired.len() > 1 {
        let mut best = (0, 1, -1.0);
        for i in 0..unpaired.len() {
            for j in i + 1..unpaired.len() {
                let cosine = dot(unpaired[i], unpaired[j]).abs();
                if cosine > best.2 {
                    best = (i, j, cosine);
                }
            }
        }
        let (second, first) = (unpaired.remove(best.1), unpaired.remove(best.0));
        planes.push(orthonormal(first, second, a)?);
    }
    columns(&planes, unpaired.len())
}

/// Columns R of all modal planes in the order and orientation of a neighbouring basis with left vectors `left`, by (1).
///
/// Motions are assigned to the neighbour's planes by the size of their components there, largest first. `None` if a plane of the neighbour is not found.
pub(crate) fn aligned_with_neighbour(motions: &[EigenMotion], a: &Matrix, left: &Matrix) -> Option<Matrix> {
    let plane_count = left.nrows() / 2;
    let rows = left.transpose();
    let component = |state: &[f64], k: usize| {
        let product = |row: usize| dot(column_of(&rows, row), state);
        let (a, b) = (product(k), product(plane_count + k));
        a * a + b * b
    };
    let mut components = Vec::with_capacity(motions.len() * plane_count);
    for (i, motion) in motions.iter().enumerate() {
        for k in 0..plane_count {
            let imaginary = motion.imaginary.as_ref().map_or(0.0, |state| component(state, k));
            components.push((component(&motion.real, k) + imaginary, i, k));
        }
    }
    components.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); plane_count];
    let (mut free_dimensions, mut assigned) = (vec![2; plane_count], vec![false; motions.len()]);
    for (_, i, k) in components {
        let dimensions = if motions[i].imaginary.is_some() { 2 } else { 1 };
        if !assigned[i] && free_dimensions[k] >= dimensions {
            assigned[i] = true;
            free_dimensions[k] -= dimensions;
            members[k].push(i);
        }
    }
    let planes = members.iter().enumerate().map(|(k, members)| {
        let plane = match members.as_slice() {
            [one] => real_plane(&motions[*one], a)?,
            [one, other] => orthonormal(&motions[*one].real, &motions[*other].real, a)?,
            _ => return None,
        };
        let [a, b] = [k, plane_count + k].map(|row| column_of(&rows, row));
        transform_by_inverse(&plane, [dot(a, &plane[0]), dot(a, &plane[1]), dot(b, &plane[0]), dot(b, &plane[1])])
    });
    columns(&planes.collect::<Option<Vec<_>>>()?, 0)
}

/// Plane of an oscillating motion; `None` for a real motion.
fn real_plane(motion: &EigenMotion, a: &Matrix) -> Option<[Vec<f64>; 2]> {
    let imaginary = motion.imaginary.as_ref()?;
    let (aa, ab, bb) = (dot(&motion.real, &motion.real), dot(&motion.real, imaginary), dot(imaginary, imaginary));
    let (mean, half) = (0.5 * (aa + bb), 0.5 * (aa - bb));
    let radius = (half * half + ab * ab).sqrt();
    if mean - radius < MIN_AXIS_RATIO * MIN_AXIS_RATIO * (mean + radius) {
        return orthonormal(&motion.real, imaginary, a);
    }
    // x = Re[r (a + ib)]; the factor makes each vector about 1 long
    let scale = std::f64::consts::SQRT_2;
    Some([
        motion.real.iter().map(|entry| scale * entry).collect(),
        imaginary.iter().map(|entry| -scale * entry).collect(),
    ])
}

/// Orthonormal basis of the plane of two vectors, with a generalised eigenvector if they are parallel.
fn orthonormal(one: &[f64], other: &[f64], a: &Matrix) -> Option<[Vec<f64>; 2]> {
    let (one, other) = if dot(one, one) >= dot(other, other) { (one, other) } else { (other, one) };
    let first = unit(one)?;
    let orthogonal = unit(other).map(|second| orthogonal_part(&second, &first));
    let second = match orthogonal {
        Some(orthogonal) if dot(&orthogonal, &orthogonal) > MIN_ANGLE * MIN_ANGLE => orthogonal,
        _ => orthogonal_part(&unit(&generalised_eigenvector(&first, a)?)?, &first),
    };
    // once more against rounding
    let second = unit(&orthogonal_part(&unit(&second)?, &first))?;
    Some([first, second])
}

/// Generalised eigenvector: the shortest g with `(A - lambda) g = r`, where `lambda = r.A r`.
fn generalised_eigenvector(r: &[f64], a: &Matrix) -> Option<Vec<f64>> {
    let size = r.len();
    let mut a_r = vec![0.0; size];
    mul_vec(a, r, &mut a_r);
    let shifted = a - Matrix::identity(size, size) * dot(r, &a_r);
    let decomposition = shifted.svd(true, true);
    let tolerance = MIN_ANGLE * decomposition.singular_values.max();
    Some(decomposition.solve(&Vector::from_column_slice(r), tolerance).ok()?.as_slice().to_vec())
}

/// Vector of length 1 in the direction of v; `None` for zero.
fn unit(v: &[f64]) -> Option<Vec<f64>> {
    let length = dot(v, v).sqrt();
    (length > 0.0).then(|| v.iter().map(|entry| entry / length).collect())
}

/// Component of v orthogonal to a unit vector.
fn orthogonal_part(v: &[f64], along: &[f64]) -> Vec<f64> {
    let component = dot(along, v);
    v.iter().zip(along).map(|(entry, unit)| entry - component * unit).collect()
}

/// Plane transformed by `S^-1`, by (1), with the entries of S by rows; `None` if the plane is not that of the neighbour.
fn transform_by_inverse(plane: &[Vec<f64>; 2], s: [f64; 4]) -> Option<[Vec<f64>; 2]> {
    let determinant = s[0] * s[3] - s[1] * s[2];
    if determinant.abs() < MIN_PLANE_DETERMINANT {
        return None;
    }
    let combine = |a: f64, b: f64| -> Vec<f64> {
        plane[0].iter().zip(&plane[1]).map(|(x, y)| (a * x + b * y) / determinant).collect()
    };
    Some([combine(s[3], -s[2]), combine(-s[1], s[0])])
}

/// Matrix of the columns of all planes; `None` if they do not fill the state space or motions remain unpaired.
fn columns(planes: &[[Vec<f64>; 2]], unpaired: usize) -> Option<Matrix> {
    let plane_count = planes.len();
    let size = planes.first()?[0].len();
    if unpaired > 0 || 2 * plane_count != size {
        return None;
    }
    Some(Matrix::from_fn(size, size, |i, j| planes[j % plane_count][j / plane_count][i]))
}
