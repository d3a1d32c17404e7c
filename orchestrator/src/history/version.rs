//! The version of histories.

/// Version of what the files contain; a reader refuses one it does not know.
pub const HISTORY_VERSION: u32 = 1;
