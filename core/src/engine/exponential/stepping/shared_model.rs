//! Modal bases, speed intervals and ring points that runs of one model share, because they take longer to compute than a run.
//!
//! A structure keeps those of the last few models. A run finds the same values in them as it would compute alone: they depend only on
//! their key, not on earlier runs or on the order of the runs.

use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::contact::ring_points::{RingPoints, ring_points};
use crate::engine::exponential::modal::bearing_tables::BearingTables;
use crate::engine::exponential::modal::grid_spacing::GridSpacing;
use crate::engine::exponential::modal::modal_basis::LateralModel;
use crate::engine::exponential::modal::outputs::{DirectFeedthrough, Outputs};
use crate::engine::exponential::modal::section_loads::SectionLoadModel;
use crate::engine::exponential::modal::speed_grid::SpeedGrid;
use crate::engine::exponential::modal::state_space::StateSpace;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::shaft_line::sites;
use crate::engine::time_step::slowest_to_resolve;
use crate::structure::Structure;
use bladeoff_model::machine::{Contact, ContactSurface, Machine, Presence};
use std::sync::{Arc, Mutex, PoisonError};

/// Largest number of lateral coordinates: the cost of a modal basis grows with its cube.
const MAX_LATERAL_COORDINATES: usize = 200;
/// Number of models that a structure keeps, and of ring point sets that a ring keeps.
const MAX_KEPT_MODELS: usize = 8;

/// Modal bases of one model over the spin, and the feedthrough feedthrough of its loads.
#[derive(Debug)]
pub(crate) struct SharedModel {
    /// Grid of speeds with the modal bases.
    pub grid: SpeedGrid,
    /// Direct feedthrough of each bearing's load, then of each journal's displacement; with bearing tables those of each speed interval take its place.
    pub feedthrough: Vec<DirectFeedthrough>,
}

/// Values that a shared model depends on, beside the structure.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    /// Values of the machine.
    of: MachineValues,
    /// Contact step and grid spacing, as bits.
    step: u64,
    spacing: u64,
    /// Whether the grid is closer at slow spins.
    closes: bool,
    /// Number of bases in the place of one, as bits.
    refinement: u64,
    /// Number of speed intervals between two grid speeds.
    intervals: u32,
    /// Position of the grid relative to the initial speed.
    anchor: i64,
}

/// Values of a shared model that may differ between machines of one structure.
#[derive(Debug, Clone, PartialEq)]
struct MachineValues {
    /// Node and mass of each unbalance.
    sites: Vec<(usize, u64)>,
    /// Gravity, and elevations of the bearings' seats, as bits.
    gravity: [u64; 2],
    elevations: Vec<[u64; 2]>,
    /// Whether each unbalance is present before the release: the seats of bearing tables carry its weight. Empty without tables.
    before: Vec<bool>,
    /// Node of each contact.
    nodes: Vec<usize>,
}

impl MachineValues {
    fn new(machine: &Machine) -> Self {
        let has_tables = machine.rotor.bearings.iter().any(|bearing| bearing.table.is_some());
        let unbalances = machine.rotor.unbalances.iter().filter(|_| has_tables);
        Self {
            before: unbalances.map(|unbalance| unbalance.presence == Presence::Before).collect(),
            sites: sites(machine).iter().map(|site| (site.node, site.mass.to_bits())).collect(),
            gravity: machine.rotor.gravity.map(f64::to_bits),
            elevations: machine.rotor.bearings.iter().map(|bearing| bearing.elevation.map(f64::to_bits)).collect(),
            nodes: machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.node).collect(),
        }
    }
}

/// Whether two machines of one structure can share modal bases, initial speeds and steps apart.
#[must_use]
pub fn same_bases(one: &Machine, other: &Machine) -> bool {
    MachineValues::new(one) == MachineValues::new(other)
}

/// Shared models of the last runs of a structure.
#[derive(Debug, Default)]
struct ModelCache(Mutex<Vec<(Key, Arc<SharedModel>)>>);

