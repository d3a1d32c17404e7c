//! Messages of a worker to the orchestrator. Every message is a request that gets one answer.

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};

use super::block::{Block, HEADER, Header, MessageError, Reader, Writer, at_most, high, low};
use super::{BatchId, MAX_REPORTS, MAX_VALUES, RunId, WorkerId};

const MAGIC: u64 = u64::from_le_bytes(*b"bladFRwk");
const KIND_HELLO: u32 = 1;
const KIND_REPORT: u32 = 2;
const FLAG_ASKS: u64 = 1;
/// Words of a report before the presence bits: sample, codes, causes and value count, notes, cpu.
const REPORT_WORDS: usize = 5;
/// Words for reports in one block: 4 of the largest reports, or about 25 of usual size.
const ITEM_WORDS: usize = 4 * words(MAX_VALUES);

/// Words of a report with this many values: head, one presence bit per value, values.
const fn words(n_values: usize) -> usize {
    REPORT_WORDS + n_values.div_ceil(64) + n_values
}

/// A block that carries a [`FromWorker`].
pub type FromWorkerBlock = Block<{ HEADER + ITEM_WORDS + 1 }>;

/// A message from a worker.
#[derive(Debug, Clone, PartialEq)]
pub struct FromWorker {
    /// Sender; the orchestrator checks that the message came by this worker's connection.
    pub worker: WorkerId,
    /// Content.
    pub body: Body,
}

/// Content of a message from a worker.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// First message after connecting.
    Hello(Hello),
    /// Results of a batch, or none; with `asks`, the message also requests work.
    Report(Report),
}

/// Identity of a worker process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hello {
    /// Process id.
    pub pid: u32,
    /// Identity of its program file, see `bladeoff_worker::process::build_id`.
    pub build: u64,
}

/// Finished samples of a batch, sent while the batch is in progress.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Batch and attempt the results belong to; `None` for a request without results.
    pub batch: Option<(BatchId, u32)>,
    /// Finished samples.
    pub samples: Vec<SampleReport>,
    /// Whether the batch is over: the answer is the next batch.
    pub asks: bool,
}

/// One finished sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleReport {
    /// Sample number.
    pub sample: u64,
    /// CPU time of the solve \[s\].
    pub cpu_s: f64,
    /// The result.
    pub outcome: Outcome,
}

impl Report {
    /// Whether another report with this many values still fits the same message.
    #[must_use]
    pub fn has_room(&self, n_values: usize) -> bool {
        let used: usize = self.samples.iter().map(|sample| words(sample.outcome.values.len())).sum();
        self.samples.len() < MAX_REPORTS && used + words(n_values) <= ITEM_WORDS
    }
}

impl FromWorker {
    /// Encodes the message.
    ///
    /// # Errors
    /// Results that exceed the limits of [`super`] or contradict each other, which [`FromWorker::decode`] would reject.
    pub fn encode(&self, run: RunId, block: &mut FromWorkerBlock) -> Result<(), MessageError> {
        let header = |kind| Header { run, kind, worker: self.worker.0, batch: 0, attempt: 0, items: 0, extra: 0 };
        match &self.body {
            Body::Hello(hello) => {
                let mut writer = Writer::new(block, MAGIC, header(KIND_HELLO));
                writer.push(u64::from(hello.pid));
                writer.push(hello.build);
                writer.finish();
            }
            Body::Report(report) => {
                at_most("number of reports", report.samples.len() as u64, MAX_REPORTS as u64)?;
                let used: usize = report.samples.iter().map(|s| words(s.outcome.values.len())).sum();
                at_most("words of all reports", used as u64, ITEM_WORDS as u64)?;
                report.samples.iter().try_for_each(check)?;
                let (batch, attempt) = report.batch.unwrap_or((BatchId(0), 0));
                check_batch(report.batch, report.samples.len())?;
                let header = Header {
                    batch: batch.0,
                    attempt,
                    items: report.samples.len() as u32,
                    extra: if report.asks { FLAG_ASKS } else { 0 },
                    ..header(KIND_REPORT)
                };
                let mut writer = Writer::new(block, MAGIC, header);
                report.samples.iter().for_each(|sample| write(sample, &mut writer));
                writer.finish();
            }
        }
        Ok(())
    }

    /// Decodes and checks a message of this run.
    ///
    /// # Errors
    /// The block is not a valid message; see [`MessageError`].
    pub fn decode(block: &FromWorkerBlock, run: RunId) -> Result<Self, MessageError> {
        let (mut reader, header) = Reader::new(block, MAGIC, run)?;
        let body = match header.kind {
            KIND_HELLO => {
                let pid = at_most("process id", reader.word()?, u64::from(u32::MAX))? as u32;
                Body::Hello(Hello { pid, build: reader.word()? })
            }
            KIND_REPORT => {
                at_most("flags", header.extra, FLAG_ASKS)?;
                let n = at_most("number of reports", u64::from(header.items), MAX_REPORTS as u64)? as usize;
                let batch = match (header.batch, header.attempt) {
                    (0, 0) => None,
                    (batch, attempt) => Some((BatchId(batch), attempt)),
                };
                check_batch(batch, n)?;
                let samples = (0..n).map(|_| read(&mut reader)).collect::<Result<_, _>>()?;
                Body::Report(Report { batch, samples, asks: header.extra & FLAG_ASKS != 0 })
            }
            kind => return Err(MessageError::Tag { field: "kind", found: u64::from(kind) }),
        };
        reader.finish()?;
        Ok(Self { worker: WorkerId(header.worker), body })
    }
}

