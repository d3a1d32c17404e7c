//! Clocks that the standard library lacks: time since the start of the machine, local time of day.

use crate::schedule::{Moment, TimeOfDay, Until};
use jiff::tz::TimeZone;
use jiff::{Timestamp, ToSpan, civil};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Reads the clocks.
pub(super) fn now() -> Moment {
    let wall = match SystemTime::now().duration_since(UNIX_EPOCH) {
        Ok(since) => i64::try_from(since.as_millis()).unwrap_or(i64::MAX / 4),
        Err(before) => -i64::try_from(before.duration().as_millis()).unwrap_or(i64::MAX / 4),
    };
    Moment { boot: boot(), wall }
}

/// Next time at which the local clock shows `time`.
#[must_use]
pub fn next(time: TimeOfDay) -> Until {
    Until::next(time, now(), local)
}

/// Duration until then.
#[must_use]
pub fn left(until: &Until) -> Duration {
    Duration::from_millis(u64::try_from(until.left(now())).unwrap_or(0))
}

/// Milliseconds since the machine was started, including sleep.
fn boot() -> i64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
    time.tv_sec * 1000 + time.tv_nsec / 1_000_000
}

/// Time of a time of day in the system's time zone, including summer time.
fn local(wall: i64, days: i32, time: TimeOfDay) -> i64 {
    moment_in(&TimeZone::system(), wall, days, time).unwrap_or(wall)
}

/// Time of a time of day in a zone, a given number of days after the date of another time. A time of day that summer time skips is as long after
/// midnight as on other days, so the clock shows an hour later.
fn moment_in(zone: &TimeZone, wall: i64, days: i32, time: TimeOfDay) -> Result<i64, jiff::Error> {
    let date = Timestamp::from_millisecond(wall)?.to_zoned_datetime(zone.clone()).date();
    let of_day = civil::time(time.hour as i8, time.minute as i8, time.second as i8, 0);
    let at = date.checked_add(days.days())?.to_datetime(of_day);
    Ok(at.to_zoned_datetime(zone.clone())?.timestamp().as_millisecond())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_occurrence_of_any_time_is_within_a_day() {
        for hour in 0..24 {
            let now = now();
            let left = Until::next(TimeOfDay { hour, minute: 30, second: 0 }, now, local).left(now);
            // 25 hours on the day on which summer time ends.
            assert!((1..=25 * 3_600_000).contains(&left), "{hour}: {left}");
        }
        assert!(now().boot > 0);
    }

    #[test]
    fn summer_time_changes_the_length_of_a_day() {
        let zone = TimeZone::posix("CET-1CEST,M3.5.0,M10.5.0/3").expect("a zone");
        let at = |wall: &str, days, hour| {
            let wall = wall.parse::<Timestamp>().expect("a moment").as_millisecond();
            let moment = moment_in(&zone, wall, days, TimeOfDay { hour, minute: 30, second: 0 }).expect("a moment");
            Timestamp::from_millisecond(moment).expect("in range").to_string()
        };
        assert_eq!(at("2026-03-28T12:00:00Z", 0, 6), "2026-03-28T05:30:00Z");
        // 23 hours later
        assert_eq!(at("2026-03-28T12:00:00Z", 1, 6), "2026-03-29T04:30:00Z");
        // 02:30 does not exist on that day; the clock shows 03:30
        assert_eq!(at("2026-03-28T12:00:00Z", 1, 2), "2026-03-29T01:30:00Z");
        // 25 hours later; of the two 02:30s the first
        assert_eq!(at("2026-10-24T12:00:00Z", 1, 6), "2026-10-25T05:30:00Z");
        assert_eq!(at("2026-10-24T12:00:00Z", 1, 2), "2026-10-25T00:30:00Z");
        // the local date applies: 23:30 UTC is the next day there
        assert_eq!(at("2026-03-28T23:30:00Z", 0, 6), "2026-03-29T04:30:00Z");
    }

    #[test]
    fn a_day_later_is_a_day_later() {
        let time = TimeOfDay { hour: 12, minute: 0, second: 0 };
        let wall = now().wall;
        let day = local(wall, 1, time) - local(wall, 0, time);
        assert!((23 * 3_600_000..=25 * 3_600_000).contains(&day), "{day}");
    }
}
