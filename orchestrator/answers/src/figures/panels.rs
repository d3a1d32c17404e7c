//! Lines over a common axis: one panel below the other, each with its own scale, its legend beside it.

use super::rimmed::rimmed;
use super::style::{FINE, GRID, SMALL, TEXT, TITLE, roomy, tick, tick_within};
use super::{Area, COLOURS, Figure, FigureError};
use plotters::coord::types::RangedCoordf64;
use plotters::element::Circle;
use plotters::prelude::{
    BLACK, Cartesian2d, ChartBuilder, ChartContext, Color, DashedLineSeries, EmptyElement, IntoFont, LineSeries,
    PathElement, RGBColor, SVGBackend, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mark {
    /// Joined by a line.
    #[default]
    Line,
    /// Joined by a dashed line.
    Dashed,
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
    /// Colour; `None`: the next of the palette.
    pub colour: Option<RGBColor>,
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
    pub fn marked(label: &str, points: Vec<(f64, f64)>, mark: Mark, colour: RGBColor) -> Self {
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
    /// A logarithmic vertical axis over whole decades; values that are not above zero are not drawn.
    pub is_log: bool,
}

impl Panel {
    /// With the powers of ten of its values, over whole decades.
    fn of_powers(&self) -> Panel {
        let power = |&(x, y): &(f64, f64)| Some((x, libm::log10(y))).filter(|point| point.1.is_finite());
        let lines = self
            .lines
            .iter()
            .map(|line| Line { points: line.points.iter().filter_map(power).collect(), ..line.clone() });
        let lines: Vec<Line> = lines.collect();
        let values = || lines.iter().flat_map(|line| &line.points).map(|point| point.1);
        let range = self.y_range.map(|(low, high)| (libm::log10(low), libm::log10(high)));
        let (low, high) = range.unwrap_or_else(|| roomy(values(), 0.0));
        let (low, high) = (libm::floor(low + 1e-9), libm::ceil(high - 1e-9));
        Panel { y_range: Some((low, if high > low { high } else { low + 1.0 })), lines, ..self.clone() }
    }
}

/// Width of a figure without legends \[px\].
const WIDTH: u32 = 900;
/// Height of a panel without axis texts \[px\].
const HEIGHT: u32 = 190;
/// Height of an entry of a legend \[px\].
const ENTRY: u32 = 18;

/// Draws panels below one another.
///
/// # Errors
/// The plotting library failed.
pub fn panels(title: &str, x_label: &str, panels: &[Panel]) -> Result<Figure, FigureError> {
    panels_marked(title, x_label, panels, &[])
}

/// Draws panels with marks: places along x that all panels share, with names in the first panel.
///
/// # Errors
/// The plotting library failed.
pub fn panels_marked(
    title: &str,
    x_label: &str,
    panels: &[Panel],
    marks: &[(f64, String)],
) -> Result<Figure, FigureError> {
    let below = 44;
    let height = 48 + below + HEIGHT * panels.len().max(1) as u32;
    let all = panels.iter().flat_map(|panel| &panel.lines).flat_map(|line| &line.points);
    let x_range = roomy(all.map(|point| point.0), 0.0);
    Figure::draw((WIDTH + legend_width(panels), height), |root| {
        let root = root.titled(title, TITLE)?;
        let mut rest = root;
        for (at, panel) in panels.iter().enumerate() {
            let last = at + 1 == panels.len();
            let (area, next) = rest.split_vertically((HEIGHT + if last { below } else { 0 }) * FINE);
            let chart = draw(&area, panel, x_range, last.then_some(x_label), HEIGHT)?;
            draw_marks(chart, marks, at == 0)?;
            rest = next;
        }
        Ok(())
    })
}

/// Draws one tall panel over a range of its own.
///
/// # Errors
/// The plotting library failed.
pub fn tall_panel(title: &str, x_label: &str, panel: &Panel, x_range: (f64, f64)) -> Result<Figure, FigureError> {
    let height = 500;
    Figure::draw((WIDTH + legend_width(std::slice::from_ref(panel)), height + 60), |root| {
        let root = root.titled(title, TITLE)?;
        draw(&root, panel, x_range, Some(x_label), height).map(|_| ())
    })
}

/// Room for the longest entry of all legends, beside the panels: over them it would hide lines \[px\].
fn legend_width(panels: &[Panel]) -> u32 {
    let labels = panels.iter().flat_map(|panel| &panel.lines).map(|line| line.label.chars().count() as u32);
    labels.max().filter(|longest| *longest > 0).map_or(0, |longest| 40 + 7 * longest)
}

fn draw<'a>(
    area: &Area<'a>,
    panel: &Panel,
    x_range: (f64, f64),
    x_label: Option<&str>,
    height: u32,
) -> Result<Chart<'a>, FigureError> {
    let powers = panel.is_log.then(|| panel.of_powers());
    let panel = powers.as_ref().unwrap_or(panel);
    let (area, beside) = area.split_horizontally(WIDTH * FINE);
    let values = panel.lines.iter().flat_map(|line| &line.points).map(|point| point.1);
    let (low, high) = panel.y_range.unwrap_or_else(|| roomy(values, 0.06));
    let mut chart = ChartBuilder::on(&area)
        .margin_right(22 * FINE)
        .margin_top(8 * FINE)
        .margin_left(6 * FINE)
        .x_label_area_size(if x_label.is_some() { 44 * FINE } else { 10 * FINE })
        .y_label_area_size(74 * FINE)
        .build_cartesian_2d(x_range.0..x_range.1, low..high)?;
    let x_text = |value: &f64| if x_label.is_some() { tick_within(*value, x_range) } else { String::new() };
    let y_text = |value: &f64| match panel.is_log {
        true if libm::rint(*value) == *value => tick(libm::exp10(*value)),
        true => String::new(),
        false => tick_within(*value, (low, high)),
    };
    let y_labels = if panel.is_log { (high - low) as usize + 1 } else { (height / 32) as usize };
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE)
        .set_all_tick_mark_size(4 * FINE)
        .axis_style(BLACK.stroke_width(FINE))
        .bold_line_style(GRID.stroke_width(FINE))
        .x_labels(10)
        .y_labels(y_labels)
        .x_label_formatter(&x_text)
        .y_label_formatter(&y_text)
        .label_style(SMALL.into_font())
        .axis_desc_style(TEXT.into_font())
        .y_desc(&panel.y_label);
    if let Some(label) = x_label {
        mesh.x_desc(label);
    }
    mesh.draw()?;
    let mut legend = Vec::new();
    for (at, line) in panel.lines.iter().enumerate() {
        let colour = line.colour.unwrap_or(COLOURS[at % COLOURS.len()]);
        let points =
            if panel.thin { thinned(&line.points, x_range, (WIDTH - 100) as usize) } else { line.points.clone() };
        let dots =
            |radius: u32, style| points.iter().map(move |point| Circle::new(*point, (radius * FINE) as i32, style));
        match line.mark {
            Mark::Line => chart.draw_series(LineSeries::new(points, colour.stroke_width(line.width * FINE)))?,
            Mark::Dashed => {
                let style = colour.stroke_width(line.width * FINE);
                chart.draw_series(DashedLineSeries::new(points, 6 * FINE, 4 * FINE, style))?
            }
            Mark::Dots(radius) => chart.draw_series(dots(radius, colour.filled()))?,
            Mark::Rings(radius) => chart.draw_series(dots(radius, colour.stroke_width(2 * FINE)))?,
        };
        if !line.label.is_empty() {
            legend.push((line.label.as_str(), line.mark, colour));
        }
    }
    draw_legend(&beside, &legend, height)?;
    Ok(chart)
}

