//! Inputs of selected rows, formatted to identify the rows.

use super::side::{Cells, cells};
use crate::tables::{ColumnHead, Table, TableError};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Inputs of each selected row in the order of `heads`; "none" for a missing value.
pub(super) fn of_rows(
    files: &[PathBuf],
    heads: &[ColumnHead],
    rows: impl Iterator<Item = usize>,
) -> Result<BTreeMap<usize, Vec<String>>, TableError> {
    let none = vec!["none".to_owned(); heads.len()];
    let mut found: BTreeMap<usize, Vec<String>> = rows.map(|row| (row, none.clone())).collect();
    if found.is_empty() || heads.is_empty() {
        return Ok(found);
    }
    let names: Vec<&str> = heads.iter().map(|head| head.name.as_str()).collect();
    let mut from = 0;
    Table::for_each_piece(files, &names, |piece| {
        for (row, told) in found.range_mut(from..from + piece.rows()) {
            for (head, told) in heads.iter().zip(told) {
                let word = match cells(piece, head) {
                    // the shortest decimal that parses to the same bits
                    Some(Cells::Numbers(numbers)) => numbers[row - from].map(|number| format!("{number:?}")),
                    Some(Cells::Words(words)) => words[row - from].clone(),
                    None => None,
                };
                if let Some(word) = word {
                    *told = word;
                }
            }
        }
        from += piece.rows();
        Ok(())
    })?;
    Ok(found)
}
