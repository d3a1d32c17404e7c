//! Releases of unbalances: time and speed of each, and the energy of the released masses.

use super::peak::At;
use super::row::Row;
use bladeoff_model::machine::Rotor;

/// Release of one unbalance.
#[derive(Debug, Clone)]
struct Released {
    /// Index in the machine's list, and name.
    unbalance: usize,
    name: String,
    at: Option<At>,
    /// Whether the release occurred while all guards held.
    guarded: bool,
}

/// Recorder of a machine's releases, in the order of the file.
#[derive(Debug, Clone)]
pub(crate) struct ReleaseRecorder(Vec<Released>);

impl ReleaseRecorder {
    /// An unbalance that is released at once counts as released at t = 0.
    pub fn new(rotor: &Rotor) -> Self {
        let speed = rotor.initial_speed;
        let unbalances = rotor.unbalances.iter().enumerate().filter(|(_, one)| one.release.is_some());
        let released = unbalances.map(|(unbalance, one)| Released {
            unbalance,
            name: one.name.clone(),
            at: (!one.is_awaited(speed)).then_some(At { time: 0.0, speed }),
            guarded: false,
        });
        Self(released.collect())
    }

    /// Records the release of an unbalance.
    pub fn see(&mut self, unbalance: usize, at: At) {
        self.0.iter_mut().filter(|one| one.unbalance == unbalance).for_each(|one| one.at = Some(at));
    }

    /// Marks the releases so far as guarded.
    pub fn hold(&mut self) {
        self.0.iter_mut().for_each(|one| one.guarded = one.at.is_some());
    }

    /// Reports the columns of the releases. `energy`: energy of the released masses \[J\]; `None` if only columns are requested.
    pub(super) fn report(&self, energy: Option<f64>, row: &mut Row<'_>) {
        for Released { name, at, guarded, .. } in &self.0 {
            let time = at.map(|at| at.time);
            row.once(
                &format!("release_{name}_at_s"),
                &format!("time at which unbalance {name} was released; null: the run ended before"),
                time,
                time.filter(|_| *guarded),
            );
            row.real(
                format_args!("release_{name}_at_rad_s"),
                "rad/s",
                format_args!("mean spin at the release of unbalance {name}"),
                at.map(|at| at.speed),
            );
        }
        if !self.0.is_empty() {
            row.real(
                "released_energy_J",
                "J",
                "energy that released masses had at their release, kinetic and in gravity; negative for lost masses; 0 for those released at t = 0",
                energy,
            );
        }
    }
}
