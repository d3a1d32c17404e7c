//! Bytes of one entry of the record: fixed order, little endian, versioned, with its key and a checksum, so that an entry is recognised
//! even in a damaged file.
//!
//! ```text
//! b"bOfL" | u32 length of all | u128 key | u8 version | u8 status | u8 cause (255: none) | u8 end cause | u32 causes
//! u32 notes | u32 attempt | u32 worker | f64 cpu_s | u16 n | n x f64 (the all-ones bit pattern: null) | 8 bytes of blake3 of all before
//! ```
//! The n values are the first of a row; later values are null. So a row that ends with nulls is short, and an entry stays valid when a later
//! build appends columns.

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_study::SampleKey;

/// First bytes of every entry.
pub(super) const MAGIC: [u8; 4] = *b"bOfL";
const VERSION: u8 = 3;
const NO_CAUSE: u8 = 255;
/// A NaN that no computation produces; values are never NaN.
const NULL: u64 = u64::MAX;
const CHECKSUM: usize = 8;
/// Bytes between the length and the values.
const FIXED: usize = 16 + 4 + 4 + 4 + 4 + 4 + 8 + 2;
/// Bytes of an entry without values.
pub(super) const LEAST: usize = 4 + 4 + FIXED + CHECKSUM;

/// A finished sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The outcome, which enters the results. Trailing null values of the row may be missing.
    pub outcome: Outcome,
    /// CPU time of the successful attempt \[s\].
    pub cpu_s: f64,
    /// Number of the worker.
    pub worker: u32,
    /// Number of attempts, including the successful one.
    pub attempt: u32,
}

/// First part of an entry: enough to count the entry and to decide whether it can be reused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Head {
    /// Key of the sample's inputs.
    pub key: SampleKey,
    /// Status of the sample.
    pub status: Status,
    /// Reason for a status other than `ok`.
    pub cause: Option<Cause>,
    /// The value of a requested column with whole numbers, if the entry has that column.
    pub count: Option<u64>,
}

/// Reason for rejecting bytes as an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum EntryError {
    /// The entry has another version.
    #[error("record version {found}; this program reads {VERSION}")]
    Version {
        /// Version in the bytes.
        found: u8,
    },
    /// Too short or too long.
    #[error("{found} bytes where {wanted} are needed")]
    Length {
        /// Number of bytes given.
        found: usize,
        /// Number of bytes required.
        wanted: usize,
    },
    /// A code without a meaning.
    #[error("unknown {what} code {code}")]
    Code {
        /// Field of the code.
        what: &'static str,
        /// The code.
        code: u32,
    },
    /// The bytes have changed since they were written.
    #[error("wrong checksum: the bytes have changed since they were written")]
    Checksum,
    /// The entry belongs to another sample.
    #[error("it belongs to other inputs")]
    Key,
}

impl Entry {
    /// Encodes the entry.
    #[must_use]
    pub fn encode(&self, key: SampleKey) -> Vec<u8> {
        let outcome = &self.outcome;
        let count = outcome.values.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        let values = &outcome.values[..count];
        let length = LEAST + 8 * count;
        let mut bytes = Vec::with_capacity(length);
        bytes.extend(MAGIC);
        bytes.extend(u32::try_from(length).expect("a message holds at most 1024 values").to_le_bytes());
        bytes.extend(key.0.to_le_bytes());
        bytes.push(VERSION);
        bytes.push(outcome.status.code());
        bytes.push(outcome.cause.map_or(NO_CAUSE, Cause::code));
        bytes.push(outcome.end_cause.code());
        bytes.extend(outcome.causes.bits().to_le_bytes());
        bytes.extend(outcome.notes.bits().to_le_bytes());
        bytes.extend(self.attempt.to_le_bytes());
        bytes.extend(self.worker.to_le_bytes());
        bytes.extend(self.cpu_s.to_le_bytes());
        let count = u16::try_from(count).expect("a message holds at most 1024 values");
        bytes.extend(count.to_le_bytes());
        for value in values {
            bytes.extend(value.map_or(NULL, f64::to_bits).to_le_bytes());
        }
        bytes.extend(checksum(&bytes));
        bytes
    }

    /// The entry at the beginning of `bytes`, and the bytes after it.
    ///
    /// # Errors
    /// As [`Entry::decode`].
    pub fn first_of(bytes: &[u8]) -> Result<(SampleKey, Self, &[u8]), EntryError> {
        let length = length_at(bytes).ok_or(EntryError::Checksum)?;
        let cut = EntryError::Length { found: bytes.len(), wanted: length };
        let (entry, rest) = bytes.split_at_checked(length).ok_or(cut)?;
        let (key, entry) = Self::decode(entry)?;
        Ok((key, entry, rest))
    }

