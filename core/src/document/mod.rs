//! What machine files and study files share: a TOML tree that knows where everything stands, the list of all problems
//! of a file, nearest names, and quantities with units.

mod nearest;
mod problem;
mod tree;
pub mod units;

pub use nearest::nearest;
pub use problem::{BYTE_ORDER_MARK, Collector, MOST_PROBLEMS, Problem, Problems, cut};
pub use tree::{Entry, MAX_FILE_BYTES, Node, Value, parse_toml};
