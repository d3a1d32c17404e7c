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
//! Stations are a chain from one near the initial speed on, upwards and downwards, each aligned with the one before: what a station is does not depend
//! on the way a run takes, nor on the runs before it.

use super::ExponentialError;
use super::block::size_of;
use super::kick::Kick;
use super::local::Local;
use super::measured::Measured;
use super::outlook::Outlook;
use super::propagator::Propagator;
use super::scale::Scale;
use super::settings::LEVELS;
use super::station::{Model, Station};
use super::transfer::Transfer;
use super::within::{Kept, Within};
use crate::linalg::{Matrix, Vector, axpy, lanes, mul, solve};
use crate::modal::{Damping, DampingGrid};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Distance from the middle of a cell at which a run leaves it, as a part of its width.
const BEYOND: f64 = 0.5625;
/// How far a grid goes from where its chain begins, upwards and downwards, in spacings: with the default one up to four times the initial speed. What other runs have visited is not
/// counted. A spin that jumps by [`LEAP`] of them in a step has left every model.
const MOST: f64 = 128.0;
const LEAP: f64 = 48.0;
/// A load may jump from cell to cell by this part of the largest that slow motions make: the jump is not seen (`finish` in `flight.rs`), what is left of it is (1.5e-3 of the rig's load at 0.3, 2 % at 0.7).
const JUMP: f64 = 0.25;
/// Rounding of a node's rate beside that of the fastest coordinate.
const ROUNDING: f64 = 1e-14;
/// Slow motions are those of one pair of so many.
const SLOWEST: usize = 2;
/// Cells that are kept for other runs, at most: some 25 kB each with 24 pairs (what is looked at is mixed by each run: [`super::tables`]). They are kept from the second run on, where each run has masses of its own there is no
/// other; before, as many as a spin that swings about an edge, or a history, comes back to.
const KEPT: usize = 2048;
const LAST: usize = 2;

/// Stations, transfers and cells of a model, for steps of one size: runs share it, and each finds in it what it would have found alone.
#[derive(Debug)]
pub(super) struct Grid {
    pub model: Model,
    scale: Scale,
    /// m.
    cells: i64,
    /// The station at which the chain begins.
    first: i64,
    /// Cells are kept.
    keeps: AtomicBool,
    found: Mutex<Found>,
}

/// What runs have come to so far.
#[derive(Debug, Default)]
struct Found {
    stations: BTreeMap<i64, Arc<Station>>,
    /// By the station below.
    transfers: BTreeMap<i64, Arc<Transfer>>,
    cells: BTreeMap<i64, Arc<Cell>>,
}

/// What a run needs in one cell.
#[derive(Debug)]
pub(super) struct Cell {
    pub index: i64,
    /// How far its stations are apart \[rad/s\].
    apart: f64,
    pub local: Local,
    share: f64,
    pub stations: [Arc<Station>; 2],
    transfer: Arc<Transfer>,
    unbalances: usize,
    propagators: [OnceLock<Propagator>; LEVELS + 1],
    /// Of the first diaphragm's node: where its rows and pushes begin, and those of the bearings' loads.
    contact: Option<(usize, usize, Vec<usize>)>,
    /// First rows of what is watched for peaks: the bearings' loads, the place of the first diaphragm's node.
    watched: Vec<usize>,
    kick: OnceLock<Kick>,
    outlook: OnceLock<Outlook>,
    kept: OnceLock<Kept>,
}

impl Cell {
    /// What a step of `2^level` contact steps of `h` \[s\] makes.
    pub fn propagator(&self, level: usize, h: f64) -> &Propagator {
        self.propagators[level]
            .get_or_init(|| Propagator::new(&self.local, self.unbalances, h * libm::exp2(level as f64)))
    }

