//! The worst runs, each with the command that reproduces it.

use super::Subject;
use super::rows::{Coordinate, End, Ends, Extreme, Seen};
use super::words::kind_in_words;
use bladeoff_answers::page::{Block, Table};
use bladeoff_answers::summary::{counted, worst_least};
use bladeoff_system::call;
use bladeoff_text::document::units::format_digits;
use std::path::Path;

/// A command for a directory, with the plain name of the program: a page may be read on another computer.
pub(super) fn command(word: &str, directory: &Path, words: &[&str]) -> String {
    let directory = call::word(call::path_word(directory));
    let words: Vec<String> = words.iter().map(call::word).collect();
    format!("bladeoff {word} {directory} {}", words.join(" "))
}

/// For each result the runs with its worst values: the largest, or the smallest where that is worse (first contact, end speed). Results of formulas
/// have both lists, because either end may be unfavourable. Runs of every status are in one list, ranked by the values reached before a guard or
/// limit was exceeded. The worst ok run is listed beside them.
pub(super) fn worst(seen: &Seen, subject: Subject<'_>) -> Vec<Block> {
    let is_function = subject.samples.study().function().is_some();
    let mut blocks = Vec::new();
    for (coordinate, Ends { largest, least, recorded, unknown }) in seen.coordinates.iter().zip(&seen.ends) {
        if largest.all.is_empty() {
            continue;
        }
        let ends = match worst_least(&coordinate.column).filter(|_| !is_function) {
            Some(end) => vec![(end, least)],
            None if is_function => vec![("largest", largest), ("least", least)],
            None => vec![("largest", largest)],
        };
        for (end, list) in ends {
            blocks.push(Block::Table(table(coordinate, end, list, subject, is_function)));
        }
        if let Some(note) = beyond_the_list(coordinate, largest, recorded.as_ref()).filter(|_| !is_function) {
            blocks.push(Block::Note(note));
        }
        if *unknown > 0 && !is_function {
            blocks.push(Block::Note(format!(
                "{} not ok and not in the list: their {} before the guard or limit was exceeded is unknown.",
                are_counted(*unknown),
                coordinate.name
            )));
        }
    }
    if !blocks.is_empty() {
        let text = if is_function {
            "Runs with the status ok. The commands work in the directory where this page was written.".to_owned()
        } else {
            "Runs of every status. For runs that are not ok, the list is ordered by the value before a guard or limit was exceeded: a lower bound. \
             The column \"in the table\" is the value of results.parquet, up to the end of the run. The last line is the worst ok run if it is not \
             among them. The commands work in the directory where this page was written. With --history FILE.mcap \
             they also write the time history \
             (bladeoff plot FILE.mcap)."
                .to_owned()
        };
        blocks.insert(0, Block::Text(text));
    }
    blocks
}

/// Sentence about the largest value in the table of a run that is not ok, if it is above every value of the list and the run is not in the list.
fn beyond_the_list(coordinate: &Coordinate, list: &End, recorded: Option<&Extreme>) -> Option<String> {
    let one = recorded.filter(|one| list.all.first().is_none_or(|first| one.value > first.value))?;
    if list.all.iter().any(|row| row.sample == one.sample) {
        return None;
    }
    Some(format!(
        "The largest {} in the table is {}, in sample {} ({}). It was reached after a guard or limit was exceeded.",
        coordinate.name,
        format_digits(one.value, &coordinate.unit, 5),
        one.sample,
        kind_in_words(&one.kind)
    ))
}

/// "1 run is", "2 runs are".
fn are_counted(count: u64) -> String {
    format!("{} {}", counted(count, "run"), if count == 1 { "is" } else { "are" })
}

/// The table of one list.
fn table(coordinate: &Coordinate, end: &str, list: &End, subject: Subject<'_>, is_function: bool) -> Table {
    let is_listed = |ok: &&Extreme| !list.all.iter().any(|row| row.sample == ok.sample);
    let rows: Vec<&Extreme> = list.all.iter().chain(list.ok.as_ref().filter(is_listed)).collect();
    let is_marked = rows.iter().any(|row| row.kind.0 != "ok");
    let show = |value: f64| format_digits(value, &coordinate.unit, 5);
    // "largest bearing load" instead of "largest max bearing load"
    let name = coordinate.name.strip_prefix("max ").filter(|_| end == "largest").unwrap_or(&coordinate.name);
    let mut head = vec!["sample".to_owned(), "status".to_owned(), format!("{end} {name}")];
    if is_marked {
        head.push("in the table".to_owned());
    }
    let verbatim = vec![head.len()];
    head.push(if is_function { "details" } else { "command to reproduce" }.to_owned());
    let cells = |row: &&Extreme| {
        let sample = row.sample.to_string();
        let again = if is_function {
            command("why", subject.directory, &[&sample])
        } else {
            command("replay", subject.directory, &["--sample", &sample])
        };
        let mut cells = vec![sample, kind_in_words(&row.kind), show(row.value)];
        if is_marked {
            cells.push(row.recorded.map_or_else(|| "-".to_owned(), show));
        }
        cells.push(again);
        cells
    };
    Table { head, rows: rows.iter().map(cells).collect(), verbatim }
}
