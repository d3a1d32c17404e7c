//! What the whirl states are in one cell of the grid, where all of it is constant.

use super::block::Block;
use super::forms::{Rows, mixed_list};
use super::rows::add_both;
use super::station::Station;
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
    /// At a speed \[rad/s\] and a share of the way between two stations, under so many unbalances: linear in the share.
    pub fn between(stations: [&Station; 2], share: f64, speed: f64, unbalances: usize) -> Self {
        let times = [1.0 - share, share];
        let lists = |of: &dyn Fn(&Station) -> &[Vec<f64>]| -> Vec<Vec<f64>> {
            let [below, above] = stations.map(of);
            below.iter().zip(above).map(|(below, above)| mixed_list([below, above], times)).collect()
        };
        let pushes = lists(&|station| &station.pushes);
        let outputs = Rows::mixed(stations.map(|station| &station.outputs), times);
        let struck = pushes[..2 * unbalances].iter().map(|push| {
            let mut seen = Vec::new();
            outputs.times(push, &mut seen);
            seen
        });
        let blocks = stations[0].blocks.iter().zip(&stations[1].blocks);
        Self {
            speed,
            blocks: blocks.map(|(x, y)| std::array::from_fn(|i| times[0] * x[i] + times[1] * y[i])).collect(),
            struck: struck.collect(),
            rows: lists(&|station| &station.rows),
            outputs,
            pushes,
        }
    }

    /// Adds impulses of the unbalances on their nodes \[N s\] to y and its outputs.
    pub fn strike(&self, impulses: impl Iterator<Item = Complex<f64>>, y: &mut [f64], seen: &mut [f64]) {
        for (s, impulse) in impulses.enumerate() {
            let parts = [impulse.re, impulse.im];
            add_both(parts, [&self.pushes[2 * s], &self.pushes[2 * s + 1]], y);
            add_both(parts, [&self.struck[2 * s], &self.struck[2 * s + 1]], seen);
        }
    }
}