    /// What impulses on the first diaphragm's node make over a contact step of `h` \[s\]; `None` without one.
    pub fn kick(&self, h: f64) -> Option<&Kick> {
        let (row, push, loads) = self.contact.as_ref()?;
        Some(self.kick.get_or_init(|| Kick::new(&self.local, self.propagator(0, h), h, *row, *push, loads)))
    }

    /// What forces keep of its states over contact steps of `h` \[s\], by what damping takes there ([`super::within`]).
    pub fn kept(&self, within: &Within, h: f64) -> &Kept {
        self.kept.get_or_init(|| Kept::new(&self.local, within, h, self.unbalances))
    }

    /// States behind an impulse on the first diaphragm's node, along the machine's axes, of those before.
    pub fn strike(&self, [u, v]: [f64; 2], y: &mut [f64]) {
        if let Some((_, push, _)) = self.contact {
            axpy(u, &self.local.pushes[push], y);
            axpy(v, &self.local.pushes[push + 1], y);
        }
    }

    /// What flights in contact steps of `h` \[s\] see.
    pub fn outlook(&self, h: f64) -> &Outlook {
        self.outlook.get_or_init(|| Outlook::new(&self.local, &self.watched, self.unbalances, h))
    }

    /// What is measured at its stations.
    pub fn measured(&self, model: &Model) -> [&Measured; 2] {
        self.stations.each_ref().map(|station| station.measured(model))
    }

    /// Its index, and how much of each station it is.
    pub fn place(&self) -> (i64, [f64; 2]) {
        (self.index, [1.0 - self.share, self.share])
    }

    /// y of a motion (q, q'), `None` where there is none.
    pub fn state_of(&self, motion: &[f64]) -> Option<Vec<f64>> {
        let [below, above] = &self.stations;
        let whole = &below.motion * (1.0 - self.share) + &above.motion * self.share;
        Some(solve(&whole, &Vector::from_column_slice(motion))?.as_slice().to_vec())
    }
}

/// Damping at the stations of a grid, as a run in one cell sees it.
pub(super) struct CellDamping<'a> {
    grid: &'a Grid,
    /// The station below the cell.
    below: i64,
    stations: &'a [Arc<Station>; 2],
}

impl CellDamping<'_> {
    /// Speeds of the stations of the cell \[rad/s\].
    pub fn speeds(&self) -> [f64; 2] {
        self.stations.each_ref().map(|station| station.local.speed)
    }
}

impl DampingGrid for CellDamping<'_> {
    fn speed(&self, b: i64) -> f64 {
        self.grid.scale.speed(b)
    }

    fn below(&self, speed: f64) -> i64 {
        self.grid.scale.below(speed)
    }

    /// A run computes the stations on both sides of every speed that it visits, before it asks.
    fn least(&self, b: i64) -> Option<Damping> {
        let beside = usize::try_from(b - self.below).ok().and_then(|at| self.stations.get(at));
        beside.map_or_else(|| self.grid.least_damping(b), |station| station.least)
    }
}

impl Grid {
    /// With its first station near `speed`: the same one for all speeds about it.
    pub fn new(model: Model, scale: Scale, cells: u32, speed: f64) -> Result<Self, ExponentialError> {
        let first = scale.anchor(speed);
        let keeps = AtomicBool::new(false);
        let grid = Self { model, scale, cells: i64::from(cells), first, keeps, found: Mutex::default() };
        let station = Station::new(&grid.model, grid.scale.speed(first), None)?;
        grid.found.lock().unwrap_or_else(PoisonError::into_inner).stations.insert(first, Arc::new(station));
        Ok(grid)
    }

    /// Damping as a run in a cell sees it.
    pub fn damping<'a>(&'a self, cell: &'a Cell) -> CellDamping<'a> {
        CellDamping { grid: self, below: cell.index.div_euclid(self.cells), stations: &cell.stations }
    }

