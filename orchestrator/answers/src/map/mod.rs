//! Maps: a column, or the probability of a condition, over two parameters of a study.
//!
//! ```text
//! rows --place--> panels (a combination of the other axes) of items: place, regime, value or truth   (pairs: of two panels)
//!   both axes have given values   --grid-->     a cell for each combination: median and 95 % value of its starts, probability of its starts
//!   otherwise                     --scatter-->  a raster, smoothed (smooth), with the uncertainty of each value
//!   --> Map: cells as answers.json has them; contour lines (contour) and boundaries of regimes (boundary) for pictures
//!       of some of the given values --refine--> the combinations to be computed next
//! ```
//! A bad run is counted in its cell. Each figure is given with bad runs harmless and with bad runs harmful, as in [`crate::estimate`].
//! Places without a sample have no cell.
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

/// Name of the column of regimes.
pub const REGIME: &str = "rub_regime";

/// Level of the second figure of a cell, the quantile of its starts.
pub const UPPER: f64 = 0.95;

/// Quantity that a map shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Of {
    /// A column.
    Value(String),
    /// The probability of a condition.
    Probability(Formula),
}

/// Definition of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Column along the first axis.
    pub x: String,
    /// Column along the second axis.
    pub y: String,
    /// Whether both axes have given values (`[[vary]]`), so that no smoothing is needed.
    pub is_grid: bool,
    /// Whether an axis has given values: it is drawn value by value, and the map is smoothed along the other axis.
    pub varied: (bool, bool),
    /// Quantity shown.
    pub of: Of,
    /// Columns for whose combinations of values there are panels.
    pub panels: Vec<String>,
    /// Varied release angles: the starts of a cell.
    pub starts: Vec<String>,
    /// A column of `panels`, and pairs of its values whose difference is shown: first minus second.
    pub paired: Option<(String, Vec<[Label; 2]>)>,
}

/// An axis of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Name of the column.
    pub column: String,
    /// SI unit, "" for a pure number.
    pub unit: String,
    /// Midpoints of the cells, ascending: the values of the study, or those of the raster.
    pub at: Vec<f64>,
}

impl Axis {
    /// Edges of the cells: half-way between neighbours; the outer edges are symmetric about their midpoints.
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

/// Kind of the figure of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shows {
    /// Value of the only run of the cell.
    Value,
    /// Median of the starts; `upper` is their 95 % quantile.
    Median,
    /// Share of the starts.
    Probability,
    /// Smoothed mean of nearby samples.
    SmoothedMean,
    /// Smoothed share of nearby samples.
    SmoothedProbability,
}

/// A cell of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Column and row of the cell among the places of the axes.
    #[serde(skip)]
    pub at: (usize, usize),
    /// Midpoint along the first axis.
    pub x: f64,
    /// Midpoint along the second axis.
    pub y: f64,
    /// Number of runs in the cell; in a difference, of pairs of runs.
    pub n: u64,
    /// Bad runs, included in `n`.
    pub bad: u64,
    /// Runs beyond the model, included in `bad`.
    pub beyond: u64,
    /// Figure with bad runs counted as harmless.
    pub estimate: Option<f64>,
    /// Figure with bad runs counted as harmful.
    pub estimate_if_bad_harmful: Option<f64>,
    /// Lower limit for this cell alone; the interval covers bad runs counted either way.
    pub low: Option<f64>,
    /// Upper limit, likewise.
    pub high: Option<f64>,
    /// 95 % quantile of the starts, bad runs harmless; only with medians.
    pub upper: Option<f64>,
    /// 95 % quantile of the starts, bad runs harmful.
    pub upper_if_bad_harmful: Option<f64>,
    /// The most frequent regime of the ok runs; the worst of equally frequent ones.
    pub regime: Option<String>,
    /// Half width of the interval over the runs with a value, regardless of nearby bad runs; only for smoothed cells.
    #[serde(skip)]
    pub half_width: Option<f64>,
    /// Whether bad runs affect the figure.
    #[serde(skip)]
    pub is_open: bool,
}

