//! What `run.engine = "exponential"` covers; what it does not is refused here, by name and place.

use super::path::joined;
use super::reader::Reader;
use crate::document::units::format_quantity;
use crate::machine::model::{Detection, Engine};
use crate::machine::schema::{CONTACT_STEP, END_TIME, ENGINE, STEP};

pub(super) fn check(reader: &mut Reader<'_>) {
    if reader.word(ENGINE).and_then(Engine::from_word) != Some(Engine::Exponential) {
        if reader.number(CONTACT_STEP).is_some() {
            let allowed = "run.step, or run.engine = \"exponential\"";
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
    if reader.number(STEP).is_some() {
        let allowed = "run.contact_step, or run.engine = \"reduced\"";
        reader.fail(STEP, "the engine \"exponential\" has no equal steps", allowed);
    }
    if reader.number("rotor.initial_speed") == Some(0.0) {
        refuse(reader, "rotor.initial_speed", "a rotor at rest", "a speed above 0");
    }
    for law in ["acceleration", "times", "speeds"] {
        let path = joined(&["rotor.speed_law.", law]);
        if reader.is_given(&path) {
            refuse(reader, &path, "a prescribed speed", "none");
        }
    }
    if reader.word("run.force_location") == Some("current") {
        refuse(reader, "run.force_location", "forces at the place of step n", "next");
    }
    let names: Vec<String> = reader.layout.group("diaphragms").iter().map(|member| member.name.clone()).collect();
    for name in names {
        let path = |key: &str| joined(&["diaphragms.", &name, ".", key]);
        let (kind, detection, points) = (path("kind"), path("contact.detection"), path("contact.points"));
        match reader.word(&kind) {
            Some("rigid") => refuse(reader, &kind, "a rigid ring", "flexible"),
            Some("radial-spring") => refuse(reader, &kind, "a radial spring", "flexible"),
            _ => {}
        }
        if let Some(word) = reader.word(&detection).filter(|word| *word != Detection::Hyp2.word()) {
            refuse(reader, &detection, &format!("the detection {word}"), Detection::Hyp2.word());
        }
        if reader.word(&points) == Some("one") {
            refuse(reader, &points, "a single contact point", "several");
        }
    }
}

fn refuse(reader: &mut Reader<'_>, path: &str, what: &str, instead: &str) {
    let message = format!("the engine \"exponential\" does not cover {what}");
    reader.fail(path, message, format!("{instead}, or run.engine = \"reduced\""));
}
