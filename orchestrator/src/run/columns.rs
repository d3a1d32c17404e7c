//! The columns of a study's table: those that the study declares and those of the solver, as the table wants them.

use crate::engine;
use bladeoff_answers::tables::{Field, FieldKind, TableSchema};
use bladeoff_model::machine::Machine;
use bladeoff_study::{Column, ColumnKind, Samples};

/// All columns of the table of these samples; `machine`: one of theirs.
pub(super) fn table_schema(samples: &Samples, machine: &Machine) -> TableSchema {
    TableSchema::new(samples.columns().into_iter().map(field).collect(), &engine::columns(machine))
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
