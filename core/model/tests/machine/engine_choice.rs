//! `run.engine = "auto"`: the exponential engine, except for the list of docs/machines.md.

use crate::common::shipped;
use bladeoff_model::machine::{Engine, EngineReason, MachineDef};

/// Replaces a piece of the lab rig; returns the engine that `auto` selects, and the uncovered property.
fn choice(piece: &str, by: &str) -> (Engine, Option<String>) {
    let text = shipped("lab_rig");
    assert!(text.contains(piece), "{piece}");
    let def = MachineDef::parse("rig.toml", &text.replace(piece, by)).unwrap_or_else(|problems| panic!("{problems}"));
    let choice = def.engine().expect("a choice");
    match choice.reason {
        EngineReason::NotCovered(what) => (choice.engine, Some(what.to_string())),
        _ => (choice.engine, None),
    }
}

/// The lab rig with another stator: its lines from the diaphragm to the contact.
fn stator(lines: &str) -> (Engine, Option<String>) {
    let text = shipped("lab_rig");
    let from = text.find("[diaphragms.seal]").expect("a diaphragm");
    let to = text.find("[diaphragms.seal.contact]").expect("a contact");
    choice(&text[from..to], &format!("[diaphragms.seal]\n{lines}\n"))
}

#[test]
fn auto_is_the_exponential_engine_but_for_a_short_list() {
    let contact = "[diaphragms.seal.contact]\n";
    let listed = [
        (
            "forces at the place of step n",
            choice("end_time = \"0.6 s\"", "end_time = 0.6\nforce_location = \"current\""),
        ),
        ("a ring that nothing holds", choice("count = 8", "count = 0")),
    ];
    for (what, (engine, told)) in listed {
        assert_eq!(engine, Engine::Reduced, "{what}");
        assert!(told.as_ref().is_some_and(|told| told.starts_with(what)), "{what}: {told:?}");
    }
    let law = "[rotor.speed_law]\nacceleration = -50\n[rotor.damping]";
    let covered = [
        choice("detection = \"hyp2\"", "detection = \"hyp1\""),
        choice("detection = \"hyp2\"", "detection = \"hyp2-frozen\""),
        choice(contact, &format!("{contact}points = \"one\"\n")),
        choice("friction = 0.15", "friction = 0.15\nfriction_law = \"slip\""),
        choice("[rotor.damping]", law),
        choice("initial_speed = \"3000 rpm\"", "initial_speed = 0\nspeed_law = { acceleration = 50 }"),
        choice("initial_speed = \"3000 rpm\"", "initial_speed = 0"),
        choice("elements = 16", "elements = 208"),
        stator("kind = \"radial-spring\"\nstiffness = 1e6"),
        stator("kind = \"rigid\""),
    ];
    for (case, found) in covered.into_iter().enumerate() {
        assert_eq!(found, (Engine::Exponential, None), "case {case}");
    }
}
