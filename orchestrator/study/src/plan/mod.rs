//! Where the points of `[design]` lie: a pure function of (seed, index), so that each is made alone, in any order.
//!
//! ```text
//! point `index` = R j + r: point j of replicate r of R                  monte-carlo and one-at-a-time: R = 1
//! column `replicate` = r, column `block` = j; one-at-a-time: see steps.rs
//! ```
//! More samples, or more parameters behind the others, move no coordinate. Replicates are interleaved, so that the first points of
//! all are done first; another number of replicates is another design, though each replicate stays what it is.
//!
//! A block is the smallest set of points that is of use only as a whole: a point of each replicate. A replicate of a hypercube or of
//! Sobol's sequence is what it should be at powers of two only; between them there is no interval ([`Plan::standing`]).

mod def;
mod steps;

pub use def::{
    Base, FEWEST_REPLICATES, Kind, MOST_PARAMETERS, MOST_POINTS, MOST_QUANTILES, MOST_REPLICATES, PlanDef, PlanError,
};
pub use steps::Steps;

use crate::correlation::Copula;
use crate::design::halton;
use crate::design::hypercube::Hypercube;
use crate::design::random::Source;
use crate::design::sobol::{Sobol, keys};
use crate::uncertain::Uncertain;

/// From here on the pairs of dimensions of a sequence are no longer spread well.
const MANY_PARAMETERS: usize = 50;

/// The points of a design.
#[derive(Debug, Clone)]
pub struct Plan {
    kind: Kind,
    samples: u64,
    replicates: u64,
    points: Points,
}

#[derive(Debug, Clone)]
enum Points {
    MonteCarlo(Source),
    Hypercubes(Vec<Hypercube>),
    /// Keys of the scrambling of each replicate; none: as the sequence stands.
    Sobol(Sobol, Vec<Vec<u64>>),
    /// The primes of the parameters, and keys likewise.
    Halton(Vec<u64>, Vec<Vec<u64>>),
    Steps(Steps),
}

/// What an interval may be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Independent points: exact methods.
    Independent,
    /// So many independent replicates.
    Replicates(u64),
    /// Nothing, for this reason.
    NoInterval(&'static str),
}

impl Plan {
    /// The points of a design of these parameters.
    ///
    /// # Errors
    /// Every mistake.
    pub fn new(
        def: &PlanDef,
        seed: u64,
        names: &[String],
        laws: &[Uncertain],
        copula: &Copula,
    ) -> Result<Self, Vec<PlanError>> {
        let mut errors = def::mistakes(def);
        if !(1..=MOST_PARAMETERS).contains(&laws.len()) {
            errors.push(PlanError::Parameters { given: laws.len() });
        }
        let plain = def.scramble == Some(false) && matches!(def.kind, Kind::Sobol | Kind::Halton);
        if plain {
            let endless = names.iter().zip(laws).filter(|(_, law)| !law.ends()[0].is_finite());
            errors.extend(endless.map(|(name, _)| PlanError::Unbounded { name: name.clone() }));
            if !copula.is_independent() {
                errors.push(PlanError::UnboundedByCorrelation);
            }
        }
        if def.kind == Kind::OneAtATime && !copula.is_independent() {
            errors.push(PlanError::Correlated);
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let (kind, dimensions) = (def.kind, laws.len());
        let (samples, replicates) = (def.samples.unwrap_or(1), def.replicates.unwrap_or(1));
        let sources = (0..replicates).map(|replicate| Source::new(seed, kind.word(), replicate));
        let scrambling =
            |wanted: bool| sources.clone().filter(|_| wanted).map(|source| keys(&source, dimensions)).collect();
        let points = match kind {
            Kind::MonteCarlo => Points::MonteCarlo(Source::new(seed, kind.word(), 0)),
            Kind::LatinHypercube => {
                Points::Hypercubes(sources.map(|source| Hypercube::new(&source, dimensions, samples)).collect())
            }
            Kind::Sobol => Points::Sobol(Sobol::new(dimensions), scrambling(!plain)),
            Kind::Halton => Points::Halton(halton::primes(dimensions), scrambling(!plain)),
            Kind::OneAtATime => Points::Steps(Steps::new(def, names, laws)?),
        };
        Ok(Self { kind, samples, replicates, points })
    }

    /// How points are placed.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Whether its points are random where the kind has a plain form.
    #[must_use]
    pub fn is_scrambled(&self) -> bool {
        !matches!(&self.points, Points::Sobol(_, keys) | Points::Halton(_, keys) if keys.is_empty())
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
            _ => self.samples * self.replicates,
        }
    }