/// One panel of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// Values on the axes that have panels.
    #[serde(skip)]
    pub group: Group,
    /// `group` as text: "contact gap = 0.4 mm".
    #[serde(skip)]
    pub panel: String,
    /// The values between which a difference is taken, as text: "detection = hyp1 less hyp2".
    #[serde(skip)]
    pub less: String,
    /// First axis.
    pub x: Axis,
    /// Second axis.
    pub y: Axis,
    /// Quantity shown: a column or `P(...)`.
    pub of: String,
    /// SI unit of the quantity, "" for a pure number.
    pub unit: String,
    /// Kind of the figure of a cell.
    pub shows: Shows,
    /// For a difference at the same starts: the column, and the two values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<(String, [Label; 2])>,
    /// For smoothed cells: smoothing width as a share of the range of an axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// For smoothed cells: runs (or pairs) in cells that are not drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undrawn: Option<u64>,
    /// For a smoothed column: smallest and largest value of single runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<(f64, f64)>,
    /// Confidence level of the limits.
    pub confidence: f64,
    /// Names of the regimes, the worst last.
    #[serde(skip)]
    pub regimes: Vec<String>,
    /// Runs of the panel; in a difference, pairs.
    pub n: u64,
    /// Bad runs, included in `n`.
    pub bad: u64,
    /// Runs beyond the model, included in `bad`.
    pub beyond: u64,
    /// Places of failed, invalid and quarantined runs.
    #[serde(skip)]
    pub bad_at: Vec<(f64, f64)>,
    /// Places of runs beyond the model.
    #[serde(skip)]
    pub beyond_at: Vec<(f64, f64)>,
    /// Whether the cells were chosen by their results (`[refine]`).
    #[serde(skip)]
    pub refined: bool,
    /// Reservations and remarks for the reader.
    pub notes: Vec<String>,
    /// Cells with samples, in rows of the first axis.
    pub cells: Vec<Cell>,
}

impl Map {
    /// Cells by their indices: `[column of x][row of y]`.
    #[must_use]
    pub fn table(&self) -> Vec<Vec<Option<&Cell>>> {
        let mut table = vec![vec![None; self.y.at.len()]; self.x.at.len()];
        for cell in &self.cells {
            table[cell.at.0][cell.at.1] = Some(cell);
        }
        table
    }

    /// Whether bad runs leave a cell open although both figures are equal: bad runs on both sides of a difference of shares cancel.
    #[must_use]
    pub fn is_unsure(&self, cell: &Cell) -> bool {
        self.difference.is_some() && self.is_share() && cell.is_open
    }

    /// Whether some smoothed cell has no limits because samples are too few.
    #[must_use]
    pub fn lacks_limits(&self) -> bool {
        self.is_smoothed() && self.cells.iter().any(|cell| cell.half_width.is_none())
    }

    /// Whether limits of a smoothed column hold only for the runs with a value, because bad runs are nearby.
    #[must_use]
    pub fn has_limits_of_others(&self) -> bool {
        self.shows == Shows::SmoothedMean && self.cells.iter().any(|cell| cell.is_open && cell.half_width.is_some())
    }

    /// Whether contour lines are drawn, which needs enough cells.
    #[must_use]
    pub fn has_contours(&self) -> bool {
        self.x.at.len().min(self.y.at.len()) >= contour::FEWEST
    }

    /// Number of failed and invalid runs among the runs that are not ok.
    #[must_use]
    pub fn failing(&self) -> u64 {
        self.bad - self.beyond
    }

    /// Name of the runs that are not ok: "bad runs", "runs beyond the model", or both; in a difference, pairs with such a run.
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

    /// Whether the cells are smoothed.
    #[must_use]
    pub fn is_smoothed(&self) -> bool {
        matches!(self.shows, Shows::SmoothedMean | Shows::SmoothedProbability)
    }

    /// Whether the map shows shares.
    #[must_use]
    pub fn is_share(&self) -> bool {
        matches!(self.shows, Shows::Probability | Shows::SmoothedProbability)
    }
}

/// Input common to all panels of a map.
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

/// Panels of a map, followed by its differences; `alpha` = 1 - confidence.
///
/// # Errors
/// The study has no such column.
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

    /// Column name without its unit, as text.
    fn named(&self, column: &str) -> String {
        plain_name(column, self.unit(column))
    }

    /// A value of a column with a convenient unit.
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
