//! Batches of rows: products of eight rows at a time with one vector, of all rows or of one block of eight.
//!
//! Verified by `products_are_those_of_their_matrix`.

use crate::eight::mix;
use bladeoff_numerics::linalg::Matrix;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, rows_times};

/// Quantity that is interpolated linearly between two modal bases.
pub(crate) trait Interpolate: Default {
    /// Sets `self` to the linear combination of two values of equal size with the given factors.
    fn interpolate(&mut self, values: [&Self; 2], factors: [f64; 2]);
}

/// Rows in blocks of eight; the last block is filled up with zeros.
#[derive(Debug, Clone, Default)]
pub(crate) struct RowBatch {
    columns: usize,
    /// Entries of each block, column by column.
    entries: Vec<Lane>,
}

impl RowBatch {
    /// Batch of the rows of a matrix.
    pub fn new(matrix: &Matrix) -> Self {
        let (rows, columns) = matrix.shape();
        let mut entries = vec![Lane::default(); rows.div_ceil(LANES) * columns];
        for (j, column) in matrix.as_slice().chunks_exact(rows.max(1)).enumerate() {
            for (block, part) in column.chunks(LANES).enumerate() {
                entries[block * columns + j].0[..part.len()].copy_from_slice(part);
            }
        }
        Self { columns, entries }
    }

    /// Products of one block of eight rows with y.
    pub fn multiply_block(&self, block: usize, y: &[f64]) -> [f64; LANES] {
        rows_times(&self.entries[block * self.columns..(block + 1) * self.columns], y)
    }

    /// Products of all rows with y, with zeros up to a multiple of eight.
    pub fn multiply(&self, y: &[f64], products: &mut Vec<f64>) {
        products.clear();
        for block in self.entries.chunks_exact(self.columns.max(1)) {
            products.extend_from_slice(&rows_times(block, y));
        }
    }
}

impl Interpolate for RowBatch {
    fn interpolate(&mut self, rows: [&Self; 2], factors: [f64; 2]) {
        self.columns = rows[0].columns;
        mix(rows.map(|rows| rows.entries.as_slice()), factors, &mut self.entries);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_numerics::linalg::mul_vec;

    #[test]
    fn products_are_those_of_their_matrix() {
        for (rows, columns) in [(0, 3), (1, 1), (4, 7), (8, 8), (13, 5), (17, 12)] {
            let matrix = Matrix::from_fn(rows, columns, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.0);
            let y: Vec<f64> = (0..columns).map(|i| (i * 5 % 7) as f64 - 2.5).collect();
            let mut wanted = vec![0.0; rows];
            mul_vec(&matrix, &y, &mut wanted);
            let batch = RowBatch::new(&matrix);
            let (mut products, mut mixed) = (Vec::new(), RowBatch::default());
            mixed.interpolate([&batch, &batch], [0.25, 1.75]);
            mixed.multiply(&y, &mut products);
            assert_eq!(products.len(), rows.next_multiple_of(LANES));
            for (i, product) in products.iter().enumerate() {
                let expected = wanted.get(i).map_or(0.0, |product| 2.0 * product);
                assert!((product - expected).abs() < 1e-11, "{rows} {columns}");
                assert_eq!(mixed.multiply_block(i / LANES, &y)[i % LANES].to_bits(), product.to_bits());
            }
        }
    }
}
