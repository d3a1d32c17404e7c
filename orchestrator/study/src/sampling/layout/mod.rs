//! Points of a `[design]`: a pure function of (seed, index), so that each point can be computed alone, in any order.
//!
//! ```text
//! point `index` = R j + r: point j of replicate r of R                  monte-carlo and one-at-a-time: R = 1
//! column `replicate` = r, column `block` = j; one-at-a-time: see steps.rs
//! morris, saltelli: points in blocks that are useful only as a whole, R = 1: see morris.rs, saltelli.rs
//! ```
//! More samples, or more parameters after the others (except for morris and saltelli), change no coordinate. Replicates are interleaved, so
//! that the first points of all replicates are computed first; another number of replicates is another design, though each replicate stays
//! the same.
//!
//! A block is the smallest set of points that is useful only as a whole: one point of each replicate. A replicate of a Latin hypercube or
//! of Sobol's sequence has its properties only at powers of two; other numbers of points have no interval ([`SamplingLayout::standing`]),
//! and no limit cuts there ([`SamplingLayout::limited`]).

mod def;
mod mistakes;
mod morris;
mod related;
mod saltelli;
mod steps;

pub use def::{
    Base, FEWEST_REPLICATES, LEVELS, LayoutDef, LayoutError, LayoutKind, MOST_LEVELS, MOST_PARAMETERS, MOST_POINTS,
    MOST_QUANTILES, MOST_REPLICATES,
};
pub use morris::{Move, Trajectories};
pub use saltelli::{Role, Saltelli};
pub use steps::Steps;

use crate::correlation::Copula;
use crate::sampling::sequence::halton::{self, Scramble};
use crate::sampling::sequence::hypercube::Hypercube;
use crate::sampling::sequence::random::Source;
use crate::sampling::sequence::sobol::{Sobol, keys};
use crate::uncertain::Uncertain;
use related::{LEAST, related};

/// The points of a design.
#[derive(Debug, Clone)]
pub struct SamplingLayout {
    kind: LayoutKind,
    samples: u64,
    replicates: u64,
    points: Points,
}

#[derive(Debug, Clone)]
enum Points {
    MonteCarlo(Source),
    Hypercubes(Vec<Hypercube>),
    /// Scrambling keys of each replicate; empty: not scrambled.
    Sobol(Sobol, Vec<Vec<u64>>),
    /// Primes of the parameters, and scrambling of each replicate; empty: not scrambled.
    Halton(Vec<u64>, Vec<Vec<Scramble>>),
    Steps(Steps),
    Trajectories(Trajectories),
    Saltelli(Saltelli),
}

/// Basis for a confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Independent points: exact methods.
    Independent,
    /// This number of independent replicates.
    Replicates(u64),
    /// No interval is possible, for this reason.
    NoInterval(&'static str),
}

