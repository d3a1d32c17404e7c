//! Text answers of maps: extreme values, and the share of the cells that an event reaches.

use super::answer::Answer;
use super::scale::Scale;
use super::sentence::counted;
use crate::estimate::bad::Bad;
use crate::estimate::figures::{Figures, Method};
use crate::map::{Cell, Map, Of, Shows, Wanted};
use crate::share::percent;
use bladeoff_text::document::units::format_digits;

/// Short text of a map: "max_bearing_load_N over gap_m and friction, a panel for each detection".
pub(super) fn map_in_words(wanted: &Wanted) -> String {
    let of = match &wanted.of {
        Of::Value(column) => column.clone(),
        Of::Probability(formula) => format!("P({})", formula.text),
    };
    let mut text = format!("map of {of} over {} and {}", wanted.x, wanted.y);
    if !wanted.panels.is_empty() {
        text += &format!(", a panel for each {}", wanted.panels.join(", "));
    }
    if !wanted.starts.is_empty() {
        text += &format!(", starts: {}", wanted.starts.join(", "));
    }
    text
}

/// One answer for each panel and for each difference.
pub(super) fn answers_of(name: &str, maps: Vec<Map>) -> Vec<Answer> {
    let answer = |map: Map| {
        let mut figures = Figures::over(map.n);
        figures.method = Method::Without;
        figures.approximate = map.is_smoothed();
        figures.notes.clone_from(&map.notes);
        let mut answer = Answer::of(name, "map", map.group.clone(), bad_of(&map), map.confidence, figures);
        let panel = if map.panel.is_empty() { String::new() } else { format!("{}: ", map.panel) };
        answer.sentence = panel + &sentence(&map);
        answer.map = Some(Box::new(map));
        answer
    };
    maps.into_iter().map(answer).collect()
}

