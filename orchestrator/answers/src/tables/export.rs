//! The result table as CSV. Numbers have all their digits; null is an empty cell.

use super::TableError;
use super::read::for_each_frame;
use bladeoff_system::files::FileError;
use polars::prelude::AnyValue;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Number of bytes buffered before a write.
const GATHERED: usize = 1 << 16;

/// Format of numbers and cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CsvStyle {
    /// `,` between cells, decimal points.
    #[default]
    Point,
    /// `;` between cells, decimal commas.
    Comma,
}

impl CsvStyle {
    /// Character between two cells.
    #[must_use]
    pub fn separator(self) -> char {
        match self {
            Self::Point => ',',
            Self::Comma => ';',
        }
    }

    /// The shortest decimal that parses to the same bits.
    #[must_use]
    pub fn number(self, number: f64) -> String {
        let text = format!("{number:?}");
        if self == Self::Comma { text.replace('.', ",") } else { text }
    }
}

/// Writes the rows in these files, file by file, as CSV with one header line to `out`; `name`: name of `out` in errors.
///
/// # Errors
/// A file cannot be read, or `out` cannot be written.
pub fn export_csv(files: &[PathBuf], name: &Path, style: CsvStyle, mut out: impl Write) -> Result<(), TableError> {
    let failed = |path: &PathBuf| {
        let path = path.clone();
        move |source| TableError::Table { action: "export", path, source }
    };
    let mut text = String::new();
    let mut has_header = false;
    for path in files {
        for_each_frame(path, None, |frame| {
            if !std::mem::replace(&mut has_header, true) {
                for (at, column) in frame.columns().iter().enumerate() {
                    push(&mut text, style, at, column.name().as_str());
                }
                text.push('\n');
            }
            for row in 0..frame.height() {
                for (at, column) in frame.columns().iter().enumerate() {
                    push(&mut text, style, at, &shown(&column.get(row).map_err(failed(path))?, style));
                }
                text.push('\n');
                if text.len() > GATHERED {
                    out.write_all(text.as_bytes()).map_err(FileError::at("write", name))?;
                    text.clear();
                }
            }
            Ok(())
        })?;
    }
    Ok(out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(FileError::at("write", name))?)
}

/// Text of a cell; for numbers the shortest decimal that parses to the same bits.
fn shown(cell: &AnyValue<'_>, style: CsvStyle) -> String {
    match cell {
        AnyValue::Null => String::new(),
        AnyValue::Float64(number) => style.number(*number),
        AnyValue::String(word) => (*word).to_owned(),
        AnyValue::StringOwned(word) => word.to_string(),
        other => other.to_string(),
    }
}

/// Appends a cell, quoted if necessary.
fn push(text: &mut String, style: CsvStyle, at: usize, cell: &str) {
    if at > 0 {
        text.push(style.separator());
    }
    if cell.contains([style.separator(), '"', '\n', '\r']) {
        write!(text, "\"{}\"", cell.replace('"', "\"\"")).expect("writing to a String cannot fail");
    } else {
        text.push_str(cell);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_their_digits_and_are_quoted_where_needed() {
        assert_eq!(shown(&AnyValue::Float64(0.1 + 0.2), CsvStyle::Point), "0.30000000000000004");
        assert_eq!(shown(&AnyValue::UInt64(7), CsvStyle::Comma), "7");
        assert_eq!(shown(&AnyValue::Null, CsvStyle::Comma), "");
        let mut text = String::new();
        push(&mut text, CsvStyle::Point, 0, "normal_work,slip_reversal");
        push(&mut text, CsvStyle::Point, 1, "ok");
        assert_eq!(text, "\"normal_work,slip_reversal\",ok");
        let mut text = String::new();
        for (at, cell) in
            [&*shown(&AnyValue::Float64(-1.5e-7), CsvStyle::Comma), "a;b", "a,b", "2\nlines"].iter().enumerate()
        {
            push(&mut text, CsvStyle::Comma, at, cell);
        }
        assert_eq!(text, "-1,5e-7;\"a;b\";a,b;\"2\nlines\"");
    }
}
