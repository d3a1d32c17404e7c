//! Probability of an event, from counts.
//!
//! ```text
//! independent points     [L(k_low), U(k_high)], exact limits at alpha/2 each; they cover p for any outcome of the bad runs
//! replicates             Student's t of their shares; with few events, or few points without: limits of independent points, approximate
//! ```
//! Coverage: with the open runs settled, the number of events is k_low <= k <= k_high, and both limits grow with k.
//! Sources: C. J. Clopper, E. S. Pearson (1934). Verified by `tests/uncertainty`: figures by hand and the coverage table.

use super::figures::{Figures, Method, ratio_of_counts};
use super::known::Truths;
use super::limits::{lower_limit, upper_limit};
use super::scheme::{FEW, Scheme};
use super::truth::Truth;

/// Counts of points and events in a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Number of points.
    pub n: u64,
    /// Events with open runs counted as harmless.
    pub low: u64,
    /// Events with open runs counted as harmful.
    pub high: u64,
}

impl Tally {
    /// Adds a point.
    pub fn see(&mut self, truth: Truth) {
        self.n += 1;
        self.low += u64::from(truth.low());
        self.high += u64::from(truth.high());
    }

    /// Sum over all parts.
    #[must_use]
    pub fn of_all(tallies: &[Self]) -> Self {
        tallies.iter().fold(Self::default(), |sum, one| Self {
            n: sum.n + one.n,
            low: sum.low + one.low,
            high: sum.high + one.high,
        })
    }
}

/// Counts by part; `part` gives the part of a point.
#[must_use]
pub fn tallies(truths: &Truths, parts: usize, part: impl Fn(usize) -> usize) -> Vec<Tally> {
    let mut tallies = vec![Tally::default(); parts];
    for (point, &truth) in truths.of.iter().enumerate() {
        tallies[part(point)].see(truth);
    }
    tallies
}

/// Sets the upper limit for an event without occurrence, as for equally many independent points: no occurrence is never a probability of 0.
pub fn none_seen(all: &Tally, alpha: f64, found: &mut Figures) {
    if all.low == 0 && all.n > 0 {
        found.low = Some(0.0);
        found.high = Some(upper_limit(all.high, all.n, alpha / 2.0));
        found.statistical = Some(upper_limit(0, all.n, alpha / 2.0));
        (found.method, found.approximate) = (Method::ClopperPearson, true);
        found.notes.push("no event: the upper limit is that of the same number of independent points".to_owned());
    }
}

/// Probability with its interval; `tallies` by part of the scheme, `alpha` = 1 - confidence.
#[must_use]
pub fn proportion(tallies: &[Tally], scheme: &Scheme, alpha: f64) -> Figures {
    proportion_by(tallies, scheme, alpha, scheme.t(alpha))
}

/// [`proportion`] with a precomputed [`Scheme::t`], which dominates the computing time.
#[must_use]
pub fn proportion_by(tallies: &[Tally], scheme: &Scheme, alpha: f64, t: f64) -> Figures {
    let all = Tally::of_all(tallies);
    let mut found = Figures::over(all.n);
    if all.n == 0 {
        found.notes.push("there is no point".to_owned());
        return found;
    }
    let share = |events: u64| events as f64 / all.n as f64;
    found.events = Some(all.low);
    found.estimate = Some(share(all.low));
    found.harmful = Some(share(all.high));
    let exact = |found: &mut Figures| {
        found.low = Some(lower_limit(all.low, all.n, alpha / 2.0));
        found.high = Some(upper_limit(all.high, all.n, alpha / 2.0));
        found.statistical = Some(upper_limit(all.low, all.n, alpha / 2.0) - found.low.unwrap_or(0.0));
        found.method = Method::ClopperPearson;
    };
    match scheme {
        Scheme::Independent => exact(&mut found),
        Scheme::Without(why) => found.notes.push(why.clone()),
        Scheme::Replicated(_) => {
            found.approximate = true;
            let few = [all.low, all.n - all.low, all.high, all.n - all.high].into_iter().any(|count| count < FEW);
            let of = |events: fn(&Tally) -> u64| {
                let parts: Vec<_> = tallies.iter().map(|part| (events(part) as f64, part.n as f64)).collect();
                ratio_of_counts(&parts, t, alpha)
            };
            match (of(|part| part.low), of(|part| part.high)) {
                (Some((low, down)), Some((high, up))) if !few => {
                    found.low = Some((low - down).max(0.0));
                    found.high = Some((high + up).min(1.0));
                    found.statistical = Some(2.0 * down);
                    found.method = Method::Replicates;
                }
                _ => {
                    exact(&mut found);
                    let why = format!(
                        "fewer than {FEW} events, or fewer than {FEW} points without: the limits are those of \
                                 the same number of independent points"
                    );
                    found.notes.push(why);
                }
            }
        }
    }
    found
}
