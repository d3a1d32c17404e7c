//! Grid of speeds: modal bases where runs visit them, and speed intervals between two bases.
//!
//! ```text
//! basis b      at W_b                                            (`grid_spacing`)
//! interval j   one of m between two bases, at the share s of the way:   R(s), B(s), O(s), N(s) linear in s                          (1)
//! from interval to interval     y := X^(1/m) y,   X = L_(b+1) R_b                                                                   (2)
//! ```
//! `R`, `B`, `O`, `N`: right vectors, plane blocks, output rows and gyroscopic momentum of a modal basis (`modal_basis`); `y`: modal state; `m`: intervals between two bases.
//! Within an interval all of them are constant. A run leaves its interval when it is a sixteenth of the width beyond its edge: a spin that oscillates about an edge then does not
//! change interval each time, and a falling spin does not stay behind. (2) is the slow change of the eigenvectors with the spin, exact from basis to basis (`basis_change`).
//! The error of (1) and (2) is of second order in the width of an interval and in the grid spacing (docs/theory/08-exponential-engine.md, "Whirl states").
//!
//! The bases form a chain that begins at the anchor near the initial speed and continues upwards and downwards, each basis aligned with the one before.
//! A basis therefore depends neither on the path of a run through the speeds nor on earlier runs.
//! Verified by the tests below and `tests/exponential/exponential.rs`.

use super::basis_change::BasisChange;
use super::grid_spacing::GridSpacing;
use super::modal_basis::{LateralModel, ModalBasis};
use super::plane_block::block_norm;
use super::speed_interval::SpeedInterval;
use crate::engine::exponential::error::ExponentialError;
use crate::modal::{Damping, DampingGrid};
use bladeoff_numerics::linalg::{Matrix, lanes, mul};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Distance from the middle of an interval at which a run leaves it, as a share of its width.
const LEAVE_DISTANCE: f64 = 0.5625;
/// Largest distance of a basis from the anchor, in grid spacings: with the default spacing four times the initial speed.
const MAX_BASES: f64 = 128.0;
/// Largest jump of the spin in one step, in grid spacings; a larger one has left the validity of the model.
const MAX_SPEED_JUMP: f64 = 48.0;
/// Largest jump of a bearing load between two intervals, as a share of the largest load of slow motions.
///
/// The step that leaves an interval still reads the loads of that interval, so the jump itself is not recorded. Its after-effect is: 1.5e-3 of the load of the lab rig at 0.3, 2 % at 0.7.
const MAX_LOAD_JUMP: f64 = 0.25;
/// Rounding error of a nodal velocity, relative to the velocity of the fastest coordinate.
const ROUNDING: f64 = 1e-14;
/// Share of slow planes: one in this many planes, the slowest ones, counts as slow motion.
const SLOW_SHARE: usize = 2;
/// Largest number of intervals that are kept for other runs, from the second run on; about 25 kB each with 24 planes.
///
/// Tables for observations are not part of them: each run interpolates its own ([`super::interval_tables`]).
const MAX_KEPT_INTERVALS: usize = 2048;
/// Number of intervals that the first run keeps: as many as a spin that oscillates about an edge, or a history, returns to.
const RECENT_INTERVALS: usize = 2;

/// Modal bases, basis changes and speed intervals of one model and one contact step.
///
/// Runs share a grid. Its contents do not depend on which run computed them.
#[derive(Debug)]
pub(crate) struct SpeedGrid {
    /// System matrices, outputs and observed quantities of the machine.
    pub model: LateralModel,
    spacing: GridSpacing,
    /// m: number of intervals between two bases.
    intervals_per_basis: i64,
    /// Index of the basis at which the chain begins.
    anchor: i64,
    /// Whether intervals are kept for other runs.
    keeps_intervals: AtomicBool,
    computed: Mutex<Computed>,
}

/// Bases, basis changes and intervals computed so far, by index.
#[derive(Debug, Default)]
struct Computed {
    bases: BTreeMap<i64, Arc<ModalBasis>>,
    /// Basis changes, by the index of the lower basis.
    basis_changes: BTreeMap<i64, Arc<BasisChange>>,
    intervals: BTreeMap<i64, Arc<SpeedInterval>>,
}

