//! Histograms over all rows: the uncertain inputs as drawn, and the results that questions and gates name.

use super::rows::{Coordinate, Held};
use super::words::status_in_words;
use bladeoff_answers::ask::{Ask, Figure, Question};
use bladeoff_answers::estimate::formula::Formula;
use bladeoff_answers::figures::Scale;
use bladeoff_answers::gate::Gate;
use bladeoff_answers::page::Block;
use bladeoff_answers::page::chart::{Axis, Chart, Series, Shape, shown};
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{Table, TableError};
use bladeoff_study::{Origin, Samples};
use bladeoff_text::document::units::{format_digits, parse_any_quantity};
use std::path::PathBuf;

/// Limits of the number of bins, which is the square root of the number of values.
const BINS: (usize, usize) = (6, 40);
/// Height of the frame of an input, and of a result.
const HEIGHTS: (u32, u32) = (70, 150);

/// Number of runs in equal bins of one coordinate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Histogram {
    /// Smallest and largest value.
    range: (f64, f64),
    /// Number of ok runs by bin.
    ok: Vec<u64>,
    /// Number of runs that are not ok by bin; for a result by the value before a guard or limit was exceeded.
    others: Vec<u64>,
    /// Number of runs without a value.
    without: u64,
}

/// Histograms of the coordinates; `None` for words, and if no row has a value.
///
/// # Errors
/// A table cannot be read.
pub(super) fn histograms(files: &[PathBuf], coordinates: &[Coordinate]) -> Result<Vec<Option<Histogram>>, TableError> {
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY, 0_u64); coordinates.len()];
    for_each_value(files, coordinates, |at, value, _| {
        let Some(value) = value else { return };
        let (low, high, count) = &mut ranges[at];
        (*low, *high, *count) = (low.min(value), high.max(value), *count + 1);
    })?;
    let empty = |(low, high, count): &(f64, f64, u64)| {
        // the difference of two huge values may be infinite
        let bins = ((*count as f64).sqrt().ceil() as usize).clamp(BINS.0, BINS.1);
        let bins = if high > low && (high - low).is_finite() { bins } else { 1 };
        (*count > 0).then(|| Histogram { range: (*low, *high), ok: vec![0; bins], others: vec![0; bins], without: 0 })
    };
    let mut found: Vec<Option<Histogram>> = ranges.iter().map(empty).collect();
    for_each_value(files, coordinates, |at, value, is_ok| {
        let Some(histogram) = &mut found[at] else { return };
        match value {
            None => histogram.without += 1,
            Some(value) => {
                let bin = histogram.bin(value);
                let counts = if is_ok { &mut histogram.ok } else { &mut histogram.others };
                counts[bin] += 1;
            }
        }
    })?;
    Ok(found)
}

/// Calls a function with every row's value of every numeric coordinate, and whether the row is ok.
fn for_each_value(
    files: &[PathBuf],
    coordinates: &[Coordinate],
    mut visit: impl FnMut(usize, Option<f64>, bool),
) -> Result<(), TableError> {
    let mut names = vec!["status"];
    for of in coordinates.iter().filter(|of| !of.is_word) {
        names.push(&of.column);
        if let Held::Reached(column) = &of.held {
            names.push(column);
        }
    }
    names.sort_unstable();
    names.dedup();
    Table::for_each_piece(files, &names, |piece| {
        let status = piece.words("status").unwrap_or_default();
        for (at, of) in coordinates.iter().enumerate().filter(|(_, of)| !of.is_word) {
            let numbers = piece.numbers(&of.column).unwrap_or_default();
            let reached = match &of.held {
                Held::Reached(column) => piece.numbers(column),
                Held::Once | Held::Nothing => None,
            };
            for row in 0..piece.rows() {
                let is_ok = status.get(row).is_some_and(|status| status.as_deref() == Some("ok"));
                let cells = if is_ok || !of.is_result { Some(numbers) } else { reached };
                let value = cells.and_then(|cells| *cells.get(row)?).filter(|value| value.is_finite());
                visit(at, value, is_ok);
            }
        }
        Ok(())
    })
}

