//! The columns of a study's table: those that the study declares and those of the solver, as the table wants them.

use crate::engine;
use bladeoff_answers::tables::{Field, FieldKind, TableSchema};
use bladeoff_model::machine::{Machine, MachineDef, ParamValue, PathInfo, TWIN};
use bladeoff_model::outcome::{Column as OutcomeColumn, ColumnKind as OutcomeKind, Empty, Group, Growth, Part};
use bladeoff_study::{Column, ColumnKind, Samples};
use bladeoff_study::{FunctionModel, Output};

/// All columns of the table of these samples; `machine`: one of theirs.
pub(super) fn table_schema(samples: &Samples, machine: &Machine) -> TableSchema {
    TableSchema::new(samples.columns().into_iter().map(field).collect(), &engine::columns(machine))
}

/// The same of a study of formulas.
pub(super) fn function_schema(samples: &Samples, model: &FunctionModel) -> TableSchema {
    TableSchema::of_formulas(samples.columns().into_iter().map(field).collect(), &function_columns(model))
}

/// What a study of formulas gives: a pure number for each, by its name.
#[must_use]
pub fn function_columns(model: &FunctionModel) -> Vec<OutcomeColumn> {
    let column = |output: &Output| OutcomeColumn {
        name: output.name.clone(),
        unit: "",
        kind: OutcomeKind::Real,
        meaning: output.text.clone(),
        group: Group::Functions,
        part: Part::Whole,
        growth: Growth::Free,
        is_guarded: false,
        empty: Empty::Absent,
        lacks: None,
    };
    model.outputs.iter().map(column).collect()
}

/// Column of the time of the first exceeded limit of the model with `on_exceed = "beyond"`.
const BEYOND_TIME: &str = "beyond_s";

/// What a column of a table says of a run that is not ok.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Told {
    /// All: it went into the run.
    Given,
    /// At least what was reached while all guards held, which stands in the column of this name, if there is one.
    Grown(Option<String>),
    /// The time of a first event, where it happened while all guards and limits held, as the column of this name has it.
    Once(Option<String>),
    /// Time of the first exceeded limit of the model: that of the row in a run beyond the model, else as `Once`.
    Limit(Option<String>),
    /// Nothing.
    Found,
}

impl Told {
    /// The column with what was reached while all guards and limits held.
    #[must_use]
    pub fn guarded(&self) -> Option<&str> {
        match self {
            Self::Grown(name) | Self::Once(name) | Self::Limit(name) => name.as_deref(),
            Self::Given | Self::Found => None,
        }
    }
}

/// A column of a study's table.
#[derive(Debug, Clone)]
pub struct TableColumn {
    /// Name, unit, storage.
    pub field: Field,
    /// Of runs that are not ok.
    pub told: Told,
    /// Whether an empty cell of an ok run decides nothing: the run has no such quantity.
    pub unjudged: bool,
    /// Part or key that the study's machine needs for the column; without it the column is empty in every row.
    pub lacks: Option<String>,
}

/// All columns of the table of these samples; `None`: their machine cannot be built.
#[must_use]
pub fn columns_of(samples: &Samples) -> Option<Vec<TableColumn>> {
    if let Some(model) = samples.study().function() {
        return Some(told(&function_schema(samples, model), &function_columns(model)));
    }
    let definition = samples.try_machine(0).ok()??;
    let machine = definition.build().ok()?;
    let mut columns = told(&table_schema(samples, &machine), &engine::columns(&machine));
    // a column that any sample may have is not lacking
    for variant in variants(samples, &definition) {
        let Ok(machine) = variant.build() else { continue };
        let found = engine::columns(&machine);
        let has = |name: &str| found.iter().any(|column| column.name == name && column.lacks.is_none());
        for column in columns.iter_mut().filter(|column| column.lacks.is_some()) {
            if has(&column.field.name) {
                column.lacks = None;
            }
        }
    }
    Some(columns)
}

/// Machines of the study that may have other quantities than that of the first sample: one for each word of a parameter with words, and
/// one with a twin run where samples have one.
fn variants(samples: &Samples, definition: &MachineDef) -> Vec<MachineDef> {
    let with = |info: &PathInfo, value: ParamValue| {
        let mut variant = definition.clone();
        variant.set(info, &value).ok().map(|()| variant)
    };
    let mut found: Vec<MachineDef> = Vec::new();
    for parameter in samples.parameters().iter().filter(|parameter| !parameter.is_variable) {
        let words = parameter.words().unwrap_or_default();
        found.extend(words.iter().filter_map(|word| with(&parameter.info, ParamValue::Choice((*word).to_owned()))));
        if parameter.info.path == TWIN {
            found.extend(with(&parameter.info, ParamValue::Number(SHIFT)));
        }
    }
    found.extend(samples.study().twin.as_ref().and_then(|twin| with(&twin.info, ParamValue::Number(SHIFT))));
    found
}

/// A shift of a twin run that any machine allows.
const SHIFT: f64 = 1e-6;

/// Those of a study of this machine, or of formulas that are not known, in which nothing varies.
#[must_use]
pub fn columns_without(machine: Option<&Machine>) -> Vec<TableColumn> {
    let outcome = machine.map(engine::columns).unwrap_or_default();
    told(&TableSchema::new(Vec::new(), &outcome), &outcome)
}

/// `outcome`: the columns that the solver fills.
fn told(schema: &TableSchema, outcome: &[OutcomeColumn]) -> Vec<TableColumn> {
    let columns = schema.fields().iter().enumerate().map(|(at, field)| {
        let solved = at.checked_sub(schema.given()).and_then(|at| outcome.get(at));
        let told = match solved {
            None => Told::Given,
            Some(column) if column.name == BEYOND_TIME => Told::Limit(column.guarded()),
            Some(column) if column.grows() => Told::Grown(column.guarded()),
            Some(column) if column.growth == Growth::Once => Told::Once(column.guarded()),
            Some(_) => Told::Found,
        };
        let unjudged = solved.is_some_and(|column| column.empty == Empty::Unjudged);
        TableColumn { field: field.clone(), told, unjudged, lacks: solved.and_then(|column| column.lacks.clone()) }
    });
    columns.collect()
}

fn field(column: Column) -> Field {
    let kind = match column.kind {
        ColumnKind::Real => FieldKind::Real,
        ColumnKind::Integer => FieldKind::Integer,
        ColumnKind::Word => FieldKind::Word,
    };
    Field { name: column.name, unit: column.unit, meaning: column.meaning, kind }
}

/// Names of the columns that the table of this machine has whatever varies.
#[must_use]
pub fn own_columns(machine: &Machine) -> Vec<String> {
    let schema = TableSchema::new(Vec::new(), &engine::columns(machine));
    schema.fields().iter().map(|field| field.name.clone()).collect()
}