/// Least damping of the modal bases of a grid, for a run in one interval: the two bases beside it are read without a lock.
pub(crate) struct IntervalDamping<'a> {
    grid: &'a SpeedGrid,
    /// Index of the basis below the interval.
    below: i64,
    bases: &'a [Arc<ModalBasis>; 2],
}

impl IntervalDamping<'_> {
    /// Speeds of the two bases of the interval \[rad/s\].
    pub fn speeds(&self) -> [f64; 2] {
        self.bases.each_ref().map(|basis| basis.interval_model.speed)
    }
}

impl DampingGrid for IntervalDamping<'_> {
    fn speed(&self, b: i64) -> f64 {
        self.grid.spacing.speed(b)
    }

    fn below(&self, speed: f64) -> i64 {
        self.grid.spacing.below(speed)
    }

    /// A run computes the bases on both sides of every speed that it visits before it asks for their damping.
    fn least(&self, b: i64) -> Option<Damping> {
        let beside = usize::try_from(b - self.below).ok().and_then(|at| self.bases.get(at));
        beside.map_or_else(|| self.grid.least_damping(b), |basis| basis.least_damping)
    }
}

impl SpeedGrid {
    /// Grid with `intervals` speed intervals between two bases, and with its anchor computed: the same one for all initial speeds near `speed` \[rad/s\].
    ///
    /// # Errors
    /// [`ExponentialError`] if there is no usable basis at the anchor.
    pub fn new(
        model: LateralModel,
        spacing: GridSpacing,
        intervals: u32,
        speed: f64,
    ) -> Result<Self, ExponentialError> {
        let anchor = spacing.anchor(speed);
        let keeps = AtomicBool::new(false);
        let grid = Self {
            model,
            spacing,
            intervals_per_basis: i64::from(intervals),
            anchor,
            keeps_intervals: keeps,
            computed: Mutex::default(),
        };
        let basis = ModalBasis::new(&grid.model, grid.spacing.speed(anchor), None)?;
        grid.computed.lock().unwrap_or_else(PoisonError::into_inner).bases.insert(anchor, Arc::new(basis));
        Ok(grid)
    }

    /// Least damping of the bases, for a run in an interval.
    pub fn damping<'a>(&'a self, interval: &'a SpeedInterval) -> IntervalDamping<'a> {
        IntervalDamping {
            grid: self,
            below: interval.index.div_euclid(self.intervals_per_basis),
            bases: &interval.bases,
        }
    }

    /// Least damping of basis b; `None` if it is not computed or has no oscillating mode.
    fn least_damping(&self, b: i64) -> Option<Damping> {
        self.computed.lock().unwrap_or_else(PoisonError::into_inner).bases.get(&b).and_then(|basis| basis.least_damping)
    }

    /// Keeps intervals from now on, for other runs.
    pub fn keep_intervals(&self) {
        self.keeps_intervals.store(true, Ordering::Relaxed);
    }

    /// Index of the interval that contains a speed \[rad/s\].
    pub fn index_of(&self, speed: f64) -> i64 {
        self.spacing.interval_of(speed, self.intervals_per_basis)
    }

    /// Whether a run at `speed` \[rad/s\] has left an interval.
    pub fn has_left(&self, interval: &SpeedInterval, speed: f64) -> bool {
        (speed - interval.model.speed).abs() * self.intervals_per_basis as f64 > LEAVE_DISTANCE * interval.basis_spacing
    }

    /// Whether a spin \[rad/s\] has jumped farther from an interval than the grid follows.
    pub fn jumps_too_far(&self, interval: &SpeedInterval, speed: f64) -> bool {
        (speed - interval.model.speed).abs() > MAX_SPEED_JUMP * self.spacing.spacing
    }

    /// Number of bases computed so far, and an upper bound of their condition numbers.
    pub fn visited_bases(&self) -> (usize, f64) {
        let computed = self.computed.lock().unwrap_or_else(PoisonError::into_inner);
        (computed.bases.len(), computed.bases.values().map(|basis| basis.condition).fold(1.0, f64::max))
    }

