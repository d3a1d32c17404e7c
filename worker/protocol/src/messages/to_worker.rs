//! Messages of the orchestrator to a worker.

use super::block::{Block, HEADER, Header, MessageError, Reader, Writer, at_most};
use super::{BatchId, MAX_BATCH, MAX_BATCH_VALUES, MAX_PARAMS, RunId, WorkerId};

const MAGIC: u64 = u64::from_le_bytes(*b"bladTOwk");
const KIND_BATCH: u32 = 1;
const KIND_CONTINUE: u32 = 2;
const KIND_STOP: u32 = 3;
const KIND_LEAVE: u32 = 4;

/// A block that carries a [`ToWorker`].
pub type ToWorkerBlock = Block<{ HEADER + MAX_BATCH + MAX_BATCH_VALUES + 1 }>;

/// Samples to compute, in this order.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Number of the batch, which its results repeat.
    pub batch: BatchId,
    /// Number of the attempt at these samples, from 1.
    pub attempt: u32,
    /// Parameters per sample.
    pub n_params: usize,
    /// Sample numbers, at least one.
    pub samples: Vec<u64>,
    /// Parameter values, sample by sample: finite, or NaN if the sample has no value (a formula gave none).
    pub params: Vec<f64>,
}

impl Batch {
    /// The samples with their parameters.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &[f64])> {
        let n = self.n_params;
        self.samples.iter().enumerate().map(move |(i, &sample)| (sample, &self.params[i * n..(i + 1) * n]))
    }
}

/// An answer to a worker's request.
#[derive(Debug, Clone, PartialEq)]
pub enum ToWorker {
    /// Compute these samples.
    Batch(Batch),
    /// Report received: continue with the batch, or ask for one if the batch is done.
    Continue,
    /// Report received: other workers compute the rest of the batch; ask for the next one.
    Leave,
    /// The run is over for this worker; no further message is expected.
    Stop,
}

impl ToWorker {
    /// Encodes the message.
    ///
    /// # Errors
    /// A batch that exceeds the limits of [`super`], or has an infinite value.
    pub fn encode(&self, run: RunId, worker: WorkerId, block: &mut ToWorkerBlock) -> Result<(), MessageError> {
        let header = |kind| Header { run, kind, worker: worker.0, batch: 0, attempt: 0, items: 0, extra: 0 };
        match self {
            ToWorker::Batch(batch) => {
                check(batch)?;
                let header = Header {
                    batch: batch.batch.0,
                    attempt: batch.attempt,
                    items: batch.samples.len() as u32,
                    extra: batch.n_params as u64,
                    ..header(KIND_BATCH)
                };
                let mut writer = Writer::new(block, MAGIC, header);
                batch.samples.iter().for_each(|&sample| writer.push(sample));
                batch.params.iter().for_each(|value| writer.push(value.to_bits()));
                writer.finish();
            }
            ToWorker::Continue => Writer::new(block, MAGIC, header(KIND_CONTINUE)).finish(),
            ToWorker::Leave => Writer::new(block, MAGIC, header(KIND_LEAVE)).finish(),
            ToWorker::Stop => Writer::new(block, MAGIC, header(KIND_STOP)).finish(),
        }
        Ok(())
    }

    /// Decodes and checks a message, which must be for this worker of this run.
    ///
    /// # Errors
    /// The block is not a valid message; see [`MessageError`].
    pub fn decode(block: &ToWorkerBlock, run: RunId, worker: WorkerId) -> Result<Self, MessageError> {
        let (mut reader, header) = Reader::new(block, MAGIC, run)?;
        if header.worker != worker.0 {
            return Err(MessageError::Contradiction { what: "message is for another worker" });
        }
        let message = match header.kind {
            KIND_BATCH => {
                let n_samples = at_most("number of samples", u64::from(header.items), MAX_BATCH as u64)? as usize;
                let n_params = at_most("parameters per sample", header.extra, MAX_PARAMS as u64)? as usize;
                at_most("number of values", (n_samples * n_params) as u64, MAX_BATCH_VALUES as u64)?;
                let samples = (0..n_samples).map(|_| reader.word()).collect::<Result<_, _>>()?;
                let params =
                    (0..n_samples * n_params).map(|_| reader.word().map(f64::from_bits)).collect::<Result<_, _>>()?;
                let batch = Batch { batch: BatchId(header.batch), attempt: header.attempt, n_params, samples, params };
                check(&batch)?;
                ToWorker::Batch(batch)
            }
            KIND_CONTINUE => ToWorker::Continue,
            KIND_LEAVE => ToWorker::Leave,
            KIND_STOP => ToWorker::Stop,
            kind => return Err(MessageError::Tag { field: "kind", found: u64::from(kind) }),
        };
        reader.finish()?;
        Ok(message)
    }
}

/// Rules for a batch, checked on both sides.
fn check(batch: &Batch) -> Result<(), MessageError> {
    at_most("number of samples", batch.samples.len() as u64, MAX_BATCH as u64)?;
    at_most("parameters per sample", batch.n_params as u64, MAX_PARAMS as u64)?;
    at_most("number of values", batch.params.len() as u64, MAX_BATCH_VALUES as u64)?;
    if batch.samples.is_empty() {
        return Err(MessageError::Contradiction { what: "batch without samples" });
    }
    if batch.batch.0 == 0 || batch.attempt == 0 {
        return Err(MessageError::Contradiction { what: "batch or attempt number 0" });
    }
    if batch.params.len() != batch.samples.len() * batch.n_params {
        return Err(MessageError::Contradiction { what: "number of values is not samples x parameters" });
    }
    match batch.params.iter().position(|value| value.is_infinite()) {
        None => Ok(()),
        Some(at) => {
            Err(MessageError::NotFinite { sample: batch.samples[at / batch.n_params], index: at % batch.n_params })
        }
    }
}
