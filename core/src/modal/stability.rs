//! Stability of whirl: the least damping ratio of the linear rotor without contact, over the speed.
//!
//! ```text
//! lambda = r + i w         a solution e^{lambda t} of the linear rotor at one speed
//! zeta   = -r/|lambda|     damping ratio; zeta < 0: the motion grows                                                     (1)
//! least  = min zeta over the whirl modes (w > 0, zeta < 0.9) and over motions that grow without oscillation (zeta = -1) (2)
//! growth = exp(-2 pi zeta/sqrt(1 - zeta^2))      amplitude after one revolution of the whirl, over that before            (3)
//! ```
//! Aperiodic decaying motions and overdamped motions ([`OVERDAMPED`]) are not whirl modes, as in the report of modes. Between two speeds of
//! a [`DampingGrid`], (2) is interpolated linearly; the error is of second order in their distance.
//!
//! Source: the definition of the damping ratio; (3) is exp(-delta) with the logarithmic decrement delta. Limits: the linear rotor, with the
//! masses of the unbalances at their nodes and all bearings linear; contact and friction are excluded. Verified by the tests below and by
//! `tests/rotor/stability.rs`.

use super::whirl::{APERIODIC, OVERDAMPED};

/// Magnitude below which a damping ratio is rounding and counts as 0, so that an undamped rotor is not unstable. Eigenvalues have an error
/// of about 1e-16 of the largest |lambda|. That is up to 1e5 times a whirl frequency, and up to 100 times more by the condition of the
/// eigenvalue: 1e-9 in all. A mode with this negative damping ratio grows by 1 % in 1.6 million revolutions, more than any run has.
pub const ROUNDING: f64 = 1e-9;
/// Rounding of the damping ratio of a fast mode, per ratio of its |lambda| to the smallest one. Slow modes have nearly full accuracy; fast
/// modes have the rounding of the slowest (6e-12 times that ratio, on an almost massless shaft with modes up to 1e9 rad/s).
const ROUNDING_OF_FAST: f64 = 1e-11;
/// Ratio to the largest |lambda| below which |lambda| is rounding of the double zero of a free direction (the square root of 1e-16).
const FREE: f64 = 1e-7;

/// Damping of one motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damping {
    /// Damping ratio zeta (1) \[-\]; -1 for a motion that grows without oscillation.
    pub ratio: f64,
    /// Circular frequency w \[rad/s\]; 0 for a motion without oscillation.
    pub frequency: f64,
}

impl Damping {
    /// Growth factor (3) of the amplitude per revolution of the whirl \[-\]; above 1 for an unstable mode.
    #[must_use]
    pub fn growth(&self) -> f64 {
        let ratio = self.ratio;
        let decrement = 2.0 * std::f64::consts::PI * ratio / (1.0 - ratio * ratio).max(0.0).sqrt();
        // a motion that grows without oscillation does not whirl
        if ratio <= -1.0 { f64::MAX } else { libm::exp(-decrement).min(f64::MAX) }
    }
}

/// Returns the least damping (2) of the eigenvalues lambda (re, im) at one speed, with or without the conjugates; `None` without a whirl
/// mode.
#[must_use]
pub fn least_damping(values: &[[f64; 2]]) -> Option<Damping> {
    let size = |&[re, im]: &[f64; 2]| libm::hypot(re, im);
    let least = FREE * values.iter().map(size).fold(0.0, f64::max);
    let slowest = values.iter().map(size).filter(|size| *size > least).fold(f64::INFINITY, f64::min);
    let of = |value: &[f64; 2]| {
        let (size, [re, im]) = (size(value), *value);
        if size <= least || im < -APERIODIC * size {
            return None;
        }
        let ratio = -re / size;
        if im <= APERIODIC * size {
            return (ratio < 0.0).then_some(Damping { ratio: -1.0, frequency: 0.0 });
        }
        let rounding = ROUNDING.max(ROUNDING_OF_FAST * size / slowest);
        let ratio = if ratio.abs() < rounding { 0.0 } else { ratio };
        (ratio < OVERDAMPED).then_some(Damping { ratio, frequency: im })
    };
    values.iter().filter_map(of).min_by(|a, b| a.ratio.total_cmp(&b.ratio).then(a.frequency.total_cmp(&b.frequency)))
}

