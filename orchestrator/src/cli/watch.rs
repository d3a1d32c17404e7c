//! `bladeoff watch`: a page about a running study on the terminal, drawn again every few seconds.

use super::answer::asked_of;
use super::error::CliError;
use super::exit::Exit;
use super::output::{redraw, tell, width};
use super::place::default_directory;
use super::status;
use crate::questions::{Meant, answer, columns_asked, told};
use crate::run::columns_of;
use crate::run::directory::read_current;
use crate::run::shards::row_files;
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{Table, TableError};
use bladeoff_study::{Samples, parse_duration};
use bladeoff_text::document::units::format_digits;
use std::io::{BufRead, stdin};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Number of bins of the histogram.
const BINS: usize = 10;
/// Number of characters of its longest bar.
const BAR: usize = 40;
/// Column of the histogram of a study without questions.
const DEFAULT_COLUMN: &str = "max_bearing_load_N";

/// Watch a study while it runs
///
/// Draws a page on the terminal every few seconds. It has state, pace, remaining time, failures by cause and the task of
/// each worker. Below are the worst value so far, a histogram of the first quantity that the questions name, and the
/// present answers with their intervals. It reads only files of the directory, so the study is not disturbed. `q` and Enter, or Ctrl-C,
/// end it, and so does the end of the study. Without a terminal it prints the page once.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff watch
  bladeoff watch runs/blade-off-risk
  bladeoff watch runs/blade-off-risk --every '10 s'")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if it contains a study, otherwise the newest one
    /// below runs/]
    directory: Option<PathBuf>,

    /// Time between two pages
    #[arg(long, value_name = "TIME", default_value = "2 s", value_parser = parse_duration)]
    every: Duration,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    if width().is_none() {
        tell(&page(&directory)?.text)?;
        return Ok(Exit::Ok);
    }
    let (sender, keys) = channel();
    // if the thread cannot be started, Ctrl-C still ends the command
    let _ = std::thread::Builder::new().name("keyboard".into()).spawn(move || read_keys(&sender));
    loop {
        let page = page(&directory)?;
        redraw(&page.text)?;
        if page.is_complete {
            return Ok(Exit::Ok);
        }
        match keys.recv_timeout(args.every) {
            Ok(()) => return Ok(Exit::Ok),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(args.every),
        }
    }
}

/// Reads lines of standard input until one is `q`.
fn read_keys(sender: &Sender<()>) {
    for line in stdin().lock().lines().map_while(Result::ok) {
        if line.trim().eq_ignore_ascii_case("q") {
            let _ = sender.send(());
            return;
        }
    }
    // standard input has ended: the sender is kept, so that the page is still updated
    std::thread::park();
}

/// One page.
struct Page {
    text: String,
    is_complete: bool,
}

fn page(directory: &Path) -> Result<Page, CliError> {
    let mut text = status::text(directory, false)?;
    let is_complete = text.lines().any(|line| line.starts_with("state") && line.contains("complete"));
    let Ok((samples, _, Meant { questions, gates })) = asked_of(directory, None) else {
        return Ok(Page { text, is_complete });
    };
    let column = columns_asked(&samples, &questions, &gates).into_iter().next();
    let column = column.unwrap_or_else(|| DEFAULT_COLUMN.to_owned());
    let values = read_current(directory, row_files, |files| Values::read(files, &column))?;
    text.push_str(&values.text(&column, &unit(&samples, &column)));
    if !questions.is_empty() && values.rows > 0 {
        text.push('\n');
        text.push_str(&told(&answer(directory, &samples, &questions)?));
    }
    Ok(Page { text, is_complete })
}

/// Unit of a column of the table; empty for a number without one.
fn unit(samples: &Samples, column: &str) -> String {
    let columns = columns_of(samples).unwrap_or_default();
    columns.into_iter().find(|one| one.field.name == column).map_or_else(String::new, |one| one.field.unit)
}

