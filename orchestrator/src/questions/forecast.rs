//! Forecast of intervals with more points, from the scatter so far: after another hour and night at the pace of the run, up to the end of
//! the design; for a complete study, with four times its points.

use super::Answering;
use bladeoff_answers::ask::{Answer, Scale};
use bladeoff_answers::estimate::figures::Figures;
use bladeoff_answers::stop::{StopRule, expected, half_width};
use bladeoff_answers::summary::{counted, duration};
use serde_json::{Map, Value, json};
use std::time::Duration;

/// Forecast horizons \[s\] with their names.
const AHEAD: [(&str, u64); 2] = [("another hour", 3600), ("another night (8 h)", 8 * 3600)];
/// Factor on the points of a complete study.
const MORE: u64 = 4;

/// Number of points at a later time.
#[derive(Debug, Clone, PartialEq)]
pub struct Later {
    /// "after another hour", "at the end, 5000 points".
    pub when: String,
    /// Time until then, if `when` contains none.
    pub time: Option<Duration>,
    /// Number of points at that time.
    pub points: u64,
}

impl Later {
    /// Text with time: "at the end, 5000 points, in about 5 h".
    fn timed(&self) -> String {
        self.time.map_or_else(|| self.when.clone(), |time| format!("{}, in about {}", self.when, duration(time)))
    }
}

/// Forecast of the widest interval of an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    /// Name of the question.
    pub name: String,
    /// Values of the crossed axes, as text; empty without axes.
    pub group: String,
    /// Figure with the widest interval: "total order of gap"; empty if there is only one figure.
    pub figure: String,
    /// Present half width.
    pub now: f64,
    /// Half width at each of [`Forecasts::later`].
    pub later: Vec<f64>,
    /// Unit and format of the half widths.
    pub scale: Scale,
}

/// Forecasts of all answers of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecasts {
    /// Points per hour.
    pub per_hour: f64,
    /// Forecast horizons.
    pub later: Vec<Later>,
    /// Forecasts of the answers with an interval, in the order of the answers.
    pub of: Vec<Forecast>,
    /// Sensitivities without any interval: question with group, and reason.
    pub without: Vec<(String, String)>,
    /// Whether runs beyond the model leave open a part that more points cannot narrow.
    pub beyond: bool,
    /// Number of points at which `[stop]` is expected to be met, and time until then.
    pub met: Option<(u64, Duration)>,
    /// Whether this is the next interim analysis.
    pub is_met_next: bool,
}

/// Requirements of `[stop]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Awaited {
    /// Required widths.
    pub rule: StopRule,
    /// Names of the questions.
    pub names: Vec<String>,
    /// Numbers of points of the interim analyses.
    pub analyses: Vec<u64>,
}

/// Note for all answers together.
pub(super) const NOT_NARROWED: &str =
    "more points cannot narrow the part of an interval that runs beyond the model leave open";

/// Largest number of points in a forecast.
const MOST: f64 = 1e15;

/// Smallest number of samples, and time \[s\], for a measured pace.
const FEWEST: (f64, f64) = (8.0, 1.0);

/// Samples per second from the status of the last run: over the last seconds while it runs, over the whole run afterwards. `None` with too
/// few samples or too short a time.
#[must_use]
pub fn pace(report: &Map<String, Value>) -> Option<f64> {
    let number = |key: &str| report.get(key).and_then(Value::as_f64).filter(|number| *number > 0.0);
    let (computed, elapsed) = (number("computed")?, number("elapsed_s")?);
    if computed < FEWEST.0 || elapsed < FEWEST.1 {
        return None;
    }
    Some(number("rate_per_s").unwrap_or(computed / elapsed))
}

