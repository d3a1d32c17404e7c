//! Summary of a result table: statuses of the samples, and the main quantities, by contact detection.
//!
//! Statistics are over `ok` rows that have the quantity; their number is printed, and rows not included are
//! listed. A failed, invalid or beyond row is never dropped silently.

use super::counts::Counts;
use super::figures::{Values, all_pass};
use super::reached::{Line, Reached, reached};
use super::text::{Align, TextTable, counted};
use crate::tables::{DETECTION, Table, TableError};
use bladeoff_model::machine::{TWIN, TWIN_LIMIT};
use bladeoff_text::document::units::format_digits;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::PathBuf;

/// The unfavourable end of a quantity.
#[derive(Clone, Copy)]
enum Worst {
    Largest,
    Smallest,
}

/// The main quantities: column, SI unit, label, unfavourable end.
const QUANTITIES: [(&str, &str, &str, Worst); 6] = [
    ("max_bearing_load_N", "N", "largest bearing load", Worst::Largest),
    ("max_filtered_contact_force_N", "N", "largest contact force (1 ms mean)", Worst::Largest),
    ("max_eccentricity_m", "m", "largest eccentricity", Worst::Largest),
    ("friction_energy_J", "J", "friction energy", Worst::Largest),
    ("first_contact_s", "s", "first contact (worst: earliest)", Worst::Smallest),
    ("end_speed_rad_s", "rad/s", "end speed (worst: lowest)", Worst::Smallest),
];

/// Name of the unfavourable end of a quantity if that is the smallest value: "earliest", "lowest"; `None` if it is the largest, or unknown.
#[must_use]
pub fn worst_least(column: &str) -> Option<&'static str> {
    if column == "beyond_s" {
        return Some("earliest");
    }
    let (.., label, _) =
        QUANTITIES.iter().find(|(name, .., worst)| *name == column && matches!(worst, Worst::Smallest))?;
    let (_, end) = label.split_once("(worst: ")?;
    Some(end.trim_end_matches(')'))
}

/// Column that reports whether the twin of a run has different results.
const SENSITIVE: &str = "sensitive";

/// Columns of the values that rows not ok reached before a guard or limit was exceeded, by quantity.
const GUARDED: [Option<&str>; QUANTITIES.len()] = [
    Some("guarded_max_bearing_load_N"),
    Some("guarded_max_filtered_contact_force_N"),
    Some("guarded_max_eccentricity_m"),
    Some("guarded_friction_energy_J"),
    None,
    None,
];

/// Columns that a summary reads.
const SUMMARY_COLUMNS: [&str; 13 + QUANTITIES.len()] = [
    "sample",
    "guarded_max_bearing_load_N",
    "guarded_max_filtered_contact_force_N",
    "guarded_max_eccentricity_m",
    "guarded_friction_energy_J",
    DETECTION,
    "status",
    "cause",
    TWIN,
    "twin_status",
    "twin_bearing_load_change",
    SENSITIVE,
    TWIN_LIMIT,
    QUANTITIES[0].0,
    QUANTITIES[1].0,
    QUANTITIES[2].0,
    QUANTITIES[3].0,
    QUANTITIES[4].0,
    QUANTITIES[5].0,
];

/// Accumulator of a summary. Rows are read in several passes, so that large tables need not be in memory.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Rows by contact detection.
    groups: BTreeMap<String, Group>,
    /// Whether the table has each quantity.
    has: [bool; QUANTITIES.len()],
    rows: u64,
    twins: Twins,
}

/// Twins: second runs with a slightly different initial speed.
#[derive(Debug, Clone, Default)]
struct Twins {
    /// Rows with a twin, and rows whose twin failed.
    count: u64,
    failed: u64,
    /// `|twin_bearing_load_change|`.
    changes: Values,
    /// Shifts of the initial speed, if the table has them.
    shifts: BTreeSet<String>,
    /// Rows compared with their twin, and those that are sensitive.
    compared: u64,
    sensitive: u64,
    /// Limits of the change, if the table has them.
    limits: BTreeSet<String>,
}

