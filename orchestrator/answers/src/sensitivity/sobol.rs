//! Sobol indices: shares of an output's variance caused by parameters alone, by pairs, and including all interactions.
//!
//! ```text
//! first    S_i  = 1/N sum f(B) (f(AB_i) - f(A))/V                          A. Saltelli et al. (2010), table 2 (b)
//! total    T_i  = 1/(2 N) sum (f(A) - f(AB_i))^2/V                         M. J. W. Jansen (1999)
//! second   S_ij = 1/N sum (f(BA_i) f(AB_j) - f(A) f(B))/V - S_i - S_j      A. Saltelli (2002)
//! V        = variance of all f(A) and f(B) together, divided by 2 N
//! ```
//! First and second orders are products of outputs. A constant added to an output changes no index, but the scatter of these products
//! increases with the square of the mean. Therefore f is the output minus its mean over all rows of the complete base points.
//! Because of its scatter an estimate may be slightly below 0 or above 1; it is not clipped.
//! Requires independent parameters. Verified by `tests/sensitivity`: SALib on the same rows, Ishigami's and Sobol's g-function, coverage.

use super::blocks::{Blocks, counted, percent};
use super::indices::{Index, Indices, OfParameter, Pair, SensitivityError};
use super::resample::{Sums, told};

/// Mean and standard deviation of f(A) and f(B).
fn moments(blocks: &Blocks, values: &[Option<f64>], rows: usize) -> (f64, f64) {
    let both =
        || blocks.whole.iter().flat_map(|block| [values[block * rows], values[(block + 1) * rows - 1]]).flatten();
    let n = 2.0 * blocks.whole.len() as f64;
    let mean = both().sum::<f64>() / n;
    (mean, libm::sqrt(both().map(|y| (y - mean) * (y - mean)).sum::<f64>() / n))
}

/// Mean over all rows of the complete base points.
fn mean_of_all(blocks: &Blocks, values: &[Option<f64>], rows: usize) -> f64 {
    let block = |block: &usize| values[block * rows..(block + 1) * rows].iter().flatten().sum::<f64>();
    blocks.whole.iter().map(block).sum::<f64>() / (blocks.whole.len() * rows) as f64
}

/// Share of a single base point in the variance above which the output counts as heavy-tailed; and the same relative to the number of base
/// points, because with few points one has a large share in any case.
const HEAVY: (f64, f64) = (0.2, 5.0);

/// Note if a single base point contributes so much of the variance that intervals cover less often than stated. Measured by
/// `coverage_of_heavy_tails` of `tests/sensitivity`; bootstrap-t and bias-corrected limits of the same sums covered less often.
fn heavy(blocks: &Blocks, values: &[Option<f64>], rows: usize, mean: f64) -> Option<String> {
    let square = |at: usize| values[at].map_or(0.0, |y| (y - mean) * (y - mean));
    let of = blocks.whole.iter().map(|block| square(block * rows) + square((block + 1) * rows - 1));
    let (most, sum) = of.fold((0.0_f64, 0.0), |(most, sum), one| (most.max(one), sum + one));
    let (share, count) = (most / sum, blocks.whole.len());
    (share > HEAVY.0.max(HEAVY.1 / count as f64)).then(|| {
        format!(
            "a single run of {} makes up {} of the variance: with such tails, 95 % intervals of indices held in 72 to \
             94 of 100 studies, not in 95",
            counted(count, "base points"),
            percent(share)
        )
    })
}

/// Smallest and largest of f(A) and f(B).
fn ends(blocks: &Blocks, values: &[Option<f64>], rows: usize) -> (f64, f64) {
    let both = blocks.whole.iter().flat_map(|block| [values[block * rows], values[(block + 1) * rows - 1]]).flatten();
    both.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), y| (least.min(y), most.max(y)))
}

