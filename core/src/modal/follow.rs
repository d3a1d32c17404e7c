//! Tracking of modes over speed by their mode shapes, and critical speeds: the speeds at which a whirl frequency equals the spin.
//!
//! From one speed to the next, each mode is matched with the most similar mode ([`Mode::alike`]). The speed step is halved if the match is
//! not clear, or if a mode becomes overdamped or disappears. So the lines of a Campbell diagram cross at a true crossing and veer
//! otherwise. The number of evaluated speeds is limited ([`Spectra`]). Verified by `tests/rotor/modes.rs`; critical speeds also by
//! `tests/rotor/outside.rs` and `tests/rotor/linear_rotors.rs`.

use super::matrices::Reduced;
use super::quadratic::Eigensolver;
use super::reduction::checked_basis;
use super::refine::Refinement;
use super::shape::{CLEAR, Mode};
use super::spectra::{ModesError, Spectra};
use super::whirl::{APERIODIC, CriticalSpeed, Lateral, OverdampedMode, SpeedModes, WhirlMode, whirls};

/// Number of lowest whirl modes at rest that are tracked for critical speeds and must be matched clearly.
const FOLLOWED: usize = 12;
/// Speed intervals from rest to the end of the search.
const INTERVALS: usize = 64;
/// Highest speed of the search, as a multiple of the highest tracked frequency at rest.
const END: f64 = 1.05;
/// Maximum number of steps between two requested speeds.
const MOST: f64 = 128.0;
/// Maximum number of halvings of a speed step.
const HALVINGS: usize = 8;
/// Similarity (MAC) below which two modes are not matched by shape.
const STRANGE: f64 = 0.05;

/// Modes at one speed.
struct ModesAtSpeed {
    /// Speed W \[rad/s\].
    speed: f64,
    modes: Vec<Mode>,
    /// Identity of each mode: a number that stays with the mode over speed.
    identity: Vec<usize>,
}

/// Tracking of all modes from rest to increasing speeds.
struct Way<'a> {
    /// Evaluator of spectra, which limits the number of speeds.
    spectra: Spectra<'a>,
    /// Modes at the current speed.
    last: ModesAtSpeed,
    /// Number of each identity, from 1; 0 until the mode first whirls.
    numbers: Vec<usize>,
    /// Number of identities that have a number.
    numbered: usize,
    /// Number of tracked modes, which must be matched clearly.
    followed: usize,
    /// Highest frequency at rest of the tracked modes \[rad/s\].
    top: f64,
    /// Crossings of modes with the spin so far: speed \[rad/s\] and mode. `None`: crossings are not searched.
    crossings: Option<Vec<(f64, Mode)>>,
}

impl<'a> Way<'a> {
    fn begin(
        lateral: &'a Lateral,
        reduced: Option<&'a Reduced>,
        crossings: Option<Vec<(f64, Mode)>>,
    ) -> Result<Self, ModesError> {
        let spectra = Spectra::new(lateral, reduced);
        let mut modes = spectra.spectrum(0.0, 0.0)?;
        // whirl modes first: the tracked modes are the first ones
        modes.sort_by_key(|mode| !whirls(mode));
        let (followed, top) = followed(&modes);
        let last = ModesAtSpeed { speed: 0.0, identity: (0..modes.len()).collect(), modes };
        let numbers = vec![0; last.modes.len()];
        let mut way = Self { spectra, last, numbers, numbered: 0, followed, top, crossings };
        way.number();
        Ok(way)
    }

    /// Numbers each mode that whirls for the first time.
    fn number(&mut self) {
        for (mode, &identity) in self.last.modes.iter().zip(&self.last.identity) {
            if self.numbers[identity] == 0 && whirls(mode) {
                self.numbered += 1;
                self.numbers[identity] = self.numbered;
            }
        }
    }

