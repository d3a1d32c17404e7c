//! What a column of the result table is. Which there are is declared by the solver, by the recorders that fill them.

/// Columns of an outcome at most: what a message between processes carries.
pub const MAX_COLUMNS: usize = 256;

/// How a column is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// f64.
    Real,
    /// A count: u64 in the table, exact in f64 below 2^53.
    Count,
    /// One of these words: text in the table, its index in an [`super::Outcome`].
    Choice(&'static [&'static str]),
}

/// One numeric column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name; ends in the SI unit where it has one.
    pub name: String,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Storage.
    pub kind: ColumnKind,
    /// What it means, one sentence.
    pub meaning: String,
}
