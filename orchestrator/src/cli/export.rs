//! `bladeoff export`: the result table in another format.

use super::error::CliError;
use super::exit::Exit;
use super::output::remark;
use crate::run::directory::{MANIFEST, PARTS, RESULTS};
use crate::run::refuse_changed;
use crate::run::shards::{is_unmerged, row_files, unread};
use bladeoff_answers::tables::{CsvStyle, TableError, export_csv};
use bladeoff_system::call;
use bladeoff_system::files::Pending;
use bladeoff_system::shown;
use bladeoff_text::document::visible_lines;
use std::ffi::OsStr;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Write the table of a result directory as CSV
///
/// One header line with the column names (unit included), then one line per sample. Numbers have all their digits; null
/// is an empty cell. pandas, Polars and DuckDB read the Parquet file itself. Of an incomplete study the finished rows are
/// written, in the order in which they were finished. A table that differs from its checksum in manifest.json is
/// rejected; `bladeoff run` with the same study writes it again.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bladeoff export runs/first-look --csv > first-look.csv\n  bladeoff export runs/first-look --csv --out first-look.csv"
)]
pub struct Args {
    /// Result directory of `bladeoff run`
    directory: PathBuf,

    /// Comma-separated values
    #[arg(long, required = true)]
    csv: bool,

    /// `;` between cells and decimal commas, for spreadsheets that use them; [points] reads both styles
    #[arg(long)]
    decimal_comma: bool,

    /// Write to this file instead of standard output; an existing file is not overwritten
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    debug_assert!(args.csv, "the only format, and required");
    let files = row_files(&args.directory);
    let Some(first) = files.first() else { return Err(CliError::no_results(&args.directory)) };
    if is_unmerged(&args.directory) {
        unread(&args.directory).iter().for_each(|what| remark(&format!("warning: {what}")));
        let merge = call::command([OsStr::new("merge"), call::path_word(&args.directory).as_os_str()]);
        remark(&format!("warning: the shards are not merged ({merge}); exporting what their chunks hold"));
    } else if !first.ends_with(RESULTS) {
        let parts = args.directory.join(PARTS);
        remark(&format!(
            "warning: the study is incomplete; exporting the finished rows that are in {} (after a kill the record may have a few \
             more: `run` writes them). Parts have no checksum, so they cannot be verified",
            shown(parts)
        ));
    }
    // changed numbers must not be copied into another file
    let is_known = refuse_changed(&args.directory)?;
    if first.ends_with(RESULTS) && !is_known {
        remark(&format!("warning: {} cannot be verified: {MANIFEST} has no checksum of it", shown(first)));
    }
    let style = if args.decimal_comma { CsvStyle::Comma } else { CsvStyle::Point };
    match &args.out {
        Some(path) if path.symlink_metadata().is_ok() => return Err(CliError::Exists { path: path.clone() }),
        Some(path) => {
            let mut pending = Pending::create(path)?;
            export_csv(&files, path, style, BufWriter::new(pending.file()))?;
            pending.finish_new()?;
            remark(&format!("wrote {}", shown(path)));
        }
        None => {
            let stdout = io::stdout().lock();
            let is_terminal = stdout.is_terminal();
            let mut out = Watched { inner: stdout, is_terminal, error: None };
            let exported = export_csv(&files, Path::new("standard output"), style, &mut out);
            if let Some(error) = out.error {
                return Err(CliError::stdout(error));
            }
            exported.map_err(|error: TableError| CliError::from(error))?;
            out.inner.flush().map_err(CliError::stdout)?;
        }
    }
    Ok(Exit::Ok)
}

/// Keeps the error of a write: Polars replaces it, so that a closed reader could not be recognised.
struct Watched<W> {
    inner: W,
    /// Whether standard output is a terminal, where control characters are made visible; other programs get the values unchanged.
    is_terminal: bool,
    error: Option<io::Error>,
}

impl<W: Write> Write for Watched<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match std::str::from_utf8(bytes) {
            Ok(text) if self.is_terminal => self.inner.write_all(visible_lines(text).as_bytes()).map(|()| bytes.len()),
            _ => self.inner.write(bytes),
        };
        written.inspect_err(|error| {
            if error.kind() != io::ErrorKind::Interrupted {
                self.error = Some(io::Error::from(error.kind()));
            }
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
