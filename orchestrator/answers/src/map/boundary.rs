//! Regime boundaries between the cells of a map, as smooth lines.
//!
//! ```text
//! cells --> a node on each side that two cells of different regimes share; nodes of one square of four cells are joined, of three regimes at its middle
//!   --level--> each node moves between the two middles to the mean of its line around it   --round--> lines with rounded corners
//! ```
//! A node stays between the midpoints of its two cells, and a rounded line stays within the angle of its nodes. Therefore each midpoint is on
//! the side of its own regime.
//! Source: S. F. F. Gibson, "Constrained elastic surface nets" (1998); G. M. Chaikin (1974) for the corners.
//! Verified by `a_boundary_separates_the_regimes_and_no_other_cells`, `a_slanting_boundary_has_no_steps`.

use super::{Axis, Map};
use std::collections::BTreeMap;

/// A line through points.
pub type Line = Vec<(f64, f64)>;

/// Largest displacement of a node from the side of its cells, in cells.
const SLIDE: f64 = 0.4;
/// Number of nodes on either side over which a node is averaged: the largest, and as a fraction of the line, so that short lines keep their shape.
const AROUND: usize = 6;
const PART: usize = 6;
/// Number of averaging rounds, and of corner-cutting rounds.
const LEVELS: usize = 2;
const ROUNDS: usize = 2;

/// A place in half cells: the midpoint of cell i is 2 i, its sides are 2 i - 1 and 2 i + 1.
type Key = (i64, i64);

struct Node {
    key: Key,
    /// Place in cells.
    place: [f64; 2],
    joined: Vec<usize>,
}

#[derive(Default)]
struct Net {
    nodes: Vec<Node>,
    by_key: BTreeMap<Key, usize>,
}

impl Net {
    fn node(&mut self, key: Key) -> usize {
        *self.by_key.entry(key).or_insert_with(|| {
            let place = [0.5 * key.0 as f64, 0.5 * key.1 as f64];
            self.nodes.push(Node { key, place, joined: Vec::new() });
            self.nodes.len() - 1
        })
    }

    fn join(&mut self, a: Key, b: Key) {
        let (a, b) = (self.node(a), self.node(b));
        self.nodes[a].joined.push(b);
        self.nodes[b].joined.push(a);
    }

    /// Moves the nodes of a line across their sides towards the mean; an end on the edge of the map follows the node beside it.
    fn level(&mut self, line: &[usize]) {
        let is_closed = line[0] == line[line.len() - 1];
        let count = if is_closed { line.len() - 1 } else { line.len() };
        let before: Vec<[f64; 2]> = line.iter().map(|at| self.nodes[*at].place).collect();
        for at in 0..count {
            let key = self.nodes[line[at]].key;
            let Some(axis) = axis_of(key) else { continue };
            let room = if is_closed { count } else { at.min(count - 1 - at) };
            let around = AROUND.min(count / PART).min(room) as i64;
            let place = |off: i64| before[(at as i64 + off).rem_euclid(count as i64) as usize][axis];
            let mean = (-around..=around).map(place).sum::<f64>() / (2 * around + 1) as f64;
            let side = 0.5 * [key.0, key.1][axis] as f64;
            self.nodes[line[at]].place[axis] = mean.clamp(side - SLIDE, side + SLIDE);
        }
        for (end, beside) in [(line[0], line[1]), (line[line.len() - 1], line[line.len() - 2])] {
            if let Some(axis) = axis_of(self.nodes[beside].key).filter(|_| self.nodes[end].joined.len() == 1) {
                self.nodes[end].place[axis] = self.nodes[beside].place[axis];
            }
        }
    }

    /// Lines between nodes at which not exactly two pieces meet, followed by closed lines.
    fn lines(&self) -> Vec<Vec<usize>> {
        let mut is_taken = vec![false; self.nodes.len()];
        let is_end = |at: usize| self.nodes[at].joined.len() != 2;
        let mut lines = Vec::new();
        for start in (0..self.nodes.len()).filter(|at| is_end(*at)) {
            for &first in &self.nodes[start].joined {
                if is_end(first) {
                    if start < first {
                        lines.push(vec![start, first]);
                    }
                    continue;
                }
                if is_taken[first] {
                    continue;
                }
                lines.push(self.follow(start, first, &mut is_taken));
            }
        }
        for start in 0..self.nodes.len() {
            if !is_end(start) && !is_taken[start] {
                is_taken[start] = true;
                lines.push(self.follow(start, self.nodes[start].joined[0], &mut is_taken));
            }
        }
        lines
    }

