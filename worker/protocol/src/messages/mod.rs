//! Messages: owned Rust types on either side, fixed-size blocks of words in between.
//!
//! ```text
//! word  0  magic, by direction                      word  5  batch number, 0 = none
//!       1  version of this format                         6  attempt | number of items << 32
//!       2  run                                            7  parameters per sample (to worker) | flags (from worker)
//!       3  kind | worker << 32                            8.. items
//!       4  words in use, header and checksum included     last word in use: checksum of all before
//! ```
//! A block holds integers and bit patterns of f64 only, so any content is a valid block and decoding is safe code. Decoding returns a
//! [`MessageError`] for content that it rejects. The checksum covers every word in use.

mod block;
mod from_worker;
mod to_worker;

pub use block::{Block, MessageError};
pub use from_worker::{Body, FromWorker, FromWorkerBlock, Hello, Report, SampleReport};
pub use to_worker::{Batch, ToWorker, ToWorkerBlock};

/// Version of the message format; a reader rejects any other.
pub const PROTOCOL_VERSION: u64 = 5;
/// Most samples in one batch.
pub const MAX_BATCH: usize = 256;
/// Most parameters of one sample.
pub const MAX_PARAMS: usize = 128;
/// Most parameter values in one batch, all samples together.
pub const MAX_BATCH_VALUES: usize = 4096;
/// Most result values of one sample.
pub const MAX_VALUES: usize = 2048;
/// Most sample reports in one message.
pub const MAX_REPORTS: usize = 256;

/// Number of samples in one batch when each sample has `n_params` parameters; at least 32.
#[must_use]
pub fn batch_capacity(n_params: usize) -> usize {
    MAX_BATCH_VALUES.checked_div(n_params).unwrap_or(MAX_BATCH).min(MAX_BATCH)
}

/// Random number of a run, which keeps messages of other runs from being accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RunId(pub u64);

/// Number of a worker process, counted over all processes that a run has started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WorkerId(pub u32);

/// Number of a batch within a run; 0 means no batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BatchId(pub u64);

impl std::fmt::Display for WorkerId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "w{}", self.0)
    }
}

impl std::fmt::Display for RunId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}
