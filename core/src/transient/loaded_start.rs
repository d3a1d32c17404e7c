//! A start under contact: a massless radial spring may be loaded at t = 0.
//!
//! `d- = dt v0 - dt^2 a0/2` makes the first step second order only with the whole a0, contact and friction included.
//! Without it the rotor starts with a velocity that is wrong by `a_contact dt/2`, and the whole run is first order in dt.
//! Verified by `dry_whip_threshold_converges_with_order_two`, `a_loaded_start_has_the_velocity_asked_for` in `tests/rub.rs`.

use super::shaft_line::{distance, norm};
use super::{Run, TOLERANCE};
use crate::outcome::Cause;

/// Rounds at most: each gains a factor of `x/(1 + x)`, `x = c dt/(2 m)` of the damping, beside what friction changes.
const ROUNDS: usize = 2000;

impl Run<'_> {
    /// Turns the fictitious increments before t = 0 into those that centre the first step, contact included, on v0.
    ///
    /// # Errors
    /// The cause of a step that cannot be computed, [`Cause::Diverged`] of rounds that do not settle.
    pub(super) fn load_start(&mut self) -> Result<(), Cause> {
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
        for _ in 0..ROUNDS {
            self.begin_step();
            self.predict()?;
            // whether it touches depends on the place alone, which no round moves
            if !self.first_contact()? {
                settled = true;
                break;
            }
            let found = centre(&self.d, &self.line.lateral.previous);
            let found_twist = centre(&self.d_twist, &self.line.twist.previous);
            let shift = |previous: &[f64], wanted: &[f64], found: &[f64]| -> Vec<f64> {
                previous.iter().zip(wanted.iter().zip(found)).map(|(p, (w, f))| p + 0.5 * (w - f)).collect()
            };
            let lateral = shift(&self.line.lateral.previous, &wanted, &found);
            let twist = shift(&self.line.twist.previous, &wanted_twist, &found_twist);
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
            Err(failure) => Err(failure.cause()),
        }
    }
}
