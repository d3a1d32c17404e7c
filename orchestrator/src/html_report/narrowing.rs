//! How the confidence intervals of sensitivity indices narrow with the number of points: the widest interval of each kind of index, the interval of
//! the most influential parameter, and the expected width of the widest interval.

use super::words::{group, unit_of};
use crate::questions::{Forecasts, group_in_words};
use crate::run::TableColumn;
use bladeoff_answers::ask::{Answer, Question};
use bladeoff_answers::figures::Scale;
use bladeoff_answers::page::chart::{Axis, COLOURS, Chart, Series, Shape, shown};
use bladeoff_answers::page::{Block, Table};

/// Largest number of groups of a question that have a chart.
const MOST_CHARTS: usize = 5;

/// A line of half widths over the number of points.
struct Course {
    name: String,
    points: Vec<(f64, f64)>,
}

/// Charts of every group; for a group without intervals the reason.
pub(super) fn narrowing(
    question: &Question,
    steps: &[(u64, Vec<Answer>)],
    columns: &[TableColumn],
    forecasts: Option<&Forecasts>,
) -> Vec<Block> {
    let Some((_, last)) = steps.last() else { return Vec::new() };
    let mut blocks = Vec::new();
    for (at, answer) in last.iter().take(MOST_CHARTS).enumerate() {
        let of = group(&answer.group);
        let name = if of.is_empty() { question.name.clone() } else { format!("{}, {of}", question.name) };
        let course: Vec<(u64, &Answer)> =
            steps.iter().filter_map(|(points, answers)| Some((*points, answers.get(at)?))).collect();
        let Some(now) = widest(answer, |_| true) else {
            let why = answer.without_interval().unwrap_or_else(|| "no index has an interval".to_owned());
            blocks.push(Block::Text(format!("{name}: {why}.")));
            continue;
        };
        blocks.push(Block::Text(said(&name, answer, now)));
        // a single evaluation gives no course
        if course.iter().filter(|(_, answer)| widest(answer, |_| true).is_some()).count() > 1 {
            blocks.push(chart(&name, &course, columns, ahead(answer, forecasts)));
        }
    }
    if last.len() > MOST_CHARTS {
        blocks.push(Block::Note(format!("The first {MOST_CHARTS} of {} groups are drawn.", last.len())));
    }
    blocks
}

/// Half width of the interval of the figure at an index.
fn half(answer: &Answer, at: usize) -> Option<f64> {
    let figures = answer.figures.get(at)?;
    Some(0.5 * (figures.high? - figures.low?))
}

/// The widest interval among the chosen figures: index of its figure and half width.
fn widest(answer: &Answer, is_meant: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
    let halves = (0..answer.figures.len()).filter(|at| is_meant(*at)).filter_map(|at| Some((at, half(answer, at)?)));
    halves.reduce(|most, one| if one.1 > most.1 { one } else { most })
}

/// Sentence: "load: half of the widest interval is 9.1 % (first order of gap), that of the most decisive index, total order of mass, is 7 %."
fn said(name: &str, answer: &Answer, (at, half_width): (usize, f64)) -> String {
    let show = |half: f64| answer.scale.show(half);
    let decisive = answer.most_decisive().filter(|decisive| *decisive != at);
    let decisive = decisive.and_then(|at| Some((answer.figure_name(at), half(answer, at)?)));
    let more = match decisive {
        Some((figure, half)) => format!("; that of the main driver, {figure}, is {}", show(half)),
        None => String::new(),
    };
    format!("{name}: half of the widest interval is {} ({}){more}.", show(half_width), answer.figure_name(at))
}

/// Expected half width of the widest interval, as a line from its present value.
fn ahead(answer: &Answer, forecasts: Option<&Forecasts>) -> Vec<(f64, f64)> {
    let Some(forecasts) = forecasts else { return Vec::new() };
    let group = group_in_words(answer);
    let of = forecasts.of.iter().find(|one| one.name == answer.name && one.group == group);
    let later = |one| forecasts.later.iter().zip(one).map(|(later, half): (_, &f64)| (later.points as f64, *half));
    of.map(|one| later(&one.later).collect()).unwrap_or_default()
}

