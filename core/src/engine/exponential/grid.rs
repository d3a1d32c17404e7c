//! The grid of spins: stations where they are visited, and cells between them in which a run goes.
//!
//! ```text
//! station b   at W_b = (b + 1/2) D                        half a spacing off zero, where an isotropic rotor's modes are double
//! cell k      of width D/m, at a share s of the way between its stations:   R(s), B(s), O(s), N(s) linear in s                      (1)
//! from cell to cell   y := X^(1/m) y                                                                                               (2)
//! ```
//! In a cell the blocks are constant, and a run stays in it until it is a sixteenth of a cell beyond (a spin that swings about an edge does not change cells
//! with it; more would hold a falling spin's cells above it). (2) is the slow change of the eigenvectors
//! with the spin, exact from station to station. The error of both is of second order in the cell's width and the spacing: docs/theory/08-exponential-engine.md.
//!
//! Stations are a chain from the one at the initial speed on, upwards and downwards, each aligned with the one before: what a station is does not depend
//! on the way a run takes.

use super::ExponentialError;
use super::block::Block;
use super::station::{Model, Station};
use super::transfer::Transfer;
use crate::linalg::{Matrix, mul, mul_vec};
use std::collections::BTreeMap;

/// Distance from the middle of a cell at which a run leaves it, as a part of its width.
const BEYOND: f64 = 0.5625;

/// Stations and transfers of a model.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub model: Model,
    /// D \[rad/s\].
    spacing: f64,
    /// m.
    cells: i64,
    stations: BTreeMap<i64, Station>,
    /// By the station below.
    transfers: BTreeMap<i64, Transfer>,
}

/// What a run needs in one cell.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    pub index: i64,
    /// Speed in its middle \[rad/s\].
    pub speed: f64,
    pub blocks: Vec<Block>,
    /// A row on y for each output.
    pub rows: Vec<Vec<f64>>,
    /// A vector of y for each force.
    pub pushes: Vec<Vec<f64>>,
    /// Gyroscopic momentum `y^T N y`.
    pub momentum: Matrix,
}

impl Grid {
    /// With a first station below `speed`.
    pub fn new(model: Model, spacing: f64, cells: u32, speed: f64) -> Result<Self, ExponentialError> {
        let mut grid =
            Self { model, spacing, cells: i64::from(cells), stations: BTreeMap::new(), transfers: BTreeMap::new() };
        let first = grid.index_of(speed).div_euclid(grid.cells);
        grid.stations.insert(first, Station::new(&grid.model, grid.speed_of_station(first), None)?);
        Ok(grid)
    }

    /// The cell that has a speed.
    pub fn index_of(&self, speed: f64) -> i64 {
        libm::floor((speed / self.spacing - 0.5) * self.cells as f64) as i64
    }

    /// Whether a run at `speed` has left a cell.
    pub fn has_left(&self, cell: &Cell, speed: f64) -> bool {
        (speed - cell.speed).abs() * self.cells as f64 > BEYOND * self.spacing
    }

    fn speed_of_station(&self, b: i64) -> f64 {
        (b as f64 + 0.5) * self.spacing
    }

    /// Number of stations computed so far, and the largest condition of them.
    pub fn visited(&self) -> (usize, f64) {
        (self.stations.len(), self.stations.values().map(|station| station.condition).fold(1.0, f64::max))
    }

    /// A cell, its stations computed where they are not there yet.
    pub fn cell(&mut self, index: i64) -> Result<Cell, ExponentialError> {
        let (b, j) = (index.div_euclid(self.cells), index.rem_euclid(self.cells));
        self.reach(b)?;
        self.reach(b + 1)?;
        let middle = (j as f64 + 0.5) / self.cells as f64;
        let share = match self.transfers[&b] {
            Transfer::Gradual { .. } => middle,
            Transfer::AtOnce(_) => libm::floor(middle + 0.5),
        };
        let (below, above) = (&self.stations[&b], &self.stations[&(b + 1)]);
        let mixed = |one: &Matrix, other: &Matrix| one * (1.0 - share) + other * share;
        let (rows, pushes) = (mixed(&below.rows, &above.rows), mixed(&below.pushes, &above.pushes));
        let blocks = below.blocks.iter().zip(&above.blocks);
        Ok(Cell {
            index,
            speed: self.speed_of_station(b) + middle * self.spacing,
            blocks: blocks.map(|(x, y)| std::array::from_fn(|i| x[i] * (1.0 - share) + y[i] * share)).collect(),
            rows: rows.row_iter().map(|row| row.iter().copied().collect()).collect(),
            pushes: pushes.column_iter().map(|column| column.iter().copied().collect()).collect(),
            momentum: mixed(&below.momentum, &above.momentum),
        })
    }

