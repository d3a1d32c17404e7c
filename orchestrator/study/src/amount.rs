//! Times and sizes as people write them: "8h", "90 min", "2 GB".

use bladeoff_model::document::cut;
use bladeoff_model::document::units::parse_bare_or_quantity;
use std::time::Duration;

/// Longest time that makes sense, about thirty years \[s\].
const LONGEST: f64 = 1e9;
/// Units of memory, by name.
const SIZES: [(&str, u64); 7] = [
    ("kB", 1_000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
    ("KiB", 1 << 10),
    ("MiB", 1 << 20),
    ("GiB", 1 << 30),
    ("B", 1),
];

/// A time with its unit, or in seconds.
///
/// # Errors
/// What is wrong with the text.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let seconds = parse_bare_or_quantity(text, "s").map_err(|error| error.to_string())?;
    if seconds > 0.0 && seconds <= LONGEST {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!("{:?} is not a time above 0 and up to {LONGEST:e} s", cut(text, 40)))
    }
}

/// A number of bytes with its unit.
///
/// # Errors
/// What is wrong with the text.
pub fn parse_memory(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let shown = cut(text, 40);
    let wrong = || format!("{shown:?} is not a size such as 500 MB or 2 GB (units: B, kB, MB, GB, KiB, MiB, GiB)");
    let (number, factor) =
        SIZES.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, *factor))).ok_or_else(wrong)?;
    let bytes = number.trim_end().parse::<f64>().map_err(|_| wrong())? * factor as f64;
    // A worker that may allocate nothing cannot start.
    if (1e6..=1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(format!("{shown:?} is not a size from 1 MB on")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_units() {
        let seconds = |text: &str| parse_duration(text).map(|time| time.as_secs());
        assert_eq!(seconds("8h"), Ok(8 * 3600));
        assert_eq!(seconds("90 min"), Ok(5400));
        assert_eq!(seconds("45"), Ok(45));
        for text in ["", "0", "-1 h", "8 hours", "8 m", "nan", "inf", "1e99 h", "1e300"] {
            assert!(parse_duration(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_read_with_their_units() {
        assert_eq!(parse_memory("2GB"), Ok(2_000_000_000));
        assert_eq!(parse_memory("1.5 MiB"), Ok(3 << 19));
        for text in ["", "2", "2 G", "GB", "-2 GB", "1 kB", "inf GB", "1e30 GB"] {
            assert!(parse_memory(text).is_err(), "{text}");
        }
    }
}
