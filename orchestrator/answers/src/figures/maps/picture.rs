//! One picture: its layers, and its scale beside it.

use super::super::rimmed::rimmed;
use super::super::style::{FINE, GREY, SMALL, TEXT, tick_within};
use super::super::{Area, COLOURS, FigureError};
use super::colour::{Colours, STEPS};
use super::layers::{Layers, Picture};
use super::{HEIGHT, UNKNOWN, WIDTH};
use plotters::prelude::{
    BLACK, ChartBuilder, Color, EmptyElement, IntoFont, PathElement, Polygon, RGBColor, Rectangle, Text, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The hatching of what has no sample.
const HATCH: RGBColor = RGBColor(225, 225, 225);
/// Room for the scale, labels of x and y, the title \[px\].
const BAR: u32 = 96;
const BELOW: u32 = 38;
const LEFT: u32 = 58;
/// Left of the name of an axis, which would touch the edge.
const ROOM: u32 = 4;
const ABOVE: u32 = 26;

pub(super) fn draw(area: &Area<'_>, picture: &Picture<'_>, colours: &Colours) -> Result<(), FigureError> {
    let (title, rest) = area.split_vertically(ABOVE * FINE);
    let style = SMALL.into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    title.draw(&Text::new(picture.title.clone(), ((LEFT * FINE) as i32, (ABOVE * FINE / 2) as i32), style))?;
    let (left, right) = rest.split_horizontally((WIDTH - BAR) * FINE);
    if picture.map.cells.is_empty() {
        let style = TEXT.into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        let middle = (((WIDTH - BAR) * FINE / 2) as i32, ((HEIGHT - ABOVE) * FINE / 2) as i32);
        left.draw(&Text::new("no cell is drawn: no samples, or too few", middle, style))?;
        return Ok(());
    }
    let layers = Layers::new(picture, colours);
    let ((x0, x1), (y0, y1)) = (layers.x.ends(), layers.y.ends());
    let mut chart = ChartBuilder::on(&left)
        .margin_right(4 * FINE)
        .x_label_area_size(BELOW * FINE)
        .margin_left(ROOM * FINE)
        .y_label_area_size((LEFT - ROOM) * FINE)
        .build_cartesian_2d(x0..x1, y0..y1)?;
    strokes(&mut chart, &layers.hatching, &[(HATCH, FINE)])?;
    // a little over the next cell: edges that only touch show as hairlines
    let over = (0.4 * (x1 - x0) / f64::from(WIDTH), 0.4 * (y1 - y0) / f64::from(HEIGHT));
    let colour = |share: Option<f64>| share.map_or(UNKNOWN, |share| colours.at(share));
    for tile in &layers.tiles {
        let to = ((tile.to.0 + over.0).min(x1), (tile.to.1 + over.1).min(y1));
        chart.draw_series([Rectangle::new([tile.from, to], colour(tile.harmless).filled())])?;
        if let Some(harmful) = tile.harmful {
            chart.draw_series([Polygon::new(tile.upper_half(to).to_vec(), colour(harmful).filled())])?;
        }
    }
    strokes(&mut chart, &layers.contours, &[(WHITE, 2 * FINE + 2), (BLACK, FINE)])?;
    strokes(&mut chart, &layers.boundaries, &[(WHITE, 5 * FINE), (COLOURS[1], 3 * FINE)])?;
    let size = (0.012 * (x1 - x0), 0.016 * (y1 - y0));
    for (u, v) in layers.diamonds {
        let corners = [(u - size.0, v), (u, v + size.1), (u + size.0, v), (u, v - size.1)];
        let sides = [0, 1, 2, 3].map(|at| [corners[at], corners[(at + 1) % 4]]);
        strokes(&mut chart, &sides, &[(WHITE, 4 * FINE), (BLACK, 2 * FINE)])?;
    }
    for (u, v) in layers.crosses {
        let arms = [
            [(u - size.0, v - size.1), (u + size.0, v + size.1)],
            [(u - size.0, v + size.1), (u + size.0, v - size.1)],
        ];
        strokes(&mut chart, &arms, &[(WHITE, 4 * FINE), (BLACK, 2 * FINE)])?;
    }
    for (name, place) in layers.names {
        let middle = Pos::new(HPos::Center, VPos::Center);
        rimmed(&name, (0, 0), middle, [WHITE, BLACK], |text| {
            chart.draw_series([EmptyElement::at(place) + text])?;
            Ok(())
        })?;
    }
    chart
        .configure_mesh()
        .disable_mesh()
        .set_all_tick_mark_size(4 * FINE)
        .axis_style(BLACK.stroke_width(FINE))
        .x_labels(7)
        .y_labels(8)
        .x_label_formatter(&|value| tick_within(*value, layers.x.ends()))
        .y_label_formatter(&|value| tick_within(*value, layers.y.ends()))
        .label_style(SMALL.into_font())
        .axis_desc_style(SMALL.into_font())
        .x_desc(&layers.x.label)
        .y_desc(&layers.y.label)
        .draw()?;
    bar(&right, &colours.label(&picture.name), colours)
}

type Chart<'a, 'b> = plotters::prelude::ChartContext<
    'a,
    plotters::prelude::SVGBackend<'b>,
    plotters::prelude::Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Lines, each colour over all of the one before.
fn strokes(
    chart: &mut Chart<'_, '_>,
    lines: &[impl AsRef<[(f64, f64)]>],
    strokes: &[(RGBColor, u32)],
) -> Result<(), FigureError> {
    for (colour, width) in strokes {
        let style = colour.stroke_width(*width);
        chart.draw_series(lines.iter().map(|line| PathElement::new(line.as_ref().to_vec(), style)))?;
    }
    Ok(())
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
