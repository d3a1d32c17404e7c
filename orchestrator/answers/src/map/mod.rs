//! Maps: a column, or the probability of a condition, over two parameters of a study.
//!
//! ```text
//! rows --place--> panels (a combination of the other axes) of items: place, regime, value or truth   (pairs: of two panels)
//!   both axes have given values   --grid-->     a cell for each combination: median and 95 % value of its starts, probability of its starts
//!   otherwise                     --scatter-->  a raster, smoothed (smooth), with the uncertainty of each value
//!   --> Map: cells as answers.json has them; contour lines (contour) and boundaries of regimes (boundary) for pictures
//!       of some of the given values --refine--> the combinations to be computed next
//! ```
//! A bad run stays in its cell: it is counted, and each figure is that with bad runs harmless and with bad runs harmful, as in
//! [`crate::estimate`]. Where no sample is, there is no cell.
//!
//! Verified by `tests/uncertainty/maps.rs`.

pub mod boundary;
pub mod contour;
mod grid;
mod pairs;
mod place;
pub mod refine;
mod scatter;
mod smooth;

use crate::estimate::formula::Formula;
use crate::estimate::input::{DesignKind, Group, InputError, Label, Study, plain_name};
use crate::estimate::scheme::Scheme;
use bladeoff_text::document::units::format_digits;
use place::{Item, Items, Places, items};
use serde::Serialize;

/// The column whose words are regimes.
pub const REGIME: &str = "rub_regime";

/// Share of a cell's starts that its second figure is not exceeded by.
pub const UPPER: f64 = 0.95;

/// What a map shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Of {
    /// A column.
    Value(String),
    /// The probability of a condition.
    Probability(Formula),
}

/// A map that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Column along the first axis.
    pub x: String,
    /// Along the second.
    pub y: String,
    /// Whether both have given values (`[[vary]]`), so that they are drawn as they are.
    pub is_grid: bool,
    /// Whether one of them has: it is drawn value by value, and smoothed along the other.
    pub varied: (bool, bool),
    /// What is shown.
    pub of: Of,
    /// Columns of which each combination of values has a panel.
    pub panels: Vec<String>,
    /// Columns of release angles that are varied: several starts a cell.
    pub starts: Vec<String>,
    /// One of `panels`, and the differences between its values: at the first, less that at the second.
    pub paired: Option<(String, Vec<[Label; 2]>)>,
}

/// An axis of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Its column.
    pub column: String,
    /// SI unit, "" for a pure number.
    pub unit: String,
    /// Where cells have their middles, ascending: the values of the study, or those of the raster.
    pub at: Vec<f64>,
}

impl Axis {
    /// Where cells end: half-way between neighbours; at the ends as far out as the neighbour is in.
    #[must_use]
    pub fn edges(&self) -> Vec<f64> {
        let at = &self.at;
        let (Some(first), Some(last)) = (at.first(), at.last()) else { return Vec::new() };
        if at.len() == 1 {
            let half = if *first == 0.0 { 0.5 } else { 0.05 * first.abs() };
            return vec![first - half, first + half];
        }
        let inner = at.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let (low, high) = (at[1] - first, last - at[at.len() - 2]);
        std::iter::once(first - 0.5 * low).chain(inner).chain([last + 0.5 * high]).collect()
    }
}

/// What the figure of a cell is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shows {
    /// Of the one run of the cell.
    Value,
    /// Median of its starts; `upper` is their 95 % value.
    Median,
    /// Share of its starts.
    Probability,
    /// Smoothed mean of what is around it.
    SmoothedMean,
    /// Smoothed share of what is around it.
    SmoothedProbability,
}

