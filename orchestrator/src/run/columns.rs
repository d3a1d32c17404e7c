//! The columns of a study's table: those that the study declares and those of the solver, as the table wants them.

use crate::engine;
use bladeoff_answers::tables::{Field, FieldKind, TableSchema};
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Column as OutcomeColumn, ColumnKind as OutcomeKind, Group, Growth, Part};
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
    /// What happened once and for all, where nothing but a step limit or a limit of the model ended the run.
    Once,
    /// All. An empty cell means that no limit of the model was exceeded.
    Limit,
    /// Nothing.
    Found,
}

/// A column of a study's table.
#[derive(Debug, Clone)]
pub struct TableColumn {
    /// Name, unit, storage.
    pub field: Field,
    /// Of runs that are not ok.
    pub told: Told,
}

/// All columns of the table of these samples; `None`: their machine cannot be built.
#[must_use]
pub fn columns_of(samples: &Samples) -> Option<Vec<TableColumn>> {
    if let Some(model) = samples.study().function() {
        return Some(told(&function_schema(samples, model), &function_columns(model)));
    }
    let machine = samples.try_machine(0).ok()??.build().ok()?;
    Some(told(&table_schema(samples, &machine), &engine::columns(&machine)))
}

/// Those of a study of this machine, or of formulas that are not known, in which nothing varies.
#[must_use]
pub fn columns_without(machine: Option<&Machine>) -> Vec<TableColumn> {
    let outcome = machine.map(engine::columns).unwrap_or_default();
    told(&TableSchema::new(Vec::new(), &outcome), &outcome)
}

/// `outcome`: the columns that the solver fills.
fn told(schema: &TableSchema, outcome: &[OutcomeColumn]) -> Vec<TableColumn> {
    let columns = schema.fields().iter().enumerate().map(|(at, field)| {
        let told = match at.checked_sub(schema.given()).and_then(|at| outcome.get(at)) {
            None => Told::Given,
            Some(column) if column.name == BEYOND_TIME => Told::Limit,
            Some(column) if column.grows() => Told::Grown(column.guarded()),
            Some(column) if column.growth == Growth::Once => Told::Once,
            Some(_) => Told::Found,
        };
        TableColumn { field: field.clone(), told }
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