impl SamplingLayout {
    /// The points of a design with these parameters.
    ///
    /// # Errors
    /// All mistakes.
    pub fn new(
        def: &LayoutDef,
        seed: u64,
        names: &[String],
        laws: &[Uncertain],
        copula: &Copula,
    ) -> Result<Self, Vec<LayoutError>> {
        let mut errors = mistakes::mistakes(def, laws.len());
        if !(1..=MOST_PARAMETERS).contains(&laws.len()) {
            errors.push(LayoutError::Parameters { given: laws.len() });
        }
        let plain = def.scramble == Some(false)
            && matches!(def.kind, LayoutKind::Sobol | LayoutKind::Halton | LayoutKind::Saltelli);
        if plain {
            let endless = names.iter().zip(laws).filter(|(_, law)| !law.ends()[0].is_finite());
            errors.extend(endless.map(|(name, _)| LayoutError::Unbounded { name: name.clone() }));
            if !copula.is_independent() && !def.kind.moves_one_parameter() {
                errors.push(LayoutError::UnboundedByCorrelation);
            }
        }
        if def.kind.moves_one_parameter() && !copula.is_independent() {
            errors.push(LayoutError::Correlated { kind: def.kind });
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let (kind, dimensions) = (def.kind, laws.len());
        let samples = if kind == LayoutKind::Morris { def.trajectories } else { def.samples }.unwrap_or(1);
        let replicates = def.replicates.unwrap_or(1);
        let sources = (0..replicates).map(|replicate| Source::new(seed, kind.word(), replicate));
        let scrambling = |wanted: bool| -> Vec<Vec<u64>> {
            sources.clone().filter(|_| wanted).map(|source| keys(&source, dimensions)).collect()
        };
        let points = match kind {
            LayoutKind::MonteCarlo => Points::MonteCarlo(Source::new(seed, kind.word(), 0)),
            LayoutKind::LatinHypercube => {
                Points::Hypercubes(sources.map(|source| Hypercube::new(&source, dimensions, samples)).collect())
            }
            LayoutKind::Sobol => Points::Sobol(Sobol::new(dimensions), scrambling(!plain)),
            LayoutKind::Halton => {
                let primes = halton::primes(dimensions);
                let of =
                    |keys: Vec<u64>| primes.iter().zip(keys).map(|(&prime, key)| Scramble::new(prime, key)).collect();
                let scrambles = scrambling(!plain).into_iter().map(of).collect();
                Points::Halton(primes, scrambles)
            }
            LayoutKind::OneAtATime => Points::Steps(Steps::new(def, names, laws)?),
            LayoutKind::Morris => {
                let source = Source::new(seed, kind.word(), 0);
                Points::Trajectories(Trajectories::new(source, def.levels.unwrap_or(LEVELS), laws))
            }
            LayoutKind::Saltelli => {
                let scrambling = (!plain).then(|| keys(&Source::new(seed, kind.word(), 0), 2 * dimensions));
                Points::Saltelli(Saltelli::new(dimensions, scrambling, def.second_order.unwrap_or(false)))
            }
        };
        Ok(Self { kind, samples, replicates, points })
    }

    /// Placement of the points.
    #[must_use]
    pub fn kind(&self) -> LayoutKind {
        self.kind
    }

    /// Whether the points are random, for kinds that can also be deterministic.
    #[must_use]
    pub fn is_scrambled(&self) -> bool {
        match &self.points {
            Points::Sobol(_, keys) => !keys.is_empty(),
            Points::Halton(_, scrambles) => !scrambles.is_empty(),
            Points::Saltelli(saltelli) => saltelli.is_scrambled(),
            _ => true,
        }
    }

    /// Number of replicates.
    #[must_use]
    pub fn replicates(&self) -> u64 {
        self.replicates
    }

    /// Number of points.
    #[must_use]
    pub fn count(&self) -> u64 {
        match &self.points {
            Points::Steps(steps) => steps.count(),
            _ => self.samples * self.rows(),
        }
    }

    /// Number of points of a block; 1 for a one-at-a-time design, whose blocks differ.
    #[must_use]
    pub fn rows(&self) -> u64 {
        match &self.points {
            Points::Trajectories(trajectories) => trajectories.rows(),
            Points::Saltelli(saltelli) => saltelli.rows(),
            _ => self.replicates,
        }
    }

    /// Keeps a fraction `factor` (0 .. 1] of the points of each replicate, from the first on, at least one: a power of two where the kind needs
    /// one. A one-at-a-time design stays whole.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        let wanted = (libm::round(self.samples as f64 * factor) as u64).clamp(1, self.samples);
        self.samples = if self.kind.needs_powers_of_two() { 1 << wanted.ilog2() } else { wanted };
        self
    }

    /// Number of points within the first `limit` that form whole blocks; at least the first block. A replicate of a Latin hypercube or of Sobol's
    /// sequence is cut at a power of two, because no interval can be computed otherwise.
    #[must_use]
    pub fn limited(&self, limit: u64) -> u64 {
        let limit = limit.clamp(1, self.count());
        match &self.points {
            Points::Steps(steps) => {
                let next = |index: u64| index < steps.count() && steps.block(index) == steps.block(index - 1);
                (1..=limit).rev().find(|&index| !next(index)).unwrap_or(1)
            }
            _ if limit == self.count() => limit,
            _ => self.whole(limit).max(self.rows()),
        }
    }

    /// The replicate of a point.
    #[must_use]
    pub fn replicate(&self, index: u64) -> u64 {
        index % self.replicates
    }

    /// The block of a point.
    #[must_use]
    pub fn block(&self, index: u64) -> u64 {
        match &self.points {
            Points::Steps(steps) => steps.block(index),
            _ => index / self.rows(),
        }
    }

    /// The largest number of points, at most `count` from the first on, whose shape allows an interval.
    #[must_use]
    pub fn whole(&self, count: u64) -> u64 {
        let each = count / self.rows();
        match self.kind {
            LayoutKind::OneAtATime | LayoutKind::MonteCarlo => count,
            LayoutKind::LatinHypercube | LayoutKind::Sobol => {
                each.checked_ilog2().map_or(0, |power| self.replicates << power)
            }
            LayoutKind::Halton | LayoutKind::Morris | LayoutKind::Saltelli => each * self.rows(),
        }
    }

    /// Basis for an interval from the first `count` points.
    #[must_use]
    pub fn standing(&self, count: u64) -> Standing {
        match self.kind {
            LayoutKind::MonteCarlo => Standing::Independent,
            LayoutKind::OneAtATime => Standing::NoInterval("points of a one-at-a-time design are not random"),
            LayoutKind::Morris => {
                Standing::NoInterval("points of a morris design are not a sample of the distributions")
            }
            LayoutKind::Saltelli => Standing::NoInterval("points of a saltelli design depend on one another"),
            _ if !self.is_scrambled() => Standing::NoInterval("points that are not scrambled are not random"),
            _ if self.replicates < FEWEST_REPLICATES => Standing::NoInterval("fewer than 16 replicates"),
            _ if count == 0 || !count.is_multiple_of(self.replicates) => {
                Standing::NoInterval("replicates of different sizes")
            }
            _ if self.whole(count) != count => Standing::NoInterval("replicates of a size that is no power of two"),
            _ => Standing::Replicates(self.replicates),
        }
    }

