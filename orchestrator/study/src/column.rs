//! A column that a study gives to a table.

/// What a column of the study holds in a table; whole numbers, words and texts come as [`ParamValue`](bladeoff_model::machine::ParamValue), too.
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
    /// Name; ends in the SI unit where it has one.
    pub name: String,
    /// SI unit, "" for none.
    pub unit: String,
    /// What it means, one sentence.
    pub meaning: String,
    /// What it holds.
    pub kind: ColumnKind,
}