fn sentence(map: &Map) -> String {
    let what = match map.shows {
        Shows::Value | Shows::Probability => map.of.clone(),
        Shows::Median => format!("median of {}", map.of),
        Shows::SmoothedMean | Shows::SmoothedProbability => format!("{} (smoothed)", map.of),
    };
    let less = if map.less.is_empty() { String::new() } else { format!(", {},", map.less) };
    let mut text = format!("{what}{less} over {} and {}: ", map.x.column, map.y.column);
    let runs = if map.difference.is_some() { "pair" } else { "run" };
    let show =
        |value: f64| if map.is_share() { percent(not_rounded(value)) } else { format_digits(value, &map.unit, 4) };
    // smoothing reduces the maximum, so the range of single runs is printed, too
    let single = map
        .runs
        .map_or(String::new(), |(least, most)| format!("; single {runs}s from {} to {}", show(least), show(most)));
    // the maximum uses bad runs as harmful, the minimum as harmless; a single figure of a grid cell is a valid bound, of other cells not
    let needs_both = map.is_smoothed() || map.difference.is_some();
    let is_told = |cell: &&Cell| match (cell.estimate, cell.estimate_if_bad_harmful) {
        _ if map.is_unsure(cell) => false,
        (Some(_), Some(_)) => true,
        (None, None) => false,
        _ => !needs_both,
    };
    let known =
        |of: fn(&Cell) -> Option<f64>| map.cells.iter().filter(is_told).filter_map(move |cell| Some((of(cell)?, cell)));
    let harmful: fn(&Cell) -> Option<f64> = |cell| cell.estimate_if_bad_harmful;
    let harmless: fn(&Cell) -> Option<f64> = |cell| cell.estimate;
    let largest = |of| known(of).max_by(|a, b| a.0.total_cmp(&b.0));
    let least = |of| known(of).min_by(|a, b| a.0.total_cmp(&b.0));
    let cells_told = map.cells.iter().filter(is_told).count();
    // a cell whose bad runs leave it without a value may contain the extreme one
    let is_open = |of: fn(&Cell) -> Option<f64>| {
        map.cells.iter().any(|cell| map.is_unsure(cell) || cell.bad > 0 && of(cell).is_none())
    };
    let has_highest = known(harmful).count() == cells_told && !is_open(harmful);
    let has_lowest = known(harmless).count() == cells_told && !is_open(harmless);
    // if a cell has no harmful figure, the largest harmless one is a lower bound of the maximum
    let highest = if has_highest { largest(harmful) } else { largest(harmless) };
    let lowest = if has_lowest { least(harmless) } else { least(harmful) };
    let (Some(highest), Some(lowest)) = (highest, lowest) else {
        let why = if map.undrawn == Some(map.n) { ", too few to be smoothed" } else { "" };
        return text + &format!("no cell has a number, {}{why}", counted(map.n, runs)) + &single + &bad(map);
    };
    let at = |cell: &Cell| {
        let along = |axis: &crate::map::Axis, value: f64| format_digits(value, &axis.unit, 4);
        format!("{} and {}", along(&map.x, cell.x), along(&map.y, cell.y))
    };
    if map.difference.is_some() {
        text += &format!("from {} at {} to {} at {}", show(lowest.0), at(lowest.1), show(highest.0), at(highest.1));
    } else {
        let (most, fewest) = (if has_highest { "at most" } else { "the largest at least" }, show(lowest.0));
        text += &format!("{most} {}, at {}", show(highest.0), at(highest.1));
        text += &if has_lowest { format!("; at least {fewest}") } else { format!("; the least at most {fewest}") };
    }
    text += &single;
    if map.runs.is_some_and(|(least, most)| lowest.0 < least || highest.0 > most) && map.difference.is_none() {
        text += " (the smoothed curve goes beyond them)";
    }
    let cells = map.cells.len();
    if map.is_share() && map.difference.is_none() {
        let counts = |is: fn(f64) -> bool| {
            let [least, most] = [harmless, harmful].map(|of| known(of).filter(|(share, _)| is(*share)).count());
            let share = |count: usize| count as f64 / cells.max(1) as f64;
            if least == most {
                return part(most, cells, map.refined);
            }
            if map.refined {
                return format!("{least} to {most} cells");
            }
            let (least, most) = Scale::Share.show_both(share(least), share(most));
            format!("{least} to {most} of the cells")
        };
        text +=
            &format!("; half or more in {}, above 0 in {}", counts(|share| share >= 0.5), counts(|share| share > 0.0));
    }
    let open = map
        .cells
        .iter()
        .filter(|cell| {
            map.is_unsure(cell) || cell.bad > 0 && (cell.estimate_if_bad_harmful.is_none() || cell.estimate.is_none())
        })
        .count();
    if open > 0 && (!map.is_share() || map.difference.is_some()) {
        let which = if map.difference.is_some() { "bad runs" } else { map.bad_in_words() };
        text += &format!("; open, because of {which}, in {}", part(open, cells, map.refined));
    }
    let regimes = map.regimes.iter().filter_map(|word| {
        let count = map.cells.iter().filter(|cell| cell.regime.as_ref() == Some(word)).count();
        (count > 0).then(|| format!("{word} in {}", part(count, cells, map.refined)))
    });
    let regimes: Vec<String> = regimes.collect();
    if !regimes.is_empty() {
        text += &format!("; most frequent regime of ok runs: {}", regimes.join(", "));
    }
    text + &format!("; {}, {}", counted(cells as u64, "cell"), counted(map.n, runs)) + &bad(map)
}

/// Rounds a smoothed share to 0 or 1 if the difference is a rounding error.
fn not_rounded(share: f64) -> f64 {
    let whole = libm::rint(share);
    if (share - whole).abs() < 1e-12 { whole } else { share }
}

/// A number of cells with its share; no share for cells chosen by `[refine]`, which would not be that of the map.
fn part(count: usize, of: usize, is_refined: bool) -> String {
    if is_refined {
        return counted(count as u64, "cell");
    }
    percent(count as f64 / of.max(1) as f64) + " of the cells"
}

/// Counts of runs that are not ok, or of pairs with such a run.
fn bad_of(map: &Map) -> Bad {
    Bad { of: map.n, all: map.bad, beyond: map.beyond, ..Bad::default() }
}

/// Text such as "12 bad runs"; in a difference, pairs with at least one such run.
fn bad_ones(map: &Map) -> String {
    if map.difference.is_some() {
        let of = |count: u64, what: &str| (count > 0).then(|| format!("{} with {what}", counted(count, "pair")));
        let both = [of(map.failing(), "a bad run"), of(map.beyond, "a run beyond the model")];
        return both.into_iter().flatten().collect::<Vec<_>>().join(" and ");
    }
    bad_of(map).words()
}

fn bad(map: &Map) -> String {
    if map.bad == 0 {
        return String::new();
    }
    if map.is_smoothed() {
        return format!(", {}", bad_ones(map));
    }
    let cells = map.cells.iter().filter(|cell| cell.bad > 0).count() as u64;
    format!(", {} in {}", bad_ones(map), counted(cells, "cell"))
}
