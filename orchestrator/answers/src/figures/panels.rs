//! Lines over a common axis: one panel below the other, each with its own scale, its legend beside it.

use super::style::rimmed;
use super::{COLOURS, Figure, HEAD};
use crate::drawing::{Anchor, Axis, BLACK, Frame, Rgb, Ruling, Svg, TEXT, WHITE};

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mark {
    /// Joined by a line.
    #[default]
    Line,
    /// Joined by a dashed line.
    Dashed,
    /// Joined by a dotted line.
    Dotted,
    /// Dots of this radius \[px\].
    Dots(u32),
    /// Circles of this radius \[px\].
    Rings(u32),
}

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// In the legend; "" for none.
    pub label: String,
    /// Colour; `None`: the next of the palette, see [`style`].
    pub colour: Option<Rgb>,
    /// Points, in the panel's shown units.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub mark: Mark,
    /// Width of a line \[px\].
    pub width: u32,
}

impl Line {
    /// A line in the next colour.
    #[must_use]
    pub fn new(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.to_owned(), colour: None, points, mark: Mark::Line, width: 1 }
    }

    /// With a mark and a colour of its own.
    #[must_use]
    pub fn marked(label: &str, points: Vec<(f64, f64)>, mark: Mark, colour: Rgb) -> Self {
        Self { label: label.to_owned(), colour: Some(colour), points, mark, width: 1 }
    }
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Vertical axis with its unit.
    pub y_label: String,
    /// Lines.
    pub lines: Vec<Line>,
    /// Range; `None`: that of the values with some room.
    pub y_range: Option<(f64, f64)>,
    /// Draw the smallest and largest value of each column of pixels only.
    pub thin: bool,
    /// A logarithmic vertical axis ; values that are not above zero are not drawn.
    pub is_log: bool,
}

impl Panel {
    fn axis(&self, most: u32) -> Axis {
        let values = self.lines.iter().flat_map(|line| &line.points).map(|point| point.1);
        let axis = if self.is_log { Axis::log(&*self.y_label, values) } else { Axis::numbers(&*self.y_label, values) };
        match self.y_range {
            Some((low, high)) => axis.from_to(low, high),
            None => axis,
        }
        .most(most)
    }

    fn height(&self) -> u32 {
        let entries = self.lines.iter().filter(|line| !line.label.is_empty()).count() as u32;
        HEIGHT.max(ENTRY * (1 + entries.min(MOST_ENTRIES)))
    }
}

/// Width of a figure without legends \[px\].
const WIDTH: u32 = 900;
/// Least height of a panel without axis texts \[px\]; a panel with many entries in its legend is higher.
const HEIGHT: u32 = 190;
/// Height of an entry of a legend \[px\].
const ENTRY: u32 = 18;
/// Largest number of entries for which a panel becomes higher; of more entries, the last ones are counted.
const MOST_ENTRIES: u32 = 21;

/// Least number of characters of a legend's entries: "and 10 more".
const MORE: u32 = 11;

/// Sides of a frame \[px\].
const LEFT: f64 = 80.0;
const RIGHT: f64 = 878.0;
/// From the left of a frame to the name of its axis \[px\].
const BESIDE: f64 = 62.0;

/// Draws panels below one another.
#[must_use]
pub fn panels(title: &str, x_label: &str, panels: &[Panel]) -> Figure {
    panels_marked(title, x_label, panels, &[])
}

/// Draws panels with marks: places along x that all panels share, with names in the first panel.
#[must_use]
pub fn panels_marked(title: &str, x_label: &str, panels: &[Panel], marks: &[(f64, String)]) -> Figure {
    let all = panels.iter().flat_map(|panel| &panel.lines).flat_map(|line| &line.points);
    let mut x = Axis::tight(x_label, all.map(|point| point.0)).most(10);
    let height: u32 = panels.iter().map(Panel::height).sum();
    Figure::draw((WIDTH + legend_width(panels), 92 + height.max(HEIGHT)), title, |svg| {
        let mut top = HEAD + 8.0;
        for (at, panel) in panels.iter().enumerate() {
            x.has_numbers = at + 1 == panels.len();
            let y = panel.axis(5);
            let bottom = top + f64::from(panel.height());
            let frame = Frame::new(&x, &y, [LEFT, top, RIGHT, bottom - 18.0]);
            draw(svg, panel, &frame);
            draw_marks(svg, &frame, marks, at == 0);
            top = bottom;
        }
    })
}