/// Rows of one contact detection.
#[derive(Debug, Clone, Default)]
struct Group {
    rows: u64,
    with_contact: u64,
    /// Counts by status and cause.
    counts: Counts,
    /// Values of the rows that are ok and have the quantity.
    values: [Values; QUANTITIES.len()],
    /// Values reached by the rows that are not ok.
    reached: [Reached; QUANTITIES.len()],
}

impl Summary {
    /// Summary of the rows in these files.
    ///
    /// # Errors
    /// A table that cannot be read.
    pub fn of(files: &[PathBuf]) -> Result<Self, TableError> {
        let mut summary = Self::default();
        all_pass(files, &SUMMARY_COLUMNS, &mut summary, Self::add, Self::go_on)?;
        Ok(summary)
    }

    /// Adds the rows of a piece; later passes add only the values.
    fn add(&mut self, table: &Table, is_first: bool) {
        let detections = table.words(DETECTION).unwrap_or(&[]);
        let (status, cause) = (table.words("status").unwrap_or(&[]), table.words("cause").unwrap_or(&[]));
        let contact = table.numbers("first_contact_s").unwrap_or(&[]);
        let quantities = QUANTITIES.map(|(column, ..)| table.numbers(column));
        let (guarded, samples) =
            (GUARDED.map(|column| column.and_then(|column| table.numbers(column))), table.numbers("sample"));
        for (has, values) in self.has.iter_mut().zip(&quantities) {
            *has |= values.is_some();
        }
        let word = |words: &[Option<String>], row: usize| words.get(row).and_then(Clone::clone);
        self.twins.add(table, is_first);
        self.rows += if is_first { table.rows() as u64 } else { 0 };
        for row in 0..table.rows() {
            let name = word(detections, row).unwrap_or_else(|| "no diaphragm".to_owned());
            let group = self.groups.entry(name).or_default();
            let status = word(status, row).unwrap_or_default();
            if status == "ok" {
                for (values, column) in group.values.iter_mut().zip(&quantities) {
                    column.and_then(|column| column[row]).iter().for_each(|value| values.see(*value));
                }
            }
            if is_first && status != "ok" {
                let sample = samples.and_then(|samples| samples[row]).unwrap_or_default() as u64;
                // a table without guarded columns adds nothing
                let known =
                    group.reached.iter_mut().zip(&guarded).filter_map(|(reached, column)| Some((reached, (*column)?)));
                for (reached, column) in known {
                    reached.see(column[row], sample, &status);
                }
            }
            if is_first {
                group.rows += 1;
                group.with_contact += u64::from(contact.get(row).is_some_and(Option::is_some));
                group.counts.add(status, word(cause, row));
            }
        }
    }

    /// Ends a pass. Returns whether another pass is needed.
    fn go_on(&mut self) -> bool {
        let all = self.groups.values_mut().flat_map(|group| &mut group.values);
        all.chain([&mut self.twins.changes]).fold(false, |open, values| values.go_on() | open)
    }

    /// The summary as text; `width` limits the width of its tables.
    #[must_use]
    pub fn text(&self, width: Option<usize>) -> String {
        let mut text = self.verdicts(width);
        text.push('\n');
        text.push_str(&self.statistics(width));
        text.push_str(&reached(&self.reached()));
        text.push_str(&self.twins.text(self.rows));
        text
    }

    /// Uses `run.twin` and `run.twin_limit` of the machine if the table does not have them.
    #[must_use]
    pub fn with_twin(mut self, [shift, limit]: [f64; 2]) -> Self {
        if self.twins.shifts.is_empty() && shift > 0.0 {
            self.twins.shifts.insert(format_digits(shift, "", 3));
        }
        if self.twins.limits.is_empty() && limit > 0.0 {
            self.twins.limits.insert(percent(limit));
        }
        self
    }

    /// Text of how many runs are sensitive; `None` if no run was compared with a twin.
    #[must_use]
    pub fn sensitive(&self) -> Option<String> {
        self.twins.sensitive()
    }