/// Least damping at the speeds W_b of a grid, ascending with b.
pub trait DampingGrid {
    /// Speed W_b \[rad/s\].
    fn speed(&self, b: i64) -> f64;
    /// Index of the largest W_b that does not exceed a speed \[rad/s\].
    fn below(&self, speed: f64) -> i64;
    /// Least damping at W_b; `None` if no mode whirls or the value is unknown.
    fn least(&self, b: i64) -> Option<Damping>;

    /// Damping ratio at a speed \[rad/s\], interpolated linearly between the two neighbouring speeds of the grid.
    fn ratio_at(&self, speed: f64) -> Option<f64> {
        let b = self.below(speed);
        let (from, to) = (self.speed(b), self.speed(b + 1));
        let share = ((speed - from) / (to - from)).clamp(0.0, 1.0);
        match (self.least(b), self.least(b + 1)) {
            (Some(one), Some(other)) => Some((1.0 - share) * one.ratio + share * other.ratio),
            (one, other) => one.or(other).map(|one| one.ratio),
        }
    }
}

/// Least damping over the speeds that a run has visited so far.
#[derive(Debug, Clone, Default)]
pub struct LeastDamping {
    /// Lowest and highest visited speed \[rad/s\].
    seen: Option<[f64; 2]>,
    /// Least damping ratio \[-\], and its speed \[rad/s\].
    least: Option<(f64, f64)>,
}

impl LeastDamping {
    /// Returns whether a speed lies outside the visited range by more than `noticeable` \[rad/s\].
    #[inline]
    #[must_use]
    pub fn is_new(&self, speed: f64, noticeable: f64) -> bool {
        self.seen.is_none_or(|[lowest, highest]| speed < lowest - noticeable || speed > highest + noticeable)
    }

    /// Extends the visited range to a speed \[rad/s\]; returns the least damping ratio so far \[-\] and its speed \[rad/s\].
    pub fn see(&mut self, speed: f64, grid: &dyn DampingGrid) -> Option<(f64, f64)> {
        let [lowest, highest] = self.seen.unwrap_or([speed; 2]);
        if !speed.is_finite() || (self.seen.is_some() && (lowest..=highest).contains(&speed)) {
            return self.least;
        }
        let (from, to) = if speed < lowest { (speed, lowest) } else { (highest, speed) };
        let mut candidate = |ratio: Option<f64>, speed: f64| {
            if let Some(ratio) = ratio.filter(|ratio| self.least.is_none_or(|(least, _)| *ratio < least)) {
                self.least = Some((ratio, speed));
            }
        };
        candidate(grid.ratio_at(speed), speed);
        for b in grid.below(from) + 1..=grid.below(to) {
            candidate(grid.least(b).map(|damping| damping.ratio), grid.speed(b));
        }
        self.seen = Some([lowest.min(speed), highest.max(speed)]);
        self.least
    }

    /// Returns the least damping ratio so far \[-\] and its speed \[rad/s\].
    #[must_use]
    pub fn least(&self) -> Option<(f64, f64)> {
        self.least
    }

    /// Returns the largest growth factor (3) of a whirl mode so far \[-\]; above 1 for an unstable rotor. `None` before the first speed or
    /// without a whirl mode.
    #[must_use]
    pub fn growth(&self) -> Option<f64> {
        self.least.map(|(ratio, _)| Damping { ratio, frequency: 0.0 }.growth())
    }
}

/// A range of speeds with an unstable whirl mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnstableRange {
    /// Lower limit \[rad/s\].
    pub from: f64,
    /// Upper limit \[rad/s\].
    pub to: f64,
    /// Least damping of the range at the evaluated speeds.
    pub worst: Damping,
    /// Speed of `worst` \[rad/s\].
    pub worst_at: f64,
}

/// Largest error of a limit of an [`UnstableRange`] \[rad/s\]: 0.01 rpm.
const CLOSE: f64 = 0.01 * std::f64::consts::PI / 30.0;

