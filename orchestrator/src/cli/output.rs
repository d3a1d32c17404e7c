//! Standard output is data, standard error everything else. Neither ever makes the program panic, and neither passes on what
//! would act on a terminal: whatever came from files, their names and other programs is made visible here.

use super::error::CliError;
use bladeoff_model::document::{visible_json, visible_lines};
use std::io::{self, Write};

/// Writes data to standard output.
///
/// # Errors
/// The reader's disk is full or the like; a reader that went away (`| head`) is [`CliError::ReaderLeft`].
pub fn print(text: &str) -> Result<(), CliError> {
    write(&visible_lines(text))
}

/// Writes JSON to standard output.
///
/// # Errors
/// As [`print`].
pub fn print_json(json: &str) -> Result<(), CliError> {
    write(&visible_json(json))
}

fn write(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(CliError::stdout)
}

/// Writes a remark to standard error; if nobody can read it, that is no reason to stop.
pub fn remark(text: &str) {
    let _ = writeln!(io::stderr(), "{}", visible_lines(text));
}

/// The same for an error as [`super::render::render`] made it, which has colours of its own and nothing else.
pub fn rendered(text: &str) {
    let _ = writeln!(io::stderr(), "{}", text.trim_end());
}
