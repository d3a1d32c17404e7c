//! Converts rotors of other programs to machine files: a commented machine file, and the list of what was not converted.
//!
//! ```text
//! text --fields--> elements of the file --elements--> --line, support--> shaft line with supports --write--> machine file
//! ```
//! Input texts are untrusted. All mistakes are reported at once, with their positions. The machine file contains only checked numbers, checked
//! names and comments of one line.

mod elements;
mod fields;
mod line;
mod names;
mod support;
mod write;

use bladeoff_model::machine::MachineDef;
use bladeoff_text::document::{Problems, parse_json, parse_toml};
use elements::Rotor;
use line::Line;
use support::Supports;

/// A machine file converted from a rotor of another program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Imported {
    /// The machine file.
    pub machine: String,
    /// Elements that were not converted, or converted differently.
    pub notes: Vec<Note>,
}

/// A part of a rotor that a machine file cannot represent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Elements of the other program, by their names in its file.
    pub element: String,
    /// Quantity that was not converted, the reason, and its replacement.
    pub message: String,
}

impl Note {
    fn new(element: &str, message: impl Into<String>) -> Self {
        Self { element: element.to_owned(), message: message.into() }
    }
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.element, self.message)
    }
}

/// Most elements that a note lists.
const MOST_NAMED: usize = 3;

/// Joins the notes with the same message.
fn joined(notes: Vec<Note>) -> Vec<Note> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for Note { element, message } in notes {
        match groups.iter_mut().find(|(said, _)| *said == message) {
            Some((_, elements)) => elements.push(element),
            None => groups.push((message, vec![element])),
        }
    }
    let note = |(message, elements): (String, Vec<String>)| {
        let mut element =
            elements.iter().take(MOST_NAMED).map(|name| names::in_one_line(name)).collect::<Vec<_>>().join(", ");
        if elements.len() > MOST_NAMED {
            element.push_str(&format!(" and {} more", elements.len() - MOST_NAMED));
        }
        Note { element, message }
    };
    groups.into_iter().map(note).collect()
}

/// Converts a rotor saved by ROSS (`Rotor.save`, TOML or JSON). `file` is its name in messages and in the machine file.
///
/// # Errors
/// All mistakes of the file at once: missing or invalid values, elements outside the shaft, and elements that cannot be left out without changing the
/// rotor (couplings).
pub fn from_ross(file: &str, text: &str) -> Result<Imported, Problems> {
    let is_json = text.trim_start_matches('\u{feff}').trim_start().starts_with('{');
    let (root, mut problems) = if is_json { parse_json(file, text)? } else { parse_toml(file, text)? };
    let mut notes = Vec::new();
    let rotor = Rotor::read(root.value.as_table().unwrap_or_default(), &mut problems, &mut notes);
    let line = Line::of(&rotor, &mut problems);
    let supports = line.as_ref().map(|line| Supports::of(&rotor, line, &mut problems, &mut notes));
    problems.finish()?;
    let (Some(line), Some(supports)) = (line, supports) else { return Ok(Imported { machine: String::new(), notes }) };
    let body = write::machine(file, &rotor, &line, &supports, &mut notes);
    let mut notes = joined(notes);
    let machine = write::provenance(file, text, &rotor, &notes) + &body;
    if let Err(problems) = MachineDef::parse("machine", &machine) {
        for problem in problems.list {
            notes.push(Note::new("machine file", format!("is rejected as it is: {}", problem.headline())));
        }
    }
    Ok(Imported { machine, notes })
}
