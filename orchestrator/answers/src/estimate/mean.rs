//! A mean, by Student's t: of independent values, or of replicates.
//!
//! A run that is bad has no value, and may have had any, small or large. The estimate is the mean of the others; harmful, the mean has no
//! value; and neither limit exists: the mean of the others says nothing of those that are not there.

use super::figures::{Figures, Method, Sum, finite, ratio};
use super::known::Values;
use super::scheme::Scheme;
use bladeoff_model::probability::student;

/// Mean and half width.
fn interval(
    values: &[f64],
    points: &[u32],
    scheme: &Scheme,
    part: impl Fn(usize) -> usize,
    alpha: f64,
) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = Sum::of(values.iter().copied()) / n;
    let half = match scheme {
        Scheme::Without(_) => None,
        Scheme::Independent if values.len() < 2 => None,
        Scheme::Independent => {
            let squares = Sum::of(values.iter().map(|value| (value - mean) * (value - mean)));
            Some(student(n - 1.0, alpha) * libm::sqrt(squares / (n * (n - 1.0))))
        }
        Scheme::Replicated(parts) => {
            let mut sums = vec![(Sum::default(), 0.0); *parts];
            for (value, &point) in values.iter().zip(points) {
                let sum = &mut sums[part(point as usize)];
                // about the mean: sums of large values would lose what they differ by
                sum.0.add(value - mean);
                sum.1 += 1.0;
            }
            let sums: Vec<_> = sums.into_iter().map(|(sum, count)| (sum.value(), count)).collect();
            ratio(&sums, scheme.t(alpha)).map(|(_, half)| half)
        }
    };
    (mean, half)
}

/// The mean; `part`: that of a point.
#[must_use]
pub fn mean(values: &Values, scheme: &Scheme, part: impl Fn(usize) -> usize, alpha: f64) -> Figures {
    let mut found = Figures::over(values.low.len() as u64);
    let bounded = |ends: &[f64]| ends.iter().all(|end| end.is_finite());
    let (below, above) = (bounded(&values.low), bounded(&values.high));
    if let Scheme::Without(why) = scheme {
        found.notes.push(why.clone());
    } else {
        found.method = if *scheme == Scheme::Independent { Method::Student } else { Method::Replicates };
        found.approximate = true;
    }
    // by end: the rest alone where an end is not bounded
    let of_end = |ends: &[f64], all: bool| {
        let kept = |at: &usize| all || (values.low[*at].is_finite() && values.high[*at].is_finite());
        let rows: Vec<usize> = (0..ends.len()).filter(kept).collect();
        let numbers: Vec<f64> = rows.iter().map(|&row| ends[row]).collect();
        let points: Vec<u32> = rows.iter().map(|&row| values.point[row]).collect();
        (!numbers.is_empty()).then(|| interval(&numbers, &points, scheme, &part, alpha))
    };
    let low = of_end(&values.low, below);
    if let Some((mean, half)) = low {
        found.estimate = finite(mean);
        found.statistical = half.map(|half| 2.0 * half);
        if below {
            found.low = half.and_then(|half| finite(mean - half));
        }
    } else {
        found.notes.push("no run has a value".to_owned());
    }
    if above && let Some((mean, half)) = of_end(&values.high, true) {
        found.harmful = finite(mean);
        found.high = half.and_then(|half| finite(mean + half));
    }
    if !(below && above) {
        found
            .notes
            .push("bad runs may have had any value: no limits; the estimate is that of the other runs".to_owned());
    }
    if found.low.is_none() && found.high.is_none() {
        found.method = Method::Without;
        found.approximate = false;
    }
    if values.low.len() == 1 {
        found.notes.push("one value has no interval".to_owned());
    }
    found
}
