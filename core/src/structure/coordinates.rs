//! Generalised coordinates of a part: its nodal degrees of freedom, or modal amplitudes.

use bladeoff_numerics::linalg::{Matrix, axpy, column_of, dot};

/// The map between coordinates q and nodal degrees of freedom x: `x = Phi q`, forces `Phi^T f`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    /// Number of nodal degrees of freedom.
    nodal_size: usize,
    /// Mode shapes; `None` for nodal coordinates.
    modes: Option<Modes>,
}

#[derive(Debug, Clone, PartialEq)]
struct Modes {
    /// Mode shapes Phi in columns.
    shapes: Matrix,
    /// Phi^T: the column of a nodal degree of freedom is contiguous.
    transposed: Matrix,
    /// Range of rows from the first to the last nonzero one, by mode: a mode in one plane skips the other.
    spans: Vec<(usize, usize)>,
}

impl Coordinates {
    /// Nodal coordinates, q = x.
    #[must_use]
    pub fn nodal(size: usize) -> Self {
        Self { nodal_size: size, modes: None }
    }

    /// Modal coordinates, x = Phi q.
    #[must_use]
    pub fn modal(shapes: &Matrix) -> Self {
        Self {
            nodal_size: shapes.nrows(),
            modes: Some(Modes {
                shapes: shapes.clone(),
                transposed: shapes.transpose(),
                spans: (0..shapes.ncols()).map(|j| span(column_of(shapes, j))).collect(),
            }),
        }
    }

    /// Number of coordinates.
    #[must_use]
    pub fn size(&self) -> usize {
        self.modes.as_ref().map_or(self.nodal_size, |modes| modes.shapes.ncols())
    }

    /// Number of nodal degrees of freedom.
    #[must_use]
    pub fn nodal_size(&self) -> usize {
        self.nodal_size
    }

    /// Whether the coordinates are modal amplitudes.
    #[must_use]
    pub fn is_modal(&self) -> bool {
        self.modes.is_some()
    }

    /// Mode shapes Phi; `None` for nodal coordinates.
    #[must_use]
    pub fn shapes(&self) -> Option<&Matrix> {
        self.modes.as_ref().map(|modes| &modes.shapes)
    }

    /// Nodal displacements x = Phi q.
    pub fn expand(&self, q: &[f64], x: &mut [f64]) {
        match &self.modes {
            None => x.copy_from_slice(q),
            Some(modes) => {
                x.fill(0.0);
                for (j, &amplitude) in q.iter().enumerate() {
                    let (from, to) = modes.spans[j];
                    axpy(amplitude, &column_of(&modes.shapes, j)[from..to], &mut x[from..to]);
                }
            }
        }
    }

    /// The first `x.len()` nodal degrees of freedom of Phi q.
    pub fn expand_head(&self, q: &[f64], x: &mut [f64]) {
        match &self.modes {
            None => x.copy_from_slice(&q[..x.len()]),
            Some(modes) => {
                x.fill(0.0);
                for (j, &amplitude) in q.iter().enumerate() {
                    axpy(amplitude, &column_of(&modes.shapes, j)[..x.len()], x);
                }
            }
        }
    }

    /// Generalised forces f_q = Phi^T f.
    pub fn project(&self, f: &[f64], f_q: &mut [f64]) {
        match &self.modes {
            None => f_q.copy_from_slice(f),
            Some(modes) => {
                for (j, sum) in f_q.iter_mut().enumerate() {
                    let (from, to) = modes.spans[j];
                    *sum = dot(&column_of(&modes.shapes, j)[from..to], &f[from..to]);
                }
            }
        }
    }

    /// Adds `factor * Phi[dof, :]` to a row.
    pub fn add_row(&self, dof: usize, factor: f64, row: &mut [f64]) {
        match &self.modes {
            None => row[dof] += factor,
            Some(modes) => axpy(factor, column_of(&modes.transposed, dof), row),
        }
    }

    /// Row Phi[dof, :].
    #[must_use]
    pub fn row(&self, dof: usize) -> Vec<f64> {
        let mut row = vec![0.0; self.size()];
        self.add_row(dof, 1.0, &mut row);
        row
    }
}

fn span(column: &[f64]) -> (usize, usize) {
    let from = column.iter().position(|&value| value != 0.0).unwrap_or(0);
    let to = column.iter().rposition(|&value| value != 0.0).map_or(0, |last| last + 1);
    (from, to.max(from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_is_the_transpose_of_expansion() {
        let shapes = Matrix::from_fn(6, 3, |i, j| ((i * 5 + j * 7) % 9) as f64 - 4.0);
        for coordinates in [Coordinates::modal(&shapes), Coordinates::nodal(6)] {
            let q: Vec<f64> = (0..coordinates.size()).map(|i| i as f64 + 0.5).collect();
            let f: Vec<f64> = (0..6).map(|i| f64::from(i) - 2.0).collect();
            let (mut x, mut p) = (vec![0.0; 6], vec![0.0; coordinates.size()]);
            coordinates.expand(&q, &mut x);
            coordinates.project(&f, &mut p);
            assert!((bladeoff_numerics::linalg::dot(&x, &f) - bladeoff_numerics::linalg::dot(&q, &p)).abs() < 1e-12);
            assert!((bladeoff_numerics::linalg::dot(&coordinates.row(4), &q) - x[4]).abs() < 1e-12);
            let mut head = vec![0.0; 4];
            coordinates.expand_head(&q, &mut head);
            assert_eq!(head, x[..4]);
        }
    }
}
