//! Questions answered from a stream of rows in one or several passes. Memory does not grow with the number of rows.
//!
//! ```text
//! probability    counts                                               one pass
//! mean           sums; then sums about the mean                       two
//! quantile       some of the values; then those around its ranks      two, of replicates four; one more if the first guess missed
//! exceedance     all values, for the levels; then counts              two
//! ```
//! The estimators are those for rows in memory ([`crate::estimate`]), applied in the same order: the results are identical to the byte.

use super::asked::{Answered, Asked, unanswered};
use super::question::{Ask, Figure, Question};
use super::wording::{LEFT_OUT, note_empty};
use crate::estimate::bad::Bad;
use crate::estimate::exceedance::Exceedances;
use crate::estimate::formula::Formula;
use crate::estimate::input::{InputError, Study};
use crate::estimate::known::{Values, levels_at, reached_at, truths_at, values_at};
use crate::estimate::mean::Means;
use crate::estimate::order::kept_by_each;
use crate::estimate::proportion::Tally;
use crate::estimate::quantile::Quantiles;
use crate::estimate::scheme::Scheme;
use crate::estimate::undecided::Undecided;

/// A complete table in the order of its samples.
#[derive(Debug, Clone)]
pub struct Whole<'a> {
    /// Columns, groups and design of the table, without rows.
    pub head: Study<'a>,
    /// Number of points.
    pub points: u64,
    /// Number of points of each replicate.
    pub by_replicate: Vec<u64>,
}

/// Questions in progress.
pub struct Streamed<'a> {
    whole: &'a Whole<'a>,
    scheme: Scheme,
    folds: Vec<Open<'a>>,
    is_first_pass: bool,
}

/// A question, its accumulated state, and whether it needs the rows of the current pass.
struct Open<'a> {
    asked: Asked<'a>,
    fold: Result<Fold<'a>, InputError>,
    is_open: bool,
}

/// Accumulated state of a question, by group.
enum Fold<'a> {
    Probability(&'a Figure, &'a Formula, Vec<Counted>),
    Mean(&'a Figure, &'a str, Vec<Of<Means>>),
    Quantile(&'a Figure, &'a str, Vec<Of<Quantiles>>),
    Exceedance(&'a str, Vec<Of<Exceedances>>),
}

/// Accumulated counts of a condition.
#[derive(Clone)]
struct Counted {
    tallies: Vec<Tally>,
    bad: Bad,
    empty: u64,
    undecided: Undecided,
}

/// Accumulated state of a column: estimator, bad runs, runs without a value.
#[derive(Clone)]
struct Of<T> {
    held: T,
    bad: Bad,
    empty: u64,
}

impl<T> Of<T> {
    fn new(held: T) -> Self {
        Self { held, bad: Bad::default(), empty: 0 }
    }

    /// Counts values on the first pass.
    fn count(&mut self, values: &Values, is_first: bool) {
        if is_first {
            self.bad.add(&values.bad);
            self.empty += values.empty;
        }
    }
}

impl<'a> Streamed<'a> {
    /// Whether a question can be answered from a stream of rows.
    #[must_use]
    pub fn takes(question: &Question) -> bool {
        matches!(question.ask, Ask::One(_) | Ask::Exceedance(_))
    }

    /// Starts a stream for questions that [`Streamed::takes`] accepts.
    #[must_use]
    pub fn new(whole: &'a Whole<'a>, questions: &[&'a Question]) -> Self {
        let scheme = Scheme::counted(&whole.head.design, || whole.by_replicate.clone());
        let groups = whole.head.groups.len();
        let kept = kept_by_each(groups * questions.len());
        let one = |question: &&'a Question| {
            let fold = Fold::new(&question.ask, &whole.head, &scheme, kept);
            Open { asked: Asked::of(&whole.head, question, scheme.clone()), is_open: fold.is_ok(), fold }
        };
        let folds = questions.iter().map(one).collect();
        Self { whole, scheme, folds, is_first_pass: true }
    }

    /// Processes the rows of a piece, the first of which has row number `first_row`; its design has the replicates of their points.
    pub fn see(&mut self, piece: &Study<'_>, first_row: u64) {
        let groups = piece.groups.len();
        let offset = (first_row % groups as u64) as usize;
        let part = |point: usize| self.scheme.part(&piece.design, point);
        for group in 0..groups {
            // points are counted from the first one of the piece
            let rows = |row: usize| ((row + offset) / groups, row);
            let from = (group + groups - offset) % groups;
            let rows: Vec<(usize, usize)> = (from..piece.status.len()).step_by(groups).map(rows).collect();
            for open in self.folds.iter_mut().filter(|open| open.is_open) {
                if let Ok(fold) = &mut open.fold
                    && let Err(why) = fold.see(piece, group, (&rows, self.is_first_pass), part)
                {
                    (open.fold, open.is_open) = (Err(why), false);
                }
            }
        }
    }

    /// Ends a pass. Returns whether all rows have to be read once more.
    pub fn go_on(&mut self) -> bool {
        self.is_first_pass = false;
        for open in self.folds.iter_mut().filter(|open| open.is_open) {
            open.is_open = open.fold.as_mut().is_ok_and(|fold| fold.go_on(&open.asked));
        }
        self.folds.iter().any(|open| open.is_open)
    }

