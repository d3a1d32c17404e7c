//! `kind = "table"` of a bearing: its lists, and the speeds that a run needs.

use super::path::below;
use super::reader::Reader;
use crate::machine::bearing_table::{BearingTable, COEFFICIENTS, Interpolation};
use bladeoff_text::document::units::format_digits;

/// Smallest ratio of a table's highest speed to the largest speed of a run: an unbalance makes the speed fluctuate.
const MARGIN: f64 = 1.05;
/// Keys of the coefficients, and whether a table requires them.
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

/// The table of a bearing; `None`: a problem was reported.
pub(super) fn bearing_table(reader: &mut Reader<'_>, bearing: &str) -> Option<BearingTable> {
    let (table, file) = (below(bearing, "coefficients"), below(bearing, "table"));
    let table = &*table;
    // readers of machine files replace the file's name by the lists
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
    check_range(reader, bearing, &speeds)?;
    Some(BearingTable::new(speeds, values, interpolation))
}

/// A list of the table; empty: not given; `None`: invalid, which has been reported.
fn list(reader: &mut Reader<'_>, table: &str, key: &'static str, is_needed: bool) -> Option<Vec<f64>> {
    let path = below(table, key);
    let found = reader.list(&path)?;
    if found.is_empty() && is_needed {
        reader.missing_here(&path, &format!("rotor.bearings.NAME.coefficients.{key}"));
        return None;
    }
    Some(found)
}

/// Checks that the table covers the speeds of the run, from the initial speed down to the end speed. A problem is reported at the speed of the
/// run, because the lists of a separate table file are not in the machine file that the user sees.
fn check_range(reader: &mut Reader<'_>, bearing: &str, speeds: &[f64]) -> Option<()> {
    let (low, high) = (speeds[0], speeds[speeds.len() - 1]);
    let shown = |speed: f64| format_digits(speed, "rad/s", 6);
    let end = reader.number("run.end_speed")?;
    if low > end {
        let message = format!("the run may fall below the table of {bearing}, which begins at {}", shown(low));
        reader.fail("run.end_speed", message, format!("at least {}, or a table from {}", shown(low), shown(end)));
        return None;
    }
    let law = reader.list("rotor.speed_law.speeds").unwrap_or_default();
    let initial = reader.number("rotor.initial_speed")?;
    let acceleration = reader.number("rotor.speed_law.acceleration").unwrap_or(0.0);
    let accelerated = initial + acceleration * reader.number("run.end_time")?;
    let largest = law.into_iter().chain([accelerated]).fold(initial, f64::max);
    let needed = MARGIN * largest;
    if high < needed {
        let key = match largest {
            largest if largest == initial => "rotor.initial_speed",
            largest if largest == accelerated => "rotor.speed_law.acceleration",
            _ => "rotor.speed_law.speeds",
        };
        let message = format!(
            "the table of {bearing} ends at {}, below {}, which is {MARGIN} times the largest speed of the run, {}",
            shown(high),
            shown(needed),
            shown(largest)
        );
        let allowed =
            format!("a largest speed of at most {}, or a table up to {}", shown(high / MARGIN), shown(needed));
        reader.fail(key, message, allowed);
        return None;
    }
    Some(())
}
