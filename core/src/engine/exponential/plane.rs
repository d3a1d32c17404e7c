//! Vectors and 2 x 2 matrices of the plane across the shaft.

/// Length of a vector: one square root, the same on every processor.
#[inline(always)]
pub(crate) fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// The vector turned by a quarter turn, counter-clockwise.
#[inline(always)]
pub(crate) fn across([a, b]: [f64; 2]) -> [f64; 2] {
    [-b, a]
}

/// Scalar product.
#[inline(always)]
pub(crate) fn product(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Product of a matrix and a vector.
#[inline(always)]
pub(crate) fn times(m: &[[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    [product(m[0], v), product(m[1], v)]
}

/// Product of a matrix, stored by rows, and a vector.
#[inline(always)]
pub(crate) fn by_rows(m: &[f64; 4], v: [f64; 2]) -> [f64; 2] {
    [m[0] * v[0] + m[1] * v[1], m[2] * v[0] + m[3] * v[1]]
}

/// A matrix of the machine's axes in axes turned by the angle with this sine and cosine.
#[inline(always)]
pub(crate) fn turned((sin, cos): (f64, f64), m: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let [one, other] = [[cos, sin], [-sin, cos]];
    let (by_one, by_other) = (times(m, one), times(m, other));
    [[product(one, by_one), product(one, by_other)], [product(other, by_one), product(other, by_other)]]
}
