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

use super::basis_change::BasisChange;
use super::dissipation::{Dissipation, ForcedDissipation};
use super::grid_spacing::GridSpacing;
use super::impulse_response::ImpulseResponse;
use super::interval_model::IntervalModel;
use super::modal_basis::{LateralModel, ModalBasis};
use super::plane_block::block_norm;
use super::propagator::Propagator;
use super::section_loads::SectionLoads;
use super::step_bounds::StepBounds;
use crate::engine::exponential::error::ExponentialError;
use crate::engine::exponential::settings::MAX_DOUBLINGS;
use crate::linalg::{Matrix, Vector, axpy, lanes, mul, solve};
use crate::modal::{Damping, DampingGrid};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Distance from the middle of a cell at which a run leaves it, as a part of its width.
const LEAVE_DISTANCE: f64 = 0.5625;
/// How far a grid goes from where its chain begins, upwards and downwards, in spacings: with the default one up to four times the initial speed. What other runs have visited is not
/// counted. A spin that jumps by [`LEAP`] of them in a step has left every model.
const MAX_BASES: f64 = 128.0;
const MAX_SPEED_JUMP: f64 = 48.0;
/// A load may jump from cell to cell by this part of the largest that slow motions make: the jump is not seen (`finish` in `flight.rs`), what is left of it is (1.5e-3 of the rig's load at 0.3, 2 % at 0.7).
const MAX_LOAD_JUMP: f64 = 0.25;
/// Rounding of a node's rate beside that of the fastest coordinate.
const ROUNDING: f64 = 1e-14;
/// Slow motions are those of one pair of so many.
const SLOW_SHARE: usize = 2;
/// Cells that are kept for other runs, at most: some 25 kB each with 24 pairs (what is looked at is mixed by each run: [`super::tables`]). They are kept from the second run on, where each run has masses of its own there is no
/// other; before, as many as a spin that swings about an edge, or a history, comes back to.
const MAX_KEPT_INTERVALS: usize = 2048;
const RECENT_INTERVALS: usize = 2;

/// Stations, transfers and cells of a model, for steps of one size: runs share it, and each finds in it what it would have found alone.
#[derive(Debug)]
pub(crate) struct SpeedGrid {
    pub model: LateralModel,
    scale: GridSpacing,
    /// m.
    cells: i64,
    /// The station at which the chain begins.
    first: i64,
    /// Cells are kept.
    keeps_intervals: AtomicBool,
    computed: Mutex<Computed>,
}

/// What runs have come to so far.
#[derive(Debug, Default)]
struct Computed {
    bases: BTreeMap<i64, Arc<ModalBasis>>,
    /// By the station below.
    basis_changes: BTreeMap<i64, Arc<BasisChange>>,
    cells: BTreeMap<i64, Arc<SpeedInterval>>,
}

/// What a run needs in one cell.
#[derive(Debug)]
pub(crate) struct SpeedInterval {
    pub index: i64,
    /// How far its stations are apart \[rad/s\].
    basis_spacing: f64,
    pub model: IntervalModel,
    share: f64,
    pub stations: [Arc<ModalBasis>; 2],
    basis_change: Arc<BasisChange>,
    unbalances: usize,
    propagators: [OnceLock<Propagator>; MAX_DOUBLINGS + 1],
    /// Of the first diaphragm's node: where its rows and pushes begin, and those of the bearings' loads.
    contact: Option<(usize, usize, Vec<usize>)>,
    /// First rows of what is watched for peaks: the bearings' loads, the place of the first diaphragm's node.
    watched: Vec<usize>,
    impulse_response: OnceLock<ImpulseResponse>,
    step_bounds: OnceLock<StepBounds>,
    forced_dissipation: OnceLock<ForcedDissipation>,
}

impl SpeedInterval {
    /// What a step of `2^level` contact steps of `h` \[s\] makes.
    pub fn propagator(&self, level: usize, h: f64) -> &Propagator {
        self.propagators[level]
            .get_or_init(|| Propagator::new(&self.model, self.unbalances, h * libm::exp2(level as f64)))
    }

