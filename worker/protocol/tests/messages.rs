//! Messages go there and back exactly; anything else is refused, never believed and never a panic.

use bladeoff_core::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::messages::{
    Batch, BatchId, Block, Body, FromWorker, FromWorkerBlock, Hello, MAX_BATCH, MAX_PARAMS, MAX_VALUES, MessageError,
    Report, RunId, SampleReport, ToWorker, ToWorkerBlock, WorkerId, batch_capacity,
};
use proptest::prelude::*;

const RUN: RunId = RunId(0xb1ade0ff);
const WORKER: WorkerId = WorkerId(7);

fn finite() -> impl Strategy<Value = f64> {
    any::<f64>().prop_map(|value| if value.is_finite() { value } else { -0.0 })
}

fn batches() -> impl Strategy<Value = ToWorker> {
    (0..=MAX_PARAMS, 1..u64::MAX, 1..u32::MAX).prop_flat_map(|(n_params, batch, attempt)| {
        let samples = prop::collection::vec(any::<u64>(), 1..=batch_capacity(n_params));
        samples.prop_flat_map(move |samples| {
            let n = samples.len() * n_params;
            (Just(samples), prop::collection::vec(finite(), n)).prop_map(move |(samples, params)| {
                ToWorker::Batch(Batch { batch: BatchId(batch), attempt, n_params, samples, params })
            })
        })
    })
}

fn to_worker() -> impl Strategy<Value = ToWorker> {
    prop_oneof![4 => batches(), 1 => Just(ToWorker::Continue), 1 => Just(ToWorker::Stop)]
}

fn outcomes() -> impl Strategy<Value = Outcome> {
    let causes = prop::collection::vec(0..Cause::ALL.len(), 0..4);
    let values = prop::collection::vec(prop::option::of(finite()), 0..=MAX_VALUES);
    (causes, values, any::<bool>(), 0..EndCause::ALL.len()).prop_map(|(all, values, failed, end)| {
        let mut causes = CauseSet::default();
        all.iter().for_each(|&code| causes.insert(Cause::ALL[code]));
        let cause = all.first().map(|&code| Cause::ALL[code]);
        let status = match (cause, failed) {
            (None, _) => Status::Ok,
            (_, true) => Status::Failed,
            (_, false) => Status::Invalid,
        };
        Outcome { status, cause, causes, end_cause: EndCause::ALL[end], values }
    })
}

fn from_worker() -> impl Strategy<Value = FromWorker> {
    let samples = (any::<u64>(), 0.0..1e6, outcomes()).prop_map(|(sample, cpu_s, outcome)| SampleReport {
        sample,
        cpu_s,
        outcome,
    });
    let reports = (prop::collection::vec(samples, 0..=16), any::<bool>(), 1..u64::MAX, 1..u32::MAX).prop_map(
        |(samples, asks, batch, attempt)| {
            Body::Report(Report { batch: Some((BatchId(batch), attempt)), samples, asks })
        },
    );
    let hello = (any::<u32>(), any::<u64>()).prop_map(|(pid, build)| Body::Hello(Hello { pid, build }));
    let ask = Just(Body::Report(Report { batch: None, samples: Vec::new(), asks: true }));
    let body = prop_oneof![1 => hello, 1 => ask, 6 => reports];
    body.prop_map(|body| FromWorker { worker: WORKER, body })
}

fn encoded_to(message: &ToWorker) -> Box<ToWorkerBlock> {
    let mut block = ToWorkerBlock::empty();
    message.encode(RUN, WORKER, &mut block).expect("within the limits");
    block
}

fn encoded_from(message: &FromWorker) -> Box<FromWorkerBlock> {
    let mut block = FromWorkerBlock::empty();
    message.encode(RUN, &mut block).expect("within the limits");
    block
}

fn flipped<const N: usize>(block: &Block<N>, bits: &[usize]) -> Box<Block<N>> {
    let mut changed = Box::new(*block);
    for bit in bits {
        let at = bit % (block.used() * 64);
        changed.words[at / 64] ^= 1 << (at % 64);
    }
    changed
}