    /// Interval with an index; its bases are computed if they are not there yet.
    ///
    /// # Errors
    /// [`ExponentialError`] if a basis on the way there cannot be computed.
    pub fn interval(&self, index: i64) -> Result<Arc<SpeedInterval>, ExponentialError> {
        let computed = &mut *self.computed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(interval) = computed.intervals.get(&index) {
            return Ok(Arc::clone(interval));
        }
        let (b, j) = (index.div_euclid(self.intervals_per_basis), index.rem_euclid(self.intervals_per_basis));
        self.compute_basis(computed, b)?;
        self.compute_basis(computed, b + 1)?;
        let position = (j as f64 + 0.5) / self.intervals_per_basis as f64;
        let basis_change = Arc::clone(&computed.basis_changes[&b]);
        let share = match *basis_change {
            BasisChange::Gradual { .. } => position,
            BasisChange::AtOnce(_) => libm::floor(position + 0.5),
        };
        let (below, above) = (&computed.bases[&b], &computed.bases[&(b + 1)]);
        let outputs = &self.model.outputs;
        let basis_spacing = self.spacing.distance(b);
        let speed = self.spacing.speed(b) + position * basis_spacing;
        let interval =
            Arc::new(SpeedInterval::new(index, [below, above], basis_change, share, [speed, basis_spacing], outputs));
        let keeps = self.keeps_intervals.load(Ordering::Relaxed);
        if !keeps && computed.intervals.len() >= RECENT_INTERVALS {
            computed.intervals.clear();
        }
        if computed.intervals.len() < MAX_KEPT_INTERVALS {
            computed.intervals.insert(index, Arc::clone(&interval));
        }
        Ok(interval)
    }

    /// Transforms the modal state y from one interval to the next, up or down, by (2).
    pub fn change_basis(&self, from: &SpeedInterval, to: &SpeedInterval, y: &mut Vec<f64>, scratch: &mut Vec<f64>) {
        #[cfg(test)]
        if self.model.state_space.fault == Some(crate::engine::exponential::settings::Fault::LostBasisChange) {
            return;
        }
        let mut apply = |matrix: &Matrix| {
            lanes::product([matrix.nrows(), matrix.ncols(), 1], matrix.as_slice(), y, scratch);
            std::mem::swap(y, scratch);
        };
        let side = usize::from(to.index < from.index);
        if from.index.div_euclid(self.intervals_per_basis) != to.index.div_euclid(self.intervals_per_basis) {
            for interval in [from, to] {
                if let BasisChange::Gradual { half, .. } = &*interval.basis_change {
                    apply(&half[side]);
                }
            }
            return;
        }
        match &*from.basis_change {
            BasisChange::Gradual { whole, .. } => apply(&whole[side]),
            BasisChange::AtOnce(whole)
                if 2 * from.index.max(to.index).rem_euclid(self.intervals_per_basis) == self.intervals_per_basis =>
            {
                apply(&whole[side]);
            }
            BasisChange::AtOnce(_) => {}
        }
    }

    /// Whether bearing loads between two bases are unusable: they would jump by more than [`MAX_LOAD_JUMP`] of the largest load of slow motions of one energy.
    ///
    /// Jumps from interval to interval and rounding are considered; a basis change at once counts for its share of one interval.
    /// The node of a strongly damped bearing hardly moves, and its load is the damping times the small velocity that rounding and intervals leave.
    fn loses_bearing_loads(&self, basis_change: &BasisChange, [below, above]: [&ModalBasis; 2]) -> bool {
        let rows_at = |share: f64| &below.output_rows * (1.0 - share) + &above.output_rows * share;
        let intervals = self.intervals_per_basis as f64;
        let (rows_before, rows_after, intervals_at_once) = match basis_change {
            BasisChange::Gradual { whole, .. } => {
                let half = 0.5 / intervals;
                (rows_at(0.5 - half), mul(&rows_at(0.5 + half), &whole[0]), 1.0)
            }
            BasisChange::AtOnce([up, _]) => (below.output_rows.clone(), mul(&above.output_rows, up), intervals),
        };
        let (slow, fastest) =
            (slow_states(below), below.motion_of_state.rows(below.blocks.len(), below.blocks.len()).amax());
        let (mut jump, mut largest) = (0.0_f64, 0.0_f64);
        for (bearing, first_row) in self.model.outputs.load_rows().into_iter().enumerate() {
            jump = jump.max(ROUNDING * fastest * self.model.outputs.max_velocity_coefficient(bearing));
            for (&state, row) in slow.iter().flat_map(|state| [(state, first_row), (state, first_row + 1)]) {
                jump = jump.max((rows_before[(row, state)] - rows_after[(row, state)]).abs() / intervals_at_once);
                largest = largest.max(rows_before[(row, state)].abs());
            }
        }
        jump > MAX_LOAD_JUMP * largest
    }

