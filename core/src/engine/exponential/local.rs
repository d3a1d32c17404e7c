//! What the whirl states are in one cell of the grid, where all of it is constant.

use super::block::Block;
use super::forms::Rows;
use super::rows::add_both;
use nalgebra::Complex;

#[derive(Debug)]
pub(super) struct Local {
    /// Speed in the cell's middle \[rad/s\].
    pub speed: f64,
    pub blocks: Vec<Block>,
    /// A row on y for each output, and all of them.
    pub rows: Vec<Vec<f64>>,
    pub outputs: Rows,
    /// A vector of y for each force.
    pub pushes: Vec<Vec<f64>>,
    /// Outputs of those of the unbalances.
    pub struck: Vec<Vec<f64>>,
}

impl Local {
    /// Adds impulses of the unbalances on their nodes \[N s\] to y and its outputs.
    pub fn strike(&self, impulses: impl Iterator<Item = Complex<f64>>, y: &mut [f64], seen: &mut [f64]) {
        for (s, impulse) in impulses.enumerate() {
            let parts = [impulse.re, impulse.im];
            add_both(parts, [&self.pushes[2 * s], &self.pushes[2 * s + 1]], y);
            add_both(parts, [&self.struck[2 * s], &self.struck[2 * s + 1]], seen);
        }
    }
}