/// Points of a ring, by contact step and by the radius of an inner face.
#[derive(Debug, Default)]
struct RingCache(Mutex<Vec<((u64, Option<u64>), Arc<RingPoints>)>>);

impl SharedModel {
    /// Returns the shared model of a machine: a kept one, or a new one.
    ///
    /// # Errors
    /// [`ExponentialError`] for a machine without a modal basis at its initial speed, or with more lateral modes than are
    /// covered.
    pub fn of(machine: &Machine, structure: &Structure, settings: StepSettings) -> Result<Arc<Self>, ExponentialError> {
        let speed = machine.rotor.initial_speed;
        let mut spacing = GridSpacing::of(machine, settings.spacing);
        if settings.spacing.is_none() && speed == 0.0 && machine.rotor.speed_law.is_none() {
            spacing = GridSpacing::reaching(machine, slowest_to_resolve(machine, structure));
        }
        if settings.spacing.is_none() && !structure.rotor.tables.is_empty() {
            spacing = spacing.refined_for(&BearingTables::new(structure))?;
        }
        let key = Key {
            of: MachineValues::new(machine),
            step: settings.step.to_bits(),
            spacing: spacing.spacing.to_bits(),
            closes: spacing.closes,
            refinement: spacing.refinement.to_bits(),
            intervals: settings.cells,
            anchor: spacing.anchor(speed),
        };
        let models: &ModelCache = structure.engine_cache.get();
        let kept = &mut *models.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|(other, _)| *other == key) {
            kept[at..].rotate_left(1);
            let shared = Arc::clone(&kept[kept.len() - 1].1);
            shared.grid.keep_intervals();
            return Ok(shared);
        }
        if structure.lateral.coordinates.size() > MAX_LATERAL_COORDINATES {
            return Err(ExponentialError::NotCovered { what: "more than 200 lateral modes (run.rotor_modes)" });
        }
        let state_space =
            StateSpace::new(machine, structure).ok_or(ExponentialError::Singular { part: "the rotor" })?;
        let outputs = Outputs::new(machine, structure);
        let feedthrough = outputs.feedthrough(&state_space, speed);
        let measures = SectionLoadModel::new(machine, structure, &state_space, outputs.weight());
        #[cfg(test)]
        let state_space = state_space.with_fault(settings.fault);
        let grid = SpeedGrid::new(LateralModel { state_space, outputs, measures }, spacing, settings.cells, speed)?;
        let shared = Arc::new(Self { grid, feedthrough });
        if kept.len() == MAX_KEPT_MODELS {
            kept.remove(0);
        }
        kept.push((key, Arc::clone(&shared)));
        Ok(shared)
    }
}

/// Returns the points of a diaphragm's ring for contact steps of `step` \[s\]: kept ones, or new ones. Those of a rigid ring are not kept.
pub(crate) fn ring_points_of(machine: &Machine, index: usize, structure: &Structure, step: f64) -> Arc<RingPoints> {
    let diaphragm = &machine.diaphragms[index];
    let new_points = || Arc::new(ring_points(diaphragm, structure, index, step));
    let Some(part) = &structure.rings[index] else { return new_points() };
    let rings: &RingCache = part.engine_cache.get();
    let key = (step.to_bits(), inner_face_radius(&diaphragm.contact));
    let kept = &mut *rings.0.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, ring_points)) = kept.iter().find(|(other, _)| *other == key) {
        return Arc::clone(ring_points);
    }
    let new_points = new_points();
    if kept.len() == MAX_KEPT_MODELS {
        kept.remove(0);
    }
    kept.push((key, Arc::clone(&new_points)));
    new_points
}

/// Radius of an inner face, as bits; `None` for a ring that is touched at its mean line.
fn inner_face_radius(contact: &Contact) -> Option<u64> {
    (contact.surface == ContactSurface::InnerFace).then(|| (contact.rotor_radius + contact.gap).to_bits())
}
