//! Symmetric matrices for correlations, stored by rows: Cholesky factor and eigenvalues, by plain operations in a fixed order.

/// A square matrix, stored by rows.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrelationMatrix {
    size: usize,
    entries: Vec<f64>,
}

/// The smallest square of a pivot; below it, a factor has no valid digits.
const LEAST_PIVOT: f64 = 1e-12;
/// Most sweeps over all pairs; about ten are usual.
const SWEEPS: usize = 60;

impl CorrelationMatrix {
    /// The identity matrix.
    #[must_use]
    pub fn identity(size: usize) -> Self {
        let mut matrix = Self { size, entries: vec![0.0; size * size] };
        (0..size).for_each(|i| matrix.set(i, i, 1.0));
        matrix
    }

    /// Number of rows.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// An entry.
    #[must_use]
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.entries[row * self.size + column]
    }

    /// Sets an entry.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        self.entries[row * self.size + column] = value;
    }

    /// Sets an entry and its mirror image.
    pub fn set_both(&mut self, row: usize, column: usize, value: f64) {
        self.set(row, column, value);
        self.set(column, row, value);
    }

    /// The lower triangular L with L L^T = this matrix of unit diagonal; `None` if it is not positive definite, or so close to singular that the
    /// previous rows determine a row to 1e-6.
    #[must_use]
    pub fn cholesky(&self) -> Option<CorrelationMatrix> {
        let mut factor = Self { size: self.size, entries: vec![0.0; self.size * self.size] };
        for i in 0..self.size {
            for j in 0..=i {
                let mut rest = self.at(i, j);
                for k in 0..j {
                    rest -= factor.at(i, k) * factor.at(j, k);
                }
                if i > j {
                    factor.set(i, j, rest / factor.at(j, j));
                } else if rest > LEAST_PIVOT {
                    factor.set(i, i, libm::sqrt(rest));
                } else {
                    return None;
                }
            }
        }
        Some(factor)
    }

    /// Eigenvalues and, in the columns, eigenvectors, by Jacobi rotations; `first`: an orthogonal matrix, ideally close to the eigenvectors.
    ///
    /// Source: G. H. Golub, C. F. Van Loan, "Matrix Computations", section 8.5.
    #[must_use]
    pub fn eigen(&self, first: CorrelationMatrix) -> (Vec<f64>, CorrelationMatrix) {
        let n = self.size;
        let mut vectors = first;
        // V^T A V: almost diagonal if `first` is close to the eigenvectors
        let mut a = vectors.transposed_times(&self.transposed_times(&vectors));
        for _ in 0..SWEEPS {
            let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a.at(i, j) * a.at(i, j)).sum();
            if off <= 1e-30 * n as f64 {
                break;
            }
            for p in 0..n {
                for q in p + 1..n {
                    a.rotate(p, q, &mut vectors);
                }
            }
        }
        ((0..n).map(|i| a.at(i, i)).collect(), vectors)
    }

    /// The transpose of this matrix times the other.
    fn transposed_times(&self, other: &CorrelationMatrix) -> CorrelationMatrix {
        let n = self.size;
        let mut product = Self { size: n, entries: vec![0.0; n * n] };
        for k in 0..n {
            for i in 0..n {
                let factor = self.at(k, i);
                for j in 0..n {
                    product.entries[i * n + j] += factor * other.at(k, j);
                }
            }
        }
        product
    }

    /// Makes the entry p, q zero by a rotation.
    fn rotate(&mut self, p: usize, q: usize, vectors: &mut CorrelationMatrix) {
        let entry = self.at(p, q);
        // the sum of all such entries is below rounding
        if entry.abs() < 1e-17 {
            return;
        }
        let tau = (self.at(q, q) - self.at(p, p)) / (2.0 * entry);
        let root = libm::sqrt(1.0 + tau * tau);
        let t = if tau >= 0.0 { 1.0 / (tau + root) } else { -1.0 / (root - tau) };
        let c = 1.0 / libm::sqrt(1.0 + t * t);
        let s = t * c;
        for k in 0..self.size {
            let (x, y) = (self.at(k, p), self.at(k, q));
            self.set(k, p, c * x - s * y);
            self.set(k, q, s * x + c * y);
        }
        for k in 0..self.size {
            let (x, y) = (self.at(p, k), self.at(q, k));
            self.set(p, k, c * x - s * y);
            self.set(q, k, s * x + c * y);
        }
        for k in 0..self.size {
            let (x, y) = (vectors.at(k, p), vectors.at(k, q));
            vectors.set(k, p, c * x - s * y);
            vectors.set(k, q, s * x + c * y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_and_vectors_give_the_matrix_back() {
        let n = 12;
        let mut matrix = CorrelationMatrix::identity(n);
        for i in 0..n {
            for j in 0..i {
                matrix.set_both(i, j, 1.0 / (1 + i + j) as f64);
            }
        }
        let (values, vectors) = matrix.eigen(CorrelationMatrix::identity(n));
        let again = matrix.eigen(vectors.clone()).0;
        assert!(values.iter().zip(again).all(|(value, again)| (value - again).abs() < 1e-14));
        for i in 0..n {
            for j in 0..n {
                let back: f64 = (0..n).map(|k| values[k] * vectors.at(i, k) * vectors.at(j, k)).sum();
                let unit: f64 = (0..n).map(|k| vectors.at(k, i) * vectors.at(k, j)).sum();
                assert!((back - matrix.at(i, j)).abs() < 1e-14, "{i} {j}");
                assert!((unit - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j}");
            }
        }
        let factor = matrix.cholesky();
        assert_eq!(factor.is_some(), values.iter().all(|value| *value > 0.0));
    }

    #[test]
    fn cholesky_gives_the_matrix_back_and_refuses_what_is_not_definite() {
        let mut matrix = CorrelationMatrix::identity(3);
        matrix.set_both(0, 1, 0.9);
        matrix.set_both(1, 2, 0.9);
        matrix.set_both(0, 2, 0.7);
        let factor = matrix.cholesky().expect("definite");
        for i in 0..3 {
            for j in 0..3 {
                let back: f64 = (0..3).map(|k| factor.at(i, k) * factor.at(j, k)).sum();
                assert!((back - matrix.at(i, j)).abs() < 1e-15);
            }
        }
        matrix.set_both(0, 2, 0.5);
        assert!(matrix.cholesky().is_none());
        // exactly singular: the third row equals the second
        matrix.set_both(1, 2, 1.0);
        matrix.set_both(0, 2, 0.9);
        assert!(matrix.cholesky().is_none());
    }
}
