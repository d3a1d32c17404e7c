//! Observation of a run: the observable state at an instant, and the interface of an observer.

use super::energies::Energies;

/// State of a run at step n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Mean spin angle \[rad\].
    pub angle: f64,
    /// Mean spin \[rad/s\].
    pub speed: f64,
    /// Lateral nodal displacements [m, rad], indexed by [`crate::rotor::RotorMatrices::u`] and its siblings.
    pub displacement: &'a [f64],
    /// Lateral nodal velocities [m/s, rad/s].
    pub velocity: &'a [f64],
    /// Torsion angle of each node relative to the mean spin angle \[rad\], positive in the direction of positive spin.
    pub torsion_angles: &'a [f64],
    /// Bearing loads `K (x - e) + C x'`, in the machine's order \[N\]; x includes the static response of the truncated modes, e is the
    /// elevation of the seat.
    pub bearing_loads: &'a [[f64; 2]],
    /// Pedestal loads `K x + C x'`, in the order of the bearings with a pedestal \[N\].
    pub pedestal_loads: &'a [[f64; 2]],
    /// Contact with each diaphragm, in the machine's order.
    pub contacts: &'a [ContactFrame<'a>],
    /// Energies of the last balance at or before this instant \[J\].
    pub energies: Energies,
}

/// Contact with one diaphragm at one instant, in the stator's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFrame<'a> {
    /// Position of the rotor centre relative to the diaphragm's centre \[m\].
    pub rotor: [f64; 2],
    /// Gap in the run's own gap function \[m\], negative for penetration: the residual gap after the contact force of the previous step.
    pub gap: f64,
    /// Contact angle \[rad\].
    pub angle: f64,
    /// Normal force \[N\].
    pub normal_force: f64,
    /// Friction force \[N\].
    pub friction_force: f64,
    /// Slip velocity \[m/s\]; 0 without contact.
    pub slip: f64,
    /// Radial and tangential displacement of the ring at the contact point \[m\]. The static response of the truncated modes is that to the
    /// contact force of the previous step, as for the gap.
    pub ring: [f64; 2],
    /// Nodal degrees of freedom `[u, u_s, v, v_s]` of the flexible ring, without blade nodes; `None` without a flexible ring.
    pub field: Option<&'a [f64]>,
}

/// Observer of a run. An observer cannot change the run.
pub trait Follower {
    /// Receives the normal contact force of a step on one diaphragm \[N\], zero without contact. `_diaphragm`: its index in the machine's
    /// order. The method is called for every step, because the forces of single steps are not converged, and before [`Follower::see`] of
    /// that step.
    fn contact_force(&mut self, _diaphragm: usize, _time: f64, _force: f64) {}
    /// Returns whether the run continues. It is called before each step of the run and then of its twin, with consecutive step numbers; they
    /// begin again with a run that is repeated with a finer step. A run that is not continued ends as at its step limit.
    fn goes_on(&mut self, _step: u64) -> bool {
        true
    }
    /// Returns whether the observer needs the instant; called once per step.
    fn wants(&mut self, step: u64, time: f64) -> bool;
    /// Returns whether the observer also needs the final instant of the run, in addition to those of [`Follower::wants`]. Its state, time
    /// and spin are those of the row. Its velocities, loads and contact force are those of a step that would follow.
    fn wants_end(&mut self) -> bool {
        false
    }
    /// Returns whether the observer needs the separate energies of a frame. Otherwise an engine may compute only their sum.
    fn wants_energies(&self) -> bool {
        true
    }
    /// Returns whether the observer needs any instant or contact force. If not, the engine passes it none.
    fn follows(&self) -> bool {
        true
    }
    /// Returns whether the observer may be shown a run again from its start, with a finer step. Otherwise the step is found by runs that it does
    /// not observe.
    fn begins_again(&self) -> bool {
        !self.follows()
    }
    /// Receives an instant.
    fn see(&mut self, frame: &Frame<'_>);
}

/// Observer that needs nothing.
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
