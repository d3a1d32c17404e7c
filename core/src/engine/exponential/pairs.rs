//! Pairs of motions: real planes of the state space, each of which goes on in itself.
//!
//! A motion that oscillates spans a plane with its conjugate; of those that do not, two share one. In a plane the system is a real
//! 2 x 2 block (`block`), so that a pair that merges, and parts again as two real motions, stays one plane: its eigenvectors become one
//! there, the plane does not. What would merge is paired: motions that are nearly parallel, or those whose planes a neighbouring speed has as one.
//! ```text
//! V   two columns for each pair k, at k and n + k;        alone   the two of a pair orthonormal (a plane of its own norm where it oscillates well)
//! S_k = [L' V]_kk,  R = V S^-1                            beside a neighbour with left vectors L': each plane turned so that [L' R]_kk = 1      (1)
//! ```
//! (1) is parallel transport: between neighbours no plane turns or grows in itself, and no phase has to be followed.

use super::system::EigenMotion;
use crate::linalg::{Matrix, dot};

/// Ratio of the two axes of an oscillating motion below which its plane gets orthonormal vectors: damping ratio 0.98.
const FLAT: f64 = 0.1;
/// Smallest determinant of an S_k that is one plane seen from its neighbour.
const SAME_PLANE: f64 = 0.1;

/// The columns V of every pair without a neighbour; `None` where motions are missing.
pub(super) fn alone(motions: &[EigenMotion]) -> Option<Matrix> {
    let mut planes: Vec<[Vec<f64>; 2]> = motions.iter().filter_map(plane_of).collect();
    let mut left: Vec<&[f64]> = motions.iter().filter(|m| m.imaginary.is_none()).map(|m| m.real.as_slice()).collect();
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
        planes.push(orthonormal(first, second)?);
    }
    columns(&planes, left.len())
}

/// The columns R beside a neighbour with left vectors L'; `None` where its planes are not found again.
pub(super) fn beside(motions: &[EigenMotion], left: &Matrix) -> Option<Matrix> {
    let pairs = left.nrows() / 2;
    let rows = left.transpose();
    let share = |state: &[f64], k: usize| {
        let of = |row: usize| dot(crate::linalg::column_of(&rows, row), state);
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
            [one] => plane_of(&motions[*one])?,
            [one, other] => orthonormal(&motions[*one].real, &motions[*other].real)?,
            _ => return None,
        };
        let [a, b] = [k, pairs + k].map(|row| crate::linalg::column_of(&rows, row));
        aligned(&plane, [dot(a, &plane[0]), dot(a, &plane[1]), dot(b, &plane[0]), dot(b, &plane[1])])
    });
    columns(&planes.collect::<Option<Vec<_>>>()?, 0)
}

/// The plane of a motion that oscillates.
fn plane_of(motion: &EigenMotion) -> Option<[Vec<f64>; 2]> {
    let imaginary = motion.imaginary.as_ref()?;
    let (aa, ab, bb) = (dot(&motion.real, &motion.real), dot(&motion.real, imaginary), dot(imaginary, imaginary));
    let (mean, radius) = (0.5 * (aa + bb), (0.5 * (aa - bb)).hypot(ab));
    if mean - radius < FLAT * FLAT * (mean + radius) {
        return orthonormal(&motion.real, imaginary);
    }
    // x = Re[r (a + ib)]; so that each vector is about of length 1
    let scale = std::f64::consts::SQRT_2;
    Some([
        motion.real.iter().map(|entry| scale * entry).collect(),
        imaginary.iter().map(|entry| -scale * entry).collect(),
    ])
}

/// Orthonormal vectors of the plane of two, the longer one first; `None` where they are one to rounding.
fn orthonormal(one: &[f64], other: &[f64]) -> Option<[Vec<f64>; 2]> {
    let (one, other) = if dot(one, one) >= dot(other, other) { (one, other) } else { (other, one) };
    let unit = |v: Vec<f64>| {
        let length = dot(&v, &v).sqrt();
        (length > 0.0).then(|| v.iter().map(|entry| entry / length).collect::<Vec<f64>>())
    };
    let (first, second) = (unit(one.to_vec())?, unit(other.to_vec())?);
    let rest = |v: &[f64]| {
        let along = dot(&first, v);
        v.iter().zip(&first).map(|(entry, unit)| entry - along * unit).collect::<Vec<f64>>()
    };
    let across = rest(&second);
    // 1e-14: a difference of two that agree so far has no digit left
    (dot(&across, &across) > 1e-28).then(|| unit(rest(&unit(across)?)))?.map(|second| [first.clone(), second])
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