/// Fills a block with noise that starts like a message, so that the checks behind the first are reached too.
fn noise<const N: usize>(start: &Block<N>, words: &[u64], keep: usize) -> Box<Block<N>> {
    let mut block = Box::new(*start);
    for (at, word) in words.iter().enumerate() {
        if at >= keep {
            block.words[at % N] = *word;
        }
    }
    block
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn messages_go_there_and_back(to in to_worker(), from in from_worker()) {
        prop_assert_eq!(ToWorker::decode(&encoded_to(&to), RUN, WORKER), Ok(to));
        prop_assert_eq!(FromWorker::decode(&encoded_from(&from), RUN), Ok(from));
    }

    #[test]
    fn every_flipped_bit_is_seen(to in to_worker(), from in from_worker(), bits in prop::collection::vec(any::<usize>(), 1..4)) {
        let (to_block, from_block) = (encoded_to(&to), encoded_from(&from));
        // Within what was in use before: words behind it mean nothing, and two flips of one bit are none.
        let changed = flipped(&to_block, &bits);
        if changed != to_block {
            prop_assert!(ToWorker::decode(&changed, RUN, WORKER).is_err());
        }
        let changed = flipped(&from_block, &bits);
        if changed != from_block {
            prop_assert!(FromWorker::decode(&changed, RUN).is_err());
        }
    }

    #[test]
    fn noise_is_never_believed(
        to in to_worker(),
        from in from_worker(),
        words in prop::collection::vec(prop_oneof![any::<u64>(), 0..600_u64], 0..700),
        keep in 0..9_usize,
    ) {
        let (to_block, from_block) = (encoded_to(&to), encoded_from(&from));
        let changed = noise(&to_block, &words, keep);
        if changed.words[..to_block.used()] != to_block.words[..to_block.used()] {
            prop_assert!(ToWorker::decode(&changed, RUN, WORKER).is_err());
        }
        let changed = noise(&from_block, &words, keep);
        if changed.words[..from_block.used()] != from_block.words[..from_block.used()] {
            prop_assert!(FromWorker::decode(&changed, RUN).is_err());
        }
    }

    /// A hostile worker can compute the checksum. What it says is refused, or obeys every rule a message must keep.
    #[test]
    fn noise_with_a_valid_checksum_breaks_no_rule(
        from in from_worker(),
        changes in prop::collection::vec((3..64_usize, prop_oneof![any::<u64>(), 0..600_u64, Just(f64::NAN.to_bits())]), 1..6),
    ) {
        let mut block = encoded_from(&from);
        for (at, word) in changes {
            block.words[at] = word;
        }
        let used = block.used().max(9);
        block.words[4] = used as u64;
        block.words[used - 1] = checksum(&block.words[..used - 1]);
        if let Ok(message) = FromWorker::decode(&block, RUN) {
            let mut again = FromWorkerBlock::empty();
            prop_assert!(message.encode(RUN, &mut again).is_ok());
            if let Body::Report(report) = message.body {
                for done in report.samples {
                    prop_assert!(done.outcome.values.iter().flatten().all(|value| value.is_finite()));
                    prop_assert_eq!(done.outcome.status == Status::Ok, done.outcome.cause.is_none());
                    prop_assert!(done.outcome.values.len() <= MAX_VALUES && done.outcome.status != Status::Quarantined);
                }
            }
        }
    }
}

/// Cases per property: more with `PROPTEST_CASES`.
fn cases() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(500)
}

/// The checksum as documented: one bijective step per word and a finish. Written here again, as a hostile peer would.
fn checksum(words: &[u64]) -> u64 {
    let mut state: u64 = 0x9e37_79b9_7f4a_7c15;
    for word in words {
        state = (state ^ word).wrapping_mul(0xd6e8_feb8_6659_fd93).rotate_left(29);
    }
    for factor in [0xff51_afd7_ed55_8ccd, 0xc4ce_b9fe_1a85_ec53] {
        state = (state ^ (state >> 33)).wrapping_mul(factor);
    }
    state ^ (state >> 33)
}

fn report(outcome: Outcome) -> FromWorker {
    let samples = vec![SampleReport { sample: 3, cpu_s: 0.5, outcome }];
    FromWorker { worker: WORKER, body: Body::Report(Report { batch: Some((BatchId(1), 1)), samples, asks: true }) }
}

