//! Forecast of the half width of an interval with more points, at the present rates.
//!
//! ```text
//! width(n') = open + statistical(n) sqrt(n/n')        open: widening by bad runs, which remains
//! probability with exact limits: limits with proportionally more events
//! ```
//! A forecast is not an interval: it assumes that the scatter remains the same.

use super::rule::StopRule;
use crate::estimate::figures::{Figures, Method};
use crate::estimate::limits::{lower_limit, upper_limit};

/// Half width of the interval of a figure with another number of points; `None` without an interval.
///
/// * `alpha` - 1 - confidence of the interval; `now`, `then` - points of `figures`, and of the forecast.
#[must_use]
pub fn half_width(figures: &Figures, alpha: f64, (now, then): (u64, u64)) -> Option<f64> {
    let statistical = figures.statistical?;
    let open = (figures.high? - figures.low? - statistical).max(0.0);
    let times = then as f64 / now as f64;
    let width = match (figures.method, figures.events) {
        (Method::ClopperPearson, Some(events)) => {
            let n = libm::rint(figures.n as f64 * times) as u64;
            let events = (libm::rint(events as f64 * times) as u64).min(n);
            upper_limit(events, n, 0.5 * alpha) - lower_limit(events, n, 0.5 * alpha)
        }
        _ => statistical / libm::sqrt(times),
    };
    Some(0.5 * (open + width))
}

/// Number of points of the first interim analysis at which every figure is expected to be precise enough; `None` if there is no such analysis.
///
/// * `figures` - each at `now` points, with 1 - confidence of its interval; `analyses` - points of the interim analyses.
#[must_use]
pub fn expected(rule: &StopRule, figures: &[(Figures, f64)], now: u64, analyses: &[u64]) -> Option<u64> {
    let narrow = |(one, alpha): &(Figures, f64), then: u64| {
        let wanted = one.estimate.and_then(|estimate| rule.wanted(estimate));
        wanted.zip(half_width(one, *alpha, (now, then))).is_some_and(|(wanted, half)| half <= wanted)
    };
    let mut next = analyses.iter().copied().filter(|points| *points > now);
    next.find(|points| figures.iter().all(|one| narrow(one, *points)))
}
