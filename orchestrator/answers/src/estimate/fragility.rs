//! Probability of a condition as a function of a parameter.
//!
//! * Varied parameter: one probability for each value, over all points.
//! * Uncertain parameter with words, or with few values that recur: one probability for each value; words in the order of their list.
//! * Other uncertain parameters: bins of equal count by rank, as many as have `FEWEST_IN_BIN` points each, at most `MOST_BINS`.
//!
//! The points of a bin are as independent as those of the study. Each bin therefore has the interval of a probability, at its own level:
//! the probability averaged over the bin.
//!
//! Limits are conservative where the probability varies within a bin: such counts scatter less than binomial ones
//! (W. Hoeffding, 1956).

use super::input::{Cells, InputError, Label, Study};
use std::collections::BTreeMap;

/// Smallest number of points of a bin, and largest number of bins.
const FEWEST_IN_BIN: usize = 50;
const MOST_BINS: usize = 20;

/// A bin of an uncertain parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Bin {
    /// Smallest and largest value in the bin.
    pub range: (Label, Label),
    /// Indices of its points, ascending.
    pub points: Vec<u32>,
}

/// Bins of an uncertain parameter, and whether each bin is a single value. Every group has the same points.
///
/// # Errors
/// The study has no such column.
pub fn bins(study: &Study<'_>, path: &str) -> Result<(Vec<Bin>, bool), InputError> {
    let points = study.points();
    match study.column(path)?.cells {
        Cells::Words(words, list) => {
            let bin = |word: &str| {
                let label = Label::Word(word.to_owned());
                Bin { range: (label.clone(), label), points: Vec::new() }
            };
            // every word of the list, including words that were never drawn
            let mut bins: Vec<Bin> = list.iter().map(|word| bin(word)).collect();
            let mut places: BTreeMap<&str, usize> = list.iter().map(String::as_str).zip(0..).collect();
            for point in 0..points {
                // a point without a word is a value of its own
                let word = words[study.row(point, 0)].as_deref().unwrap_or("");
                let place = *places.entry(word).or_insert_with(|| {
                    bins.push(bin(word));
                    bins.len() - 1
                });
                bins[place].points.push(point as u32);
            }
            Ok((bins, true))
        }
        Cells::Numbers(values, _) => {
            let value = |point: u32| values[study.row(point as usize, 0)].unwrap_or(f64::NAN);
            let mut order: Vec<u32> = (0..points as u32).collect();
            order.sort_unstable_by(|&a, &b| value(a).total_cmp(&value(b)).then(a.cmp(&b)));
            let mut each: Vec<Vec<u32>> = Vec::new();
            for &point in &order {
                let known = each.len();
                match each.last_mut() {
                    Some(last) if value(last[0]).total_cmp(&value(point)).is_eq() => last.push(point),
                    _ if known > MOST_BINS => break,
                    _ => each.push(vec![point]),
                }
            }
            // if every point has its own value, values are binned however few there are
            let all_differ = points > 0 && each.len() == points;
            let single = each.len() <= MOST_BINS && !all_differ;
            if !single {
                let count = (points / FEWEST_IN_BIN).clamp(1, MOST_BINS);
                each = (0..count).map(|bin| order[bin * points / count..(bin + 1) * points / count].to_vec()).collect();
            }
            let bin = |mut points: Vec<u32>| {
                let (first, last) = (value(points[0]), value(points[points.len() - 1]));
                // read in their order in memory
                points.sort_unstable();
                Bin { range: (Label::Number(first), Label::Number(last)), points }
            };
            Ok((each.into_iter().map(bin).collect(), single))
        }
    }
}