fn good() -> Outcome {
    let (status, causes) = (Status::Ok, CauseSet::default());
    Outcome { status, cause: None, causes, end_cause: EndCause::EndTime, values: vec![Some(1.5), None, Some(-0.0)] }
}

#[test]
fn the_writer_refuses_what_the_reader_would() {
    let mut block = FromWorkerBlock::empty();
    let mut refusal = |outcome| report(outcome).encode(RUN, &mut block).expect_err("against the rules");
    assert_eq!(
        refusal(Outcome { values: vec![None, Some(f64::NAN)], ..good() }),
        MessageError::NotFinite { sample: 3, index: 1 }
    );
    assert!(matches!(refusal(Outcome { values: vec![None; MAX_VALUES + 1], ..good() }), MessageError::Range { .. }));
    assert!(matches!(refusal(Outcome { status: Status::Failed, ..good() }), MessageError::Contradiction { .. }));
    assert!(matches!(refusal(Outcome { cause: Some(Cause::Diverged), ..good() }), MessageError::Contradiction { .. }));
    let mut block = ToWorkerBlock::empty();
    let batch = |samples: Vec<u64>, n_params, params| {
        ToWorker::Batch(Batch { batch: BatchId(1), attempt: 1, n_params, samples, params })
    };
    let mut refusal = |message: ToWorker| message.encode(RUN, WORKER, &mut block).expect_err("against the rules");
    assert!(matches!(refusal(batch(vec![], 0, vec![])), MessageError::Contradiction { .. }));
    assert!(matches!(refusal(batch(vec![0; MAX_BATCH + 1], 0, vec![])), MessageError::Range { .. }));
    assert!(matches!(refusal(batch(vec![1, 2], 1, vec![0.0])), MessageError::Contradiction { .. }));
    let infinite = batch(vec![1, 2], 1, vec![0.0, f64::INFINITY]);
    assert_eq!(refusal(infinite), MessageError::NotFinite { sample: 2, index: 0 });
}

#[test]
fn a_message_for_another_run_worker_or_version_is_refused_by_name() {
    let block = encoded_from(&report(good()));
    let other = RunId(1);
    assert_eq!(FromWorker::decode(&block, other), Err(MessageError::Run { found: RUN.0, expected: other }));
    let stop = encoded_to(&ToWorker::Stop);
    assert!(ToWorker::decode(&stop, RUN, WorkerId(8)).is_err());
    let mut newer = block.clone();
    newer.words[1] = 2;
    assert_eq!(FromWorker::decode(&newer, RUN), Err(MessageError::Version { found: 2 }));
    assert!(matches!(FromWorker::decode(&FromWorkerBlock::empty(), RUN), Err(MessageError::Magic { found: 0, .. })));
    let mut long = block;
    long.words[4] = u64::MAX;
    assert!(matches!(FromWorker::decode(&long, RUN), Err(MessageError::Length { found: u64::MAX, .. })));
}

#[test]
fn absent_values_stay_absent_and_zero_keeps_its_sign() {
    let block = encoded_from(&report(good()));
    let Ok(FromWorker { body: Body::Report(report), .. }) = FromWorker::decode(&block, RUN) else { panic!("refused") };
    let values = &report.samples[0].outcome.values;
    assert_eq!(values[..2], [Some(1.5), None]);
    assert!(values[2].is_some_and(|zero| zero == 0.0 && zero.is_sign_negative()));
}

#[test]
fn a_report_knows_when_it_is_full() {
    let Body::Report(mut full) = report(good()).body else { panic!("a report") };
    full.samples.clear();
    while full.has_room(MAX_VALUES) {
        let outcome = Outcome { values: vec![Some(1.0); MAX_VALUES], ..good() };
        full.samples.push(SampleReport { sample: 0, cpu_s: 0.0, outcome });
    }
    assert_eq!(full.samples.len(), 16);
    let message = FromWorker { worker: WORKER, body: Body::Report(full) };
    assert_eq!(FromWorker::decode(&encoded_from(&message), RUN), Ok(message));
}
