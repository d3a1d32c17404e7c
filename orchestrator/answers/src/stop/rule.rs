//! `[stop]`: required precision, and end of a study.

use crate::estimate::figures::{Figures, Method};
use crate::estimate::limits::lower_limit;

/// Conditions of `[stop]`; all that are given must hold.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StopRule {
    /// Largest half width of an interval, in the unit of its figure.
    pub half_width: Option<f64>,
    /// Largest half width of an interval relative to the figure.
    pub relative: Option<f64>,
    /// Largest number of points.
    pub samples: Option<u64>,
}

/// Precision of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Precision {
    /// The required precision is reached.
    Enough,
    /// The half width of the interval exceeds the required one.
    Wide {
        /// Half width.
        half: f64,
        /// Largest permitted half width.
        wanted: f64,
    },
    /// The statistical width suffices, but bad runs widen the interval; more points do not change that.
    BadRuns,
    /// The figure has no interval.
    NoInterval,
}

/// Reason why more points will not reach the required precision, as far as the rows show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hindrance {
    /// The widening of the interval by bad runs alone is too large; more points do not reduce it.
    BadRuns {
        /// Half of that widening; `None` if bad runs leave no limit at all.
        open: Option<f64>,
        /// Largest permitted half width.
        wanted: f64,
        /// Whether this is certain: even the lower confidence limit on the share of bad runs gives too large a widening.
        is_sure: bool,
    },
    /// A relative half width is required of a figure that is 0.
    Zero,
    /// There is no figure.
    NoNumber,
}

impl StopRule {
    /// Largest permitted half width for this estimate; `None` if there is no requirement.
    #[must_use]
    pub fn wanted(&self, estimate: f64) -> Option<f64> {
        let relative = self.relative.map(|relative| relative * estimate.abs());
        match (self.half_width, relative) {
            (Some(absolute), Some(relative)) => Some(absolute.min(relative)),
            (absolute, relative) => absolute.or(relative),
        }
    }

    /// Precision of a figure, by half the width of its interval. If bad runs count both ways, the interval covers both.
    #[must_use]
    pub fn precision(&self, figures: &Figures) -> Precision {
        let wanted = figures.estimate.and_then(|estimate| self.wanted(estimate));
        let (Some(_), Some(wanted)) = (figures.estimate, wanted) else { return Precision::NoInterval };
        let alone = figures.statistical.is_some_and(|width| 0.5 * width <= wanted);
        match figures.high.zip(figures.low).map(|(high, low)| 0.5 * (high - low)) {
            Some(half) if half <= wanted => Precision::Enough,
            _ if alone => Precision::BadRuns,
            Some(half) => Precision::Wide { half, wanted },
            None => Precision::NoInterval,
        }
    }

    /// Reason why a figure will not become precise enough with more points of the same kind; `None` without a reason, or if
    /// it is precise enough.
    ///
    /// * `bad` - number of bad runs in its group; `alpha` - 1 - confidence of its interval.
    #[must_use]
    pub fn hindrance(&self, figures: &Figures, bad: u64, alpha: f64) -> Option<Hindrance> {
        if self.precision(figures) == Precision::Enough {
            return None;
        }
        let Some(estimate) = figures.estimate else { return Some(Hindrance::NoNumber) };
        let wanted = self.wanted(estimate)?;
        if wanted == 0.0 {
            return Some(Hindrance::Zero);
        }
        if bad > 0 && figures.harmful.is_none() {
            // A mean has no limit with any bad run. A quantile has one if bad runs are few enough, and their share is an estimate.
            let is_sure = figures.method != Method::OrderStatistics;
            return Some(Hindrance::BadRuns { open: None, wanted, is_sure });
        }
        let (low, high, statistical) = (figures.low?, figures.high?, figures.statistical?);
        let open = 0.5 * (high - low - statistical);
        // rounding errors do not count as width
        let is_open = bad > 0 && open >= wanted && open > 1e-9 * statistical;
        // remains with more points: distance of the two figures, for the smallest likely share of bad runs
        let apart = figures.harmful.map_or(0.0, |harmful| 0.5 * (harmful - estimate).abs());
        let bad = bad.min(figures.n);
        let least = apart * lower_limit(bad, figures.n, 0.5 * alpha) * figures.n as f64 / bad.max(1) as f64;
        is_open.then_some(Hindrance::BadRuns { open: Some(open), wanted, is_sure: least >= wanted })
    }

    /// Whether all figures are precise enough; false for none.
    #[must_use]
    pub fn is_enough(&self, figures: &[Figures]) -> bool {
        !figures.is_empty() && figures.iter().all(|one| self.precision(one) == Precision::Enough)
    }

    /// Whether a width is required; otherwise a study ends at its last interim analysis.
    #[must_use]
    pub fn asks_for_width(&self) -> bool {
        self.half_width.is_some() || self.relative.is_some()
    }

    /// Largest number of points of a design with `points` points.
    #[must_use]
    pub fn end(&self, points: u64) -> u64 {
        self.samples.map_or(points, |samples| samples.min(points))
    }
}
