//! `[stop]`: precision at which a study ends before its design does. `[stop]` does not enter the identity of a study: another rule
//! ends the result table at another point, and no sample is computed again.

use super::amount::parse_duration;
use super::asked::{Asked, AskedQuestion};
use super::sampling::layout::{LayoutKind, SamplingLayout, Standing};
use super::table::{Keys, scalar_text, wrong_type};
use bladeoff_text::document::{Collector, Entry, Value};
use std::time::Duration;

/// Number of points at the first interim analysis; each later one has twice as many.
pub const FIRST_LOOK: u64 = 256;

/// Settings of `[stop]`. If both widths are given, both must be reached; the first fulfilled condition ends the study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopDef {
    /// Largest half width of every interval, in the unit of its figure.
    pub half_width: Option<f64>,
    /// Largest half width relative to the figure \[-\].
    pub relative: Option<f64>,
    /// Most points; trajectories of a Morris design, base points of a Saltelli design.
    pub samples: Option<u64>,
    /// Longest time of a run.
    pub wall: Option<Duration>,
}

impl StopDef {
    /// Whether the widths of intervals are limited.
    #[must_use]
    pub fn asks_for_width(&self) -> bool {
        self.half_width.is_some() || self.relative.is_some()
    }

    /// Reads `[stop]` of a study; `layout`: its points, `None` if they are invalid. Problems are added to `problems`.
    pub(super) fn read(
        entry: &Entry,
        asked: &Asked,
        (has_design, layout): (bool, Option<&SamplingLayout>),
        problems: &mut Collector<'_>,
    ) -> Option<Self> {
        let keys = Keys::of(entry, "stop", problems)?;
        let known = crate::keys::names("[stop]");
        let before = problems.count();
        keys.refuse_unknown(&known, problems);
        let stop = Self {
            half_width: keys.get("half_width").and_then(|entry| width(entry, problems)),
            relative: keys.get("relative").and_then(|entry| relative(entry, problems)),
            samples: keys.get("samples").and_then(|entry| keys.whole(entry, 1, i64::MAX as u64, problems)),
            wall: keys.get("wall").and_then(|entry| wall(entry, problems)),
        };
        if problems.count() > before {
            return None;
        }
        let mut refuse = |entry: &Entry, key: &str, message: String, allowed: &str| {
            problems.add(entry.node.span.clone(), key, message).allowed = Some(allowed.to_owned());
        };
        if known.iter().all(|key| keys.get(key).is_none()) {
            let allowed = "half_width = 0.01, relative = \"5 %\", samples = 4096, wall = \"8 h\"";
            refuse(entry, "stop", "has no rule to stop at".to_owned(), allowed);
            return None;
        }
        if !has_design {
            let allowed = "[design] with kind = \"monte-carlo\" and samples = 4096";
            refuse(entry, "stop", "needs the points of a [design], which this study does not have".to_owned(), allowed);
            return None;
        }
        let width = keys.get("half_width").or(keys.get("relative"));
        let key = |entry: &Entry| format!("stop.{}", entry.name);
        if let Some(width) = width.filter(|_| !asked.questions.iter().any(has_figure)) {
            let message = "no question of the study has an answer with an interval".to_owned();
            let allowed = "a [[question]] with `probability`, `quantile`, `mean` or `sensitivity`";
            refuse(width, &key(width), message, allowed);
        }
        let layout = layout?;
        let word = layout.kind().word();
        if layout.kind() == LayoutKind::OneAtATime {
            let message = format!(
                "points of kind {word:?} are not a random sample: the first points do not represent the others"
            );
            refuse(entry, "stop", message, "another kind in [design]");
        } else if !is_blocked(layout) && !FIRST_LOOK.is_multiple_of(layout.replicates()) {
            let message = format!(
                "an interim analysis of the first {FIRST_LOOK} points would split {} replicates",
                layout.replicates()
            );
            refuse(entry, "stop", message, "16, 32, 64, 128 or 256 replicates");
        } else if let (Some(width), false, Standing::NoInterval(why)) =
            (width, is_blocked(layout), layout.standing(layout.count()))
        {
            let message = format!("no answer has an interval: {why}");
            refuse(
                width,
                &key(width),
                message,
                "kind = \"monte-carlo\", or replicates = 16 of a power of two of samples",
            );
        } else if let Some(width) = width.filter(|_| is_blocked(layout) && !asked.questions.iter().any(is_sensitivity))
        {
            let message = format!("only a question with `sensitivity` has intervals with points of kind {word:?}");
            refuse(width, &key(width), message, "a [[question]] with `sensitivity`");
        }
        if let (Some(samples), Some(entry), false) = (stop.samples, keys.get("samples"), is_blocked(layout))
            && samples < layout.count()
            && layout.whole(samples) != samples
        {
            let whole = layout.whole(samples);
            let allowed = if whole > 0 { format!("such as {whole}") } else { "more points".to_owned() };
            refuse(
                entry,
                "stop.samples",
                format!("the first {samples} points are not a complete design of kind {word:?}"),
                &allowed,
            );
        }
        (problems.count() == before).then_some(stop)
    }
}

