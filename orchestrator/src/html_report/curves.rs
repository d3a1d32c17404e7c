//! Exceedance and fragility curves with their bands.

use super::words::{Quantity, group};
use crate::questions::Answering;
use crate::run::TableColumn;
use bladeoff_answers::ask::{Ask, Question};
use bladeoff_answers::estimate::curve::{Curve, CurveCells};
use bladeoff_answers::estimate::input::{Group, Label};
use bladeoff_answers::page::Block;
use bladeoff_answers::page::chart::{Axis, COLOURS, Chart, Series, Shape, Symbol};

/// Largest number of groups that are drawn, and of points of a curve.
const MOST_CURVES: usize = 6;
const MOST_POINTS: usize = 400;
/// Largest number of points of a curve that are drawn one by one.
const MOST_WHISKERS: usize = 12;

/// A point of a curve as it is drawn.
struct Drawn {
    /// Position, and the ends of its bin.
    x: f64,
    ends: (f64, f64),
    estimate: Option<f64>,
    harmful: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
}

/// The chart of a question that has a curve.
pub(super) fn curve(answering: &Answering, question: &Question, columns: &[TableColumn]) -> Option<Block> {
    let (_, curve) = answering.curves.iter().find(|(name, _)| *name == question.name)?;
    match &question.ask {
        Ask::Exceedance(column) => exceedance(question, column, curve, columns),
        Ask::Fragility(path, formula) => fragility(question, path, &formula.text, curve, columns),
        _ => None,
    }
}

fn cells<'a>(curve: &'a Curve, name: &str) -> &'a [Option<f64>] {
    curve.numbers(name).unwrap_or_default()
}

/// Rows of each group, in order; the first `axes` columns are those of the group.
fn groups(curve: &Curve, axes: usize) -> Vec<(Group, Vec<usize>)> {
    let rows = cells(curve, "estimate").len();
    let label = |(name, cells): &(String, CurveCells), row: usize| {
        let label = match cells {
            CurveCells::Numbers(numbers) => numbers[row].map(Label::Number),
            CurveCells::Words(words) => words[row].clone().map(Label::Word),
        };
        (name.clone(), label.unwrap_or(Label::Word(String::new())))
    };
    let mut groups: Vec<(Group, Vec<usize>)> = Vec::new();
    for row in 0..rows {
        let group = Group(curve.columns[..axes].iter().map(|column| label(column, row)).collect());
        match groups.last_mut() {
            Some((last, rows)) if *last == group => rows.push(row),
            _ => groups.push((group, vec![row])),
        }
    }
    groups
}

/// Columns of the group: those before the positions, which are followed by `n`.
fn axes(curve: &Curve, places: usize) -> usize {
    let n = curve.columns.iter().position(|(name, _)| name == "n").unwrap_or(places);
    n.saturating_sub(places)
}

fn drawn(curve: &Curve, rows: &[usize], place: impl Fn(usize) -> (f64, f64)) -> Vec<Drawn> {
    let [estimate, harmful, low, high] =
        ["estimate", "estimate_if_bad_harmful", "low", "high"].map(|name| cells(curve, name));
    let all = rows.len();
    // both ends are kept
    let step = all.div_ceil(MOST_POINTS).max(1);
    let chosen = rows.iter().enumerate().filter(|(at, _)| at % step == 0 || at + 1 == all).map(|(_, row)| *row);
    chosen
        .map(|row| {
            let ends = place(row);
            let x = (ends.0 + ends.1) / 2.0;
            Drawn { x, ends, estimate: estimate[row], harmful: harmful[row], low: low[row], high: high[row] }
        })
        .collect()
}

