//! What the whirl states are in one cell of the grid, where all of it is constant.

use super::block::Block;

#[derive(Debug)]
pub(super) struct Local {
    /// Speed in the cell's middle \[rad/s\].
    pub speed: f64,
    pub blocks: Vec<Block>,
    /// A row on y for each output.
    pub rows: Vec<Vec<f64>>,
    /// A vector of y for each force.
    pub pushes: Vec<Vec<f64>>,
}
