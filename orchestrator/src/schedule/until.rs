//! `--until 06:30`: end of a run by the wall clock, also when that clock is set.
//!
//! The boot clock counts real time, sleep of the machine included, and cannot be set. While the difference of both clocks stays
//! the same, the run ends when the wall clock shows the time, also if this is noticed after a sleep. When the difference changes
//! by [`SET`] or more, the wall clock was set and the new one counts: the run ends at the 06:30 that is nearest to the planned
//! end. So no change, of a minute or of fifty years, moves the end by more than about half a day, and a clock set from 6:00 to
//! 6:45 ends the run instead of prolonging it to the next day.

use std::str::FromStr;

/// A smaller difference is drift and slewing.
const SET: i64 = 60_000;

/// A time of the day by the local clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeOfDay {
    /// 0 to 23.
    pub hour: u8,
    /// 0 to 59.
    pub minute: u8,
    /// 0 to 59.
    pub second: u8,
}

/// Error of a text that is not a time of day.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is not a time of day such as 06:30 or 22:15:30")]
pub struct TimeOfDayError {
    /// The text.
    pub text: String,
}

impl FromStr for TimeOfDay {
    type Err = TimeOfDayError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = || TimeOfDayError { text: text.chars().take(40).collect() };
        let number = |part: &str, most: u8| {
            let is_plain = (1..=2).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_digit());
            part.parse::<u8>().ok().filter(|number| is_plain && *number <= most).ok_or_else(wrong)
        };
        let parts: Vec<&str> = text.trim().split(':').collect();
        let (hour, minute, second) = match parts[..] {
            [hour, minute] => (hour, minute, "0"),
            [hour, minute, second] => (hour, minute, second),
            _ => return Err(wrong()),
        };
        Ok(Self { hour: number(hour, 23)?, minute: number(minute, 59)?, second: number(second, 59)? })
    }
}

impl std::fmt::Display for TimeOfDay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:02}:{:02}", self.hour, self.minute)?;
        if self.second > 0 { write!(f, ":{:02}", self.second) } else { Ok(()) }
    }
}

/// Readings of both clocks \[ms\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// Time since the machine was started, including sleep.
    pub boot: i64,
    /// Time since 1970-01-01 00:00 UTC.
    pub wall: i64,
}

/// Converts a time of day to milliseconds since 1970, a given number of days after the local date of another time.
pub type Zone = fn(wall: i64, days: i32, time: TimeOfDay) -> i64;

/// End of a run by the wall clock.
#[derive(Debug, Clone, Copy)]
pub struct Until {
    time: TimeOfDay,
    zone: Zone,
    end: i64,
    /// Wall clock minus boot clock.
    distance: i64,
}

impl Until {
    /// The next time at which the clock shows `time`.
    #[must_use]
    pub fn next(time: TimeOfDay, now: Moment, zone: Zone) -> Self {
        let today = zone(now.wall, 0, time);
        let end = if today > now.wall { today } else { zone(now.wall, 1, time) };
        Self { time, zone, end, distance: now.wall - now.boot }
    }

    /// The time of the day.
    #[must_use]
    pub fn time(&self) -> TimeOfDay {
        self.time
    }

    /// Time left \[ms\]; negative if the end has passed.
    #[must_use]
    pub fn left(&self, now: Moment) -> i64 {
        self.end - now.wall
    }