    fn least_damping(&self, b: i64) -> Option<Damping> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).stations.get(&b).and_then(|station| station.least)
    }

    /// Keeps cells from now on, for other runs.
    pub fn keep(&self) {
        self.keeps.store(true, Ordering::Relaxed);
    }

    /// The cell that has a speed.
    pub fn index_of(&self, speed: f64) -> i64 {
        self.scale.cell_of(speed, self.cells)
    }

    /// Whether a run at `speed` has left a cell.
    pub fn has_left(&self, cell: &Cell, speed: f64) -> bool {
        (speed - cell.local.speed).abs() * self.cells as f64 > BEYOND * cell.apart
    }

    /// Whether a spin is too far from a cell for a way there.
    pub fn leaps(&self, cell: &Cell, speed: f64) -> bool {
        (speed - cell.local.speed).abs() > LEAP * self.scale.spacing
    }

    /// Number of stations computed so far, and a bound of the condition of them.
    pub fn visited(&self) -> (usize, f64) {
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        (found.stations.len(), found.stations.values().map(|station| station.condition).fold(1.0, f64::max))
    }

    /// A cell, its stations computed where they are not there yet.
    pub fn cell(&self, index: i64) -> Result<Arc<Cell>, ExponentialError> {
        let found = &mut *self.found.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(cell) = found.cells.get(&index) {
            return Ok(Arc::clone(cell));
        }
        let (b, j) = (index.div_euclid(self.cells), index.rem_euclid(self.cells));
        self.reach(found, b)?;
        self.reach(found, b + 1)?;
        let middle = (j as f64 + 0.5) / self.cells as f64;
        let transfer = Arc::clone(&found.transfers[&b]);
        let share = match *transfer {
            Transfer::Gradual { .. } => middle,
            Transfer::AtOnce(_) => libm::floor(middle + 0.5),
        };
        let (below, above) = (&found.stations[&b], &found.stations[&(b + 1)]);
        let outputs = &self.model.outputs;
        let apart = self.scale.apart(b);
        let speed = self.scale.speed(b) + middle * apart;
        let cell = Arc::new(Cell {
            index,
            apart,
            local: Local::between([&below.local, &above.local], [1.0 - share, share], speed),
            share,
            stations: [Arc::clone(below), Arc::clone(above)],
            transfer,
            unbalances: outputs.unbalances(),
            propagators: Default::default(),
            contact: outputs.has_contact().then(|| (outputs.contact(0), outputs.contact_push(0), outputs.loads())),
            watched: outputs.loads().into_iter().chain(outputs.has_contact().then(|| outputs.contact(0))).collect(),
            kick: OnceLock::new(),
            outlook: OnceLock::new(),
            kept: OnceLock::new(),
        });
        let keeps = self.keeps.load(Ordering::Relaxed);
        if !keeps && found.cells.len() >= LAST {
            found.cells.clear();
        }
        if found.cells.len() < KEPT {
            found.cells.insert(index, Arc::clone(&cell));
        }
        Ok(cell)
    }

    /// Takes y from a cell to its neighbour.
    pub fn cross(&self, from: &Cell, to: &Cell, y: &mut Vec<f64>, scratch: &mut Vec<f64>) {
        let mut apply = |matrix: &Matrix| {
            lanes::product([matrix.nrows(), matrix.ncols(), 1], matrix.as_slice(), y, scratch);
            std::mem::swap(y, scratch);
        };
        let side = usize::from(to.index < from.index);
        if from.index.div_euclid(self.cells) != to.index.div_euclid(self.cells) {
            for cell in [from, to] {
                if let Transfer::Gradual { half, .. } = &*cell.transfer {
                    apply(&half[side]);
                }
            }
            return;
        }
        match &*from.transfer {
            Transfer::Gradual { whole, .. } => apply(&whole[side]),
            Transfer::AtOnce(whole) if 2 * from.index.max(to.index).rem_euclid(self.cells) == self.cells => {
                apply(&whole[side]);
            }
            Transfer::AtOnce(_) => {}
        }
    }

    /// Whether a bearing's load is not known between two stations: from cell to cell (at once: for as much of the spin), or by rounding, it would jump by more than [`JUMP`] of the largest load
    /// that slow motions of one energy make. The node of a bearing that is damped strongly hardly moves, and its load is the damping times what rounding and cells leave of that.
    fn loses_loads(&self, transfer: &Transfer, [one, other]: [&Station; 2]) -> bool {
        let mixed = |share: f64| &one.rows * (1.0 - share) + &other.rows * share;
        let cells = self.cells as f64;
        let (here, there, at_once) = match transfer {
            Transfer::Gradual { whole, .. } => {
                let half = 0.5 / cells;
                (mixed(0.5 - half), mul(&mixed(0.5 + half), &whole[0]), 1.0)
            }
            Transfer::AtOnce([up, _]) => (one.rows.clone(), mul(&other.rows, up), cells),
        };
        let (slow, fastest) = (slow_states(one), one.motion.rows(one.blocks.len(), one.blocks.len()).amax());
        let (mut jump, mut largest) = (0.0_f64, 0.0_f64);
        for (bearing, first) in self.model.outputs.loads().into_iter().enumerate() {
            jump = jump.max(ROUNDING * fastest * self.model.outputs.of_velocity(bearing));
            for (&state, row) in slow.iter().flat_map(|state| [(state, first), (state, first + 1)]) {
                jump = jump.max((here[(row, state)] - there[(row, state)]).abs() / at_once);
                largest = largest.max(here[(row, state)].abs());
            }
        }
        jump > JUMP * largest
    }

    /// Computes the stations from those that are there to b.
    fn reach(&self, found: &mut Found, b: i64) -> Result<(), ExponentialError> {
        loop {
            let (Some((&lowest, _)), Some((&highest, _))) =
                (found.stations.first_key_value(), found.stations.last_key_value())
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
            if (self.scale.speed(new) - self.scale.speed(self.first)).abs() > MOST * self.scale.spacing {
                return Err(ExponentialError::NoBasis { speed: self.scale.speed(new) });
            }
            let beside = found.stations.get(&neighbour).map(|station| &**station);
            let station = Station::new(&self.model, self.scale.speed(new), beside)?;
            let (below, near) = (new.min(neighbour), &*found.stations[&neighbour]);
            let (one, other) = if new < neighbour { (&station, near) } else { (near, &station) };
            let (up, down) = (mul(&other.left, &one.right), mul(&one.left, &other.right));
            let transfer = Transfer::new(up, down, self.cells);
            if self.loses_loads(&transfer, [one, other]) {
                return Err(ExponentialError::NoBasis { speed: self.scale.speed(new) });
            }
            found.stations.insert(new, Arc::new(station));
            found.transfers.insert(below, Arc::new(transfer));
        }
    }
}