    /// Decodes an entry.
    ///
    /// # Errors
    /// Changed bytes, another version, a wrong length, an unknown code.
    pub fn decode(bytes: &[u8]) -> Result<(SampleKey, Self), EntryError> {
        let mut reader = Reader(checked(bytes)?);
        let head = reader.head()?;
        let end_cause = reader.take::<1>()?[0];
        let causes = u32::from_le_bytes(reader.take()?);
        let notes = u32::from_le_bytes(reader.take()?);
        let attempt = u32::from_le_bytes(reader.take()?);
        let worker = u32::from_le_bytes(reader.take()?);
        let cpu_s = f64::from_le_bytes(reader.take()?);
        let count = u16::from_le_bytes(reader.take()?);
        let values = (0..count)
            .map(|_| Ok(Some(u64::from_le_bytes(reader.take()?)).filter(|&bits| bits != NULL).map(f64::from_bits)))
            .collect::<Result<Vec<_>, EntryError>>()?;
        if !reader.0.is_empty() {
            return Err(EntryError::Length { found: reader.0.len(), wanted: 0 });
        }
        let outcome = Outcome {
            status: head.status,
            cause: head.cause,
            causes: CauseSet::from_bits(causes).ok_or(EntryError::Code { what: "causes", code: causes })?,
            notes: CauseSet::from_bits(notes).ok_or(EntryError::Code { what: "notes", code: notes })?,
            end_cause: EndCause::from_code(end_cause)
                .ok_or(EntryError::Code { what: "end cause", code: u32::from(end_cause) })?,
            values,
        };
        Ok((head.key, Self { outcome, cpu_s, worker, attempt }))
    }
}

impl Head {
    /// Decodes the head of an entry, whose checksum is verified. `column`: index of the value wanted as `count`.
    ///
    /// # Errors
    /// As [`Entry::decode`].
    pub fn decode(bytes: &[u8], column: Option<usize>) -> Result<Self, EntryError> {
        let content = checked(bytes)?;
        let mut head = Reader(content).head()?;
        head.count = column.and_then(|column| {
            let value = content.get(FIXED..)?.chunks_exact(8).nth(column)?;
            let bits = u64::from_le_bytes(value.try_into().expect("eight bytes"));
            (bits != NULL).then(|| f64::from_bits(bits)).filter(|count| count.fract() == 0.0).map(|count| count as u64)
        });
        Ok(head)
    }
}

/// Length of the entry at the beginning of `bytes`, as stored in it; `None` if there is no entry.
pub(super) fn length_at(bytes: &[u8]) -> Option<usize> {
    let rest = bytes.strip_prefix(&MAGIC)?;
    let length = usize::try_from(u32::from_le_bytes(*rest.first_chunk()?)).ok()?;
    (LEAST..=LEAST + 8 * usize::from(u16::MAX)).contains(&length).then_some(length)
}

fn checksum(bytes: &[u8]) -> [u8; CHECKSUM] {
    *blake3::hash(bytes).as_bytes().first_chunk().expect("a hash has 32 bytes")
}