/// First-order, total and second-order indices.
///
/// * `names` - of the d parameters; `values` - of all rows, base point by base point: A, AB_1 .. AB_d, [BA_1 .. BA_d], B, `None` without
///   a number; `second_order`: rows BA_1 .. BA_d exist; `alpha` - 1 - confidence.
///
/// # Errors
/// There is no parameter.
pub fn sobol(
    names: &[String],
    values: &[Option<f64>],
    second_order: bool,
    alpha: f64,
) -> Result<Indices, SensitivityError> {
    let d = names.len();
    if d == 0 {
        return Err(SensitivityError::Parameters);
    }
    let rows = 2 + if second_order { 2 * d } else { d };
    let blocks = Blocks::new(values, rows);
    let count = blocks.whole.len();
    let mut notes = Vec::new();
    blocks.told("base points", &mut notes);
    let pairs: Vec<(usize, usize)> =
        (0..d).flat_map(|i| (i + 1..d).map(move |j| (i, j))).filter(|_| second_order).collect();
    let (mean, deviation) = moments(&blocks, values, rows);
    // rounding errors of a constant are not variance
    let varies = count > 0 && deviation > 1e-13 * mean.abs();
    let mut without = None;
    let found = if varies {
        let centre = mean_of_all(&blocks, values, rows);
        let at = |block: usize, row: usize| values[block * rows + row].unwrap_or(f64::NAN) - centre;
        // sums of 1, f(A) + f(B) and squares about the mean; first and total of each parameter; pairs
        let sums = Sums::new(count, 3 + 2 * d + pairs.len(), |number, sums| {
            let block = blocks.whole[number];
            let (a, b) = (at(block, 0), at(block, rows - 1));
            let (low, high) = (a + centre - mean, b + centre - mean);
            sums[..3].copy_from_slice(&[1.0, low + high, low * low + high * high]);
            for i in 0..d {
                let ab = at(block, 1 + i);
                sums[3 + 2 * i] = b * (ab - a);
                sums[4 + 2 * i] = 0.5 * (a - ab) * (a - ab);
            }
            for (sum, &(i, j)) in sums[3 + 2 * d..].iter_mut().zip(&pairs) {
                *sum = at(block, 1 + d + i) * at(block, 1 + j) - a * b;
            }
        });
        let figures = |sums: &[f64]| {
            let n = sums[0];
            let shift = sums[1] / (2.0 * n);
            let scale = n * (sums[2] / (2.0 * n) - shift * shift);
            let mut found: Vec<f64> = sums[3..3 + 2 * d].iter().map(|sum| sum / scale).collect();
            for (number, &(i, j)) in pairs.iter().enumerate() {
                found.push(sums[3 + 2 * d + number] / scale - found[2 * i] - found[2 * j]);
            }
            found
        };
        sums.indices(count, alpha, figures)
    } else {
        let (least, most) = ends(&blocks, values, rows);
        let why = match count {
            0 => "no base point is whole",
            _ if least < most => "the output varies less than the rounding error of its mean",
            _ => "the output does not vary",
        };
        without = Some(why);
        notes.push(match count {
            0 => why.to_owned(),
            _ if least < most => format!("{why}: subtract the constant from the output"),
            _ => format!("{why}: it has no variance to share"),
        });
        vec![Index::default(); 2 * d + pairs.len()]
    };
    let interval = if varies { told(count, alpha, "base points", &mut notes) } else { "none" };
    if interval != "none" {
        notes.extend(heavy(&blocks, values, rows, mean));
    }
    let of = |(i, name): (usize, &String)| {
        let (first, total) = (Some(found[2 * i]), Some(found[2 * i + 1]));
        (name.clone(), OfParameter { first, total, ..OfParameter::default() })
    };
    let second = |(number, &(i, j)): (usize, &(usize, usize))| Pair {
        between: [names[i].clone(), names[j].clone()],
        second: found[2 * d + number],
    };
    Ok(Indices {
        of: names.iter().enumerate().map(of).collect(),
        pairs: pairs.iter().enumerate().map(second).collect(),
        r2: None,
        interval,
        n: count as u64,
        left_out: blocks.left_out() as u64,
        without,
        notes,
    })
}
