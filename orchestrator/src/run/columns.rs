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
