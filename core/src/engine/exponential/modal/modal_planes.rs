//! Pairs of motions: real planes of the state space, each of which goes on in itself.
//!
//! A motion that oscillates spans a plane with its conjugate; of those that do not, two share one. In a plane the system is a real
//! 2 x 2 block (`block`), so that a pair that merges, and parts again as two real motions, stays one plane: its eigenvectors become one
//! there, the plane does not. What would merge is paired: motions that are nearly parallel, or those whose planes a neighbouring speed has as one.
//! ```text
//! V   two columns for each pair k, at k and n + k;        alone   the two of a pair orthonormal (a plane of its own norm where it oscillates well)
//! S_k = [L' V]_kk,  R = V S^-1                            beside a neighbour with left vectors L': each plane turned so that [L' R]_kk = 1      (1)
//! ```
//! Where two of a pair are one motion to rounding (critical damping), the plane has the vector `g` of `(A - lambda) g = r` besides it.
//! (1) is parallel transport: between neighbours no plane turns or grows in itself, and no phase has to be followed.

use super::state_space::EigenMotion;
use crate::linalg::{Matrix, Vector, column_of, dot, mul_vec};

/// Ratio of the two axes of an oscillating motion below which its plane gets orthonormal vectors: damping ratio 0.98.
const FLAT: f64 = 0.1;
/// Smallest determinant of an S_k that is one plane seen from its neighbour.
const SAME_PLANE: f64 = 0.1;
/// Sine of the angle below which two vectors span a plane no better than rounding.
const ONE: f64 = 1e-5;

/// The columns V of every pair of motions of A without a neighbour; `None` where motions are missing.
pub(crate) fn from_eigenmotions(motions: &[EigenMotion], a: &Matrix) -> Option<Matrix> {
    let (turning, still): (Vec<&EigenMotion>, Vec<&EigenMotion>) = motions.iter().partition(|m| m.imaginary.is_some());
    let mut planes = turning.into_iter().map(|motion| real_plane(motion, a)).collect::<Option<Vec<_>>>()?;
    let mut left: Vec<&[f64]> = still.into_iter().map(|motion| motion.real.as_slice()).collect();
    while left.len() > 1 {
        let mut best = (0, 1, -1.0);
        for i in 0..left.len() {
            for j in i + 1..left.len() {
                let cosine = dot(left[i], left[j]).abs();
                if cosine > best.2 {
                    best = (i, j, cosine);
                }
            }
        }
        let (second, first) = (left.remove(best.1), left.remove(best.0));
        planes.push(orthonormal(first, second, a)?);
    }
    columns(&planes, left.len())
}

/// The columns R beside a neighbour with left vectors L'; `None` where its planes are not found again.
pub(crate) fn aligned_with_neighbour(motions: &[EigenMotion], a: &Matrix, left: &Matrix) -> Option<Matrix> {
    let pairs = left.nrows() / 2;
    let rows = left.transpose();
    let share = |state: &[f64], k: usize| {
        let of = |row: usize| dot(column_of(&rows, row), state);
        let (a, b) = (of(k), of(pairs + k));
        a * a + b * b
    };
    let mut shares = Vec::with_capacity(motions.len() * pairs);
    for (i, motion) in motions.iter().enumerate() {
        for k in 0..pairs {
            let imaginary = motion.imaginary.as_ref().map_or(0.0, |state| share(state, k));
            shares.push((share(&motion.real, k) + imaginary, i, k));
        }
    }
    shares.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); pairs];
    let (mut room, mut placed) = (vec![2; pairs], vec![false; motions.len()]);
    for (_, i, k) in shares {
        let needs = if motions[i].imaginary.is_some() { 2 } else { 1 };
        if !placed[i] && room[k] >= needs {
            placed[i] = true;
            room[k] -= needs;
            members[k].push(i);
        }
    }
    let planes = members.iter().enumerate().map(|(k, members)| {
        let plane = match members.as_slice() {
            [one] => real_plane(&motions[*one], a)?,
            [one, other] => orthonormal(&motions[*one].real, &motions[*other].real, a)?,
            _ => return None,
        };
        let [a, b] = [k, pairs + k].map(|row| column_of(&rows, row));
        aligned(&plane, [dot(a, &plane[0]), dot(a, &plane[1]), dot(b, &plane[0]), dot(b, &plane[1])])
    });
    columns(&planes.collect::<Option<Vec<_>>>()?, 0)
}