type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Upright lines within the range, their names in rows so that neighbours do not overlap.
fn draw_marks(mut chart: Chart<'_>, marks: &[(f64, String)], has_names: bool) -> Result<(), FigureError> {
    let (x, y) = (chart.x_range(), chart.y_range());
    let within = |at: &f64| x.contains(at);
    let (_, pixels) = chart.plotting_area().dim_in_pixel();
    let row = f64::from(15 * FINE) / f64::from(pixels.max(1)) * (y.end - y.start);
    for (number, (at, name)) in marks.iter().filter(|mark| within(&mark.0)).enumerate() {
        let line = [(*at, y.start), (*at, y.end)];
        chart.draw_series(DashedLineSeries::new(line, 3 * FINE, 3 * FINE, BLACK.stroke_width(FINE)))?;
        if has_names {
            let is_left = at - x.start < 0.7 * (x.end - x.start);
            let (side, off) = if is_left { (HPos::Left, 4) } else { (HPos::Right, -4) };
            let place = (*at, y.end - row * (number % 4) as f64);
            rimmed(name, (off, 1), Pos::new(side, VPos::Top), [WHITE, BLACK], |text| {
                chart.draw_series([EmptyElement::at(place) + text])?;
                Ok(())
            })?;
        }
    }
    Ok(())
}

/// Entries below one another; those that find no room are counted.
fn draw_legend(area: &Area<'_>, entries: &[(&str, Mark, RGBColor)], height: u32) -> Result<(), FigureError> {
    let fine = FINE as i32;
    let room = ((height - 20) / ENTRY) as usize;
    let shown = if entries.len() > room { room - 1 } else { entries.len() };
    let style = SMALL.into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let at = |row: usize| (18 + ENTRY as i32 * row as i32) * fine;
    for (row, (label, mark, colour)) in entries.iter().take(shown).enumerate() {
        let y = at(row);
        match mark {
            Mark::Line => area.draw(&PathElement::new([(0, y), (18 * fine, y)], colour.stroke_width(3 * FINE)))?,
            Mark::Dashed => {
                for from in [0, 11] {
                    let dash = [(from * fine, y), ((from + 7) * fine, y)];
                    area.draw(&PathElement::new(dash, colour.stroke_width(2 * FINE)))?;
                }
            }
            Mark::Dots(radius) => area.draw(&Circle::new((9 * fine, y), (radius * FINE) as i32, colour.filled()))?,
            Mark::Rings(radius) => {
                area.draw(&Circle::new((9 * fine, y), (radius * FINE) as i32, colour.stroke_width(2 * FINE)))?;
            }
        }
        area.draw(&plotters::element::Text::new((*label).to_owned(), (24 * fine, y), style.clone()))?;
    }
    if shown < entries.len() {
        let more = format!("and {} more", entries.len() - shown);
        area.draw(&plotters::element::Text::new(more, (24 * fine, at(shown)), style))?;
    }
    Ok(())
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
    fn a_logarithmic_axis_has_whole_decades() {
        let points = vec![(0.0, 0.0), (1.0, 0.02), (2.0, 30.0), (3.0, -1.0)];
        let panel = Panel { y_label: "y".into(), lines: vec![Line::new("", points)], is_log: true, ..Panel::default() };
        let powers = panel.of_powers();
        assert_eq!(powers.y_range, Some((-2.0, 2.0)));
        assert_eq!(powers.lines[0].points.len(), 2, "zero and below have no place");
        let svg = panels("t", "x", &[panel]).expect("drawn").svg().to_owned();
        let ticks = svg.lines().filter(|line| ["0.01", "0.1", "1", "10", "100"].contains(&line.trim())).count();
        assert!(ticks >= 5 && !svg.contains("NaN"), "{svg}");
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