impl Histogram {
    fn bin(&self, value: f64) -> usize {
        let (low, high) = self.range;
        let bins = self.ok.len();
        let share = if bins > 1 { (value - low) / (high - low) } else { 0.0 };
        ((share * bins as f64) as usize).min(bins - 1)
    }

    /// Whether a limit is near enough to the values for both to be visible in one figure.
    fn is_near(&self, limit: f64) -> bool {
        let (low, high) = self.range;
        let room = 2.0 * (high - low).max(0.02 * high.abs());
        (low - room..=high + room).contains(&limit)
    }

    fn runs(&self) -> u64 {
        self.ok.iter().chain(&self.others).sum()
    }

    /// The chart of a coordinate; `at`: values that are marked.
    fn chart(&self, of: &Coordinate, at: &[f64], height: u32) -> Chart {
        let (low, high) = self.range;
        let scale = Scale::of(&of.unit, low.abs().max(high.abs()));
        let bins = self.ok.len() as f64;
        // equal values have a bar with a width relative to the value
        let width = if high > low { (high - low) / bins } else { low.abs().max(1.0) * 0.02 };
        let start = if high > low { low } else { low - 0.5 * width };
        let edge = |bin: usize| (start + width * bin as f64) * scale.factor;
        let most = self.ok.iter().zip(&self.others).map(|(ok, other)| ok + other).max().unwrap_or(1) as f64;
        let steps = |from: &dyn Fn(usize) -> u64, to: &dyn Fn(usize) -> u64| {
            let one = |bin: usize| [edge(bin), edge(bin + 1)].map(|x| (x, from(bin) as f64, to(bin) as f64));
            Shape::Band((0..self.ok.len()).flat_map(one).collect())
        };
        let outline = |top: &dyn Fn(usize) -> u64| {
            let mut line = vec![(edge(0), 0.0)];
            line.extend((0..self.ok.len()).flat_map(|bin| [edge(bin), edge(bin + 1)].map(|x| (x, top(bin) as f64))));
            line.push((edge(self.ok.len()), 0.0));
            Shape::Line(line, false)
        };
        let (ok, all) = (|bin: usize| self.ok[bin], |bin: usize| self.ok[bin] + self.others[bin]);
        let has_others = self.others.iter().any(|count| *count > 0);
        let mut series = Vec::new();
        let mut add = |name: &str, colour, shape| series.push(Series { name: name.to_owned(), colour, shape });
        if has_others {
            add(if of.is_result { "not ok: a lower bound" } else { "not ok" }, "bad", steps(&ok, &all));
            add("", "bad", outline(&all));
        }
        add(if has_others { "ok" } else { "" }, "c0", steps(&|_| 0, &ok));
        add("", "c0", outline(&ok));
        for value in at.iter().filter(|value| self.is_near(**value)) {
            add(
                &format!("limit {}", format_digits(*value, &of.unit, 6)),
                "ink",
                Shape::Line([0.0, 1.08 * most].map(|y| (value * scale.factor, y)).to_vec(), true),
            );
        }
        let near = at.iter().filter(|value| self.is_near(**value)).map(|value| value * scale.factor);
        let ends = [edge(0), edge(self.ok.len())].into_iter().chain(near);
        Chart {
            x: Axis::numbers(scale.label(&of.name), ends),
            y: Axis::numbers("runs", [].into_iter()).from_to(0.0, 1.08 * most),
            series,
            height,
        }
    }