/// The plane of a motion that oscillates.
fn real_plane(motion: &EigenMotion, a: &Matrix) -> Option<[Vec<f64>; 2]> {
    let imaginary = motion.imaginary.as_ref()?;
    let (aa, ab, bb) = (dot(&motion.real, &motion.real), dot(&motion.real, imaginary), dot(imaginary, imaginary));
    let (mean, half) = (0.5 * (aa + bb), 0.5 * (aa - bb));
    let radius = (half * half + ab * ab).sqrt();
    if mean - radius < FLAT * FLAT * (mean + radius) {
        return orthonormal(&motion.real, imaginary, a);
    }
    // x = Re[r (a + ib)]; so that each vector is about of length 1
    let scale = std::f64::consts::SQRT_2;
    Some([
        motion.real.iter().map(|entry| scale * entry).collect(),
        imaginary.iter().map(|entry| -scale * entry).collect(),
    ])
}

/// Orthonormal vectors of the plane of two; `None` where there is none.
fn orthonormal(one: &[f64], other: &[f64], a: &Matrix) -> Option<[Vec<f64>; 2]> {
    let (one, other) = if dot(one, one) >= dot(other, other) { (one, other) } else { (other, one) };
    let first = unit(one)?;
    let across = unit(other).map(|second| orthogonal_part(&second, &first));
    let second = match across {
        Some(across) if dot(&across, &across) > ONE * ONE => across,
        _ => orthogonal_part(&unit(&generalised(&first, a)?)?, &first),
    };
    // once more, for what rounding has left along the first
    let second = unit(&orthogonal_part(&unit(&second)?, &first))?;
    Some([first, second])
}

/// The shortest g of `(A - lambda) g = r`, lambda being `r.A r`.
fn generalised(r: &[f64], a: &Matrix) -> Option<Vec<f64>> {
    let size = r.len();
    let mut moved = vec![0.0; size];
    mul_vec(a, r, &mut moved);
    let shifted = a - Matrix::identity(size, size) * dot(r, &moved);
    let parts = shifted.svd(true, true);
    let least = ONE * parts.singular_values.max();
    Some(parts.solve(&Vector::from_column_slice(r), least).ok()?.as_slice().to_vec())
}

fn unit(v: &[f64]) -> Option<Vec<f64>> {
    let length = dot(v, v).sqrt();
    (length > 0.0).then(|| v.iter().map(|entry| entry / length).collect())
}

/// v without its part along a unit vector.
fn orthogonal_part(v: &[f64], along: &[f64]) -> Vec<f64> {
    let part = dot(along, v);
    v.iter().zip(along).map(|(entry, unit)| entry - part * unit).collect()
}

/// `V S^-1` of one plane.
fn aligned(plane: &[Vec<f64>; 2], s: [f64; 4]) -> Option<[Vec<f64>; 2]> {
    let determinant = s[0] * s[3] - s[1] * s[2];
    if determinant.abs() < SAME_PLANE {
        return None;
    }
    let mix = |a: f64, b: f64| -> Vec<f64> {
        plane[0].iter().zip(&plane[1]).map(|(x, y)| (a * x + b * y) / determinant).collect()
    };
    Some([mix(s[3], -s[2]), mix(-s[1], s[0])])
}

/// All columns; `None` where they are not a basis of the state space, or something is left over.
fn columns(planes: &[[Vec<f64>; 2]], left_over: usize) -> Option<Matrix> {
    let pairs = planes.len();
    let size = planes.first()?[0].len();
    if left_over > 0 || 2 * pairs != size {
        return None;
    }
    Some(Matrix::from_fn(size, size, |i, j| planes[j % pairs][j / pairs][i]))
}
