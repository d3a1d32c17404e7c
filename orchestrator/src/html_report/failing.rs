//! Section about failed runs: where in the parameters runs fail, and in which regimes they are.

use super::Subject;
use super::rows::{Coordinate, OfKind, Picked, Seen};
use super::words::percent;
use super::worst::command;
use crate::terminal::{Ran, advice, cause_in_words};
use bladeoff_answers::figures::Scale;
use bladeoff_answers::page::chart::{Axis, COLOURS, Chart, Coordinate as Drawn, Series, Shape, Symbol, parallel};
use bladeoff_answers::page::{Block, Explorer, Figure, Plot, Table};
use bladeoff_model::machine::Engine;
use bladeoff_model::outcome::Cause;

/// Largest number of ok runs drawn as lines in parallel coordinates: more lines merge into a grey area.
const MOST_LINES: usize = 500;

/// The number of runs that are not ok, their causes, and their parameters.
pub(super) fn failures(seen: &Seen, subject: Subject<'_>) -> Vec<Block> {
    let bad: Vec<&OfKind> = seen.kinds.iter().filter(|of| of.kind.0 != "ok").collect();
    let mut blocks = Vec::new();
    if seen.rows == 0 {
        return vec![Block::Text("No run has ended yet.".to_owned())];
    }
    if bad.is_empty() {
        blocks.push(Block::Text(match seen.rows {
            1 => "The run is ok.".to_owned(),
            rows => format!("All {rows} runs are ok."),
        }));
    } else {
        blocks.push(Block::Table(causes(&bad, seen, subject)));
        blocks.push(Block::Note(
            "failed: ended early. Invalid: finished, but a validity check failed. Beyond: exceeded a limit of the \
             physical model, with all numerical checks passed. Quarantined: its process ended repeatedly."
                .to_owned(),
        ));
    }
    let shown: Vec<Shown> =
        seen.coordinates.iter().enumerate().filter_map(|(at, of)| Shown::of(seen, at, of)).collect();
    if shown.len() < 2 {
        return blocks;
    }
    blocks.push(Block::Note(thinned(seen)));
    blocks.push(scatter(seen, &shown).into());
    blocks.push(lines(seen, &shown).into());
    blocks
}

fn causes(bad: &[&OfKind], seen: &Seen, subject: Subject<'_>) -> Table {
    let head = ["status", "cause", "runs", "share", "meaning and advice", "details of the first"];
    let rows = bad.iter().map(|OfKind { kind: (status, cause), count, first }| {
        let known = Cause::from_word(cause);
        let is_function = subject.samples.study().function().is_some();
        let means = match known {
            _ if is_function => "a formula has no finite value there".to_owned(),
            Some(cause) => {
                // the advice is for several runs, which may be in different regimes
                let ran = Ran { engine: engine_of(subject, *first), is_backward: false, has_one_point: false };
                format!("{}. Try: {}", cause_in_words(cause), advice(cause, ran).text)
            }
            None => String::new(),
        };
        let why = command("why", subject.directory, &[&first.to_string()]);
        vec![status.clone(), cause.clone(), count.to_string(), percent(*count as f64 / seen.rows as f64), means, why]
    });
    Table { head: head.map(str::to_owned).to_vec(), rows: rows.collect(), verbatim: vec![5] }
}

/// The engine of a sample; for a machine that can no longer be built, the engine of most studies.
fn engine_of(subject: Subject<'_>, sample: u64) -> Engine {
    let machine = subject.samples.try_machine(sample).ok().flatten().and_then(|machine| machine.build().ok());
    machine.map_or(Engine::Reduced, |machine| machine.run.engine)
}

/// A coordinate with its values in the unit shown to the reader.
struct Shown {
    label: String,
    /// Values by picked row.
    values: Vec<Option<f64>>,
    words: Vec<String>,
    is_result: bool,
}

impl Shown {
    /// The coordinate as it is shown; `None` if no row has a value, or all rows have the same word.
    fn of(seen: &Seen, at: usize, coordinate: &Coordinate) -> Option<Self> {
        let values = || seen.picked.iter().map(|row| row.values[at]);
        let largest = values().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
        let words = seen.words[at].clone();
        values().any(|value| value.is_some()).then_some(())?;
        if coordinate.is_word {
            let values = values().collect();
            return (words.len() > 1).then(|| Self { label: coordinate.name.clone(), values, words, is_result: false });
        }
        let scale = Scale::of(&coordinate.unit, largest);
        let values = values().map(|value| value.map(|value| value * scale.factor)).collect();
        Some(Self { label: scale.label(&coordinate.name), values, words: Vec::new(), is_result: coordinate.is_result })
    }
}

/// Names of the kinds of rows, "ok" first.
fn kinds(seen: &Seen) -> Vec<String> {
    let name = |of: &OfKind| if of.kind.0 == "ok" { "ok".to_owned() } else { format!("{}: {}", of.kind.0, of.kind.1) };
    let mut names: Vec<String> = seen.kinds.iter().map(name).collect();
    if names.first().is_none_or(|first| first != "ok") {
        names.insert(0, "ok".to_owned());
    }
    names
}

