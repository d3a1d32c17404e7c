//! Matrices of the lateral motion in nodal coordinates, and in a reduced basis.
//!
//! ```text
//! (lambda^2 M + lambda (C + W G) + K + K_skew) x = 0,   x = V y
//! ```
//! Source: equations of motion of the shaft line at constant speed. Limits: the callers add bearing tables. Verified by the tests of the
//! solvers that use these matrices.

use bladeoff_numerics::linalg::{Matrix, project};

/// Lateral matrices: M, C, K + K_skew (without bearing tables) and G.
pub(super) struct Matrices {
    /// M [kg, kg m, kg m2].
    pub mass: Matrix,
    /// C [N s/m, N s, N m s].
    pub damping: Matrix,
    /// K + K_skew [N/m, N, N m].
    pub stiffness: Matrix,
    /// G per unit spin [kg m2].
    pub gyroscopic: Matrix,
}

/// A reduced basis with its matrices.
pub(super) struct Reduced {
    /// V: the same mode shapes in the XZ plane, then in the YZ plane.
    pub shapes: Matrix,
    /// Projected matrices `V^T A V`.
    pub matrices: Matrices,
}

impl Reduced {
    pub fn new(shapes: Matrix, matrices: &Matrices) -> Self {
        let Matrices { mass, damping, stiffness, gyroscopic } = matrices;
        let [mass, damping, stiffness, gyroscopic] =
            [mass, damping, stiffness, gyroscopic].map(|matrix| project(matrix, &shapes));
        Self { shapes, matrices: Matrices { mass, damping, stiffness, gyroscopic } }
    }

    /// Projection `V^T A V` of a nodal matrix.
    pub fn projected(&self, matrix: &Matrix) -> Matrix {
        project(matrix, &self.shapes)
    }

    /// Number of reduced coordinates per plane.
    pub fn per_plane(&self) -> usize {
        self.shapes.ncols() / 2
    }
}
