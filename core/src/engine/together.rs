//! Contact with several diaphragms in one step: the forces are solved together, coupled through the shaft.
//!
//! ```text
//! d = d_free + sum_i R_i F_i        increments of the step; R_i: response to the contact forces F_i at diaphragm i               (1)
//! F_i = contact(d_free + sum_{j != i} R_j F_j)      for each i in turn, until no force changes                              (2)
//! ```
//! `d_free` contains the non-linear terms of the shaft at `d`, so (2) repeats the prediction whenever another force has changed. The rounds contract
//! by the coupling of two diaphragms over a step, `W_ij W_ji/(W_ii W_jj)`, which is far below 1 for diaphragms at different positions.
//!
//! A diaphragm without contact force changes no digit: (2) checks it and adds nothing.
//! Source: block Gauss-Seidel iteration on the Delassus operator of all diaphragms.
//! Limits: the truncated modes of `reduced` follow only the forces at their own diaphragm.
//! Verified by `core/tests/contact/two_diaphragms.rs`.

use super::motion::Motion;
use super::rub::StepContact;
use super::shaft_line::OtherForces;
use bladeoff_model::outcome::Cause;

/// Maximum number of rounds over all diaphragms.
const ROUNDS: usize = 100;

impl Motion<'_> {
    /// Corrects the prediction by the contact with all diaphragms (2).
    pub(super) fn correct_together(&mut self) -> Result<(), Cause> {
        let count = self.rubs.len();
        let mut is_due = vec![true; count];
        for _ in 0..ROUNDS {
            for at in 0..count {
                if std::mem::take(&mut is_due[at]) && self.correct_one(at)? {
                    (0..count).filter(|other| *other != at).for_each(|other| is_due[other] = true);
                }
            }
            if !is_due.contains(&true) {
                self.line.others = None;
                return Ok(());
            }
        }
        self.line.others = None;
        Err(Cause::Diverged)
    }

    /// Solves the contact with one diaphragm under the forces of the others. Returns whether its force has changed.
    fn correct_one(&mut self, at: usize) -> Result<bool, Cause> {
        let before = self.contacts[at];
        self.line.others = self.forces_of_others(at);
        let mut d = self.d.clone();
        if before.is_some() {
            // prediction without the force of this diaphragm
            self.predictor.predict(&mut self.line, self.time, &mut d)?;
        }
        let found = self.rubs[at].correct(&mut self.line, self.time, &mut d)?;
        self.contacts[at] = found;
        if before.is_some() || found.is_some() {
            self.d = d;
        }
        Ok(self.rubs[at].differs(before.as_ref(), found.as_ref()))
    }

    /// Response to the forces of all other diaphragms; `None` if they have no force.
    fn forces_of_others(&self, at: usize) -> Option<OtherForces> {
        let others = self.rubs.iter().zip(&self.contacts).enumerate().filter(|(other, _)| *other != at);
        let pressed: Vec<(usize, &StepContact)> =
            others.filter_map(|(other, (_, contact))| Some((other, contact.as_ref()?))).collect();
        let mut sum = OtherForces::none(&self.line);
        for (other, contact) in &pressed {
            self.rubs[*other].respond(contact, &mut sum);
        }
        (!pressed.is_empty()).then_some(sum)
    }
}
