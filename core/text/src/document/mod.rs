//! Reader of machine files and study files: a TOML tree with the position of each value, the list of all problems of a file, nearest names,
//! quantities with units, and escaping of untrusted text.

mod json;
mod nearest;
mod problem;
mod tree;
pub mod units;
mod visible;

pub use json::parse_json;
pub use nearest::nearest;
pub use problem::{BYTE_ORDER_MARK, Collector, MISSING, MOST_PROBLEMS, Problem, Problems, cut};
pub use tree::{Entry, MAX_FILE_BYTES, Node, Value, parse_toml};
pub use visible::{is_hidden, pictured_lines, visible, visible_json, visible_lines};
