//! Maps as pictures: smooth boundaries, the same layers in a page as in a picture, few failed runs.

use super::maps::{Rows, of_z, over};
use bladeoff_answers::figures;
use bladeoff_answers::map::boundary::boundary;
use bladeoff_answers::map::{Map, Wanted};
use bladeoff_answers::page::{Plot, map_figures};
use bladeoff_model::outcome::Status;

/// Cells on a square grid with a regime that is free where `is_free`.
fn regimes(count: u32, is_free: impl Fn(f64, f64) -> bool) -> Map {
    let mut rows = Rows::default();
    for x in 0..count {
        for y in 0..count {
            let (x, y) = (f64::from(x), f64::from(y));
            rows.add((x, y), 0.0, "a", if is_free(x, y) { 0.0 } else { 2.0 });
        }
    }
    rows.maps(&of_z(true)).remove(0)
}

/// Number of crossings of a line between two places, from the signs of four areas; a place on a line counts as one side.
fn crossings(lines: &[Vec<(f64, f64)>], from: (f64, f64), to: (f64, f64)) -> usize {
    let side =
        |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0) > 0.0;
    let pieces = lines.iter().flat_map(|line| line.windows(2));
    let crosses = |a, b| side(a, b, from) != side(a, b, to) && side(from, to, a) != side(from, to, b);
    pieces.filter(|piece| crosses(piece[0], piece[1])).count()
}

#[test]
fn a_boundary_separates_the_regimes_and_no_other_cells() {
    // scattered islands, tongues and saddles
    let scattered = |x: f64, y: f64| ((x * 12.9898 + y * 78.233).sin() * 43758.5453).rem_euclid(1.0) < 0.5;
    let disc = |x: f64, y: f64| x * x + y * y < 90.0;
    for (map, least) in [(regimes(9, scattered), 50), (regimes(12, disc), 10)] {
        let lines = boundary(&map);
        let table = map.table();
        let regime = |i: usize, j: usize| table[i][j].and_then(|cell| cell.regime.clone()).expect("a regime");
        let mut crossed = 0;
        let last = map.x.at.len() - 1;
        for i in 0..=last {
            for j in 0..=last {
                for (k, l) in [(i + 1, j), (i, j + 1)].into_iter().filter(|(k, l)| *k <= last && *l <= last) {
                    let differs = regime(i, j) != regime(k, l);
                    crossed += usize::from(differs);
                    // places slightly off the midpoints, so that no line goes through one
                    let [from, to] = [(i, j), (k, l)].map(|(i, j)| (map.x.at[i] + 1e-7, map.y.at[j] + 2e-7));
                    assert_eq!(crossings(&lines, from, to), usize::from(differs), "{i} {j} to {k} {l}");
                }
            }
        }
        assert!(crossed > least, "{crossed}");
    }
}

#[test]
fn a_slanting_boundary_has_no_steps() {
    let slanting = |x: f64, y: f64| y < 5.3 + 0.3 * x;
    let map = regimes(24, slanting);
    let lines = boundary(&map);
    let [line] = &lines[..] else { panic!("one line: {lines:?}") };
    let off = |(x, y): &(f64, f64)| (y - 5.3 - 0.3 * x).abs();
    let largest = line.iter().map(off).fold(0.0, f64::max);
    // seven steps would turn by a right angle twice each: 22
    let turns = line.windows(3).map(|at| {
        let [a, b] = [(at[0], at[1]), (at[1], at[2])].map(|(p, q)| libm::atan2(q.1 - p.1, q.0 - p.0));
        (b - a).abs()
    });
    let turned = turns.sum::<f64>();
    assert!(largest < 0.75, "{largest}");
    assert!(line.len() > 24 && turned < 5.0, "{turned}: {line:?}");
}

