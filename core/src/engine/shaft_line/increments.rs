//! Increments of one step, in coordinates.

/// From n to n+1.
#[derive(Debug, Clone, Default)]
pub(crate) struct Increments {
    pub lateral: Vec<f64>,
    /// Of absolute angles.
    pub twist: Vec<f64>,
}

impl Increments {
    /// None, of these sizes.
    pub fn zeros(lateral: usize, twist: usize) -> Self {
        Self { lateral: vec![0.0; lateral], twist: vec![0.0; twist] }
    }

    /// Takes the values of others of the same sizes.
    pub fn copy_from(&mut self, other: &Self) {
        self.lateral.copy_from_slice(&other.lateral);
        self.twist.copy_from_slice(&other.twist);
    }
}