/// A cell of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Column and row of it among the places of the axes.
    #[serde(skip)]
    pub at: (usize, usize),
    /// Its middle along the first axis.
    pub x: f64,
    /// Along the second.
    pub y: f64,
    /// Runs in it; of a difference pairs of runs.
    pub n: u64,
    /// Bad ones among them.
    pub bad: u64,
    /// Runs beyond the model among these.
    pub beyond: u64,
    /// The figure with bad runs harmless.
    pub estimate: Option<f64>,
    /// With bad runs harmful.
    pub estimate_if_bad_harmful: Option<f64>,
    /// Limits that cover both, each cell by itself.
    pub low: Option<f64>,
    /// As `low`.
    pub high: Option<f64>,
    /// 95 % value of its starts, bad runs harmless; of medians alone.
    pub upper: Option<f64>,
    /// The same, bad runs harmful.
    pub upper_if_bad_harmful: Option<f64>,
    /// The most frequent regime of its ok runs, of several the worst.
    pub regime: Option<String>,
    /// Half the width of the limits of its runs with a value, whether or not bad runs are near; of smoothed cells alone.
    #[serde(skip)]
    pub half_width: Option<f64>,
    /// Bad runs stand in its figure.
    #[serde(skip)]
    pub is_open: bool,
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// Its values on the axes that have panels.
    #[serde(skip)]
    pub group: Group,
    /// The same as a person reads them: "contact gap = 0.4 mm".
    #[serde(skip)]
    pub panel: String,
    /// Of a difference what it is between, likewise: "detection = hyp1 less hyp2".
    #[serde(skip)]
    pub less: String,
    /// First axis.
    pub x: Axis,
    /// Second axis.
    pub y: Axis,
    /// What is shown: a column or `P(...)`.
    pub of: String,
    /// Its SI unit, "" for a pure number.
    pub unit: String,
    /// What the figure of a cell is.
    pub shows: Shows,
    /// It is a difference at the same starts: the column, and the values that it is between.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<(String, [Label; 2])>,
    /// Of smoothed cells: the width, as part of the range of an axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Of smoothed cells: runs (of a difference pairs) in cells that are not drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undrawn: Option<u64>,
    /// Of a smoothed column: the least and the largest of single runs, which no smoothed cell reaches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<(f64, f64)>,
    /// Of the limits.
    pub confidence: f64,
    /// Words of regimes, the worst last.
    #[serde(skip)]
    pub regimes: Vec<String>,
    /// Runs of the panel; of a difference pairs.
    pub n: u64,
    /// Bad ones among them.
    pub bad: u64,
    /// Runs beyond the model among these.
    pub beyond: u64,
    /// Where failed, invalid and quarantined runs are.
    #[serde(skip)]
    pub bad_at: Vec<(f64, f64)>,
    /// Where runs beyond the model are.
    #[serde(skip)]
    pub beyond_at: Vec<(f64, f64)>,
    /// Its cells were chosen by their results.
    #[serde(skip)]
    pub refined: bool,
    /// What a reader has to know.
    pub notes: Vec<String>,
    /// Cells that have samples, by rows of the first axis.
    pub cells: Vec<Cell>,
}

impl Map {
    /// Cells by their places: `[column of x][row of y]`.
    #[must_use]
    pub fn table(&self) -> Vec<Vec<Option<&Cell>>> {
        let mut table = vec![vec![None; self.y.at.len()]; self.x.at.len()];
        for cell in &self.cells {
            table[cell.at.0][cell.at.1] = Some(cell);
        }
        table
    }

    /// Whether bad runs leave a cell open although both its figures are the same: bad on both sides of a difference of shares they cancel.
    #[must_use]
    pub fn is_unsure(&self, cell: &Cell) -> bool {
        self.difference.is_some() && self.is_share() && cell.is_open
    }

    /// Whether a smoothed cell has no limits, because samples are too few.
    #[must_use]
    pub fn lacks_limits(&self) -> bool {
        self.is_smoothed() && self.cells.iter().any(|cell| cell.half_width.is_none())
    }

    /// Whether the limits of a smoothed column hold for the runs with a value alone, because bad runs are near.
    #[must_use]
    pub fn has_limits_of_others(&self) -> bool {
        self.shows == Shows::SmoothedMean && self.cells.iter().any(|cell| cell.is_open && cell.half_width.is_some())
    }

    /// Whether contour lines are drawn: there are enough cells for them.
    #[must_use]
    pub fn has_contours(&self) -> bool {
        self.x.at.len().min(self.y.at.len()) >= contour::FEWEST
    }

    /// Failed and invalid runs among the runs that are not ok.
    #[must_use]
    pub fn failing(&self) -> u64 {
        self.bad - self.beyond
    }

    /// The runs that are not ok as a kind: "bad runs", "runs beyond the model", or both; of a difference pairs with such a run.
    #[must_use]
    pub fn bad_in_words(&self) -> &'static str {
        match (self.difference.is_some(), self.failing() > 0, self.beyond > 0) {
            (false, true, true) => "bad runs and runs beyond the model",
            (false, false, true) => "runs beyond the model",
            (false, _, _) => "bad runs",
            (true, true, true) => "pairs with a bad run or one beyond the model",
            (true, false, true) => "pairs with a run beyond the model",
            (true, _, _) => "pairs with a bad run",
        }
    }

    /// Whether its cells are smoothed.
    #[must_use]
    pub fn is_smoothed(&self) -> bool {
        matches!(self.shows, Shows::SmoothedMean | Shows::SmoothedProbability)
    }

    /// Whether it shows shares.
    #[must_use]
    pub fn is_share(&self) -> bool {
        matches!(self.shows, Shows::Probability | Shows::SmoothedProbability)
    }
}

/// What all panels of a map share.
struct Frame<'a> {
    study: &'a Study<'a>,
    wanted: &'a Wanted,
    places: Places,
    scheme: Scheme,
    t: f64,
    alpha: f64,
    unit: String,
    regimes: Vec<String>,
}