    /// Answers to the questions, after the last pass.
    #[must_use]
    pub fn answers(self) -> Vec<Answered> {
        let Whole { points, by_replicate, .. } = self.whole;
        let parts = if matches!(self.scheme, Scheme::Replicated(_)) { by_replicate.clone() } else { vec![*points] };
        let one = |Open { asked, fold, .. }: Open<'_>| {
            let answered = fold.and_then(|fold| fold.answered(&asked, *points, &parts));
            match answered {
                Ok(answered) => asked.noted(answered),
                Err(why) => unanswered(*points, asked.question, &why),
            }
        };
        self.folds.into_iter().map(one).collect()
    }
}

impl<'a> Fold<'a> {
    fn new(ask: &'a Ask, head: &Study<'_>, scheme: &Scheme, kept: usize) -> Result<Self, InputError> {
        let groups = head.groups.len();
        let tallies = vec![Tally::default(); scheme.parts()];
        let counted = Counted { tallies, bad: Bad::default(), empty: 0, undecided: Undecided::default() };
        let fold = match ask {
            Ask::One(figure) => match figure {
                Figure::Probability(formula) => Self::Probability(figure, formula, vec![counted; groups]),
                Figure::Mean(column) => Self::Mean(figure, column, vec![Of::new(Means::default()); groups]),
                Figure::Quantile(u, column) => {
                    Self::Quantile(figure, column, vec![Of::new(Quantiles::keeping(*u, kept)); groups])
                }
            },
            Ask::Exceedance(column) => Self::Exceedance(column, vec![Of::new(Exceedances::default()); groups]),
            Ask::Fragility(..) | Ask::Difference(..) | Ask::Map(_) | Ask::Sensitivity(_) => {
                return Err(InputError::Method("this question needs all rows at once".to_owned()));
            }
        };
        // report missing columns before any row is read
        match &fold {
            Self::Probability(_, formula, _) => drop(truths_at(head, formula, std::iter::empty())?),
            Self::Mean(_, column, _) | Self::Quantile(_, column, _) | Self::Exceedance(column, _) => {
                head.numbers(column)?;
            }
        }
        Ok(fold)
    }

    fn see(
        &mut self,
        piece: &Study<'_>,
        group: usize,
        (rows, is_first): (&[(usize, usize)], bool),
        part: impl Fn(usize) -> usize,
    ) -> Result<(), InputError> {
        let pairs = |values: Values| {
            let points = values.point.into_iter().map(|point| point as usize);
            values.low.into_iter().zip(values.high).zip(points)
        };
        match self {
            Self::Probability(_, formula, counted) if is_first => {
                let truths = truths_at(piece, formula, rows.iter().map(|(_, row)| *row))?;
                let counted = &mut counted[group];
                counted.bad.add(&truths.bad());
                counted.empty += truths.empty;
                counted.undecided.add(&truths.undecided());
                for (truth, (point, _)) in truths.of.into_iter().zip(rows) {
                    counted.tallies[part(*point)].see(truth);
                }
            }
            Self::Probability(..) => {}
            Self::Mean(_, column, means) => {
                let values = values_at(piece, column, rows.iter().copied())?;
                means[group].count(&values, is_first);
                pairs(values).for_each(|((low, high), point)| means[group].held.see(low, high, part(point)));
            }
            Self::Quantile(_, column, quantiles) => {
                let values = levels_at(piece, column, rows.iter().copied())?;
                quantiles[group].count(&values, is_first);
                pairs(values).for_each(|((low, high), point)| quantiles[group].held.see(low, high, part(point)));
            }
            Self::Exceedance(column, curves) => {
                let values = reached_at(piece, column, rows.iter().copied())?;
                curves[group].count(&values, is_first);
                pairs(values).for_each(|((low, high), point)| curves[group].held.see(low, high, part(point)));
            }
        }
        Ok(())
    }

    fn go_on(&mut self, asked: &Asked<'_>) -> bool {
        let Asked { scheme, alpha, .. } = asked;
        match self {
            Self::Probability(..) => false,
            Self::Mean(_, _, means) => means.iter_mut().fold(false, |open, of| of.held.go_on(scheme) | open),
            Self::Quantile(_, _, all) => all.iter_mut().fold(false, |open, of| of.held.go_on(scheme, *alpha) | open),
            Self::Exceedance(_, curves) => curves.iter_mut().fold(false, |open, of| of.held.go_on(scheme) | open),
        }
    }

    fn answered(self, asked: &Asked<'_>, points: u64, parts: &[u64]) -> Result<Answered, InputError> {
        let (scheme, alpha) = (&asked.scheme, asked.alpha);
        match self {
            Self::Probability(figure, _, counted) => {
                let one = |of: Counted| (asked.of_tallies(&of.tallies, of.empty, &of.undecided), of.bad);
                asked.told_of(figure, counted.into_iter().map(one).collect())
            }
            Self::Mean(figure, _, means) => {
                let one = |of: Of<Means>| {
                    let mut figures = of.held.figures(&of.bad, scheme, alpha);
                    note_empty(&mut figures.notes, of.empty, LEFT_OUT);
                    (figures, of.bad)
                };
                asked.told_of(figure, means.into_iter().map(one).collect())
            }
            Self::Quantile(figure, _, quantiles) => {
                let one = |of: Of<Quantiles>| {
                    let mut figures = of.held.figures(of.bad, scheme, alpha);
                    note_empty(&mut figures.notes, of.empty, LEFT_OUT);
                    (figures, of.bad)
                };
                asked.told_of(figure, quantiles.into_iter().map(one).collect())
            }
            Self::Exceedance(column, curves) => {
                let one = |of: Of<Exceedances>| {
                    let (curve, method) = of.held.curve(parts, of.bad.all, scheme, alpha);
                    (curve, method, of.bad, of.empty)
                };
                asked.curves_of(column, points, curves.into_iter().map(one).collect())
            }
        }
    }
}
