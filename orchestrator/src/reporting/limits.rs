//! Limits of the physical model in a study: value and origin of each, the runs that exceed it, and the key that a limit needs which is not
//! judged.
//!
//! ```text
//! exceeded: limit_ratio_NAME > 1; of a row that is not ok the ratio reached while all guards and limits held
//! open:     not exceeded in a run that ended earlier, at another limit or by a failure, and in an invalid run
//! ```

use crate::report::Tally;
use bladeoff_answers::page::Table as PageTable;
use bladeoff_answers::report::{Align, TextTable, counted};
use bladeoff_answers::tables::{Table, TableError};
use bladeoff_model::document::units::format_digits;
use bladeoff_model::machine::{DiaphragmKind, Machine, ModelLimit, OnExceed, RotorKind};
use bladeoff_model::outcome::{Limit, Status};
use bladeoff_study::Samples;
use std::path::PathBuf;

/// How the column of a limit's ratio begins; the limit's name follows.
const RATIO: &str = "limit_ratio_";

/// One limit in the rows of a study.
#[derive(Debug, Clone, PartialEq)]
struct Counted {
    limit: ModelLimit,
    /// Value and reference in words.
    value: String,
    /// Where the value comes from.
    origin: &'static str,
    /// Key that the machine needs; the limit is not judged without it.
    lacks: Option<&'static str>,
    /// Rows of any status.
    rows: u64,
    /// Rows that ended before they could exceed the limit, and invalid rows that did not exceed it while all guards held.
    earlier: u64,
    invalid: u64,
    /// Rows with a ratio above 1, and the ok ones among them.
    exceeded: u64,
    exceeded_ok: u64,
    /// Largest ratio, and its sample.
    largest: Option<(f64, u64)>,
}

/// Limits of a study of a machine, with the counts of its rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LimitTable(Vec<Counted>);

