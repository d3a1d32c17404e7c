//! The result table as CSV: for programs that read nothing better. Numbers keep all their digits; null is empty.

use super::TableError;
use super::read::for_each_frame;
use bladeoff_system::files::FileError;
use polars::prelude::AnyValue;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Bytes gathered before they are written.
const GATHERED: usize = 1 << 16;

/// Writes the rows in these files as CSV with one header line to `out`, which is called `name` in errors, file by file.
///
/// # Errors
/// A file cannot be read, or `out` cannot be written.
pub fn export_csv(files: &[PathBuf], name: &Path, mut out: impl Write) -> Result<(), TableError> {
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
                    push(&mut text, at, column.name().as_str());
                }
                text.push('\n');
            }
            for row in 0..frame.height() {
                for (at, column) in frame.columns().iter().enumerate() {
                    push(&mut text, at, &shown(&column.get(row).map_err(failed(path))?));
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

/// A cell; the shortest decimal that reads back as the same bits.
fn shown(cell: &AnyValue<'_>) -> String {
    match cell {
        AnyValue::Null => String::new(),
        AnyValue::Float64(number) => format!("{number:?}"),
        AnyValue::String(word) => (*word).to_owned(),
        AnyValue::StringOwned(word) => word.to_string(),
        other => other.to_string(),
    }
}

/// Adds a cell, quoted where it has to be.
fn push(text: &mut String, at: usize, cell: &str) {
    if at > 0 {
        text.push(',');
    }
    if cell.contains([',', '"', '\n', '\r']) {
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
        assert_eq!(shown(&AnyValue::Float64(0.1 + 0.2)), "0.30000000000000004");
        assert_eq!(shown(&AnyValue::UInt64(7)), "7");
        assert_eq!(shown(&AnyValue::Null), "");
        let mut text = String::new();
        push(&mut text, 0, "normal_work,slip_reversal");
        push(&mut text, 1, "ok");
        assert_eq!(text, "\"normal_work,slip_reversal\",ok");
    }
}
