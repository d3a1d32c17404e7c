//! Which engine computes a machine: what its file names, or what `run.engine = "auto"` comes to.
//!
//! A machine alone is asked once ([`MachineDef::engine`](super::MachineDef::engine)). A study asks of all its samples, and gives the answer to every
//! one ([`MachineDef::settle`](super::MachineDef::settle)): between samples of several engines there would be differences that no parameter makes.

use super::model::Engine;
use super::schema::{CONTACT_STEP, STEP};
use std::fmt;

/// Whether values of this path may decide what `run.engine = "auto"` comes to; of all others it is independent.
#[must_use]
pub fn decides_engine(path: &str) -> bool {
    let of_ring = [".kind", ".contact.detection", ".contact.points", ".ring.elements", ".blades.count"];
    [STEP, CONTACT_STEP, "rotor.initial_speed", "run.force_location"].contains(&path)
        || path.starts_with("rotor.speed_law.")
        || of_ring.iter().any(|ending| path.ends_with(ending))
}

/// Something of a machine that the exponential engine does not cover.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotCovered {
    /// Path of the value, or of its table.
    pub path: String,
    /// What it makes of the machine: "a rigid ring".
    pub what: String,
}

impl fmt::Display for NotCovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.what, self.path)
    }
}

/// Why it is that engine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EngineReason {
    /// `run.engine` names it.
    Named,
    /// `run.contact_step` is given, which only it has.
    ContactStep,
    /// `run.step` is given, which the exponential engine has not.
    Step,
    /// The exponential engine covers all of it.
    Covered,
    /// It does not cover this, the first of all.
    NotCovered(NotCovered),
    /// It cannot start, for this reason.
    NoStart(String),
    /// The result directory was begun with it.
    Begun,
}

/// The engine of a machine, or of all samples of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EngineChoice {
    /// Which.
    pub engine: Engine,
    /// Why.
    pub reason: EngineReason,
}

impl EngineChoice {
    /// Whether `run.engine = "auto"` came to it.
    #[must_use]
    pub fn is_auto(&self) -> bool {
        self.reason != EngineReason::Named
    }

    /// Engine and reason in words; `all`: what is covered, "the machine" or "every sample".
    #[must_use]
    pub fn words(&self, all: &str) -> String {
        let why = match &self.reason {
            EngineReason::Named => return format!("{} (run.engine names it)", self.engine.word()),
            EngineReason::ContactStep => "run.contact_step is given, which only this engine has".to_owned(),
            EngineReason::Step => "run.step is given, which \"exponential\" does not have".to_owned(),
            EngineReason::Covered => format!("it covers {all}"),
            EngineReason::NotCovered(what) => format!("\"exponential\" does not cover {what}"),
            EngineReason::NoStart(why) => format!("\"exponential\" cannot start: {why}"),
            EngineReason::Begun => "the result directory was created with it".to_owned(),
        };
        format!("{} (run.engine = \"{}\": {why})", self.engine.word(), Engine::AUTO)
    }
}
