//! Entries of the record made of accepted results.

use bladeoff_model::outcome::{CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::messages::SampleReport;

use crate::schedule::Effect;
use bladeoff_record::Entry;

/// Collects the accepted results of one message, which come from one worker, and the quarantined samples, in the order of the
/// effects.
pub(super) fn entries(effects: &[Effect], results: Vec<SampleReport>) -> Vec<(u64, Entry)> {
    let mut results: Vec<Option<SampleReport>> = results.into_iter().map(Some).collect();
    let record = |effect: &Effect| match effect {
        Effect::Record { index, attempt, worker } => {
            let SampleReport { sample, cpu_s, outcome } = results.get_mut(*index).and_then(Option::take)?;
            Some((sample, Entry { outcome, cpu_s, worker: worker.0, attempt: *attempt }))
        }
        Effect::Quarantine { sample, cause, worker, attempt } => {
            let mut causes = CauseSet::default();
            causes.insert(*cause);
            let (status, end_cause) = (Status::Quarantined, EndCause::Failure);
            let outcome = Outcome {
                status,
                cause: Some(*cause),
                causes,
                notes: CauseSet::default(),
                end_cause,
                values: Vec::new(),
            };
            Some((*sample, Entry { outcome, cpu_s: 0.0, worker: worker.0, attempt: *attempt }))
        }
        _ => None,
    };
    effects.iter().filter_map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::outcome::Cause;
    use bladeoff_protocol::messages::WorkerId;

    #[test]
    fn what_is_accepted_is_recorded_once_and_what_is_quarantined_has_no_values() {
        let outcome = Outcome {
            status: Status::Ok,
            cause: None,
            causes: CauseSet::default(),
            notes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: vec![Some(1.0)],
        };
        let report = |sample| SampleReport { sample, cpu_s: 0.5, outcome: outcome.clone() };
        let worker = WorkerId(3);
        let accept = |index| Effect::Record { index, attempt: 2, worker };
        let effects = [
            accept(1),
            Effect::Continue(worker),
            accept(1),
            Effect::Quarantine { sample: 9, cause: Cause::WorkerKilled, worker, attempt: 4 },
            accept(5),
        ];
        let found = entries(&effects, vec![report(7), report(8)]);
        let told = |(sample, entry): &(u64, Entry)| (*sample, entry.worker, entry.attempt);
        assert_eq!(found.iter().map(told).collect::<Vec<_>>(), [(8, 3, 2), (9, 3, 4)]);
        assert_eq!(found[0].1.outcome, outcome);
        let given_up = &found[1].1.outcome;
        assert_eq!((given_up.status, given_up.values.len()), (Status::Quarantined, 0));
    }
}
