//! Compressed sparse rows: the products of the step loop with finite-element matrices.

use super::Matrix;

/// Compressed sparse row matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Csr {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Csr {
    /// The entries of a dense matrix that are not exactly zero.
    #[must_use]
    pub fn from_dense(a: &Matrix) -> Self {
        let mut csr = Csr { starts: vec![0], columns: Vec::new(), values: Vec::new() };
        for i in 0..a.nrows() {
            for j in 0..a.ncols() {
                if a[(i, j)] != 0.0 {
                    csr.columns.push(u32::try_from(j).expect("matrices are far below 2^32 columns"));
                    csr.values.push(a[(i, j)]);
                }
            }
            csr.starts.push(csr.values.len());
        }
        csr
    }

    /// y -= a A x.
    pub fn subtract_scaled(&self, a: f64, x: &[f64], y: &mut [f64]) {
        for (i, yi) in y.iter_mut().enumerate() {
            let row = self.starts[i]..self.starts[i + 1];
            let mut sum = 0.0;
            for (value, &j) in self.values[row.clone()].iter().zip(&self.columns[row]) {
                sum += value * x[j as usize];
            }
            *yi -= a * sum;
        }
    }

    /// `(A x)_i`, row by row.
    pub fn products<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.starts.windows(2).map(|row| {
            let row = row[0]..row[1];
            let mut sum = 0.0;
            for (value, &j) in self.values[row.clone()].iter().zip(&self.columns[row]) {
                sum += value * x[j as usize];
            }
            sum
        })
    }

    /// Largest `|(A x)_i|`.
    #[must_use]
    pub fn largest_product(&self, x: &[f64]) -> f64 {
        self.products(x).fold(0.0_f64, |largest, product| largest.max(product.abs()))
    }

    /// x^T A y.
    #[must_use]
    pub fn bilinear(&self, x: &[f64], y: &[f64]) -> f64 {
        let mut total = 0.0;
        for (i, xi) in x.iter().enumerate() {
            let row = self.starts[i]..self.starts[i + 1];
            let mut sum = 0.0;
            for (value, &j) in self.values[row.clone()].iter().zip(&self.columns[row]) {
                sum += value * y[j as usize];
            }
            total += xi * sum;
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_agree_with_the_dense_matrix() {
        let a = Matrix::from_fn(5, 5, |i, j| if (i + 2 * j) % 3 == 0 { (i * 5 + j) as f64 + 1.0 } else { 0.0 });
        let csr = Csr::from_dense(&a);
        let (x, z) = ([1.0, -2.0, 3.0, 0.5, 4.0], [0.3, 0.1, -1.0, 2.0, 7.0]);
        let mut y = [1.0; 5];
        csr.subtract_scaled(2.0, &x, &mut y);
        for i in 0..5 {
            let product: f64 = (0..5).map(|j| a[(i, j)] * x[j]).sum();
            assert!((y[i] - (1.0 - 2.0 * product)).abs() < 1e-12);
        }
        let direct: f64 = (0..5).flat_map(|i| (0..5).map(move |j| (i, j))).map(|(i, j)| z[i] * a[(i, j)] * x[j]).sum();
        assert!((csr.bilinear(&z, &x) - direct).abs() < 1e-10);
    }
}