/// Forecasts of answers at this pace in samples per second; `None` if there is nothing to report.
///
/// * `groups` - samples of a point; `awaited` - requirements of `[stop]`.
#[must_use]
pub fn forecasts(answering: &Answering, pace: f64, groups: usize, awaited: Option<&Awaited>) -> Option<Forecasts> {
    let points = answering.points;
    let per_s = pace / groups.max(1) as f64;
    if points == 0 || per_s <= 0.0 {
        return None;
    }
    // `[stop]` may end a study before its design does
    let end = awaited.and_then(|awaited| awaited.analyses.last()).map_or(answering.design, |last| *last);
    let later = later(points, end, per_s);
    let answers = &answering.answers.answers;
    let found: Vec<Forecast> = answers.iter().filter_map(|answer| one(answer, points, &later)).collect();
    let without: Vec<(String, String)> = answers.iter().filter_map(without).collect();
    if found.is_empty() && without.is_empty() {
        return None;
    }
    let is_open = |awaited: &&Awaited| awaited.rule.asks_for_width() && !answering.answers.complete;
    let met = awaited.filter(is_open).and_then(|awaited| {
        let asked = answers.iter().filter(|answer| awaited.names.contains(&answer.name));
        let with_alpha = |answer: &Answer| {
            let alpha = 1.0 - answer.confidence;
            answer.figures.iter().map(|one| (one.clone(), alpha)).collect::<Vec<_>>()
        };
        let figures: Vec<(Figures, f64)> = asked.flat_map(with_alpha).collect();
        let met = expected(&awaited.rule, &figures, points, &awaited.analyses).filter(|_| !figures.is_empty())?;
        Some((met, Duration::try_from_secs_f64((met - points) as f64 / per_s).ok()?))
    });
    let beyond = answers.iter().any(|answer| answer.beyond_open > 0 && answer.figures.iter().any(is_left_open));
    let next = awaited.and_then(|awaited| awaited.analyses.iter().copied().find(|analysis| *analysis > points));
    let is_met_next = met.is_some_and(|(points, _)| Some(points) == next);
    Some(Forecasts { per_hour: 3600.0 * per_s, later, of: found, without, beyond, met, is_met_next })
}

/// Whether runs that are not ok leave a figure open.
fn is_left_open(figures: &Figures) -> bool {
    figures.estimate.is_some() && figures.estimate != figures.harmful
}

/// Values of the crossed axes of an answer, as text; empty without axes.
#[must_use]
pub fn group_in_words(answer: &Answer) -> String {
    let group: Vec<String> = answer.group.0.iter().map(|(path, label)| format!("{path} = {label}")).collect();
    group.join(", ")
}

/// Forecast of the widest interval of an answer; `None` without an interval.
fn one(answer: &Answer, now: u64, later: &[Later]) -> Option<Forecast> {
    let widest = |points: u64| {
        let half = |(at, one): (usize, &Figures)| Some((at, half_width(one, 1.0 - answer.confidence, (now, points))?));
        let halves = answer.figures.iter().enumerate().filter_map(half);
        halves.reduce(|most, one| if one.1 > most.1 { one } else { most })
    };
    let (at, half) = widest(now)?;
    Some(Forecast {
        name: answer.name.clone(),
        group: group_in_words(answer),
        figure: answer.figure_name(at),
        now: half,
        later: later.iter().map(|later| Some(widest(later.points)?.1)).collect::<Option<_>>()?,
        scale: answer.scale.clone(),
    })
}

/// A sensitivity without any interval, and the reason.
fn without(answer: &Answer) -> Option<(String, String)> {
    answer.sensitivity.as_ref().filter(|_| answer.figures.iter().all(|one| one.statistical.is_none()))?;
    let group = group_in_words(answer);
    let group = if group.is_empty() { group } else { format!(" ({group})") };
    Some((format!("{}{group}", answer.name), answer.without_interval()?))
}

/// Forecast horizons: the times before the end of the design, and its end if that is before the last of them. For a complete design:
/// a multiple of its points.
fn later(points: u64, end: u64, per_s: f64) -> Vec<Later> {
    let time = |points: u64| Duration::try_from_secs_f64(points as f64 / per_s).ok();
    if points >= end {
        let more = points.saturating_mul(MORE);
        return vec![Later { when: format!("with {more} points"), time: time(more - points), points: more }];
    }
    let mut all: Vec<Later> = Vec::new();
    for (what, seconds) in AHEAD {
        let more = points.saturating_add((per_s * seconds as f64).round().min(MOST) as u64);
        if more >= end {
            all.push(Later { when: format!("at the end, {end} points"), time: time(end - points), points: end });
            break;
        }
        all.push(Later { when: format!("after {what}"), time: None, points: more });
    }
    all
}

