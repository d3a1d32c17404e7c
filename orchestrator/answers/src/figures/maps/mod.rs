//! Maps of a study: colour by cell, contour lines, the boundary of regimes, bad runs, one picture for each panel and difference.
//!
//! ```text
//! maps -> pictures: a figure of each cell (median, 95 % value, share, smoothed value, half width of its limits) -> one scale of colour (colour)
//!   for all pictures of a kind -> side by side, marks of each scale at the contour lines
//! ```
//! A cell with bad runs is split: its lower left is as if they had been harmless, its upper right as if harmful, grey where that has no
//! number. Hatched is what has no sample, or too few.

mod colour;
mod layers;
mod picture;

use super::style::plain_name;
use super::{Figure, HEAD};
use crate::drawing::{Anchor, Rgb};
use crate::map::{Cell, Map, Shows};
use bladeoff_text::document::cut;
pub use colour::{Colours, Kind, STEPS, stepped};
pub use layers::{Layers, Picture};
use picture::draw;

/// Size of a picture, and of the lines that explain \[px\].
const WIDTH: u32 = 470;
const HEIGHT: u32 = 330;
const LINE: u32 = 18;
/// Characters of a name from outside, at most.
const NAME: usize = 70;

/// A cell of which something is not known.
pub const UNKNOWN: Rgb = Rgb(190, 190, 190);

/// The scales of colour of maps, one for all pictures of a kind: the same colour is the same value.
#[derive(Debug, Clone)]
pub struct MapScales(Vec<(Kind, Colours)>);

impl MapScales {
    /// For all pictures of these maps.
    #[must_use]
    pub fn of(maps: &[Map]) -> Self {
        let pictures: Vec<Picture<'_>> = maps.iter().flat_map(pictures_of).collect();
        let mut scales: Vec<(Kind, Colours)> = Vec::new();
        for picture in &pictures {
            if scales.iter().any(|(kind, _)| *kind == picture.kind) {
                continue;
            }
            let same = pictures.iter().filter(|other| other.kind == picture.kind);
            let values = same.flat_map(|other| {
                other.map.cells.iter().flat_map(|cell| {
                    let (harmless, harmful) = other.figures(cell);
                    harmless.into_iter().chain(harmful)
                })
            });
            let unit = if picture.map.is_share() { None } else { Some(picture.map.unit.as_str()) };
            scales.push((picture.kind, Colours::new(picture.kind, values, unit)));
        }
        Self(scales)
    }

    /// The scale of a kind, if a map had a picture of it.
    pub(crate) fn get(&self, kind: Kind) -> Option<&Colours> {
        self.0.iter().find(|(known, _)| *known == kind).map(|(_, colours)| colours)
    }
}

/// Draws the maps of one question.
#[must_use]
pub fn maps(title: &str, maps: &[Map]) -> Figure {
    maps_on(title, maps, &MapScales::of(maps))
}

/// Draws maps on scales that others share.
#[must_use]
pub fn maps_on(title: &str, maps: &[Map], scales: &MapScales) -> Figure {
    let pictures: Vec<Picture<'_>> = maps.iter().flat_map(pictures_of).collect();
    let doubled = maps.iter().any(|map| map.is_smoothed() || map.shows == Shows::Median);
    let columns = if doubled { 2 } else { pictures.len().clamp(1, 3) };
    let rows = pictures.len().max(1).div_ceil(columns);
    let told = explanation(maps);
    let size = (WIDTH * columns as u32, 40 + HEIGHT * rows as u32 + LINE * told.len() as u32 + 16);
    Figure::draw(size, &cut(title, 2 * NAME), |svg| {
        for (at, picture) in pictures.iter().enumerate() {
            let (column, row) = ((at % columns) as u32, (at / columns) as u32);
            if let Some(colours) = scales.get(picture.kind) {
                draw(svg, (f64::from(WIDTH * column), HEAD + f64::from(HEIGHT * row)), picture, colours);
            }
        }
        for (at, line) in told.iter().enumerate() {
            let y = HEAD + f64::from(HEIGHT * rows as u32 + LINE * at as u32) + 18.0;
            svg.text("", (16.0, y), Anchor::Start, line);
        }
    })
}

