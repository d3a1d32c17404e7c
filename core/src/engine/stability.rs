//! Least damping of a machine's whirl modes in the lateral modal basis of its structure, at speeds of the exponential engine's grid.
//!
//! ```text
//! (lambda^2 M + lambda (C + W G) + K + K_skew) q = 0        M with the unbalances' masses at their nodes                  (1)
//! ```
//! `exponential` and `reduced` integrate these matrices. `full` has more modes, with whirl frequencies above those of the basis. The exponential
//! engine has the solutions of (1) in the modal bases of its speed grid ([`super::exponential`]). The other two engines solve (1) at every second
//! speed of this grid, or at every fourth if the grid is refined towards rest. They keep the solutions with the structure. Definition:
//! [`crate::modal::least_damping`]. Verified by `tests/rotor/stability.rs`.

use super::beginning::projected;
use super::exponential::GridSpacing;
use super::shaft_line::{masses, sites};
use crate::modal::{
    Damping, DampingGrid, UnstableRange, highest_speed, least_damping, quadratic_values, unstable_ranges,
};
use crate::rotor::RotorMatrices;
use crate::structure::{Coordinates, Structure};
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{EigenError, Matrix, Vector, add_outer, project};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Maximum number of grid speeds above and below the first one at which the damping is computed.
const MOST: i64 = 256;
/// Thinning of the grid: every second speed of an even grid, every fourth of a grid that is refined towards rest. About 20 of 40 speeds remain, or 68
/// of 272, between the initial speed and rest. With all speeds a run of the lab rig took 4 % longer. The remaining speeds are a nineteenth of the
/// initial speed apart; at rest on anisotropic bearings an eightieth of that.
const THINNED: [i64; 2] = [2, 4];
/// Number of machines of one structure whose systems are kept.
const KEPT: usize = 8;

/// Matrices of the eigenvalue problem (1) for one machine.
#[derive(Debug)]
struct Whirl {
    /// Mass matrix M with the unbalances' masses.
    mass: Matrix,
    /// Damping matrix C.
    damping: Matrix,
    /// Gyroscopic matrix G per unit spin.
    gyroscopic: Matrix,
    /// Stiffness matrix K + K_skew.
    stiffness: Matrix,
    /// Shaft line with bearing tables, and the mode shapes for the projection of its matrices (`None`: nodal coordinates).
    tables: Option<(RotorMatrices, Option<Matrix>)>,
}

impl Whirl {
    fn new(machine: &Machine, structure: &Structure) -> Self {
        let (part, rotor, modes) = (&structure.lateral, &structure.rotor, &structure.basis().lateral);
        if part.coordinates.is_modal() || modes.omega_squared.is_empty() {
            return Self {
                mass: masses(structure, &sites(machine)).0,
                damping: part.damping.clone(),
                gyroscopic: projected(structure, &rotor.gyroscopic()),
                stiffness: &part.stiffness + projected(structure, &rotor.skew_stiffness()),
                tables: (!rotor.tables.is_empty()).then(|| (rotor.clone(), part.coordinates.shapes().cloned())),
            };
        }
        // full model: a solution with all degrees of freedom would cost their number cubed, so the reduced basis is used
        let (shapes, size) = (&modes.shapes, modes.omega_squared.len());
        let coordinates = Coordinates::modal(shapes);
        let mut mass = Matrix::identity(size, size);
        for site in sites(machine) {
            for dof in rotor.plane_places(site.node) {
                add_outer(&mut mass, site.mass, &coordinates.row(dof));
            }
        }
        let diagonal = Matrix::from_diagonal(&Vector::from_column_slice(&modes.omega_squared));
        Self {
            mass,
            damping: project(&rotor.damping, shapes),
            gyroscopic: project(&rotor.gyroscopic(), shapes),
            stiffness: diagonal + project(&rotor.skew_stiffness(), shapes),
            tables: (!rotor.tables.is_empty()).then(|| (rotor.clone(), Some(shapes.clone()))),
        }
    }

    fn at(&self, speed: f64) -> Result<Option<Damping>, EigenError> {
        let mut velocity = &self.damping + &self.gyroscopic * speed;
        let mut stiffness = Cow::Borrowed(&self.stiffness);
        if let Some((rotor, shapes)) = &self.tables
            && let Some(changes) = rotor.change_at(speed)
        {
            let [k, c] = changes.map(|change| match shapes {
                Some(shapes) => project(&change, shapes),
                None => change,
            });
            velocity += c;
            stiffness = Cow::Owned(&self.stiffness + k);
        }
        Ok(least_damping(&quadratic_values(&self.mass, &velocity, &stiffness, "whirl at one speed")?))
    }
}

/// Node and mass (as bits) of each unbalance. (1) depends only on them and on the structure.
type Masses = Vec<(usize, u64)>;

/// Systems of machines of one structure; the most recently used one is last.
#[derive(Debug, Default)]
struct Systems(Mutex<Vec<(Masses, Arc<System>)>>);

/// System (1) with its solutions, by the bits of the speed.
#[derive(Debug)]
struct System {
    /// Matrices of (1).
    whirl: Whirl,
    /// Least damping by the bits of the speed; `None` if there is no solution.
    solved: Mutex<BTreeMap<u64, Option<Damping>>>,
}

