//! The summary of a result table: what became of the samples, and the main quantities, by contact detection.
//!
//! Statistics are over `ok` rows that have the quantity; how many those are stands beside them, and what they leave
//! out is listed. A failed or invalid row never drops out without a word.

use super::text::{Align, TextTable};
use crate::results::{DETECTION, Table};
use bladeoff_core::document::units::format_digits;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Which end of a quantity is the bad one.
#[derive(Clone, Copy)]
enum Worst {
    Largest,
    Smallest,
}

/// The main quantities: column, SI unit, label, bad end.
const QUANTITIES: [(&str, &str, &str, Worst); 6] = [
    ("max_bearing_load_N", "N", "largest bearing load", Worst::Largest),
    ("max_filtered_contact_force_N", "N", "largest contact force (1 ms mean)", Worst::Largest),
    ("max_eccentricity_m", "m", "largest eccentricity", Worst::Largest),
    ("friction_energy_J", "J", "friction energy", Worst::Largest),
    ("first_contact_s", "s", "first contact (worst: earliest)", Worst::Smallest),
    ("end_speed_rad_s", "rad/s", "end speed (worst: lowest)", Worst::Smallest),
];

/// Rows of one detection.
struct Group {
    name: String,
    rows: Vec<usize>,
}

/// The summary as text.
#[must_use]
pub fn summary(table: &Table) -> String {
    let mut groups: Vec<Group> = Vec::new();
    let detections = table.words(DETECTION);
    for row in 0..table.rows() {
        let name = detections.and_then(|words| words[row].clone()).unwrap_or_else(|| "no diaphragm".to_owned());
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.rows.push(row),
            None => groups.push(Group { name, rows: vec![row] }),
        }
    }
    groups.sort_by(|a, b| a.name.cmp(&b.name));
    let mut text = verdicts(table, &groups);
    text.push('\n');
    text.push_str(&statistics(table, &groups));
    text
}

fn status(table: &Table, row: usize) -> &str {
    table.words("status").and_then(|words| words[row].as_deref()).unwrap_or("")
}

/// "2 (2 slip_reversal)" of the group's rows of these statuses.
fn by_cause(table: &Table, rows: &[usize], statuses: &[&str]) -> String {
    let mut causes: BTreeMap<&str, usize> = BTreeMap::new();
    let mut total = 0;
    for &row in rows.iter().filter(|&&row| statuses.contains(&status(table, row))) {
        total += 1;
        let cause = table.words("cause").and_then(|words| words[row].as_deref());
        *causes.entry(cause.unwrap_or("no cause")).or_default() += 1;
    }
    if total == 0 {
        return "0".to_owned();
    }
    let named: Vec<String> = causes.iter().map(|(cause, count)| format!("{count} {cause}")).collect();
    format!("{total} ({})", named.join(", "))
}

fn verdicts(table: &Table, groups: &[Group]) -> String {
    let mut text = TextTable::new(&[
        ("detection", Align::Left),
        ("samples", Align::Right),
        ("with contact", Align::Right),
        ("ok", Align::Right),
        ("invalid", Align::Left),
        ("failed", Align::Left),
    ]);
    for group in groups {
        let contact = table.numbers("first_contact_s").unwrap_or(&[]);
        let with_contact = group.rows.iter().filter(|&&row| contact.get(row).is_some_and(Option::is_some)).count();
        text.row(vec![
            group.name.clone(),
            group.rows.len().to_string(),
            with_contact.to_string(),
            group.rows.iter().filter(|&&row| status(table, row) == "ok").count().to_string(),
            by_cause(table, &group.rows, &["invalid"]),
            by_cause(table, &group.rows, &["failed", "quarantined"]),
        ]);
    }
    text.render("")
}

fn statistics(table: &Table, groups: &[Group]) -> String {
    let mut header = vec![("median | worst (rows)", Align::Left)];
    header.extend(groups.iter().map(|group| (group.name.as_str(), Align::Right)));
    let mut text = TextTable::new(&header);
    for (column, unit, label, worst) in QUANTITIES {
        let Some(values) = table.numbers(column) else { continue };
        let mut cells = vec![label.to_owned()];
        for group in groups {
            let ok = group.rows.iter().filter(|&&row| status(table, row) == "ok");
            let mut found: Vec<f64> = ok.filter_map(|&row| values[row]).collect();
            found.sort_by(f64::total_cmp);
            cells.push(match (found.first(), found.last()) {
                (Some(&least), Some(&most)) => {
                    let end = match worst {
                        Worst::Largest => most,
                        Worst::Smallest => least,
                    };
                    let show = |value| format_digits(value, unit, 3);
                    format!("{} | {} ({})", show(median(&found)), show(end), found.len())
                }
                _ => "- (0)".to_owned(),
            });
        }
        text.row(cells);
    }
    let mut text = text.render("");
    text.push_str("Rows: those with status ok that have the quantity (no first contact without contact).");
    let left_out = |group: &Group| {
        let others = by_cause(table, &group.rows, &["invalid", "failed", "quarantined"]);
        (others != "0").then(|| format!("{} {others}", group.name))
    };
    let left_out: Vec<String> = groups.iter().filter_map(left_out).collect();
    if left_out.is_empty() {
        text.push_str(" No row is left out.\n");
    } else {
        writeln!(text, " Left out: {}.", left_out.join("; ")).expect("writing to a String cannot fail");
    }
    text
}

/// Median of sorted numbers, at least one.
fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Cells;

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

    #[test]
    fn a_summary_says_how_many_rows_it_covers_and_which_it_leaves_out() {
        let text = summary(&table());
        let line = |start: &str| text.lines().find(|line| line.starts_with(start)).expect("the line").to_owned();
        assert!(line("hyp1").contains("1 (1 diverged)"), "{text}");
        let load = line("largest bearing load");
        assert!(load.contains("2 kN | 3 kN (2)"), "the failed row's 9e9 N is not counted: {text}");
        assert!(load.ends_with("- (0)"), "no ok row with hyp2: {text}");
        assert!(line("first contact").contains("0.2 s | 0.2 s (1)"), "{text}");
        assert!(text.contains("Left out: hyp1 1 (1 diverged); hyp2 1 (1 slip_reversal)."), "{text}");
    }

    #[test]
    fn a_table_without_ok_rows_does_not_panic() {
        let empty = Table::from_columns(0, Vec::new());
        assert!(summary(&empty).contains("detection"));
    }
}