/// Both figures of a cell, with bad runs harmless and harmful.
pub type Pick = fn(&Cell) -> (Option<f64>, Option<f64>);

/// Whether both figures of a cell are drawn. A share that is smoothed includes bad runs of other cells; a mean has no figure for them.
fn is_split(cell: &Cell, (harmless, harmful): (Option<f64>, Option<f64>)) -> bool {
    harmless != harmful && (cell.bad > 0 || harmful.is_some())
}

fn middle(cell: &Cell) -> (Option<f64>, Option<f64>) {
    (cell.estimate, cell.estimate_if_bad_harmful)
}

fn upper(cell: &Cell) -> (Option<f64>, Option<f64>) {
    (cell.upper, cell.upper_if_bad_harmful)
}

fn half_width(cell: &Cell) -> (Option<f64>, Option<f64>) {
    (cell.half_width, cell.half_width)
}

/// What a map is of: a column in words, a condition as it was written.
pub fn of_in_words(map: &Map) -> String {
    match map.shows {
        Shows::Probability | Shows::SmoothedProbability => map.of.clone(),
        Shows::Value | Shows::Median | Shows::SmoothedMean => plain_name(&map.of, &map.unit),
    }
}

/// The pictures of a map.
pub fn pictures_of(map: &Map) -> Vec<Picture<'_>> {
    // which panel first: what is cut off then is the same in all of them
    let parts = || [&map.panel, &map.less].into_iter().filter(|part| !part.is_empty()).cloned();
    let title = |what: &str| {
        let text = parts().chain([what.to_owned()]).collect::<Vec<_>>();
        cut(&text.join(": "), NAME)
    };
    let width = map.width.map_or(String::new(), |width| format!(" over {width:.2}"));
    let kind = if map.difference.is_some() { Kind::Difference } else { Kind::Value };
    let of = cut(&of_in_words(map), NAME / 2);
    let picture = |what: &str, kind: Kind, pick: Pick, name: String| Picture {
        title: title(what),
        what: what.to_owned(),
        map,
        pick,
        kind,
        name,
    };
    match map.shows {
        Shows::Value => vec![picture("one run a cell", kind, middle, of)],
        Shows::Probability => vec![picture("share of the runs of a cell", kind, middle, of)],
        Shows::Median => vec![
            picture("median of the runs of a cell", kind, middle, of.clone()),
            picture("95 % value of the runs of a cell", kind, upper, of),
        ],
        Shows::SmoothedMean | Shows::SmoothedProbability => vec![
            picture(&format!("smoothed{width}"), kind, middle, of),
            picture("half width of its limits", Kind::Width, half_width, "half width".to_owned()),
        ],
    }
}

/// Runs beyond the model as a mark's meaning.
const BEYOND: &str = "runs beyond the model";

/// Characters of a line below one panel.
const CHARACTERS: usize = 85;

/// Marks in as few lines as they fit in.
fn in_lines(marks: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for mark in marks {
        match lines.last_mut() {
            Some(line) if line.len() + 2 + mark.len() <= CHARACTERS => *line += &format!("; {mark}"),
            _ => lines.push(mark.clone()),
        }
    }
    lines
}

