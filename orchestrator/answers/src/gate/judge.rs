//! Decision of a gate in each group, as verdict and sentence.

use super::look::{Deciding, FIRST_LOOK, MOST_POINTS, deciding, last_look};
use super::require::Gate;
use crate::ask::{counted, decided_by, percent, percent_given, prefix};
use crate::estimate::bad::Bad;
use crate::estimate::input::{DesignKind, Group, InputError, Study};
use crate::estimate::known::truths;
use crate::estimate::limits::{lower_limit, upper_limit};
use crate::estimate::proportion::{Tally, tallies};
use crate::estimate::undecided::Undecided;

/// Verdict of a gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The limit is met; exit code 0.
    Passed,
    /// More points are needed; exit code 5.
    Open,
    /// The limit is exceeded; exit code 4.
    Failed,
}

impl Verdict {
    /// Exit code of the command.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Passed => 0,
            Self::Failed => 4,
            Self::Open => 5,
        }
    }
}

/// Decision of a gate in one group.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The gate as written.
    pub gate: String,
    /// Values of the group on the crossed axes.
    pub group: Group,
    /// Verdict.
    pub verdict: Verdict,
    /// Points analysed, including events and bad runs.
    pub n: u64,
    /// Events with bad runs counted as harmless, and as harmful.
    pub events: (u64, u64),
    /// Bad runs.
    pub bad: u64,
    /// Runs beyond the model, included in `bad`.
    pub beyond: u64,
    /// Ok runs that leave the condition open.
    pub undecided: Undecided,
    /// One-sided limits at `level`: lower with bad runs harmless, upper with bad runs harmful.
    pub limits: (f64, f64),
    /// Largest probability that each limit is wrong.
    pub level: f64,
    /// Further points that would decide the gate at the present rates.
    pub more: Option<u64>,
    /// The decision as a sentence.
    pub sentence: String,
}

/// Reason why a gate cannot be judged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GateError {
    /// A design without exact limits.
    #[error("a gate needs independent points for its limits to be exact: `kind = \"monte-carlo\"`, not {0:?}")]
    Design(&'static str),
    /// Rows that do not fit the design, or a missing column.
    #[error(transparent)]
    Input(#[from] InputError),
}

impl Gate {
    /// Judges every group of a study that has been checked. An incomplete study is judged by its points up to the last interim analysis.
    ///
    /// # Errors
    /// The design has no exact limits, or a column is missing.
    pub fn judge(&self, study: &Study<'_>) -> Result<Vec<Decision>, GateError> {
        if study.design.kind != DesignKind::MonteCarlo {
            return Err(GateError::Design(study.design.kind.word()));
        }
        let (alpha, points) = ((1.0 - self.confidence) * study.design.share, study.points() as u64);
        let look = if study.design.complete { Some((points, alpha)) } else { last_look(points, alpha) };
        let one = |(at, group): (usize, &Group)| {
            let mut truths = truths(study, &self.condition, at)?;
            let (n, level) = look.unwrap_or((0, alpha));
            truths.truncate(n as usize);
            let tally = Tally::of_all(&tallies(&truths, 1, |_| 0));
            let bad = truths.bad();
            let undecided = truths.undecided();
            let present = (points, study.design.complete, alpha);
            let by = decided_by(study, &self.condition);
            Ok(self.decision(group.clone(), tally, (bad, undecided, by), level, present))
        };
        study.groups.iter().enumerate().map(one).collect()
    }

    fn decision(
        &self,
        group: Group,
        tally: Tally,
        (bad, undecided, by): (Bad, Undecided, &str),
        level: f64,
        present: (u64, bool, f64),
    ) -> Decision {
        let Tally { n, low, high } = tally;
        let limits = if n == 0 { (0.0, 1.0) } else { (lower_limit(low, n, level), upper_limit(high, n, level)) };
        let verdict = if n > 0 && limits.1 < self.bound {
            Verdict::Passed
        } else if n > 0 && limits.0 >= self.bound {
            Verdict::Failed
        } else {
            Verdict::Open
        };
        let mut decision = Decision {
            gate: self.text.clone(),
            group,
            verdict,
            n,
            events: (low, high),
            bad: bad.all,
            beyond: bad.beyond,
            undecided,
            limits,
            level,
            more: None,
            sentence: String::new(),
        };
        decision.sentence = self.words(&mut decision, (&bad, by), present);
        decision
    }

    /// Sentence of a decision; also determines how many further points would decide.
    fn words(
        &self,
        decision: &mut Decision,
        (bad, by): (&Bad, &str),
        (points, complete, alpha): (u64, bool, f64),
    ) -> String {
        let (n, (low, high)) = (decision.n, decision.events);
        let mut text = format!("{}{}: ", prefix(&decision.group), self.text);
        if n == 0 {
            return text
                + &format!(
                    "open, the first interim analysis is at {FIRST_LOOK} points, or when the study is complete"
                );
        }
        let (sure, bound) = (percent(1.0 - decision.level), percent_given(self.bound));
        text += &match decision.verdict {
            Verdict::Passed => format!("passed, at most {} ({sure})", percent(decision.limits.1)),
            Verdict::Failed => format!("failed, at least {} ({sure})", percent(decision.limits.0)),
            Verdict::Open => {
                format!(
                    "open, {} to {} (one-sided {sure} limits)",
                    percent(decision.limits.0),
                    percent(decision.limits.1)
                )
            }
        };
        text += &format!(", {low} of {n}");
        let open = bad.open();
        let of_open = match (open.failing(), open.beyond) {
            (0, 0) => "",
            (_, 0) => "bad runs",
            (0, _) => "runs beyond the model",
            _ => "bad runs and runs beyond the model",
        };
        if high > low {
            let kinds = [of_open.to_owned(), decision.undecided.words()];
            let open = kinds.into_iter().filter(|kind| !kind.is_empty()).collect::<Vec<_>>().join(" and ");
            text += &format!(", {high} if {open} are harmful");
        } else if decision.bad > 0 {
            text += &format!(", {} {by}", bad.words());
        }
        if decision.verdict == Verdict::Open {
            let share = |events: u64| events as f64 / n as f64;
            let needed = deciding((share(low), share(high)), self.bound, points, alpha, !complete);
            text += &match needed {
                Deciding::At(needed) => {
                    decision.more = Some(needed - points);
                    format!("; at this rate {} more would decide", counted(needed - points, "point"))
                }
                Deciding::Beyond => {
                    format!("; at this rate more points would be needed than a study may have ({MOST_POINTS})")
                }
                Deciding::Never if high > low && share(low) < self.bound && share(high) >= self.bound => {
                    let undecided = decision.undecided.words();
                    let which = if of_open.is_empty() { &undecided } else { of_open };
                    format!(
                        "; the {which} prevent a decision, not the number of points: with them the rate is on both sides of {bound}"
                    )
                }
                Deciding::Never => "; the rate is at the bound, and no number of points decides".to_owned(),
            };
        }
        text
    }
}

/// Verdict of several decisions: failed before open before passed.
#[must_use]
pub fn verdict(decisions: &[Decision]) -> Verdict {
    decisions.iter().map(|decision| decision.verdict).max().unwrap_or(Verdict::Open)
}
