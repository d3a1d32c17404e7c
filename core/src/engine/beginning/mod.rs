//! Start of a run: the motion at t = 0.
//!
//! `state` sets the shaft line with its `accelerations`. The rings are placed around it, and `loaded` corrects the start for a
//! contact that exists already.

mod accelerations;
mod centring;
mod loaded;
mod state;

pub(super) use state::{initial_motion, projected, steady_state};

use loaded::load;
use state::start;

use super::motion::Motion;
use super::rub::Rub;
use super::shaft_line::ShaftLine;
use super::time_step::StartError;
use crate::structure::Structure;
use bladeoff_model::machine::{Diaphragm, Machine};
use bladeoff_model::outcome::Cause;
use bladeoff_numerics::linalg::norm;

/// Motion at t = 0, and the cause of failure if no first step is possible.
///
/// # Errors
/// [`StartError`] if the machine has no valid initial state.
pub(super) fn begin<'a>(
    machine: &Machine,
    structure: &'a Structure,
    dt: f64,
) -> Result<(Motion<'a>, Option<Cause>), StartError> {
    let singular = StartError::Singular { what: "mass", part: "the rotor" };
    let mut line = ShaftLine::new(machine, structure, dt).ok_or_else(|| singular.clone())?;
    let settled = start(machine, structure, &mut line)?;
    let mut rubs = Vec::new();
    for (diaphragm, ring) in machine.diaphragms.iter().zip(&structure.rings) {
        let location = machine.run.force_location;
        let rub = Rub::new(diaphragm, structure, ring.as_ref(), &line, location).ok_or_else(|| singular.clone())?;
        rubs.push(free(rub, diaphragm, &line)?);
    }
    let mut motion = Motion::new(machine, line, rubs);
    let loaded = if settled { load(&mut motion, structure) } else { Err(Cause::Diverged) };
    Ok((motion, loaded.err()))
}

/// Checks that the rotor starts inside a diaphragm, without contact force except that of a spring.
fn free<'a>(mut rub: Rub<'a>, diaphragm: &Diaphragm, line: &ShaftLine<'_>) -> Result<Rub<'a>, StartError> {
    if rub.is_outside(line) {
        return Err(StartError::StartsOutside {
            diaphragm: diaphragm.name.clone(),
            eccentricity: norm(&rub.place(line)),
            radius: diaphragm.contact.rotor_radius + diaphragm.contact.gap,
            offset: diaphragm.contact.offset,
        });
    }
    let gap = rub.gap_at_n(line).value;
    if gap < 0.0 && !rub.is_spring() {
        return Err(StartError::StartsInContact { diaphragm: diaphragm.name.clone(), gap });
    }
    Ok(rub)
}
