//! A machine as its file defines it, with values that may be changed by path.

use std::sync::Arc;

use super::build::{Reader, build, choose};
use super::engine::EngineChoice;
use super::layout::{Layout, Origin, Scalar, State};
use super::load::load;
use super::model::{Engine, Machine};
use super::paths::PathInfo;
use super::schema::ENGINE;
use super::value::{self, ParamValue, ValueError};
use bladeoff_text::document::{Collector, Problems};

/// A machine file: its text, and a value for every scalar and choice. Clones share everything but the values, so a clone per sample of a
/// study is cheap.
#[derive(Debug, Clone)]
pub struct MachineDef {
    pub(super) layout: Arc<Layout>,
    pub(super) states: Vec<State>,
}

impl MachineDef {
    /// Reads a machine file and checks that a machine can be built from it. Messages refer to the file as `file`.
    ///
    /// # Errors
    /// All problems of the file at once. A file with too many syntax errors is reported with the first of them only.
    pub fn parse(file: &str, text: &str) -> Result<Self, Problems> {
        Self::parse_partly(file, text).map_err(|(_, problems)| problems)
    }

    /// As [`MachineDef::parse`], but an error also has the readable part of the file (`None`: no part), so that references to its parameters can
    /// be checked too.
    ///
    /// # Errors
    /// As [`MachineDef::parse`].
    pub fn parse_partly(file: &str, text: &str) -> Result<Self, (Option<Self>, Problems)> {
        let loaded = load(file, text).map_err(|problems| (None, problems))?;
        let def = Self { layout: Arc::new(loaded.layout), states: loaded.states };
        match build(&def.layout, &def.states, loaded.problems) {
            Ok(_) => Ok(def),
            Err(problems) => Err((Some(def), problems)),
        }
    }

    /// Name of the machine.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.layout.name
    }

    /// The file as it was read, comments included.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.layout.text
    }

    /// Texts by which tables refer to others (`rotor.unbalances.NAME.disc`), by path. A study cannot vary them.
    pub fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.layout.texts.iter().map(|(path, text)| (path.as_str(), text.value.as_deref().unwrap_or_default()))
    }

    /// Parses a value written without quotes: "8 mm", "hyp1", "12"; a bare number is in SI units.
    ///
    /// # Errors
    /// [`ValueError`]: unreadable, out of range, not one of the allowed words.
    pub fn parse_value(&self, path: &PathInfo, text: &str) -> Result<ParamValue, ValueError> {
        let slot = &self.layout.slots[self.index(path)?];
        let value = value::parse(slot, text)?;
        value::check(slot, &value)?;
        Ok(value)
    }

    /// Checks type and range of a value; [`MachineDef::build`] checks values against each other.
    ///
    /// # Errors
    /// [`ValueError`]: out of range, not whole, not one of the allowed words.
    pub fn check_value(&self, path: &PathInfo, value: &ParamValue) -> Result<(), ValueError> {
        value::check(&self.layout.slots[self.index(path)?], value).map(|_| ())
    }

    /// Sets the value of a parameter.
    ///
    /// # Errors
    /// As [`MachineDef::check_value`]; the machine is then unchanged.
    pub fn set(&mut self, path: &PathInfo, value: &ParamValue) -> Result<(), ValueError> {
        let index = self.index(path)?;
        let scalar = value::check(&self.layout.slots[index], value)?;
        self.states[index] = State { scalar, origin: Origin::Set };
        Ok(())
    }

    /// Builds the validated machine from the present values.
    ///
    /// # Errors
    /// All violated checks between the present values.
    pub fn build(&self) -> Result<Machine, Problems> {
        build(&self.layout, &self.states, Collector::new(&self.layout.file, &self.layout.text))
    }

    /// The engine of the machine with its present values; `None`: `run.engine` is invalid, which has been reported.
    #[must_use]
    pub fn engine(&self) -> Option<EngineChoice> {
        choose(&Reader::new(&self.layout, &self.states, Collector::new(&self.layout.file, &self.layout.text)))
    }

    /// Sets the engine, as the default rather than as a value of the file.
    pub fn settle(&mut self, engine: Engine) {
        if let Some(index) = self.layout.find(ENGINE) {
            self.states[index] = State { scalar: Scalar::Word(engine.word()), origin: Origin::Default };
        }
    }

    /// A problem found by a run that no check of the file can find: at the position of a parameter, with its present value.
    #[must_use]
    pub fn refused(&self, path: &str, message: String, allowed: String) -> Problems {
        let mut problems = Collector::new(&self.layout.file, &self.layout.text);
        let span = match self.layout.find(path) {
            Some(index) => self.layout.slots[index].span.clone(),
            None => self.layout.table_span(path),
        };
        let problem = problems.add(span, path, message);
        problem.value = self.find(path).ok().map(|info| info.shown);
        problem.allowed = Some(allowed);
        problems.into_problems()
    }

    pub(super) fn index(&self, path: &PathInfo) -> Result<usize, ValueError> {
        self.layout.find(&path.path).ok_or_else(|| ValueError::NoSuchParameter { path: path.path.clone() })
    }

    /// Whether a slot belongs to a machine with the present values of `kind`.
    pub(super) fn applies(&self, index: usize) -> bool {
        self.holds(self.layout.conditions[index])
    }

    /// Whether the present values of `kind` meet a condition of the layout.
    pub(super) fn holds(&self, condition: Option<(usize, &'static str)>) -> bool {
        condition.is_none_or(|(kind, word)| self.states[kind].scalar == Scalar::Word(word))
    }
}
