//! One picture: cells, lines, marks, and its scale beside it.

use super::super::style::{FINE, GREY, SMALL, Scale, TEXT, plain_name, tick};
use super::super::{Area, COLOURS, FigureError};
use super::colour::{Colours, Kind, STEPS};
use super::{HEIGHT, Pick, WIDTH};
use crate::map::contour::{Piece, boundary, contour};
use crate::map::{Axis, Cell, Map};
use plotters::prelude::{BLACK, ChartBuilder, Color, IntoFont, PathElement, Polygon, RGBColor, Rectangle, Text, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// What a picture shows.
pub(super) struct Picture<'a> {
    pub title: String,
    pub map: &'a Map,
    pub pick: Pick,
    pub kind: Kind,
    /// Of the scale.
    pub name: String,
}

/// A cell of which something is not known, and the hatching of what has no sample.
const UNKNOWN: RGBColor = RGBColor(190, 190, 190);
const HATCH: RGBColor = RGBColor(225, 225, 225);
/// Lines of the hatching.
const HATCHES: i32 = 28;
/// Crosses of bad runs, or diamonds of runs beyond the model, over a smoothed map, at most.
const MOST_CROSSES: usize = 400;
/// Room for the scale, labels of x and y, the title \[px\].
const BAR: u32 = 96;
const BELOW: u32 = 38;
const LEFT: u32 = 58;
/// Left of the name of an axis, which would touch the edge.
const ROOM: u32 = 4;
const ABOVE: u32 = 26;

/// An axis in the unit a reader wants.
struct Shown {
    scale: Scale,
    edges: Vec<f64>,
    at: Vec<f64>,
    label: String,
}

fn shown(axis: &Axis) -> Shown {
    let edges = axis.edges();
    let largest = edges.iter().fold(0.0_f64, |most, edge| most.max(edge.abs()));
    let scale = Scale::of(&axis.unit, largest);
    let scaled = |values: &[f64]| values.iter().map(|value| value * scale.factor).collect::<Vec<f64>>();
    let label = scale.label(&bladeoff_text::document::cut(&plain_name(&axis.column, &axis.unit), 50));
    Shown { edges: scaled(&edges), at: scaled(&axis.at), label, scale }
}

pub(super) fn draw(area: &Area<'_>, picture: &Picture<'_>, colours: &Colours) -> Result<(), FigureError> {
    let (title, rest) = area.split_vertically(ABOVE * FINE);
    let style = SMALL.into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    title.draw(&Text::new(picture.title.clone(), ((LEFT * FINE) as i32, (ABOVE * FINE / 2) as i32), style))?;
    let (left, right) = rest.split_horizontally((WIDTH - BAR) * FINE);
    let map = picture.map;
    if map.cells.is_empty() {
        let style = TEXT.into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        let middle = (((WIDTH - BAR) * FINE / 2) as i32, ((HEIGHT - ABOVE) * FINE / 2) as i32);
        left.draw(&Text::new("no cell is drawn: no sample, or too few", middle, style))?;
        return Ok(());
    }
    let (x, y) = (shown(&map.x), shown(&map.y));
    let ends = |edges: &[f64]| (edges[0], edges[edges.len() - 1]);
    let ((x0, x1), (y0, y1)) = (ends(&x.edges), ends(&y.edges));
    let mut chart = ChartBuilder::on(&left)
        .margin_right(4 * FINE)
        .x_label_area_size(BELOW * FINE)
        .margin_left(ROOM * FINE)
        .y_label_area_size((LEFT - ROOM) * FINE)
        .build_cartesian_2d(x0..x1, y0..y1)?;
    let hatch = HATCH.stroke_width(FINE);
    let table = map.table();
    if map.cells.len() < map.x.at.len() * map.y.at.len() {
        let lines = (1..2 * HATCHES).map(|k| hatching(k, (x0, x1), (y0, y1)));
        chart.draw_series(lines.map(|line| PathElement::new(line.to_vec(), hatch)))?;
    }
    // a little over the next cell: edges that only touch show as hairlines
    let over = (0.4 * (x1 - x0) / f64::from(WIDTH), 0.4 * (y1 - y0) / f64::from(HEIGHT));
    for cell in &map.cells {
        let (from, to) = corners(cell, &x.edges, &y.edges);
        let to = ((to.0 + over.0).min(x1), (to.1 + over.1).min(y1));
        let (harmless, harmful) = picture.figures(cell);
        let colour = |value: Option<f64>| value.map_or(UNKNOWN, |value| colours.of(value));
        chart.draw_series([Rectangle::new([from, to], colour(harmless).filled())])?;
        // a share that is smoothed takes bad runs of other cells in; a mean has no figure for them
        if harmless != harmful && (cell.bad > 0 || harmful.is_some()) {
            let half = vec![to, (to.0, from.1), (from.0, to.1)];
            chart.draw_series([Polygon::new(half, colour(harmful).filled())])?;
        }
    }
    let value = |i: usize, j: usize| table[i][j].and_then(|cell| picture.figures(cell).0);
    for level in &colours.levels {
        strokes(&mut chart, &contour(&x.at, &y.at, value, *level), &[(WHITE, 2 * FINE + 2), (BLACK, FINE)])?;
    }
    let scaled = |[a, b]: Piece| {
        let of = |(u, v): (f64, f64)| (u * x.scale.factor, v * y.scale.factor);
        [of(a), of(b)]
    };
    let edges: Vec<Piece> = boundary(map).into_iter().map(scaled).collect();
    strokes(&mut chart, &edges, &[(WHITE, 5 * FINE), (COLOURS[1], 3 * FINE)])?;
    let size = (0.012 * (x1 - x0), 0.016 * (y1 - y0));
    let marked = |places: &[(f64, f64)], count: fn(&Cell) -> u64| -> Vec<(f64, f64)> {
        if map.is_smoothed() {
            let step = places.len().div_ceil(MOST_CROSSES).max(1);
            places.iter().step_by(step).map(|(u, v)| (u * x.scale.factor, v * y.scale.factor)).collect()
        } else {
            let cells = map.cells.iter().filter(|cell| count(cell) > 0);
            cells.map(|cell| (x.at[cell.at.0], y.at[cell.at.1])).collect()
        }
    };
    // runs beyond the model: diamonds
    for (u, v) in marked(&map.beyond_at, |cell| cell.beyond) {
        let corners = [(u - size.0, v), (u, v + size.1), (u + size.0, v), (u, v - size.1)];
        let sides = [0, 1, 2, 3].map(|at| [corners[at], corners[(at + 1) % 4]]);
        strokes(&mut chart, &sides, &[(WHITE, 4 * FINE), (BLACK, 2 * FINE)])?;
    }
    for (u, v) in marked(&map.bad_at, |cell| cell.bad - cell.beyond) {
        let arms = [
            [(u - size.0, v - size.1), (u + size.0, v + size.1)],
            [(u - size.0, v + size.1), (u + size.0, v - size.1)],
        ];
        strokes(&mut chart, &arms, &[(WHITE, 4 * FINE), (BLACK, 2 * FINE)])?;
    }
    if picture.kind == Kind::Value {
        for (name, (i, j)) in regions(map) {
            named(&mut chart, &name, (x.at[i], y.at[j]))?;
        }
    }
    chart
        .configure_mesh()
        .disable_mesh()
        .set_all_tick_mark_size(4 * FINE)
        .axis_style(BLACK.stroke_width(FINE))
        .x_labels(7)
        .y_labels(8)
        .x_label_formatter(&|value| tick(*value))
        .y_label_formatter(&|value| tick(*value))
        .label_style(SMALL.into_font())
        .axis_desc_style(SMALL.into_font())
        .x_desc(&x.label)
        .y_desc(&y.label)
        .draw()?;
    bar(&right, &colours.label(&picture.name), colours)
}

