//! Layers of a picture of a map, in shown units: tiles, lines, marks, names. SVG, PNG and the page are drawn from them.

use super::super::style::{Scale, plain_name};
use super::colour::{Colours, Kind};
use super::{Pick, is_split};
use crate::map::boundary::{Line, boundary};
use crate::map::contour::{Piece, contour};
use crate::map::{Axis, Cell, Map};

/// A picture: a figure of each cell of a map.
pub struct Picture<'a> {
    /// With the panel.
    pub title: String,
    /// Without it.
    pub what: String,
    pub map: &'a Map,
    pub pick: Pick,
    pub kind: Kind,
    /// Name of the scale.
    pub name: String,
}

impl Picture<'_> {
    /// Figures of a cell, with bad runs harmless and harmful, that colours and lines may take for values. The one end that is known of a cell
    /// of a grid is a bound, not a value.
    pub fn figures(&self, cell: &Cell) -> (Option<f64>, Option<f64>) {
        let (harmless, harmful) = (self.pick)(cell);
        let is_grid = !self.map.is_smoothed();
        let is_bound = is_grid && harmless.is_some() != harmful.is_some();
        if is_bound || is_grid && self.map.is_unsure(cell) { (None, None) } else { (harmless, harmful) }
    }
}

/// An axis in the unit a reader wants.
pub struct Shown {
    pub scale: Scale,
    pub edges: Vec<f64>,
    pub at: Vec<f64>,
    pub label: String,
}

impl Shown {
    fn new(axis: &Axis) -> Self {
        let edges = axis.edges();
        let largest = edges.iter().fold(0.0_f64, |most, edge| most.max(edge.abs()));
        let scale = Scale::of(&axis.unit, largest);
        let scaled = |values: &[f64]| values.iter().map(|value| value * scale.factor).collect::<Vec<f64>>();
        let label = scale.label(&bladeoff_text::document::cut(&plain_name(&axis.column, &axis.unit), 50));
        Self { edges: scaled(&edges), at: scaled(&axis.at), label, scale }
    }

    /// First and last edge.
    pub fn ends(&self) -> (f64, f64) {
        (self.edges[0], self.edges[self.edges.len() - 1])
    }
}

/// A cell: its corners, and its places on the scale of colour (`None`: grey).
pub struct Tile {
    pub from: (f64, f64),
    pub to: (f64, f64),
    /// With bad runs harmless: all of it, or lower left.
    pub harmless: Option<f64>,
    /// With bad runs harmful, where that differs: upper right.
    pub harmful: Option<Option<f64>>,
}

impl Tile {
    /// The part that is drawn with bad runs harmful, up to a corner.
    pub fn upper_half(&self, to: (f64, f64)) -> [(f64, f64); 3] {
        [to, (to.0, self.from.1), (self.from.0, to.1)]
    }
}

/// Lines of the hatching.
const HATCHES: i32 = 28;
/// Crosses of bad runs, or diamonds of runs beyond the model, over a smoothed map, at most.
const MOST_CROSSES: usize = 400;

/// All of a picture, from the ground up. There is at least one cell.
pub struct Layers {
    pub x: Shown,
    pub y: Shown,
    /// Below the cells, where some are missing.
    pub hatching: Vec<Piece>,
    pub tiles: Vec<Tile>,
    pub contours: Vec<Piece>,
    pub boundaries: Vec<Line>,
    pub diamonds: Vec<(f64, f64)>,
    pub crosses: Vec<(f64, f64)>,
    pub names: Vec<(String, (f64, f64))>,
}