    /// The first points of each replicate, a part `factor` (0 .. 1] of them, at least one: a power of two where the kind needs it.
    /// A one-at-a-time design stays whole.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        let wanted = (libm::round(self.samples as f64 * factor) as u64).clamp(1, self.samples);
        self.samples = if self.kind.needs_powers_of_two() { 1 << wanted.ilog2() } else { wanted };
        self
    }

    /// How many points the first `limit` points are, in whole blocks; the first block in any case.
    #[must_use]
    pub fn limited(&self, limit: u64) -> u64 {
        let limit = limit.clamp(1, self.count());
        match &self.points {
            Points::Steps(steps) => {
                let next = |index: u64| index < steps.count() && steps.block(index) == steps.block(index - 1);
                (1..=limit).rev().find(|&index| !next(index)).unwrap_or(1)
            }
            _ => (limit - limit % self.replicates).max(self.replicates),
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
            _ => index / self.replicates,
        }
    }

    /// The largest beginning of the first `count` points of which an interval can be made as far as its shape goes.
    #[must_use]
    pub fn whole(&self, count: u64) -> u64 {
        let each = count / self.replicates;
        match self.kind {
            Kind::OneAtATime | Kind::MonteCarlo => count,
            Kind::LatinHypercube | Kind::Sobol => each.checked_ilog2().map_or(0, |power| self.replicates << power),
            Kind::Halton => each * self.replicates,
        }
    }

    /// What an interval may be made of from the first `count` points.
    #[must_use]
    pub fn standing(&self, count: u64) -> Standing {
        match (self.kind, &self.points) {
            (Kind::MonteCarlo, _) => Standing::Independent,
            (Kind::OneAtATime, _) => Standing::NoInterval("points of a one-at-a-time design are not random"),
            (_, Points::Sobol(_, keys) | Points::Halton(_, keys)) if keys.is_empty() => {
                Standing::NoInterval("points that are not scrambled are not random")
            }
            _ if self.replicates < FEWEST_REPLICATES => Standing::NoInterval("fewer than 16 replicates"),
            _ if count == 0 || !count.is_multiple_of(self.replicates) => {
                Standing::NoInterval("replicates of different sizes")
            }
            _ if self.whole(count) != count => Standing::NoInterval("replicates of a size that is no power of two"),
            _ => Standing::Replicates(self.replicates),
        }
    }

    /// What `check` says beside the numbers.
    #[must_use]
    pub fn notes(&self, dimensions: usize, copula: &Copula) -> Vec<String> {
        let mut notes = Vec::new();
        if let Standing::NoInterval(reason) = self.standing(self.count()) {
            notes.push(match reason {
                "fewer than 16 replicates" => {
                    let s = if self.replicates == 1 { "" } else { "s" };
                    format!(
                        "answers have no interval: {} replicate{s}, {FEWEST_REPLICATES} are needed",
                        self.replicates
                    )
                }
                reason => format!("answers have no interval: {reason}"),
            });
        }
        let sequence = matches!(self.kind, Kind::Sobol | Kind::Halton);
        if sequence && dimensions > MANY_PARAMETERS {
            notes.push(format!(
                "{dimensions} parameters: beyond about {MANY_PARAMETERS} pairs of them are not spread evenly; the important ones should stand first"
            ));
        }
        if (sequence || self.kind == Kind::LatinHypercube) && !copula.is_independent() {
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

    /// The coordinates of a point `index` < count of any kind but one-at-a-time (which leaves them as they are).
    pub fn fill(&self, index: u64, point: &mut [f64]) {
        let (j, r) = (index / self.replicates, (index % self.replicates) as usize);
        match &self.points {
            Points::MonteCarlo(source) => source.fill(index, point),
            Points::Hypercubes(cubes) => cubes[r].fill(j, point),
            Points::Sobol(sobol, keys) => match keys.get(r) {
                Some(keys) => sobol.scrambled(j, keys, point),
                None => sobol.plain(j, point),
            },
            Points::Halton(primes, keys) => {
                for (dimension, (coordinate, &prime)) in point.iter_mut().zip(primes).enumerate() {
                    *coordinate = match keys.get(r) {
                        Some(keys) => halton::scrambled(j, prime, keys[dimension]),
                        None => halton::plain(j, prime),
                    };
                }
            }
            Points::Steps(_) => {}
        }
    }
}