/// Index of a row's kind in [`kinds`].
fn kind_of(seen: &Seen, row: &Picked) -> usize {
    let has_ok = seen.kinds.first().is_some_and(|first| first.kind.0 == "ok");
    row.kind + usize::from(!has_ok)
}

/// Sentence about how many rows are shown and how many are left out.
fn thinned(seen: &Seen) -> String {
    let all = seen.picked.len() as u64;
    if all == seen.rows {
        return format!("Below: {}.", if all == 1 { "the one run".to_owned() } else { format!("all {all} runs") });
    }
    let kept = |of: usize| seen.picked.iter().filter(|row| row.kind == of).count() as u64;
    let parts = seen.kinds.iter().enumerate().map(|(at, of)| {
        let name = if of.kind.0 == "ok" { "ok".to_owned() } else { format!("{} by {}", of.kind.0, of.kind.1) };
        match kept(at) {
            shown if shown == of.count => format!("all {shown} {name}"),
            shown => format!("{shown} of {} {name}", of.count),
        }
    });
    format!(
        "Below: {} of {} runs, chosen by a hash of their numbers: {}.",
        all,
        seen.rows,
        parts.collect::<Vec<_>>().join(", ")
    )
}

/// Scatter plot over two coordinates; with scripts the reader can choose any two.
fn scatter(seen: &Seen, shown: &[Shown]) -> Figure {
    let kinds = kinds(seen);
    let kind: Vec<usize> = seen.picked.iter().map(|row| kind_of(seen, row)).collect();
    // numeric coordinates first; if no run failed, a result over a parameter shows more than two parameters
    let is_number = |at: &usize| shown[*at].words.is_empty();
    let x = (0..shown.len()).find(is_number).unwrap_or(0);
    let failed = seen.ok() < seen.rows;
    let parameter = (0..shown.len()).find(|at| *at != x && is_number(at) && !shown[*at].is_result);
    let result = (0..shown.len()).find(|at| *at != x && shown[*at].is_result);
    let y = if failed { parameter.or(result) } else { result.or(parameter) };
    let y = y.unwrap_or(usize::from(x == 0));
    let axis = |at: usize| {
        let of: &Shown = &shown[at];
        match &of.words[..] {
            [] => Axis::numbers(of.label.clone(), of.values.iter().flatten().copied()),
            words => Axis::words(words.to_vec()),
        }
    };
    let series = kinds.iter().enumerate().filter(|(of, _)| kind.contains(of)).map(|(of, name)| {
        let rows = kind.iter().enumerate().filter(|(_, kind)| **kind == of);
        let points = rows.filter_map(|(row, _)| Some((shown[x].values[row]?, shown[y].values[row]?))).collect();
        let (colour, symbol) = if of == 0 { ("quiet", Symbol::Speck) } else { (colour(of), Symbol::Cross) };
        Series { name: name.clone(), colour, shape: Shape::Dots(points, Vec::new(), symbol) }
    });
    let chart = Chart { x: axis(x), y: axis(y), series: series.collect(), height: 340 };
    let mut figure = chart.figure("Each point is a run; runs that are not ok are marked by their cause.", None);
    figure.plot = Some(Plot::Explorer(Explorer {
        columns: shown.iter().map(|of| (of.label.clone(), of.values.clone())).collect(),
        words: shown.iter().map(|of| of.words.clone()).collect(),
        samples: seen.picked.iter().map(|row| row.sample).collect(),
        kind,
        kinds,
        first: (x, y),
    }));
    figure
}

/// Colour of a kind, the same as in the page's script and in parallel coordinates.
fn colour(kind: usize) -> &'static str {
    COLOURS[[1, 0, 2, 3, 4, 5, 6][(kind - 1) % 7]]
}

fn lines(seen: &Seen, shown: &[Shown]) -> Figure {
    let mut good = 0;
    // rows are in the order of their sample numbers, so that every n-th row is a selection independent of the results
    let goods = seen.picked.iter().filter(|row| kind_of(seen, row) == 0).count();
    let step = goods.div_ceil(MOST_LINES).max(1);
    let rows: Vec<usize> = (0..seen.picked.len())
        .filter(|row| {
            if kind_of(seen, &seen.picked[*row]) != 0 {
                return true;
            }
            good += 1;
            (good - 1) % step == 0
        })
        .collect();
    let coordinates: Vec<Drawn> = shown
        .iter()
        .map(|of| Drawn {
            label: of.label.clone(),
            values: rows.iter().map(|row| of.values[*row]).collect(),
            words: of.words.clone(),
        })
        .collect();
    let kind: Vec<usize> = rows.iter().map(|row| kind_of(seen, &seen.picked[*row])).collect();
    let drawing = parallel(&coordinates, &kind, &kinds(seen));
    let lines = if step == 1 { String::new() } else { format!(" {} of the ok runs are drawn.", goods.div_ceil(step)) };
    let caption = format!("Each line is a run, from its parameters on the left to its results on the right.{lines}");
    Figure { caption, drawing, plot: None, table: None }
}