impl Layers {
    pub fn new(picture: &Picture<'_>, colours: &Colours) -> Self {
        let map = picture.map;
        let (x, y) = (Shown::new(&map.x), Shown::new(&map.y));
        let is_sparse = map.cells.len() < map.x.at.len() * map.y.at.len();
        let hatching =
            if is_sparse { (1..2 * HATCHES).map(|k| hatch(k, x.ends(), y.ends())).collect() } else { Vec::new() };
        let tiles = map.cells.iter().map(|cell| tile(picture, cell, &x, &y, colours)).collect();
        let table = map.table();
        let value = |i: usize, j: usize| table[i][j].and_then(|cell| picture.figures(cell).0);
        // the uncertainty of an estimate is noise: lines would show the noise
        let levels = if map.has_contours() && picture.kind != Kind::Width { &colours.levels[..] } else { &[] };
        let contours = levels.iter().flat_map(|level| contour(&x.at, &y.at, value, *level)).collect();
        let scaled = |(u, v): (f64, f64)| (u * x.scale.factor, v * y.scale.factor);
        let boundaries = boundary(map).into_iter().map(|line| line.into_iter().map(scaled).collect()).collect();
        let marked = |places: &[(f64, f64)], count: fn(&Cell) -> u64| -> Vec<(f64, f64)> {
            if map.is_smoothed() {
                let step = places.len().div_ceil(MOST_CROSSES).max(1);
                places.iter().step_by(step).map(|place| scaled(*place)).collect()
            } else {
                let cells = map.cells.iter().filter(|cell| count(cell) > 0);
                cells.map(|cell| (x.at[cell.at.0], y.at[cell.at.1])).collect()
            }
        };
        let diamonds = marked(&map.beyond_at, |cell| cell.beyond);
        let crosses = marked(&map.bad_at, |cell| cell.bad - cell.beyond);
        let regions = if picture.kind == Kind::Value { regions(map) } else { Vec::new() };
        let names = regions.into_iter().map(|(name, (i, j))| (name, (x.at[i], y.at[j]))).collect();
        Self { hatching, tiles, contours, boundaries, diamonds, crosses, names, x, y }
    }
}

fn tile(picture: &Picture<'_>, cell: &Cell, x: &Shown, y: &Shown, colours: &Colours) -> Tile {
    let (i, j) = cell.at;
    let figures = picture.figures(cell);
    let share = |value: Option<f64>| value.map(|value| colours.share(value));
    Tile {
        from: (x.edges[i], y.edges[j]),
        to: (x.edges[i + 1], y.edges[j + 1]),
        harmless: share(figures.0),
        harmful: is_split(cell, figures).then(|| share(figures.1)),
    }
}

/// The k-th line of the hatching, within the picture.
fn hatch(k: i32, (x0, x1): (f64, f64), (y0, y1): (f64, f64)) -> Piece {
    let share = f64::from(k) / f64::from(HATCHES);
    // u + v = share, in the unit square
    let (from, to) = ((share - 1.0).max(0.0), share.min(1.0));
    let at = |u: f64| (x0 + u * (x1 - x0), y0 + (share - u) * (y1 - y0));
    [at(from), at(to)]
}

/// Each regime and the cell of it that is farthest from cells of others.
fn regions(map: &Map) -> Vec<(String, (usize, usize))> {
    let distance = |a: (usize, usize), b: (usize, usize)| {
        let (du, dv) = (a.0 as f64 - b.0 as f64, a.1 as f64 - b.1 as f64);
        du * du + dv * dv
    };
    let mut found = Vec::new();
    for word in &map.regimes {
        let (own, others): (Vec<&Cell>, Vec<&Cell>) =
            map.cells.iter().partition(|cell| cell.regime.as_ref() == Some(word));
        let room = |cell: &&Cell| {
            let (i, j) = cell.at;
            // the edge of the picture is as near as a cell beyond it
            let edge = [i + 1, j + 1, map.x.at.len() - i, map.y.at.len() - j].into_iter().min().unwrap_or(1) as f64;
            others.iter().map(|other| distance(cell.at, other.at)).fold(edge * edge, f64::min)
        };
        let best = own.into_iter().max_by(|a, b| room(a).total_cmp(&room(b)).then(b.at.cmp(&a.at)));
        found.extend(best.map(|cell| (word.clone(), cell.at)));
    }
    found
}
