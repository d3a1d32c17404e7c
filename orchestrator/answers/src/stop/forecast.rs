//! What more points would narrow an interval to, at the rates that there are.
//!
//! ```text
//! width(n') = open + statistical(n) sqrt(n/n') z(alpha')/z(alpha)        open: what bad runs leave, which stays as it is
//! a probability with exact limits: those of as many events more
//! ```
//! z is the normal quantile at 1 - alpha/2. A forecast, no interval: it takes the scatter so far for that to come.

use super::look::Look;
use super::rule::StopRule;
use crate::estimate::figures::{Figures, Method};
use crate::estimate::limits::{lower_limit, upper_limit};
use bladeoff_model::probability::normal_quantile;

fn z(alpha: f64) -> f64 {
    normal_quantile(1.0 - 0.5 * alpha, 0.5 * alpha)
}

/// Half the interval of a figure at other points and another level; `None` where there is no interval.
///
/// * `figures` - at `now`.
#[must_use]
pub fn half_width(figures: &Figures, now: &Look, then: &Look) -> Option<f64> {
    let statistical = figures.statistical?;
    let open = (figures.high? - figures.low? - statistical).max(0.0);
    let times = then.points as f64 / now.points as f64;
    let width = match (figures.method, figures.events) {
        (Method::ClopperPearson, Some(events)) => {
            let n = libm::rint(figures.n as f64 * times) as u64;
            let events = (libm::rint(events as f64 * times) as u64).min(n);
            upper_limit(events, n, 0.5 * then.alpha) - lower_limit(events, n, 0.5 * then.alpha)
        }
        _ => statistical / libm::sqrt(times) * z(then.alpha) / z(now.alpha),
    };
    Some(0.5 * (open + width))
}

/// The first look at which every figure is expected to be precise enough; `None`: none of them.
#[must_use]
pub fn expected(rule: &StopRule, figures: &[Figures], now: &Look, looks: &[Look]) -> Option<Look> {
    let narrow = |one: &Figures, then: &Look| {
        let wanted = one.estimate.and_then(|estimate| rule.wanted(estimate));
        wanted.zip(half_width(one, now, then)).is_some_and(|(wanted, half)| half <= wanted)
    };
    let mut next = looks.iter().filter(|look| look.points > now.points);
    next.find(|look| figures.iter().all(|one| narrow(one, look))).copied()
}
