//! `[stop]`: what is precise enough, and where a study ends.

use crate::estimate::figures::{Figures, Method};
use crate::estimate::limits::lower_limit;

/// What `[stop]` asks for; everything that is given has to hold.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StopRule {
    /// Half of an interval at most, in the unit of its figure.
    pub half_width: Option<f64>,
    /// Half of an interval at most, as a part of the figure.
    pub relative: Option<f64>,
    /// Points at most.
    pub samples: Option<u64>,
}

/// How precise a figure is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Precision {
    /// As it is to be.
    Enough,
    /// Half of its interval is wider than what is wanted.
    Wide {
        /// Half of it.
        half: f64,
        /// At most.
        wanted: f64,
    },
    /// It would be, but for what bad runs leave open, which more points do not narrow.
    BadRuns,
    /// It has no interval.
    NoInterval,
}

/// What keeps a figure from ever becoming precise enough, as far as its rows tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hindrance {
    /// What bad runs leave open is wider by itself, and more points do not narrow it.
    BadRuns {
        /// Half of that; `None`: they leave no limit at all.
        open: Option<f64>,
        /// Half of the interval at most.
        wanted: f64,
        /// Whether it is so however the share of bad runs among so few was met: their lower limit alone leaves as much.
        is_sure: bool,
    },
    /// A part of a figure that is 0 is asked for.
    Zero,
    /// There is no figure.
    NoNumber,
}

impl StopRule {
    /// Half of an interval of this estimate at most; `None`: any.
    #[must_use]
    pub fn wanted(&self, estimate: f64) -> Option<f64> {
        let relative = self.relative.map(|relative| relative * estimate.abs());
        match (self.half_width, relative) {
            (Some(absolute), Some(relative)) => Some(absolute.min(relative)),
            (absolute, relative) => absolute.or(relative),
        }
    }

    /// How precise a figure is. Where bad runs count both ways its interval covers both, and half of it is taken.
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

    /// What keeps a figure from becoming precise enough however many points there will be, if its runs go on as they have; `None`:
    /// nothing, or it is precise enough.
    ///
    /// * `bad` - runs of its group that are; `alpha` - 1 - confidence of its interval.
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
            // a mean has no limit beside a single bad run; a quantile has one where they are few enough, and how many they are is an estimate
            let is_sure = figures.method != Method::OrderStatistics;
            return Some(Hindrance::BadRuns { open: None, wanted, is_sure });
        }
        let (low, high, statistical) = (figures.low?, figures.high?, figures.statistical?);
        let open = 0.5 * (high - low - statistical);
        // rounding is no width
        let is_open = bad > 0 && open >= wanted && open > 1e-9 * statistical;
        // what stays with ever more points: the two figures, of as few bad runs as their share may be
        let apart = figures.harmful.map_or(0.0, |harmful| 0.5 * (harmful - estimate).abs());
        let bad = bad.min(figures.n);
        let least = apart * lower_limit(bad, figures.n, 0.5 * alpha) * figures.n as f64 / bad.max(1) as f64;
        is_open.then_some(Hindrance::BadRuns { open: Some(open), wanted, is_sure: least >= wanted })
    }

    /// Whether all of these are precise enough; nothing is not.
    #[must_use]
    pub fn is_enough(&self, figures: &[Figures]) -> bool {
        !figures.is_empty() && figures.iter().all(|one| self.precision(one) == Precision::Enough)
    }

    /// Whether any width is asked for; without one a study ends at its last look.
    #[must_use]
    pub fn asks_for_width(&self) -> bool {
        self.half_width.is_some() || self.relative.is_some()
    }

    /// Points at which a design of so many ends at the latest.
    #[must_use]
    pub fn end(&self, points: u64) -> u64 {
        self.samples.map_or(points, |samples| samples.min(points))
    }
}
