//! Messages survive encoding and decoding exactly; any other block is rejected without a panic.

#[path = "../../../tests/support/cap.rs"]
mod cap;

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::messages::{
    Batch, BatchId, Block, Body, FromWorker, FromWorkerBlock, Hello, MAX_BATCH, MAX_PARAMS, MAX_VALUES, MessageError,
    PROTOCOL_VERSION, Report, RunId, SampleReport, ToWorker, ToWorkerBlock, WorkerId, batch_capacity,
};
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;

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
    prop_oneof![4 => batches(), 1 => Just(ToWorker::Continue), 1 => Just(ToWorker::Leave), 1 => Just(ToWorker::Stop)]
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
        Outcome { status, cause, causes, notes: CauseSet::default(), end_cause: EndCause::ALL[end], values }
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
            let mut report = Report { batch: Some((BatchId(batch), attempt)), samples: Vec::new(), asks };
            for sample in samples {
                if report.has_room(sample.outcome.values.len()) {
                    report.samples.push(sample);
                }
            }
            Body::Report(report)
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

/// Fills a block with noise after a valid start, so that the noise reaches the later checks too.
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
    #![proptest_config(config())]

    #[test]
    fn messages_go_there_and_back(to in to_worker(), from in from_worker()) {
        prop_assert_eq!(ToWorker::decode(&encoded_to(&to), RUN, WORKER), Ok(to));
        prop_assert_eq!(FromWorker::decode(&encoded_from(&from), RUN), Ok(from));
    }

    #[test]
    fn every_flipped_bit_is_seen(to in to_worker(), from in from_worker(), bits in prop::collection::vec(any::<usize>(), 1..4)) {
        let (to_block, from_block) = (encoded_to(&to), encoded_from(&from));
        // Changes only words that were in use: later words have no meaning, and flipping the same bit twice changes nothing.
        let changed = flipped(&to_block, &bits);
        if changed != to_block {
            prop_assert!(cap::case(MOST, || ToWorker::decode(&changed, RUN, WORKER)).is_err());
        }
        let changed = flipped(&from_block, &bits);
        if changed != from_block {
            prop_assert!(cap::case(MOST, || FromWorker::decode(&changed, RUN)).is_err());
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
            prop_assert!(cap::case(MOST, || ToWorker::decode(&changed, RUN, WORKER)).is_err());
        }
        let changed = noise(&from_block, &words, keep);
        if changed.words[..from_block.used()] != from_block.words[..from_block.used()] {
            prop_assert!(cap::case(MOST, || FromWorker::decode(&changed, RUN)).is_err());
        }
    }
}

/// A way to make a hostile message from a valid one, in addition to a right checksum.
#[derive(Debug, Clone)]
enum Lie {
    /// Replaces a word.
    Word(prop::sample::Index, u64),
    /// Flips one bit.
    Bit(prop::sample::Index, u32),
    /// Adds to a word, such as a count.
    Add(prop::sample::Index, u64),
    /// Claims another length.
    Length(prop::sample::Index),
}

fn lies() -> impl Strategy<Value = Vec<Lie>> {
    let index = any::<prop::sample::Index>;
    let word = prop_oneof![
        any::<u64>(),
        0..600_u64,
        Just(f64::NAN.to_bits()),
        Just(f64::NEG_INFINITY.to_bits()),
        Just(u64::MAX),
        (0..300_u64, 0..64_u64).prop_map(|(high, low)| high << 32 | low),
    ];
    let lie = prop_oneof![
        3 => (index(), word).prop_map(|(at, word)| Lie::Word(at, word)),
        4 => (index(), 0..64_u32).prop_map(|(at, bit)| Lie::Bit(at, bit)),
        2 => (index(), prop_oneof![Just(1), Just(u64::MAX), Just(1 << 32)]).prop_map(|(at, more)| Lie::Add(at, more)),
        1 => index().prop_map(Lie::Length),
    ];
    prop::collection::vec(lie, 1..4)
}

/// The message with these lies. Magic, version and run stay: a hostile worker knows them, and the other checks come after them.
fn lying<const N: usize>(good: &Block<N>, lies: &[Lie]) -> Box<Block<N>> {
    let mut block = Box::new(*good);
    let mut used = good.used();
    // Fields of the header are chosen as often as all items together, in which most words are values.
    let place = |at: &prop::sample::Index, used: usize| {
        let fields: Vec<usize> = [3, 5, 6, 7].into_iter().chain(8..20.min(used - 1)).collect();
        let at = at.index(2 * (used + fields.len()));
        if at.is_multiple_of(2) { fields[at / 2 % fields.len()] } else { 5 + at / 2 % (used - 6) }
    };
    for lie in lies {
        match lie {
            Lie::Word(at, word) => block.words[place(at, used)] = *word,
            Lie::Bit(at, bit) => block.words[place(at, used)] ^= 1 << bit,
            Lie::Add(at, more) => {
                let word = &mut block.words[place(at, used)];
                *word = word.wrapping_add(*more);
            }
            Lie::Length(at) => used = 9 + at.index(N - 8),
        }
    }
    block.words[4] = used as u64;
    block.words[used - 1] = checksum(&block.words[..used - 1]);
    block
}

/// Counts of hostile messages by their outcome.
#[derive(Debug, Default)]
struct Fates {
    cases: u64,
    /// Passed the checks of magic, version, length, checksum and run.
    past_checksum: u64,
    believed: u64,
    /// Rejected, by the check that failed.
    refused: BTreeMap<&'static str, u64>,
}

