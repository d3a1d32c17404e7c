//! `[stop]`: what is precise enough, and where a study ends.

use super::look::Look;
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

/// A mistake in `[stop]`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StopError {
    /// No width and no number of points.
    #[error("asks for nothing; allowed: `half_width`, `relative`, `samples`, `wall`")]
    Nothing,
    /// A value that no interval has.
    #[error("`{key}` = {given}; allowed: {allowed}")]
    Value {
        /// The key.
        key: &'static str,
        /// As given.
        given: String,
        /// What is allowed.
        allowed: &'static str,
    },
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
    /// # Errors
    /// Every mistake; `has_wall`: a time is given as well, which is not of this rule.
    pub fn check(&self, has_wall: bool) -> Result<(), Vec<StopError>> {
        let mut errors = Vec::new();
        let widths = [("half_width", self.half_width), ("relative", self.relative)];
        for (key, given) in widths {
            if let Some(given) = given.filter(|given| !(*given > 0.0 && given.is_finite())) {
                errors.push(StopError::Value { key, given: given.to_string(), allowed: "above 0" });
            }
        }
        if self.samples == Some(0) {
            errors.push(StopError::Value { key: "samples", given: "0".to_owned(), allowed: "1 and more" });
        }
        if *self == Self::default() && !has_wall {
            errors.push(StopError::Nothing);
        }
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

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

/// Where a study stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Decision {
    /// Precise enough at this look, and at none before: the table ends here.
    Met(Look),
    /// At its end without being so.
    Ended(Look, Vec<Precision>),
    /// More points are needed up to the next look; what was found at the last one.
    Open {
        /// The next.
        next: Look,
        /// The last, with the precision of every figure.
        last: Option<(Look, Vec<Precision>)>,
    },
}

/// Where a study of `done` points stands: the first look that decides, in their order.
///
/// * `looks` - of [`super::looks`], up to [`StopRule::end`]; `figures` - those of every question and group at a look: of its points alone
///   and at its level.
///
/// # Errors
/// What `figures` fails with.
///
/// # Panics
/// There is no look.
pub fn decide<E>(
    rule: &StopRule,
    looks: &[Look],
    done: u64,
    mut figures: impl FnMut(&Look) -> Result<Vec<Figures>, E>,
) -> Result<Decision, E> {
    let mut last = None;
    for look in looks {
        if look.points > done {
            return Ok(Decision::Open { next: *look, last });
        }
        let found: Vec<Precision> = if rule.asks_for_width() || look.is_last {
            figures(look)?.iter().map(|one| rule.precision(one)).collect()
        } else {
            Vec::new()
        };
        let met = rule.asks_for_width() && !found.is_empty() && found.iter().all(|one| *one == Precision::Enough);
        if met {
            return Ok(Decision::Met(*look));
        }
        last = Some((*look, found));
    }
    let (look, found) = last.expect("a study has a last look");
    Ok(Decision::Ended(look, found))
}