fn exceedance(question: &Question, column: &str, curve: &Curve, columns: &[TableColumn]) -> Option<Block> {
    let axes = axes(curve, 1);
    let CurveCells::Numbers(levels) = &curve.columns.get(axes)?.1 else { return None };
    let largest = levels.iter().flatten().fold(0.0_f64, |most, level| most.max(level.abs()));
    let quantity = Quantity::column(columns, column, None, largest);
    let level = |row: usize| {
        let x = quantity.show(levels[row].unwrap_or(f64::NAN));
        (x, x)
    };
    let groups = groups(curve, axes);
    let mut series = Vec::new();
    // a zero estimate cannot be drawn on a logarithmic axis
    let n = cells(curve, "n").iter().flatten().fold(1.0_f64, |most, n| most.max(*n));
    let least = 0.5 / n;
    let mut across = Vec::new();
    for (at, (of, rows)) in groups.iter().take(MOST_CURVES).enumerate() {
        let points = drawn(curve, rows, level);
        across.extend(points.iter().map(|point| point.x));
        lines(&mut series, COLOURS[at], &group(of), &points, |share| share.max(least));
    }
    let chart = Chart {
        x: Axis::numbers(quantity.label(), across.into_iter()),
        y: Axis::log("probability of more", [least, 1.0].into_iter()).from_to(least, 1.3),
        series,
        height: 320,
    };
    Some(
        chart
            .figure(
                caption(question, &format!("probability that {} exceeds a level", quantity.name), groups.len()),
                None,
            )
            .into(),
    )
}

fn caption(question: &Question, what: &str, groups: usize) -> String {
    let percent = super::words::percent(question.confidence);
    let cut = if groups > MOST_CURVES {
        format!(" The first {MOST_CURVES} of {groups} groups are drawn.")
    } else {
        String::new()
    };
    format!("{}: {what}. With {percent} limits.{cut}", question.name)
}

/// Band, estimate, and the estimate with bad runs counted as harmful if that differs.
fn lines(series: &mut Vec<Series>, colour: &'static str, name: &str, points: &[Drawn], shown: impl Fn(f64) -> f64) {
    let named = |what: &str| if name.is_empty() { what.to_owned() } else { format!("{name}: {what}") };
    let band: Vec<_> =
        points.iter().filter_map(|point| Some((point.x, shown(point.low?), shown(point.high?)))).collect();
    if !band.is_empty() {
        series.push(Series { name: named("limits"), colour, shape: Shape::Band(band) });
    }
    let line = points.iter().filter_map(|point| Some((point.x, shown(point.estimate?)))).collect();
    series.push(Series { name: named("estimate"), colour, shape: Shape::Line(line, false) });
    if points.iter().any(|point| point.harmful != point.estimate) {
        let line = points.iter().filter_map(|point| Some((point.x, shown(point.harmful?)))).collect();
        series.push(Series { name: named("if bad runs are harmful"), colour, shape: Shape::Line(line, true) });
    }
}

