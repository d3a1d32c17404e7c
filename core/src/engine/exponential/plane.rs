//! Vectors and matrices of the plane.

/// A quarter turn on.
pub(super) fn across([a, b]: [f64; 2]) -> [f64; 2] {
    [-b, a]
}

pub(super) fn product(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn times(m: &[[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    [product(m[0], v), product(m[1], v)]
}

/// Of a matrix by rows.
pub(super) fn by_rows(m: &[f64; 4], v: [f64; 2]) -> [f64; 2] {
    [m[0] * v[0] + m[1] * v[1], m[2] * v[0] + m[3] * v[1]]
}

/// A matrix of the machine's axes in axes turned by an angle with this sine and cosine.
pub(super) fn turned((sin, cos): (f64, f64), m: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let axes = [[cos, sin], [-sin, cos]];
    axes.map(|a| axes.map(|b| product(a, times(m, b))))
}
