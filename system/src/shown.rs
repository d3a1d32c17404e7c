//! Paths in messages.

use bladeoff_text::document::visible;
use std::path::Path;

/// A path in one line: characters that act on a terminal or end the line are escaped, and bytes that are not text are replaced. For output
/// that a person reads. Paths that are used again, or become part of a command ([`crate::call::word`]) or a file, stay unchanged.
///
/// Verified by `a_name_with_a_line_feed_adds_no_line` in `tests/program/escapes.rs`.
#[must_use]
pub fn shown(path: impl AsRef<Path>) -> String {
    visible(&path.as_ref().to_string_lossy()).into_owned()
}