/// The panels of a map, then its differences; `alpha` = 1 - confidence.
///
/// # Errors
/// The study lacks a column.
pub fn maps(study: &Study<'_>, wanted: &Wanted, alpha: f64) -> Result<Vec<Map>, InputError> {
    let places = Places::of(study, wanted)?;
    let scheme = match Scheme::of(&study.design) {
        Scheme::Without(why) if study.design.kind == DesignKind::Chosen => {
            Scheme::Without(why.replace("chosen points", "chosen values"))
        }
        _ if !wanted.starts.is_empty() && study.design.kind != DesignKind::Chosen => {
            Scheme::Without(format!("no interval: the values of {} are chosen, not sampled", wanted.starts.join(", ")))
        }
        scheme => scheme,
    };
    let unit = match &wanted.of {
        Of::Value(column) => study.column(column)?.unit.clone(),
        Of::Probability(_) => String::new(),
    };
    let frame =
        Frame { study, wanted, t: scheme.t(alpha), scheme, alpha, unit, regimes: place::regimes(study), places };
    let mut maps = Vec::new();
    let mut all = Vec::new();
    for (group, rows) in &frame.places.panels {
        let found = items(&frame, rows)?;
        maps.push(frame.map(group.clone(), None, &found));
        all.push(found);
    }
    if let Some((column, pairs)) = &wanted.paired {
        for (at, (group, _)) in frame.places.panels.iter().enumerate() {
            for [a, b] in pairs {
                let rest = group.without(column);
                let other = |(other, _): &(Group, _)| other.label(column) == Some(b) && other.without(column) == rest;
                let Some(other) = frame.places.panels.iter().position(other) else { continue };
                if group.label(column) == Some(a) {
                    let found = pairs::paired(&frame, &all[at], &all[other]);
                    maps.push(frame.map(rest, Some((column.clone(), [a.clone(), b.clone()])), &found));
                }
            }
        }
    }
    Ok(maps)
}

impl Frame<'_> {
    fn unit(&self, column: &str) -> &str {
        self.study.column(column).map_or("", |column| column.unit.as_str())
    }

    /// A column without its unit.
    fn named(&self, column: &str) -> String {
        plain_name(column, self.unit(column))
    }

    /// One of its values with the unit that a person would choose.
    fn shown(&self, column: &str, label: &Label) -> String {
        match label {
            Label::Number(number) => format_digits(*number, self.unit(column), 4),
            Label::Word(word) => word.clone(),
        }
    }

    fn map(&self, group: Group, difference: Option<(String, [Label; 2])>, items: &Items) -> Map {
        let wanted = self.wanted;
        let (x, y) = (&self.places.x, &self.places.y);
        let is_share = matches!(wanted.of, Of::Probability(_));
        let said =
            group.0.iter().map(|(column, label)| format!("{} = {}", self.named(column), self.shown(column, label)));
        let less = difference.as_ref().map_or(String::new(), |(column, [a, b])| {
            format!("{} = {} less {}", self.named(column), self.shown(column, a), self.shown(column, b))
        });
        let at =
            |is: fn(&Item) -> bool| items.list.iter().filter(|item| is(item)).map(|item| (item.x, item.y)).collect();
        let mut map = Map {
            panel: said.collect::<Vec<_>>().join(", "),
            less,
            group,
            x: x.clone(),
            y: y.clone(),
            of: match &wanted.of {
                Of::Value(column) => column.clone(),
                Of::Probability(formula) => format!("P({})", formula.text),
            },
            unit: self.unit.clone(),
            shows: Shows::Value,
            difference,
            width: None,
            undrawn: None,
            runs: None,
            confidence: 1.0 - self.alpha,
            regimes: self.regimes.clone(),
            n: items.list.len() as u64,
            bad: items.list.iter().filter(|item| item.is_bad()).count() as u64,
            beyond: items.list.iter().filter(|item| item.is_beyond()).count() as u64,
            bad_at: at(|item| item.is_bad() && !item.is_beyond()),
            beyond_at: at(Item::is_beyond),
            refined: self.study.design.refined,
            notes: Vec::new(),
            cells: Vec::new(),
        };
        let nowhere = self.places.nowhere;
        if nowhere > 0 {
            let runs = if nowhere == 1 { "1 run has".to_owned() } else { format!("{nowhere} runs have") };
            map.notes.push(format!("{runs} no value of {} or {}, and no place", wanted.x, wanted.y));
        }
        if items.unpaired > 0 {
            let count = items.unpaired;
            let runs = if count == 1 { "1 run of both has".to_owned() } else { format!("{count} runs of both have") };
            map.notes.push(format!("{runs} no partner with the same inputs"));
        }
        if items.empty > 0 {
            let what = match (items.empty, map.difference.is_some()) {
                (1, true) => "1 pair has".to_owned(),
                (1, false) => "1 run has".to_owned(),
                (count, true) => format!("{count} pairs have"),
                (count, false) => format!("{count} runs have"),
            };
            map.notes.push(format!("{what} no value (for example, no contact) and no place in the map"));
        }
        if self.places.is_grid {
            if let Scheme::Without(why) = &self.scheme {
                map.notes.push(why.clone());
            }
            grid::fill(self, items, &mut map, is_share);
        } else {
            scatter::fill(self, items, &mut map, is_share);
        }
        map
    }
}