    /// Tracks all modes to a speed \[rad/s\], with at most `halvings` halvings of the step.
    fn go_to(&mut self, speed: f64, halvings: usize) -> Result<(), ModesError> {
        let modes = self.spectra.spectrum(speed, self.last.speed)?;
        let last = &self.last;
        let next = matched(&last.modes, &modes);
        let clear = |(from, to): (usize, &Option<(usize, f64)>)| {
            last.identity[from] >= self.followed
                || to.is_some_and(|(to, alike)| alike >= CLEAR && whirls(&last.modes[from]) == whirls(&modes[to]))
        };
        if halvings > 0 && !next.iter().enumerate().all(clear) {
            let middle = 0.5 * (last.speed + speed);
            self.go_to(middle, halvings - 1)?;
            return self.go_to(speed, halvings - 1);
        }
        let mut identity = vec![None; modes.len()];
        for (from, to) in next.iter().enumerate() {
            let Some((to, _)) = *to else { continue };
            identity[to] = Some(last.identity[from]);
            let (one, other) = (&last.modes[from], &modes[to]);
            if let Some(found) = &mut self.crossings
                && oscillates(one)
                && oscillates(other)
            {
                found.extend(crossing(&self.spectra, (last.speed, one), (speed, other))?);
            }
        }
        let identity = identity.into_iter().map(|known| {
            known.unwrap_or_else(|| {
                self.numbers.push(0);
                self.numbers.len() - 1
            })
        });
        let identity = identity.collect();
        self.last = ModesAtSpeed { speed, modes, identity };
        self.number();
        Ok(())
    }

    /// Returns the whirl modes and overdamped motions at the current speed.
    fn here(&self) -> SpeedModes {
        let modes = || self.last.modes.iter().zip(&self.last.identity);
        let whirling = modes().filter(|(mode, _)| whirls(mode));
        let shown = |mode| self.spectra.lateral.whirl(mode, self.last.speed);
        let mut whirl: Vec<_> = whirling.map(|(mode, &identity)| (self.numbers[identity], shown(mode))).collect();
        whirl.sort_by(|a, b| a.1.frequency.total_cmp(&b.1.frequency).then(a.0.cmp(&b.0)));
        let overdamped = modes().filter(|(mode, _)| !whirls(mode)).map(|(mode, _)| {
            let [re, im] = mode.value;
            OverdampedMode { decay: -re, frequency: im, damping_ratio: -re / libm::hypot(re, im) }
        });
        let mut overdamped: Vec<_> = overdamped.collect();
        overdamped.sort_by(|a, b| a.decay.total_cmp(&b.decay));
        if !self.spectra.lateral.plane_motion(self.last.speed) {
            once(&mut overdamped);
        }
        SpeedModes { speed: self.last.speed, whirl, overdamped }
    }
}

/// Returns the number of tracked whirl modes at rest, and the highest of their frequencies \[rad/s\].
fn followed(modes: &[Mode]) -> (usize, f64) {
    let mut frequencies: Vec<f64> = modes.iter().filter(|mode| whirls(mode)).map(|mode| mode.value[1]).collect();
    frequencies.sort_by(f64::total_cmp);
    let count = frequencies.len().min(FOLLOWED);
    (count, frequencies[..count].last().copied().unwrap_or(0.0))
}

/// Removes one of two aperiodic motions whose decay differs by rounding only: they are a pair that rotates too slowly to be resolved.
fn once(overdamped: &mut Vec<OverdampedMode>) {
    let mut alone: Option<f64> = None;
    overdamped.retain(|mode| {
        let second =
            mode.frequency == 0.0 && alone.is_some_and(|decay| mode.decay - decay <= 2.0 * APERIODIC * decay.abs());
        alone = (mode.frequency == 0.0 && !second).then_some(mode.decay);
        !second
    });
}