/// Draws one tall panel over a range of its own.
#[must_use]
pub fn tall_panel(title: &str, x_label: &str, panel: &Panel, x_range: (f64, f64)) -> Figure {
    let (x, y) = (Axis::between(x_label, x_range).most(10), panel.axis(15));
    Figure::draw((WIDTH + legend_width(std::slice::from_ref(panel)), 560), title, |svg| {
        draw(svg, panel, &Frame::new(&x, &y, [LEFT, HEAD + 8.0, RIGHT, 516.0]));
    })
}

/// Room for the longest entry of all legends, beside the panels: over them it would hide lines \[px\].
fn legend_width(panels: &[Panel]) -> u32 {
    let labels = panels.iter().flat_map(|panel| &panel.lines).map(|line| line.label.chars().count() as u32);
    labels.max().filter(|longest| *longest > 0).map_or(0, |longest| 40 + 7 * longest.max(MORE))
}

fn draw(svg: &mut Svg, panel: &Panel, frame: &Frame<'_>) {
    frame.axes(svg, Ruling::Grid, BESIDE);
    let mut legend = Vec::new();
    for (at, line) in panel.lines.iter().enumerate() {
        let (colour, kind) = line.colour.map_or_else(|| style(at, line.mark), |colour| (colour, line.mark));
        let points = if panel.thin { thinned(&line.points, frame.x.range, 800) } else { line.points.clone() };
        let places = frame.places(points.into_iter().filter(|point| !panel.is_log || point.1 > 0.0));
        mark(svg, kind, colour, f64::from(line.width), places.collect());
        if !line.label.is_empty() {
            legend.push((line.label.as_str(), kind, colour, line.width));
        }
    }
    draw_legend(svg, frame, &legend);
}

/// Colour and mark of a line by its number: lines of the same colour differ in their dashes.
#[must_use]
pub fn style(number: usize, mark: Mark) -> (Rgb, Mark) {
    let dashed = match (mark, number / COLOURS.len()) {
        (Mark::Line, 1) => Mark::Dashed,
        (Mark::Line, 2..) => Mark::Dotted,
        (mark, _) => mark,
    };
    (COLOURS[number % COLOURS.len()], dashed)
}

fn mark(svg: &mut Svg, mark: Mark, colour: Rgb, width: f64, places: Vec<(f64, f64)>) {
    match mark {
        Mark::Line | Mark::Dashed | Mark::Dotted if places.len() < 2 => {
            places.into_iter().for_each(|place| svg.circle(colour.fill(), place, 2.0));
        }
        Mark::Line => svg.line(colour.stroke(width), places),
        Mark::Dashed => svg.line(colour.dashed(width, [6, 4]), places),
        Mark::Dotted => svg.line(colour.dashed(width, [2, 3]), places),
        Mark::Dots(radius) => {
            places.into_iter().for_each(|place| svg.circle(colour.fill(), place, f64::from(radius)));
        }
        Mark::Rings(radius) => {
            places.into_iter().for_each(|place| svg.circle(colour.stroke(2.0), place, f64::from(radius)));
        }
    }
}

/// Upright lines within the range, their names in rows so that neighbours do not overlap.
fn draw_marks(svg: &mut Svg, frame: &Frame<'_>, marks: &[(f64, String)], has_names: bool) {
    let within = marks.iter().filter_map(|(at, name)| Some((frame.x.share(*at)?, name)));
    for (number, (share, name)) in within.filter(|(share, _)| (0.0..=1.0).contains(share)).enumerate() {
        let x = frame.left + share * frame.width;
        svg.line(BLACK.dashed(1.0, [3, 3]), [(x, frame.top), (x, frame.top + frame.height)]);
        if has_names {
            let (anchor, off) = if share < 0.7 { (Anchor::Start, 4.0) } else { (Anchor::End, -4.0) };
            let y = frame.top + 12.0 + 15.0 * (number % 4) as f64;
            rimmed(svg, (x + off, y), anchor, [WHITE, BLACK], name);
        }
    }
}