    /// What impulses on the first diaphragm's node make over a contact step of `h` \[s\]; `None` without one.
    pub fn impulse_response(&self, h: f64) -> Option<&ImpulseResponse> {
        let (row, push, loads) = self.contact.as_ref()?;
        Some(
            self.impulse_response
                .get_or_init(|| ImpulseResponse::new(&self.model, self.propagator(0, h), h, *row, *push, loads)),
        )
    }

    /// What forces keep of its states over contact steps of `h` \[s\], by what damping takes there ([`super::within`]).
    pub fn forced_dissipation(&self, within: &Dissipation, h: f64) -> &ForcedDissipation {
        self.forced_dissipation.get_or_init(|| ForcedDissipation::new(&self.model, within, h, self.unbalances))
    }

    /// States behind an impulse on the first diaphragm's node, along the machine's axes, of those before.
    pub fn apply_contact_impulse(&self, [u, v]: [f64; 2], y: &mut [f64]) {
        if let Some((_, push, _)) = self.contact {
            axpy(u, &self.model.input_vectors[push], y);
            axpy(v, &self.model.input_vectors[push + 1], y);
        }
    }

    /// What flights in contact steps of `h` \[s\] see.
    pub fn step_bounds(&self, h: f64) -> &StepBounds {
        self.step_bounds.get_or_init(|| StepBounds::new(&self.model, &self.watched, self.unbalances, h))
    }

    /// What is measured at its stations.
    pub fn section_loads(&self, model: &LateralModel) -> [&SectionLoads; 2] {
        self.stations.each_ref().map(|station| station.section_loads(model))
    }

    /// Its index, and how much of each station it is.
    pub fn place(&self) -> (i64, [f64; 2]) {
        (self.index, [1.0 - self.share, self.share])
    }

    /// y of a motion (q, q'), `None` where there is none.
    pub fn state_of(&self, motion: &[f64]) -> Option<Vec<f64>> {
        let [below, above] = &self.stations;
        let whole = &below.motion_of_state * (1.0 - self.share) + &above.motion_of_state * self.share;
        Some(solve(&whole, &Vector::from_column_slice(motion))?.as_slice().to_vec())
    }
}

/// Damping at the stations of a grid, as a run in one cell sees it.
pub(crate) struct CellDamping<'a> {
    grid: &'a SpeedGrid,
    /// The station below the cell.
    below: i64,
    stations: &'a [Arc<ModalBasis>; 2],
}

impl CellDamping<'_> {
    /// Speeds of the stations of the cell \[rad/s\].
    pub fn speeds(&self) -> [f64; 2] {
        self.stations.each_ref().map(|station| station.interval_model.speed)
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
        beside.map_or_else(|| self.grid.least_damping(b), |station| station.least_damping)
    }
}

impl SpeedGrid {
    /// With its first station near `speed`: the same one for all speeds about it.
    pub fn new(model: LateralModel, scale: GridSpacing, cells: u32, speed: f64) -> Result<Self, ExponentialError> {
        let first = scale.anchor(speed);
        let keeps = AtomicBool::new(false);
        let grid =
            Self { model, scale, cells: i64::from(cells), first, keeps_intervals: keeps, computed: Mutex::default() };
        let station = ModalBasis::new(&grid.model, grid.scale.speed(first), None)?;
        grid.computed.lock().unwrap_or_else(PoisonError::into_inner).bases.insert(first, Arc::new(station));
        Ok(grid)
    }

    /// Damping as a run in a cell sees it.
    pub fn damping<'a>(&'a self, cell: &'a SpeedInterval) -> CellDamping<'a> {
        CellDamping { grid: self, below: cell.index.div_euclid(self.cells), stations: &cell.stations }
    }

    fn least_damping(&self, b: i64) -> Option<Damping> {
        self.computed
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .bases
            .get(&b)
            .and_then(|station| station.least_damping)
    }

    /// Keeps cells from now on, for other runs.
    pub fn keep_intervals(&self) {
        self.keeps_intervals.store(true, Ordering::Relaxed);
    }

