//! Root of a distribution function in the logarithm of its argument, by Newton's method on the logarithm of the smaller tail. For the
//! distributions here, the logarithm of a tail is concave in that of the argument, so the steps do not oscillate; a bracket limits them.

/// The matched tail, with the logarithm of its probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Tail {
    /// ln p.
    Lower(f64),
    /// ln q.
    Upper(f64),
}

impl Tail {
    /// The smaller of both tails.
    pub fn smaller(p: f64, q: f64) -> Self {
        if p <= q { Self::Lower(libm::log(p)) } else { Self::Upper(libm::log(q)) }
    }
}

/// Smallest logarithm of an argument; below, the argument underflows to 0.
const LEAST: f64 = -745.2;
const ROUNDS: usize = 200;

/// Number of previous states that are compared to find a cycle.
const REMEMBERED: usize = 4;

/// Solves for the t of at most `top` at which the tail has its value; `tails`: ln of the lower tail, of the upper tail, and of dp/dt.
///
/// Near the root, rounding makes about half of all searches alternate between two neighbouring numbers. The state of a round
/// determines the next one, so a repeated state gives the result of all [`ROUNDS`] rounds without computing them.
pub(super) fn solve(tail: Tail, first: f64, top: f64, tails: impl Fn(f64) -> (f64, f64, f64)) -> f64 {
    // the first guess is exact for such a small argument
    if first < LEAST {
        return f64::NEG_INFINITY;
    }
    let (mut low, mut high) = (LEAST, top);
    let mut t = first.clamp(low, high);
    let mut seen = [[f64::NAN; 3]; REMEMBERED];
    let (mut round, mut rounds) = (0, ROUNDS);
    while round < rounds {
        let state = [t, low, high];
        if let Some(place) = seen.iter().position(|known| *known == state).filter(|_| rounds == ROUNDS) {
            rounds = round + (ROUNDS - round) % (place + 1);
            continue;
        }
        seen.rotate_right(1);
        seen[0] = state;
        round += 1;
        let (lower, upper, slope) = tails(t);
        // error of the logarithm, positive if t is too large, and its derivative
        let (error, rise) = match tail {
            Tail::Lower(ln) => (lower - ln, libm::exp(slope - lower)),
            Tail::Upper(ln) => (ln - upper, libm::exp(slope - upper)),
        };
        if error > 0.0 {
            high = high.min(t);
        } else {
            low = low.max(t);
        }
        let newton = t - error / rise;
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= 1e-16 * t.abs().max(1.0) || error == 0.0 {
            return next;
        }
        t = next;
    }
    t
}
