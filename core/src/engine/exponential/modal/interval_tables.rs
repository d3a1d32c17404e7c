//! What a run looks at in the cell it is in, mixed from the tables of its stations as soon as it is asked for.
//!
//! They are the run's own, and written over from cell to cell: the cells of a run have some 50 kB of them each, more in all than a processor keeps near. Mixed anew from two stations, which it
//! does keep, they are there in a fifth of the time (docs/theory/08-exponential-engine.md).
//! Verified by `tables_are_those_of_their_cell`.

use super::dissipation::Dissipation;
use super::modal_basis::LateralModel;
use super::quadratic_form::QuadraticForm;
use super::row_batch::{Interpolate, RowBatch};
use super::speed_interval::SpeedInterval;

/// One of them, and the cell that it is of.
#[derive(Debug, Clone, Default)]
struct Interpolated<T> {
    cell: Option<i64>,
    value: T,
}

impl<T: Interpolate> Interpolated<T> {
    /// Of a cell by its index and its shares of two stations.
    fn of(&mut self, (cell, shares): (i64, [f64; 2]), bases: [&T; 2]) -> &T {
        if self.cell != Some(cell) {
            self.value.interpolate(bases, shares);
            self.cell = Some(cell);
        }
        &self.value
    }
}

/// Those of a run; of cells of one grid, and contact steps of one size.
#[derive(Debug, Clone, Default)]
pub(crate) struct IntervalTables {
    momentum: Interpolated<QuadraticForm>,
    bounds: Interpolated<RowBatch>,
    bearings: Interpolated<RowBatch>,
    moments: Interpolated<RowBatch>,
    displacements: Interpolated<RowBatch>,
    velocities: Interpolated<RowBatch>,
    dissipation: Interpolated<Dissipation>,
}

impl IntervalTables {
    /// N, whose form of y is the gyroscopic momentum.
    pub fn momentum(&mut self, cell: &SpeedInterval) -> &QuadraticForm {
        self.momentum.of(cell.interpolation(), cell.bases.each_ref().map(|station| &station.gyroscopic_momentum))
    }

    /// [`super::measured::Measured::bounds`].
    pub fn bounds(&mut self, cell: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.bounds.of(cell.interpolation(), cell.section_loads(model).map(|at| &at.bounds))
    }

    /// Of the bearings' motion.
    pub fn bearings(&mut self, cell: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.bearings.of(cell.interpolation(), cell.section_loads(model).map(|at| &at.bearings))
    }

    /// Of bending moments.
    pub fn moments(&mut self, cell: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.moments.of(cell.interpolation(), cell.section_loads(model).map(|at| &at.moments))
    }

    /// q of whirl states.
    pub fn displacements(&mut self, cell: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.displacements.of(cell.interpolation(), cell.section_loads(model).map(|at| &at.motion[0]))
    }

    /// q'.
    pub fn velocities(&mut self, cell: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.velocities.of(cell.interpolation(), cell.section_loads(model).map(|at| &at.motion[1]))
    }

    /// What damping takes over contact steps of `h` \[s\].
    pub fn dissipation(&mut self, cell: &SpeedInterval, model: &LateralModel, h: f64) -> &Dissipation {
        self.dissipation.of(cell.interpolation(), cell.bases.each_ref().map(|station| station.dissipation(model, h)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;

    #[test]
    fn tables_are_those_of_their_cell() {
        let value = |i: usize, j: usize| ((i * 7 + j * 3) % 11) as f64 - 4.0;
        let [one, other] = [0, 5].map(|n| Matrix::from_fn(13, 9, |i, j| value(i + n, j)));
        let y: Vec<f64> = (0..9).map(|i| value(i, 2)).collect();
        let mut table = Interpolated::<RowBatch>::default();
        let rows = [RowBatch::new(&one), RowBatch::new(&other)];
        // back and forth between cells, as a spin that swings about an edge
        for (cell, share) in [(7, 0.25), (8, 0.75), (7, 0.25), (7, 0.25), (-3, 0.5)] {
            let shares = [1.0 - share, share];
            let (mut found, mut wanted) = (Vec::new(), Vec::new());
            table.of((cell, shares), [&rows[0], &rows[1]]).multiply(&y, &mut found);
            RowBatch::new(&(&one * (1.0 - share) + &other * share)).multiply(&y, &mut wanted);
            assert_eq!(found.len(), wanted.len());
            assert!(found.iter().zip(&wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{share}");
        }
    }
}
