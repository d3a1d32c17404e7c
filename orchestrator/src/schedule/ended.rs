//! Why a run ends, and how far it is with that.

use std::time::Duration;

use super::settings::RunLimits;
use super::until::Until;

/// A signal that ended a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, or SIGHUP unless it is ignored.
    Terminate,
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Every sample is done.
    Complete,
    /// As many as `[stop]` of the study asks for: complete as well.
    Stop,
    /// A signal came.
    Signalled(Signal),
    /// `wall` was reached.
    Wall,
    /// `until` was reached.
    Until,
    /// `max_failures` was exceeded.
    TooManyFailures,
}

impl Ended {
    /// The word of it, the same in events, status and manifest.
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

    /// The option of the command line that ended it, if one did.
    #[must_use]
    pub fn by_option(self) -> Option<&'static str> {
        match self {
            Ended::Wall => Some("--wall"),
            Ended::Until => Some("--until"),
            Ended::TooManyFailures => Some("--max-failures"),
            Ended::Complete | Ended::Stop | Ended::Signalled(_) => None,
        }
    }

    /// The state that it leaves a study in: `complete`, or why it is not.
    #[must_use]
    pub fn state(self) -> &'static str {
        if self.is_complete() { Ended::Complete.word() } else { self.word() }
    }
}

/// How far a run is with ending.
#[derive(Debug)]
pub(super) struct Ending {
    /// The end by the clock on the wall, which moves when that clock is set.
    pub until: Option<Until>,
    /// What made it end before it was complete.
    pub why: Option<Ended>,
    /// No assignments any more; what is unfinished is killed then.
    pub deadline: Option<Duration>,
    /// Worker after worker died before it asked.
    pub has_given_up: bool,
}

impl Ending {
    pub fn new(limits: &RunLimits) -> Self {
        Self { until: limits.until, why: None, deadline: None, has_given_up: false }
    }

    /// Whether no sample is assigned any more.
    pub fn has_begun(&self) -> bool {
        self.deadline.is_some()
    }
}