    fn verdicts(&self, width: Option<usize>) -> String {
        let mut text = TextTable::new(&[
            ("detection", Align::Left),
            ("samples", Align::Right),
            ("with contact", Align::Right),
            ("ok", Align::Right),
            ("beyond", Align::Left),
            ("invalid", Align::Left),
            ("failed", Align::Left),
        ]);
        for (name, group) in &self.groups {
            text.row(vec![
                name.clone(),
                group.rows.to_string(),
                group.with_contact.to_string(),
                group.counts.ok().to_string(),
                group.counts.by_cause(&["beyond"]),
                group.counts.by_cause(&["invalid"]),
                group.counts.by_cause(&["failed", "quarantined"]),
            ]);
        }
        text.fitting("", width)
    }

    /// Values reached by rows that are not ok, for the quantities whose largest value is the worst.
    fn reached(&self) -> Vec<Line<'_>> {
        let quantities = QUANTITIES.iter().enumerate().filter(|(at, _)| self.has[*at] && GUARDED[*at].is_some());
        let lines = quantities.map(|(at, (_, unit, label, _))| {
            let groups = self.groups.iter().map(|(name, group)| {
                let most = group.values[at].figures().map(|found| found.most);
                (name.as_str(), &group.reached[at], most)
            });
            (*label, *unit, groups.collect())
        });
        lines.collect()
    }

    fn statistics(&self, width: Option<usize>) -> String {
        let mut header = vec![("ok runs: median | worst (number)", Align::Left)];
        header.extend(self.groups.keys().map(|name| (name.as_str(), Align::Right)));
        let mut text = TextTable::new(&header);
        for (at, (_, unit, label, worst)) in QUANTITIES.into_iter().enumerate() {
            if !self.has[at] {
                continue;
            }
            let mut cells = vec![label.to_owned()];
            for group in self.groups.values() {
                let found = &group.values[at];
                cells.push(match found.figures() {
                    Some(figures) => {
                        let end = match worst {
                            Worst::Largest => figures.most,
                            Worst::Smallest => figures.least,
                        };
                        let show = |value| format_digits(value, unit, 3);
                        format!("{} | {} ({})", show(figures.median), show(end), found.count())
                    }
                    None => "- (0)".to_owned(),
                });
            }
            text.row(cells);
        }
        let mut text = text.fitting("", width);
        text.push_str("Number: ok runs that have the quantity (without contact, no first contact).");
        let left_out = |(name, group): (&String, &Group)| {
            let others = group.counts.by_cause(&["beyond", "invalid", "failed", "quarantined"]);
            (others != "0").then(|| format!("{name} {others}"))
        };
        let left_out: Vec<String> = self.groups.iter().filter_map(left_out).collect();
        if left_out.is_empty() {
            text.push_str(" All runs are included.\n");
        } else {
            writeln!(text, " Not included: {}.", left_out.join("; ")).expect("writing to a String cannot fail");
        }
        text
    }
}

impl Twins {
    fn add(&mut self, table: &Table, is_first: bool) {
        let changes = table.numbers("twin_bearing_load_change").unwrap_or_default();
        changes.iter().flatten().for_each(|change| self.changes.see(change.abs()));
        if !is_first {
            return;
        }
        for word in table.words("twin_status").unwrap_or_default().iter().flatten() {
            self.count += 1;
            self.failed += u64::from(word == "failed");
        }
        let shifts = table.numbers(TWIN).unwrap_or_default().iter().flatten().filter(|shift| **shift > 0.0);
        self.shifts.extend(shifts.map(|shift| format_digits(*shift, "", 3)));
        for word in table.words(SENSITIVE).unwrap_or_default().iter().flatten() {
            self.compared += 1;
            self.sensitive += u64::from(word == "yes");
        }
        let limits = table.numbers(TWIN_LIMIT).unwrap_or_default();
        self.limits.extend(limits.iter().flatten().map(|limit| percent(*limit)));
    }

    fn sensitive(&self) -> Option<String> {
        if self.compared == 0 {
            return None;
        }
        let limits: Vec<&str> = self.limits.iter().map(String::as_str).collect();
        let limit = if limits.is_empty() { TWIN_LIMIT.to_owned() } else { limits.join(" or ") };
        let are = if self.sensitive == 1 { "is" } else { "are" };
        let (sensitive, runs) = (self.sensitive, counted(self.compared, "run"));
        Some(format!(
            "{sensitive} of {runs} with a twin {are} sensitive (a twin shifted by {TWIN} changes a result by more than {limit})."
        ))
    }

