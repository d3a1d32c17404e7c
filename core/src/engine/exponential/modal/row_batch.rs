//! Rows of which eight are taken at a time, all of them or those that are asked for.

use crate::linalg::Matrix;
use crate::linalg::eight::mix;
use crate::linalg::lanes::{LANES, Lane, rows_times};

/// What is linear in the share between two stations.
pub(crate) trait Interpolate: Default {
    /// Becomes the sum of two of one size, times these.
    fn interpolate(&mut self, of: [&Self; 2], times: [f64; 2]);
}

/// Rows in blocks of eight, zeros behind the last.
#[derive(Debug, Clone, Default)]
pub(crate) struct RowBatch {
    columns: usize,
    /// Of each block, column by column.
    entries: Vec<Lane>,
}

impl RowBatch {
    /// Of a matrix.
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

    /// Products of one block with a list.
    pub fn multiply_block(&self, block: usize, y: &[f64]) -> [f64; LANES] {
        rows_times(&self.entries[block * self.columns..(block + 1) * self.columns], y)
    }

    /// Products of all rows, and zeros up to a multiple of eight.
    pub fn multiply(&self, y: &[f64], products: &mut Vec<f64>) {
        products.clear();
        for block in self.entries.chunks_exact(self.columns.max(1)) {
            products.extend_from_slice(&rows_times(block, y));
        }
    }
}

impl Interpolate for RowBatch {
    fn interpolate(&mut self, of: [&Self; 2], times: [f64; 2]) {
        self.columns = of[0].columns;
        mix(of.map(|rows| rows.entries.as_slice()), times, &mut self.entries);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::mul_vec;

    #[test]
    fn products_are_those_of_their_matrix() {
        for (rows, columns) in [(0, 3), (1, 1), (4, 7), (8, 8), (13, 5), (17, 12)] {
            let matrix = Matrix::from_fn(rows, columns, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.0);
            let y: Vec<f64> = (0..columns).map(|i| (i * 5 % 7) as f64 - 2.5).collect();
            let mut whole = vec![0.0; rows];
            mul_vec(&matrix, &y, &mut whole);
            let one = RowBatch::new(&matrix);
            let (mut products, mut mixed) = (Vec::new(), RowBatch::default());
            mixed.interpolate([&one, &one], [0.25, 1.75]);
            mixed.multiply(&y, &mut products);
            assert_eq!(products.len(), rows.next_multiple_of(LANES));
            for (i, product) in products.iter().enumerate() {
                let wanted = whole.get(i).map_or(0.0, |product| 2.0 * product);
                assert!((product - wanted).abs() < 1e-11, "{rows} {columns}");
                assert_eq!(mixed.multiply_block(i / LANES, &y)[i % LANES].to_bits(), product.to_bits());
            }
        }
    }
}
