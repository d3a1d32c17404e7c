//! A start under contact: a massless radial spring may be loaded at t = 0.
//!
//! `d- = dt v0 - dt^2 a0/2` makes the first step second order only with the whole a0, contact and friction included.
//! Without it the rotor starts with a velocity that is wrong by `a_contact dt/2`, and the whole run is first order in dt.
//! ```text
//! e = 2 dt v0 - (d + d-):     d-  +=  e/2                                   gains a factor of x/(1 + x),  x = c dt/(2 m)      (1)
//! A d = (A - C/dt) d- + f:    d-  +=  (dt^2/2) M^-1 A e = e/2 + (dt/4) M^-1 C e     exact where f does not depend on d-        (2)
//! ```
//! (2) where (1) does not settle: a light node under strong damping. What f does depend on (stick, the brake, gyroscopic moments)
//! comes in by secants, Broyden's second method.
//! Source: the scheme of `stepper`; Broyden, Math. Comp. 19 (1965), 577-593.
//! Verified by `dry_whip_threshold_converges_with_order_two`, `a_loaded_start_has_the_velocity_asked_for` in `tests/contact/rub.rs`,
//! `a_light_damped_node_starts_with_the_velocity_asked_for` in `tests/runs/stresses.rs`.

use super::centring::Centring;
use crate::engine::motion::Motion;
use crate::engine::predictor::TOLERANCE;
use crate::engine::rub::Rub;
use crate::engine::shaft_line::Increments;
use crate::structure::Structure;
use bladeoff_model::outcome::Cause;
use bladeoff_numerics::linalg::{axpy, distance, norm};

/// Rounds (1) at most.
const ROUNDS: usize = 2000;
/// Rounds (2) at most after them.
const EXACT_ROUNDS: usize = 100;

/// Turns the fictitious increments before t = 0 into those that centre the first step, contact included, on v0.
///
/// # Errors
/// The cause of a step that cannot be computed, [`Cause::Diverged`] of rounds that do not settle.
pub(super) fn load(motion: &mut Motion<'_>, structure: &Structure) -> Result<(), Cause> {
    if !motion.rubs.iter().any(Rub::is_spring) {
        return Ok(());
    }
    // no contact force: the prediction is centred on v0 by construction
    motion.predict()?;
    let wanted = centred(motion);
    let mut settled = false;
    let mut exact = None;
    for round in 0..ROUNDS + EXACT_ROUNDS {
        motion.solve()?;
        // no force, nothing to centre; next to the gap that depends, besides the place, on the increments before, which rounds move
        if motion.contacts.iter().all(Option::is_none) {
            settled = true;
            break;
        }
        if round == ROUNDS {
            exact = Some(Centring::new(&motion.line, structure).ok_or(Cause::Diverged)?);
        }
        let (found, mut previous) = (centred(motion), motion.line.previous());
        let error = |wanted: &[f64], found: &[f64]| wanted.iter().zip(found).map(|(w, f)| w - f).collect();
        let error =
            Increments { lateral: error(&wanted.lateral, &found.lateral), twist: error(&wanted.twist, &found.twist) };
        match &mut exact {
            None => {
                axpy(0.5, &error.lateral, &mut previous.lateral);
                axpy(0.5, &error.twist, &mut previous.twist);
            }
            Some(exact) => exact.correct(&error, &mut previous),
        }
        motion.line.come_from(&previous);
        // a rotor that rests on its spring has increments of rounding alone
        let scale = motion.line.lateral_scale(norm(&previous.lateral));
        let twist_scale = norm(&previous.twist).max(motion.line.twist_scale());
        settled = distance(&found.lateral, &wanted.lateral) <= TOLERANCE * scale
            && distance(&found.twist, &wanted.twist) <= TOLERANCE * twist_scale;
        if settled {
            break;
        }
    }
    motion.restart();
    if settled { Ok(()) } else { Err(Cause::Diverged) }
}

/// Twice the increments of the first step, centred.
fn centred(motion: &Motion<'_>) -> Increments {
    let previous = motion.line.previous();
    let sum = |d: &[f64], previous: &[f64]| d.iter().zip(previous).map(|(a, b)| a + b).collect();
    Increments { lateral: sum(&motion.d.lateral, &previous.lateral), twist: sum(&motion.d.twist, &previous.twist) }
}
