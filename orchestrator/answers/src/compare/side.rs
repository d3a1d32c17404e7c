//! One of two tables: sample, verdict and input key of each row.

use super::error::CompareError;
use crate::tables::{ColumnHead, HeadKind, Table};
use bladeoff_model::outcome::Status;
use std::path::PathBuf;

/// Verdicts by their text: "ok", "failed: diverged". The first one is ok.
#[derive(Debug)]
pub(super) struct Verdicts(Vec<String>);

/// Number of the verdict ok.
pub(super) const OK: u16 = 0;

impl Default for Verdicts {
    fn default() -> Self {
        Self(vec![Status::Ok.word().to_owned()])
    }
}

impl Verdicts {
    /// Number of a verdict. There are at most statuses times causes, far fewer than `u16` allows.
    fn number(&mut self, status: Status, cause: Option<&str>) -> u16 {
        if status == Status::Ok {
            return OK;
        }
        let label = cause.map_or_else(|| status.word().to_owned(), |cause| format!("{}: {cause}", status.word()));
        let found = self.0.iter().position(|known| *known == label).unwrap_or_else(|| {
            self.0.push(label);
            self.0.len() - 1
        });
        u16::try_from(found).unwrap_or(u16::MAX)
    }

    /// Text of a verdict.
    pub fn label(&self, number: u16) -> &str {
        self.0.get(usize::from(number)).map_or("of another cause", String::as_str)
    }
}

/// Rows of a table in the order of its files.
#[derive(Debug, Default)]
pub(super) struct Side {
    /// Sample numbers.
    pub samples: Vec<u64>,
    /// Verdict numbers in [`Verdicts`].
    pub verdicts: Vec<u16>,
    /// 128-bit hashes of the inputs by which rows match.
    pub keys: Vec<u128>,
}

impl Side {
    pub fn rows(&self) -> usize {
        self.samples.len()
    }

    pub fn is_ok(&self, row: usize) -> bool {
        self.verdicts[row] == OK
    }

    pub fn count_ok(&self) -> u64 {
        self.verdicts.iter().filter(|verdict| **verdict == OK).count() as u64
    }

    /// Reads the rows of these files; `by`: inputs of the key.
    pub fn read(files: &[PathBuf], by: &[&ColumnHead], verdicts: &mut Verdicts) -> Result<Self, CompareError> {
        let mut side = Self::default();
        let mut odd = None;
        let names: Vec<&str> =
            ["sample", "status", "cause"].into_iter().chain(by.iter().map(|head| head.name.as_str())).collect();
        let mut bytes = Vec::new();
        for path in files {
            let before = side.rows();
            Table::for_each_piece(std::slice::from_ref(path), &names, |piece| {
                let numbers = piece.numbers("sample").unwrap_or_default();
                let (statuses, causes) = (piece.words("status"), piece.words("cause"));
                let inputs: Vec<Option<Cells<'_>>> = by.iter().map(|head| cells(piece, head)).collect();
                for row in 0..piece.rows() {
                    let sample = numbers.get(row).copied().flatten().filter(|number| is_number_of_sample(*number));
                    let status = statuses.and_then(|words| Status::from_word(words[row].as_deref()?));
                    let (Some(sample), Some(status)) = (sample, status) else {
                        odd = odd.clone().or(Some((path.clone(), side.rows() - before)));
                        return Ok(());
                    };
                    let cause = causes.and_then(|words| words[row].as_deref());
                    side.samples.push(sample as u64);
                    side.verdicts.push(verdicts.number(status, cause));
                    bytes.clear();
                    inputs.iter().for_each(|cells| push(&mut bytes, cells.as_ref(), row));
                    side.keys.push(hash(&bytes));
                }
                Ok(())
            })?;
        }
        match odd {
            Some((path, row)) => Err(CompareError::Row { path, row }),
            None => Ok(side),
        }
    }
}

fn is_number_of_sample(number: f64) -> bool {
    number >= 0.0 && number < (1u64 << 53) as f64 && libm::floor(number) == number
}

/// Cells of an input in a piece.
pub(super) enum Cells<'a> {
    Numbers(&'a [Option<f64>]),
    Words(&'a [Option<String>]),
}

pub(super) fn cells<'a>(piece: &'a Table, head: &ColumnHead) -> Option<Cells<'a>> {
    match head.kind {
        HeadKind::Words => piece.words(&head.name).map(Cells::Words),
        HeadKind::Numbers | HeadKind::Other => piece.numbers(&head.name).map(Cells::Numbers),
    }
}

/// Appends a cell as bytes, so that different rows have different bytes.
pub(super) fn push(bytes: &mut Vec<u8>, cells: Option<&Cells<'_>>, row: usize) {
    match cells {
        Some(Cells::Numbers(numbers)) => match numbers[row].filter(|number| !number.is_nan()) {
            // 0 and -0 are equal
            Some(number) => {
                bytes.push(1);
                bytes.extend((number + 0.0).to_bits().to_le_bytes());
            }
            None => bytes.push(0),
        },
        Some(Cells::Words(words)) => match &words[row] {
            Some(word) => {
                bytes.push(2);
                bytes.extend((word.len() as u64).to_le_bytes());
                bytes.extend(word.as_bytes());
            }
            None => bytes.push(0),
        },
        None => bytes.push(0),
    }
}

pub(super) fn hash(bytes: &[u8]) -> u128 {
    let hash = blake3::hash(bytes);
    let half: [u8; 16] = std::array::from_fn(|at| hash.as_bytes()[at]);
    u128::from_le_bytes(half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(cell: Option<f64>) -> u128 {
        let (mut bytes, cells) = (Vec::new(), [cell]);
        push(&mut bytes, Some(&Cells::Numbers(&cells)), 0);
        hash(&bytes)
    }

    #[test]
    fn keys_are_of_exact_values_and_zero_has_no_sign() {
        assert_eq!(key(Some(0.0)), key(Some(-0.0)));
        assert_eq!(key(None), key(Some(f64::NAN)));
        assert_ne!(key(Some(0.1 + 0.2)), key(Some(0.3)));
        assert_ne!(key(None), key(Some(0.0)));
    }

    #[test]
    fn words_of_two_columns_are_not_one_word() {
        let of = |a: &str, b: &str| {
            let (a, b) = ([Some(a.to_owned())], [Some(b.to_owned())]);
            let mut bytes = Vec::new();
            [&a, &b].into_iter().for_each(|word| push(&mut bytes, Some(&Cells::Words(word)), 0));
            hash(&bytes)
        };
        assert_ne!(of("ab", "c"), of("a", "bc"));
    }
}