impl Forecasts {
    /// Lines: "high: half of its interval is 0.79 % now, 0.56 % after another hour, 0.21 % after another night (8 h)".
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        self.lines_with(Later::timed, true)
    }

    /// Lines for display next to the remaining time of a running study, without a second time to the same end.
    #[must_use]
    pub fn lines_beside_the_time_left(&self) -> Vec<String> {
        self.lines_with(|later| later.when.clone(), !self.is_met_next)
    }

    fn lines_with(&self, when: fn(&Later) -> String, is_met_timed: bool) -> Vec<String> {
        let one = |forecast: &Forecast| {
            let Forecast { name, group, figure, now, later, scale } = forecast;
            let group = if group.is_empty() { String::new() } else { format!(" ({group})") };
            let which = match figure.as_str() {
                "" => "its interval".to_owned(),
                figure => format!("its widest interval ({figure})"),
            };
            let show = |half: f64| scale.show(half);
            let later: Vec<String> =
                self.later.iter().zip(later).map(|(later, half)| format!("{} {}", show(*half), when(later))).collect();
            format!("{name}{group}: half of {which} is {} now, {}", show(*now), later.join(", "))
        };
        let mut lines: Vec<String> = self.of.iter().map(one).collect();
        lines.extend(self.without.iter().map(|(name, why)| format!("{name}: none is forecast: {why}")));
        lines.extend(self.beyond.then(|| NOT_NARROWED.to_owned()));
        lines.extend(self.met.map(|(points, time)| {
            let time = if is_met_timed { format!(", in about {}", duration(time)) } else { String::new() };
            format!("precise enough, as [stop] asks, is expected at {points} points{time}")
        }));
        lines
    }

    /// Heading above the lines.
    #[must_use]
    pub fn head(&self) -> String {
        let count = self.per_hour.round();
        let points = if count >= 1.0 { counted(count as u64, "point") } else { "less than a point".to_owned() };
        format!("Forecast, at the measured pace of {points} an hour and the scatter so far")
    }

    /// The forecasts as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let one = |forecast: &Forecast| {
            json!({
                "name": forecast.name,
                "group": forecast.group,
                "figure": Some(&forecast.figure).filter(|figure| !figure.is_empty()),
                "half_width": forecast.now,
                "later": forecast.later,
            })
        };
        let later = |later: &Later| json!({ "when": later.timed(), "points": later.points });
        json!({
            "points_per_hour": self.per_hour,
            "later": self.later.iter().map(later).collect::<Vec<_>>(),
            "of": self.of.iter().map(one).collect::<Vec<_>>(),
            "beyond_leaves_open": self.beyond,
            "stop_at_points": self.met.map(|(points, _)| points),
            "stop_in_s": self.met.map(|(_, time)| time.as_secs_f64()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_answers::ask::{Answers, SCHEMA};
    use bladeoff_answers::estimate::bad::Bad;
    use bladeoff_answers::estimate::figures::Method;
    use bladeoff_answers::estimate::input::Group;

    fn report(values: &Value) -> Option<f64> {
        pace(values.as_object().expect("an object"))
    }

    #[test]
    fn a_pace_is_measured_or_not_known() {
        assert_eq!(report(&json!({ "computed": 100, "elapsed_s": 50.0, "rate_per_s": 3.0 })), Some(3.0));
        assert_eq!(report(&json!({ "computed": 100, "elapsed_s": 50.0, "rate_per_s": 0.0 })), Some(2.0));
        for nothing in [
            json!({}),
            json!({ "computed": 0, "elapsed_s": 50.0 }),
            json!({ "computed": 100, "elapsed_s": null }),
            json!({ "computed": 5, "elapsed_s": 0.01, "rate_per_s": 500.0 }),
        ] {
            assert_eq!(report(&nothing), None, "{nothing}");
        }
    }

    #[test]
    fn four_times_the_points_halve_an_interval() {
        let figures = Figures {
            estimate: Some(10.0),
            low: Some(9.0),
            high: Some(11.0),
            statistical: Some(2.0),
            method: Method::Student,
            ..Figures::over(1000)
        };
        let mut answer = Answer::of("load", "mean", Group::default(), Bad::default(), 0.95, figures.clone());
        (answer.figures, answer.scale) = (vec![figures], Scale::Unit("N".to_owned()));
        let answers = Answers { schema: SCHEMA, complete: false, answers: vec![answer] };
        let answering = Answering {
            answers,
            curves: Vec::new(),
            points: 1000,
            of: 1500,
            design: 1500,
            is_design: true,
            is_known: true,
            is_open: false,
        };
        // two groups: 3000 points an hour
        let rule = StopRule { half_width: Some(0.45), ..StopRule::default() };
        let analyses = |end: u64| (8..).map(|k| 1 << k).take_while(|points| *points < end).chain([end]).collect();
        let awaited = |end: u64| Awaited { rule, names: vec!["load".to_owned()], analyses: analyses(end) };
        let ahead = |answering: &Answering, end: u64| {
            forecasts(answering, 6000.0 / 3600.0, 2, Some(&awaited(end))).expect("a forecast")
        };
        let wide = Answering { design: 1 << 20, ..answering.clone() };
        let found = ahead(&wide, 1 << 20);
        assert!((found.per_hour - 3000.0).abs() < 1e-9 && (found.of[0].later[0] - 0.5).abs() < 1e-3, "{found:?}");
        assert!((found.of[0].later[1] - 0.2).abs() < 1e-3, "{found:?}");
        let text = found.lines().join("\n");
        assert!(
            text.contains("load: half of its interval is 1 N now, 0.5 N after another hour, 0.2 N after another night"),
            "{text}"
        );
        let met = found.met.expect("some time");
        assert!(met.0 >= 8192 && met.1 > Duration::from_secs(3600), "{met:?}");
        // the design, or [stop], ends earlier
        let short = Answering { design: 16_000, ..answering.clone() };
        let found = ahead(&short, 16_000);
        assert!(
            found.of[0].later.len() == 2 && found.lines()[0].contains("0.25 N at the end, 16000 points, in about 5 h"),
            "{:?}",
            found.lines()
        );
        let beside = found.lines_beside_the_time_left().join("\n");
        assert!(beside.contains("0.25 N at the end, 16000 points") && !beside.contains("in about 5 h"), "{beside}");
        let found = ahead(&short, 1500);
        assert!(
            (found.of[0].later.len(), found.met) == (1, None)
                && found.lines()[0].contains("0.8165 N at the end, 1500 points"),
            "{:?}",
            found.lines()
        );
        // complete study: forecast for more points
        let whole = Answering { design: 1000, of: 1000, ..answering.clone() };
        let found = ahead(&whole, 1000);
        assert_eq!(
            found.lines(),
            ["load: half of its interval is 1 N now, 0.5 N with 4000 points, in about 1 h 00 min"]
        );
        // the note on runs beyond the model appears once for any number of answers
        let mut open = Answering { design: 1000, of: 1000, ..answering.clone() };
        open.answers.answers[0].beyond = 17;
        // their values determine the answer: nothing is open
        assert!(!ahead(&open, 1000).lines().iter().any(|line| line == NOT_NARROWED));
        open.answers.answers[0].beyond_open = 17;
        open.answers.answers.push(open.answers.answers[0].clone());
        let found = ahead(&open, 1000);
        assert_eq!(found.lines().iter().filter(|line| *line == NOT_NARROWED).count(), 1, "{:?}", found.lines());
        assert_eq!(found.json()["beyond_leaves_open"], true);
        let nothing = Answering { points: 0, ..answering };
        assert_eq!(forecasts(&nothing, 1.0, 1, None), None);
    }
}
