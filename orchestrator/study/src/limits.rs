//! `[limits]`: shares of failed, invalid and beyond samples above which `run` ends with exit code 4, and limits of each sample.

use super::amount::{parse_duration, parse_memory};
use super::table::{Keys, scalar_text};
use bladeoff_text::document::{Collector, Entry, Value};
use std::time::Duration;

/// Limits of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest share of failed or quarantined samples; default 0 %. With questions or gates the default is 100 %, because the answers account
    /// for such samples.
    pub max_failed: Share,
    /// Largest share of invalid samples; default 100 %.
    pub max_invalid: Share,
    /// Largest share of samples beyond the model; default 100 %.
    pub max_beyond: Share,
    /// Limits of each sample.
    pub sample: SampleLimits,
}

/// Limits of each sample, passed unchanged from the file or the command line to the scheduler. They affect only whether a result exists, not
/// its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleLimits {
    /// Longest wall time. A worker that exceeds it is killed, which counts as a crash. Default: none.
    pub time: Option<Duration>,
    /// Memory that the worker may allocate after its start \[bytes\]. Default: none.
    pub memory: Option<u64>,
    /// Number of crashes of a worker with this sample alone after which the sample is quarantined, at least 1; default 2.
    pub crashes: u32,
    /// Number of kills by other processes of a worker with this sample alone after which the sample is quarantined, at least 1; default 5.
    pub kills: u32,
}

impl Default for SampleLimits {
    fn default() -> Self {
        Self { time: None, memory: None, crashes: 2, kills: 5 }
    }
}

/// A number or share of the samples of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Share {
    /// Number of samples.
    Count(u64),
    /// Percentage of samples.
    Percent(f64),
}

impl Share {
    /// Whether `count` of `total` samples is within this share.
    #[must_use]
    pub fn allows(self, count: u64, total: u64) -> bool {
        match self {
            Share::Count(most) => count <= most,
            Share::Percent(percent) => count as f64 * 100.0 <= percent * total as f64,
        }
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Share::Count(count) => write!(f, "{count}"),
            Share::Percent(percent) => write!(f, "{percent} %"),
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        let all = Share::Percent(100.0);
        Self { max_failed: Share::Percent(0.0), max_invalid: all, max_beyond: all, sample: SampleLimits::default() }
    }
}

const ALLOWED: &str = "a number of samples such as 3, or a share such as \"5 %\"";

impl Limits {
    /// Defaults for a study without `[limits]`; `is_asked`: the study has questions or gates.
    pub(super) fn of(is_asked: bool) -> Self {
        let all = Share::Percent(100.0);
        if is_asked { Self { max_failed: all, ..Self::default() } } else { Self::default() }
    }

    /// Reads `[limits]`; `is_asked`: the study has questions or gates. Problems are added to `problems`.
    pub(super) fn read(entry: &Entry, is_asked: bool, problems: &mut Collector<'_>) -> Self {
        let mut limits = Self::of(is_asked);
        let Some(keys) = Keys::of(entry, "limits", problems) else { return limits };
        keys.refuse_unknown(&crate::keys::names("[limits]"), problems);
        let shares = [
            ("max_failed", &mut limits.max_failed),
            ("max_invalid", &mut limits.max_invalid),
            ("max_beyond", &mut limits.max_beyond),
        ];
        for (name, limit) in shares {
            let read = |entry| read_share(entry, &format!("limits.{name}"), problems);
            *limit = keys.get(name).and_then(read).unwrap_or(*limit);
        }
        let sample = &mut limits.sample;
        sample.time = keys.get("time_limit").and_then(|entry| read_amount(entry, parse_duration, problems));
        sample.memory = keys.get("memory_limit").and_then(|entry| read_amount(entry, parse_memory, problems));
        let mut deaths = |name: &str| {
            let entry = keys.get(name)?;
            keys.whole(entry, 1, 1000, problems).and_then(|limit| u32::try_from(limit).ok())
        };
        sample.crashes = deaths("crash_limit").unwrap_or(sample.crashes);
        sample.kills = deaths("kill_limit").unwrap_or(sample.kills);
        limits
    }
}

fn read_amount<T>(entry: &Entry, parse: impl Fn(&str) -> Result<T, String>, problems: &mut Collector<'_>) -> Option<T> {
    let text = scalar_text(&entry.node.value).unwrap_or_default();
    parse(&text)
        .map_err(|message| {
            let value = problems.excerpt(entry.node.span.clone());
            problems.add(entry.node.span.clone(), format!("limits.{}", entry.name), message).value = Some(value);
        })
        .ok()
}

fn read_share(entry: &Entry, key: &str, problems: &mut Collector<'_>) -> Option<Share> {
    let share = match &entry.node.value {
        Value::Integer(count) => u64::try_from(*count).ok().map(Share::Count),
        Value::Text(text) => text
            .trim()
            .strip_suffix('%')
            .and_then(|number| number.trim_end().parse::<f64>().ok())
            .filter(|percent| (0.0..=100.0).contains(percent))
            .map(Share::Percent),
        _ => None,
    };
    if share.is_none() {
        let value = problems.excerpt(entry.node.span.clone());
        let problem = problems.add(entry.node.span.clone(), key, "not a number or share of samples");
        problem.value = Some(value);
        problem.allowed = Some(ALLOWED.to_owned());
    }
    share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_counts_or_takes_a_part() {
        assert!(Share::Percent(0.0).allows(0, 10) && !Share::Percent(0.0).allows(1, 10));
        assert!(Share::Percent(10.0).allows(1, 10) && !Share::Percent(10.0).allows(2, 10));
        assert!(Share::Count(2).allows(2, 3) && !Share::Count(2).allows(3, 1000));
    }
}
