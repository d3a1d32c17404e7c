//! The last instant: a run's end, whatever it was, for whoever follows it.
//!
//! The state at the end is known, but centred velocities, loads and contact forces take one more step, which the row has no
//! part in: it is computed when the row is made, and nothing of it is kept. Where that step cannot be computed (it is the one
//! that failed) velocities are those of the step before and there is no contact force. Time, spin and works are the row's.

use super::Run;
use super::rub::StepContact;
use crate::outcome::Cause;
use crate::record::Follower;

impl Run<'_> {
    /// Shows the instant at which the run has ended.
    pub(super) fn show_end(&mut self, failure: Option<Cause>, follower: &mut dyn Follower) {
        if self.end_shown || !follower.wants_end() {
            return;
        }
        // a budget ends a run between two steps
        let may_go_on = matches!(failure, None | Some(Cause::StepLimit));
        let found = if may_go_on { self.one_more() } else { None };
        if found.is_none() {
            self.d.copy_from_slice(&self.line.lateral.previous);
            self.d_twist.copy_from_slice(&self.line.twist.previous);
        }
        let contact = found.flatten();
        self.line.settle(&self.d, &self.d_twist);
        let pressed = self.rub.as_ref().zip(contact.as_ref());
        let pressed = pressed.map(|(rub, contact)| (rub.node, rub.outwards(contact.on_rotor)));
        self.loads.update(&self.line, pressed);
        self.write_stores();
        self.show(contact.as_ref(), self.speed, follower);
        self.end_shown = true;
    }

    /// Shows the instant of a step that leads where no model goes, unless it has been.
    pub(super) fn show_last(&mut self, contact: Option<&StepContact>, shown: bool, follower: &mut dyn Follower) {
        if !shown && follower.wants_end() {
            self.write_stores();
            self.show(contact, self.speed, follower);
        }
        self.end_shown = true;
    }

    /// The increments of a further step and its contact; `None` if it cannot be computed.
    fn one_more(&mut self) -> Option<Option<StepContact>> {
        self.begin_step();
        self.predict().ok()?;
        match &mut self.rub {
            None => Some(None),
            Some(rub) => rub.correct(&mut self.line, self.time, &mut self.d, &mut self.d_twist).ok(),
        }
    }
}