/// Values of one column in the finished rows, of every status.
#[derive(Debug, Default)]
struct Values {
    rows: usize,
    all: Vec<f64>,
    /// Largest value, with its sample and status.
    largest: Option<(f64, u64, String)>,
}

impl Values {
    fn read(files: &[PathBuf], column: &str) -> Result<Self, TableError> {
        let mut found = Self::default();
        Table::for_each_piece(files, &["sample", "status", column], |piece| {
            let (samples, statuses) = (piece.numbers("sample").unwrap_or(&[]), piece.words("status").unwrap_or(&[]));
            let values = piece.numbers(column).unwrap_or(&[]);
            found.rows += piece.rows();
            for ((value, sample), status) in values.iter().zip(samples).zip(statuses) {
                let (Some(value), Some(sample)) = (value.filter(|value| value.is_finite()), sample) else { continue };
                found.all.push(value);
                if found.largest.as_ref().is_none_or(|(largest, ..)| value > *largest) {
                    found.largest = Some((value, *sample as u64, status.clone().unwrap_or_default()));
                }
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Worst value and histogram; one line with the number of rows if no row has a value.
    fn text(&self, column: &str, unit: &str) -> String {
        let show = |value: f64| format_digits(value, unit, 4);
        let Some((largest, sample, status)) = &self.largest else {
            return match self.rows {
                0 => format!(
                    "\n{column}: no value yet, because the tables have no row; the run writes the first ones after some seconds\n"
                ),
                rows => format!("\n{column}: no value in {}\n", counted(rows as u64, "row")),
            };
        };
        // runs that have just ended have no row yet
        let rows = counted(self.rows as u64, "row");
        let mut text = format!("\n{column}, {rows}: largest so far {} (sample {sample}, {status})\n", show(*largest));
        for (from, to, count) in bins(&self.all) {
            let bar = "#".repeat((count * BAR).div_ceil(self.all.len().max(1)));
            text.push_str(&format!("  {:>12} to {:>12}  {count:>8}  {bar}\n", show(from), show(to)));
        }
        let without = self.rows - self.all.len();
        if without > 0 {
            text.push_str(&format!("  without a value: {}\n", counted(without as u64, "run")));
        }
        text
    }
}

/// Equal bins from the smallest to the largest value, with the number of values in each; a single bin if all values are equal.
fn bins(values: &[f64]) -> Vec<(f64, f64, usize)> {
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let span = largest - smallest;
    if !(span > 0.0 && span.is_finite()) {
        return vec![(smallest, largest, values.len())];
    }
    let mut counts = [0_usize; BINS];
    for value in values {
        counts[((value - smallest) / span * BINS as f64).min(BINS as f64 - 1.0) as usize] += 1;
    }
    let edge = |at: usize| smallest + span * at as f64 / BINS as f64;
    counts.iter().enumerate().map(|(at, count)| (edge(at), edge(at + 1), *count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_value_the_number_of_rows_is_printed() {
        let text = |rows| Values { rows, ..Values::default() }.text("g", "");
        assert!(text(0).contains("g: no value yet, because the tables have no row"), "{}", text(0));
        assert_eq!(text(3), "\ng: no value in 3 rows\n");
    }

    #[test]
    fn bins_count_every_value_once() {
        let values: Vec<f64> = (0..=100).map(f64::from).collect();
        let found = bins(&values);
        assert_eq!((found.len(), found.iter().map(|bin| bin.2).sum::<usize>()), (BINS, 101));
        assert_eq!((found[0], found[9]), ((0.0, 10.0, 10), (90.0, 100.0, 11)));
        assert_eq!(bins(&[3.0, 3.0]), [(3.0, 3.0, 2)]);
        let extreme = bins(&[-1e308, 1e308, 0.0]);
        assert_eq!(extreme.iter().map(|bin| bin.2).sum::<usize>(), 3, "{extreme:?}");
    }
}
