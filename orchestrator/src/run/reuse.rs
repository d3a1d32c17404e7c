//! Whether a finished sample equals the result of a new computation.
//!
//! Equal keys mean runs that are step for step the same but for `run.step_limit`, a budget that cuts them off:
//!
//! ```text
//! failed by the limit, after n steps   the same under the limit n; a larger limit or none continues the run
//! ended after n steps                  the same under every limit from n on
//! failed otherwise in step n + 1       the same under every limit from n + 1 on
//! ```
//! (`engine::Run::step` checks the limit before a step; the column `steps` counts whole ones.) A larger limit is a longer budget:
//! samples that it does not affect are taken over, and samples that the old limit ended are computed again. Under a smaller limit
//! a sample that needs more steps is another sample; a run that would lose it is rejected.

use bladeoff_model::outcome::{Cause, Status};
use bladeoff_record::Head;

/// Value of an entry for a sample of the same key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Worth {
    /// Equal to a new computation of the sample.
    Same,
    /// Less than a new computation: the sample is computed again.
    Superseded,
    /// More than a new computation.
    Other,
}

/// Compares an entry, whose `count` is its column `steps`, with a sample of this step limit. `is_its_own`: the entry was computed
/// for this sample.
pub(super) fn worth(entry: &Head, limit: Option<u64>, is_its_own: bool) -> Worth {
    // Its end does not depend on the steps; it is repeated only on request.
    if is_its_own || entry.status == Status::Quarantined {
        return Worth::Same;
    }
    match (limit, entry.count) {
        (Some(limit), Some(steps)) if entry.cause == Some(Cause::StepLimit) => match limit.cmp(&steps) {
            std::cmp::Ordering::Less => Worth::Other,
            std::cmp::Ordering::Equal => Worth::Same,
            std::cmp::Ordering::Greater => Worth::Superseded,
        },
        (None, _) if entry.cause == Some(Cause::StepLimit) => Worth::Superseded,
        (None, _) => Worth::Same,
        (Some(limit), Some(steps)) => {
            let needed = steps + u64::from(entry.status == Status::Failed);
            if needed <= limit { Worth::Same } else { Worth::Other }
        }
        // A panic left no values: its step is unknown, and there is no result to lose.
        (Some(_), None) => Worth::Superseded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_study::SampleKey;

    #[test]
    fn an_entry_is_worth_what_the_limit_leaves_of_it() {
        let entry = |status, cause, count| Head { key: SampleKey(1), status, cause, count };
        let ended = entry(Status::Ok, None, Some(100));
        let diverged = entry(Status::Failed, Some(Cause::Diverged), Some(100));
        let cut = entry(Status::Failed, Some(Cause::StepLimit), Some(100));
        let panicked = entry(Status::Failed, Some(Cause::Panicked), None);
        let killed = entry(Status::Quarantined, Some(Cause::WorkerKilled), None);
        use Worth::{Other, Same, Superseded};
        for (entry, under) in [
            (ended, [Other, Same, Same, Same]),
            (diverged, [Other, Other, Same, Same]),
            (cut, [Other, Same, Superseded, Superseded]),
            (panicked, [Superseded, Superseded, Superseded, Same]),
            (killed, [Same; 4]),
        ] {
            let limits = [Some(99), Some(100), Some(101), None];
            assert_eq!(limits.map(|limit| worth(&entry, limit, false)), under, "{entry:?}");
            assert_eq!(worth(&entry, Some(100), true), Same);
        }
    }
}
