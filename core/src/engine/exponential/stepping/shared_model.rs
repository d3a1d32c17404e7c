//! What runs of one model share: bases, cells and candidates, which take longer to compute than a run.
//!
//! A structure keeps those of the last few models. A run finds in them what it would have computed alone: they depend on what their key
//! says, not on the runs before, nor on the order in which these asked.

use crate::engine::exponential::contact::ring_points::{RingPoints, ring_of, ring_points};
use crate::engine::exponential::error::ExponentialError;
use crate::engine::exponential::modal::grid_spacing::GridSpacing;
use crate::engine::exponential::modal::modal_basis::LateralModel;
use crate::engine::exponential::modal::outputs::{DirectFeedthrough, Outputs};
use crate::engine::exponential::modal::section_loads::SectionLoadModel;
use crate::engine::exponential::modal::speed_grid::SpeedGrid;
use crate::engine::exponential::modal::state_space::StateSpace;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::shaft_line::sites;
use crate::structure::Structure;
use bladeoff_model::machine::{Contact, ContactSurface, Machine};
use std::sync::{Arc, Mutex, PoisonError};

/// Lateral coordinates at most: a basis takes their cube.
const MAX_LATERAL_COORDINATES: usize = 200;
/// Models that are kept.
const MAX_KEPT_MODELS: usize = 8;

/// Bases of one model, and what is read from them.
#[derive(Debug)]
pub(crate) struct SharedModel {
    pub grid: SpeedGrid,
    pub feedthrough: Vec<DirectFeedthrough>,
}

/// What they depend on beside the structure.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    of: MachineValues,
    step: u64,
    spacing: u64,
    closes: bool,
    cells: u32,
    anchor: i64,
}

/// Those of its values that differ between machines of one structure.
#[derive(Debug, Clone, PartialEq)]
struct MachineValues {
    /// Node and mass of each unbalance.
    sites: Vec<(usize, u64)>,
    gravity: [u64; 2],
    /// Of the contacts.
    nodes: Vec<usize>,
}

impl MachineValues {
    fn new(machine: &Machine) -> Self {
        Self {
            sites: sites(machine).iter().map(|site| (site.node, site.mass.to_bits())).collect(),
            gravity: machine.rotor.gravity.map(f64::to_bits),
            nodes: machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.node).collect(),
        }
    }
}

/// Whether two machines of one structure share bases, initial speeds and steps apart.
#[must_use]
pub fn same_bases(one: &Machine, other: &Machine) -> bool {
    MachineValues::new(one) == MachineValues::new(other)
}

/// Those of the last models that a structure was run with.
#[derive(Debug, Default)]
struct ModelCache(Mutex<Vec<(Key, Arc<SharedModel>)>>);

/// Candidates of a ring, by the step and the radius of an inner face.
#[derive(Debug, Default)]
struct RingCache(Mutex<Vec<((u64, Option<u64>), Arc<RingPoints>)>>);

impl SharedModel {
    /// Of a machine: those that its structure keeps, or new ones.
    pub fn of(machine: &Machine, structure: &Structure, settings: StepSettings) -> Result<Arc<Self>, ExponentialError> {
        let speed = machine.rotor.initial_speed;
        let scale = GridSpacing::of(machine, settings.spacing);
        let key = Key {
            of: MachineValues::new(machine),
            step: settings.step.to_bits(),
            spacing: scale.spacing.to_bits(),
            closes: scale.closes,
            cells: settings.cells,
            anchor: scale.anchor(speed),
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
        let system = StateSpace::new(machine, structure).ok_or(ExponentialError::Singular { part: "the rotor" })?;
        let outputs = Outputs::new(machine, structure);
        let direct = outputs.feedthrough(&system);
        let measures = SectionLoadModel::new(machine, structure, &system, outputs.weight());
        let grid =
            SpeedGrid::new(LateralModel { state_space: system, outputs, measures }, scale, settings.cells, speed)?;
        let shared = Arc::new(Self { grid, feedthrough: direct });
        if kept.len() == MAX_KEPT_MODELS {
            kept.remove(0);
        }
        kept.push((key, Arc::clone(&shared)));
        Ok(shared)
    }
}

/// The candidates of the first diaphragm for contact steps of `step` \[s\]: those that the ring keeps, or new ones.
pub(crate) fn ring_points_of(
    machine: &Machine,
    structure: &Structure,
    step: f64,
) -> Result<Arc<RingPoints>, ExponentialError> {
    let rings: &RingCache = ring_of(structure, 0)?.engine_cache.get();
    let key = (step.to_bits(), face(&machine.diaphragms[0].contact));
    let kept = &mut *rings.0.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, found)) = kept.iter().find(|(other, _)| *other == key) {
        return Ok(Arc::clone(found));
    }
    let made = Arc::new(ring_points(&machine.diaphragms[0], structure, 0, step)?);
    if kept.len() == MAX_KEPT_MODELS {
        kept.remove(0);
    }
    kept.push((key, Arc::clone(&made)));
    Ok(made)
}

/// Radius of an inner face.
fn face(contact: &Contact) -> Option<u64> {
    (contact.surface == ContactSurface::InnerFace).then(|| (contact.rotor_radius + contact.gap).to_bits())
}