fn fragility(question: &Question, path: &str, event: &str, curve: &Curve, columns: &[TableColumn]) -> Option<Block> {
    let axes = axes(curve, 2);
    let [(_, from), (_, to)] = curve.columns.get(axes..axes + 2)? else { return None };
    let groups = groups(curve, axes);
    let what = format!("probability of {event}, over {path}");
    // the axis ends at the largest limit, because 3 % on an axis of 100 % would be invisible
    let shares = ["estimate", "estimate_if_bad_harmful", "high"].into_iter().flat_map(|name| cells(curve, name));
    let most = shares.flatten().fold(0.0_f64, |most, share| most.max(100.0 * share));
    let y =
        |series, x, height| Chart { x, y: Axis::numbers("probability [%]", [0.0, most].into_iter()), series, height };
    let (CurveCells::Numbers(from), CurveCells::Numbers(to)) = (from, to) else {
        return by_words(question, &what, curve, from, &groups);
    };
    let largest = to.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    let quantity = Quantity::column(columns, path, None, largest);
    let end = |cells: &[Option<f64>], row: usize| quantity.show(cells[row].unwrap_or(f64::NAN));
    let mut series = Vec::new();
    let mut across = Vec::new();
    for (at, (of, rows)) in groups.iter().take(MOST_CURVES).enumerate() {
        let points = drawn(curve, rows, |row| (end(from, row), end(to, row)));
        across.extend(points.iter().flat_map(|point| [point.ends.0, point.ends.1]));
        // between a few chosen values no line is drawn
        if points.iter().all(|point| point.ends.0 == point.ends.1) && points.len() <= MOST_WHISKERS {
            let intervals = points
                .iter()
                .map(|point| (point.x, point.low.map(|low| 100.0 * low), point.high.map(|high| 100.0 * high)));
            let intervals = Shape::Upright(intervals.collect());
            let of = group(of);
            let name = if of.is_empty() { "limits".to_owned() } else { of };
            series.push(Series { name, colour: COLOURS[at], shape: intervals });
            let harmful = points.iter().filter(|point| point.harmful != point.estimate);
            let harmful: Vec<_> = harmful.filter_map(|point| Some((point.x, 100.0 * point.harmful?))).collect();
            if !harmful.is_empty() {
                let shape = Shape::Dots(harmful, Vec::new(), Symbol::Ring);
                series.push(Series { name: "if bad runs are harmful".into(), colour: COLOURS[at], shape });
            }
        } else {
            lines(&mut series, COLOURS[at], &group(of), &points, |share| 100.0 * share);
        }
        let dots: Vec<(f64, f64)> =
            points.iter().filter_map(|point| Some((point.x, 100.0 * point.estimate?))).collect();
        let said = points.iter().filter(|point| point.estimate.is_some()).map(|point| {
            let show = |value: Option<f64>| value.map_or("?".to_owned(), super::words::percent);
            let (from, to) = point.ends;
            let unit = &quantity.scale.unit;
            let (from, to) = (bladeoff_answers::page::chart::shown(from), bladeoff_answers::page::chart::shown(to));
            format!("{from} to {to} {unit}: {} ({} to {})", show(point.estimate), show(point.low), show(point.high))
        });
        let said = said.collect();
        series.push(Series { name: String::new(), colour: COLOURS[at], shape: Shape::Dots(dots, said, Symbol::Disc) });
    }
    let x = Axis::numbers(quantity.label(), across.into_iter());
    Some(y(series, x, 280).figure(caption(question, &what, groups.len()), None).into())
}

/// For words there are no lines, but intervals, one below the other.
fn by_words(
    question: &Question,
    what: &str,
    curve: &Curve,
    from: &CurveCells,
    groups: &[(Group, Vec<usize>)],
) -> Option<Block> {
    let CurveCells::Words(words) = from else { return None };
    let mut names = Vec::new();
    let (mut dots, mut harmful, mut intervals) = (Vec::new(), Vec::new(), Vec::new());
    for (of, rows) in groups.iter().take(MOST_CURVES) {
        for point in drawn(curve, rows, |row| (row as f64, row as f64)) {
            let at = names.len() as f64;
            let word = words[point.x as usize].clone().unwrap_or_default();
            let of = group(of);
            names.push(if of.is_empty() { word } else { format!("{of}, {word}") });
            dots.extend(point.estimate.map(|share| (100.0 * share, at)));
            harmful.extend(point.harmful.filter(|_| point.harmful != point.estimate).map(|share| (100.0 * share, at)));
            intervals.push((at, point.low.map(|share| 100.0 * share), point.high.map(|share| 100.0 * share)));
        }
    }
    let mut series = vec![
        Series { name: "limits".into(), colour: "c0", shape: Shape::Across(intervals) },
        Series { name: "estimate".into(), colour: "c0", shape: Shape::Dots(dots, Vec::new(), Symbol::Disc) },
    ];
    if !harmful.is_empty() {
        series.push(Series {
            name: "if bad runs are harmful".into(),
            colour: "c1",
            shape: Shape::Dots(harmful, Vec::new(), Symbol::Ring),
        });
    }
    let height = 30 + 30 * names.len() as u32;
    let chart =
        Chart { x: Axis::numbers("probability [%]", [0.0, 100.0].into_iter()), y: Axis::words(names), series, height };
    Some(chart.figure(caption(question, what, groups.len()), None).into())
}