    fn follow(&self, start: usize, first: usize, is_taken: &mut [bool]) -> Vec<usize> {
        let (mut line, mut at) = (vec![start], first);
        loop {
            let before = line[line.len() - 1];
            line.push(at);
            let node = &self.nodes[at];
            if at == start || node.joined.len() != 2 {
                return line;
            }
            is_taken[at] = true;
            at = if node.joined[0] == before { node.joined[1] } else { node.joined[0] };
        }
    }
}

/// Axis along which a node may move: across its side; `None` for the middle of four cells, or a node on the edge.
fn axis_of(key: Key) -> Option<usize> {
    match (key.0.rem_euclid(2), key.1.rem_euclid(2)) {
        (1, 0) => Some(0),
        (0, 1) => Some(1),
        _ => None,
    }
}

/// Cuts the corners of a line; a closed line repeats its first point.
fn round(line: Line) -> Line {
    let is_closed = line.len() > 3 && line[0] == line[line.len() - 1];
    let mut line = line;
    for _ in 0..ROUNDS {
        let mix = |a: (f64, f64), b: (f64, f64), t: f64| (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
        let pairs = || line.windows(2);
        let cut: Line = pairs().flat_map(|pair| [mix(pair[0], pair[1], 0.25), mix(pair[0], pair[1], 0.75)]).collect();
        let (first, last) = (line[0], line[line.len() - 1]);
        line = if is_closed {
            let again = cut[0];
            cut.into_iter().chain([again]).collect()
        } else {
            std::iter::once(first).chain(cut).chain([last]).collect()
        };
    }
    line
}

/// Boundary lines between cells of different regimes. At a missing cell they end half-way along the side.
#[must_use]
pub fn boundary(map: &Map) -> Vec<Line> {
    let table = map.table();
    let (columns, rows) = (map.x.at.len() as i64, map.y.at.len() as i64);
    let is_inside = |i: i64, j: i64| (0..columns).contains(&i) && (0..rows).contains(&j);
    let regime = |(i, j): (i64, i64)| {
        let cell = if is_inside(i, j) { table[i as usize][j as usize] } else { None };
        cell.and_then(|cell| cell.regime.as_deref())
    };
    let mut net = Net::default();
    for i in -1..columns {
        for j in -1..rows {
            let middle = (2 * i + 1, 2 * j + 1);
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let sides = [(0, 1), (1, 2), (2, 3), (3, 0)].map(|(a, b)| (corners[a], corners[b]));
            let differ = |a, b| regime(a).is_some() && regime(b).is_some() && regime(a) != regime(b);
            let crossed: Vec<Key> =
                sides.into_iter().filter(|(a, b)| differ(*a, *b)).map(|(a, b)| (a.0 + b.0, a.1 + b.1)).collect();
            let is_whole = corners.iter().all(|corner| regime(*corner).is_some());
            match crossed[..] {
                [a, b] if is_whole => net.join(a, b),
                _ => crossed.iter().for_each(|side| net.join(*side, middle)),
            }
        }
    }
    let lines = net.lines();
    for line in lines.iter().flat_map(|line| [line; LEVELS]) {
        net.level(line);
    }
    let (x, y) = (halves(&map.x), halves(&map.y));
    let of = |halves: &[f64], place: f64| {
        // index 0 is the lower edge of the map, half a cell below the first midpoint
        let along = 2.0 * place + 1.0;
        let from = (along as usize).min(halves.len() - 2);
        halves[from] + (along - from as f64) * (halves[from + 1] - halves[from])
    };
    let point = |at: &usize| (of(&x, net.nodes[*at].place[0]), of(&y, net.nodes[*at].place[1]));
    lines.iter().map(|line| round(line.iter().map(point).collect())).collect()
}

/// Edges and midpoints of the cells, alternately.
fn halves(axis: &Axis) -> Vec<f64> {
    let edges = axis.edges();
    let middles = axis.at.iter().zip(&edges[1..]).flat_map(|(at, edge)| [*at, *edge]);
    edges[..1].iter().copied().chain(middles).collect()
}
