//! Speeds of the grid at which modal bases are computed.
//!
//! ```text
//! even spacing          W_b = (b + 1/2) D                                                                              (1)
//! refined at rest       W_b = 2 D sinh((b + 1/2)/2N)      about D/2 apart at the initial speed N D, D/37 at rest         (2)
//! ```
//! `b`: index of a basis, `D`: grid spacing \[rad/s\], `N`: number of bases up to the initial speed. No basis is at W = 0, where the modes of an isotropic rotor are double.
//!
//! (2) is for anisotropic bearings. There the orbits change from planar to circular within some rad/s of rest, but hardly change at high speed.
//! A turbine on such bearings that whips until it stops lost 2e-4 of its energy with (1) and D = 4 rad/s, and 2.5e-6 with (2) (8e-6 with N instead of 2N). An isotropic shaft line has circular orbits
//! at any speed.
//!
//! With bearing tables there are r times as many bases, `(b + 1/2)/r` in the place of `b + 1/2`: r is the least power of two with which the coefficients depart from the straight
//! lines between two bases by at most [`MAX_BEND`] of their largest value, and [`MAX_MEAN_BEND`] in the mean. Verified by the test below and `whips_on_anisotropic_bearings_balance_their_energies` (`tests/exponential/exponential_run.rs`).

use super::bearing_tables::BearingTables;
use crate::engine::exponential::error::ExponentialError;
use bladeoff_model::machine::{Bearing, Machine};

/// Number of bases up to the initial speed, N.
const BASES_PER_INITIAL_SPEED: f64 = 37.5;
/// Number of neighbouring bases of which one is the anchor: runs with initial speeds among them continue their bases from the same one.
const ANCHOR_STRIDE: f64 = 8.0;

/// Largest departure of a table's coefficient from the straight line between two bases, as a share of the largest one of its kind; and of its mean over the table.
const MAX_BEND: f64 = 1e-2;
const MAX_MEAN_BEND: f64 = 1e-4;
/// Largest number r of bases in the place of one.
const MAX_REFINEMENT: f64 = 16.0;
/// Speeds between two bases at which the departure is computed.
const BEND_POINTS: u32 = 8;

/// Rule for the speeds W_b of a grid: (1) or (2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GridSpacing {
    /// D \[rad/s\].
    pub spacing: f64,
    /// Whether the grid is refined at rest, by (2).
    pub closes: bool,
    /// r: number of bases in the place of one; 1 without bearing tables.
    pub refinement: f64,
}

/// Whether all bearings are isotropic (cross stiffness and cross damping skew-symmetric), at all speeds of their tables.
fn is_isotropic(machine: &Machine) -> bool {
    let same = |[[a, b], [c, d]]: [[f64; 2]; 2]| a.to_bits() == d.to_bits() && b + c == 0.0;
    let constant = |bearing: &Bearing| match &bearing.table {
        None => same(bearing.stiffness) && same(bearing.damping),
        Some(table) => table.at_nodes().all(|at| same(at.stiffness) && same(at.damping)),
    };
    machine.rotor.bearings.iter().all(constant)
}

impl GridSpacing {
    /// Grid spacing of a machine for its largest speed; a given spacing \[rad/s\] makes the grid even.
    pub fn of(machine: &Machine, spacing: Option<f64>) -> Self {
        let law_speeds = machine.rotor.speed_law.iter().flat_map(|law| law.speeds.iter().copied());
        let even = spacing.map(|spacing| Self { spacing, closes: false, refinement: 1.0 });
        even.unwrap_or_else(|| Self::reaching(machine, law_speeds.fold(machine.rotor.initial_speed, f64::max)))
    }

    /// Grid spacing of a machine for speeds up to `speed` \[rad/s\]: D is the power of two nearest to speed/N.
    pub fn reaching(machine: &Machine, speed: f64) -> Self {
        let spacing = libm::exp2(libm::round(libm::log2(speed.max(1.0) / BASES_PER_INITIAL_SPEED)));
        Self { spacing, closes: !is_isotropic(machine), refinement: 1.0 }
    }

