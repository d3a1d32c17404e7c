//! The version of histories.

/// Version of the contents of history files; a reader rejects a version that it does not know.
pub const HISTORY_VERSION: u32 = 1;