    /// Computes the chain of bases from the computed ones up or down to basis b.
    fn compute_basis(&self, computed: &mut Computed, b: i64) -> Result<(), ExponentialError> {
        loop {
            let (Some((&lowest, _)), Some((&highest, _))) =
                (computed.bases.first_key_value(), computed.bases.last_key_value())
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
            if (self.spacing.speed(new) - self.spacing.speed(self.anchor)).abs() > MAX_BASES * self.spacing.spacing {
                return Err(ExponentialError::NoBasis { speed: self.spacing.speed(new) });
            }
            let existing_basis = computed.bases.get(&neighbour).map(|basis| &**basis);
            let basis = ModalBasis::new(&self.model, self.spacing.speed(new), existing_basis)?;
            let (below, existing) = (new.min(neighbour), &*computed.bases[&neighbour]);
            let (lower, upper) = if new < neighbour { (&basis, existing) } else { (existing, &basis) };
            let (up, down) = (mul(&upper.left, &lower.right), mul(&lower.left, &upper.right));
            let basis_change = BasisChange::new(up, down, self.intervals_per_basis);
            if self.loses_bearing_loads(&basis_change, [lower, upper]) {
                return Err(ExponentialError::NoBasis { speed: self.spacing.speed(new) });
            }
            computed.bases.insert(new, Arc::new(basis));
            computed.basis_changes.insert(below, Arc::new(basis_change));
        }
    }
}

