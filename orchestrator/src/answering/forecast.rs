//! What another hour or night narrows intervals to, at the pace of the run: the scatter so far taken for that to come.

use super::Answering;
use bladeoff_answers::ask::{Answer, Scale};
use bladeoff_answers::estimate::figures::Figures;
use bladeoff_answers::report::{counted, duration};
use bladeoff_answers::stop::{Look, StopRule, expected, half_width};
use serde_json::{Map, Value, json};
use std::time::Duration;

/// Times that are looked ahead, with their names.
const AHEAD: [(&str, u64); 2] = [("hour", 3600), ("night (8 h)", 8 * 3600)];

/// The widest interval of an answer, now and later.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    /// Of the question, and the group.
    pub name: String,
    /// Values of the crossed axes, in words; empty where there are none.
    pub group: String,
    /// Half of it now.
    pub now: f64,
    /// After another hour, after another night.
    pub later: [f64; 2],
    /// How it reads.
    pub scale: Scale,
}

/// Forecasts of all answers of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecasts {
    /// Points of an hour.
    pub per_hour: f64,
    /// Of each answer with an interval, in their order.
    pub of: Vec<Forecast>,
    /// Points at which `[stop]` is expected to be met, and the time to there.
    pub met: Option<(u64, Duration)>,
    /// Points of the design, where a night computes more.
    pub ends: Option<u64>,
}

/// What `[stop]` of a study waits for.
#[derive(Debug, Clone, PartialEq)]
pub struct Awaited {
    /// The widths.
    pub rule: StopRule,
    /// Names of the questions.
    pub names: Vec<String>,
    /// Where it looks, at the levels of 95 %.
    pub looks: Vec<Look>,
}

/// Points that are never forecast.
const MOST: f64 = 1e15;

/// Points and time from which on a pace says something.
const FEWEST: (f64, f64) = (8.0, 1.0);

/// Samples of a second as the last run told of itself: that of a moment ago while it runs, of its whole course afterwards. `None`: it
/// told too little.
#[must_use]
pub fn pace(told: &Map<String, Value>) -> Option<f64> {
    let number = |key: &str| told.get(key).and_then(Value::as_f64).filter(|number| *number > 0.0);
    let (computed, elapsed) = (number("computed")?, number("elapsed_s")?);
    if computed < FEWEST.0 || elapsed < FEWEST.1 {
        return None;
    }
    Some(number("rate_per_s").unwrap_or(computed / elapsed))
}

/// Forecasts of answers at so many samples of a second; `None`: there is nothing to tell.
///
/// * `groups` - samples of a point; `awaited` - by `[stop]`.
#[must_use]
pub fn forecasts(answering: &Answering, pace: f64, groups: usize, awaited: Option<&Awaited>) -> Option<Forecasts> {
    let (points, of) = (answering.points, answering.design);
    let per_s = pace / groups.max(1) as f64;
    let now = Look { points, alpha: 0.05, is_last: false };
    let later =
        |seconds: u64| Look { points: points.saturating_add((per_s * seconds as f64).round().min(MOST) as u64), ..now };
    let one = |answer: &Answer| {
        let level = |look: &Look| Look { alpha: 1.0 - answer.confidence, ..*look };
        let widest = |then: Look| {
            let half = |one: &Figures| half_width(one, &level(&now), &level(&then));
            let halves: Option<Vec<f64>> = answer.figures.iter().map(half).collect();
            halves?.into_iter().reduce(f64::max)
        };
        let group: Vec<String> = answer.group.0.iter().map(|(path, label)| format!("{path} = {label}")).collect();
        Some(Forecast {
            name: answer.name.clone(),
            group: group.join(", "),
            now: widest(now)?,
            later: [widest(later(AHEAD[0].1))?, widest(later(AHEAD[1].1))?],
            scale: answer.scale.clone(),
        })
    };
    let answers = &answering.answers.answers;
    let found: Vec<Forecast> = answers.iter().filter_map(one).collect();
    if points == 0 || per_s <= 0.0 || found.is_empty() {
        return None;
    }
    let is_open = |awaited: &&Awaited| awaited.rule.asks_for_width() && !answering.answers.complete;
    let met = awaited.filter(is_open).and_then(|awaited| {
        let asked = answers.iter().filter(|answer| awaited.names.contains(&answer.name));
        let figures: Vec<Figures> = asked.flat_map(|answer| answer.figures.iter().cloned()).collect();
        let look = expected(&awaited.rule, &figures, &now, &awaited.looks).filter(|_| !figures.is_empty())?;
        Some((look.points, Duration::try_from_secs_f64((look.points - points) as f64 / per_s).ok()?))
    });
    let ends = (later(AHEAD[1].1).points > of).then_some(of);
    Some(Forecasts { per_hour: 3600.0 * per_s, of: found, met, ends })
}

