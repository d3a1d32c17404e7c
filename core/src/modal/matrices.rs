//! Matrices of the lateral motion in nodal coordinates, and in a reduced basis.
//!
//! ```text
//! (lambda^2 M + lambda (C + W G) + K + K_skew) x = 0,   x = V y
//! ```
//! Source: equations of motion of the shaft line at constant speed. Limits: bearing tables are added by the callers. Verified by the tests of those that solve it.

use bladeoff_numerics::linalg::{Matrix, project};

/// M, C, K + K_skew without tables, and G.
pub(super) struct Matrices {
    pub mass: Matrix,
    pub damping: Matrix,
    pub stiffness: Matrix,
    pub gyroscopic: Matrix,
}

/// A reduced basis with its matrices.
pub(super) struct Reduced {
    /// V: the same shapes in the XZ plane, then in the YZ plane.
    pub shapes: Matrix,
    pub matrices: Matrices,
}

impl Reduced {
    pub fn new(shapes: Matrix, matrices: &Matrices) -> Self {
        let Matrices { mass, damping, stiffness, gyroscopic } = matrices;
        let [mass, damping, stiffness, gyroscopic] =
            [mass, damping, stiffness, gyroscopic].map(|matrix| project(matrix, &shapes));
        Self { shapes, matrices: Matrices { mass, damping, stiffness, gyroscopic } }
    }

    /// V^T A V.
    pub fn projected(&self, matrix: &Matrix) -> Matrix {
        project(matrix, &self.shapes)
    }

    /// Coordinates of each plane.
    pub fn per_plane(&self) -> usize {
        self.shapes.ncols() / 2
    }
}
