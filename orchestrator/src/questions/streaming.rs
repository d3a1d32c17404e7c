//! Answers from a finished table, row group by row group: for any study with a design whose table is complete and in the order of its
//! samples.

use super::rows::{AnsweringError, Rows};
use super::vocabulary::Vocabulary;
use crate::run::TableEnd;
use bladeoff_answers::ask::{Answered, Question, Streamed, Whole};
use bladeoff_answers::tables::{Table, TableError};
use bladeoff_study::Samples;
use std::path::{Path, PathBuf};

/// Answers to questions that [`Streamed`] supports; `None`: the table has another form. The outer error is that of the file, which may have been
/// replaced in the meantime.
pub(super) fn stream(
    table: &Path,
    samples: &Samples,
    vocabulary: &Vocabulary<'_>,
    end: Option<TableEnd>,
    questions: &[&Question],
) -> Result<Result<Option<Vec<Answered>>, AnsweringError>, TableError> {
    let Some(layout) = samples.layout() else { return Ok(Ok(None)) };
    let files = [PathBuf::from(table)];
    let mut columns: Vec<String> = questions.iter().flat_map(|question| question.columns(&vocabulary.names)).collect();
    columns.sort();
    columns.dedup();
    let head = Rows::head(samples, layout, vocabulary, &columns, &Table::names_in(table)?, end);
    if Table::count_rows(&files)? as u64 != head.of() * vocabulary.groups.len() as u64 || head.of() == 0 {
        return Ok(Ok(None));
    }
    let mut by_replicate = vec![0; layout.replicates() as usize];
    (0..head.of()).for_each(|point| by_replicate[layout.replicate(point) as usize] += 1);
    let names = head.wanted();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let whole = Whole { head: head.study(), points: head.of(), by_replicate };
    let mut streamed = Streamed::new(&whole, questions);
    let mut rows = Rows::head(samples, layout, vocabulary, &columns, &Table::names_in(table)?, end);
    loop {
        let (mut first, mut is_in_order, mut odd) = (0, true, None);
        Table::for_each_piece(&files, &names, |piece| {
            match rows.pass(layout, piece, first) {
                Ok(true) if is_in_order && odd.is_none() => streamed.see(&rows.study(), first),
                Ok(is_next) => is_in_order &= is_next,
                Err(sample) => odd = odd.or(Some(sample)),
            }
            first += piece.rows() as u64;
            Ok(())
        })?;
        if let Some(sample) = odd {
            return Ok(Err(AnsweringError::Row { path: table.to_path_buf(), sample }));
        }
        if !is_in_order {
            return Ok(Ok(None));
        }
        if !streamed.go_on() {
            return Ok(Ok(Some(streamed.answers())));
        }
    }
}
