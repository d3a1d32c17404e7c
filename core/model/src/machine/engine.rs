//! Selection of the engine: the one that the file names, or the result of `run.engine = "auto"`.
//!
//! For a single machine, the selection is made once ([`MachineDef::engine`](super::MachineDef::engine)). A study checks all its samples and uses
//! one engine for all of them ([`MachineDef::settle`](super::MachineDef::settle)): samples of different engines would differ without a
//! change of any parameter.

use super::model::Engine;
use super::schema::{CONTACT_STEP, STEP};
use std::fmt;

/// Whether values of this path can change the result of `run.engine = "auto"`, which is independent of all other paths.
#[must_use]
pub fn decides_engine(path: &str) -> bool {
    let of_ring = [".kind", ".contact.detection", ".contact.points", ".ring.elements", ".blades.count"];
    [STEP, CONTACT_STEP, "rotor.initial_speed", "run.force_location"].contains(&path)
        || path.starts_with("rotor.speed_law.")
        || of_ring.iter().any(|ending| path.ends_with(ending))
}

/// A property of a machine that the exponential engine does not cover.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotCovered {
    /// Path of the value, or of its table.
    pub path: String,
    /// Description of the property: "a rigid ring".
    pub what: String,
}

impl fmt::Display for NotCovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.what, self.path)
    }
}

/// Reason for the selection of an engine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EngineReason {
    /// `run.engine` names it.
    Named,
    /// `run.contact_step` is given, which only the exponential engine has.
    ContactStep,
    /// `run.step` is given, which the exponential engine does not have.
    Step,
    /// The exponential engine covers the whole machine.
    Covered,
    /// The first property that the exponential engine does not cover.
    NotCovered(NotCovered),
    /// The exponential engine cannot start, for this reason.
    NoStart(String),
    /// The result directory was begun with this engine.
    Begun,
}

/// The engine of a machine, or of all samples of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EngineChoice {
    /// Selected engine.
    pub engine: Engine,
    /// Reason.
    pub reason: EngineReason,
}

impl EngineChoice {
    /// Whether `run.engine = "auto"` selected the engine.
    #[must_use]
    pub fn is_auto(&self) -> bool {
        self.reason != EngineReason::Named
    }

    /// Engine and reason in words. `all` names the covered object: "the machine" or "every sample".
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
