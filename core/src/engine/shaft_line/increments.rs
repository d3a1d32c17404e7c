//! Increments of one step from n to n+1, in coordinates.

/// Increments q(n+1) - q(n) of the lateral and the torsional coordinates.
#[derive(Debug, Clone, Default)]
pub(crate) struct Increments {
    /// Increments of the lateral coordinates.
    pub lateral: Vec<f64>,
    /// Increments of the torsional coordinates, of absolute angles.
    pub torsion: Vec<f64>,
}

impl Increments {
    /// Zero increments of these sizes.
    pub fn zeros(lateral: usize, torsion: usize) -> Self {
        Self { lateral: vec![0.0; lateral], torsion: vec![0.0; torsion] }
    }

    /// Copies other increments of the same sizes.
    pub fn copy_from(&mut self, other: &Self) {
        self.lateral.copy_from_slice(&other.lateral);
        self.torsion.copy_from_slice(&other.torsion);
    }
}
