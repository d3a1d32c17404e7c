//! Lines on which a map has a level, and edges between cells of different regimes.
//!
//! Marching squares on the middles of cells, linear between neighbours: exact for a plane. A square with a corner that has no value
//! has no line: nothing is drawn where no sample is. Of a saddle the mean of the corners decides.
//! Verified by `a_plane_has_straight_contours_where_they_belong`.

use super::Map;

/// A piece of a line.
pub type Piece = [(f64, f64); 2];

/// Pieces of the line of a level; `value` by column and row.
#[must_use]
pub fn contour(xs: &[f64], ys: &[f64], value: impl Fn(usize, usize) -> Option<f64>, level: f64) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for i in 1..xs.len() {
        for j in 1..ys.len() {
            // anticlockwise from the lower left
            let corners = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)];
            let values: Vec<f64> = corners.iter().filter_map(|&(i, j)| value(i, j)).collect();
            let Ok(values) = <[f64; 4]>::try_from(values) else { continue };
            let is_above = values.map(|value| value >= level);
            let crossed = |edge: usize| {
                let (a, b) = (edge, (edge + 1) % 4);
                let share = (level - values[a]) / (values[b] - values[a]);
                let of = |from: f64, to: f64| from + share * (to - from);
                let ((i, j), (k, l)) = (corners[a], corners[b]);
                (of(xs[i], xs[k]), of(ys[j], ys[l]))
            };
            let edges: Vec<usize> = (0..4).filter(|&edge| is_above[edge] != is_above[(edge + 1) % 4]).collect();
            match edges[..] {
                [a, b] => pieces.push([crossed(a), crossed(b)]),
                [a, b, c, d] => {
                    let joins_first = (values.iter().sum::<f64>() / 4.0 >= level) == is_above[0];
                    let pairs = if joins_first { [(a, b), (c, d)] } else { [(d, a), (b, c)] };
                    pieces.extend(pairs.map(|(from, to)| [crossed(from), crossed(to)]));
                }
                _ => {}
            }
        }
    }
    pieces
}

/// Edges between neighbouring cells whose regimes differ.
#[must_use]
pub fn boundary(map: &Map) -> Vec<Piece> {
    let (x, y, table) = (map.x.edges(), map.y.edges(), map.table());
    let regime = |i: usize, j: usize| table[i][j].and_then(|cell| cell.regime.as_deref());
    let differ = |a: Option<&str>, b: Option<&str>| a.is_some() && b.is_some() && a != b;
    let mut pieces = Vec::new();
    for i in 0..table.len() {
        for j in 0..map.y.at.len() {
            if i > 0 && differ(regime(i - 1, j), regime(i, j)) {
                pieces.push([(x[i], y[j]), (x[i], y[j + 1])]);
            }
            if j > 0 && differ(regime(i, j - 1), regime(i, j)) {
                pieces.push([(x[i], y[j]), (x[i + 1], y[j])]);
            }
        }
    }
    pieces
}