/// Matches the modes `from` with the modes `to` at the next speed: the index of the matched mode and their similarity. The most similar
/// modes are matched first. The remaining whirl modes are matched by the distance of their lambda. If the number of whirl modes does not
/// change, whirl modes are matched with whirl modes only.
fn matched(from: &[Mode], to: &[Mode]) -> Vec<Option<(usize, f64)>> {
    let whirling = |modes: &[Mode]| modes.iter().filter(|mode| whirls(mode)).count();
    let lasting = whirling(from) == whirling(to);
    let mut pairs: Vec<(f64, f64, usize, usize)> = Vec::new();
    for (a, one) in from.iter().enumerate() {
        for (b, other) in to.iter().enumerate() {
            let ([p, q], [r, s]) = (one.value, other.value);
            if whirls(one) == whirls(other) || !lasting {
                pairs.push((one.alike(other), libm::hypot(p - r, q - s), a, b));
            }
        }
    }
    let (mut found, mut taken) = (vec![None; from.len()], vec![false; to.len()]);
    let mut pair = |pairs: &[(f64, f64, usize, usize)], fits: &dyn Fn(f64, usize, usize) -> bool| {
        for &(alike, _, a, b) in pairs {
            if found[a].is_none() && !taken[b] && fits(alike, a, b) {
                found[a] = Some((b, alike));
                taken[b] = true;
            }
        }
    };
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.total_cmp(&y.1)).then((x.2, x.3).cmp(&(y.2, y.3))));
    pair(&pairs, &|alike, _, _| alike > STRANGE);
    pairs.sort_by(|x, y| x.1.total_cmp(&y.1).then((x.2, x.3).cmp(&(y.2, y.3))));
    pair(&pairs, &|_, a, b| whirls(&from[a]) && whirls(&to[b]));
    found
}

/// Returns the modes at given speeds \[rad/s\], in the order of `speeds`.
///
/// # Errors
/// [`ModesError`].
pub(super) fn follow(lateral: &Lateral, speeds: &[f64]) -> Result<Vec<SpeedModes>, ModesError> {
    let mut way = Way::begin(lateral, None, None)?;
    let interval = END * way.top / INTERVALS as f64;
    let mut order: Vec<usize> = (0..speeds.len()).collect();
    order.sort_by(|&a, &b| speeds[a].total_cmp(&speeds[b]));
    let mut planned = 0.0_f64;
    let parts: Vec<usize> = order
        .iter()
        .map(|&at| {
            let (from, to) = (planned, speeds[at]);
            planned = from.max(to);
            let parts = if interval > 0.0 { ((to - from) / interval).ceil().clamp(1.0, MOST) } else { 1.0 };
            if to > from { parts as usize } else { 0 }
        })
        .collect();
    way.spectra.plan(planned, parts.iter().sum());
    let mut found = vec![None; speeds.len()];
    for (at, parts) in order.into_iter().zip(parts) {
        let (from, to) = (way.last.speed, speeds[at]);
        for part in 1..=parts {
            let between = from + (to - from) * part as f64 / parts as f64;
            way.go_to(if part == parts { to } else { between }, HALVINGS)?;
        }
        found[at] = Some(way.here());
    }
    Ok(found.into_iter().flatten().collect())
}

/// Critical speeds of a rotor, each list ascending.
pub(super) struct CriticalSpeeds {
    /// Critical speeds of whirl modes.
    pub whirl: Vec<CriticalSpeed>,
    /// Critical speeds of overdamped motions that oscillate, if their shape can be followed from speed to speed.
    pub overdamped: Vec<CriticalSpeed>,
}

/// Returns the speeds at which the frequency of a mode equals the speed.
///
/// For displayed results, the modes are tracked in a reduced basis, and each critical speed is then refined in the full model. The full
/// model is tracked if there is no such basis, or if the refinement converges to another mode.
///
/// # Errors
/// [`ModesError`].
pub(super) fn critical_speeds(lateral: &Lateral) -> Result<CriticalSpeeds, ModesError> {
    let mut found = match in_reduced_basis(lateral)? {
        Some(found) => found,
        None => crossings(lateral, None)?,
    };
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of = |whirling: bool| {
        let those = found.iter().filter(|(_, mode)| whirls(mode) == whirling);
        those.map(|(speed, mode)| critical(lateral, *speed, mode)).collect()
    };
    Ok(CriticalSpeeds { whirl: of(true), overdamped: of(false) })
}