/// The bytes between length and checksum, both of which are verified.
fn checked(bytes: &[u8]) -> Result<&[u8], EntryError> {
    let wanted = length_at(bytes).ok_or(EntryError::Checksum)?;
    if wanted != bytes.len() {
        return Err(EntryError::Length { found: bytes.len(), wanted });
    }
    let (content, sum) = bytes.split_at(wanted - CHECKSUM);
    if checksum(content) != *sum {
        return Err(EntryError::Checksum);
    }
    Ok(&content[8..])
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], EntryError> {
        let Some((head, rest)) = self.0.split_first_chunk::<N>() else {
            return Err(EntryError::Length { found: self.0.len(), wanted: N });
        };
        self.0 = rest;
        Ok(*head)
    }

    fn head(&mut self) -> Result<Head, EntryError> {
        let key = SampleKey(u128::from_le_bytes(self.take()?));
        let [version, status, cause] = self.take()?;
        if version != VERSION {
            return Err(EntryError::Version { found: version });
        }
        let unknown = |what, code: u8| EntryError::Code { what, code: u32::from(code) };
        Ok(Head {
            key,
            status: Status::from_code(status).ok_or(unknown("status", status))?,
            cause: match cause {
                NO_CAUSE => None,
                code => Some(Cause::from_code(code).ok_or(unknown("cause", code))?),
            },
            count: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// An entry of a later build: unknown codes are reported by name, because the bytes are intact.
    #[test]
    fn codes_of_a_later_build_are_refused_by_name() {
        let outcome = Outcome {
            status: Status::Invalid,
            cause: Some(Cause::NormalWork),
            causes: CauseSet::from_bits(1 << Cause::NormalWork.code()).expect("a cause"),
            notes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: vec![Some(1.0)],
        };
        let entry = Entry { outcome, cpu_s: 1.0, worker: 1, attempt: 1 };
        let with = |at: usize, code: u8| {
            let mut bytes = entry.encode(SampleKey(1));
            bytes[at] = code;
            let content = bytes.len() - CHECKSUM;
            let sum = checksum(&bytes[..content]);
            bytes[content..].copy_from_slice(&sum);
            bytes
        };
        assert_eq!(Entry::decode(&with(25, 1)), Ok((SampleKey(1), entry.clone())), "the place of the status");
        let code = |what, code| EntryError::Code { what, code };
        for (at, number, error) in [
            (24, 4, EntryError::Version { found: 4 }),
            (25, 5, code("status", 5)),
            (26, 24, code("cause", 24)),
            (27, 7, code("end cause", 7)),
            (31, 0x01, code("causes", 0x100_0008)),
            (35, 0x01, code("notes", 0x100_0000)),
        ] {
            assert_eq!(Entry::decode(&with(at, number)).map(drop), Err(error), "byte {at}");
        }
    }

    prop_compose! {
        fn any_entry()(
            status in 0..Status::ALL.len() as u8, cause in prop::option::of(0..Cause::ALL.len() as u8), end in 0..EndCause::ALL.len() as u8,
            causes in 0..1u32 << Cause::ALL.len(), notes in 0..1u32 << Cause::ALL.len(),
            values in prop::collection::vec(prop::option::of(prop::num::f64::NORMAL | prop::num::f64::ZERO), 0..80),
            cpu_s in 0.0..1e6f64, worker: u32, attempt: u32,
        ) -> Entry {
            let outcome = Outcome {
                status: Status::from_code(status).expect("one of all"),
                cause: cause.map(|code| Cause::from_code(code).expect("one of all")),
                causes: CauseSet::from_bits(causes).expect("bits of all"),
                notes: CauseSet::from_bits(notes).expect("bits of all"),
                end_cause: EndCause::from_code(end).expect("one of all"),
                values,
            };
            Entry { outcome, cpu_s, worker, attempt }
        }
    }

    /// Removes the trailing nulls of an entry.
    fn short(mut entry: Entry) -> Entry {
        while entry.outcome.values.last().is_some_and(Option::is_none) {
            entry.outcome.values.pop();
        }
        entry
    }

    #[test]
    fn nulls_at_the_end_of_a_row_take_no_room() {
        let entry = |values: &[Option<f64>]| {
            let outcome = Outcome {
                status: Status::Ok,
                cause: None,
                causes: CauseSet::default(),
                notes: CauseSet::default(),
                end_cause: EndCause::EndTime,
                values: values.to_vec(),
            };
            Entry { outcome, cpu_s: 1.0, worker: 1, attempt: 1 }.encode(SampleKey(1))
        };
        assert_eq!(entry(&[Some(1.0), None, Some(2.0), None, None]), entry(&[Some(1.0), None, Some(2.0)]));
        assert_eq!(entry(&[None, None]).len(), LEAST);
        assert_eq!(entry(&[Some(1.0), None, Some(2.0)]).len(), LEAST + 24);
    }

    proptest! {
        #[test]
        fn an_entry_survives_its_bytes(entry in any_entry(), key: u128) {
            let key = SampleKey(key);
            let bytes = entry.encode(key);
            let entry = short(entry);
            let head = Head { key, status: entry.outcome.status, cause: entry.outcome.cause, count: None };
            prop_assert_eq!(Head::decode(&bytes, None), Ok(head));
            prop_assert_eq!(Head::decode(&bytes, Some(entry.outcome.values.len())), Ok(head), "no such value");
            for (at, value) in entry.outcome.values.iter().enumerate() {
                let count = value.filter(|value| value.fract() == 0.0).map(|value| value as u64);
                prop_assert_eq!(Head::decode(&bytes, Some(at)), Ok(Head { count, ..head }));
            }
            prop_assert_eq!(length_at(&bytes), Some(bytes.len()));
            prop_assert_eq!(Entry::decode(&bytes), Ok((key, entry.clone())));
            let two = [bytes.as_slice(), b"rest"].concat();
            prop_assert_eq!(Entry::first_of(&two), Ok((key, entry, &b"rest"[..])));
        }

        #[test]
        fn any_cut_is_refused(entry in any_entry(), cut: prop::sample::Index) {
            let bytes = entry.encode(SampleKey(1));
            let kept = cut.index(bytes.len());
            prop_assert!(Entry::decode(&bytes[..kept]).is_err());
        }

        #[test]
        fn any_changed_byte_is_noticed(entry in any_entry(), at: prop::sample::Index, flip in 1u8..) {
            let mut bytes = entry.encode(SampleKey(1));
            let at = at.index(bytes.len());
            bytes[at] ^= flip;
            prop_assert!(Entry::decode(&bytes).is_err() && Head::decode(&bytes, Some(0)).is_err());
        }

        #[test]
        fn any_bytes_give_an_entry_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Entry::decode(&bytes);
        }
    }
}