impl Fates {
    fn count<T>(&mut self, decoded: &Result<T, MessageError>) {
        self.cases += 1;
        let (why, is_past) = match decoded {
            Ok(_) => {
                self.believed += 1;
                self.past_checksum += 1;
                return;
            }
            Err(MessageError::Magic { .. } | MessageError::Version { .. } | MessageError::Run { .. }) => {
                ("envelope", false)
            }
            Err(MessageError::Checksum { .. }) => ("checksum", false),
            Err(MessageError::Length { most, .. }) => ("length", *most == usize::MAX),
            Err(MessageError::Tag { .. }) => ("tag", true),
            Err(MessageError::Range { .. }) => ("range", true),
            Err(MessageError::NotFinite { .. }) => ("not finite", true),
            Err(MessageError::Contradiction { .. }) => ("contradiction", true),
            Err(MessageError::LeftOver { .. }) => ("left over", true),
        };
        self.past_checksum += u64::from(is_past);
        *self.refused.entry(why).or_default() += 1;
    }

    #[expect(clippy::print_stdout, reason = "the figures of docs/durability.md")]
    /// At least 99 of 100 passed the checksum, and every check behind it rejected some.
    fn assert_thorough(&self, checks: &[&str]) {
        println!("{self:?}; {}", cap::figures());
        assert!(100 * self.past_checksum >= 99 * self.cases, "{self:?}");
        assert!(self.believed > 0 && self.believed < self.cases, "{self:?}");
        if self.cases < 500 {
            return;
        }
        checks.iter().for_each(|check| assert!(self.refused.contains_key(check), "{check}: {self:?}"));
    }
}

/// A hostile worker can compute the checksum. Its messages are rejected, or obey every rule of a message.
#[test]
fn a_lying_worker_with_a_right_checksum_breaks_no_rule() {
    let fates = RefCell::new(Fates::default());
    proptest!(config(), |(from in from_worker(), lies in lies())| {
        let block = lying(&encoded_from(&from), &lies);
        let decoded = cap::case(MOST, || FromWorker::decode(&block, RUN));
        fates.borrow_mut().count(&decoded);
        if let Ok(message) = decoded {
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
    });
    fates.borrow().assert_thorough(&["length", "tag", "range", "not finite", "contradiction", "left over"]);
}

/// A hostile orchestrator can compute the checksum, too. At most it can make a worker compute other samples.
#[test]
fn a_lying_orchestrator_with_a_right_checksum_breaks_no_rule() {
    let fates = RefCell::new(Fates::default());
    proptest!(config(), |(to in to_worker(), lies in lies())| {
        let block = lying(&encoded_to(&to), &lies);
        let decoded = cap::case(MOST, || ToWorker::decode(&block, RUN, WORKER));
        fates.borrow_mut().count(&decoded);
        if let Ok(message) = decoded {
            let mut again = ToWorkerBlock::empty();
            prop_assert!(message.encode(RUN, WORKER, &mut again).is_ok());
            if let ToWorker::Batch(batch) = message {
                prop_assert!(batch.n_params <= MAX_PARAMS && (1..=MAX_BATCH).contains(&batch.samples.len()));
                prop_assert_eq!(batch.params.len(), batch.samples.len() * batch.n_params);
                prop_assert!(!batch.params.iter().any(|value| value.is_infinite()));
            }
        }
    });
    fates.borrow().assert_thorough(&["length", "range", "not finite", "left over"]);
}

fn config() -> ProptestConfig {
    ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() }
}

/// Memory limit of one case \[bytes\]; a message has at most 34 kB.
const MOST: usize = 1 << 20;

/// Cases per property: more with `PROPTEST_CASES`.
fn cases() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(500)
}

/// The checksum as documented: one bijective step per word and a final one. Implemented independently, as a hostile peer would.
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
    Outcome {
        status,
        cause: None,
        causes,
        notes: CauseSet::default(),
        end_cause: EndCause::EndTime,
        values: vec![Some(1.5), None, Some(-0.0)],
    }
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
    // A missing value is transmitted as such.
    let message = batch(vec![1, 2], 1, vec![f64::NAN, 1.0]);
    message.encode(RUN, WORKER, &mut block).expect("a value that is none");
    let decoded = ToWorker::decode(&block, RUN, WORKER).expect("the same");
    assert!(matches!(decoded, ToWorker::Batch(batch) if batch.params[0].is_nan() && batch.params[1] == 1.0));
}

#[test]
fn a_message_for_another_run_worker_or_version_is_refused_by_name() {
    let block = encoded_from(&report(good()));
    let other = RunId(1);
    assert_eq!(FromWorker::decode(&block, other), Err(MessageError::Run { found: RUN.0, expected: other }));
    let stop = encoded_to(&ToWorker::Stop);
    assert!(ToWorker::decode(&stop, RUN, WorkerId(8)).is_err());
    let mut newer = block.clone();
    newer.words[1] += 1;
    assert_eq!(FromWorker::decode(&newer, RUN), Err(MessageError::Version { found: PROTOCOL_VERSION + 1 }));
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
    assert_eq!(full.samples.len(), 4);
    let message = FromWorker { worker: WORKER, body: Body::Report(full) };
    assert_eq!(FromWorker::decode(&encoded_from(&message), RUN), Ok(message));
}
