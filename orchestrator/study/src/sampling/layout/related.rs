//! Correlation of columns of a design that has too few points for its number of columns: the same rule for the values of a parameter in A and
//! in B of a Saltelli design, and for pairs of parameters in a replicate of a sequence.
//!
//! ```text
//! largest correlation of two parameters in a replicate of    64         256         1024        4096 points
//!   sobol / halton    8 parameters                           0.4 / 0.3  0.04 / 0.1  0 / 0       0 / 0
//!                    30                                      0.8 / 0.4  0.2 / 0.2   0 / 0.1     0 / 0
//!                   120                                      1.0 / 0.5  0.8 / 0.3   0.2 / 0.1   0 / 0.1
//! ```

/// Smallest correlation that is reported.
pub(super) const LEAST: f64 = 0.1;
/// Most points that are examined: with more points, no correlation is as large.
pub(super) const EXAMINED: u64 = 8192;

/// Pairs of columns with a correlation of at least [`LEAST`] over the first `count` points, the largest first.
///
/// * `columns` - their number; `fill` - writes the coordinates of a point.
pub(super) fn related(
    count: u64,
    columns: usize,
    fill: impl Fn(u64, &mut [f64]),
    pairs: impl Iterator<Item = [usize; 2]>,
) -> Vec<([usize; 2], f64)> {
    let count = count.min(EXAMINED);
    let mut point = vec![0.0; columns];
    let mut all = vec![Vec::with_capacity(count as usize); columns];
    for index in 0..count {
        fill(index, &mut point);
        all.iter_mut().zip(&point).for_each(|(column, coordinate)| column.push(*coordinate));
    }
    for column in &mut all {
        let mean = column.iter().sum::<f64>() / count as f64;
        column.iter_mut().for_each(|value| *value -= mean);
        let norm = libm::sqrt(column.iter().map(|value| value * value).sum());
        column.iter_mut().for_each(|value| *value /= norm);
    }
    let product = |[a, b]: [usize; 2]| all[a].iter().zip(&all[b]).map(|(a, b)| a * b).sum();
    let mut found: Vec<([usize; 2], f64)> =
        pairs.map(|pair| (pair, product(pair))).filter(|(_, r): &(_, f64)| r.abs() >= LEAST).collect();
    found.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    found
}
