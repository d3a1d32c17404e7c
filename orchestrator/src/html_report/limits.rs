//! Limits of the physical model in a study: value and origin of each limit, the runs that exceed it, and the missing key of a limit that is not
//! judged.
//!
//! ```text
//! exceeded: limit_ratio_NAME > 1; of a row that is not ok the ratio reached while all guards and limits held
//! undecided: not exceeded before another limit or a failure, after which nothing is counted
//! ```

use super::limit_values::{LimitValue, not_judged, of_study, stress, unjudged_stresses};
use crate::terminal::{Tally, just_above};
use bladeoff_answers::page::{Block, Table as PageTable};
use bladeoff_answers::summary::{Align, TextTable, counted};
use bladeoff_answers::tables::{Table, TableError};
use bladeoff_model::machine::OnExceed;
use bladeoff_model::outcome::Status;
use bladeoff_study::Samples;
use bladeoff_text::document::units::format_digits;
use std::path::PathBuf;

/// Stress above which no steel of a turbine's rings, blades or shafts is elastic \[Pa\]: the yield strength of maraging steels reaches 2 GPa, that of
/// blade steels is below 1.3 GPa.
const ABOVE_ANY_STEEL: f64 = 2e9;

/// Beginning of the column name of a limit's ratio; the name of the limit follows.
const RATIO: &str = "limit_ratio_";

/// Counts for one limit over the rows of a study.
#[derive(Debug, Clone, PartialEq)]
struct Counted {
    of: LimitValue,
    /// Number of rows of any status.
    rows: u64,
    /// Number of rows that ended before they could exceed the limit, and of invalid rows that did not exceed it while all guards held.
    earlier: u64,
    invalid: u64,
    /// Number of rows with a ratio above 1, and of the ok rows among them.
    exceeded: u64,
    exceeded_ok: u64,
    /// Largest ratio, and its sample.
    largest: Option<(f64, u64)>,
    /// Largest stress of the ok rows if the limit is not judged, and its sample.
    stress: Option<(f64, u64)>,
    /// Number of ok rows with a stress above [`ABOVE_ANY_STEEL`] if the limit is not judged.
    above: u64,
}

/// Limits of a study of a machine, with the counts of its rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LimitTable(Vec<Counted>);

impl LimitTable {
    /// Counts the rows of these files; empty for a study of formulas.
    ///
    /// # Errors
    /// A table cannot be read.
    pub fn of(samples: &Samples, files: &[PathBuf]) -> Result<Self, TableError> {
        let Some(all) = of_study(samples) else { return Ok(Self::default()) };
        let mut all: Vec<Counted> = all.into_iter().map(Counted::new).collect();
        let names: Vec<String> = all.iter().map(|counted| counted.column()).collect();
        let guarded: Vec<String> = names.iter().map(|name| format!("guarded_{name}")).collect();
        let columns = ["sample", "status"].into_iter();
        let columns: Vec<&str> = columns.chain(names.iter().chain(&guarded).map(String::as_str)).collect();
        Table::for_each_piece(files, &columns, |piece| {
            let status = piece.words("status").unwrap_or(&[]);
            let number = piece.numbers("sample").unwrap_or(&[]);
            for ((of, name), guarded) in all.iter_mut().zip(&names).zip(&guarded) {
                let (values, guarded) = (piece.numbers(name).unwrap_or(&[]), piece.numbers(guarded).unwrap_or(&[]));
                for row in 0..number.len() {
                    let Some(sample) = number[row] else { continue };
                    let Some(status) = status.get(row).and_then(|word| Status::from_word(word.as_deref()?)) else {
                        continue;
                    };
                    let cells = if status == Status::Ok { values } else { guarded };
                    of.see(cells.get(row).copied().flatten(), sample as u64, status);
                }
            }
            Ok(())
        })?;
        Ok(Self(all))
    }

    /// The table below a summary; empty for a study of formulas.
    #[must_use]
    pub fn text(&self, width: Option<usize>) -> String {
        let mut table = TextTable::new(&HEAD.map(|head| (head, Align::Left)));
        self.judged().for_each(|of| table.row(of.cells()));
        let mut text = String::new();
        if !self.0.is_empty() {
            text = format!("Limits of the model:\n{}", table.fitting("  ", width));
        }
        for of in &self.0 {
            if let Some(key) = of.of.lacks {
                text.push_str(&format!("  {}: {}\n", of.of.name(), of.unjudged(key)));
            }
        }
        text
    }

