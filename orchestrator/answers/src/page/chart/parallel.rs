//! Parallel coordinates, which the chart library has not: one upright axis for each coordinate, one line for each run. Bad ones stand out.

use super::drawing::{WIDTH, legend, whole};
use super::{COLOURS, Series, Shape, shown};
use crate::drawing::{Anchor, LETTER, Svg, share_of};
use bladeoff_text::document::cut;
use std::fmt::Write;

const TOP: f64 = 44.0;
const HEIGHT: f64 = 300.0;
const SIDE: f64 = 70.0;
/// Distance of titles from the edge.
const EDGE: f64 = 4.0;

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// With unit.
    pub label: String,
    /// Of each run.
    pub values: Vec<Option<f64>>,
    /// Names of 0, 1, ...; none: numbers.
    pub words: Vec<String>,
}

/// Draws runs; `kinds`: names of what a run may be, the first one `ok`; `kind`: which each is. A run without a value on an axis has a gap there.
#[must_use]
pub fn parallel(coordinates: &[Coordinate], kind: &[usize], kinds: &[String]) -> String {
    let mut svg = Svg::default();
    let step = (WIDTH - 2.0 * SIDE) / (coordinates.len().max(2) - 1) as f64;
    let ranges: Vec<(f64, f64)> = coordinates.iter().map(range).collect();
    let letters = ((step / LETTER) as usize).clamp(6, 40);
    // good ones below, rare ones on top
    for of in 0..kinds.len() {
        let mut path = String::new();
        for (run, _) in kind.iter().enumerate().filter(|(_, kind)| **kind == of) {
            let mut pen = 'M';
            for (at, (coordinate, (low, high))) in coordinates.iter().zip(&ranges).enumerate() {
                let Some(value) = coordinate.values[run].filter(|value| value.is_finite()) else {
                    pen = 'M';
                    continue;
                };
                let y = TOP + HEIGHT * (1.0 - share_of(value, (*low, *high)));
                write!(path, "{pen}{:.0},{y:.0}", SIDE + step * at as f64).expect("writing to a String cannot fail");
                pen = 'L';
            }
        }
        svg.path(format_args!("class=\"run {}\"", class(of)), path);
    }
    for (at, (coordinate, (low, high))) in coordinates.iter().zip(&ranges).enumerate() {
        let x = SIDE + step * at as f64;
        // two rows where they are many
        let y = if coordinates.len() > 4 && at % 2 == 1 { 12.0 } else { 28.0 };
        let bottom = TOP + HEIGHT;
        svg.path("class=\"frame\"", format_args!("M{x:.1},{TOP}V{bottom}"));
        let is_edge = at == 0 || at + 1 == coordinates.len();
        let label = cut(&coordinate.label, letters_of(step, coordinates.len(), is_edge) - 3);
        // what stands at the edge stays inside
        let (x_label, anchor) = match at {
            0 => (EDGE, Anchor::Start),
            _ if at + 1 == coordinates.len() => (WIDTH - EDGE, Anchor::End),
            _ => (x, Anchor::Middle),
        };
        svg.text("", (x_label, y), anchor, &label);
        let ends = match &coordinate.words[..] {
            [] => [(shown(*high), TOP - 3.0 + 14.0), (shown(*low), bottom + 15.0)].to_vec(),
            words => {
                let place = |at: usize| bottom - HEIGHT * (at as f64 - low) / (high - low) + 4.0;
                words.iter().enumerate().map(|(at, word)| (cut(word, letters), place(at))).collect()
            }
        };
        for (text, y) in ends {
            svg.text("class=\"end\"", (x + 5.0, y), Anchor::Start, &text);
        }
    }
    let series: Vec<Series> = kinds
        .iter()
        .enumerate()
        .filter(|(of, _)| kind.contains(of))
        .map(|(of, name)| Series { name: name.clone(), colour: class(of), shape: Shape::Line(Vec::new(), false) })
        .collect();
    let bottom = legend(&mut svg, &series, TOP + HEIGHT + 34.0, SIDE);
    whole(&svg, bottom)
}

/// Letters of a title that keep it from its neighbours in its row. A title at the edge begins outside of its axis and has half of the room.
fn letters_of(step: f64, count: usize, is_edge: bool) -> usize {
    let pitch = if count > 4 { 2.0 * step } else { step };
    let room = if is_edge { SIDE - EDGE + pitch / 2.0 } else { pitch };
    (((room - 2.0 * EDGE) / LETTER) as usize).clamp(6, 80)
}

/// The good ones are grey; the first colour of the others is not the one of good figures.
fn class(kind: usize) -> &'static str {
    match kind {
        0 => "quiet",
        _ => COLOURS[[1, 0, 2, 3, 4, 5, 6][(kind - 1) % 7]],
    }
}

fn range(coordinate: &Coordinate) -> (f64, f64) {
    if !coordinate.words.is_empty() {
        return (-0.5, coordinate.words.len() as f64 - 0.5);
    }
    let values = coordinate.values.iter().flatten().copied().filter(|value| value.is_finite());
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low < high {
        return (low, high);
    }
    let middle = if low == high { low } else { 0.0 };
    let room = (1e-3 * middle.abs()).max(0.5);
    ((middle - room).max(f64::MIN), (middle + room).min(f64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_of_a_row_do_not_overlap() {
        for count in 2..=12 {
            let step = (WIDTH - 2.0 * SIDE) / (count - 1) as f64;
            let width = |at: usize| LETTER * letters_of(step, count, at == 0 || at + 1 == count) as f64;
            let ends = |at: usize| match at {
                0 => (EDGE, EDGE + width(0)),
                _ if at + 1 == count => (WIDTH - EDGE - width(at), WIDTH - EDGE),
                _ => (SIDE + step * at as f64 - width(at) / 2.0, SIDE + step * at as f64 + width(at) / 2.0),
            };
            let next = if count > 4 { 2 } else { 1 };
            for at in 0..count - next {
                assert!(ends(at).1 < ends(at + next).0, "{count} axes: {at} {:?} {:?}", ends(at), ends(at + next));
            }
        }
    }

    #[test]
    fn a_gap_stays_a_gap_and_each_kind_has_its_lines() {
        let numbers =
            |values: &[Option<f64>]| Coordinate { label: "x <m>".into(), values: values.to_vec(), words: Vec::new() };
        let axes = [
            numbers(&[Some(1.0), Some(2.0), Some(3.0)]),
            numbers(&[None, Some(5.0), Some(5.0)]),
            Coordinate {
                label: "way".into(),
                values: vec![Some(0.0), Some(1.0), None],
                words: vec!["a".into(), "b".into()],
            },
        ];
        for extreme in [[Some(f64::MIN), Some(f64::MAX), None], [Some(1e20), Some(1e20), Some(f64::NAN)]] {
            let axes = [numbers(&extreme), numbers(&[Some(f64::MAX), Some(f64::MAX), Some(5e-324)])];
            let svg = parallel(&axes, &[0, 1, 0], &["ok".into(), "diverged".into()]);
            assert!(svg.contains("class=\"run") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
        let svg = parallel(&axes, &[0, 1, 0], &["ok".into(), "diverged".into()]);
        let lines: Vec<&str> = svg.lines().filter(|line| line.contains("class=\"run")).collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].matches('M').count(), 3, "a gap begins a new line: {}", lines[0]);
        assert_eq!((lines[1].matches('M').count(), lines[1].matches('L').count()), (1, 2));
        assert!(svg.contains("x &lt;m&gt;") && svg.contains("diverged") && !svg.contains("NaN"), "{svg}");
    }
}
