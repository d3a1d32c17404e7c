//! Start under contact: a massless radial spring may be loaded at t = 0.
//!
//! `d- = dt v0 - dt^2 a0/2` makes the first step second order only with the complete a0, including contact and friction. Otherwise the rotor starts
//! with a velocity error of `a_contact dt/2`, and the whole run is first order in dt.
//! ```text
//! e = 2 dt v0 - (d + d-):     d-  +=  e/2                                   gains a factor of x/(1 + x),  x = c dt/(2 m)      (1)
//! A d = (A - C/dt) d- + f:    d-  +=  (dt^2/2) M^-1 A e = e/2 + (dt/4) M^-1 C e     exact where f does not depend on d-        (2)
//! ```
//! Rounds (2) follow if (1) does not converge: a light node with strong damping. Secants (Broyden's second method) account for the terms of f that do
//! depend on d-: sticking, the brake, gyroscopic moments.
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

/// Maximum number of rounds (1).
const ROUNDS: usize = 2000;
/// Maximum number of rounds (2) after them.
const EXACT_ROUNDS: usize = 100;

/// Corrects the fictitious increments before t = 0 so that the first step, contact included, is centred on the velocity v0.
///
/// # Errors
/// Cause of a step that cannot be computed; [`Cause::Diverged`] if the rounds do not converge.
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
        // without force the prediction is already centred; close to the gap, contact depends also on the increments before
        // t = 0, which the rounds change
        if motion.contacts.iter().all(Option::is_none) {
            settled = true;
            break;
        }
        if round == ROUNDS {
            exact = Some(Centring::new(&motion.line, structure).ok_or(Cause::Diverged)?);
        }
        let (found, mut previous) = (centred(motion), motion.line.previous());
        let error = |wanted: &[f64], found: &[f64]| wanted.iter().zip(found).map(|(w, f)| w - f).collect();
        let error = Increments {
            lateral: error(&wanted.lateral, &found.lateral),
            torsion: error(&wanted.torsion, &found.torsion),
        };
        match &mut exact {
            None => {
                axpy(0.5, &error.lateral, &mut previous.lateral);
                axpy(0.5, &error.torsion, &mut previous.torsion);
            }
            Some(exact) => exact.correct(&error, &mut previous),
        }
        motion.line.come_from(&previous);
        // increments of a rotor at rest on its spring are mere rounding
        let scale = motion.line.lateral_scale(norm(&previous.lateral));
        let torsional_scale = norm(&previous.torsion).max(motion.line.torsional_scale());
        settled = distance(&found.lateral, &wanted.lateral) <= TOLERANCE * scale
            && distance(&found.torsion, &wanted.torsion) <= TOLERANCE * torsional_scale;
        if settled {
            break;
        }
    }
    motion.restart();
    if settled { Ok(()) } else { Err(Cause::Diverged) }
}

/// Twice the centred increments of the first step.
fn centred(motion: &Motion<'_>) -> Increments {
    let previous = motion.line.previous();
    let sum = |d: &[f64], previous: &[f64]| d.iter().zip(previous).map(|(a, b)| a + b).collect();
    Increments {
        lateral: sum(&motion.d.lateral, &previous.lateral),
        torsion: sum(&motion.d.torsion, &previous.torsion),
    }
}
