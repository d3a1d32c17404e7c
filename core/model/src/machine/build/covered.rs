//! Coverage of the exponential engine. A machine outside of it is rejected with name and position where the file requests that engine; with
//! `run.engine = "auto"`, the coverage determines the engine.

use super::path::joined;
use super::reader::Reader;
use crate::machine::engine::{EngineChoice, EngineReason, NotCovered};
use crate::machine::model::Engine;
use crate::machine::schema::{CONTACT_STEP, END_TIME, ENGINE, STEP};
use bladeoff_text::document::units::format_quantity;

/// Group of the tables of torques.
const TORQUES: &str = "torques";

/// The engine of a machine and the reason; `None`: `run.engine` is invalid.
pub(in crate::machine) fn choose(reader: &Reader<'_>) -> Option<EngineChoice> {
    let word = reader.word(ENGINE)?;
    let (engine, reason) = match Engine::from_word(word) {
        Some(engine) => (engine, EngineReason::Named),
        // `check` checks the coverage
        None if reader.number(CONTACT_STEP).is_some() => (Engine::Exponential, EngineReason::ContactStep),
        None if reader.number(STEP).is_some() => (Engine::Reduced, EngineReason::Step),
        // neglected effects of torsional vibration may change loads by per cents, so a user who accepts them has to name the engine
        None if !reader.layout.group(TORQUES).is_empty() && reader.is_point_mass() == Some(false) => {
            (Engine::Reduced, EngineReason::NotCovered(neglected()))
        }
        None => match gaps(reader).into_iter().next() {
            Some(Gap { not_covered, .. }) => (Engine::Reduced, EngineReason::NotCovered(not_covered)),
            None => (Engine::Exponential, EngineReason::Covered),
        },
    };
    Some(EngineChoice { engine, reason })
}

/// Effect that the engine neglects where torques excite torsional vibration.
fn neglected() -> NotCovered {
    NotCovered { path: TORQUES.to_owned(), what: "gyroscopic moments of torsional vibration".to_owned() }
}

pub(super) fn check(reader: &mut Reader<'_>) {
    let Some(EngineChoice { engine, reason }) = choose(reader) else { return };
    if engine != Engine::Exponential {
        if reader.number(CONTACT_STEP).is_some() {
            // the message does not suggest an engine that would be rejected in turn
            let is_covered = gaps(reader).is_empty() && reader.number(STEP).is_none();
            let allowed = if is_covered { "run.step, or run.engine = \"exponential\"" } else { "run.step" };
            reader.fail(CONTACT_STEP, "only the engine \"exponential\" has a contact step", allowed);
        }
        return;
    }
    if let (Some(step), Some(end)) = (reader.number(CONTACT_STEP), reader.number(END_TIME))
        && step > end
    {
        let allowed = format!("at most run.end_time = {}", format_quantity(end, "s"));
        reader.fail(CONTACT_STEP, "longer than the whole run", allowed);
    }
    let has_step = reader.number(CONTACT_STEP).is_some();
    // a study has set the engine of its samples, for the same reason as for a single machine
    let is_settled = reader.is_default(ENGINE);
    let (asked, otherwise) = match reason {
        EngineReason::Named if has_step && !is_settled => ("", "run.engine = \"reduced\" and no run.contact_step"),
        _ if has_step => (", which run.contact_step asks for,", "no run.contact_step"),
        _ => ("", "run.engine = \"reduced\""),
    };
    if reader.number(STEP).is_some() {
        let message = format!("the engine \"exponential\"{asked} has no equal steps");
        let instead = if asked.is_empty() { "run.contact_step" } else { "no run.step" };
        reader.fail(STEP, message, format!("{instead}, or {otherwise}"));
    }
    for Gap { not_covered: NotCovered { path, what }, instead } in gaps(reader) {
        let message = format!("the engine \"exponential\"{asked} does not cover {what}");
        reader.fail(&path, message, format!("{instead}, or {otherwise}"));
    }
}

/// An uncovered property of a machine, and the covered alternative.
struct Gap {
    not_covered: NotCovered,
    instead: &'static str,
}

/// All uncovered properties, in the order of reporting. Each follows from one value, so that a study that varies values can check each alone.
fn gaps(reader: &Reader<'_>) -> Vec<Gap> {
    let mut gaps = Vec::new();
    let mut gap = |path: &str, what: &str, instead: &'static str| {
        gaps.push(Gap { not_covered: NotCovered { path: path.to_owned(), what: what.to_owned() }, instead });
    };
    if reader.word("run.force_location") == Some("current") {
        gap("run.force_location", "forces at the place of step n", "next");
    }
    for member in reader.layout.group("diaphragms") {
        let path = |key: &str| joined(&["diaphragms.", &member.name, key]);
        let (kind, blades) = (path(".kind"), path(".blades.count"));
        let is_flexible = !matches!(reader.word(&kind), Some("rigid" | "radial-spring"));
        if is_flexible && reader.number(&blades) == Some(0.0) {
            gap(&blades, "a ring that nothing holds", "blades");
        }
    }
    gaps
}
