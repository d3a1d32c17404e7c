//! A column that a study gives to a table.

/// Kind of a column of the study in a table; whole numbers, words and texts are [`ParamValue`](bladeoff_model::machine::ParamValue) as well.
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
    /// Meaning in one sentence.
    pub meaning: String,
    /// Kind of its values.
    pub kind: ColumnKind,
}