    /// The cell that has a speed.
    pub fn index_of(&self, speed: f64) -> i64 {
        self.scale.cell_of(speed, self.cells)
    }

    /// Whether a run at `speed` has left a cell.
    pub fn has_left(&self, cell: &SpeedInterval, speed: f64) -> bool {
        (speed - cell.model.speed).abs() * self.cells as f64 > LEAVE_DISTANCE * cell.basis_spacing
    }

    /// Whether a spin is too far from a cell for a way there.
    pub fn jumps_too_far(&self, cell: &SpeedInterval, speed: f64) -> bool {
        (speed - cell.model.speed).abs() > MAX_SPEED_JUMP * self.scale.spacing
    }

    /// Number of stations computed so far, and a bound of the condition of them.
    pub fn visited_bases(&self) -> (usize, f64) {
        let found = self.computed.lock().unwrap_or_else(PoisonError::into_inner);
        (found.bases.len(), found.bases.values().map(|station| station.condition).fold(1.0, f64::max))
    }

    /// A cell, its stations computed where they are not there yet.
    pub fn interval(&self, index: i64) -> Result<Arc<SpeedInterval>, ExponentialError> {
        let found = &mut *self.computed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(cell) = found.cells.get(&index) {
            return Ok(Arc::clone(cell));
        }
        let (b, j) = (index.div_euclid(self.cells), index.rem_euclid(self.cells));
        self.compute_basis(found, b)?;
        self.compute_basis(found, b + 1)?;
        let middle = (j as f64 + 0.5) / self.cells as f64;
        let transfer = Arc::clone(&found.basis_changes[&b]);
        let share = match *transfer {
            BasisChange::Gradual { .. } => middle,
            BasisChange::AtOnce(_) => libm::floor(middle + 0.5),
        };
        let (below, above) = (&found.bases[&b], &found.bases[&(b + 1)]);
        let outputs = &self.model.outputs;
        let apart = self.scale.distance(b);
        let speed = self.scale.speed(b) + middle * apart;
        let cell = Arc::new(SpeedInterval {
            index,
            basis_spacing: apart,
            model: IntervalModel::between([&below.interval_model, &above.interval_model], [1.0 - share, share], speed),
            share,
            stations: [Arc::clone(below), Arc::clone(above)],
            basis_change: transfer,
            unbalances: outputs.unbalances(),
            propagators: Default::default(),
            contact: outputs
                .has_contact()
                .then(|| (outputs.contact_row(0), outputs.contact_input(0), outputs.load_rows())),
            watched: outputs
                .load_rows()
                .into_iter()
                .chain(outputs.has_contact().then(|| outputs.contact_row(0)))
                .collect(),
            impulse_response: OnceLock::new(),
            step_bounds: OnceLock::new(),
            forced_dissipation: OnceLock::new(),
        });
        let keeps = self.keeps_intervals.load(Ordering::Relaxed);
        if !keeps && found.cells.len() >= RECENT_INTERVALS {
            found.cells.clear();
        }
        if found.cells.len() < MAX_KEPT_INTERVALS {
            found.cells.insert(index, Arc::clone(&cell));
        }
        Ok(cell)
    }

    /// Takes y from a cell to its neighbour.
    pub fn change_basis(&self, from: &SpeedInterval, to: &SpeedInterval, y: &mut Vec<f64>, scratch: &mut Vec<f64>) {
        let mut apply = |matrix: &Matrix| {
            lanes::product([matrix.nrows(), matrix.ncols(), 1], matrix.as_slice(), y, scratch);
            std::mem::swap(y, scratch);
        };
        let side = usize::from(to.index < from.index);
        if from.index.div_euclid(self.cells) != to.index.div_euclid(self.cells) {
            for cell in [from, to] {
                if let BasisChange::Gradual { half, .. } = &*cell.basis_change {
                    apply(&half[side]);
                }
            }
            return;
        }
        match &*from.basis_change {
            BasisChange::Gradual { whole, .. } => apply(&whole[side]),
            BasisChange::AtOnce(whole) if 2 * from.index.max(to.index).rem_euclid(self.cells) == self.cells => {
                apply(&whole[side]);
            }
            BasisChange::AtOnce(_) => {}
        }
    }