/// Returns the ranges of speed with negative least damping. `speeds` is ascending; its ends are the ends of the search.
///
/// Between two speeds with different signs, the limit is found by bisection. If the damping at a speed is not above that of both
/// neighbours, the minimum between the neighbours is searched by golden sections; this finds a range between two speeds. Limit: two minima
/// between three speeds are not separated.
///
/// # Errors
/// The errors of `damping`.
pub fn unstable_ranges<E>(
    speeds: &[f64],
    mut damping: impl FnMut(f64) -> Result<Option<Damping>, E>,
) -> Result<Vec<UnstableRange>, E> {
    let mut points: Vec<(f64, Option<Damping>)> = Vec::with_capacity(speeds.len());
    for &speed in speeds {
        points.push((speed, damping(speed)?));
    }
    let ratio = |found: Option<Damping>| found.map_or(1.0, |found| found.ratio);
    let mut minima = Vec::new();
    for three in points.windows(3) {
        let [a, b, c] = [0, 1, 2].map(|i| ratio(three[i].1));
        if b >= 0.0 && a.min(c) >= b && a.max(c) > b {
            minima.extend(minimum(three[0].0, three[2].0, &mut damping)?);
        }
    }
    points.extend(minima);
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut ranges: Vec<UnstableRange> = Vec::new();
    let mut before: Option<(f64, Option<Damping>)> = None;
    for &(speed, found) in &points {
        let was = before.map(|(at, found)| (at, ratio(found) < 0.0));
        let Some(worst) = found.filter(|found| found.ratio < 0.0) else {
            if let (Some((at, true)), Some(range)) = (was, ranges.last_mut()) {
                range.to = limit(at, speed, &mut damping)?;
            }
            before = Some((speed, found));
            continue;
        };
        match (was, ranges.last_mut()) {
            (Some((_, true)), Some(range)) => {
                range.to = speed;
                if worst.ratio < range.worst.ratio {
                    (range.worst, range.worst_at) = (worst, speed);
                }
            }
            _ => {
                let from = match was {
                    Some((at, _)) => limit(speed, at, &mut damping)?,
                    None => speed,
                };
                ranges.push(UnstableRange { from, to: speed, worst, worst_at: speed });
            }
        }
        before = Some((speed, found));
    }
    Ok(ranges)
}

/// Finds the zero of the damping between an unstable and a stable speed, on the unstable side \[rad/s\].
fn limit<E>(
    mut unstable: f64,
    mut stable: f64,
    damping: &mut impl FnMut(f64) -> Result<Option<Damping>, E>,
) -> Result<f64, E> {
    while (unstable - stable).abs() > CLOSE {
        let middle = 0.5 * (unstable + stable);
        let grows = damping(middle)?.is_some_and(|found| found.ratio < 0.0);
        *(if grows { &mut unstable } else { &mut stable }) = middle;
    }
    Ok(unstable)
}

