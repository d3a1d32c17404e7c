//! Contact step with Lagrange multipliers: the contact force closes the gap at n+1.
//!
//! Contact is detected in the predicted step (without contact force), then solved at one point (`one_point`). If there is no fixed
//! point (docs/theory/03-contact.md), the step is solved at several points (`several`) or, without a solution there, at the predicted
//! place. Such steps are counted.

use super::bodies::Bodies;
use super::one_point::{Attempt, account, iterate};
use super::rounds::Work;
use super::several::Several;
use super::step_contact::{ContactFailure, StepContact};
use crate::contact::Gap;
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_model::machine::{Contact, ContactPoints, Detection, ForceLocation};

/// Method for the contact forces at one diaphragm.
pub(super) struct Multipliers {
    /// Whether the force acts at the place of n+1 or of n.
    location: ForceLocation,
    /// Solution with several points; `None` if a step without fixed point is solved at the predicted place.
    several: Option<Several>,
}

impl Multipliers {
    pub fn new(contact: &Contact, location: ForceLocation) -> Self {
        let several = contact.points == ContactPoints::Several
            && contact.detection == Detection::Hyp2
            && location == ForceLocation::Next;
        Self { location, several: several.then(Several::default) }
    }

    /// Corrects the predicted increments for contact.
    pub fn correct(
        &mut self,
        bodies: &mut Bodies<'_>,
        line: &mut ShaftLine<'_>,
        (time, x_n): (f64, [f64; 2]),
        d: &mut Increments,
        work: &mut Work,
    ) -> Result<Option<StepContact>, ContactFailure> {
        bodies.release();
        let dx = bodies.section.increment(&d.lateral);
        let x_predicted = [x_n[0] + dx[0], x_n[1] + dx[1]];
        let Some(predicted) = penetrated(bodies, x_predicted) else { return Ok(None) };
        let several_minima = bodies.stator.several_minima();
        let force_place = match self.location {
            ForceLocation::Next => None,
            ForceLocation::Current => Some(bodies.gap_at_n(x_n)),
        };
        let acting = force_place.unwrap_or(predicted);
        bodies.load_rows(&acting, &predicted);
        let sign = bodies.centred_slip(line, &acting, d).signum();
        let attempt = Attempt { time, x_n, sign, predicted, force_place, several_minima };
        let prediction = d.clone();
        let updating = bodies.stator.detection != Detection::Hyp2Frozen;
        let mut result = iterate(bodies, line, &attempt, updating, d, work)?;
        let no_fixed_point = result.is_none() && updating;
        if no_fixed_point {
            if let Some(several) = &mut self.several {
                back(bodies, &prediction, d);
                if let Some(contact) = several.correct(bodies, line, &attempt, d, work) {
                    return Ok(Some(contact));
                }
            }
            back(bodies, &prediction, d);
            result = iterate(bodies, line, &attempt, false, d, work)?;
        }
        let is_beyond = bodies.stator.is_beyond(x_predicted);
        let failure = if is_beyond { ContactFailure::Outside } else { ContactFailure::NoConvergence };
        let (force, gap) = result.ok_or(failure)?;
        if force.normal <= 0.0 {
            return Ok(None);
        }
        Ok(Some(account(bodies, line, &attempt, (force, gap, no_fixed_point), d)))
    }
}

/// Gap of a predicted rotor centre, if it penetrates the ring.
fn penetrated(bodies: &mut Bodies<'_>, x: [f64; 2]) -> Option<Gap> {
    if bodies.stator.is_far(x) {
        return None;
    }
    bodies.field_after();
    let gap = bodies.stator.own_gap(x);
    // a NaN gap is passed on to the solution, which fails
    if gap.value >= 0.0 { None } else { Some(gap) }
}

/// Restores the prediction.
fn back(bodies: &mut Bodies<'_>, prediction: &Increments, d: &mut Increments) {
    d.copy_from(prediction);
    bodies.release();
}