/// Entries below one another; those that find no room are counted.
fn draw_legend(svg: &mut Svg, frame: &Frame<'_>, entries: &[(&str, Mark, Rgb, u32)]) {
    let room = (frame.height / f64::from(ENTRY)) as usize;
    let shown = if entries.len() > room { room - 1 } else { entries.len() };
    let (left, top) = (f64::from(WIDTH), frame.top + 10.0);
    let at = |row: usize| top + f64::from(ENTRY * row as u32);
    for (row, (label, kind, colour, width)) in entries.iter().take(shown).enumerate() {
        let y = at(row);
        let places = match kind {
            Mark::Line | Mark::Dashed | Mark::Dotted => vec![(left, y), (left + 18.0, y)],
            Mark::Dots(_) | Mark::Rings(_) => vec![(left + 9.0, y)],
        };
        // wider than in the panel, in the same order
        mark(svg, *kind, *colour, f64::from(*width) + 1.0, places);
        svg.text("", (left + 24.0, y + TEXT), Anchor::Start, label);
    }
    if shown < entries.len() {
        let more = format!("and {} more", entries.len() - shown);
        svg.text("", (left + 24.0, at(shown) + TEXT), Anchor::Start, &more);
    }
}

/// First, smallest, largest and last point of every column of pixels: the picture of all points.
fn thinned(points: &[(f64, f64)], (from, to): (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    if points.len() <= 4 * columns {
        return points.to_vec();
    }
    let column = |x: f64| ((x - from) / (to - from) * columns as f64) as usize;
    let mut thin = Vec::with_capacity(4 * columns);
    for run in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let by_value = |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
        let low = run.iter().enumerate().min_by(by_value).map_or(0, |found| found.0);
        let high = run.iter().enumerate().max_by(by_value).map_or(0, |found| found.0);
        let mut kept = vec![0, low, high, run.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        thin.extend(kept.into_iter().map(|at| run[at]));
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_has_its_decades_and_no_zero() {
        let points = vec![(0.0, 0.0), (1.0, 0.02), (2.0, 30.0), (3.0, -1.0)];
        let panel = Panel { y_label: "y".into(), lines: vec![Line::new("", points)], is_log: true, ..Panel::default() };
        let svg = panels("t", "x", &[panel]).svg().to_owned();
        assert!([">0.1<", ">1<", ">10<"].iter().all(|tick| svg.contains(tick)) && !svg.contains("NaN"), "{svg}");
        let line = svg.lines().find(|line| line.starts_with("<polyline")).expect("a line");
        assert_eq!(line.matches(',').count(), 2, "zero and below have no place: {line}");
    }

    #[test]
    fn many_lines_have_a_legend_and_styles_of_their_own() {
        let line = |k: usize| Line::new(&format!("line {k}"), vec![(0.0, k as f64), (1.0, k as f64)]);
        let panel = Panel { y_label: "y".into(), lines: (0..20).map(line).collect(), ..Panel::default() };
        let svg = panels("t", "x", &[panel]).svg().to_owned();
        assert!((0..20).all(|k| svg.contains(&format!(">line {k}<"))) && !svg.contains("more"), "{svg}");
        let styles: Vec<(Rgb, Mark)> = (0..20).map(|k| style(k, Mark::Line)).collect();
        assert!((0..20).all(|k| !styles[..k].contains(&styles[k])), "{styles:?}");
    }

    /// A history of one instant is a point, not an empty panel.
    #[test]
    fn a_line_of_one_point_is_a_dot() {
        let panel = Panel { y_label: "y".into(), lines: vec![Line::new("", vec![(1.0, 2.0)])], ..Panel::default() };
        assert!(panels("t", "x", &[panel]).svg().contains("<circle"));
    }

    #[test]
    fn thinning_keeps_peaks_and_ends() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), f64::from(k % 7))).collect();
        points[54_321].1 = 99.0;
        let thin = thinned(&points, (0.0, 99_999.0), 800);
        assert!(thin.len() <= 4 * 801);
        assert!(thin.contains(&(54_321.0, 99.0)));
        assert_eq!((thin[0], thin[thin.len() - 1]), (points[0], points[99_999]));
    }
}
