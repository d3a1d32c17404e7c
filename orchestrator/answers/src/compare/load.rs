//! Reads a few columns of a table at a time: all columns of a million rows would take gigabytes.

use crate::tables::{ColumnHead, HeadKind, Table, TableError};
use std::collections::HashMap;
use std::path::PathBuf;

/// Largest number of cells of each table in memory at a time.
const MOST_CELLS: usize = 8 << 20;

/// Cells of a column; a number that is not finite counts as missing.
#[derive(Debug)]
pub(super) enum Loaded {
    /// Numbers; NaN if missing.
    Numbers(Vec<f64>),
    /// Numbers of words in [`Words`]; 0 if missing.
    Words(Vec<u32>),
}

/// Distinct words, numbered from 1.
#[derive(Debug, Default)]
pub(super) struct Words {
    numbers: HashMap<String, u32>,
    words: Vec<String>,
}

impl Words {
    fn number(&mut self, word: &str) -> u32 {
        if let Some(number) = self.numbers.get(word) {
            return *number;
        }
        self.words.push(word.to_owned());
        let number = u32::try_from(self.words.len()).unwrap_or(u32::MAX);
        self.numbers.insert(word.to_owned(), number);
        number
    }

    /// Word with this number.
    pub fn word(&self, number: u32) -> Option<&str> {
        self.words.get((number as usize).checked_sub(1)?).map(String::as_str)
    }
}

/// Number of columns with so many rows that are read at a time.
pub(super) fn at_once(rows: usize) -> usize {
    (MOST_CELLS / rows.max(1)).clamp(1, 64)
}

/// Reads columns of these files, each with `rows` cells.
pub(super) fn load(
    files: &[PathBuf],
    heads: &[&ColumnHead],
    rows: usize,
    words: &mut Words,
) -> Result<Vec<Loaded>, TableError> {
    let empty = |head: &&ColumnHead| match head.kind {
        HeadKind::Words => Loaded::Words(Vec::with_capacity(rows)),
        HeadKind::Numbers | HeadKind::Other => Loaded::Numbers(Vec::with_capacity(rows)),
    };
    let mut loaded: Vec<Loaded> = heads.iter().map(empty).collect();
    let names: Vec<&str> = heads.iter().map(|head| head.name.as_str()).collect();
    Table::for_each_piece(files, &names, |piece| {
        for (name, column) in names.iter().zip(&mut loaded) {
            match column {
                Loaded::Numbers(cells) => {
                    let found = piece.numbers(name).unwrap_or_default();
                    let number = |cell: &Option<f64>| cell.filter(|number| number.is_finite()).unwrap_or(f64::NAN);
                    cells.extend(found.iter().map(number));
                }
                Loaded::Words(cells) => {
                    let found = piece.words(name).unwrap_or_default();
                    cells.extend(found.iter().map(|cell| cell.as_deref().map_or(0, |word| words.number(word))));
                }
            }
        }
        Ok(())
    })?;
    let is_whole = |column: &Loaded| match column {
        Loaded::Numbers(cells) => cells.len() == rows,
        Loaded::Words(cells) => cells.len() == rows,
    };
    // the file was replaced meanwhile, or lacks a column of the first file
    let damaged = || TableError::Damaged { path: files.first().cloned().unwrap_or_default() };
    if loaded.iter().all(is_whole) { Ok(loaded) } else { Err(damaged()) }
}
