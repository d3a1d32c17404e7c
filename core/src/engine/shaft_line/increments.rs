//! Increments of one step from n to n+1, in coordinates.

/// Increments q(n+1) - q(n) of the lateral and the torsional coordinates.
#[derive(Debug, Clone, Default)]
pub(crate) struct Increments {
    /// Increments of the lateral coordinates.
    pub lateral: Vec<f64>,
    /// Increments of the torsional coordinates, of absolute angles.
    pub twist: Vec<f64>,
}

impl Increments {
    /// Zero increments of these sizes.
    pub fn zeros(lateral: usize, twist: usize) -> Self {
        Self { lateral: vec![0.0; lateral], twist: vec![0.0; twist] }
    }

    /// Copies other increments of the same sizes.
    pub fn copy_from(&mut self, other: &Self) {
        self.lateral.copy_from_slice(&other.lateral);
        self.twist.copy_from_slice(&other.twist);
    }
}