type Chart<'a, 'b> = plotters::prelude::ChartContext<
    'a,
    plotters::prelude::SVGBackend<'b>,
    plotters::prelude::Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Pieces of lines, each colour over the one before.
fn strokes(chart: &mut Chart<'_, '_>, pieces: &[Piece], strokes: &[(RGBColor, u32)]) -> Result<(), FigureError> {
    for (colour, width) in strokes {
        let style = colour.stroke_width(*width);
        chart.draw_series(pieces.iter().map(|piece| PathElement::new(piece.to_vec(), style)))?;
    }
    Ok(())
}

/// A name with a rim, so that it is read on any ground.
fn named(chart: &mut Chart<'_, '_>, name: &str, place: (f64, f64)) -> Result<(), FigureError> {
    let around = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)];
    let places = around.map(|place| (WHITE, place)).into_iter().chain([(BLACK, (0, 0))]);
    for (colour, (right, down)) in places {
        let style = SMALL.into_font().color(&colour).pos(Pos::new(HPos::Center, VPos::Center));
        let off = (right * FINE as i32, down * FINE as i32);
        let text = plotters::prelude::EmptyElement::at(place) + Text::new(name.to_owned(), off, style);
        chart.draw_series([text])?;
    }
    Ok(())
}

fn corners(cell: &Cell, x: &[f64], y: &[f64]) -> ((f64, f64), (f64, f64)) {
    let (i, j) = cell.at;
    ((x[i], y[j]), (x[i + 1], y[j + 1]))
}

/// The k-th line of the hatching, within the picture.
fn hatching(k: i32, (x0, x1): (f64, f64), (y0, y1): (f64, f64)) -> Piece {
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

/// The scale: colours, marks at the levels of the lines, its name along it.
fn bar(area: &Area<'_>, name: &str, colours: &Colours) -> Result<(), FigureError> {
    let fine = FINE as i32;
    let height = (HEIGHT - ABOVE - BELOW) as i32 * fine;
    let (left, right) = (4 * fine, 18 * fine);
    let at = |share: f64| ((1.0 - share) * f64::from(height)) as i32;
    for step in 0..STEPS {
        let (low, high) = (step as f64 / STEPS as f64, (step as f64 + 1.0) / STEPS as f64);
        let colour = colours.at(0.5 * (low + high));
        // from the upper edge a little over the next
        area.draw(&Rectangle::new([(left, at(high)), (right, (at(low) + 2).min(height))], colour.filled()))?;
    }
    area.draw(&Rectangle::new([(left, 0), (right, height)], GREY.stroke_width(FINE)))?;
    let style = SMALL.into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    for level in &colours.levels {
        let y = at(colours.share(*level));
        area.draw(&PathElement::new(vec![(left, y), (right + 4 * fine, y)], BLACK.stroke_width(FINE)))?;
        area.draw(&Text::new(colours.mark(*level), (right + 6 * fine, y), style.clone()))?;
    }
    let turned = SMALL.into_font().transform(plotters::style::FontTransform::Rotate270);
    let style = turned.color(&BLACK).pos(Pos::new(HPos::Center, VPos::Bottom));
    area.draw(&Text::new(name.to_owned(), ((BAR as i32 - 14) * fine, height / 2), style))?;
    Ok(())
}
