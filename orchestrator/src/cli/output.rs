//! Standard output is data, standard error everything else. Neither ever makes the program panic.

use super::error::CliError;
use std::io::{self, Write};

/// Writes data to standard output.
///
/// # Errors
/// The reader's disk is full or the like; a reader that went away (`| head`) is [`CliError::ReaderLeft`].
pub fn print(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(CliError::stdout)
}

/// Writes a remark to standard error; if nobody can read it, that is no reason to stop.
pub fn remark(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}
