//! The paper's Table 1 beside ours: what the runs of the comparison say, from their numbers alone.

mod causes;
mod done;
mod quantity;
mod separation;
mod verdict;

pub use done::{Done, csv};
pub use verdict::report;