impl LimitTable {
    /// Counts the rows of these files; empty for a study of formulas.
    ///
    /// # Errors
    /// A table that cannot be read.
    pub fn of(samples: &Samples, files: &[PathBuf]) -> Result<Self, TableError> {
        let Some(mut all) = limits(samples) else { return Ok(Self::default()) };
        let names: Vec<String> = all.iter().map(|of| format!("{RATIO}{}", of.limit.limit.word())).collect();
        let guarded: Vec<String> = names.iter().map(|name| format!("guarded_{name}")).collect();
        let columns = ["sample", "status"].into_iter();
        let columns: Vec<&str> = columns.chain(names.iter().chain(&guarded).map(String::as_str)).collect();
        Table::for_each_piece(files, &columns, |piece| {
            let status = piece.words("status").unwrap_or(&[]);
            let number = piece.numbers("sample").unwrap_or(&[]);
            for ((of, name), guarded) in all.iter_mut().zip(&names).zip(&guarded) {
                let (ratios, guarded) = (piece.numbers(name).unwrap_or(&[]), piece.numbers(guarded).unwrap_or(&[]));
                for row in 0..number.len() {
                    let Some(sample) = number[row] else { continue };
                    let Some(status) = status.get(row).and_then(|word| Status::from_word(word.as_deref()?)) else {
                        continue;
                    };
                    let cells = if status == Status::Ok { ratios } else { guarded };
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
            if let Some(key) = of.lacks {
                text.push_str(&format!("  {}: {}\n", of.limit.limit.word(), not_judged(key)));
            }
        }
        text
    }

    /// The table of a page; `None` for a study of formulas.
    #[must_use]
    pub fn page(&self) -> Option<PageTable> {
        let rows = self.0.iter().map(|of| match of.lacks {
            None => of.cells(),
            Some(key) => {
                let mut cells = vec![String::new(); HEAD.len()];
                (cells[0], cells[1]) = (of.limit.limit.word().to_owned(), not_judged(key));
                cells
            }
        });
        let head = HEAD.map(str::to_owned).to_vec();
        (!self.0.is_empty()).then(|| PageTable { head, rows: rows.collect(), verbatim: Vec::new() })
    }

    /// A line for each limit with `on_exceed = "note"` that ok rows exceed: their status does not show it.
    #[must_use]
    pub fn noted(&self) -> Vec<String> {
        let exceeded = self.judged().filter(|of| of.exceeded_ok > 0 && of.limit.on_exceed == OnExceed::Note);
        let line = |of: &Counted| {
            let (name, runs) = (of.limit.limit.word(), counted(of.exceeded_ok, "run"));
            let largest = of
                .largest
                .map(|(ratio, sample)| format!(" (largest ratio {}, sample {sample})", format_digits(ratio, "", 3)));
            format!("{runs} with status ok exceed the limit {name}{}; on_exceed is note", largest.unwrap_or_default())
        };
        exceeded.map(line).collect()
    }

    fn judged(&self) -> impl Iterator<Item = &Counted> {
        self.0.iter().filter(|of| of.lacks.is_none())
    }
}

/// Columns of the table.
const HEAD: [&str; 6] = ["limit", "value", "from", "above it", "exceeded by", "largest ratio"];

fn not_judged(key: &str) -> String {
    format!("not judged: no {key}")
}

impl Counted {
    /// Takes a row with its ratio, of one that is not ok that which counts as reached.
    fn see(&mut self, ratio: Option<f64>, sample: u64, status: Status) {
        self.rows += 1;
        if ratio.is_some_and(|ratio| ratio > 1.0) {
            self.exceeded += 1;
            self.exceeded_ok += u64::from(status == Status::Ok);
        } else {
            match status {
                Status::Invalid => self.invalid += 1,
                // values after another limit are those of another machine, whether the run ended there or not
                Status::Failed | Status::Quarantined | Status::Beyond => self.earlier += 1,
                Status::Ok => {}
            }
        }
        let Some(ratio) = ratio else { return };
        if self.largest.is_none_or(|(most, first)| ratio > most || ratio == most && sample < first) {
            self.largest = Some((ratio, sample));
        }
    }

    fn cells(&self) -> Vec<String> {
        let above = match self.limit.on_exceed {
            OnExceed::Beyond => "beyond",
            OnExceed::Note => "note",
        };
        let mut exceeded = format!("{} of {}", self.exceeded, counted(self.rows, "run"));
        for (count, why) in [(self.earlier, "ended earlier"), (self.invalid, "invalid")] {
            if count > 0 {
                exceeded += &format!("; {count} {why}");
            }
        }
        let largest = self.largest.map(|(ratio, sample)| format!("{} (sample {sample})", format_digits(ratio, "", 3)));
        vec![
            self.limit.limit.word().to_owned(),
            self.value.clone(),
            self.origin.to_owned(),
            above.to_owned(),
            exceeded,
            largest.unwrap_or_else(|| "-".to_owned()),
        ]
    }
}

/// The limits of the first sample, not counted yet.
fn limits(samples: &Samples) -> Option<Vec<Counted>> {
    let definition = samples.try_machine(0).ok().flatten()?;
    let machine = definition.build().ok()?;
    let of = |limit: ModelLimit| {
        let path = format!("run.limit.{}.value", limit.limit.word());
        let origin = if samples.parameters().iter().any(|varied| varied.info.path == path) {
            "varies; here the first sample"
        } else if definition.resolve(&path).is_ok_and(|info| info.default) {
            "default"
        } else {
            "machine or study file"
        };
        Counted {
            limit,
            value: format!("{}{}", format_digits(limit.value, "", 4), reference(&machine, limit.limit)),
            origin,
            lacks: machine.lacks(limit.limit),
            rows: 0,
            earlier: 0,
            invalid: 0,
            exceeded: 0,
            exceeded_ok: 0,
            largest: None,
        }
    };
    Some(machine.run.limits.into_iter().map(of).collect())
}

/// " of yield strength 400 MPa": the reference of a limit's value.
fn reference(machine: &Machine, limit: Limit) -> String {
    let rings = || {
        machine.diaphragms.iter().filter_map(|diaphragm| match &diaphragm.kind {
            DiaphragmKind::Flexible(stator) => Some(stator),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
        })
    };
    let (name, unit, values): (&str, &str, Vec<f64>) = match limit {
        Limit::RingDisplacement => ("mean radius", "m", rings().map(|stator| stator.ring.mean_radius).collect()),
        Limit::RingYield => ("yield strength", "Pa", rings().filter_map(|stator| stator.yield_strength).collect()),
        Limit::BladeYield => {
            let bladed = rings().filter(|stator| stator.blades.is_some());
            ("yield strength", "Pa", bladed.filter_map(|stator| stator.yield_strength).collect())
        }
        Limit::ShaftYield => match &machine.rotor.kind {
            RotorKind::Shaft(shaft) => {
                ("yield strength", "Pa", shaft.elements.iter().filter_map(|element| element.yield_strength).collect())
            }
            RotorKind::PointMass(_) => return String::new(),
        },
        Limit::JournalClearance => {
            ("clearance", "m", machine.rotor.bearings.iter().filter_map(|bearing| bearing.clearance).collect())
        }
        Limit::UnstableRotor => return " growth per revolution".to_owned(),
    };
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match values.as_slice() {
        [] => String::new(),
        _ if least == most => format!(" of {name} {}", format_digits(least, unit, 4)),
        _ => format!(" of {name} {} to {}", format_digits(least, unit, 4), format_digits(most, unit, 4)),
    }
}

/// A line where more runs are beyond the model than `[limits] max_beyond` of the study allows.
///
/// # Errors
/// A table that cannot be read.
pub fn too_many_beyond(samples: &Samples, files: &[PathBuf]) -> Result<Option<String>, TableError> {
    let mut tally = Tally::default();
    Table::for_each_piece(files, &["status"], |piece| {
        let status = piece.words("status").unwrap_or(&[]).iter().flatten();
        status.filter_map(|word| Status::from_word(word)).for_each(|status| tally.count(status, None));
        Ok(())
    })?;
    let (beyond, allowed) = (tally.of(Status::Beyond), samples.study().limits.max_beyond);
    Ok((!allowed.allows(beyond, tally.done())).then(|| {
        let rows = counted(tally.done(), "sample");
        format!("{beyond} of {rows} beyond the model; the study allows {allowed} ([limits] max_beyond)")
    }))
}
