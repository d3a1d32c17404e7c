//! Speed interval of the grid: the lateral motion for spins about one speed, and everything that a run derives from it.
//!
//! The model of an interval is the linear interpolation of its two modal bases (`speed_grid`, equation (1)). All other quantities follow from the model, for
//! one contact step, and are computed when they are first used. Verified with `speed_grid` and by `tests/exponential/exponential.rs`.

use super::basis_change::BasisChange;
use super::bearing_tables::{BearingTables, TableChanges};
use super::dissipation::{Dissipation, ForcedDissipation};
use super::impulse_response::ImpulseResponse;
use super::interval_model::IntervalModel;
use super::modal_basis::{LateralModel, ModalBasis};
use super::outputs::{DirectFeedthrough, Outputs};
use super::propagator::Propagator;
use super::section_loads::SectionLoads;
use super::step_bounds::StepBounds;
use crate::engine::exponential::settings::MAX_DOUBLINGS;
use bladeoff_numerics::linalg::{Vector, axpy, solve};
use std::sync::{Arc, OnceLock};

/// Speed interval: the model of the lateral motion for spins about one speed, constant within it.
///
/// Quantities that are derived from the model are computed when they are first used.
#[derive(Debug)]
pub(crate) struct SpeedInterval {
    /// `b m + j` of interval j above basis b.
    pub index: i64,
    /// Distance between its two bases \[rad/s\].
    pub(super) basis_spacing: f64,
    /// Blocks, input vectors and output rows at the speed in the middle of the interval.
    pub model: IntervalModel,
    /// Share s of the upper basis, 0 to 1; 0 or 1 where the basis changes at once.
    share: f64,
    /// Bases below and above.
    pub bases: [Arc<ModalBasis>; 2],
    /// Changes of the bearing tables; empty without tables.
    pub table_changes: TableChanges,
    /// Direct feedthrough of the loads; empty without bearing tables, where it is the same at all speeds.
    pub feedthrough: Vec<DirectFeedthrough>,
    /// Basis change from the lower to the upper basis.
    pub(super) basis_change: Arc<BasisChange>,
    unbalances: usize,
    /// Propagators, by the number of doublings of the contact step.
    propagators: [OnceLock<Propagator>; MAX_DOUBLINGS + 1],
    /// First output row and first input vector of each diaphragm's node.
    contacts: Vec<[usize; 2]>,
    /// First rows of the outputs whose peaks are watched: loads of the bearings, then displacements of the diaphragms' nodes.
    watched_rows: Vec<usize>,
    /// Impulse responses, one per diaphragm.
    impulse_responses: Vec<OnceLock<ImpulseResponse>>,
    step_bounds: OnceLock<StepBounds>,
    forced_dissipation: OnceLock<ForcedDissipation>,
}

impl SpeedInterval {
    /// Interval between two bases at the share `share` of the upper one, with its speed and the distance of the bases \[rad/s\].
    pub(super) fn new(
        index: i64,
        [below, above]: [&Arc<ModalBasis>; 2],
        basis_change: Arc<BasisChange>,
        share: f64,
        [speed, basis_spacing]: [f64; 2],
        outputs: &Outputs,
    ) -> Self {
        let contacts = || 0..outputs.contacts();
        let shares = [1.0 - share, share];
        let feedthrough = below.feedthrough.iter().zip(&above.feedthrough);
        Self {
            index,
            basis_spacing,
            model: IntervalModel::between([&below.interval_model, &above.interval_model], shares, speed),
            table_changes: BearingTables::between([&below.table_changes, &above.table_changes], shares),
            feedthrough: feedthrough.map(|(lower, upper)| DirectFeedthrough::between([lower, upper], shares)).collect(),
            share,
            bases: [Arc::clone(below), Arc::clone(above)],
            basis_change,
            unbalances: outputs.unbalances(),
            propagators: Default::default(),
            contacts: contacts().map(|i| [outputs.contact_row(i), outputs.contact_input(i)]).collect(),
            watched_rows: outputs.load_rows().into_iter().chain(contacts().map(|i| outputs.contact_row(i))).collect(),
            impulse_responses: contacts().map(|_| OnceLock::new()).collect(),
            step_bounds: OnceLock::new(),
            forced_dissipation: OnceLock::new(),
        }
    }

    /// Propagator of a step of `2^doublings` contact steps of `h` \[s\].
    pub fn propagator(&self, doublings: usize, h: f64) -> &Propagator {
        self.propagators[doublings]
            .get_or_init(|| Propagator::new(&self.model, self.unbalances, h * libm::exp2(doublings as f64)))
    }

    /// Response to impulses on a diaphragm's node over a contact step of `h` \[s\].
    pub fn impulse_response(&self, diaphragm: usize, h: f64) -> &ImpulseResponse {
        self.impulse_responses[diaphragm].get_or_init(|| {
            let loads = &self.watched_rows[..self.watched_rows.len() - self.contacts.len()];
            ImpulseResponse::new(&self.model, self.propagator(0, h), h, (&self.contacts, diaphragm), loads)
        })
    }

    /// Part of the forces in the dissipation over a contact step of `h` \[s\] ([`super::dissipation`]).
    pub fn forced_dissipation(&self, dissipation: &Dissipation, h: f64) -> &ForcedDissipation {
        self.forced_dissipation.get_or_init(|| ForcedDissipation::new(&self.model, dissipation, h, self.unbalances))
    }

    /// Applies an impulse on a diaphragm's node \[N s\], along the axes u and v, to the modal state.
    pub fn apply_contact_impulse(&self, diaphragm: usize, [u, v]: [f64; 2], y: &mut [f64]) {
        let [_, input] = self.contacts[diaphragm];
        axpy(u, &self.model.input_vectors[input], y);
        axpy(v, &self.model.input_vectors[input + 1], y);
    }

    /// Bounds from which the length of a free step is chosen, for contact steps of `h` \[s\].
    pub fn step_bounds(&self, h: f64) -> &StepBounds {
        self.step_bounds
            .get_or_init(|| StepBounds::new(&self.model, (&self.watched_rows, self.contacts.len()), self.unbalances, h))
    }

    /// Section loads of its two bases.
    pub fn section_loads(&self, model: &LateralModel) -> [&SectionLoads; 2] {
        self.bases.each_ref().map(|basis| basis.section_loads(model))
    }

    /// Index of the interval, and the shares of its two bases in the interpolation.
    pub fn interpolation(&self) -> (i64, [f64; 2]) {
        (self.index, [1.0 - self.share, self.share])
    }

    /// Modal state of a motion `(q, q')`; `None` if the interpolated matrix Z is singular.
    pub fn state_of(&self, motion: &[f64]) -> Option<Vec<f64>> {
        let [below, above] = &self.bases;
        let motion_of_state = &below.motion_of_state * (1.0 - self.share) + &above.motion_of_state * self.share;
        Some(solve(&motion_of_state, &Vector::from_column_slice(motion))?.as_slice().to_vec())
    }
}
