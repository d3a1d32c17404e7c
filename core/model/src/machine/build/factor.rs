//! Cholesky factors of the matrices of checks: narrow bands and small dense matrices.

/// Lower triangle of a symmetric matrix with `below` subdiagonals; dense if `below` includes all of them. A study checks every sample, so a band
/// must be cheap compared with the matrices of a run.
pub(super) struct Symmetric {
    size: usize,
    below: usize,
    entries: Vec<f64>,
}

impl Symmetric {
    pub fn banded(size: usize, below: usize) -> Self {
        Self { size, below, entries: vec![0.0; size * (below + 1)] }
    }

    pub fn dense(size: usize) -> Self {
        Self::banded(size, size.saturating_sub(1))
    }

    pub fn size(&self) -> usize {
        self.size
    }

    /// Index of an entry with `column <= row <= column + below`.
    fn at(&self, row: usize, column: usize) -> usize {
        row * (self.below + 1) + self.below + column - row
    }

    /// An entry of the lower triangle.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.entries[self.at(row, column)]
    }

    /// Adds to an entry of the lower triangle.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.at(row, column);
        self.entries[at] += value;
    }

    /// Factorises `A = L L^T`; `None` if A is not positive definite.
    pub fn factor(&self) -> Option<Factor> {
        let mut l = Self { entries: self.entries.clone(), ..*self };
        for i in 0..l.size {
            let first = i.saturating_sub(l.below);
            for j in first..=i {
                let mut sum = l.get(i, j);
                for k in first.max(j.saturating_sub(l.below))..j {
                    sum -= l.get(i, k) * l.get(j, k);
                }
                let at = l.at(i, j);
                l.entries[at] = if j < i {
                    sum / l.get(j, j)
                } else if sum > 0.0 {
                    sum.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Factor(l))
    }
}

/// The factor L of `A = L L^T`.
pub(super) struct Factor(Symmetric);

impl Factor {
    /// `C^T A^-1 C`, where C has these columns.
    pub fn between(&self, columns: &[Vec<f64>]) -> Symmetric {
        let solved: Vec<Vec<f64>> = columns.iter().map(|column| self.forward(column)).collect();
        let mut product = Symmetric::dense(columns.len());
        for (i, a) in solved.iter().enumerate() {
            for (j, b) in solved[..=i].iter().enumerate() {
                product.add(i, j, a.iter().zip(b).map(|(a, b)| a * b).sum());
            }
        }
        product
    }

    /// Rows and columns of `A^-1` with these indices.
    pub fn inverse_at(&self, places: impl IntoIterator<Item = usize>) -> Symmetric {
        let unit = |place: usize| {
            let mut column = vec![0.0; self.0.size];
            column[place] = 1.0;
            column
        };
        self.between(&places.into_iter().map(unit).collect::<Vec<_>>())
    }

    /// `L^-1 b`.
    fn forward(&self, b: &[f64]) -> Vec<f64> {
        let l = &self.0;
        let mut y = vec![0.0; l.size];
        for i in b.iter().position(|entry| *entry != 0.0).unwrap_or(l.size)..l.size {
            let known = (i.saturating_sub(l.below)..i).map(|k| l.get(i, k) * y[k]).sum::<f64>();
            y[i] = (b[i] - known) / l.get(i, i);
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of a test matrix: whole numbers, dominated by the diagonal; zero outside the band.
    fn entry(i: usize, j: usize, below: usize) -> f64 {
        let (row, column) = (i.max(j), i.min(j));
        match row - column {
            0 => 50.0 + row as f64,
            apart if apart <= below => ((7 * row + 3 * column) % 11) as f64 - 5.0,
            _ => 0.0,
        }
    }

    #[test]
    fn a_factor_inverts_a_band_and_a_dense_matrix() {
        const SIZE: usize = 9;
        for below in [1, 3, SIZE - 1] {
            let mut matrix = Symmetric::banded(SIZE, below);
            for i in 0..SIZE {
                (i.saturating_sub(below)..=i).for_each(|j| matrix.add(i, j, entry(i, j, below)));
            }
            let inverse = matrix.factor().expect("definite").inverse_at(0..SIZE);
            for i in 0..SIZE {
                for j in 0..SIZE {
                    let product: f64 = (0..SIZE).map(|k| entry(i, k, below) * inverse.get(k.max(j), k.min(j))).sum();
                    assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14, "{below} {i} {j}: {product}");
                }
            }
            matrix.add(4, 4, -100.0);
            assert!(matrix.factor().is_none());
        }
    }
}
