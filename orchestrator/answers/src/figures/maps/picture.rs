//! One picture: its layers, and its scale beside it.

use super::super::COLOURS;
use super::super::style::{GREY, rimmed};
use super::colour::{Colours, STEPS};
use super::layers::{Layers, Picture};
use super::{HEIGHT, UNKNOWN, WIDTH};
use crate::drawing::{Anchor, Axis, BLACK, Frame, INK, Rgb, Ruling, Svg, TEXT, WHITE};

/// The hatching of what has no sample.
const HATCH: Rgb = Rgb(225, 225, 225);
/// Room for the scale, labels of x and y, the title \[px\].
const BAR: f64 = 96.0;
const BELOW: f64 = 40.0;
const LEFT: f64 = 62.0;
const ABOVE: f64 = 26.0;

pub(super) fn draw(svg: &mut Svg, (left, top): (f64, f64), picture: &Picture<'_>, colours: &Colours) {
    svg.text("", (left + LEFT, top + ABOVE / 2.0 + TEXT), Anchor::Start, &picture.title);
    let (right, bottom) = (left + f64::from(WIDTH) - BAR, top + f64::from(HEIGHT) - BELOW);
    if picture.map.cells.is_empty() {
        let middle = ((left + right) / 2.0, (top + ABOVE + bottom) / 2.0);
        svg.text("font-size=\"11\"", middle, Anchor::Middle, "no cell is drawn: no samples, or too few");
        return;
    }
    let layers = Layers::new(picture, colours);
    let ((x0, x1), (y0, y1)) = (layers.x.ends(), layers.y.ends());
    let (x, y) = (Axis::between(&*layers.x.label, (x0, x1)), Axis::between(&*layers.y.label, (y0, y1)));
    let frame = Frame::new(&x, &y, [left + LEFT, top + ABOVE, right - 4.0, bottom]);
    strokes(svg, &frame, &layers.hatching, &[(HATCH, 1.0)]);
    // a little over the next cell: edges that only touch show as hairlines
    let over = (0.8 * (x1 - x0) / f64::from(WIDTH), 0.8 * (y1 - y0) / f64::from(HEIGHT));
    let colour = |share: Option<f64>| share.map_or(UNKNOWN, |share| colours.at(share)).fill();
    for tile in &layers.tiles {
        let to = ((tile.to.0 + over.0).min(x1), (tile.to.1 + over.1).min(y1));
        frame.rect(svg, colour(tile.harmless), [tile.from, to]);
        if let Some(harmful) = tile.harmful {
            frame.area(svg, colour(harmful), tile.upper_half(to));
        }
    }
    strokes(svg, &frame, &layers.contours, &[(WHITE, 2.5), (BLACK, 1.0)]);
    strokes(svg, &frame, &layers.boundaries, &[(WHITE, 5.0), (COLOURS[1], 3.0)]);
    let marks = |places: &[(f64, f64)], mark: &str| {
        let place = |(x, y): (f64, f64)| format!("M{x:.1},{y:.1}{mark}");
        frame.places(places.iter().copied()).map(place).collect::<String>()
    };
    for path in [marks(&layers.diamonds, "m-4,0l4,-4l4,4l-4,4z"), marks(&layers.crosses, "m-4,-4l8,8m0,-8l-8,8")] {
        if !path.is_empty() {
            svg.path(WHITE.stroke(4.0), &path);
            svg.path(BLACK.stroke(2.0), &path);
        }
    }
    for (name, place) in &layers.names {
        if let Some((x, y)) = frame.place(*place) {
            rimmed(svg, (x, y + TEXT), Anchor::Middle, [WHITE, BLACK], name);
        }
    }
    frame.axes(svg, Ruling::Ticks, 46.0);
    bar(svg, (right + 4.0, top + ABOVE, bottom), &colours.label(&picture.name), colours);
}

/// Lines, each colour over all of the one before.
fn strokes(svg: &mut Svg, frame: &Frame<'_>, lines: &[impl AsRef<[(f64, f64)]>], strokes: &[(Rgb, f64)]) {
    let line = |line: &[(f64, f64)]| {
        let places = frame.places(line.iter().copied()).enumerate();
        places.map(|(at, (x, y))| format!("{}{x:.1},{y:.1}", if at == 0 { 'M' } else { 'L' })).collect::<String>()
    };
    let path: String = lines.iter().map(|of| line(of.as_ref())).collect();
    for (colour, width) in strokes.iter().filter(|_| !path.is_empty()) {
        svg.path(colour.stroke(*width), &path);
    }
}

/// The scale: colours, marks at the levels of the lines, its name along it.
fn bar(svg: &mut Svg, (left, top, bottom): (f64, f64, f64), name: &str, colours: &Colours) {
    let right = left + 14.0;
    let at = |share: f64| bottom - share * (bottom - top);
    for step in 0..STEPS {
        let (low, high) = (step as f64 / STEPS as f64, (step as f64 + 1.0) / STEPS as f64);
        // from the upper edge a little over the next
        svg.rect(colours.at(0.5 * (low + high)).fill(), (left, at(high)), (right, (at(low) + 0.5).min(bottom)));
    }
    svg.rect(GREY.stroke(1.0), (left, top), (right, bottom));
    for level in &colours.levels {
        let y = at(colours.share(*level));
        svg.line(INK, [(left, y), (right + 4.0, y)]);
        svg.text("", (right + 6.0, y + TEXT), Anchor::Start, &colours.mark(*level));
    }
    svg.turned((left + 78.0, (top + bottom) / 2.0), name);
}
