//! Notes on the matching: why rows have no partner, and how to match them.

use super::asked::Source;
use super::error::CompareError;
use super::matching::Matching;
use super::names::Names;
use super::side::{Side, cells, hash, push};
use crate::tables::{ColumnHead, Table, TableError};
use std::collections::HashSet;

/// Notes in the order of output.
pub(super) fn of(
    names: &Names,
    matching: &Matching,
    (a, of_a): (&Source<'_>, &Side),
    (b, of_b): (&Source<'_>, &Side),
) -> Result<Vec<String>, CompareError> {
    let mut notes = Vec::new();
    for (alone, this) in [(&names.alone.0, "A"), (&names.alone.1, "B")] {
        if !alone.is_empty() {
            let verb = if alone.len() == 1 { "is an input" } else { "are inputs" };
            notes.push(format!(
                "{} {verb} only in {this}: rows match only with {}",
                alone.join(", "),
                alone.iter().map(|name| format!("--ignore {name}")).collect::<Vec<_>>().join(" ")
            ));
        }
    }
    let can_match = notes.is_empty();
    if matching.repeated > 0 {
        notes.push(format!(
            "{} pairs have inputs that several rows of each table have: they are matched in the order of their samples",
            matching.repeated
        ));
    }
    let (unclear_a, unclear_b) = matching.unclear;
    if unclear_a > 0 {
        notes.push(format!(
            "{unclear_a} rows of A and {unclear_b} of B have the same inputs, in different numbers: which rows belong \
             together is unknown, and none are matched"
        ));
    }
    if can_match && matching.pairs.is_empty() && unclear_a == 0 && of_a.rows() > 0 && of_b.rows() > 0 {
        for head in &names.by {
            if !shares(head, a, b)? {
                notes.push(format!("no value of {0} is in both: --ignore {0} matches by the other inputs", head.name));
            }
        }
    }
    Ok(notes)
}

/// Whether both tables share any value of an input.
fn shares(head: &ColumnHead, a: &Source<'_>, b: &Source<'_>) -> Result<bool, TableError> {
    let mut values = HashSet::new();
    let mut bytes = Vec::new();
    let mut each = |source: &Source<'_>, see: &mut dyn FnMut(u128)| {
        Table::for_each_piece(source.files, &[head.name.as_str()], |piece| {
            let cells = cells(piece, head);
            for row in 0..piece.rows() {
                bytes.clear();
                push(&mut bytes, cells.as_ref(), row);
                see(hash(&bytes));
            }
            Ok(())
        })
    };
    each(a, &mut |value| {
        values.insert(value);
    })?;
    let mut found = false;
    each(b, &mut |value| found |= values.contains(&value))?;
    Ok(found)
}
