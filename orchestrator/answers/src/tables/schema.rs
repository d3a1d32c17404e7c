//! Columns of `results.parquet`: one list for the table, the JSON of `simulate`, and the documentation.
//!
//! ```text
//! sample | each varied parameter | detection | status cause causes end_cause notes | outcome columns of core | engine
//! ```
//! The contact detection always has its own column `detection`, also if it is varied. `engine` is the last column. Tables of formula
//! studies have neither.

use bladeoff_model::outcome::{Column, ColumnKind};

/// Layout version of the table; readers reject unknown versions.
pub const SCHEMA_VERSION: u32 = 3;

/// Storage type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldKind {
    /// f64.
    Real,
    /// u64.
    Count,
    /// i64: an integer parameter.
    Integer,
    /// A word.
    Word,
    /// One of these words; the solver gives its index.
    Choice(&'static [&'static str]),
}

impl FieldKind {
    /// Word for a value of the solver; `None` for a numeric field, or an invalid index.
    #[must_use]
    pub fn word(self, value: f64) -> Option<&'static str> {
        match self {
            FieldKind::Choice(words) if value >= 0.0 && value.fract() == 0.0 => words.get(value as usize).copied(),
            _ => None,
        }
    }
}

/// One column of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Name; ends in the SI unit if there is one.
    pub name: String,
    /// SI unit, "" for none.
    pub unit: String,
    /// Meaning, in one sentence.
    pub meaning: String,
    /// Storage type.
    pub kind: FieldKind,
}

/// All columns of a study's table, in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableSchema {
    fields: Vec<Field>,
    parameters: usize,
    is_of_machine: bool,
}

/// Name of the column of the contact detection.
pub const DETECTION: &str = "detection";
/// Name of the column of the engine.
pub const ENGINE: &str = "engine";
/// Column of the reason why a run ended.
pub const END_CAUSE: &str = "end_cause";
/// Column of the simulated time at which a run ended.
pub const END_TIME: &str = "end_time_s";
/// Column of the mean spin at which a run ended.
pub const END_SPEED: &str = "end_speed_rad_s";
/// Column of noted limits.
pub const NOTES: &str = "notes";
/// Verdict columns that formula studies do not have.
const OF_MACHINES: [&str; 2] = [DETECTION, NOTES];

impl TableSchema {
    /// Columns of a study that varies `parameters` (without the detection) on a machine with these outcome columns.
    #[must_use]
    pub fn new(parameters: Vec<Field>, outcome: &[Column]) -> Self {
        Self::with(parameters, verdict_fields(), outcome)
    }

    /// Columns of a formula study: variables and results.
    #[must_use]
    pub fn of_formulas(variables: Vec<Field>, outcome: &[Column]) -> Self {
        let mut verdict = verdict_fields();
        verdict.retain(|field| !OF_MACHINES.contains(&field.name.as_str()));
        verdict.iter_mut().filter(|field| field.name == END_CAUSE).for_each(|field| {
            field.meaning = "evaluated, or failure (a formula gave no finite number)".to_owned();
        });
        Self::with(variables, verdict, outcome)
    }

    fn with(parameters: Vec<Field>, verdict: Vec<Field>, outcome: &[Column]) -> Self {
        let count = parameters.len();
        let is_of_machine = verdict.iter().any(|field| field.name == DETECTION);
        let mut fields = vec![field("sample", FieldKind::Count, "row number in the study, from 0")];
        fields.extend(parameters);
        fields.extend(verdict);
        fields.extend(outcome.iter().map(|column| Field {
            name: column.name.clone(),
            unit: column.unit.to_owned(),
            meaning: column.meaning.clone(),
            kind: match column.kind {
                ColumnKind::Real => FieldKind::Real,
                ColumnKind::Count => FieldKind::Count,
                ColumnKind::Choice(words) => FieldKind::Choice(words),
            },
        }));
        if is_of_machine {
            fields.push(field(ENGINE, FieldKind::Word, "engine that computed the run: reduced, full or exponential"));
        }
        Self { fields, parameters: count, is_of_machine }
    }

    /// All fields in order.
    #[must_use]
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// The fields of the varied parameters.
    #[must_use]
    pub fn parameters(&self) -> &[Field] {
        &self.fields[1..=self.parameters]
    }

    /// The fields of the numeric outcome.
    #[must_use]
    pub fn outcome(&self) -> &[Field] {
        let end = self.fields.len() - usize::from(self.is_of_machine);
        &self.fields[self.given()..end]
    }

    /// Number of fields before the numeric outcome.
    #[must_use]
    pub fn given(&self) -> usize {
        1 + self.parameters + verdict_fields().len() - if self.is_of_machine { 0 } else { OF_MACHINES.len() }
    }

    /// Whether the rows are runs of a machine, with columns for contact detection and engine.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        self.is_of_machine
    }
}

/// Fields between parameters and numeric outcome: detection, status, causes, notes.
#[must_use]
pub fn verdict_fields() -> Vec<Field> {
    vec![
        field(DETECTION, FieldKind::Word, "contact detection: hyp1, hyp2 or hyp2-frozen; null without a diaphragm"),
        field(
            "status",
            FieldKind::Word,
            "ok, beyond (a limit of the model was exceeded), invalid (a numerical check failed), failed (ended early) or quarantined",
        ),
        field("cause", FieldKind::Word, "first cause why the status is not ok; null when it is"),
        field("causes", FieldKind::Word, "every cause that holds, joined by commas; null when the status is ok"),
        field(END_CAUSE, FieldKind::Word, "why the run ended: stopped, end_time, end_speed, limit or failure"),
        field(NOTES, FieldKind::Word, "exceeded limits of the model that leave the status as it is, joined by commas"),
    ]
}

fn field(name: &str, kind: FieldKind, meaning: &str) -> Field {
    Field { name: name.to_owned(), unit: String::new(), meaning: meaning.to_owned(), kind }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::outcome::{Empty, Group, Growth, Part};

    #[test]
    fn parts_of_the_schema_are_found_again() {
        let outcome = [Column {
            name: "steps".into(),
            unit: "",
            kind: ColumnKind::Count,
            meaning: "time steps".into(),
            group: Group::Numerics,
            part: Part::Whole,
            growth: Growth::Grows,
            is_guarded: false,
            empty: Empty::Absent,
            lacks: None,
        }];
        let gap = Field { name: "gap_m".into(), unit: "m".into(), meaning: "gap".into(), kind: FieldKind::Real };
        let schema = TableSchema::new(vec![gap.clone()], &outcome);
        assert_eq!(schema.parameters(), std::slice::from_ref(&gap));
        assert_eq!(schema.outcome()[0].name, "steps");
        assert_eq!((schema.fields().len(), schema.outcome().len()), (1 + 1 + 6 + 1 + 1, 1));
        assert_eq!(schema.fields()[9].name, ENGINE);
        let formulas = TableSchema::of_formulas(vec![gap.clone()], &outcome);
        assert_eq!((formulas.parameters(), formulas.outcome()), (schema.parameters(), schema.outcome()));
        let names: Vec<&str> = formulas.fields().iter().map(|field| field.name.as_str()).collect();
        assert_eq!(names, ["sample", "gap_m", "status", "cause", "causes", "end_cause", "steps"]);
    }
}