    /// The warning above a summary or page if stresses are not judged.
    #[must_use]
    pub fn unjudged(&self) -> Option<String> {
        let parts = self.0.iter().filter(|of| of.stress.is_some()).filter_map(|of| Some(stress(of.of.limit.limit)?.1));
        unjudged_stresses(&parts.collect::<Vec<_>>())
    }

    /// The stresses that are not judged.
    pub(super) fn unjudged_stresses(&self) -> Vec<UnjudgedStress> {
        let all = self.0.iter().filter_map(|of| {
            let (key, (largest, sample), above) = (of.of.lacks?, of.stress?, of.above);
            let (column, part) = stress(of.of.limit.limit)?;
            let [shown, limit] = [largest, ABOVE_ANY_STEEL].map(|stress| format_digits(stress, "Pa", 4));
            let mut why = format!("{}; the largest of the ok runs is {shown} (sample {sample})", not_judged(key));
            if above > 0 {
                let runs = counted(above, "ok run");
                why += &format!("; {runs} above {limit}, the elastic limit of any steel");
            }
            Some(UnjudgedStress { column, part, above, why })
        });
        all.collect()
    }

    /// The table of a page, and the meaning of its ratios; empty for a study of formulas.
    #[must_use]
    pub fn blocks(&self) -> Vec<Block> {
        let Some(table) = self.page() else { return Vec::new() };
        let ends = self.judged().any(|of| of.exceeded > 0 && of.of.limit.on_exceed == OnExceed::Beyond);
        let note = ends.then(|| {
            let text = "A run that ends at a limit has a ratio just above 1 there. How far the machine would exceed \
                        the limit is not computed.";
            Block::Note(text.to_owned())
        });
        std::iter::once(Block::Table(table)).chain(note).collect()
    }

    /// The table of a page; `None` for a study of formulas.
    fn page(&self) -> Option<PageTable> {
        let rows = self.0.iter().map(|of| match of.of.lacks {
            None => of.cells(),
            Some(key) => {
                let mut cells = vec![String::new(); HEAD.len()];
                (cells[0], cells[1]) = (of.of.name().to_owned(), of.unjudged(key));
                cells
            }
        });
        let head = HEAD.map(str::to_owned).to_vec();
        (!self.0.is_empty()).then(|| PageTable { head, rows: rows.collect(), verbatim: Vec::new() })
    }

    /// A line for each limit with `on_exceed = "note"` that ok rows exceed, because their status does not show this.
    #[must_use]
    pub fn noted(&self) -> Vec<String> {
        let line = |of: &Counted| {
            let (name, runs) = (of.of.name(), counted(of.exceeded_ok, "run"));
            let largest =
                of.largest.map(|(ratio, sample)| format!(" (largest ratio {}, sample {sample})", just_above(ratio)));
            format!("{runs} with status ok exceed the limit {name}{}; on_exceed is note", largest.unwrap_or_default())
        };
        self.exceeded_and_noted().map(line).collect()
    }

    /// Names of the limits of [`LimitTable::noted`].
    pub(super) fn names_noted(&self) -> Vec<&str> {
        self.exceeded_and_noted().map(|of| of.of.name()).collect()
    }

    /// The limits that ok rows exceed.
    fn exceeded_and_noted(&self) -> impl Iterator<Item = &Counted> {
        self.judged().filter(|of| of.exceeded_ok > 0 && of.of.limit.on_exceed == OnExceed::Note)
    }

    fn judged(&self) -> impl Iterator<Item = &Counted> {
        self.0.iter().filter(|of| of.of.lacks.is_none())
    }
}

/// Columns of the table.
const HEAD: [&str; 6] = ["limit", "value", "set by", "if exceeded", "exceeded by", "largest ratio"];

/// A stress that is not judged because no yield strength is given.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnjudgedStress {
    /// Column of the stress.
    pub column: &'static str,
    /// Part that has the stress.
    pub part: &'static str,
    /// Number of ok rows in which the stress is above the elastic limit of any steel.
    pub above: u64,
    /// Missing key, and the largest stress of the ok rows.
    pub why: String,
}