impl System {
    fn of(machine: &Machine, structure: &Structure) -> Arc<Self> {
        let masses: Masses = sites(machine).iter().map(|site| (site.node, site.mass.to_bits())).collect();
        let systems: &Systems = structure.stability_cache.get();
        let kept = &mut *systems.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|(other, _)| *other == masses) {
            kept[at..].rotate_left(1);
            return Arc::clone(&kept[kept.len() - 1].1);
        }
        let made = Arc::new(Self { whirl: Whirl::new(machine, structure), solved: Mutex::default() });
        if kept.len() == KEPT {
            kept.remove(0);
        }
        kept.push((masses, Arc::clone(&made)));
        made
    }

    fn at(&self, speed: f64) -> Option<Damping> {
        let solved = &mut *self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        *solved.entry(speed.to_bits()).or_insert_with(|| self.whirl.at(speed).ok().flatten())
    }
}

/// Least damping of one run at grid speeds.
#[derive(Debug)]
pub(super) struct SolvedGrid {
    /// Eigenvalue problem of the machine.
    system: Arc<System>,
    /// Thinned speed grid.
    speeds: Speeds,
    /// Index of the grid speed at or below the initial speed.
    first: i64,
}

/// Thinned speed grid of the exponential engine. Bearing tables add their own speeds, between which no coefficient has an extremum. A peak of a
/// coefficient that is narrower than the grid can make the rotor unstable.
#[derive(Debug, Clone)]
struct Speeds {
    /// Spacing of the exponential engine's grid.
    scale: GridSpacing,
    /// Every how many grid speeds one is used.
    every: i64,
    /// All speeds \[rad/s\], ascending, for a machine with bearing tables; otherwise the grid alone is used.
    listed: Option<Vec<f64>>,
}

impl Speeds {
    /// Thinned grid; `about` is the speed around which it is listed \[rad/s\].
    fn new(scale: GridSpacing, structure: &Structure, about: f64) -> Self {
        let grid = Self { scale, every: THINNED[usize::from(scale.closes)], listed: None };
        if structure.rotor.tables.is_empty() {
            return grid;
        }
        let first = grid.below(about);
        let of_grid = (first - MOST..=first + MOST).map(|k| grid.at(k)).filter(|speed| *speed >= 0.0);
        let of_tables = structure.rotor.tables.iter().flat_map(|(_, table)| table.speeds().iter().copied());
        let mut listed: Vec<f64> = of_grid.chain(of_tables).collect();
        listed.sort_by(f64::total_cmp);
        listed.dedup();
        Self { listed: Some(listed), ..grid }
    }

    fn at(&self, k: i64) -> f64 {
        match &self.listed {
            Some(listed) => listed[k.clamp(0, listed.len() as i64 - 1) as usize],
            None => self.scale.speed(k * self.every),
        }
    }

    fn below(&self, speed: f64) -> i64 {
        match &self.listed {
            Some(listed) => {
                (listed.partition_point(|other| *other <= speed) as i64 - 1).clamp(0, listed.len() as i64 - 2)
            }
            None => self.scale.below(speed).div_euclid(self.every),
        }
    }
}

impl SolvedGrid {
    pub fn new(machine: &Machine, structure: &Structure) -> Self {
        let initial = machine.rotor.initial_speed;
        let speeds = Speeds::new(GridSpacing::of(machine, None), structure, initial);
        Self { system: System::of(machine, structure), first: speeds.below(initial), speeds }
    }

    /// Change of the speed after which the least damping is evaluated again \[rad/s\]: a fraction of the grid spacing.
    pub fn noticeable(&self) -> f64 {
        self.speeds.scale.spacing / 16.0
    }
}

impl DampingGrid for SolvedGrid {
    fn speed(&self, b: i64) -> f64 {
        self.speeds.at(b)
    }

    fn below(&self, speed: f64) -> i64 {
        let below = self.speeds.below(speed);
        if self.speeds.listed.is_some() { below } else { below.clamp(self.first - MOST, self.first + MOST) }
    }

    fn least(&self, b: i64) -> Option<Damping> {
        self.system.at(self.speeds.at(b))
    }
}

/// Ranges of speed between `lowest` and `highest` \[rad/s\] in which a whirl mode of a machine is unstable.
///
/// The least damping is computed at the grid speeds between them. Range limits are accurate to 0.01 rpm ([`unstable_ranges`]).
///
/// # Errors
/// [`EigenError`].
pub fn unstable_speeds(
    machine: &Machine,
    structure: &Structure,
    [lowest, highest]: [f64; 2],
) -> Result<Vec<UnstableRange>, EigenError> {
    let system = System::of(machine, structure);
    let grid = Speeds::new(GridSpacing::reaching(machine, highest), structure, lowest);
    let inner = (grid.below(lowest)..=grid.below(highest) + 1)
        .map(|b| grid.at(b))
        .filter(|speed| (lowest..=highest).contains(speed));
    let mut speeds: Vec<f64> =
        std::iter::once(lowest).chain(inner).chain(std::iter::once(highest)).filter(|speed| *speed >= lowest).collect();
    speeds.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * highest.abs());
    unstable_ranges(&speeds, |speed| system.whirl.at(speed))
}

/// Lowest and highest mean spin of an undisturbed run \[rad/s\]: initial or prescribed speeds, the highest speed under torques, and the end speed.
#[must_use]
pub fn speeds_of_run(machine: &Machine) -> [f64; 2] {
    let law = machine.rotor.speed_law.as_ref().map(|law| law.speeds.as_slice()).unwrap_or_default();
    let highest = match machine.torques.is_empty() {
        true => law.iter().copied().fold(machine.rotor.initial_speed, f64::max),
        false => highest_speed(machine),
    };
    let lowest = match law {
        [] => machine.run.end_speed,
        law => law.iter().copied().fold(highest, f64::min),
    };
    [lowest.min(highest), highest]
}
