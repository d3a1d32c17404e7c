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
//! Verified by `dry_whip_threshold_converges_with_order_two`, `a_loaded_start_has_the_velocity_asked_for` in `tests/rub.rs`,
//! `a_light_damped_node_starts_with_the_velocity_asked_for` in `tests/stresses.rs`.

use super::shaft_line::{distance, norm};
use super::{ContactFailure, Run, TOLERANCE};
use crate::linalg::{Matrix, axpy, dot, mul_vec};
use crate::outcome::Cause;
use crate::structure::Structure;

/// Rounds (1) at most.
const ROUNDS: usize = 2000;
/// Rounds (2) at most after them.
const EXACT_ROUNDS: usize = 100;

/// The correction (2), lateral and twist one after the other.
struct Exact {
    blocks: [Matrix; 2],
    /// Rank-one terms `u y^T` that the rounds have added.
    secants: Vec<(Vec<f64>, Vec<f64>)>,
    /// The last correction and the error it was for.
    last: Option<(Vec<f64>, Vec<f64>)>,
}

impl Exact {
    fn times(&self, error: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; error.len()];
        let lateral = self.blocks[0].nrows();
        mul_vec(&self.blocks[0], &error[..lateral], &mut product[..lateral]);
        mul_vec(&self.blocks[1], &error[lateral..], &mut product[lateral..]);
        for (u, y) in &self.secants {
            axpy(dot(y, error), u, &mut product);
        }
        product
    }

    fn correction(&mut self, error: Vec<f64>) -> Vec<f64> {
        if let Some((step, before)) = self.last.take() {
            let gained: Vec<f64> = before.iter().zip(&error).map(|(a, b)| a - b).collect();
            let (square, expected) = (dot(&gained, &gained), self.times(&gained));
            if square > 0.0 {
                let u = step.iter().zip(&expected).map(|(s, e)| (s - e) / square).collect();
                self.secants.push((u, gained));
            }
        }
        let step = self.times(&error);
        self.last = Some((step.clone(), error));
        step
    }
}

impl Run<'_> {
    /// Turns the fictitious increments before t = 0 into those that centre the first step, contact included, on v0.
    ///
    /// # Errors
    /// The cause of a step that cannot be computed, [`Cause::Diverged`] of rounds that do not settle.
    pub(super) fn load_start(&mut self, structure: &Structure) -> Result<(), Cause> {
        if !self.rub.as_ref().is_some_and(super::Rub::is_spring) {
            return Ok(());
        }
        // no contact force: the prediction is centred on v0 by construction
        self.begin_step();
        self.predict()?;
        let centre = |d: &[f64], previous: &[f64]| -> Vec<f64> { d.iter().zip(previous).map(|(a, b)| a + b).collect() };
        let wanted = centre(&self.d, &self.line.lateral.previous);
        let wanted_twist = centre(&self.d_twist, &self.line.twist.previous);
        let mut settled = false;
        let mut exact = None;
        for round in 0..ROUNDS + EXACT_ROUNDS {
            self.begin_step();
            self.predict()?;
            // no force, nothing to centre; next to the gap that depends, besides the place, on the increments before, which rounds move
            if !self.first_contact()? {
                settled = true;
                break;
            }
            let found = centre(&self.d, &self.line.lateral.previous);
            let found_twist = centre(&self.d_twist, &self.line.twist.previous);
            if round == ROUNDS {
                let blocks = self.line.centring(structure).ok_or(Cause::Diverged)?;
                exact = Some(Exact { blocks, secants: Vec::new(), last: None });
            }
            let shift = |previous: &[f64], wanted: &[f64], found: &[f64]| -> Vec<f64> {
                previous.iter().zip(wanted.iter().zip(found)).map(|(p, (w, f))| p + 0.5 * (w - f)).collect()
            };
            let (lateral, twist) = match &mut exact {
                None => (
                    shift(&self.line.lateral.previous, &wanted, &found),
                    shift(&self.line.twist.previous, &wanted_twist, &found_twist),
                ),
                Some(exact) => {
                    let less = |wanted: &[f64], found: &[f64]| -> Vec<f64> {
                        wanted.iter().zip(found).map(|(w, f)| w - f).collect()
                    };
                    let step = exact.correction([less(&wanted, &found), less(&wanted_twist, &found_twist)].concat());
                    let (mut lateral, mut twist) =
                        (self.line.lateral.previous.clone(), self.line.twist.previous.clone());
                    axpy(1.0, &step[..lateral.len()], &mut lateral);
                    axpy(1.0, &step[lateral.len()..], &mut twist);
                    (lateral, twist)
                }
            };
            self.line.restart(&lateral, &twist);
            // a rotor that rests on its spring has increments of rounding alone
            settled = distance(&found, &wanted) <= TOLERANCE * self.line.lateral_scale(norm(&lateral))
                && distance(&found_twist, &wanted_twist) <= TOLERANCE * norm(&twist).max(self.line.twist_scale());
            if settled {
                break;
            }
        }
        self.before = [self.line.lateral.previous.clone(), self.line.lateral.previous.clone()];
        self.twist_before = self.line.twist.previous.clone();
        self.d.copy_from_slice(&self.line.lateral.previous);
        self.d_twist.copy_from_slice(&self.line.twist.previous);
        self.iterations = 0;
        if let Some(rub) = &mut self.rub {
            rub.iterations = 0;
        }
        if settled { Ok(()) } else { Err(Cause::Diverged) }
    }

    /// The step from n, without contact so far.
    pub(super) fn begin_step(&mut self) {
        self.line.prepare();
        if let Some(rub) = &mut self.rub {
            rub.prepare();
        }
    }

    fn first_contact(&mut self) -> Result<bool, Cause> {
        let Some(rub) = &mut self.rub else { return Ok(false) };
        match rub.correct(&mut self.line, self.time, &mut self.d, &mut self.d_twist) {
            Ok(contact) => Ok(contact.is_some()),
            Err(ContactFailure::NotUnique(_)) => Err(Cause::LossOfUniqueness),
            Err(ContactFailure::NoConvergence) => Err(Cause::Diverged),
        }
    }
}
