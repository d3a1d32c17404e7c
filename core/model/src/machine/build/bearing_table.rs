//! `kind = "table"` of a bearing: its lists, and the speeds that a run needs.

use super::path::below;
use super::reader::Reader;
use crate::machine::bearing_table::{BearingTable, COEFFICIENTS, Interpolation};
use bladeoff_text::document::units::format_digits;

/// Largest initial speed over the highest speed of a table that a run may start with: an unbalance makes the speed swing.
const MARGIN: f64 = 1.05;
/// Keys of the coefficients, and whether a table needs them.
const KEYS: [(&str, bool); COEFFICIENTS] = [
    ("kxx", true),
    ("kxy", false),
    ("kyx", false),
    ("kyy", true),
    ("cxx", false),
    ("cxy", false),
    ("cyx", false),
    ("cyy", false),
];

/// The table of a bearing; `None`: something was reported.
pub(super) fn bearing_table(reader: &mut Reader<'_>, bearing: &str) -> Option<BearingTable> {
    let (table, file) = (below(bearing, "coefficients"), below(bearing, "table"));
    let table = &*table;
    // who reads machine files puts the lists in the place of the file's name
    if reader.text(&file).is_some() {
        reader.fail(
            &file,
            "the file of the table has not been read",
            "a CSV file beside the machine file, or lists in coefficients",
        );
        return None;
    }
    let speeds = list(reader, table, "speeds", true)?;
    let path = below(table, "speeds");
    if speeds.len() < 2 || speeds.windows(2).any(|pair| pair[0] >= pair[1]) {
        reader.fail(&path, "not a list of ascending speeds", "two or more speeds, each above the one before");
        return None;
    }
    let factors =
        [reader.number(&below(bearing, "stiffness_factor"))?, reader.number(&below(bearing, "damping_factor"))?];
    let interpolation = if reader.word(&below(bearing, "interpolation"))? == "pchip" {
        Interpolation::Pchip
    } else {
        Interpolation::Linear
    };
    let mut values = vec![[0.0; COEFFICIENTS]; speeds.len()];
    let mut complete = true;
    for (place, (key, is_needed)) in KEYS.into_iter().enumerate() {
        let Some(column) = list(reader, table, key, is_needed) else {
            complete = false;
            continue;
        };
        if !column.is_empty() && column.len() != speeds.len() {
            let message = format!("{} values for {} speeds", column.len(), speeds.len());
            reader.fail(&below(table, key), message, "one value for each of speeds");
            complete = false;
            continue;
        }
        for (value, entry) in values.iter_mut().zip(column) {
            value[place] = factors[place / 4] * entry;
        }
    }
    if !complete {
        return None;
    }
    check_range(reader, &path, &speeds)?;
    Some(BearingTable::new(speeds, values, interpolation))
}

/// A list of the table; empty: not given; `None`: reported.
fn list(reader: &mut Reader<'_>, table: &str, key: &'static str, is_needed: bool) -> Option<Vec<f64>> {
    let path = below(table, key);
    let found = reader.list(&path)?;
    if found.is_empty() && is_needed {
        reader.missing_here(&path, &format!("rotor.bearings.NAME.coefficients.{key}"));
        return None;
    }
    Some(found)
}

/// The table covers the speeds of the run, which falls from its initial speed to its end speed.
fn check_range(reader: &mut Reader<'_>, path: &str, speeds: &[f64]) -> Option<()> {
    let (low, high) = (speeds[0], speeds[speeds.len() - 1]);
    let shown = |speed: f64| format_digits(speed, "rad/s", 6);
    let end = reader.number("run.end_speed")?;
    if low > end {
        let message = format!("the table begins at {}, the run may fall to run.end_speed = {}", shown(low), shown(end));
        reader.fail(path, message, format!("a first speed of at most {}, or a higher run.end_speed", shown(end)));
        return None;
    }
    let law = reader.list("rotor.speed_law.speeds").unwrap_or_default();
    let initial = reader.number("rotor.initial_speed")?;
    let acceleration = reader.number("rotor.speed_law.acceleration").unwrap_or(0.0);
    let accelerated = initial + acceleration * reader.number("run.end_time")?;
    let largest = law.into_iter().chain([accelerated]).fold(initial, f64::max);
    if high < MARGIN * largest {
        let message = format!("the table ends at {}, the run reaches {}", shown(high), shown(largest));
        reader.fail(
            path,
            message,
            format!("a last speed of at least {}, 1.05 times the largest speed", shown(MARGIN * largest)),
        );
        return None;
    }
    Some(())
}
