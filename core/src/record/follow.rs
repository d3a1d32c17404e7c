//! Following a run from outside: what may be seen of an instant, and by whom.

use super::energies::Energies;

/// One instant of a run, at step n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Mean spin angle \[rad\].
    pub angle: f64,
    /// Mean spin \[rad/s\].
    pub speed: f64,
    /// Lateral nodal displacements [m, rad]; places by [`crate::rotor::RotorMatrices::u`] and its siblings.
    pub displacement: &'a [f64],
    /// Lateral nodal velocities.
    pub velocity: &'a [f64],
    /// Torsion angle of each node against the mean spin angle \[rad\].
    pub torsion_angles: &'a [f64],
    /// Bearing loads `K (x - e) + C x'` in the machine's order \[N\], x with the static response of the truncated modes.
    pub bearing_loads: &'a [[f64; 2]],
    /// Pedestal loads `K x + C x'`, in the order of the bearings that have one \[N\].
    pub pedestal_loads: &'a [[f64; 2]],
    /// Contact with each diaphragm, in the machine's order.
    pub contacts: &'a [ContactFrame<'a>],
    /// Energies, last balanced at or before this instant \[J\].
    pub energies: Energies,
}

/// The contact with one diaphragm at one instant, in the stator's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFrame<'a> {
    /// Rotor centre from the diaphragm's centre \[m\].
    pub rotor: [f64; 2],
    /// Gap in the run's own gap function \[m\], as the contact force of the step before left it: that force was to leave none.
    pub gap: f64,
    /// Contact angle \[rad\].
    pub angle: f64,
    /// Normal force \[N\].
    pub normal_force: f64,
    /// Friction force \[N\].
    pub friction_force: f64,
    /// Slip velocity \[m/s\]; 0 without contact.
    pub slip: f64,
    /// Displacement of the ring at the contact place: radial, tangential \[m\]; the static part of the modes left out is under the
    /// force of the step before, as for the gap.
    pub ring: [f64; 2],
    /// Nodal freedoms `[u, u_s, v, v_s]` of the flexible ring (no blade nodes), `None` without one.
    pub field: Option<&'a [f64]>,
}

/// Follows a run. It cannot change it.
pub trait Follower {
    /// The normal contact force of the step on one diaphragm, by its place in the machine's order \[N\], zero without contact: of
    /// every step, wanted or not, because single steps say little about it. Called before [`Follower::see`] of that step.
    fn contact_force(&mut self, _diaphragm: usize, _time: f64, _force: f64) {}
    /// Whether the run goes on; asked before each step, and before those of its twin, which are counted on. One that does not ends as at
    /// its step limit.
    fn goes_on(&mut self, _step: u64) -> bool {
        true
    }
    /// Whether the instant is wanted; called once per step.
    fn wants(&mut self, step: u64, time: f64) -> bool;
    /// Whether the instant at which the run ends is wanted, besides those of [`Follower::wants`]: it is the state, time and spin of
    /// the row; its velocities, loads and contact force are those of a step that would follow.
    fn wants_end(&mut self) -> bool {
        false
    }
    /// Whether the energies of a frame are wanted one by one: an engine may need their sum alone.
    fn wants_energies(&self) -> bool {
        true
    }
    /// Whether any instant or contact force is wanted: a follower that wants none is not asked again.
    fn follows(&self) -> bool {
        true
    }
    /// Takes the instant.
    fn see(&mut self, frame: &Frame<'_>);
}

/// Wants nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoHistory;

impl Follower for NoHistory {
    fn follows(&self) -> bool {
        false
    }
    fn wants_energies(&self) -> bool {
        false
    }
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        false
    }
    fn see(&mut self, _frame: &Frame<'_>) {}
}
