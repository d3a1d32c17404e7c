//! `[stop]`: what is precise enough, and where a study ends.

use crate::estimate::figures::Figures;

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
