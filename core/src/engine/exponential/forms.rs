//! Quadratic forms and products of many rows, of one vector: eight rows at a time, in one order of operations.

use crate::linalg::Matrix;
use crate::linalg::lanes::{LANES, Lane, kernel, rows_times, rows_times_inline};

/// `y^T A y` of a symmetric A.
#[derive(Debug, Clone)]
pub(super) struct Form {
    size: usize,
    /// Of eight rows from i on: their entries in the columns from i on, column by column, what stands right of these eight columns doubled.
    entries: Vec<Lane>,
}

impl Form {
    /// Of the symmetric part of a matrix.
    pub fn new(matrix: &Matrix) -> Self {
        let size = matrix.nrows();
        let mut entries = Vec::new();
        for i in (0..size).step_by(LANES) {
            for j in i..size {
                let times = if j < i + LANES { 0.5 } else { 1.0 };
                entries.push(Lane(std::array::from_fn(|k| {
                    if i + k < size { times * (matrix[(i + k, j)] + matrix[(j, i + k)]) } else { 0.0 }
                })));
            }
        }
        Self { size, entries }
    }

    /// The sum of forms of one size, times these.
    pub fn mixed<const N: usize>(forms: [&Self; N], times: [f64; N]) -> Self {
        Self { size: forms[0].size, entries: mixed(forms.map(|form| form.entries.as_slice()), times) }
    }

    /// Its value.
    pub fn of(&self, y: &[f64]) -> f64 {
        value_of(&self.entries, &y[..self.size])
    }
}

/// Products of rows with one vector.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    columns: usize,
    /// Of eight rows, column by column.
    entries: Vec<Lane>,
}

impl Rows {
    /// Of a matrix.
    pub fn new(matrix: &Matrix) -> Self {
        let entries = (0..matrix.nrows()).step_by(LANES).flat_map(|i| {
            (0..matrix.ncols()).map(move |j| {
                Lane(std::array::from_fn(|k| if i + k < matrix.nrows() { matrix[(i + k, j)] } else { 0.0 }))
            })
        });
        Self { columns: matrix.ncols(), entries: entries.collect() }
    }

    /// The products, and zeros up to a multiple of eight.
    pub fn times(&self, y: &[f64], products: &mut Vec<f64>) {
        products.clear();
        for block in self.entries.chunks_exact(self.columns.max(1)) {
            products.extend(rows_times(block, y));
        }
    }
}

fn mixed<const N: usize>(entries: [&[Lane]; N], times: [f64; N]) -> Vec<Lane> {
    let mut sums = vec![Lane::default(); entries[0].len()];
    for (entries, times) in entries.into_iter().zip(times) {
        add_lanes(times, entries, &mut sums);
    }
    sums
}

kernel! {
    /// `sums += a x`.
    fn add_lanes(a: f64, x: &[Lane], sums: &mut [Lane]) {
        for (sum, x) in sums.iter_mut().zip(x) {
            for k in 0..LANES {
                sum.0[k] += a * x.0[k];
            }
        }
    }
}

kernel! {
    /// That of the form with these entries.
    fn value_of(entries: &[Lane], y: &[f64]) -> f64 {
        let (mut sum, mut entries) = ([0.0; LANES], entries);
        for i in (0..y.len()).step_by(LANES) {
            let (block, rest) = entries.split_at(y.len() - i);
            let products = rows_times_inline(block, &y[i..]);
            for (k, y) in y[i..].iter().take(LANES).enumerate() {
                sum[k] += products[k] * y;
            }
            entries = rest;
        }
        crate::linalg::lanes::sum(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{Vector, mul_vec};

    #[test]
    fn forms_and_products_are_those_of_their_matrix() {
        for size in [1, 2, 4, 7, 12] {
            let matrix = Matrix::from_fn(size, size, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.0);
            let y = Vector::from_fn(size, |i, _| (i * 5 % 7) as f64 - 2.5);
            let mut whole = vec![0.0; size];
            mul_vec(&matrix, y.as_slice(), &mut whole);
            let form = y.dot(&Vector::from_column_slice(&whole));
            assert!((Form::new(&matrix).of(y.as_slice()) - form).abs() < 1e-11, "{size}");
            let mut products = Vec::new();
            Rows::new(&matrix).times(y.as_slice(), &mut products);
            assert_eq!(products.len(), size.next_multiple_of(LANES));
            for (i, whole) in whole.iter().enumerate() {
                assert!((products[i] - whole).abs() < 1e-11, "{size}");
            }
        }
    }
}
