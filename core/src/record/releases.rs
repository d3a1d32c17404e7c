//! Releases of unbalances: when and at which speed each happened, and the energy of the released masses.

use super::peak::At;
use super::row::Row;
use bladeoff_model::machine::Rotor;

/// One unbalance with a release.
#[derive(Debug, Clone)]
struct Released {
    /// Place in the machine's list, and name.
    unbalance: usize,
    name: String,
    at: Option<At>,
    /// The release happened while all guards held.
    guarded: bool,
}

/// Records the releases of a machine, in the order of the file.
#[derive(Debug, Clone)]
pub(crate) struct ReleaseRecorder(Vec<Released>);

impl ReleaseRecorder {
    /// An unbalance that is released at once has happened at t = 0.
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

    /// Takes the release of an unbalance.
    pub fn see(&mut self, unbalance: usize, at: At) {
        self.0.iter_mut().filter(|one| one.unbalance == unbalance).for_each(|one| one.at = Some(at));
    }

    /// All guards hold.
    pub fn hold(&mut self) {
        self.0.iter_mut().for_each(|one| one.guarded = one.at.is_some());
    }

    /// `energy`: energy of the released masses; `None` where columns alone are asked for.
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
