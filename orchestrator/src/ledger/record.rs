//! One entry of the record as bytes: fixed order, little endian, versioned.
//!
//! ```text
//! u8 version | u8 status | u8 cause (255: none) | u8 end cause | u32 causes | u32 attempt | u32 worker | f64 cpu_s
//! u16 n | n x f64 (the all-ones bit pattern: null)
//! ```

use bladeoff_core::outcome::{Cause, CauseSet, EndCause, Outcome, Status};

const VERSION: u8 = 1;
const NO_CAUSE: u8 = 255;
/// A NaN that no computation gives; values are never NaN.
const NULL: u64 = u64::MAX;

/// A finished sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What came out: the part that belongs to the results.
    pub outcome: Outcome,
    /// CPU time of the attempt that counted \[s\].
    pub cpu_s: f64,
    /// Number of the worker.
    pub worker: u32,
    /// Attempts, the one that counted included.
    pub attempt: u32,
}

/// Why bytes are not an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// Written by another version.
    #[error("record version {found}, this program knows {VERSION}")]
    Version {
        /// What the bytes say.
        found: u8,
    },
    /// Too short or too long.
    #[error("{found} bytes at a place where {wanted} are needed")]
    Length {
        /// Bytes there.
        found: usize,
        /// Bytes needed.
        wanted: usize,
    },
    /// A code that stands for nothing.
    #[error("unknown {what} code {code}")]
    Code {
        /// Of which field.
        what: &'static str,
        /// The code.
        code: u32,
    },
}

impl Entry {
    /// As bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let outcome = &self.outcome;
        let mut bytes = Vec::with_capacity(26 + 8 * outcome.values.len());
        bytes.push(VERSION);
        bytes.push(outcome.status.code());
        bytes.push(outcome.cause.map_or(NO_CAUSE, Cause::code));
        bytes.push(outcome.end_cause.code());
        bytes.extend(outcome.causes.bits().to_le_bytes());
        bytes.extend(self.attempt.to_le_bytes());
        bytes.extend(self.worker.to_le_bytes());
        bytes.extend(self.cpu_s.to_le_bytes());
        let count = u16::try_from(outcome.values.len()).expect("a message holds at most 256 values");
        bytes.extend(count.to_le_bytes());
        for value in &outcome.values {
            bytes.extend(value.map_or(NULL, f64::to_bits).to_le_bytes());
        }
        bytes
    }

    /// From bytes.
    ///
    /// # Errors
    /// Another version, a wrong length, an unknown code.
    pub fn decode(bytes: &[u8]) -> Result<Self, RecordError> {
        let mut reader = Reader(bytes);
        let [version] = reader.take()?;
        if version != VERSION {
            return Err(RecordError::Version { found: version });
        }
        let [status] = reader.take()?;
        let [cause] = reader.take()?;
        let [end_cause] = reader.take()?;
        let causes = u32::from_le_bytes(reader.take()?);
        let attempt = u32::from_le_bytes(reader.take()?);
        let worker = u32::from_le_bytes(reader.take()?);
        let cpu_s = f64::from_le_bytes(reader.take()?);
        let count = u16::from_le_bytes(reader.take()?);
        let values = (0..count)
            .map(|_| Ok(Some(u64::from_le_bytes(reader.take()?)).filter(|&bits| bits != NULL).map(f64::from_bits)))
            .collect::<Result<Vec<_>, RecordError>>()?;
        if !reader.0.is_empty() {
            return Err(RecordError::Length { found: reader.0.len(), wanted: 0 });
        }
        let unknown = |what, code: u8| RecordError::Code { what, code: u32::from(code) };
        let cause =
            if cause == NO_CAUSE { None } else { Some(Cause::from_code(cause).ok_or(unknown("cause", cause))?) };
        let outcome = Outcome {
            status: Status::from_code(status).ok_or(unknown("status", status))?,
            cause,
            causes: CauseSet::from_bits(causes).ok_or(RecordError::Code { what: "causes", code: causes })?,
            end_cause: EndCause::from_code(end_cause).ok_or(unknown("end cause", end_cause))?,
            values,
        };
        Ok(Self { outcome, cpu_s, worker, attempt })
    }
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], RecordError> {
        let Some((head, rest)) = self.0.split_first_chunk::<N>() else {
            return Err(RecordError::Length { found: self.0.len(), wanted: N });
        };
        self.0 = rest;
        Ok(*head)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    prop_compose! {
        fn any_entry()(
            status in 0..4u8, cause in prop::option::of(0..12u8), end in 0..4u8, causes in 0..4096u32,
            values in prop::collection::vec(prop::option::of(prop::num::f64::NORMAL | prop::num::f64::ZERO), 0..80),
            cpu_s in 0.0..1e6f64, worker: u32, attempt: u32,
        ) -> Entry {
            let outcome = Outcome {
                status: Status::from_code(status).expect("four"),
                cause: cause.map(|code| Cause::from_code(code).expect("twelve")),
                causes: CauseSet::from_bits(causes).expect("twelve bits"),
                end_cause: EndCause::from_code(end).expect("four"),
                values,
            };
            Entry { outcome, cpu_s, worker, attempt }
        }
    }

    proptest! {
        #[test]
        fn an_entry_survives_its_bytes(entry in any_entry()) {
            prop_assert_eq!(Entry::decode(&entry.encode()), Ok(entry));
        }

        #[test]
        fn any_cut_is_refused(entry in any_entry(), cut: prop::sample::Index) {
            let bytes = entry.encode();
            let kept = cut.index(bytes.len());
            prop_assert!(Entry::decode(&bytes[..kept]).is_err());
        }

        #[test]
        fn any_bytes_give_an_entry_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Entry::decode(&bytes);
        }
    }
}
