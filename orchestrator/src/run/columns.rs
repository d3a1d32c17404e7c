//! Columns of a study's table: those of the study, and those of the solver.

use crate::engine;
use bladeoff_answers::tables::{Field, FieldKind, TableSchema};
use bladeoff_model::machine::{Machine, MachineDef, ParamValue, PathInfo, TWIN};
use bladeoff_model::outcome::{Column as OutcomeColumn, ColumnKind as OutcomeKind, Empty, Group, Growth, Part};
use bladeoff_study::{Column, ColumnKind, Samples};
use bladeoff_study::{FunctionModel, Output};

/// Table columns of a study of a machine; `machine`: the machine of one sample.
pub(super) fn table_schema(samples: &Samples, machine: &Machine) -> TableSchema {
    TableSchema::new(samples.columns().into_iter().map(field).collect(), &engine::columns(machine))
}

/// Table columns of a study of formulas.
pub(super) fn function_schema(samples: &Samples, model: &FunctionModel) -> TableSchema {
    TableSchema::of_formulas(samples.columns().into_iter().map(field).collect(), &function_columns(model))
}

/// Outputs of a study of formulas: a number without unit for each name.
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

/// Information that a column contains for a run that is not ok.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Availability {
    /// Complete: the value is an input of the run.
    Input,
    /// A lower bound: the value reached while all guards held, in the column of this name, if it exists.
    LowerBound(Option<String>),
    /// Time of a first event, if it happened while all guards and limits held, in the column of this name.
    EventTime(Option<String>),
    /// Time of the first exceeded limit of the model: in a run beyond the model that of the row, otherwise as `EventTime`.
    LimitTime(Option<String>),
    /// None.
    Unavailable,
}

impl Availability {
    /// Column with the value reached while all guards and limits held.
    #[must_use]
    pub fn guarded_column(&self) -> Option<&str> {
        match self {
            Self::LowerBound(name) | Self::EventTime(name) | Self::LimitTime(name) => name.as_deref(),
            Self::Input | Self::Unavailable => None,
        }
    }
}

/// Column of a study's table.
#[derive(Debug, Clone)]
pub struct TableColumn {
    /// Name, unit, storage.
    pub field: Field,
    /// Information for runs that are not ok.
    pub availability: Availability,
    /// Whether an empty cell of an ok run means that the run has no such quantity.
    pub unjudged: bool,
    /// Part or key that the study's machine needs for the column; without it the column is empty in every row.
    pub lacks: Option<String>,
}

/// Table columns of a study; `None`: its machine cannot be built.
#[must_use]
pub fn columns_of(samples: &Samples) -> Option<Vec<TableColumn>> {
    if let Some(model) = samples.study().function() {
        return Some(table_columns(&function_schema(samples, model), &function_columns(model)));
    }
    let definition = samples.try_machine(0).ok()??;
    let machine = definition.build().ok()?;
    let mut columns = table_columns(&table_schema(samples, &machine), &engine::columns(&machine));
    // A column that some sample has is not lacking.
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

/// Machines of the study that may have other quantities than that of the first sample: one for each word of a choice parameter,
/// and one with a twin run if samples have one.
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

/// Shift of a twin run that is valid for any machine.
const SHIFT: f64 = 1e-6;

/// Table columns of a study of this machine, or of unknown formulas, without varied parameters.
#[must_use]
pub fn columns_without(machine: Option<&Machine>) -> Vec<TableColumn> {
    let outcome = machine.map(engine::columns).unwrap_or_default();
    table_columns(&TableSchema::new(Vec::new(), &outcome), &outcome)
}

/// Combines the columns of a table with their availability. `outcome`: columns that the solver fills.
fn table_columns(schema: &TableSchema, outcome: &[OutcomeColumn]) -> Vec<TableColumn> {
    let columns = schema.fields().iter().enumerate().map(|(at, field)| {
        let solved = at.checked_sub(schema.given()).and_then(|at| outcome.get(at));
        let availability = match solved {
            None => Availability::Input,
            Some(column) if column.name == BEYOND_TIME => Availability::LimitTime(column.guarded()),
            Some(column) if column.grows() => Availability::LowerBound(column.guarded()),
            Some(column) if column.growth == Growth::Once => Availability::EventTime(column.guarded()),
            Some(_) => Availability::Unavailable,
        };
        let unjudged = solved.is_some_and(|column| column.empty == Empty::Unjudged);
        TableColumn {
            field: field.clone(),
            availability,
            unjudged,
            lacks: solved.and_then(|column| column.lacks.clone()),
        }
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

/// Names of the columns that every table of this machine has.
#[must_use]
pub fn own_columns(machine: &Machine) -> Vec<String> {
    let schema = TableSchema::new(Vec::new(), &engine::columns(machine));
    schema.fields().iter().map(|field| field.name.clone()).collect()
}