impl Forecasts {
    /// Lines: "high: half of its interval is 0.79 % now, 0.56 % after another hour, 0.21 % after another night (8 h)".
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let one = |forecast: &Forecast| {
            let Forecast { name, group, now, later, scale } = forecast;
            let group = if group.is_empty() { String::new() } else { format!(" ({group})") };
            let show = |half: f64| scale.show(half);
            let later: Vec<String> = AHEAD
                .iter()
                .zip(later)
                .map(|((what, _), half)| format!("{} after another {what}", show(*half)))
                .collect();
            format!("{name}{group}: half of its interval is {} now, {}", show(*now), later.join(", "))
        };
        let mut lines: Vec<String> = self.of.iter().map(one).collect();
        lines.extend(self.met.map(|(points, time)| {
            format!("precise enough, as [stop] asks, is expected at {points} points, in about {}", duration(time))
        }));
        lines.extend(self.ends.map(|of| format!("the design has {of} points: for more it needs more of them")));
        lines
    }

    /// What the lines are told under.
    #[must_use]
    pub fn head(&self) -> String {
        let count = self.per_hour.round();
        let points = if count >= 1.0 { counted(count as u64, "point") } else { "less than a point".to_owned() };
        format!("Forecast, at {points} an hour as measured, with the scatter so far")
    }

    /// For programs.
    #[must_use]
    pub fn json(&self) -> Value {
        let one = |forecast: &Forecast| {
            json!({
                "name": forecast.name,
                "group": forecast.group,
                "half_width": forecast.now,
                "after_an_hour": forecast.later[0],
                "after_a_night": forecast.later[1],
            })
        };
        json!({
            "points_per_hour": self.per_hour,
            "of": self.of.iter().map(one).collect::<Vec<_>>(),
            "stop_at_points": self.met.map(|(points, _)| points),
            "stop_in_s": self.met.map(|(_, time)| time.as_secs_f64()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_answers::ask::{Answers, SCHEMA};
    use bladeoff_answers::estimate::figures::Method;
    use bladeoff_answers::estimate::input::Group;
    use bladeoff_answers::stop::looks;

    fn told(values: &Value) -> Option<f64> {
        pace(values.as_object().expect("an object"))
    }

    #[test]
    fn a_pace_is_measured_or_not_known() {
        assert_eq!(told(&json!({ "computed": 100, "elapsed_s": 50.0, "rate_per_s": 3.0 })), Some(3.0));
        assert_eq!(told(&json!({ "computed": 100, "elapsed_s": 50.0, "rate_per_s": 0.0 })), Some(2.0));
        for nothing in [
            json!({}),
            json!({ "computed": 0, "elapsed_s": 50.0 }),
            json!({ "computed": 100, "elapsed_s": null }),
            json!({ "computed": 5, "elapsed_s": 0.01, "rate_per_s": 500.0 }),
        ] {
            assert_eq!(told(&nothing), None, "{nothing}");
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
        let mut answer = Answer::of("load", "mean", Group::default(), 0, 0.95, figures.clone());
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
        };
        // two groups: 3000 points an hour
        let rule = StopRule { half_width: Some(0.45), ..StopRule::default() };
        let awaited = |end: u64| Awaited { rule, names: vec!["load".to_owned()], looks: looks(end, 0.05) };
        let found = forecasts(&answering, 6000.0 / 3600.0, 2, Some(&awaited(1500))).expect("a forecast");
        assert!((found.per_hour - 3000.0).abs() < 1e-9 && (found.of[0].later[0] - 0.5).abs() < 1e-3, "{found:?}");
        assert!((found.of[0].later[1] - 0.2).abs() < 1e-3, "{found:?}");
        assert_eq!((found.ends, found.met), (Some(1500), None), "the design ends before it is precise enough");
        let text = found.lines().join("\n");
        assert!(text.contains("load: half of its interval is 1 N now, 0.5 N after another hour"), "{text}");
        let wider = Answering { design: 1 << 20, ..answering.clone() };
        let met = forecasts(&wider, 6000.0 / 3600.0, 2, Some(&awaited(1 << 20)));
        let met = met.expect("a forecast").met.expect("some time");
        assert!(met.0 >= 8192 && met.1 > Duration::from_secs(3600), "{met:?}");
        let nothing = Answering { points: 0, ..answering };
        assert_eq!(forecasts(&nothing, 1.0, 1, None), None);
    }
}