    /// Whether a bearing's load is not known between two stations: from cell to cell (at once: for as much of the spin), or by rounding, it would jump by more than [`JUMP`] of the largest load
    /// that slow motions of one energy make. The node of a bearing that is damped strongly hardly moves, and its load is the damping times what rounding and cells leave of that.
    fn loses_bearing_loads(&self, transfer: &BasisChange, [one, other]: [&ModalBasis; 2]) -> bool {
        let mixed = |share: f64| &one.output_rows * (1.0 - share) + &other.output_rows * share;
        let cells = self.cells as f64;
        let (here, there, at_once) = match transfer {
            BasisChange::Gradual { whole, .. } => {
                let half = 0.5 / cells;
                (mixed(0.5 - half), mul(&mixed(0.5 + half), &whole[0]), 1.0)
            }
            BasisChange::AtOnce([up, _]) => (one.output_rows.clone(), mul(&other.output_rows, up), cells),
        };
        let (slow, fastest) = (slow_states(one), one.motion_of_state.rows(one.blocks.len(), one.blocks.len()).amax());
        let (mut jump, mut largest) = (0.0_f64, 0.0_f64);
        for (bearing, first) in self.model.outputs.load_rows().into_iter().enumerate() {
            jump = jump.max(ROUNDING * fastest * self.model.outputs.of_velocity(bearing));
            for (&state, row) in slow.iter().flat_map(|state| [(state, first), (state, first + 1)]) {
                jump = jump.max((here[(row, state)] - there[(row, state)]).abs() / at_once);
                largest = largest.max(here[(row, state)].abs());
            }
        }
        jump > MAX_LOAD_JUMP * largest
    }

    /// Computes the stations from those that are there to b.
    fn compute_basis(&self, found: &mut Computed, b: i64) -> Result<(), ExponentialError> {
        loop {
            let (Some((&lowest, _)), Some((&highest, _))) =
                (found.bases.first_key_value(), found.bases.last_key_value())
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
            if (self.scale.speed(new) - self.scale.speed(self.first)).abs() > MAX_BASES * self.scale.spacing {
                return Err(ExponentialError::NoBasis { speed: self.scale.speed(new) });
            }
            let beside = found.bases.get(&neighbour).map(|station| &**station);
            let station = ModalBasis::new(&self.model, self.scale.speed(new), beside)?;
            let (below, near) = (new.min(neighbour), &*found.bases[&neighbour]);
            let (one, other) = if new < neighbour { (&station, near) } else { (near, &station) };
            let (up, down) = (mul(&other.left, &one.right), mul(&one.left, &other.right));
            let transfer = BasisChange::new(up, down, self.cells);
            if self.loses_bearing_loads(&transfer, [one, other]) {
                return Err(ExponentialError::NoBasis { speed: self.scale.speed(new) });
            }
            found.bases.insert(new, Arc::new(station));
            found.basis_changes.insert(below, Arc::new(transfer));
        }
    }
}