/// Three failed runs among many: no cell is grey, neither in the values nor in the half widths.
#[test]
fn few_failed_runs_grey_nothing_of_a_smoothed_map() {
    let mut rows = Rows { points: Some(600), ..Rows::default() };
    for at in 0..600 {
        let (x, y) = ((f64::from(at) * 0.618_034).fract(), (f64::from(at) + 0.5) / 600.0);
        let noise = ((f64::from(at) * 12.9898).sin() * 43758.5453).rem_euclid(1.0);
        rows.add((x, y), 0.0, "a", x + 2.0 * y + 0.3 * noise);
    }
    for at in [20, 300, 580] {
        (rows.z[at], rows.regime[at], rows.status[at]) = (None, None, Status::Failed);
    }
    for wanted in [of_z(false), Wanted { of: over(1.5), ..of_z(false) }] {
        let found = rows.maps(&wanted);
        let [map] = &found[..] else { panic!("one panel") };
        assert_eq!(map.bad, 3);
        assert!(map.cells.len() > 1000, "{:?}", map.width);
        let near = map.cells.iter().filter(|cell| cell.is_open && cell.half_width.is_some()).count();
        assert!(near > 10, "cells around the failed runs: {near}");
        // at the edges there are too few samples for limits
        let without = map.cells.iter().filter(|cell| cell.half_width.is_none()).count();
        assert!(5 * without < map.cells.len(), "{without}");
        let svg = figures::maps("m", &found).svg().to_owned();
        let grey = svg.matches("#BEBEBE").count();
        assert!(grey <= without + 3, "{grey} tiles, of cells without limits ({without}) and of the failed runs");
        assert!(svg.contains("crosses: bad runs"));
        let page = map_figures("m", &found, 1).remove(0);
        let Some(Plot::Traces(traces, layout)) = page.plot else { panic!("a plot") };
        let heats = traces.as_array().expect("traces").iter().filter(|trace| trace["type"] == "heatmap").count();
        assert_eq!(heats, 2 + usize::from(without > 0), "values, half widths, and grey where they are missing");
        assert_eq!(layout["coloraxis"]["colorscale"].as_array().map(Vec::len), Some(65));
        assert!(page.caption.contains("crosses: bad runs"), "{}", page.caption);
    }
}

/// A map in a page has the layers of the picture: colours, triangles, lines, boundary, hatching.
#[test]
fn a_map_of_a_page_is_the_picture() {
    let mut rows = Rows::default();
    for x in 0..9 {
        for y in 0..8 {
            if (x, y) == (8, 7) {
                continue;
            }
            for start in [0.0, 1.0, 2.0] {
                let z = 0.2 * f64::from(x) + 0.01 * f64::from(y) + 0.001 * start;
                rows.add((f64::from(x), f64::from(y)), start, "a", z);
            }
        }
    }
    rows.status[10] = Status::Failed;
    rows.z[10] = None;
    let found = rows.maps(&of_z(true));
    let page = map_figures("m", &found, 1).remove(0);
    let Some(Plot::Traces(traces, layout)) = page.plot else { panic!("a plot") };
    let traces = traces.as_array().expect("traces");
    let first: Vec<_> = traces.iter().filter(|trace| trace["xaxis"] == "x").collect();
    let of = |key: &str, value: &str| first.iter().filter(|trace| trace[key] == value).count();
    assert_eq!(of("type", "heatmap"), 1);
    assert_eq!(of("fill", "toself"), 1, "the cell of the failed run is split");
    let marks = first.iter().filter(|trace| trace["mode"] == "markers");
    let colours: Vec<_> = marks.map(|trace| trace["marker"]["color"].as_str().unwrap_or_default()).collect();
    assert_eq!(colours, ["rgb(255,255,255)", "rgb(0,0,0)"], "and has a cross, black on white");
    let lines = |colour: &str| first.iter().find(|trace| trace["line"]["color"] == colour);
    assert_eq!(layout["shapes"].as_array().map(Vec::len), Some(2), "a cell is missing: both pictures are hatched");
    // each piece of a contour is two points and a gap
    let pieces = lines("rgb(0,0,0)").expect("contours")["x"].as_array().expect("numbers").len() / 3;
    let svg = figures::maps("", &found);
    assert!(pieces > 30 && svg.svg().contains("lines: the levels"), "{pieces}");
    let edge = lines("rgb(213,94,0)").expect("the boundary of regimes");
    // 0.2 x + 0.01 y crosses 1 between 4 and 5
    let along: Vec<f64> = edge["x"].as_array().expect("numbers").iter().filter_map(|x| x.as_f64()).collect();
    assert!(along.len() > 8 && along.iter().all(|x| (4.0..=5.0).contains(x)), "{along:?}");
    // the colour at the end of the scale is that of the picture
    assert_eq!(layout["coloraxis"]["colorscale"][64][1], "rgb(253,231,37)");
    assert!(svg.svg().contains("#FDE725"));
    // seven values along an axis are too few for lines
    rows.x.iter_mut().zip(&mut rows.status).for_each(|(x, status)| {
        if *x > Some(6.5) {
            (*x, *status) = (None, Status::Failed);
        }
    });
    let few = rows.maps(&of_z(true));
    assert_eq!(few[0].x.at.len(), 7);
    assert!(!figures::maps("", &few).svg().contains("lines: the levels"));
}