/// States of the slowest pairs, [`SLOWEST`] of all.
fn slow_states(station: &Station) -> Vec<usize> {
    let size = station.blocks.len();
    let mut pairs: Vec<usize> = (0..size).collect();
    pairs.sort_by(|&one, &other| size_of(&station.blocks[one]).total_cmp(&size_of(&station.blocks[other])));
    pairs.truncate(size.div_ceil(SLOWEST));
    pairs.into_iter().flat_map(|k| [k, size + k]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::exponential::measured::Measures;
    use crate::engine::exponential::outputs::Outputs;
    use crate::engine::exponential::system::LateralSystem;
    use crate::engine::exponential::tables::Tables;
    use crate::engine::exponential::within::Room;
    use crate::linalg::mul_vec;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;
    use nalgebra::Complex;

    /// y of a state x in a cell, by the left vectors of the station below it.
    fn amplitudes(grid: &Grid, cell: &Cell, x: &[f64]) -> Vec<f64> {
        let j = cell.index.rem_euclid(grid.cells);
        let (mut y, mut scratch) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        mul_vec(&cell.stations[0].left, x, &mut y);
        if let Transfer::Gradual { half, .. } = &*cell.transfer {
            mul_vec(&half[0], &y, &mut scratch);
            std::mem::swap(&mut y, &mut scratch);
        }
        let mut from = grid.cell(cell.index - j).expect("has bases");
        while from.index < cell.index {
            let next = grid.cell(from.index + 1).expect("has bases");
            grid.cross(&from, &next, &mut y, &mut scratch);
            from = next;
        }
        y
    }

    /// Whether y of one state, taken from a station to the next cell by cell and back, is y of that state there; and how it went.
    fn carries(spacing: f64) -> bool {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let system = LateralSystem::new(&machine, &structure).expect("regular");
        let size = 2 * system.size;
        let outputs = Outputs::new(&machine, &structure);
        let measures = Measures::new(&machine, &structure, &system, outputs.weight());
        let model = Model { system, outputs, measures };
        let grid = Grid::new(model, Scale { spacing, closes: false }, 10, 1.6 * spacing).expect("has a basis");
        let x: Vec<f64> = (0..size).map(|i| f64::from(u8::try_from(i * 7 % 11).expect("small")) - 5.0).collect();
        let (below, above) = (grid.cell(10).expect("has bases"), grid.cell(20).expect("has bases"));
        let (mut y, wanted) = (amplitudes(&grid, &below, &x), amplitudes(&grid, &above, &x));
        let (begun, mut scratch) = (y.clone(), vec![0.0; size]);
        let far = |y: &[f64], z: &[f64]| crate::linalg::distance(y, z) / crate::linalg::norm(z);
        let cells: Vec<_> = (10..=20).map(|index| grid.cell(index).expect("has bases")).collect();
        cells.windows(2).for_each(|pair| grid.cross(&pair[0], &pair[1], &mut y, &mut scratch));
        assert!(far(&y, &wanted) < 1e-11, "{spacing}: {:e}", far(&y, &wanted));
        cells.windows(2).rev().for_each(|pair| grid.cross(&pair[1], &pair[0], &mut y, &mut scratch));
        assert!(far(&y, &begun) < 1e-11, "{spacing}: {:e}", far(&y, &begun));
        matches!(*below.transfer, Transfer::Gradual { .. })
    }

    #[test]
    fn between_stations_it_is_linear() {
        let path = format!("{}/../studies/machines/lp_turbine.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let grid = |spacing: f64, cells: u32| {
            let system = LateralSystem::new(&machine, &structure).expect("regular");
            let outputs = Outputs::new(&machine, &structure);
            let measures = Measures::new(&machine, &structure, &system, outputs.weight());
            Grid::new(Model { system, outputs, measures }, Scale { spacing, closes: false }, cells, 140.0)
                .expect("has a basis")
        };
        // the same cells between stations, and between ones four times as close
        let (grid, close) = (grid(4.2, 40), grid(1.05, 10));
        let h = 27e-6;
        for speed in [131.0, 133.7, 136.2] {
            let [far, near] = [&grid, &close].map(|grid| grid.cell(grid.index_of(speed)).expect("has bases"));
            for impulse in [[1.0, 0.0], [0.0, 1.0], [1.0, -0.7]] {
                let [found, wanted] = [(&grid, &far), (&close, &near)].map(|(grid, cell)| {
                    let mut y = vec![0.0; 2 * grid.model.system.size];
                    cell.strike(impulse, &mut y);
                    let forces = [Complex::default()];
                    let mut tables = Tables::default();
                    let within = tables.within(cell, &grid.model, h);
                    within.power(cell.kept(within, h), h, &y, &forces, &mut Room::default())
                });
                assert!(wanted > 0.0 && (found - wanted).abs() < 1e-3 * wanted, "{speed}: {found:e} {wanted:e}");
            }
        }
    }

    #[test]
    fn states_are_carried_from_station_to_station_gradually_and_at_once() {
        assert!(carries(2.0), "a small spacing is gone through gradually");
        assert!(!carries(2000.0), "a large one at once");
    }
}
