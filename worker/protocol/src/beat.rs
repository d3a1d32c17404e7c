//! Heartbeat of a worker: 32 bytes through its standard output, written in one piece by a thread of its own.
//!
//! Heartbeats use a pipe, not shared memory, so that monitoring does not depend on the memory that it monitors, and a closed pipe shows
//! that the process has ended. The batch and sample in progress serve time limits, displays and the redistribution of samples that wait
//! behind a long one.

use crate::messages::BatchId;

/// Bytes of one heartbeat: below `PIPE_BUF`, hence never interleaved or cut.
pub const BEAT_BYTES: usize = 32;
const MAGIC: u64 = u64::from_le_bytes(*b"bladBEAT");
const NO_SAMPLE: u64 = u64::MAX;

/// Batch and sample that a worker is computing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// Batch in progress; 0 while the worker waits for one.
    pub batch: BatchId,
    /// Sample in progress.
    pub sample: Option<u64>,
}

impl Beat {
    /// Encodes the heartbeat.
    #[must_use]
    pub fn encode(self) -> [u8; BEAT_BYTES] {
        let sample = self.sample.unwrap_or(NO_SAMPLE);
        let mut bytes = [0; BEAT_BYTES];
        let words = [MAGIC, self.batch.0, sample, MAGIC ^ self.batch.0.rotate_left(17) ^ sample.rotate_left(31)];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(words) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// Decodes a heartbeat; `None` if the bytes are not a heartbeat.
    #[must_use]
    pub fn decode(bytes: &[u8; BEAT_BYTES]) -> Option<Self> {
        let mut words = [0; 4];
        for (word, chunk) in words.iter_mut().zip(bytes.chunks_exact(8)) {
            *word = u64::from_le_bytes(chunk.try_into().ok()?);
        }
        let [magic, batch, sample, check] = words;
        let is_ours = magic == MAGIC && check == MAGIC ^ batch.rotate_left(17) ^ sample.rotate_left(31);
        is_ours.then_some(Beat { batch: BatchId(batch), sample: (sample != NO_SAMPLE).then_some(sample) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heartbeat_survives_and_a_damaged_one_is_refused() {
        for beat in [Beat { batch: BatchId(0), sample: None }, Beat { batch: BatchId(7), sample: Some(12) }] {
            let bytes = beat.encode();
            assert_eq!(Beat::decode(&bytes), Some(beat));
            for bit in 0..BEAT_BYTES * 8 {
                let mut damaged = bytes;
                damaged[bit / 8] ^= 1 << (bit % 8);
                assert_eq!(Beat::decode(&damaged), None, "bit {bit}");
            }
        }
    }
}
