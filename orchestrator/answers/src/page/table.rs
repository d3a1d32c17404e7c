//! A table of a page.

/// A table with text cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Names of the columns.
    pub head: Vec<String>,
    /// Cells; numbers are recognised and right-aligned.
    pub rows: Vec<Vec<String>>,
    /// Columns with commands or names, shown in a fixed-width font.
    pub verbatim: Vec<usize>,
}
