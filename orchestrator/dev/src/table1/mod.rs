//! The paper's Table 1 compared with the results of this program, evaluated from the numbers of the runs alone.

mod causes;
mod done;
mod quantity;
mod separation;
mod verdict;

pub use done::{Done, csv};
pub use verdict::report;