    /// The reason why the first `count` points have no interval, in words.
    #[must_use]
    pub fn without_interval(&self, count: u64) -> Option<String> {
        let Standing::NoInterval(reason) = self.standing(count) else { return None };
        Some(match reason {
            "fewer than 16 replicates" => {
                let s = if self.replicates == 1 { "" } else { "s" };
                format!("answers have no interval: {} replicate{s}, {FEWEST_REPLICATES} are needed", self.replicates)
            }
            // the interval of a sensitivity is a bootstrap of the blocks
            reason if matches!(self.kind, LayoutKind::Saltelli | LayoutKind::Morris) => {
                format!("answers other than sensitivities have no interval: {reason}")
            }
            reason => format!("answers have no interval: {reason}"),
        })
    }

    /// Notes of `check` about the design.
    #[must_use]
    pub fn notes(&self, copula: &Copula) -> Vec<String> {
        let mut notes: Vec<String> = self.without_interval(self.count()).into_iter().collect();
        let sequence = matches!(self.kind, LayoutKind::Sobol | LayoutKind::Halton | LayoutKind::Saltelli);
        if (sequence || self.kind == LayoutKind::LatinHypercube) && !copula.is_independent() {
            notes.push(
                "of correlated parameters only the first of each group keeps the even spread of the design".to_owned(),
            );
        }
        notes
    }

    /// The steps of a one-at-a-time design.
    #[must_use]
    pub fn steps(&self) -> Option<&Steps> {
        match &self.points {
            Points::Steps(steps) => Some(steps),
            _ => None,
        }
    }

    /// The trajectories of a Morris design: the parameter that each point changes, and the size of the change.
    #[must_use]
    pub fn trajectories(&self) -> Option<&Trajectories> {
        match &self.points {
            Points::Trajectories(trajectories) => Some(trajectories),
            _ => None,
        }
    }

    /// The layout of a Saltelli design: the relation of each point to its base point.
    #[must_use]
    pub fn saltelli(&self) -> Option<&Saltelli> {
        match &self.points {
            Points::Saltelli(saltelli) => Some(saltelli),
            _ => None,
        }
    }

    /// Warning if the first `count` points of a sequence are too few for this number of parameters. For a Saltelli design, it lists every
    /// parameter whose values in A and in B are correlated, the largest correlation first; for a replicate, the pair of parameters with the
    /// largest correlation.
    #[must_use]
    pub fn related(&self, count: u64, names: &[&str]) -> Option<String> {
        if matches!(self.kind, LayoutKind::Sobol | LayoutKind::Halton) {
            return self.related_in_replicate(count / self.replicates, names);
        }
        let base = count / self.rows();
        let found = self.saltelli()?.related(base);
        let each = found.iter().filter_map(|&(parameter, r)| Some(format!("{} {r:.2}", names.get(parameter)?)));
        let each = each.collect::<Vec<_>>().join(", ");
        (!each.is_empty()).then(|| {
            format!(
                "{base} base points are few for {} parameters: values of the same parameter in A and in B are \
                 correlated, {each}. A total index is biased by a factor of about 1 - correlation (too high if the \
                 correlation is negative), and its interval does not cover this bias. More base points help",
                names.len()
            )
        })
    }

    /// Warning about the first points of the first replicate.
    fn related_in_replicate(&self, points: u64, names: &[&str]) -> Option<String> {
        let d = names.len();
        let fill = |j: u64, point: &mut [f64]| self.fill(j * self.replicates, point);
        let pairs = (0..d).flat_map(|a| (a + 1..d).map(move |b| [a, b]));
        let found = related(points, d, fill, pairs);
        let &([a, b], r) = found.first()?;
        let (count, pairs) = (found.len(), d * (d - 1) / 2);
        Some(format!(
            "{points} points of a replicate are few for {d} parameters. The values of {} and {} have correlation \
             {r:.2}, and {count} of {pairs} pairs have one above {LEAST} or below -{LEAST}. Intervals are wider than \
             such points allow. More `samples` help, more `replicates` do not",
            names[a], names[b]
        ))
    }

    /// The coordinates of point `index` < count, for every kind except one-at-a-time (whose `point` is left unchanged).
    pub fn fill(&self, index: u64, point: &mut [f64]) {
        let (j, r) = (index / self.replicates, (index % self.replicates) as usize);
        match &self.points {
            Points::MonteCarlo(source) => source.fill(index, point),
            Points::Hypercubes(cubes) => cubes[r].fill(j, point),
            Points::Sobol(sobol, keys) => match keys.get(r) {
                Some(keys) => sobol.scrambled(j, keys, point),
                None => sobol.plain(j, point),
            },
            Points::Halton(primes, scrambles) => match scrambles.get(r) {
                Some(scrambles) => {
                    point.iter_mut().zip(scrambles).for_each(|(coordinate, one)| *coordinate = one.coordinate(j));
                }
                None => {
                    point.iter_mut().zip(primes).for_each(|(coordinate, &prime)| *coordinate = halton::plain(j, prime))
                }
            },
            Points::Trajectories(trajectories) => trajectories.fill(index, point),
            Points::Saltelli(saltelli) => saltelli.fill(index, point),
            Points::Steps(_) => {}
        }
    }
}
