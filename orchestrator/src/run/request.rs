//! Request of a run, and its result.

use super::chosen::Refining;
use super::directory::RESULTS;
use super::end::{PrecisionCheck, TableEnd};
use super::resume::Rerun;
use super::so_far::Watched;
use crate::dispatch::Ended;
use crate::schedule::RunLimits;
use crate::terminal::Tally;
use bladeoff_study::SampleLimits;
use bladeoff_worker::fault::Faults;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Request of a run.
#[derive(Debug, Clone)]
pub struct Request {
    /// Result directory; an existing one is continued.
    pub out: PathBuf,
    /// Accept a directory to which other users may write.
    pub trusts: bool,
    /// Number of worker processes.
    pub workers: usize,
    /// Limits of one sample.
    pub sample: SampleLimits,
    /// Limits of the run; the time of `wall` begins at [`Request::begun`].
    pub limits: RunLimits,
    /// When the program began to prepare the run.
    pub begun: Instant,
    /// Print events on standard output, for programs.
    pub json_events: bool,
    /// Finished samples to compute again.
    pub rerun: Option<Rerun>,
    /// Interim analyses that may end the study early.
    pub looking: Option<Rc<dyn PrecisionCheck>>,
    /// Choice of samples for a map.
    pub refining: Option<Rc<dyn Refining>>,
    /// Quantities of the progress line.
    pub watched: Watched,
    /// Interval of partial tables; zero: only with many rows.
    pub refresh: Duration,
    /// Fault hooks of this process, passed in by the binary.
    pub faults: &'static dyn Faults,
}

/// Result of a run.
#[derive(Debug)]
pub struct Finished {
    /// Counts of all samples by status, with those of earlier runs.
    pub tally: Tally,
    /// Samples of earlier runs.
    pub reused: u64,
    /// Reason of the end.
    pub ended: Ended,
    /// End of the table, if it is not that of its design or interim analyses were made.
    pub end: Option<TableEnd>,
    /// Path of the table, or of the folder of parts if it is incomplete; `None`: there is no row.
    pub table: Option<PathBuf>,
}

impl Finished {
    /// Result of a complete directory.
    pub(super) fn nothing_computed(directory: &Path, tally: &Tally, end: Option<TableEnd>) -> Self {
        let (tally, table) = (tally.clone(), Some(directory.join(RESULTS)));
        let ended = if end.is_some_and(|end| end.is_early()) { Ended::Stop } else { Ended::Complete };
        Self { reused: tally.done(), tally, ended, end, table }
    }
}
