//! Header cells of a table: units in brackets after names (`gap [mm]`), and files whose first line has numbers instead of names.

use super::csv::Cell;
use bladeoff_text::document::Collector;
use bladeoff_text::document::units::{parse_quantity, unit_of};
use std::borrow::Cow;

/// Reports a header that consists of numbers, as in tables from numpy or SALib. Returns whether that is the case.
pub(super) fn refuse_numbers(header: &[Cell<'_>], problems: &mut Collector<'_>) -> bool {
    let (Some(first), Some(last)) = (header.first(), header.last()) else { return false };
    let is_missing = header.iter().all(|cell| cell.text.parse::<f64>().is_ok());
    if is_missing {
        let message = "the first line holds numbers: a header line with the name of each column is missing";
        problems.add(first.span.start..last.span.end, "", message).allowed =
            Some("a first line of parameter paths, in the order of the columns".to_owned());
    }
    is_missing
}

/// Name and unit of a header cell such as `gap [mm]` or `gap (mm)`.
pub(super) fn name_and_unit(cell: &str) -> Option<(&str, &str)> {
    [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
        let (name, unit) = cell.strip_suffix(close)?.rsplit_once(open)?;
        (!name.trim().is_empty()).then(|| (name.trim_end(), unit.trim()))
    })
}

/// The unit of a header cell, for a column with the SI unit `si`; "" for a pure number (`[-]`).
///
/// # Errors
/// The problem with the unit, and the unit most likely meant.
pub(super) fn unit_for(unit: &str, si: &'static str) -> Result<String, (String, Option<String>)> {
    match unit {
        "" | "-" | "1" if unit.is_empty() || si.is_empty() => Ok(String::new()),
        _ => match parse_quantity(&format!("1 {unit}"), si) {
            Ok(_) => Ok(unit.to_owned()),
            Err(error) => Err(error.parts()),
        },
    }
}

/// A cell with the unit of its header, unless the cell is a word or has a unit.
pub(super) fn with_unit<'c>(cell: Cow<'c, str>, unit: &str) -> Cow<'c, str> {
    let is_bare = unit_of(&cell).is_empty() && cell.contains(|c: char| c.is_ascii_digit());
    if unit.is_empty() || !is_bare { cell } else { Cow::Owned(format!("{cell} {unit}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_in_brackets_is_apart_from_the_name() {
        for (cell, parts) in [
            ("contact.gap [mm]", Some(("contact.gap", "mm"))),
            ("contact.gap(mm)", Some(("contact.gap", "mm"))),
            ("friction [-]", Some(("friction", "-"))),
            ("stiffness[0][1]", Some(("stiffness[0]", "1"))),
            ("inertia [kg (m2)]", Some(("inertia", "kg (m2)"))),
            ("gap_m", None),
            ("[mm]", None),
            ("gap [mm", None),
        ] {
            assert_eq!(name_and_unit(cell), parts, "{cell}");
        }
    }

    #[test]
    fn a_bare_number_takes_the_unit_of_its_header() {
        for (cell, unit, shown) in [
            ("0.4", "mm", "0.4 mm"),
            ("4 m", "mm", "4 m"),
            ("hyp1", "mm", "hyp1"),
            ("0.4", "", "0.4"),
            ("1e-3", "m", "1e-3 m"),
        ] {
            assert_eq!(with_unit(Cow::Borrowed(cell), unit), shown);
        }
        assert_eq!(unit_for("mm", "m"), Ok("mm".to_owned()));
        assert_eq!(unit_for("-", ""), Ok(String::new()));
        assert_eq!(unit_for("", "m"), Ok(String::new()));
        for (unit, si, part) in
            [("kg", "m", "does not fit"), ("-", "m", "cannot be read"), ("inch", "m", "unknown unit")]
        {
            assert!(unit_for(unit, si).is_err_and(|(message, _)| message.contains(part)), "{unit}");
        }
    }
}