impl Counted {
    fn new(of: LimitValue) -> Self {
        Self { of, rows: 0, earlier: 0, invalid: 0, exceeded: 0, exceeded_ok: 0, largest: None, stress: None, above: 0 }
    }

    /// The column that is counted: the ratio of a limit, or the stress that the limit would judge.
    fn column(&self) -> String {
        let ratio = format!("{RATIO}{}", self.of.name());
        let stress = stress(self.of.limit.limit).filter(|_| self.of.lacks.is_some());
        stress.map_or(ratio, |(column, _)| column.to_owned())
    }

    /// Words for a limit that is not judged: "not judged: no KEY; largest stress of the ok runs 512 MPa (sample 3)".
    fn unjudged(&self, key: &str) -> String {
        let largest = self.stress.map(|(value, sample)| {
            format!("; largest stress of the ok runs {} (sample {sample})", format_digits(value, "Pa", 4))
        });
        not_judged(key) + &largest.unwrap_or_default()
    }

    /// Adds the value of the column in a row; for a row that is not ok, this is the value before a guard or limit was exceeded.
    fn see(&mut self, value: Option<f64>, sample: u64, status: Status) {
        let larger = |most: Option<(f64, u64)>, value: f64| {
            most.is_none_or(|(most, first)| value > most || value == most && sample < first)
        };
        if self.of.lacks.is_some() {
            if let Some(value) = value.filter(|_| status == Status::Ok) {
                self.above += u64::from(value > ABOVE_ANY_STEEL);
                if larger(self.stress, value) {
                    self.stress = Some((value, sample));
                }
            }
            return;
        }
        self.rows += 1;
        if value.is_some_and(|ratio| ratio > 1.0) {
            self.exceeded += 1;
            self.exceeded_ok += u64::from(status == Status::Ok);
        } else {
            match status {
                Status::Invalid => self.invalid += 1,
                // values after another limit was exceeded do not belong to this machine, whether the run ended there or not
                Status::Failed | Status::Quarantined | Status::Beyond => self.earlier += 1,
                Status::Ok => {}
            }
        }
        if let Some(ratio) = value.filter(|&ratio| larger(self.largest, ratio)) {
            self.largest = Some((ratio, sample));
        }
    }

    fn cells(&self) -> Vec<String> {
        let mut exceeded = format!("{} of {}", self.exceeded, counted(self.rows, "run"));
        for (count, why) in [(self.earlier, "undecided"), (self.invalid, "invalid")] {
            if count > 0 {
                exceeded += &format!("; {count} {why}");
            }
        }
        let largest = self.largest.map(|(ratio, sample)| format!("{} (sample {sample})", just_above(ratio)));
        vec![
            self.of.name().to_owned(),
            self.of.value.clone(),
            self.of.origin.to_owned(),
            self.of.exceeded().to_owned(),
            exceeded,
            largest.unwrap_or_else(|| "-".to_owned()),
        ]
    }
}

/// A line if more runs are beyond the model than `[limits] max_beyond` of the study allows.
///
/// # Errors
/// A table cannot be read.
pub fn too_many_beyond(samples: &Samples, files: &[PathBuf]) -> Result<Option<String>, TableError> {
    let mut tally = Tally::default();
    Table::for_each_piece(files, &["status"], |piece| {
        let status = piece.words("status").unwrap_or(&[]).iter().flatten();
        status.filter_map(|word| Status::from_word(word)).for_each(|status| tally.count(status, None));
        Ok(())
    })?;
    Ok(above_max_beyond(samples, tally.of(Status::Beyond), tally.done()))
}

/// The line if the number of samples beyond the model among `done` samples is larger than the study allows.
#[must_use]
pub fn above_max_beyond(samples: &Samples, beyond: u64, done: u64) -> Option<String> {
    let allowed = samples.study().limits.max_beyond;
    (!allowed.allows(beyond, done)).then(|| {
        let rows = counted(done, "sample");
        format!("{beyond} of {rows} beyond the model; the study allows {allowed} ([limits] max_beyond)")
    })
}
