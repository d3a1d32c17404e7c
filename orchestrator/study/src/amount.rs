//! Times and sizes in common notations: "8h", "90 min", "2 GB".

use bladeoff_text::document::cut;
use bladeoff_text::document::units::parse_bare_or_quantity;
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

/// Reads a time: with its unit (`8h`), with several units (`1h30m`, `1d 12h`), in clock notation (`08:00:00`, `1-00:00:00`), or in seconds.
///
/// # Errors
/// Error of the text.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let known = match clock(text.trim()) {
        Some(clock) => Some(clock?),
        None => of_units(text.trim()),
    };
    let in_one_unit = || parse_bare_or_quantity(text, "s").map_err(|error| error.to_string());
    let seconds = known.map_or_else(in_one_unit, Ok)?;
    if seconds > 0.0 && seconds <= LONGEST {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!("{:?} is not a time above 0 and up to {LONGEST:e} s", cut(text, 40)))
    }
}

/// Reads the time of a scheduler's task, as [`parse_duration`], but rejects a number without a unit: some schedulers use minutes, others seconds.
///
/// # Errors
/// Describes the mistake in the text.
pub fn parse_task_time(text: &str) -> Result<Duration, String> {
    let time = parse_duration(text)?;
    if text.trim().parse::<f64>().is_ok() {
        let number = cut(text.trim(), 40);
        return Err(format!("{number} has no unit; write {number}min or {number}s"));
    }
    Ok(time)
}

/// Seconds of `HH:MM:SS`, `D-HH`, `D-HH:MM` and `D-HH:MM:SS`; `None` for any other text.
fn clock(text: &str) -> Option<Result<f64, String>> {
    let (days, clock) = text.split_once('-').map_or((None, text), |(days, clock)| (Some(days), clock));
    let number = |text: &str| text.parse::<u32>().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()));
    let parts: Vec<u32> = clock.split(':').map(number).collect::<Option<_>>()?;
    let whole = match (days.map(number), &parts[..]) {
        (None, [_]) => return None,
        (None, [_, _]) => {
            return Some(Err(format!("{text:?} can mean minutes and seconds or hours and minutes; write HH:MM:SS")));
        }
        (None, [hours, minutes, seconds]) => [0, *hours, *minutes, *seconds],
        (Some(Some(days)), [hours]) => [days, *hours, 0, 0],
        (Some(Some(days)), [hours, minutes]) => [days, *hours, *minutes, 0],
        (Some(Some(days)), [hours, minutes, seconds]) => [days, *hours, *minutes, *seconds],
        _ => return None,
    };
    let [days, hours, minutes, seconds] = whole.map(f64::from);
    Some(Ok(((days * 24.0 + hours) * 60.0 + minutes) * 60.0 + seconds))
}

/// Seconds of numbers with the units d, h, min and s, in this order; `m` means minutes after one of the first two. `None` for any other text.
fn of_units(text: &str) -> Option<f64> {
    let (mut seconds, mut last, mut rest) = (0.0, f64::INFINITY, text);
    while !rest.is_empty() || last.is_infinite() {
        let number = rest.find(|c: char| !c.is_ascii_digit() && c != '.')?;
        let (number, behind) = rest.split_at(number);
        let behind = behind.trim_start();
        let (unit, behind) = behind.split_at(behind.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(behind.len()));
        let unit = match unit {
            "d" => 86_400.0,
            "h" => 3600.0,
            "min" => 60.0,
            "m" if last.is_finite() => 60.0,
            "s" => 1.0,
            _ => return None,
        };
        if unit >= last {
            return None;
        }
        seconds += number.parse::<f64>().ok()? * unit;
        (last, rest) = (unit, behind.trim_start());
    }
    Some(seconds)
}

/// A number of bytes with its unit.
///
/// # Errors
/// Error of the text.
pub fn parse_memory(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let shown = cut(text, 40);
    let wrong = || format!("{shown:?} is not a size such as 500 MB or 2 GB (units: B, kB, MB, GB, KiB, MiB, GiB)");
    let (number, factor) =
        SIZES.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, *factor))).ok_or_else(wrong)?;
    let bytes = number.trim_end().parse::<f64>().map_err(|_| wrong())? * factor as f64;
    // A worker that may allocate nothing cannot start.
    if (1e6..=1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err(format!("{shown:?} is below 1 MB, the smallest size"))
    }
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
        assert_eq!(
            ["1d", "1h30m", "1 h 30 min", "1d12h", "1.5h"].map(seconds),
            [86_400, 5400, 5400, 129_600, 5400].map(Ok)
        );
        assert_eq!(["08:00:00", "1-00:00:00", "1-12", "0-00:30"].map(seconds), [28_800, 86_400, 129_600, 1800].map(Ok));
        assert!(parse_duration("08:00").is_err_and(|error| error.contains("write HH:MM:SS")));
        for text in [
            "",
            "0",
            "-1 h",
            "8 hours",
            "8 m",
            "nan",
            "inf",
            "1e99 h",
            "1e300",
            "1h1h",
            "30m1h",
            "1:2:3:4",
            "-1:00:00",
            "1-",
            "99999999999-00",
            "1.2.3h",
        ] {
            assert!(parse_duration(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_time_of_a_task_has_a_unit() {
        assert_eq!(parse_task_time("8h"), parse_duration("8h"));
        assert_eq!(parse_task_time("480"), Err("480 has no unit; write 480min or 480s".to_owned()));
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
