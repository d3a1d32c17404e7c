//! The machine file's format as data: one table of every key. Unknown-key and missing-key checks, value checks,
//! nearest names, parameter paths and the template all come from it.

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

/// The version of the format this program reads.
pub const SCHEMA: i128 = 1;