    /// y of a state x in a cell that has been computed.
    pub fn amplitudes(&self, cell: &Cell, x: &[f64]) -> Vec<f64> {
        let (b, j) = (cell.index.div_euclid(self.cells), cell.index.rem_euclid(self.cells));
        let (mut y, mut scratch) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        mul_vec(&self.stations[&b].left, x, &mut y);
        if let Some(Transfer::Gradual { half, .. }) = self.transfers.get(&b) {
            mul_vec(&half[0], &y, &mut scratch);
            std::mem::swap(&mut y, &mut scratch);
        }
        for index in b * self.cells..b * self.cells + j {
            self.cross(index, true, &mut y, &mut scratch);
        }
        y
    }

    /// Takes y from a cell to its neighbour above (`up`) or below.
    pub fn cross(&self, index: i64, up: bool, y: &mut Vec<f64>, scratch: &mut Vec<f64>) {
        let mut apply = |matrix: &Matrix| {
            mul_vec(matrix, y, scratch);
            std::mem::swap(y, scratch);
        };
        let side = usize::from(!up);
        let next = if up { index + 1 } else { index - 1 };
        let (from, to) = (index.div_euclid(self.cells), next.div_euclid(self.cells));
        if from != to {
            for b in [from, to] {
                if let Some(Transfer::Gradual { half, .. }) = self.transfers.get(&b) {
                    apply(&half[side]);
                }
            }
            return;
        }
        match self.transfers.get(&from) {
            Some(Transfer::Gradual { whole, .. }) => apply(&whole[side]),
            Some(Transfer::AtOnce(whole)) if 2 * index.max(next).rem_euclid(self.cells) == self.cells => {
                apply(&whole[side]);
            }
            _ => {}
        }
    }

    /// Computes the stations from those that are there to b.
    fn reach(&mut self, b: i64) -> Result<(), ExponentialError> {
        loop {
            let (Some((&lowest, _)), Some((&highest, _))) =
                (self.stations.first_key_value(), self.stations.last_key_value())
            else {
                return Ok(());
            };
            let (neighbour, new) = if b > highest {
                (highest, highest + 1)
            } else if b < lowest {
                (lowest, lowest - 1)
            } else {
                return Ok(());
            };
            let station = Station::new(&self.model, self.speed_of_station(new), self.stations.get(&neighbour))?;
            self.stations.insert(new, station);
            let below = new.min(neighbour);
            let (one, other) = (&self.stations[&below], &self.stations[&(below + 1)]);
            let (up, down) = (mul(&other.left, &one.right), mul(&one.left, &other.right));
            self.transfers.insert(below, Transfer::new(up, down, self.cells));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::exponential::outputs::Outputs;
    use crate::engine::exponential::system::LateralSystem;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;

    /// Whether y of one state, taken from a station to the next cell by cell and back, is y of that state there; and how it went.
    fn carries(spacing: f64) -> bool {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let system = LateralSystem::new(&machine, &structure).expect("regular");
        let size = 2 * system.size;
        let model = Model { system, outputs: Outputs::new(&machine, &structure) };
        let mut grid = Grid::new(model, spacing, 10, 1.6 * spacing).expect("has a basis");
        let x: Vec<f64> = (0..size).map(|i| f64::from(u8::try_from(i * 7 % 11).expect("small")) - 5.0).collect();
        let (below, above) = (grid.cell(10).expect("has bases"), grid.cell(20).expect("has bases"));
        let (mut y, wanted) = (grid.amplitudes(&below, &x), grid.amplitudes(&above, &x));
        let (begun, mut scratch) = (y.clone(), vec![0.0; size]);
        let far = |y: &[f64], z: &[f64]| crate::linalg::distance(y, z) / crate::linalg::norm(z);
        (10..20).for_each(|index| grid.cross(index, true, &mut y, &mut scratch));
        assert!(far(&y, &wanted) < 1e-11, "{spacing}: {:e}", far(&y, &wanted));
        (11..=20).rev().for_each(|index| grid.cross(index, false, &mut y, &mut scratch));
        assert!(far(&y, &begun) < 1e-11, "{spacing}: {:e}", far(&y, &begun));
        matches!(grid.transfers[&1], Transfer::Gradual { .. })
    }

    #[test]
    fn states_are_carried_from_station_to_station_gradually_and_at_once() {
        assert!(carries(2.0), "a small spacing is gone through gradually");
        assert!(!carries(2000.0), "a large one at once");
    }
}
