//! Why a study cannot be run as it is.

use super::design::DesignError;
use super::input::InputError;
use bladeoff_model::document::Problems;
use bladeoff_system::threads::ThreadsError;

/// Why a study cannot be run as it is.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Problems in the study, its machine or its points file.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Problems(Vec<Problems>),
    /// A file that cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Too many samples, or a scale out of range.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// Its machines could not be built in parallel.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
}