    fn figure(&self, of: &Coordinate, at: &[f64], height: u32) -> Block {
        let scale = Scale::of(&of.unit, self.range.0.abs().max(self.range.1.abs()));
        let number = |value: f64| shown(value * scale.factor);
        let unit = if scale.unit.is_empty() { String::new() } else { format!(" {}", scale.unit) };
        let mut caption = format!(
            "{}: {}, {} to {}{unit}.",
            of.name,
            counted(self.runs(), "run"),
            number(self.range.0),
            number(self.range.1)
        );
        for value in at.iter().filter(|value| !self.is_near(**value)) {
            caption += &format!(" The limit {} is far outside.", format_digits(*value, &of.unit, 6));
        }
        if self.without > 0 {
            caption += &format!(" Without a value: {}.", counted(self.without, "run"));
        }
        if of.is_result && self.others.iter().any(|count| *count > 0) {
            caption += &format!(
                " For runs that are {}, invalid or failed it is the value before the limit or guard was exceeded.",
                status_in_words("beyond")
            );
        }
        self.chart(of, at, height).figure(caption, None).into()
    }
}

/// Histograms of the inputs that were drawn at random.
pub(super) fn inputs(samples: &Samples, coordinates: &[Coordinate], found: &[Option<Histogram>]) -> Vec<Block> {
    let is_drawn = |of: &Coordinate| {
        let named = samples.parameters().iter().find(|parameter| parameter.column().name == of.column);
        named.is_some_and(|parameter| !matches!(parameter.origin, Origin::Varied(..)))
    };
    let drawn = coordinates.iter().zip(found).filter(|(of, _)| !of.is_result && is_drawn(of));
    let drawn: Vec<Block> = drawn.filter_map(|(of, found)| Some(found.as_ref()?.figure(of, &[], HEIGHTS.0))).collect();
    let source = "The distributions are those of the study file, which is under \u{201c}Provenance\u{201d} with its \
                  comments. Read there whether they are data of the machine or examples.";
    let source = (!drawn.is_empty()).then(|| Block::Text(source.to_owned()));
    source.into_iter().chain(drawn).collect()
}

/// Histograms of the results that questions and gates name, with the limits.
pub(super) fn results(
    asked: &[String],
    (questions, gates): (&[Question], &[Gate]),
    coordinates: &[Coordinate],
    found: &[Option<Histogram>],
) -> Vec<Block> {
    let is_asked = |of: &Coordinate| of.is_result && asked.contains(&of.column);
    let results = coordinates.iter().zip(found).filter(|(of, _)| is_asked(of));
    let drawn =
        results.filter_map(|(of, found)| Some(found.as_ref()?.figure(of, &limits_in(of, questions, gates), HEIGHTS.1)));
    drawn.collect()
}

/// Values in comparisons of the column alone (no product or sum with another one) in questions and gates; each value once.
fn limits_in(of: &Coordinate, questions: &[Question], gates: &[Gate]) -> Vec<f64> {
    let of_question = questions.iter().filter_map(|question| match &question.ask {
        Ask::One(Figure::Probability(formula))
        | Ask::Difference(Figure::Probability(formula), ..)
        | Ask::Fragility(_, formula) => Some(formula),
        _ => None,
    });
    let formulas = of_question.chain(gates.iter().map(|gate| &gate.condition));
    let mut values: Vec<f64> = formulas.filter_map(|formula| limit_in(formula, of)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The number in `COLUMN > NUMBER` or `COLUMN < NUMBER`; `None` for another formula.
fn limit_in(formula: &Formula, of: &Coordinate) -> Option<f64> {
    if formula.columns != [of.column.clone()] || formula.text.matches(['<', '>']).count() != 1 {
        return None;
    }
    let (left, right) = formula.text.split_once(['<', '>'])?;
    let (left, right) = (left.trim(), right.trim_start_matches('=').trim());
    // a product, a sum or a function of the column is a different quantity
    let is_column = |side: &str| {
        let name = side.trim_matches('`');
        name.starts_with(|first: char| first.is_ascii_alphabetic())
            && name.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '.'))
    };
    let number = match (is_column(left), is_column(right)) {
        (true, false) => right,
        (false, true) => left,
        _ => return None,
    };
    parse_any_quantity(number).ok()
}