/// Whether two lines are the same up to rounding.
fn is_same(a: &[(f64, f64)], b: &[(f64, f64)]) -> bool {
    let same = |((x, y), (u, v)): (&(f64, f64), &(f64, f64))| x == u && (y - v).abs() <= 1e-6 * y.abs();
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// The kind of a figure: "total order" for "total order of gap".
fn kind(figure: &str) -> &str {
    figure.split_once(" of ").map_or(figure, |(kind, _)| kind)
}

fn chart(name: &str, course: &[(u64, &Answer)], columns: &[TableColumn], ahead: Vec<(f64, f64)>) -> Block {
    let last = course[course.len() - 1].1;
    let decisive = last.most_decisive();
    let mut kinds: Vec<String> = Vec::new();
    for at in 0..last.figures.len() {
        let of = kind(&last.figure_name(at)).to_owned();
        if !kinds.contains(&of) {
            kinds.push(of);
        }
    }
    let line = |of: &dyn Fn(&Answer) -> Option<f64>| {
        course.iter().filter_map(|(points, answer)| Some((*points as f64, of(answer)?))).collect::<Vec<_>>()
    };
    let of_kind = |wanted: &String| Course {
        name: format!("widest {wanted}"),
        points: line(&|answer| Some(widest(answer, |at| kind(&answer.figure_name(at)) == wanted)?.1)),
    };
    let mut courses: Vec<Course> = kinds.iter().map(of_kind).collect();
    if let Some(at) = decisive {
        let (name, points) = (last.figure_name(at), line(&|answer| half(answer, at)));
        match courses.iter_mut().find(|course| is_same(&course.points, &points)) {
            // two coincident lines would be unreadable, so they become one with both names
            Some(same) => same.name = format!("widest: {name}"),
            None => courses.push(Course { name, points }),
        }
    }
    let most = courses.iter().flat_map(|course| &course.points).fold(0.0_f64, |most, (_, half)| most.max(*half));
    // shares of a variance in per cent, elementary effects in the unit of the output
    let found = last.sensitivity.as_ref();
    let scale = match found.filter(|found| found.estimator == "morris") {
        Some(found) => Scale::of(unit_of(columns, &found.output), most),
        None => Scale { factor: 100.0, unit: "%".to_owned() },
    };
    let show = |points: &[(f64, f64)]| points.iter().map(|(x, y)| (*x, y * scale.factor)).collect::<Vec<_>>();
    let mut series: Vec<Series> = courses
        .iter()
        .zip(COLOURS)
        .map(|(course, colour)| Series {
            name: course.name.clone(),
            colour,
            shape: Shape::Line(show(&course.points), false),
        })
        .collect();
    let now = course.last().and_then(|(points, answer)| Some((*points as f64, widest(answer, |_| true)?.1)));
    if !ahead.is_empty() {
        let points: Vec<(f64, f64)> = now.into_iter().chain(ahead).collect();
        series.push(Series {
            name: "forecast of the widest".to_owned(),
            colour: "quiet",
            shape: Shape::Line(show(&points), true),
        });
    }
    let all: Vec<(f64, f64)> = series
        .iter()
        .flat_map(|series| match &series.shape {
            Shape::Line(points, _) => points.clone(),
            _ => Vec::new(),
        })
        .collect();
    let table = table(course, &courses, &scale);
    let chart = Chart {
        x: Axis::log("points", all.iter().map(|(x, _)| *x)).at(ticks(course, &all)),
        y: Axis::numbers(scale.label("half of the interval"), all.iter().map(|(_, y)| *y).chain([0.0])),
        series,
        height: 220,
    };
    let caption = format!("{name}: half of the intervals of its indices after the first points and after all.");
    chart.figure(caption, Some(table)).into()
}

/// Ticks of the axis: the numbers of points of the evaluations and the end of the forecast.
fn ticks(course: &[(u64, &Answer)], all: &[(f64, f64)]) -> Vec<f64> {
    let last = all.iter().fold(0.0_f64, |last, (x, _)| last.max(*x));
    let looks: Vec<f64> = course.iter().map(|(points, _)| *points as f64).collect();
    let is_beyond = looks.last().is_some_and(|look| last > 1.5 * look);
    looks.into_iter().chain(is_beyond.then_some(last)).collect()
}

fn table(course: &[(u64, &Answer)], courses: &[Course], scale: &Scale) -> Table {
    let mut head = vec!["points".to_owned()];
    head.extend(courses.iter().map(|course| scale.label(&course.name)));
    let row = |(points, _): &(u64, &Answer)| {
        let cell = |course: &Course| {
            let found = course.points.iter().find(|(x, _)| *x == *points as f64);
            found.map_or(String::new(), |(_, half)| shown(half * scale.factor))
        };
        std::iter::once(points.to_string()).chain(courses.iter().map(cell)).collect()
    };
    Table { head, rows: course.iter().map(row).collect(), verbatim: Vec::new() }
}
