//! The clocks of the system, where the standard library has none: time since the machine was started, the local time of the day.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::schedule::{Moment, TimeOfDay, Until};

/// What the clocks say.
pub(super) fn now() -> Moment {
    let wall = match SystemTime::now().duration_since(UNIX_EPOCH) {
        Ok(since) => i64::try_from(since.as_millis()).unwrap_or(i64::MAX / 4),
        Err(before) => -i64::try_from(before.duration().as_millis()).unwrap_or(i64::MAX / 4),
    };
    Moment { boot: boot(), wall }
}

/// The next time that the local clock shows `time`.
#[must_use]
pub fn next(time: TimeOfDay) -> Until {
    Until::next(time, now(), local)
}

/// How long it is until then.
#[must_use]
pub fn left(until: &Until) -> Duration {
    Duration::from_millis(u64::try_from(until.left(now())).unwrap_or(0))
}

#[expect(unsafe_code, reason = "the standard library has no clock that counts the machine's sleep")]
fn boot() -> i64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a valid timespec that outlives the call, which writes to nothing else.
    let _ = unsafe { libc::clock_gettime(libc::CLOCK_BOOTTIME, &raw mut time) };
    time.tv_sec * 1000 + time.tv_nsec / 1_000_000
}

/// The moment of a time of the day by the system's time zone, summer time included.
#[expect(unsafe_code, reason = "the standard library knows no time zones")]
fn local(wall: i64, days: i32, time: TimeOfDay) -> i64 {
    let seconds: libc::time_t = wall.div_euclid(1000);
    // SAFETY: all bytes zero is a valid `tm`: integers and a null pointer that nobody follows.
    let mut date: libc::tm = unsafe { std::mem::zeroed() };
    // SAFETY: both pointers are valid for the calls, which write to `date` alone; the environment is never changed by us.
    unsafe {
        if libc::localtime_r(&raw const seconds, &raw mut date).is_null() {
            return wall;
        }
        date.tm_mday += days;
        (date.tm_hour, date.tm_min, date.tm_sec) =
            (i32::from(time.hour), i32::from(time.minute), i32::from(time.second));
        // Whether summer time holds then is for the system to say.
        date.tm_isdst = -1;
        libc::mktime(&raw mut date) * 1000
    }
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
    fn a_day_later_is_a_day_later() {
        let time = TimeOfDay { hour: 12, minute: 0, second: 0 };
        let wall = now().wall;
        let day = local(wall, 1, time) - local(wall, 0, time);
        assert!((23 * 3_600_000..=25 * 3_600_000).contains(&day), "{day}");
    }
}
