//! Reasons of the end of a run, and its progress towards the end.

use std::time::Duration;

use super::settings::RunLimits;
use super::until::Until;

/// Signal that ended a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, or SIGHUP unless it is ignored.
    Terminate,
}

/// Reason of the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Every sample is done.
    Complete,
    /// As many samples are done as `[stop]` of the study requires: complete as well.
    Stop,
    /// Signal.
    Signalled(Signal),
    /// `wall` was reached.
    Wall,
    /// `until` was reached.
    Until,
    /// `max_failures` was exceeded.
    TooManyFailures,
}

impl Ended {
    /// Word for events, status and manifest.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Ended::Complete => "complete",
            Ended::Stop => "stop",
            Ended::Signalled(Signal::Interrupt) => "interrupted",
            Ended::Signalled(Signal::Terminate) => "terminated",
            Ended::Wall => "wall",
            Ended::Until => "until",
            Ended::TooManyFailures => "max_failures",
        }
    }
}

impl Ended {
    /// Whether the study is complete.
    #[must_use]
    pub fn is_complete(self) -> bool {
        matches!(self, Ended::Complete | Ended::Stop)
    }

    /// Command-line option that ended the run, if any.
    #[must_use]
    pub fn by_option(self) -> Option<&'static str> {
        match self {
            Ended::Wall => Some("--wall"),
            Ended::Until => Some("--until"),
            Ended::TooManyFailures => Some("--max-failures"),
            Ended::Complete | Ended::Stop | Ended::Signalled(_) => None,
        }
    }

    /// State in which the study is left: `complete`, or the reason why not.
    #[must_use]
    pub fn state(self) -> &'static str {
        if self.is_complete() { Ended::Complete.word() } else { self.word() }
    }
}

/// Progress of a run towards its end.
#[derive(Debug)]
pub(super) struct Ending {
    /// End by the wall clock, which moves when that clock is set.
    pub until: Option<Until>,
    /// Reason of an end before the study is complete.
    pub why: Option<Ended>,
    /// Time at which unfinished samples are killed; no samples are assigned any more.
    pub deadline: Option<Duration>,
    /// Workers in a row died before they asked for work.
    pub has_given_up: bool,
}

impl Ending {
    pub fn new(limits: &RunLimits) -> Self {
        Self { until: limits.until, why: None, deadline: None, has_given_up: false }
    }

    /// Whether assignments have ended.
    pub fn has_begun(&self) -> bool {
        self.deadline.is_some()
    }
}
