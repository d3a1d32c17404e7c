//! The tables of a study with random samples: `[[uncertain]]`, `[[correlation]]`, `[design]`, `[[derived]]`.
//!
//! ```text
//! file --uncertain--> distributions --correlation--> copula --design--> layout --derived--> formulas      SampleValues: all of it
//! ```
//! Every mistake of all tables is reported at once, each at the key that is wrong.

mod correlation;
mod derived;
mod design;
mod empirical;
mod quantity;
mod uncertain;

pub(super) use design::needs;
pub(super) use empirical::Files;

use super::axis::Axis;
use super::derived::{NameError, Variable, name_mistakes};
use super::parameter::{Origin, Parameter};
use super::sample_values::SampleValues;
use super::table::Keys;
use super::uncertain::Uncertain;
use super::vary::PathTable;
use bladeoff_text::document::{Collector, Node, Value};

/// Contents of the tables of a study.
#[derive(Debug, Clone)]
pub struct SampledTables {
    /// All parameters that differ between samples, in the order of a sample's values: uncertain, varied, derived.
    pub parameters: Vec<Parameter>,
    /// Values of a sample by its index.
    pub values: SampleValues,
    /// Descriptions of the uncertain parameters for `check`, with mean and standard deviation after truncation.
    pub distributions: Vec<String>,
    /// Notes about the design for readers of the answers.
    pub notes: Vec<String>,
    /// Descriptions of the correlations for `check`.
    pub correlated: Vec<String>,
    /// Formulas of `[[derived]]`, as text.
    pub formulas: Vec<String>,
}

/// One table of `[[uncertain]]`, as far as it could be read.
struct Draft {
    parameter: Option<Parameter>,
    law: Option<Uncertain>,
    sentence: String,
}

/// The tables, as far as they could be read.
struct Tables {
    drafts: Vec<Draft>,
    derived: Vec<derived::Formula>,
    parameters: Vec<Parameter>,
    variables: Vec<Variable>,
    /// Number of uncertain parameters.
    uncertain: usize,
    /// Whether everything that they refer to could be read.
    is_whole: bool,
}

/// Reads the tables; `axes` are those of `[[vary]]` and `[points]`. Returns the result, and all variables if they are known; `None`: problems
/// were added.
pub(super) fn read(
    keys: &Keys<'_>,
    axes: &[Axis],
    seed: u64,
    paths: &PathTable<'_>,
    files: &mut Files<'_, '_>,
    problems: &mut Collector<'_>,
) -> (Option<SampledTables>, Option<Vec<Variable>>) {
    let tables = Tables::read(keys, axes, paths, files, problems);
    let variables = tables.is_whole.then(|| tables.variables.clone());
    (tables.sampled(keys, seed, problems), variables)
}

impl Tables {
    fn read(
        keys: &Keys<'_>,
        axes: &[Axis],
        paths: &PathTable<'_>,
        files: &mut Files<'_, '_>,
        problems: &mut Collector<'_>,
    ) -> Self {
        let drafts = keys.get("uncertain").map(|entry| uncertain::read(&entry.node, paths, files, problems));
        let drafts = drafts.unwrap_or_default();
        let derived = keys.get("derived").map(|entry| derived::read(&entry.node, paths, problems)).unwrap_or_default();
        let is_whole = drafts.iter().all(|draft| draft.parameter.is_some()) && derived.iter().all(Option::is_some);
        let derived: Vec<derived::Formula> = derived.into_iter().flatten().collect();
        let varied = axes.iter().enumerate().flat_map(|(axis, along)| {
            along.varied.iter().enumerate().map(move |(member, varied)| varied.parameter(Origin::Varied(axis, member)))
        });
        let mut parameters: Vec<Parameter> = drafts.iter().filter_map(|draft| draft.parameter.clone()).collect();
        let uncertain = parameters.len();
        parameters.extend(varied);
        parameters.extend(derived.iter().map(|formula| formula.parameter.clone()));
        let variables: Vec<Variable> = parameters.iter().map(Parameter::variable).collect();
        refuse_names(&parameters, &variables, problems);
        Self { drafts, derived, parameters, variables, uncertain, is_whole }
    }

    /// `None`: problems were added.
    fn sampled(self, keys: &Keys<'_>, seed: u64, problems: &mut Collector<'_>) -> Option<SampledTables> {
        let Self { drafts, derived, parameters, variables, uncertain, is_whole: all_read } = self;
        let laws: Option<Vec<Uncertain>> = drafts.iter().map(|draft| draft.law.clone()).collect();
        let copula = correlation::read(keys, &variables[..uncertain], laws.as_deref().filter(|_| all_read), problems);
        let (copula, correlated) = copula.unzip();
        let drawn = laws.as_deref().zip(copula.as_ref()).filter(|_| all_read);
        let layout = design::read(keys, &parameters[..uncertain], drawn, seed, problems);
        // without all variables, a formula would be blamed for names that exist
        let formulas = if all_read { derived::formulas(variables, &derived, problems) } else { None };
        let (laws, copula, layout) = (laws?, copula?, layout?);
        // uncertain inputs without a design have been reported
        if layout.is_none() && !laws.is_empty() {
            return None;
        }
        let notes = layout.as_ref().map(|layout| layout.notes(&copula)).unwrap_or_default();
        Some(SampledTables {
            parameters,
            values: SampleValues::new(laws, copula, layout, formulas?),
            distributions: drafts.into_iter().map(|Draft { sentence, .. }| sentence).collect(),
            notes,
            correlated: correlated.unwrap_or_default(),
            formulas: derived.into_iter().map(|formula| formula.text).collect(),
        })
    }
}

/// Rejects names that formulas do not allow, and repeated names.
fn refuse_names(parameters: &[Parameter], variables: &[Variable], problems: &mut Collector<'_>) {
    for error in name_mistakes(variables, |number| !parameters[number].is_variable) {
        let (NameError::Letters { variable, .. }
        | NameError::Reserved { variable, .. }
        | NameError::Taken { variable, .. }) = &error;
        // the path table reports a path that is given twice
        let is_path = matches!(&error, NameError::Taken { name, .. } if name.contains('.'));
        if !is_path {
            let parameter = &parameters[*variable];
            problems.add(parameter.place.clone(), parameter.key(), error.to_string());
        }
    }
}

/// The tables of an array of tables; a problem and an empty list for anything else.
fn tables<'n>(node: &'n Node, key: &str, problems: &mut Collector<'_>) -> &'n [Node] {
    match &node.value {
        Value::Array(items) => items,
        _ => {
            super::table::wrong_type(node, key, &format!("an array of tables: [[{key}]]"), problems);
            &[]
        }
    }
}
