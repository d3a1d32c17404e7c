//! What is asked of a run, and what it answers.

use super::chosen::Refining;
use super::directory::RESULTS;
use super::end::{Looking, TableEnd};
use super::resume::Rerun;
use crate::dispatch::Ended;
use crate::schedule::RunLimits;
use crate::terminal::Tally;
use bladeoff_study::SampleLimits;
use bladeoff_worker::fault::Faults;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// Result directory; a run that is there is continued.
    pub out: PathBuf,
    /// Work there even if others could write in it.
    pub trusts: bool,
    /// Worker processes.
    pub workers: usize,
    /// What one sample may take.
    pub sample: SampleLimits,
    /// Limits of the run; the time of `wall` begins at [`Request::begun`].
    pub limits: RunLimits,
    /// When the program began to prepare the run.
    pub begun: Instant,
    /// Say what happens on standard output, for programs.
    pub json_events: bool,
    /// Finished samples that are computed again.
    pub rerun: Option<Rerun>,
    /// Where the study may end before its design does.
    pub looking: Option<Rc<dyn Looking>>,
    /// Which of its samples a map takes.
    pub refining: Option<Rc<dyn Refining>>,
    /// Time between two parts of finished rows; zero: only when there are many.
    pub refresh: Duration,
    /// Faults of this process, as the binary passes them in.
    pub faults: &'static dyn Faults,
}

/// How a study ended.
#[derive(Debug)]
pub struct Finished {
    /// Counts of the samples, those that were there before included.
    pub tally: Tally,
    /// Samples that were there before.
    pub reused: u64,
    /// Why it ended.
    pub ended: Ended,
    /// Where the table ends, if that is not where its design does, or was looked at before.
    pub end: Option<TableEnd>,
    /// The table, or the folder of the parts of one that is incomplete; `None` before there is a row.
    pub table: Option<PathBuf>,
}

impl Finished {
    /// Of a directory in which everything is.
    pub(super) fn nothing_computed(directory: &Path, tally: &Tally, end: Option<TableEnd>) -> Self {
        let (tally, table) = (tally.clone(), Some(directory.join(RESULTS)));
        let ended = if end.is_some_and(|end| end.is_early()) { Ended::Stop } else { Ended::Complete };
        Self { reused: tally.done(), tally, ended, end, table }
    }
}