    /// Grid spacing with as many bases as bearing tables need.
    ///
    /// # Errors
    /// [`ExponentialError::NotCovered`] for tables that need more than [`MAX_REFINEMENT`].
    pub fn refined_for(mut self, tables: &BearingTables) -> Result<Self, ExponentialError> {
        while !tables.is_empty() && self.bends(tables) {
            self.refinement *= 2.0;
            if self.refinement > MAX_REFINEMENT {
                return Err(ExponentialError::NotCovered {
                    what: "bearing tables with more detail than its grid of speeds",
                });
            }
        }
        Ok(self)
    }

    /// Whether the coefficients depart too far from the straight lines between two bases.
    fn bends(&self, tables: &BearingTables) -> bool {
        let ([low, high], largest) = (tables.range(), tables.largest());
        let (mut worst, mut sum, mut weight) = (0.0_f64, 0.0, 0.0);
        for b in self.below(low)..=self.below(high) {
            let (from, distance) = (self.speed(b), self.distance(b));
            let ends = [from, from + distance].map(|speed| tables.changes(speed));
            for i in 0..BEND_POINTS {
                let share = (f64::from(i) + 0.5) / f64::from(BEND_POINTS);
                let speed = from + share * distance;
                if !(low..=high).contains(&speed) {
                    continue;
                }
                let straight = BearingTables::between(ends.each_ref(), [1.0 - share, share]);
                let departure = tables.departure([&tables.changes(speed), &straight], &largest);
                (worst, sum, weight) = (worst.max(departure), sum + distance * departure, weight + distance);
            }
        }
        worst > MAX_BEND || sum > MAX_MEAN_BEND * weight
    }

    /// Index of the highest basis at or below a speed \[rad/s\].
    pub fn below(&self, speed: f64) -> i64 {
        libm::floor(self.position(speed) - 0.5) as i64
    }

    /// Speed W_b of basis b \[rad/s\].
    pub fn speed(&self, b: i64) -> f64 {
        let position = (b as f64 + 0.5) / self.refinement;
        if self.closes {
            2.0 * self.spacing * libm::sinh(position / (2.0 * BASES_PER_INITIAL_SPEED))
        } else {
            position * self.spacing
        }
    }

    /// Distance from basis b to basis b + 1 \[rad/s\].
    pub fn distance(&self, b: i64) -> f64 {
        if self.closes { self.speed(b + 1) - self.speed(b) } else { self.spacing / self.refinement }
    }

    /// Position of a speed on the grid: the real number b + 1/2 with W_b = `speed`.
    fn position(&self, speed: f64) -> f64 {
        let ratio = speed / self.spacing;
        let position = if self.closes { 2.0 * BASES_PER_INITIAL_SPEED * libm::asinh(0.5 * ratio) } else { ratio };
        position * self.refinement
    }

    /// Index of the speed interval that contains a speed, with `intervals` of them between two bases.
    pub fn interval_of(&self, speed: f64, intervals: i64) -> i64 {
        if !self.closes {
            return libm::floor((self.position(speed) - 0.5) * intervals as f64) as i64;
        }
        let b = self.below(speed);
        let offset = libm::floor((speed - self.speed(b)) / self.distance(b) * intervals as f64) as i64;
        b * intervals + offset.clamp(0, intervals - 1)
    }

    /// Index of the anchor for an initial speed: the basis from which all others are continued.
    pub fn anchor(&self, speed: f64) -> i64 {
        (libm::round(self.position(speed) / ANCHOR_STRIDE) * ANCHOR_STRIDE) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_lies_in_its_interval() {
        for closes in [false, true] {
            let grid = GridSpacing { spacing: 4.0, closes, refinement: 1.0 };
            for n in -400..800 {
                let speed = 0.37 * f64::from(n) + 0.01;
                let index = grid.interval_of(speed, 40);
                let (b, j) = (index.div_euclid(40), index.rem_euclid(40) as f64);
                let width = grid.distance(b) / 40.0;
                let from = grid.speed(b) + j * width;
                assert!(speed > from - 1e-9 && speed < from + width + 1e-9, "{closes} {speed}: {from} {width}");
                assert!((grid.speed(b + 1) - grid.speed(b) - grid.distance(b)).abs() < 1e-12);
            }
        }
        let grid = GridSpacing { spacing: 4.0, closes: true, refinement: 1.0 };
        let distance = |speed: f64| grid.distance(grid.interval_of(speed, 1));
        assert!(distance(0.0) < 0.12 && (1.8..2.2).contains(&distance(150.0)), "{} {}", distance(0.0), distance(150.0));
    }
}