/// Returns the first evaluated speed with negative damping during the search for the minimum between two speeds; `None` if the minimum is
/// not negative.
fn minimum<E>(
    mut from: f64,
    mut to: f64,
    damping: &mut impl FnMut(f64) -> Result<Option<Damping>, E>,
) -> Result<Option<(f64, Option<Damping>)>, E> {
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let ratio = |found: &Option<Damping>| found.map_or(1.0, |found| found.ratio);
    let inner = |from: f64, to: f64| [from + GOLDEN * (to - from), to - GOLDEN * (to - from)];
    let [mut a, mut b] = inner(from, to);
    let (mut at_a, mut at_b) = (damping(a)?, damping(b)?);
    loop {
        if ratio(&at_a) < 0.0 {
            return Ok(Some((a, at_a)));
        }
        if ratio(&at_b) < 0.0 {
            return Ok(Some((b, at_b)));
        }
        if to - from < CLOSE {
            return Ok(None);
        }
        if ratio(&at_a) < ratio(&at_b) {
            (to, b, at_b) = (b, a, at_a);
            a = inner(from, to)[0];
            at_a = damping(a)?;
        } else {
            (from, a, at_a) = (a, b, at_b);
            b = inner(from, to)[1];
            at_b = damping(b)?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Least damping `f(W)` on a uniform grid of 4 rad/s.
    struct Even<F: Fn(f64) -> f64>(F);

    impl<F: Fn(f64) -> f64> DampingGrid for Even<F> {
        fn speed(&self, b: i64) -> f64 {
            4.0 * b as f64
        }
        fn below(&self, speed: f64) -> i64 {
            (speed / 4.0).floor() as i64
        }
        fn least(&self, b: i64) -> Option<Damping> {
            Some(Damping { ratio: (self.0)(self.speed(b)), frequency: 1.0 })
        }
    }

    #[test]
    fn what_counts_as_whirl() {
        let least = |values: &[[f64; 2]]| least_damping(values).map(|found| found.ratio);
        assert_eq!(least(&[[-1.0, 10.0], [-1.0, -10.0]]), Some(1.0 / 101.0_f64.sqrt()));
        // a decay without oscillation and an overdamped motion do not whirl, a growing motion counts
        assert_eq!(least(&[[-5.0, 0.0], [-9.5, 1.0]]), None);
        assert_eq!(least(&[[-5.0, 0.0], [5.0, 0.0], [-1.0, 10.0]]), Some(-1.0));
        // rounding of an undamped rotor, and of a free direction
        assert_eq!(least(&[[1e-9, 100.0]]), Some(0.0));
        assert_eq!(least(&[[1e-4, 0.0], [0.0, 1e5]]), Some(0.0));
        assert!(Damping { ratio: 0.0, frequency: 1.0 }.growth() == 1.0);
        assert!(Damping { ratio: -1.0, frequency: 0.0 }.growth().is_finite());
        let one = Damping { ratio: 0.1, frequency: 1.0 };
        assert!((one.growth() - (-0.2 * std::f64::consts::PI / 0.99_f64.sqrt()).exp()).abs() < 1e-15);
    }

    #[test]
    fn the_least_of_the_speeds_visited_does_not_depend_on_the_looks() {
        let grid = Even(|speed: f64| 1e-3 * (speed - 41.0).abs() - 0.01);
        let mut fine = LeastDamping::default();
        for k in 0..=1000 {
            fine.see(100.0 - 0.09 * f64::from(k), &grid);
        }
        let mut coarse = LeastDamping::default();
        assert!(coarse.is_new(100.0, 0.1));
        assert_eq!(coarse.see(100.0, &grid).map(|(_, at)| at), Some(100.0));
        assert!(!coarse.is_new(99.95, 0.1) && coarse.is_new(99.8, 0.1));
        coarse.see(10.0, &grid);
        assert_eq!(coarse.least(), fine.least());
        // the kink lies between 40 and 44
        assert!((fine.least().expect("seen").0 + 0.009).abs() < 1e-12);
        assert!(fine.growth().expect("seen") > 1.0);
    }

    #[test]
    fn ranges_have_their_limits_and_narrow_ones_are_found() {
        let ranges = |f: &dyn Fn(f64) -> f64| {
            let speeds: Vec<f64> = (0..=50).map(|k| 4.0 * f64::from(k)).collect();
            let damping = |speed: f64| Ok::<_, Infallible>(Some(Damping { ratio: f(speed), frequency: 1.0 }));
            unstable_ranges(&speeds, damping).expect("infallible")
        };
        let found = ranges(&|speed| 0.01 - speed / 15_000.0);
        assert!(found.len() == 1 && (found[0].from - 150.0).abs() < 2e-3 && found[0].to == 200.0, "{found:?}");
        assert!((found[0].worst.ratio + 1.0 / 300.0).abs() < 1e-12);
        // 0.6 rad/s wide, between two speeds
        let found = ranges(&|speed| 1e-3 * ((speed - 50.0).powi(2) - 0.09));
        assert!(found.len() == 1, "{found:?}");
        assert!((found[0].from - 49.7).abs() < 2e-3 && (found[0].to - 50.3).abs() < 2e-3, "{found:?}");
        assert_eq!(ranges(&|_| 0.01), []);
        assert_eq!(ranges(&|_| 0.0), []);
        let all = ranges(&|_| -0.01);
        assert!(all.len() == 1 && all[0].from == 0.0 && all[0].to == 200.0);
    }
}
