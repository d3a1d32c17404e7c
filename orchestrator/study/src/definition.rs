//! A study as read from its file.

use super::asked::Asked;
use super::axis::Axis;
use super::extra_columns::ExtraColumn;
use super::file::SampledTables;
use super::frozen::{MACHINE, POINTS, STUDY, empirical};
use super::function::FunctionModel;
use super::limits::Limits;
use super::parameter::Parameter;
use super::refine::RefineDef;
use super::stop::StopDef;
use super::twin::TwinShare;
use bladeoff_model::machine::{EngineChoice, MachineDef, ParamValue, PathInfo, TWIN, TWIN_LIMIT};
use std::ops::Range;

/// A study whose every key was checked.
#[derive(Debug, Clone)]
pub struct Study {
    /// File name as given by the user.
    pub file: String,
    /// Text of the file, stored with the results.
    pub text: String,
    /// Name: letters, digits, `.`, `_`, `-`; default the file's name.
    pub name: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Subject of each sample.
    pub subject: Subject,
    /// Axes, the slowest one first.
    pub axes: Vec<Axis>,
    /// Values that differ from sample to sample, with their distributions and formulas.
    pub sampled: SampledTables,
    /// Byte range of `[design]`.
    pub design_place: Range<usize>,
    /// Text of the points file, stored with the results.
    pub points_text: Option<String>,
    /// Texts of the files of empirical distributions, in the order of their tables, stored with the results.
    pub empirical_texts: Vec<String>,
    /// Columns of the points file (the first axis) that are copied to the table.
    pub extra_columns: Vec<ExtraColumn>,
    /// Acceptable numbers of failed, invalid and beyond samples.
    pub limits: Limits,
    /// Questions and gates; they do not affect computed results.
    pub asked: Asked,
    /// Precision at which the study ends before its design does; also without effect on computed results.
    pub stop: Option<StopDef>,
    /// Map to refine; also without effect on computed results.
    pub refine: Option<RefineDef>,
    /// Samples with a twin run; `None`: determined by the machine.
    pub twin: Option<TwinShare>,
}

/// Subject of a study: a machine or formulas.
#[derive(Debug, Clone)]
pub enum Subject {
    /// The transient of a machine.
    Machine(MachineSubject),
    /// Formulas of the study's variables.
    Function(FunctionModel),
}

/// The machine of a study.
#[derive(Debug, Clone)]
pub struct MachineSubject {
    /// File name as given by the study.
    pub file: String,
    /// Text of the file.
    pub text: String,
    /// The machine with the overrides of `[set]`, and the engine of all samples.
    pub def: MachineDef,
    /// Engine and reason; `None`: `run.engine` varies.
    pub engine: Option<EngineChoice>,
    /// The overrides of `[set]`.
    pub fixed: Vec<Fixed>,
}

/// A value of `[set]`.
#[derive(Debug, Clone)]
pub struct Fixed {
    /// Parameter.
    pub info: PathInfo,
    /// Value.
    pub value: ParamValue,
    /// Byte range of its key in the study file.
    pub place: Range<usize>,
}

impl Study {
    /// The machine; `None`: the study computes formulas.
    #[must_use]
    pub fn machine(&self) -> Option<&MachineSubject> {
        match &self.subject {
            Subject::Machine(machine) => Some(machine),
            Subject::Function(_) => None,
        }
    }

    /// Name of the subject: the machine file as the study names it, or `function`.
    #[must_use]
    pub fn subject_name(&self) -> &str {
        self.machine().map_or("function", |machine| &machine.file)
    }

    /// Changes the engine of all samples if `run.engine = "auto"` selected the present one; a named engine stays.
    pub fn settle(&mut self, choice: EngineChoice) {
        if let Subject::Machine(machine) = &mut self.subject
            && machine.engine.as_ref().is_some_and(EngineChoice::is_auto)
        {
            machine.def.settle(choice.engine);
            machine.engine = Some(choice);
        }
    }

    /// Engine of all samples, and the reason; `None`: the study has no machine, or `run.engine` varies.
    #[must_use]
    pub fn engine(&self) -> Option<&EngineChoice> {
        self.machine()?.engine.as_ref()
    }

    /// The formulas; `None`: the study has a machine.
    #[must_use]
    pub fn function(&self) -> Option<&FunctionModel> {
        match &self.subject {
            Subject::Machine(_) => None,
            Subject::Function(function) => Some(function),
        }
    }

    /// Byte range in the study file that gives a parameter its values.
    #[must_use]
    pub fn place_of(&self, path: &str) -> Option<Range<usize>> {
        let varied = self.parameters().iter().find(|one| one.info.path == path).map(|one| &one.place);
        let fixed = || self.machine()?.fixed.iter().find(|one| one.info.path == path).map(|one| &one.place);
        varied.or_else(fixed).cloned()
    }

    /// All parameters that differ between samples, in the order of a sample's values: uncertain, varied, derived.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.sampled.parameters
    }

    /// Whether the solver takes this parameter: a machine has no variables, formulas have nothing else.
    #[must_use]
    pub fn is_solved(&self, parameter: &Parameter) -> bool {
        !parameter.is_variable || self.function().is_some()
    }

    /// `run.twin` of the machine before any variation; 0: no twin runs.
    #[must_use]
    pub fn shift(&self) -> f64 {
        self.twin_keys()[0]
    }

    /// `run.twin` and `run.twin_limit` of the machine before any variation; 0 without a machine.
    #[must_use]
    pub fn twin_keys(&self) -> [f64; 2] {
        [TWIN, TWIN_LIMIT].map(|key| {
            match self.machine().and_then(|machine| machine.def.resolve(key).ok()).and_then(|info| info.value) {
                Some(ParamValue::Number(value)) => value,
                _ => 0.0,
            }
        })
    }

    /// Input files by their names in the result directory; `None`: this study does not have the file.
    #[must_use]
    pub fn inputs(&self) -> Vec<(String, Option<&str>)> {
        let machine = self.machine().map(|machine| machine.text.as_str());
        let mut inputs = vec![
            (STUDY.to_owned(), Some(self.text.as_str())),
            (MACHINE.to_owned(), machine),
            (POINTS.to_owned(), self.points_text.as_deref()),
        ];
        let texts = self.empirical_texts.iter().enumerate();
        inputs.extend(texts.map(|(number, text)| (empirical(number), Some(text.as_str()))));
        inputs
    }
}
