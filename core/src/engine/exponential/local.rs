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

    /// y' of y under the unbalances' forces \[N\] and the weight.
    pub fn rates(&self, y: &[f64], forces: &[Complex<f64>], rates: &mut [f64]) {
        let pairs = self.blocks.len();
        rates.copy_from_slice(&self.pushes[2 * forces.len()]);
        for (s, f) in forces.iter().enumerate() {
            let (u, v) = (&self.pushes[2 * s], &self.pushes[2 * s + 1]);
            for ((rate, u), v) in rates.iter_mut().zip(u).zip(v) {
                *rate += u * f.re + v * f.im;
            }
        }
        let ((x, z), (dx, dz)) = (y.split_at(pairs), rates.split_at_mut(pairs));
        for (k, b) in self.blocks.iter().enumerate() {
            dx[k] += b[0] * x[k] + b[1] * z[k];
            dz[k] += b[2] * x[k] + b[3] * z[k];
        }
    }
}
