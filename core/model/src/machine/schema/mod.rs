//! The format of machine files as data: one table of every key. The checks of unknown keys, missing keys and values use this table, as do nearest
//! names, parameter paths and the template.

mod bounds;
mod key;
mod keys;
mod range;
mod tree;

pub use key::{Key, Kind, Need, When};
pub use keys::{
    CONTACT_STEP, END_TIME, ENGINE, FLAG, NORMAL_WORK, PENETRATION, STEP, STEP_LIMIT, TWIN, TWIN_LIMIT,
    TWIN_LIMIT_DEFAULT, default_of, keys,
};
pub use range::Range;
pub(super) use tree::{Branch, Segment, root};

/// Version of the format that this program reads.
pub const SCHEMA: i128 = 1;
