//! Counts of a running study: number of finished samples by result.

use bladeoff_model::outcome::{Cause, Outcome, Status};
use std::collections::BTreeMap;

/// Finished samples by status and cause.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    counts: BTreeMap<(Status, Option<Cause>), u64>,
}

impl Tally {
    /// Counts a finished sample.
    pub fn add(&mut self, outcome: &Outcome) {
        self.count(outcome.status, outcome.cause);
    }

    /// Counts a sample of which only status and cause are known.
    pub fn count(&mut self, status: Status, cause: Option<Cause>) {
        *self.counts.entry((status, cause)).or_default() += 1;
    }

    /// Finished samples.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.counts.values().sum()
    }

    /// Finished samples of this status.
    #[must_use]
    pub fn of(&self, status: Status) -> u64 {
        self.counts.iter().filter(|((found, _), _)| *found == status).map(|(_, count)| count).sum()
    }

    /// Finished samples with this first cause.
    #[must_use]
    pub fn of_cause(&self, cause: Cause) -> u64 {
        self.counts.iter().filter(|((_, found), _)| *found == Some(cause)).map(|(_, count)| count).sum()
    }

    /// Failed and quarantined samples.
    #[must_use]
    pub fn failed(&self) -> u64 {
        self.of(Status::Failed) + self.of(Status::Quarantined)
    }

    /// Samples of this status with their causes: "3 (2 slip_reversal, 1 normal_work)"; "0" for none.
    #[must_use]
    pub fn words(&self, statuses: &[Status]) -> String {
        let mut causes: BTreeMap<Option<Cause>, u64> = BTreeMap::new();
        for ((status, cause), count) in &self.counts {
            if statuses.contains(status) {
                *causes.entry(*cause).or_default() += count;
            }
        }
        let total: u64 = causes.values().sum();
        if total == 0 {
            return "0".to_owned();
        }
        let named = causes.iter().filter_map(|(cause, count)| Some(format!("{count} {}", (*cause)?.word())));
        format!("{total} ({})", named.collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::outcome::{CauseSet, EndCause};

    #[test]
    fn causes_are_counted_within_their_status() {
        let outcome = |status, cause| Outcome {
            status,
            cause,
            causes: CauseSet::default(),
            notes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: Vec::new(),
        };
        let mut tally = Tally::default();
        tally.add(&outcome(Status::Ok, None));
        tally.add(&outcome(Status::Invalid, Some(Cause::SlipReversal)));
        tally.add(&outcome(Status::Invalid, Some(Cause::NormalWork)));
        tally.add(&outcome(Status::Invalid, Some(Cause::SlipReversal)));
        assert_eq!((tally.done(), tally.failed()), (4, 0));
        assert_eq!(tally.words(&[Status::Invalid]), "3 (1 normal_work, 2 slip_reversal)");
        assert_eq!(tally.words(&[Status::Failed, Status::Quarantined]), "0");
    }
}
