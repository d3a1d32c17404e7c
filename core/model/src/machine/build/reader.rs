//! Reads slots by path and reports problems at their positions.

use super::path::joined;
use crate::machine::layout::{Layout, Origin, Scalar, State};
use crate::machine::schema::{Key, Kind, Need, keys};
use bladeoff_text::document::units::format_digits;
use bladeoff_text::document::{Collector, MISSING, Problem};

pub(in crate::machine) struct Reader<'a> {
    pub layout: &'a Layout,
    pub problems: Collector<'a>,
    states: &'a [State],
}

impl<'a> Reader<'a> {
    pub(in crate::machine) fn new(layout: &'a Layout, states: &'a [State], problems: Collector<'a>) -> Self {
        Self { layout, problems, states }
    }

    /// Reports missing required keys and keys that do not belong to a machine of this kind.
    pub fn check_presence(&mut self) {
        let layout = self.layout;
        for ((slot, state), condition) in layout.slots.iter().zip(self.states).zip(&layout.conditions) {
            if let Some((kind, word)) = *condition {
                let kind_state = self.states[kind];
                let Scalar::Word(present) = kind_state.scalar else { continue };
                if present != word {
                    // After `set` has changed a kind, keys of the file for the other kind are unused, not wrong.
                    let unused = state.origin == Origin::File && kind_state.origin == Origin::Set;
                    if state.origin != Origin::Default && !unused {
                        let shown = self.shown(&slot.path);
                        let message = format!("does not belong to kind = \"{present}\"");
                        let problem = self.problems.add(slot.span.clone(), &slot.path, message);
                        problem.value = shown;
                        problem.allowed = Some(format!("only with {}", slot.key.when.words()));
                    }
                    continue;
                }
            }
            if slot.key.need == Need::Required && state.scalar == Scalar::Absent {
                self.missing(&slot.path, slot.key);
            }
        }
        for (path, text) in &layout.texts {
            let Some((kind, word)) = layout.condition(path, text.key.when) else { continue };
            if let Scalar::Word(present) = self.states[kind].scalar
                && present != word
                && self.states[kind].origin != Origin::Set
            {
                let message = format!("does not belong to kind = \"{present}\"");
                self.fail(path, message, format!("only with {}", text.key.when.words()));
            }
        }
    }

    /// Reports a missing key.
    pub fn missing(&mut self, path: &str, key: &'static Key) {
        let span = self.layout.table_span(path);
        let words = key.range.words(key.unit());
        let allowed = match key.kind {
            Kind::Choice(list) => list.join(", "),
            _ => words,
        };
        let problem = self.problems.add(span, path, format!("{MISSING}: {}", key.meaning));
        problem.allowed = Some(allowed);
    }

    /// Reports an optional key that this machine needs.
    pub fn missing_here(&mut self, path: &str, pattern: &str) {
        if let Some(key) = keys().iter().find(|key| key.path == pattern) {
            self.missing(path, key);
        }
    }

    fn state(&self, path: &str) -> Option<State> {
        self.layout.find(path).map(|index| self.states[index])
    }

    /// Value of a numeric slot; `None` if it is absent or invalid.
    pub fn number(&self, path: &str) -> Option<f64> {
        match self.state(path)?.scalar {
            Scalar::Number(number) => Some(number),
            _ => None,
        }
    }

    /// Value of a choice; `None` if it is absent or invalid.
    pub fn word(&self, path: &str) -> Option<&'static str> {
        match self.state(path)?.scalar {
            Scalar::Word(word) => Some(word),
            _ => None,
        }
    }

    /// Value of a text; `None`: the file has none, `Some(None)`: reported as wrong.
    pub fn text(&self, path: &str) -> Option<Option<&'a str>> {
        let layout: &'a Layout = self.layout;
        layout.texts.get(path).map(|text| text.value.as_deref())
    }

    /// Value of a whole number, whose range was checked; `None` if it is absent or invalid.
    pub fn count(&self, path: &str) -> Option<usize> {
        self.number(path).map(|number| number as usize)
    }

    /// Both components of a vector.
    pub fn vector(&self, path: &str) -> Option<[f64; 2]> {
        Some([self.number(&joined(&[path, "[0]"]))?, self.number(&joined(&[path, "[1]"]))?])
    }

    /// Values along X and Y, given as a vector or as one value for both.
    pub fn diagonal(&self, path: &str) -> Option<[f64; 2]> {
        if self.layout.find(path).is_some() { self.number(path).map(|value| [value; 2]) } else { self.vector(path) }
    }

    /// A 2x2 matrix, written in full or as one value for its diagonal.
    pub fn matrix(&self, path: &str) -> Option<[[f64; 2]; 2]> {
        if self.layout.find(path).is_some() {
            let k = self.number(path)?;
            return Some([[k, 0.0], [0.0, k]]);
        }
        let cell = |place| self.number(&joined(&[path, place]));
        Some([[cell("[0][0]")?, cell("[0][1]")?], [cell("[1][0]")?, cell("[1][1]")?]])
    }

    /// A list; `None`: invalid, empty: not given.
    pub fn list(&self, path: &str) -> Option<Vec<f64>> {
        match self.layout.lengths.get(path) {
            None => Some(Vec::new()),
            Some(0) => None,
            Some(&length) => (0..length).map(|i| self.number(&format!("{path}[{i}]"))).collect(),
        }
    }

    /// Whether a value or list is present, valid or not. A default value counts as present.
    pub fn is_given(&self, path: &str) -> bool {
        self.state(path).is_some_and(|state| state.scalar != Scalar::Absent) || self.layout.lengths.contains_key(path)
    }

    /// Whether a group of tables was reported as wrong.
    pub fn is_bad_group(&self, path: &str) -> bool {
        self.layout.lengths.get(path) == Some(&0)
    }

    /// Whether the value is the format's default.
    pub fn is_default(&self, path: &str) -> bool {
        self.state(path).is_some_and(|state| state.origin == Origin::Default)
    }

    /// The present value in a readable unit.
    pub fn shown(&self, path: &str) -> Option<String> {
        if let Some(text) = self.layout.texts.get(path) {
            return Some(self.problems.excerpt(text.span.clone()));
        }
        let index = self.layout.find(path)?;
        match self.states[index].scalar {
            Scalar::Number(number) => Some(format_digits(number, self.layout.slots[index].key.unit(), 10)),
            Scalar::Word(word) => Some(format!("\"{word}\"")),
            Scalar::Bad if self.states[index].origin == Origin::File => {
                Some(self.problems.excerpt(self.layout.slots[index].span.clone()))
            }
            Scalar::Bad | Scalar::Absent => None,
        }
    }

    /// Reports a problem at the position of a value.
    pub fn fail(&mut self, path: &str, message: impl Into<String>, allowed: impl Into<String>) -> &mut Problem {
        let span = match self.layout.find(path) {
            Some(index) => self.layout.slots[index].span.clone(),
            None => self.layout.table_span(path),
        };
        let shown = self.shown(path);
        let problem = self.problems.add(span, path, message);
        problem.value = shown;
        problem.allowed = Some(allowed.into());
        problem
    }

    /// Whether the rotor is a mass point; `None`: `rotor.kind` is invalid.
    pub fn is_point_mass(&self) -> Option<bool> {
        self.word("rotor.kind").map(|kind| kind == "point-mass")
    }
}