/// Returns the refined crossings of a reduced basis; `None`: the full model is needed.
fn in_reduced_basis(lateral: &Lateral) -> Result<Option<Vec<(f64, Mode)>>, ModesError> {
    let Some(refinement) = Refinement::new(lateral).filter(|_| lateral.solver == Eigensolver::Display) else {
        return Ok(None);
    };
    let rest = lateral.spectrum(0.0)?;
    let (_, top) = followed(&rest);
    if top == 0.0 {
        return Ok(None);
    }
    let Some(reduced) = checked_basis(&refinement, rest, END * top)? else { return Ok(None) };
    let found = crossings(lateral, Some(&reduced))?;
    Ok(found.iter().map(|(speed, mode)| refinement.critical(*speed, mode)).collect())
}

/// Critical speed with the damping ratio and sense of its mode.
fn critical(lateral: &Lateral, speed: f64, mode: &Mode) -> CriticalSpeed {
    let WhirlMode { damping_ratio, whirl, share, .. } = lateral.whirl(mode, speed);
    CriticalSpeed { speed, damping_ratio, whirl, share }
}

/// Returns the crossings of the modes with the spin: speed \[rad/s\] and mode.
fn crossings(lateral: &Lateral, reduced: Option<&Reduced>) -> Result<Vec<(f64, Mode)>, ModesError> {
    let mut way = Way::begin(lateral, reduced, Some(Vec::new()))?;
    let top = END * way.top;
    way.spectra.plan(top, INTERVALS);
    for interval in (1..=INTERVALS).filter(|_| top > 0.0) {
        way.go_to(top * interval as f64 / INTERVALS as f64, HALVINGS)?;
    }
    Ok(way.crossings.unwrap_or_default())
}

/// Returns whether a motion oscillates, overdamped or not.
fn oscillates(mode: &Mode) -> bool {
    mode.value[1] > 0.0
}

/// Root of `omega(W) - W` of one mode in a speed interval, by regula falsi (Illinois); `None` without a root. Between two whirl modes, the
/// root belongs to a whirl mode; otherwise it belongs to an overdamped motion.
fn crossing(
    spectra: &Spectra<'_>,
    (mut a, first): (f64, &Mode),
    (mut b, last): (f64, &Mode),
) -> Result<Option<(f64, Mode)>, ModesError> {
    let begin = a;
    let whirling = whirls(first) && whirls(last);
    let (mut fa, mut fb) = (first.value[1] - a, last.value[1] - b);
    if (fa > 0.0) == (fb > 0.0) {
        return Ok(None);
    }
    let mut side = 0;
    for _ in 0..80 {
        let c = (a * fb - b * fa) / (fb - fa);
        let modes = spectra.spectrum(c, begin)?;
        let alike = |mode: &Mode| mode.alike(first) + mode.alike(last);
        let fitting = modes.iter().filter(|mode| if whirling { whirls(mode) } else { oscillates(mode) });
        let Some(mode) = fitting.max_by(|x, y| alike(x).total_cmp(&alike(y))) else { return Ok(None) };
        let fc = mode.value[1] - c;
        let narrow = (b - a).abs() < 1e-13 * c;
        // a jump from one mode to another is not a crossing
        if narrow && fc.abs() > 1e-6 * c {
            return Ok(None);
        }
        if narrow || fc.abs() < 1e-12 * c {
            return Ok((whirls(mode) == whirling).then(|| (c, mode.clone())));
        }
        if (fc > 0.0) == (fa > 0.0) {
            (a, fa) = (c, fc);
            if side == -1 {
                fb *= 0.5;
            }
            side = -1;
        } else {
            (b, fb) = (c, fc);
            if side == 1 {
                fa *= 0.5;
            }
            side = 1;
        }
    }
    Ok(None)
}
