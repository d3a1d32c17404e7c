//! A table of a page.

/// A table in words.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Names of its columns.
    pub head: Vec<String>,
    /// Their cells; numbers are recognised and set to the right.
    pub rows: Vec<Vec<String>>,
    /// Columns whose cells are commands or names, set as such.
    pub verbatim: Vec<usize>,
}
