//! The correlation matrix nearest to an impossible one, in the sum of squares of the differences.
//!
//! ```text
//! X = nearest matrix of eigenvalues >= delta to Y - S;  S = X - (Y - S);  Y = X with ones on its diagonal;  until Y converges
//! ```
//! Source: N. J. Higham, "Computing the nearest correlation matrix" (2002): alternating projections with Dykstra's correction.
//! Deviation: delta above 0, so that the result stays a possible matrix when rounded for a message.

use bladeoff_numerics::CorrelationMatrix;

const ROUNDS: usize = 500;
/// Size above which fewer iterations are done, so that a message takes seconds at most.
const LARGE: usize = 64;
/// Convergence limit; a message has five digits.
const SETTLED: f64 = 1e-7;

/// The nearest correlation matrix with eigenvalues of at least about `least`.
#[must_use]
pub fn nearest(given: &CorrelationMatrix, least: f64) -> CorrelationMatrix {
    let n = given.size();
    let mut y = given.clone();
    let mut correction = CorrelationMatrix::identity(n);
    (0..n).for_each(|i| correction.set(i, i, 0.0));
    let mut vectors = CorrelationMatrix::identity(n);
    let times = n.div_ceil(LARGE);
    for _ in 0..ROUNDS / (times * times * times) {
        let mut wanted = y.clone();
        for i in 0..n {
            for j in 0..n {
                wanted.set(i, j, y.at(i, j) - correction.at(i, j));
            }
        }
        let x;
        (x, vectors) = definite(&wanted, least, vectors);
        let mut change = 0.0f64;
        for i in 0..n {
            for j in 0..n {
                correction.set(i, j, x.at(i, j) - wanted.at(i, j));
                let next = if i == j { 1.0 } else { x.at(i, j) };
                change = change.max((next - y.at(i, j)).abs());
                y.set(i, j, next);
            }
        }
        if change < SETTLED {
            break;
        }
    }
    // remainder of rounding and an early end: shrunk towards independence until the matrix is positive definite
    let mut towards = 0.0;
    while shrunk(&y, 1.0 - towards).cholesky().is_none() {
        towards = (2.0 * towards).clamp(1e-9, 1.0);
    }
    shrunk(&y, 1.0 - towards)
}

/// The nearest matrix with eigenvalues of at least `least`, and its eigenvectors, which are close to those of the previous iteration (`before`).
fn definite(
    matrix: &CorrelationMatrix,
    least: f64,
    before: CorrelationMatrix,
) -> (CorrelationMatrix, CorrelationMatrix) {
    let n = matrix.size();
    let (values, vectors) = matrix.eigen(before);
    let mut nearest = matrix.clone();
    for i in 0..n {
        for j in 0..=i {
            let entry = (0..n).map(|k| values[k].max(least) * vectors.at(i, k) * vectors.at(j, k)).sum();
            nearest.set_both(i, j, entry);
        }
    }
    (nearest, vectors)
}

fn shrunk(matrix: &CorrelationMatrix, by: f64) -> CorrelationMatrix {
    let mut shrunk = matrix.clone();
    for i in 0..matrix.size() {
        for j in 0..matrix.size() {
            if i != j {
                shrunk.set(i, j, by * matrix.at(i, j));
            }
        }
    }
    shrunk
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_published_case_comes_out() {
        // Higham 2002, section 4: tridiagonal ones; nearest 0.7607 beside the diagonal, 0.1573 in the corner
        let mut given = CorrelationMatrix::identity(3);
        given.set_both(0, 1, 1.0);
        given.set_both(1, 2, 1.0);
        let found = nearest(&given, 0.0);
        assert!((found.at(0, 1) - 0.7607).abs() < 5e-5 && (found.at(1, 2) - 0.7607).abs() < 5e-5, "{found:?}");
        assert!((found.at(0, 2) - 0.1573).abs() < 5e-5, "{found:?}");
    }

    #[test]
    fn what_is_possible_stays() {
        let mut given = CorrelationMatrix::identity(4);
        given.set_both(0, 1, 0.5);
        given.set_both(2, 3, -0.7);
        let found = nearest(&given, 1e-6);
        for i in 0..4 {
            for j in 0..4 {
                assert!((found.at(i, j) - given.at(i, j)).abs() < 1e-12);
            }
        }
    }
}
