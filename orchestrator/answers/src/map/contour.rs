//! Contour lines of a map.
//!
//! Marching squares on the midpoints of cells, linear between neighbours: exact for a plane. A square with a missing corner has no line, so
//! nothing is drawn without samples. At a saddle the mean of the corners selects the connection.
//! Verified by `a_plane_has_straight_contours_where_they_belong`.

/// A piece of a line.
pub type Piece = [(f64, f64); 2];

/// Smallest number of values along each axis for contour lines: with fewer they follow the grid instead of the values.
pub const FEWEST: usize = 8;

/// Pieces of the contour line of a level; `value`: value by column and row.
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