/// Entries of y that belong to the slowest planes, one in [`SLOW_SHARE`] of all.
fn slow_states(basis: &ModalBasis) -> Vec<usize> {
    let size = basis.blocks.len();
    let mut planes: Vec<usize> = (0..size).collect();
    planes.sort_by(|&one, &other| block_norm(&basis.blocks[one]).total_cmp(&block_norm(&basis.blocks[other])));
    planes.truncate(size.div_ceil(SLOW_SHARE));
    planes.into_iter().flat_map(|k| [k, size + k]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::dissipation::DissipationBuffer;
    use super::super::interval_tables::IntervalTables;
    use super::super::outputs::Outputs;
    use super::super::section_loads::SectionLoadModel;
    use super::super::state_space::StateSpace;
    use super::*;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;
    use bladeoff_numerics::linalg::mul_vec;
    use nalgebra::Complex;

    /// Modal state in an interval of a state vector x, from the left vectors of the basis below it.
    fn state_in_interval(grid: &SpeedGrid, interval: &SpeedInterval, x: &[f64]) -> Vec<f64> {
        let j = interval.index.rem_euclid(grid.intervals_per_basis);
        let (mut y, mut scratch) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        mul_vec(&interval.bases[0].left, x, &mut y);
        if let BasisChange::Gradual { half, .. } = &*interval.basis_change {
            mul_vec(&half[0], &y, &mut scratch);
            std::mem::swap(&mut y, &mut scratch);
        }
        let mut from = grid.interval(interval.index - j).expect("has bases");
        while from.index < interval.index {
            let next = grid.interval(from.index + 1).expect("has bases");
            grid.change_basis(&from, &next, &mut y, &mut scratch);
            from = next;
        }
        y
    }

    /// Transforms a modal state from one basis to the next, interval by interval, and back, and compares it with the state itself. True if the basis change is gradual.
    fn state_survives_round_trip(spacing: f64) -> bool {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let system = StateSpace::new(&machine, &structure).expect("regular");
        let size = 2 * system.size;
        let outputs = Outputs::new(&machine, &structure);
        let measures = SectionLoadModel::new(&machine, &structure, &system, outputs.weight());
        let model = LateralModel { state_space: system, outputs, measures };
        let grid = SpeedGrid::new(model, GridSpacing { spacing, closes: false, refinement: 1.0 }, 10, 1.6 * spacing)
            .expect("has a basis");
        let x: Vec<f64> = (0..size).map(|i| f64::from(u8::try_from(i * 7 % 11).expect("small")) - 5.0).collect();
        let (below, above) = (grid.interval(10).expect("has bases"), grid.interval(20).expect("has bases"));
        let (mut y, wanted) = (state_in_interval(&grid, &below, &x), state_in_interval(&grid, &above, &x));
        let (initial, mut scratch) = (y.clone(), vec![0.0; size]);
        let relative_error =
            |y: &[f64], z: &[f64]| bladeoff_numerics::linalg::distance(y, z) / bladeoff_numerics::linalg::norm(z);
        let intervals: Vec<_> = (10..=20).map(|index| grid.interval(index).expect("has bases")).collect();
        intervals.windows(2).for_each(|pair| grid.change_basis(&pair[0], &pair[1], &mut y, &mut scratch));
        assert!(relative_error(&y, &wanted) < 1e-11, "{spacing}: {:e}", relative_error(&y, &wanted));
        intervals.windows(2).rev().for_each(|pair| grid.change_basis(&pair[1], &pair[0], &mut y, &mut scratch));
        assert!(relative_error(&y, &initial) < 1e-11, "{spacing}: {:e}", relative_error(&y, &initial));
        matches!(*below.basis_change, BasisChange::Gradual { .. })
    }

    #[test]
    fn dissipation_is_linear_between_bases() {
        let path = format!("{}/../studies/machines/lp_turbine_paper.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let grid = |spacing: f64, intervals: u32| {
            let system = StateSpace::new(&machine, &structure).expect("regular");
            let outputs = Outputs::new(&machine, &structure);
            let measures = SectionLoadModel::new(&machine, &structure, &system, outputs.weight());
            SpeedGrid::new(
                LateralModel { state_space: system, outputs, measures },
                GridSpacing { spacing, closes: false, refinement: 1.0 },
                intervals,
                140.0,
            )
            .expect("has a basis")
        };
        // intervals of equal width, with bases at one spacing and at a quarter of it
        let (grid, close) = (grid(4.2, 40), grid(1.05, 10));
        let h = 27e-6;
        for speed in [131.0, 133.7, 136.2] {
            let [far, near] = [&grid, &close].map(|grid| grid.interval(grid.index_of(speed)).expect("has bases"));
            for impulse in [[1.0, 0.0], [0.0, 1.0], [1.0, -0.7]] {
                let [found, wanted] = [(&grid, &far), (&close, &near)].map(|(grid, interval)| {
                    let mut y = vec![0.0; 2 * grid.model.state_space.size];
                    interval.apply_contact_impulse(0, impulse, &mut y);
                    let forces = [Complex::default()];
                    let mut tables = IntervalTables::default();
                    let dissipation = tables.dissipation(interval, &grid.model, h);
                    dissipation.power(
                        interval.forced_dissipation(dissipation, h),
                        h,
                        &y,
                        &forces,
                        &mut DissipationBuffer::default(),
                    )
                });
                assert!(wanted > 0.0 && (found - wanted).abs() < 1e-3 * wanted, "{speed}: {found:e} {wanted:e}");
            }
        }
    }

    #[test]
    fn modal_states_are_transformed_from_basis_to_basis_gradually_and_at_once() {
        assert!(state_survives_round_trip(2.0), "a small spacing is changed gradually");
        assert!(!state_survives_round_trip(2000.0), "a large spacing is changed at once");
    }
}
