//! Outcome of a run: status, cause, and one number per column of the result table. The solver makes it, processes hand it on, tables
//! keep it: those who only hand on or keep need no solver.

mod causes;
mod columns;
mod limit;

pub use causes::{Cause, CauseSet, EndCause, Status};
pub use columns::{Column, ColumnKind, Empty, Group, Growth, MAX_COLUMNS, Part};
pub use limit::Limit;

/// The outcome of one run: a row of the result table without its sample number and parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Whether the row may be believed.
    pub status: Status,
    /// First cause why not; `None` exactly when `status` is [`Status::Ok`].
    pub cause: Option<Cause>,
    /// Every cause that holds, `cause` included.
    pub causes: CauseSet,
    /// Limits of the model that the run exceeded and that the machine file only notes: they leave the status as it is.
    pub notes: CauseSet,
    /// Why the run ended.
    pub end_cause: EndCause,
    /// One value per column that the solver declares for the machine, in that order; `None` for what did not happen, never NaN.
    pub values: Vec<Option<f64>>,
}
