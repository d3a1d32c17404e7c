//! Paths as messages show them.

use bladeoff_text::document::visible;
use std::path::Path;

/// A path in one line, whatever is in its names: what would act on a terminal or end the line is made visible, and what is no
/// text is replaced. For everything that a person reads; a path that is used again, or goes into a command
/// ([`crate::call::word`]) or a file, stays as it is.
///
/// Verified by `a_name_with_a_line_feed_adds_no_line` in `tests/program/escapes.rs`.
#[must_use]
pub fn shown(path: impl AsRef<Path>) -> String {
    visible(&path.as_ref().to_string_lossy()).into_owned()
}
