//! A column of a table that comes from the study.

/// Type of a column; whole numbers, words and texts are [`ParamValue`](bladeoff_model::machine::ParamValue) as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Numbers.
    Real,
    /// Whole numbers.
    Integer,
    /// Words of a choice, or text.
    Word,
}

/// A column that the study gives to a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name; ends with the SI unit if there is a unit.
    pub name: String,
    /// SI unit, "" for none.
    pub unit: String,
    /// Meaning in one sentence.
    pub meaning: String,
    /// Type of the values.
    pub kind: ColumnKind,
}
