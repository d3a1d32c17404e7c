//! Linear part of a machine: shaft bending, shaft torsion, or a ring.

use super::coordinates::Coordinates;
use crate::modal::ModeSet;
use bladeoff_numerics::linalg::{Matrix, mul, mul_tn, project};

/// Linear equations of motion `M q'' + C q' + K q = f` in the engine's coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Map between coordinates q and nodal degrees of freedom.
    pub coordinates: Coordinates,
    /// Mass matrix M.
    pub mass: Matrix,
    /// Damping matrix C.
    pub damping: Matrix,
    /// Stiffness matrix K (symmetric).
    pub stiffness: Matrix,
    /// Whether all three matrices are diagonal and M = 1.
    pub modal: bool,
    /// Highest natural frequency \[rad/s\].
    pub highest: f64,
}

impl Part {
    pub(super) fn reduced(modes: &ModeSet, damping: &Matrix) -> Self {
        let size = modes.omega_squared.len();
        Self {
            coordinates: Coordinates::modal(&modes.shapes),
            mass: Matrix::identity(size, size),
            damping: project(damping, &modes.shapes),
            stiffness: diagonal(modes.omega_squared.clone()),
            modal: damping.amax() == 0.0,
            highest: modes.highest(),
        }
    }

    /// Modes with Rayleigh damping `C = a M + b K`, which keeps them uncoupled: modal damping `a + b omega^2`.
    pub(super) fn proportional(modes: &ModeSet, a: f64, b: f64) -> Self {
        let nodal = modes.shapes.nrows();
        let damping = modes.omega_squared.iter().map(|square| a + b * square).collect();
        Self { damping: diagonal(damping), modal: true, ..Self::reduced(modes, &Matrix::zeros(nodal, nodal)) }
    }

    pub(super) fn full(mass: &Matrix, damping: &Matrix, stiffness: &Matrix, highest: f64) -> Self {
        Self {
            coordinates: Coordinates::nodal(mass.nrows()),
            mass: mass.clone(),
            damping: damping.clone(),
            stiffness: stiffness.clone(),
            modal: false,
            highest,
        }
    }

    /// Coordinates of a nodal displacement field: exact for the full engine, the M-orthogonal projection
    /// `q = Phi^T M x` for the reduced one.
    #[must_use]
    pub fn coordinates_of(&self, nodal_mass: &Matrix, field: &[f64]) -> Vec<f64> {
        match self.coordinates.shapes() {
            None => field.to_vec(),
            Some(shapes) => {
                let field = Matrix::from_column_slice(field.len(), 1, field);
                mul_tn(shapes, &mul(nodal_mass, &field)).as_slice().to_vec()
            }
        }
    }
}

fn diagonal(entries: Vec<f64>) -> Matrix {
    Matrix::from_diagonal(&bladeoff_numerics::linalg::Vector::from_vec(entries))
}