fn write<const N: usize>(report: &SampleReport, writer: &mut Writer<'_, N>) {
    let outcome = &report.outcome;
    let cause = outcome.cause.map_or(0, |cause| u64::from(cause.code()) + 1);
    writer.push(report.sample);
    writer.push(u64::from(outcome.status.code()) | cause << 8 | u64::from(outcome.end_cause.code()) << 16);
    writer.push(u64::from(outcome.causes.bits()) | (outcome.values.len() as u64) << 32);
    writer.push(u64::from(outcome.notes.bits()));
    writer.push(report.cpu_s.to_bits());
    let mut presence = vec![0_u64; outcome.values.len().div_ceil(64)];
    for (index, _) in outcome.values.iter().enumerate().filter(|(_, value)| value.is_some()) {
        presence[index / 64] |= 1 << (index % 64);
    }
    presence.into_iter().for_each(|word| writer.push(word));
    outcome.values.iter().for_each(|value| writer.push(value.unwrap_or(0.0).to_bits()));
}

fn read(reader: &mut Reader<'_>) -> Result<SampleReport, MessageError> {
    let sample = reader.word()?;
    let codes = reader.word()?;
    at_most("codes", codes, 0x00ff_ffff)?;
    let code = |shift: u32| (codes >> shift) as u8;
    let unknown = |field, found: u8| MessageError::Tag { field, found: u64::from(found) };
    let status = Status::from_code(code(0)).ok_or(unknown("status", code(0)))?;
    let cause = match code(8) {
        0 => None,
        found => Some(Cause::from_code(found - 1).ok_or(unknown("cause", found))?),
    };
    let end_cause = EndCause::from_code(code(16)).ok_or(unknown("end cause", code(16)))?;
    let word = reader.word()?;
    let causes = CauseSet::from_bits(low(word)).ok_or(MessageError::Tag { field: "causes", found: word })?;
    let n_values = at_most("number of values", u64::from(high(word)), MAX_VALUES as u64)? as usize;
    let word = reader.word()?;
    let notes = u32::try_from(word).ok().and_then(CauseSet::from_bits);
    let notes = notes.ok_or(MessageError::Tag { field: "notes", found: word })?;
    let cpu_s = f64::from_bits(reader.word()?);
    let presence = (0..n_values.div_ceil(64)).map(|_| reader.word()).collect::<Result<Vec<u64>, _>>()?;
    let is_present = |index: usize| presence[index / 64] >> (index % 64) & 1 == 1;
    if (n_values..64 * presence.len()).any(is_present) {
        return Err(MessageError::Contradiction { what: "presence of a value beyond the last" });
    }
    let mut values = Vec::with_capacity(n_values);
    for index in 0..n_values {
        let bits = reader.word()?;
        if !is_present(index) && bits != 0 {
            return Err(MessageError::Contradiction { what: "an absent value that is not zero" });
        }
        values.push(is_present(index).then_some(f64::from_bits(bits)));
    }
    let report = SampleReport { sample, cpu_s, outcome: Outcome { status, cause, causes, notes, end_cause, values } };
    check(&report)?;
    Ok(report)
}

/// Rules for a result, checked on both sides.
fn check(report: &SampleReport) -> Result<(), MessageError> {
    let outcome = &report.outcome;
    at_most("number of values", outcome.values.len() as u64, MAX_VALUES as u64)?;
    if !report.cpu_s.is_finite() || report.cpu_s < 0.0 {
        return Err(MessageError::Contradiction { what: "CPU time that is not a positive number" });
    }
    if let Some(index) = outcome.values.iter().position(|value| value.is_some_and(|value| !value.is_finite())) {
        return Err(MessageError::NotFinite { sample: report.sample, index });
    }
    if outcome.status == Status::Quarantined {
        return Err(MessageError::Contradiction { what: "a worker cannot quarantine a sample" });
    }
    if (outcome.status == Status::Ok) != outcome.cause.is_none() {
        return Err(MessageError::Contradiction { what: "a cause exactly when the status is not ok" });
    }
    let first_is_in_set = outcome.cause.map_or(outcome.causes == CauseSet::default(), |c| outcome.causes.contains(c));
    if !first_is_in_set {
        return Err(MessageError::Contradiction { what: "the cause must be one of the causes" });
    }
    Ok(())
}

fn check_batch(batch: Option<(BatchId, u32)>, n: usize) -> Result<(), MessageError> {
    match batch {
        Some((BatchId(0), _) | (_, 0)) => Err(MessageError::Contradiction { what: "batch or attempt number 0" }),
        None if n > 0 => Err(MessageError::Contradiction { what: "results without a batch" }),
        _ => Ok(()),
    }
}
