//! The keys of machine files and of study files, section by section.

use super::{codes, head, row};
use bladeoff_model::machine::{Key, Kind, Need, Range, keys};
use bladeoff_study::uncertain::Distribution;
use bladeoff_study::{STUDY_KEYS, STUDY_TABLES};

/// Beginning of a path, and its heading; the longest beginning that matches applies.
const SECTIONS: [(&str, &str); 17] = [
    ("", "The file"),
    ("run.", "`[run]`: end, engine, steps, modes"),
    ("run.guard.", "`[run.guard]`: numerical checks"),
    ("run.limit.", "`[run.limit.NAME]`: limits of the physical model"),
    ("rotor.", "`[rotor]`: speed, gravity, material"),
    ("rotor.shaft", "`[[rotor.shaft]]`: sections"),
    ("rotor.discs.", "`[rotor.discs.NAME]`"),
    ("rotor.bearings.", "`[rotor.bearings.NAME]`"),
    ("rotor.unbalances.", "`[rotor.unbalances.NAME]`: added and lost masses"),
    ("rotor.damping.", "`[rotor.damping]`"),
    ("rotor.speed_law.", "`[rotor.speed_law]`: a prescribed speed"),
    ("rotor.initial.", "`[rotor.initial]`: motion at the start"),
    ("monitors.", "`[monitors.NAME]`: displacement at places without contact"),
    ("braking.", "`[braking]`: torques that slow the rotor"),
    ("torques.", "`[torques.NAME]`: torques over time"),
    ("diaphragms.", "`[diaphragms.NAME]`: ring and blades"),
    ("diaphragms.NAME.contact.", "`[diaphragms.NAME.contact]`"),
];

pub fn machine() -> String {
    let mut page = String::new();
    let section =
        |key: &Key| SECTIONS.iter().rposition(|(begin, _)| key.path.starts_with(begin)).expect("the first fits all");
    for (place, (_, heading)) in SECTIONS.iter().enumerate() {
        let of_section: Vec<&Key> = keys().iter().filter(|key| section(key) == place).collect();
        if of_section.is_empty() {
            continue;
        }
        page += &format!("## {heading}\n\n{}", head(&["key", "holds", "default", "meaning"]));
        for key in of_section {
            page += &described(key);
        }
        page += "\n";
    }
    page
}

fn described(key: &Key) -> String {
    let number = |unit: &str| {
        if key.range == Range::ANY && unit.is_empty() { "number".to_owned() } else { key.range.words(unit) }
    };
    let words = |words: &[&str]| {
        codes(
            &words
                .iter()
                .map(|word| format!("\"{word}\""))
                .collect::<Vec<_>>()
                .iter()
                .map(String::as_str)
                .collect::<Vec<_>>(),
        )
    };
    let holds = match key.kind {
        Kind::Schema => "1".to_owned(),
        Kind::Text => "text".to_owned(),
        Kind::Number(unit) => number(unit),
        Kind::NumberOr(unit, choices) => format!("{} or {}", number(unit), words(choices)),
        Kind::Count => format!("whole number {}", key.range.words("")),
        Kind::Choice(choices) => words(choices),
        Kind::Vector(unit) => format!("[x, y], {}", number(unit)),
        Kind::Matrix(unit) => format!("{}, or 2 x 2", number(unit)),
        Kind::Diagonal(unit) => format!("{}, or [x, y]", number(unit)),
        Kind::List(unit) => format!("list, {}", number(unit)),
    };
    let default = match key.need {
        Need::Required => "required".to_owned(),
        Need::Number(value) => value.to_string(),
        Need::Word(word) => words(&[word]),
        Need::Optional(instead) => instead.to_owned(),
    };
    let when = key.when.words();
    let when = if when.is_empty() { String::new() } else { format!("; with `{when}`") };
    row(&[format!("`{}`", key.path), holds, default, format!("{}{when}", key.meaning)])
}

pub fn study() -> String {
    let mut page = String::new();
    for (table, purpose) in STUDY_TABLES {
        let heading = if table.is_empty() { "The file".to_owned() } else { format!("`{table}`") };
        page += &format!("## {heading}\n\n{purpose}\n\n");
        let of_table: Vec<_> = STUDY_KEYS.iter().filter(|key| key.table == *table).collect();
        if of_table.is_empty() {
            continue;
        }
        page += &head(&["key", "holds", "default", "meaning"]);
        for key in of_table {
            page += &row(&[format!("`{}`", key.name).as_str(), key.holds, key.default, key.meaning]);
        }
        page += "\n";
        if *table == "[[uncertain]]" {
            page += "### Distributions\n\n";
            page += &head(&["`distribution`", "keys"]);
            for (word, distribution) in Distribution::ALL {
                page += &row(&[format!("`{word}`"), distribution.keys_in_words()]);
            }
            page += "\n";
        }
    }
    page
}