/// Meanings of the marks.
pub fn marks(maps: &[Map]) -> Vec<String> {
    let any = |is: fn(&Map) -> bool| maps.iter().any(is);
    let mut marks = Vec::new();
    if any(Map::has_contours) {
        marks.push("lines: the levels marked beside the scale".to_owned());
    }
    // where all cells are of one regime there is none
    let has_several = |map: &Map| {
        let mut words = map.cells.iter().filter_map(|cell| cell.regime.as_deref());
        words.next().is_some_and(|first| words.any(|word| word != first))
    };
    if any(has_several) {
        marks.push("orange: boundary of the regimes, between the middles of cells".to_owned());
    }
    let (bad, beyond) = if any(|map| map.difference.is_none()) {
        ("bad runs", BEYOND)
    } else {
        ("pairs with a bad run", "pairs with a run beyond the model")
    };
    let kinds: [(fn(&Map) -> u64, &str, &str, &str); 2] =
        [(Map::failing, "cross", "crosses", bad), (|map| map.beyond, "diamond", "diamonds", beyond)];
    for (count, mark, _, what) in kinds {
        if maps.iter().any(|map| count(map) > 0 && !map.is_smoothed()) {
            // each by itself: together they are longer than a line
            marks.push(format!("{mark}: {what}, lower left: lower bound, upper right: upper bound"));
        }
    }
    if any(|map| map.bad > 0 && !map.is_smoothed()) {
        let by = if any(|map| map.beyond > 0) { "bad runs or runs beyond the model" } else { "bad runs" };
        let grey = match (any(has_unknown), any(has_open)) {
            (true, true) => Some(format!("grey: no number, only a bound, or left open by {by}")),
            (true, false) => Some("grey: no number, or only a lower bound".to_owned()),
            (false, true) => Some(format!("grey: left open by {by}")),
            (false, false) => None,
        };
        marks.extend(grey);
    }
    for (count, _, mark, what) in kinds {
        if maps.iter().any(|map| count(map) > 0 && map.is_smoothed()) {
            marks.push(format!("{mark}: {what}"));
        }
    }
    if any(Map::lacks_limits) {
        marks.push("grey: no limits, because samples are too few".to_owned());
    }
    if any(Map::has_limits_of_others) {
        marks.push("half width near bad runs: of the runs with a value".to_owned());
    }
    if any(|map| map.bad > 0 && map.shows == Shows::SmoothedProbability) {
        marks.push("split by bad runs: lower left: lower bound, upper right: upper bound".to_owned());
    }
    if any(|map| map.cells.len() < map.x.at.len() * map.y.at.len()) {
        marks.push("hatched: no sample, or too few".to_owned());
    }
    marks
}

/// Meanings of the marks, and the number of runs.
fn explanation(maps: &[Map]) -> Vec<String> {
    let mut told = in_lines(&marks(maps));
    if maps.iter().any(|map| map.width.is_some()) {
        told.push(
            "smoothing width (share of the range of both axes): chosen by cross-validation, separately per panel and difference"
                .to_owned(),
        );
    }
    // the runs of a difference are those of its panels, where these are drawn
    let panels: Vec<&Map> = maps.iter().filter(|map| map.difference.is_none()).collect();
    let count = |of: fn(&Map) -> u64, maps: &[&Map]| maps.iter().map(|map| of(map)).sum::<u64>();
    let s = |count: u64| if count == 1 { "" } else { "s" };
    let beyond = |count: u64, what: &str| if count == 0 { String::new() } else { format!(", {count} {what}") };
    told.push(if panels.is_empty() {
        let all: Vec<&Map> = maps.iter().collect();
        let (pairs, bad) = (count(|map| map.n, &all), count(Map::failing, &all));
        let beyond = beyond(count(|map| map.beyond, &all), "with a run beyond the model");
        format!("{pairs} pair{} of runs, {bad} of them with a bad run{beyond}", s(pairs))
    } else {
        let (runs, bad) = (count(|map| map.n, &panels), count(Map::failing, &panels));
        let beyond = beyond(count(|map| map.beyond, &panels), "beyond the model");
        format!("{runs} run{}, {bad} of them bad{beyond}", s(runs))
    });
    told
}

/// Whether a part of a cell with bad runs has no number.
fn has_unknown(map: &Map) -> bool {
    let pictures = pictures_of(map);
    let is_none = |cell: &Cell| {
        let figures = pictures.iter().map(|picture| (picture.pick)(cell));
        figures.into_iter().any(|(harmless, harmful)| harmless.is_none() || harmful.is_none())
    };
    !map.is_smoothed() && map.cells.iter().any(|cell| cell.bad > 0 && !map.is_unsure(cell) && is_none(cell))
}

/// Whether a cell has numbers, and bad runs leave them open.
fn has_open(map: &Map) -> bool {
    !map.is_smoothed() && map.cells.iter().any(|cell| map.is_unsure(cell))
}