/// Whether points are useful in blocks only, so that blocks are counted.
#[must_use]
pub fn is_blocked(layout: &SamplingLayout) -> bool {
    matches!(layout.kind(), LayoutKind::Morris | LayoutKind::Saltelli)
}

/// Number of points of a block and the name of blocks, if blocks are counted.
#[must_use]
pub fn block(layout: &SamplingLayout) -> Option<(u64, &'static str)> {
    match layout.kind() {
        LayoutKind::Morris => Some((layout.rows(), "trajectories")),
        LayoutKind::Saltelli => Some((layout.rows(), "base points")),
        _ => None,
    }
}

fn has_figure(question: &AskedQuestion) -> bool {
    // an unreadable question has been reported
    question.is_partly || question.exceedance.is_none() && question.fragility.is_none() && question.map.is_none()
}

fn is_sensitivity(question: &AskedQuestion) -> bool {
    question.is_partly || question.sensitivity.is_some()
}

fn width(entry: &Entry, problems: &mut Collector<'_>) -> Option<f64> {
    above_0(
        entry,
        entry.node.value.as_number(),
        "a number above 0 in the SI unit of the answer; 0.01 for 1 % of a probability",
        problems,
    )
}

fn relative(entry: &Entry, problems: &mut Collector<'_>) -> Option<f64> {
    let percent = |text: &str| Some(text.trim().strip_suffix('%')?.trim_end().parse::<f64>().ok()? / 100.0);
    let given = match &entry.node.value {
        Value::Text(text) => percent(text),
        value => value.as_number(),
    };
    // 5 is not a share, but 5 % without its sign
    let given = given.filter(|part| *part < 1.0).or(given.map(|_| f64::NAN));
    above_0(entry, given, "a share of the answer above 0 and below 1, such as 0.05 or \"5 %\"", problems)
}

fn above_0(entry: &Entry, given: Option<f64>, allowed: &str, problems: &mut Collector<'_>) -> Option<f64> {
    let key = format!("stop.{}", entry.name);
    match given {
        Some(given) if given > 0.0 && given.is_finite() => Some(given),
        None if !matches!(entry.node.value, Value::Text(_)) => {
            wrong_type(&entry.node, &key, allowed, problems);
            None
        }
        _ => {
            let value = problems.excerpt(entry.node.span.clone());
            let told = problems.add(entry.node.span.clone(), key, "is no width");
            (told.value, told.allowed) = (Some(value), Some(allowed.to_owned()));
            None
        }
    }
}

fn wall(entry: &Entry, problems: &mut Collector<'_>) -> Option<Duration> {
    let text = scalar_text(&entry.node.value).unwrap_or_default();
    let told = parse_duration(&text);
    if let Err(message) = &told {
        let value = problems.excerpt(entry.node.span.clone());
        problems.add(entry.node.span.clone(), "stop.wall", message).value = Some(value);
    }
    told.ok()
}