    /// "Twin runs: 5 of 108 rows, bearing load changed by up to 6 % (median 0.01 %) for 1e-6 of the initial speed."
    fn text(&self, rows: u64) -> String {
        if self.count == 0 {
            return String::new();
        }
        let mut text = format!("Twin runs: {} of {}", self.count, counted(rows, "row"));
        if self.failed > 0 {
            write!(text, ", {} of them failed", self.failed).expect("writing to a String cannot fail");
        }
        if let Some(changes) = self.changes.figures() {
            let (most, middle) = (percent(changes.most), percent(changes.median));
            let shifts: Vec<&str> = self.shifts.iter().map(String::as_str).collect();
            let shifts = if shifts.is_empty() { TWIN.to_owned() } else { shifts.join(", ") };
            write!(text, ", bearing load changed by up to {most} (median {middle}) for {shifts} of the initial speed")
                .expect("writing to a String cannot fail");
        }
        text += ".\n";
        if let Some(sensitive) = self.sensitive() {
            text += &sensitive;
            text.push('\n');
        }
        text
    }
}

/// A share in per cent, as text.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{} %", format_digits(100.0 * share, "", 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::Cells;
    use bladeoff_model::outcome::Status;

    fn table() -> Table {
        let words = |list: [Option<&str>; 4]| Cells::Words(list.map(|word| word.map(str::to_owned)).to_vec());
        Table::from_columns(
            4,
            vec![
                ("detection".into(), words([Some("hyp1"), Some("hyp1"), Some("hyp1"), Some("hyp2")])),
                ("status".into(), words([Some("ok"), Some("ok"), Some("failed"), Some("invalid")])),
                ("cause".into(), words([None, None, Some("diverged"), Some("slip_reversal")])),
                ("first_contact_s".into(), Cells::Numbers(vec![Some(0.2), None, Some(0.1), Some(0.3)])),
                ("max_bearing_load_N".into(), Cells::Numbers(vec![Some(1000.0), Some(3000.0), Some(9e9), Some(5.0)])),
            ],
        )
    }

    fn summary(table: &Table) -> String {
        let mut summary = Summary::default();
        summary.add(table, true);
        assert!(!summary.go_on(), "few are kept");
        summary.text(None)
    }

    #[test]
    fn the_worst_end_is_that_of_the_label() {
        assert_eq!(worst_least("first_contact_s"), Some("earliest"));
        assert_eq!(worst_least("end_speed_rad_s"), Some("lowest"));
        assert_eq!(worst_least("beyond_s"), Some("earliest"));
        assert_eq!((worst_least("max_bearing_load_N"), worst_least("anything")), (None, None));
    }

    #[test]
    fn a_summary_says_how_many_rows_it_covers_and_which_it_leaves_out() {
        let text = summary(&table());
        let line = |start: &str| text.lines().find(|line| line.starts_with(start)).expect("the line").to_owned();
        assert!(line("hyp1").contains("1 (1 diverged)"), "{text}");
        let load = line("largest bearing load");
        assert!(load.contains("2 kN | 3 kN (2)"), "the failed row's 9e9 N is not counted: {text}");
        assert!(load.ends_with("- (0)"), "no ok row with hyp2: {text}");
        assert!(line("first contact").contains("0.2 s | 0.2 s (1)"), "{text}");
        assert!(text.contains("Not included: hyp1 1 (1 diverged); hyp2 1 (1 slip_reversal)."), "{text}");
    }

    /// A run that whirls backward at 9 MN is in the summary, whatever its status.
    #[test]
    fn what_rows_that_are_not_ok_had_reached_is_there() {
        let words = |list: [&str; 4]| Cells::Words(list.map(|word| Some(word.to_owned())).to_vec());
        let columns = vec![
            ("sample".into(), Cells::Numbers([3.0, 4.0, 5.0, 6.0].map(Some).to_vec())),
            ("status".into(), words(["ok", "invalid", "beyond", "quarantined"])),
            ("max_bearing_load_N".into(), Cells::Numbers(vec![Some(588e3), Some(2e7), Some(4e5), None])),
            ("guarded_max_bearing_load_N".into(), Cells::Numbers(vec![None, Some(9e6), Some(3e5), None])),
        ];
        let text = summary(&Table::from_columns(4, columns));
        let said = "  largest bearing load: 9 MN (no diaphragm, sample 4, invalid); more than the worst ok run, 588 kN";
        assert!(text.lines().any(|line| line == said), "{text}");
        assert!(text.contains("  1 run has no such value\n"), "{text}");
        assert!(text.contains("588 kN | 588 kN (1)"), "the ok ones are apart: {text}");
        let none = Table::from_columns(1, vec![("status".into(), Cells::Words(vec![Some("ok".to_owned())]))]);
        assert!(!summary(&none).contains("not ok"), "all are");
    }

    /// The verdict table has one column for each status; quarantined rows are counted with failed ones.
    #[test]
    fn every_status_has_its_column() {
        let rows = Status::ALL.len();
        let words =
            |list: Vec<Option<&str>>| Cells::Words(list.into_iter().map(|word| word.map(str::to_owned)).collect());
        let status = Status::ALL.iter().map(|status| Some(status.word())).collect();
        let causes = Status::ALL.iter().map(|status| (*status != Status::Ok).then_some(status.word())).collect();
        let columns = vec![("status".into(), words(status)), ("cause".into(), words(causes))];
        let text = summary(&Table::from_columns(rows, columns));
        let line = text.lines().find(|line| line.starts_with("no diaphragm")).expect("the line");
        for status in Status::ALL.iter().filter(|status| **status != Status::Ok) {
            assert!(line.contains(&format!("1 {}", status.word())), "{}: {line}", status.word());
        }
        assert!(text.lines().next().is_some_and(|head| head.contains("ok") && head.contains("beyond")), "{text}");
        assert!(text.contains(&format!("Not included: no diaphragm {}", rows - 1)), "{text}");
    }

    #[test]
    fn twins_say_how_far_a_small_shift_moves_a_load() {
        assert!(!summary(&table()).contains("Twin"), "there are none");
        let words = |list: [Option<&str>; 4]| Cells::Words(list.map(|word| word.map(str::to_owned)).to_vec());
        let with = |shift: Option<f64>| {
            let mut columns = vec![
                ("status".into(), words([Some("ok"); 4])),
                ("twin_status".into(), words([Some("ok"), None, Some("failed"), Some("ok")])),
                ("twin_bearing_load_change".into(), Cells::Numbers(vec![Some(-0.06), None, None, Some(1e-6)])),
                ("sensitive".into(), words([Some("yes"), None, None, Some("no")])),
            ];
            if shift.is_some() {
                columns.push((TWIN.into(), Cells::Numbers(vec![shift, Some(0.0), shift, shift])));
                columns.push((TWIN_LIMIT.into(), Cells::Numbers(vec![Some(0.05); 4])));
            }
            let mut summary = Summary::default();
            summary.add(&Table::from_columns(4, columns), true);
            assert!(!summary.go_on(), "few are kept");
            summary.with_twin([2e-6, 0.02]).text(None)
        };
        let said = "Twin runs: 3 of 4 rows, 1 of them failed, bearing load changed by up to 6 % (median 3 %) for";
        let (own, machine) = (with(Some(1e-6)), with(None));
        assert!(own.contains(&format!("{said} 1e-6 of the initial speed.")), "{own}");
        let sensitive =
            "1 of 2 runs with a twin is sensitive (a twin shifted by run.twin changes a result by more than";
        assert!(own.contains(&format!("{sensitive} 5 %).")), "{own}");
        assert!(machine.contains(&format!("{sensitive} 2 %).")), "{machine}");
        assert!(machine.contains(&format!("{said} 2e-6 of the initial speed.")), "{machine}");
    }

    #[test]
    fn a_table_without_ok_rows_does_not_panic() {
        let empty = Table::from_columns(0, Vec::new());
        assert!(summary(&empty).contains("detection"));
    }
}
