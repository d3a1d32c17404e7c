//! The worst runs, each with the command that computes it again.

use super::Subject;
use super::rows::{Ends, Seen};
use bladeoff_answers::page::{Block, Table};
use bladeoff_answers::report::worst_least;
use bladeoff_model::document::units::format_digits;
use bladeoff_system::call;
use std::path::Path;

/// A command about a directory, with the program's plain name: a page is read elsewhere, too.
pub(super) fn command(word: &str, directory: &Path, words: &[&str]) -> String {
    let directory = call::word(call::path_word(directory));
    let words: Vec<String> = words.iter().map(call::word).collect();
    format!("bladeoff {word} {directory} {}", words.join(" "))
}

/// For each result the runs with its worst values: the largest, where that is worse the least (a first contact, a speed at the end); of formulas
/// both, as no one knows which end is bad.
pub(super) fn worst(seen: &Seen, subject: Subject<'_>) -> Vec<Block> {
    let is_function = subject.samples.study().function().is_some();
    let mut blocks = Vec::new();
    for (coordinate, Ends { largest, least }) in seen.coordinates.iter().zip(&seen.ends) {
        if largest.is_empty() {
            continue;
        }
        let ends = match worst_least(&coordinate.column).filter(|_| !is_function) {
            Some(end) => vec![(end, least)],
            None if is_function => vec![("largest", largest), ("least", least)],
            None => vec![("largest", largest)],
        };
        for (end, list) in ends {
            let head = [
                "sample".to_owned(),
                format!("{}, {end}", coordinate.name),
                "computes it again, bit for bit".to_owned(),
            ];
            let rows = list.iter().map(|(value, sample)| {
                let again = if is_function {
                    command("why", subject.directory, &[&sample.to_string()])
                } else {
                    command("replay", subject.directory, &["--sample", &sample.to_string()])
                };
                vec![sample.to_string(), format_digits(*value, &coordinate.unit, 5), again]
            });
            let mut head = head.to_vec();
            if is_function {
                head[2] = "all that is known of it".to_owned();
            }
            blocks.push(Block::Table(Table { head, rows: rows.collect(), verbatim: vec![2] }));
        }
    }
    if !blocks.is_empty() {
        let history = if is_function {
            ""
        } else {
            " With --history FILE.mcap the first also writes what happened over time (bladeoff plot FILE.mcap)."
        };
        blocks.insert(
            0,
            Block::Text(format!("Of the runs that are ok. Commands are given from where this page was made.{history}")),
        );
    }
    blocks
}