/// States of the slowest pairs, [`SLOWEST`] of all.
fn slow_states(station: &ModalBasis) -> Vec<usize> {
    let size = station.blocks.len();
    let mut pairs: Vec<usize> = (0..size).collect();
    pairs.sort_by(|&one, &other| block_norm(&station.blocks[one]).total_cmp(&block_norm(&station.blocks[other])));
    pairs.truncate(size.div_ceil(SLOW_SHARE));
    pairs.into_iter().flat_map(|k| [k, size + k]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::dissipation::DissipationBuffer;
    use super::super::interval_tables::IntervalTables;
    use super::super::outputs::Outputs;
    use super::super::section_loads::SectionLoadModel;
    use super::super::state_space::StateSpace;
    use super::*;
    use crate::linalg::mul_vec;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;
    use nalgebra::Complex;

    /// y of a state x in a cell, by the left vectors of the station below it.
    fn amplitudes(grid: &SpeedGrid, cell: &SpeedInterval, x: &[f64]) -> Vec<f64> {
        let j = cell.index.rem_euclid(grid.cells);
        let (mut y, mut scratch) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        mul_vec(&cell.stations[0].left, x, &mut y);
        if let BasisChange::Gradual { half, .. } = &*cell.basis_change {
            mul_vec(&half[0], &y, &mut scratch);
            std::mem::swap(&mut y, &mut scratch);
        }
        let mut from = grid.interval(cell.index - j).expect("has bases");
        while from.index < cell.index {
            let next = grid.interval(from.index + 1).expect("has bases");
            grid.change_basis(&from, &next, &mut y, &mut scratch);
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
        let system = StateSpace::new(&machine, &structure).expect("regular");
        let size = 2 * system.size;
        let outputs = Outputs::new(&machine, &structure);
        let measures = SectionLoadModel::new(&machine, &structure, &system, outputs.weight());
        let model = LateralModel { state_space: system, outputs, measures };
        let grid =
            SpeedGrid::new(model, GridSpacing { spacing, closes: false }, 10, 1.6 * spacing).expect("has a basis");
        let x: Vec<f64> = (0..size).map(|i| f64::from(u8::try_from(i * 7 % 11).expect("small")) - 5.0).collect();
        let (below, above) = (grid.interval(10).expect("has bases"), grid.interval(20).expect("has bases"));
        let (mut y, wanted) = (amplitudes(&grid, &below, &x), amplitudes(&grid, &above, &x));
        let (begun, mut scratch) = (y.clone(), vec![0.0; size]);
        let far = |y: &[f64], z: &[f64]| crate::linalg::distance(y, z) / crate::linalg::norm(z);
        let cells: Vec<_> = (10..=20).map(|index| grid.interval(index).expect("has bases")).collect();
        cells.windows(2).for_each(|pair| grid.change_basis(&pair[0], &pair[1], &mut y, &mut scratch));
        assert!(far(&y, &wanted) < 1e-11, "{spacing}: {:e}", far(&y, &wanted));
        cells.windows(2).rev().for_each(|pair| grid.change_basis(&pair[1], &pair[0], &mut y, &mut scratch));
        assert!(far(&y, &begun) < 1e-11, "{spacing}: {:e}", far(&y, &begun));
        matches!(*below.basis_change, BasisChange::Gradual { .. })
    }

    #[test]
    fn between_stations_it_is_linear() {
        let path = format!("{}/../studies/machines/lp_turbine.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let grid = |spacing: f64, cells: u32| {
            let system = StateSpace::new(&machine, &structure).expect("regular");
            let outputs = Outputs::new(&machine, &structure);
            let measures = SectionLoadModel::new(&machine, &structure, &system, outputs.weight());
            SpeedGrid::new(
                LateralModel { state_space: system, outputs, measures },
                GridSpacing { spacing, closes: false },
                cells,
                140.0,
            )
            .expect("has a basis")
        };
        // the same cells between stations, and between ones four times as close
        let (grid, close) = (grid(4.2, 40), grid(1.05, 10));
        let h = 27e-6;
        for speed in [131.0, 133.7, 136.2] {
            let [far, near] = [&grid, &close].map(|grid| grid.interval(grid.index_of(speed)).expect("has bases"));
            for impulse in [[1.0, 0.0], [0.0, 1.0], [1.0, -0.7]] {
                let [found, wanted] = [(&grid, &far), (&close, &near)].map(|(grid, cell)| {
                    let mut y = vec![0.0; 2 * grid.model.state_space.size];
                    cell.apply_contact_impulse(impulse, &mut y);
                    let forces = [Complex::default()];
                    let mut tables = IntervalTables::default();
                    let within = tables.dissipation(cell, &grid.model, h);
                    within.power(cell.forced_dissipation(within, h), h, &y, &forces, &mut DissipationBuffer::default())
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
