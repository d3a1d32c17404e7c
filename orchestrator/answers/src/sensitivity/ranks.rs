//! Ranks (midranks for equal values) and their correlation.
//!
//! ```text
//! rank of a value = number of smaller values + (number of equal values + 1)/2;   Spearman's rho = correlation of the ranks
//! ```
//! Source: C. Spearman, "The proof and measurement of association between two things" (1904).
//! Verified by `tests/sensitivity`: SciPy, sums of normal numbers; coverage of 95 % intervals 94 to 96 %.

/// Values with their sort order, so that ranks of any subset need no further sorting.
pub(super) struct Ordered<'a> {
    values: &'a [f64],
    order: Vec<u32>,
}

impl<'a> Ordered<'a> {
    /// Sorts finite values; equal values keep their order.
    pub(super) fn new(values: &'a [f64]) -> Self {
        let mut order: Vec<u32> = (0..values.len() as u32).collect();
        order.sort_by(|&a, &b| values[a as usize].total_cmp(&values[b as usize]));
        Self { values, order }
    }

    /// Row indices in ascending order of values.
    pub(super) fn order(&self) -> impl Iterator<Item = usize> + '_ {
        self.order.iter().map(|&row| row as usize)
    }

    /// Whether all values are equal.
    pub(super) fn is_constant(&self) -> bool {
        let value = |row: Option<&u32>| row.map(|&row| self.values[row as usize]);
        value(self.order.first()) == value(self.order.last())
    }

    /// Ranks among the kept rows minus their mean; 0 for other rows, which therefore drop out of sums of products.
    pub(super) fn centred(&self, keep: impl Fn(usize) -> bool) -> Vec<f64> {
        let kept: Vec<usize> = self.order().filter(|row| keep(*row)).collect();
        let middle = 0.5 * (kept.len() as f64 + 1.0);
        let mut ranks = vec![0.0; self.values.len()];
        let mut from = 0;
        while from < kept.len() {
            let value = self.values[kept[from]];
            let equal = kept[from..].iter().take_while(|row| self.values[**row] == value).count();
            let rank = from as f64 + 0.5 * (equal as f64 + 1.0) - middle;
            kept[from..from + equal].iter().for_each(|row| ranks[*row] = rank);
            from += equal;
        }
        ranks
    }
}

/// Deviations from the mean. The first value is subtracted beforehand, because the mean of large, nearly equal values loses digits.
pub(super) fn from_mean(values: &[f64]) -> Vec<f64> {
    let Some(&first) = values.first() else { return Vec::new() };
    let mean = values.iter().map(|value| value - first).sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value - first) - mean).collect()
}

/// Sum of products.
pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Midranks, from 1.
#[must_use]
pub fn midranks(values: &[f64]) -> Vec<f64> {
    let middle = 0.5 * (values.len() as f64 + 1.0);
    Ordered::new(values).centred(|_| true).into_iter().map(|rank| rank + middle).collect()
}

/// Rank correlation; `None` if one of the columns does not vary.
#[must_use]
pub fn spearman(x: &[f64], y: &[f64]) -> Option<f64> {
    let (x, y) = (Ordered::new(x).centred(|_| true), Ordered::new(y).centred(|_| true));
    let found = product(&x, &y) / libm::sqrt(product(&x, &x) * product(&y, &y));
    found.is_finite().then_some(found)
}
