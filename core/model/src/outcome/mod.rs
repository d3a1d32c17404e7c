//! Outcome of a run: status, cause, and one number per column of the result table. The solver creates outcomes; code that only transmits or stores
//! them does not depend on the solver.

mod causes;
mod columns;
mod limit;

pub use causes::{Cause, CauseSet, EndCause, Status};
pub use columns::{Column, ColumnKind, Empty, Group, Growth, MAX_COLUMNS, Part};
pub use limit::Limit;

/// The outcome of one run: a row of the result table without its sample number and parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Status: usability of the row.
    pub status: Status,
    /// First cause of a status other than `ok`; `None` exactly if `status` is [`Status::Ok`].
    pub cause: Option<Cause>,
    /// All causes that apply, including `cause`.
    pub causes: CauseSet,
    /// Exceeded limits of the model that the machine file only notes; they leave the status unchanged.
    pub notes: CauseSet,
    /// Reason for the end of the run.
    pub end_cause: EndCause,
    /// One value per column that the solver declares for the machine, in that order; `None` for an event that did not occur, never NaN.
    pub values: Vec<Option<f64>>,
}
