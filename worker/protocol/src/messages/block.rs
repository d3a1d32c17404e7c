//! The fixed-size block under a message: header, checksum, bounds-checked reading and writing of words.

use super::{PROTOCOL_VERSION, RunId};

/// Number of words before the items.
pub(super) const HEADER: usize = 8;

/// A fixed-size block of words, the only data exchanged between processes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Block<const N: usize> {
    /// The words; meaning in the module documentation of [`messages`](super).
    pub words: [u64; N],
}

impl<const N: usize> Block<N> {
    /// A block that does not decode.
    #[must_use]
    pub fn empty() -> Box<Self> {
        Box::new(Self { words: [0; N] })
    }

    /// Number of words in use according to the block, limited to its size; a transport must copy this many.
    #[must_use]
    pub fn used(&self) -> usize {
        usize::try_from(self.words[4]).map_or(N, |used| used.min(N))
    }

    /// Copies the words in use of another block.
    pub fn copy_from(&mut self, other: &Self) {
        let used = other.used().max(HEADER);
        self.words[..used].copy_from_slice(&other.words[..used]);
    }
}

/// Reason for rejecting a block, which is then counted and dropped.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MessageError {
    /// The block is not one of this protocol.
    #[error("magic number {found:#x}, expected {expected:#x}")]
    Magic {
        /// Number in the block.
        found: u64,
        /// Expected number.
        expected: u64,
    },
    /// The format has another version.
    #[error("message format {found}, expected {PROTOCOL_VERSION}")]
    Version {
        /// Version in the block.
        found: u64,
    },
    /// The message belongs to another run.
    #[error("run {found:#x}, expected {expected}")]
    Run {
        /// Run in the block.
        found: u64,
        /// Expected run.
        expected: RunId,
    },
    /// The length is impossible.
    #[error("length {found} words, allowed {least} to {most}")]
    Length {
        /// Length in the block \[words\].
        found: u64,
        /// Smallest allowed length \[words\].
        least: usize,
        /// Largest allowed length \[words\].
        most: usize,
    },
    /// The content does not fit its checksum.
    #[error("checksum {found:#x}, computed {computed:#x}")]
    Checksum {
        /// Checksum in the block.
        found: u64,
        /// Checksum of the content.
        computed: u64,
    },
    /// An unknown code.
    #[error("{field} has the unknown code {found}")]
    Tag {
        /// Field of the code.
        field: &'static str,
        /// Code in the block.
        found: u64,
    },
    /// A count or number out of its range.
    #[error("{field} is {found}, at most {most} allowed")]
    Range {
        /// Field of the number.
        field: &'static str,
        /// Number in the block.
        found: u64,
        /// Largest allowed number.
        most: u64,
    },
    /// A value that is present is not finite.
    #[error("value {index} of sample {sample} is not finite")]
    NotFinite {
        /// Sample number.
        sample: u64,
        /// Index of the value.
        index: usize,
    },
    /// Two fields contradict each other.
    #[error("{what}")]
    Contradiction {
        /// Description of the contradiction.
        what: &'static str,
    },
    /// Items and length do not fit.
    #[error("{left} words are left over after the last item")]
    LeftOver {
        /// Number of words.
        left: usize,
    },
}

/// Checksum of words. Every step is a bijection of the state, so a change of any single word is detected. The final step (of MurmurHash3)
/// spreads a change of the last word over all bits, so that one more flipped bit in the checksum cannot hide the change.
fn checksum(words: &[u64]) -> u64 {
    let state = words.iter().fold(0x9e37_79b9_7f4a_7c15, |state: u64, &word| {
        (state ^ word).wrapping_mul(0xd6e8_feb8_6659_fd93).rotate_left(29)
    });
    let state = (state ^ (state >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    let state = (state ^ (state >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    state ^ (state >> 33)
}

/// Header fields common to both directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Header {
    pub run: RunId,
    pub kind: u32,
    pub worker: u32,
    pub batch: u64,
    pub attempt: u32,
    pub items: u32,
    pub extra: u64,
}

/// Writes one message into a block.
pub(super) struct Writer<'a, const N: usize> {
    words: &'a mut [u64; N],
    at: usize,
}

impl<'a, const N: usize> Writer<'a, N> {
    pub(super) fn new(block: &'a mut Block<N>, magic: u64, header: Header) -> Self {
        let words = &mut block.words;
        words[0] = magic;
        words[1] = PROTOCOL_VERSION;
        words[2] = header.run.0;
        words[3] = u64::from(header.kind) | u64::from(header.worker) << 32;
        words[5] = header.batch;
        words[6] = u64::from(header.attempt) | u64::from(header.items) << 32;
        words[7] = header.extra;
        Self { words, at: HEADER }
    }

    /// Appends a word. Callers must observe the limits in [`super`], from which N was computed.
    pub(super) fn push(&mut self, word: u64) {
        self.words[self.at] = word;
        self.at += 1;
    }

    pub(super) fn finish(self) {
        self.words[4] = self.at as u64 + 1;
        self.words[self.at] = checksum(&self.words[..self.at]);
    }
}

/// Reads one message from a block that was copied out of shared memory.
pub(super) struct Reader<'a> {
    words: &'a [u64],
    at: usize,
}

impl<'a> Reader<'a> {
    /// Checks magic, version, length, checksum, run, in this order.
    pub(super) fn new<const N: usize>(
        block: &'a Block<N>,
        magic: u64,
        run: RunId,
    ) -> Result<(Self, Header), MessageError> {
        let words = &block.words;
        if words[0] != magic {
            return Err(MessageError::Magic { found: words[0], expected: magic });
        }
        if words[1] != PROTOCOL_VERSION {
            return Err(MessageError::Version { found: words[1] });
        }
        let used = usize::try_from(words[4])
            .ok()
            .filter(|used| (HEADER + 1..=N).contains(used))
            .ok_or(MessageError::Length { found: words[4], least: HEADER + 1, most: N })?;
        let (found, computed) = (words[used - 1], checksum(&words[..used - 1]));
        if found != computed {
            return Err(MessageError::Checksum { found, computed });
        }
        if words[2] != run.0 {
            return Err(MessageError::Run { found: words[2], expected: run });
        }
        let header = Header {
            run,
            kind: low(words[3]),
            worker: high(words[3]),
            batch: words[5],
            attempt: low(words[6]),
            items: high(words[6]),
            extra: words[7],
        };
        Ok((Self { words: &words[..used - 1], at: HEADER }, header))
    }

    pub(super) fn word(&mut self) -> Result<u64, MessageError> {
        let word = *self.words.get(self.at).ok_or(MessageError::Length {
            found: self.words.len() as u64 + 1,
            least: self.at + 2,
            most: usize::MAX,
        })?;
        self.at += 1;
        Ok(word)
    }

    pub(super) fn finish(self) -> Result<(), MessageError> {
        match self.words.len() - self.at {
            0 => Ok(()),
            left => Err(MessageError::LeftOver { left }),
        }
    }
}

/// Rejects a number above `most`.
pub(super) fn at_most(field: &'static str, found: u64, most: u64) -> Result<u64, MessageError> {
    if found <= most { Ok(found) } else { Err(MessageError::Range { field, found, most }) }
}

pub(super) fn low(word: u64) -> u32 {
    word as u32
}

pub(super) fn high(word: u64) -> u32 {
    (word >> 32) as u32
}
