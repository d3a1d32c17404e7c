//! What a run looks at in the cell it is in, mixed from the tables of its stations as soon as it is asked for.
//!
//! They are the run's own, and written over from cell to cell: the cells of a run have some 50 kB of them each, more in all than a processor keeps near. Mixed anew from two stations, which it
//! does keep, they are there in a fifth of the time (docs/theory/08-exponential-engine.md).
//! Verified by `tables_are_those_of_their_cell`.

use super::eights::{Eights, Mix};
use super::forms::Form;
use super::grid::Cell;
use super::station::Model;
use super::within::Within;

/// One of them, and the cell that it is of.
#[derive(Debug, Clone, Default)]
struct Table<T> {
    cell: Option<i64>,
    mixed: T,
}

impl<T: Mix> Table<T> {
    /// Of a cell by its index and its shares of two stations.
    fn of(&mut self, (cell, shares): (i64, [f64; 2]), stations: [&T; 2]) -> &T {
        if self.cell != Some(cell) {
            self.mixed.mix(stations, shares);
            self.cell = Some(cell);
        }
        &self.mixed
    }
}

/// Those of a run; of cells of one grid, and contact steps of one size.
#[derive(Debug, Clone, Default)]
pub(super) struct Tables {
    momentum: Table<Form>,
    bounds: Table<Eights>,
    bearings: Table<Eights>,
    moments: Table<Eights>,
    places: Table<Eights>,
    rates: Table<Eights>,
    within: Table<Within>,
}

impl Tables {
    /// N, whose form of y is the gyroscopic momentum.
    pub fn momentum(&mut self, cell: &Cell) -> &Form {
        self.momentum.of(cell.place(), cell.stations.each_ref().map(|station| &station.momentum))
    }

    /// [`super::measured::Measured::bounds`].
    pub fn bounds(&mut self, cell: &Cell, model: &Model) -> &Eights {
        self.bounds.of(cell.place(), cell.measured(model).map(|at| &at.bounds))
    }

    /// Of the bearings' motion.
    pub fn bearings(&mut self, cell: &Cell, model: &Model) -> &Eights {
        self.bearings.of(cell.place(), cell.measured(model).map(|at| &at.bearings))
    }

    /// Of bending moments.
    pub fn moments(&mut self, cell: &Cell, model: &Model) -> &Eights {
        self.moments.of(cell.place(), cell.measured(model).map(|at| &at.moments))
    }

    /// q of whirl states.
    pub fn places(&mut self, cell: &Cell, model: &Model) -> &Eights {
        self.places.of(cell.place(), cell.measured(model).map(|at| &at.motion[0]))
    }

    /// q'.
    pub fn rates(&mut self, cell: &Cell, model: &Model) -> &Eights {
        self.rates.of(cell.place(), cell.measured(model).map(|at| &at.motion[1]))
    }

    /// What damping takes over contact steps of `h` \[s\].
    pub fn within(&mut self, cell: &Cell, model: &Model, h: f64) -> &Within {
        self.within.of(cell.place(), cell.stations.each_ref().map(|station| station.within(model, h)))
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
        let mut table = Table::<Eights>::default();
        let rows = [Eights::new(&one), Eights::new(&other)];
        // back and forth between cells, as a spin that swings about an edge
        for (cell, share) in [(7, 0.25), (8, 0.75), (7, 0.25), (7, 0.25), (-3, 0.5)] {
            let shares = [1.0 - share, share];
            let (mut found, mut wanted) = (Vec::new(), Vec::new());
            table.of((cell, shares), [&rows[0], &rows[1]]).times(&y, &mut found);
            Eights::new(&(&one * (1.0 - share) + &other * share)).times(&y, &mut wanted);
            assert_eq!(found.len(), wanted.len());
            assert!(found.iter().zip(&wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{share}");
        }
    }
}