    /// Whether the run must end now.
    pub fn is_reached(&mut self, now: Moment) -> bool {
        let expected = now.boot + self.distance;
        if (now.wall - expected).abs() >= SET {
            let planned = now.wall + (self.end - expected);
            let near = (-1..=3).map(|days| (self.zone)(now.wall, days, self.time));
            self.end = near.min_by_key(|end| (end - planned).abs()).unwrap_or(self.end);
            self.distance = now.wall - now.boot;
        }
        now.wall >= self.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINUTE: i64 = 60_000;
    const HOUR: i64 = 60 * MINUTE;
    const DAY: i64 = 24 * HOUR;
    /// A midnight.
    const NIGHT: i64 = 20_000 * DAY;

    fn utc(wall: i64, days: i32, time: TimeOfDay) -> i64 {
        let of_day = (i64::from(time.hour) * 60 + i64::from(time.minute)) * 60 + i64::from(time.second);
        (wall.div_euclid(DAY) + i64::from(days)) * DAY + of_day * 1000
    }

    /// A run until 06:30 that began at this time.
    fn begun(wall: i64) -> Until {
        Until::next("06:30".parse().expect("a time"), Moment { boot: 0, wall }, utc)
    }

    #[test]
    fn times_of_the_day_are_read_and_others_refused() {
        let time = |text: &str| text.parse::<TimeOfDay>();
        assert_eq!(time("06:30"), Ok(TimeOfDay { hour: 6, minute: 30, second: 0 }));
        assert_eq!(time("6:05:09").map(|time| time.to_string()), Ok("06:05:09".to_owned()));
        for text in ["", "6", "24:00", "06:60", "06:30:60", "+6:30", "06:30:00:00", "6.30", "006:30", "six"] {
            assert!(time(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_next_time_is_today_or_tomorrow() {
        assert_eq!(begun(NIGHT + HOUR).left(Moment { boot: 0, wall: NIGHT + HOUR }), 5 * HOUR + 30 * MINUTE);
        let at = NIGHT + 6 * HOUR + 30 * MINUTE;
        assert_eq!(begun(at).left(Moment { boot: 0, wall: at }), DAY);
    }

    #[test]
    fn an_undisturbed_night_and_a_sleeping_machine_end_on_time() {
        let mut until = begun(NIGHT - 2 * HOUR);
        let at = |passed: i64| Moment { boot: passed, wall: NIGHT - 2 * HOUR + passed };
        assert!(!until.is_reached(at(8 * HOUR + 29 * MINUTE)));
        assert!(until.is_reached(at(8 * HOUR + 30 * MINUTE)));
        // The end was passed during sleep: both clocks advanced.
        assert!(begun(NIGHT).is_reached(Moment { boot: 9 * HOUR, wall: NIGHT + 9 * HOUR }));
    }

    #[test]
    fn a_clock_that_is_set_ends_or_prolongs_nothing_absurdly() {
        // At 2:00, 4.5 h before the end, the clock is set to ...
        let set_to = |wall: i64| {
            let mut until = begun(NIGHT + HOUR);
            let now = Moment { boot: HOUR, wall };
            (until.is_reached(now), until.left(now))
        };
        // an hour earlier or later: the new clock is used.
        assert_eq!(set_to(NIGHT + HOUR), (false, 5 * HOUR + 30 * MINUTE));
        assert_eq!(set_to(NIGHT + 3 * HOUR), (false, 3 * HOUR + 30 * MINUTE));
        // just after 6:30: the end is reached, and is not moved to the next day.
        assert_eq!(set_to(NIGHT + 6 * HOUR + 45 * MINUTE), (true, -15 * MINUTE));
        // another year, from a clock that had lost its battery or to one that does: the 6:30 nearest to the planned end.
        assert_eq!(set_to(22 * HOUR), (false, 8 * HOUR + 30 * MINUTE));
        assert_eq!(set_to(50 * 365 * DAY + 22 * HOUR), (false, 8 * HOUR + 30 * MINUTE));
        for wall in (0..400 * DAY).step_by(37 * MINUTE as usize) {
            let (is_over, left) = set_to(wall);
            let planned = 4 * HOUR + 30 * MINUTE;
            assert!((left - planned).abs() <= 12 * HOUR && is_over == (left <= 0), "set to {wall}: {left}");
        }
    }

    #[test]
    fn slewing_moves_the_end_with_the_clock() {
        let mut until = begun(NIGHT);
        // A clock that gains a second every ten minutes.
        for minute in 0..389 {
            let now = Moment { boot: minute * MINUTE, wall: NIGHT + minute * MINUTE + minute * 100 };
            assert!(!until.is_reached(now), "minute {minute}");
        }
        assert!(until.is_reached(Moment { boot: 390 * MINUTE - 39_000, wall: NIGHT + 390 * MINUTE }));
    }
}
