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
//! at any speed. Verified by the test below and `whips_on_anisotropic_bearings_balance_their_energies` (`tests/exponential/exponential_run.rs`).

use bladeoff_model::machine::Machine;

/// Number of bases up to the initial speed, N.
const BASES_PER_INITIAL_SPEED: f64 = 37.5;
/// Number of neighbouring bases of which one is the anchor: runs with initial speeds among them continue their bases from the same one.
const ANCHOR_STRIDE: f64 = 8.0;

/// Rule for the speeds W_b of a grid: (1) or (2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GridSpacing {
    /// D \[rad/s\].
    pub spacing: f64,
    /// Whether the grid is refined at rest, by (2).
    pub closes: bool,
}

/// Whether all bearings are isotropic (cross stiffness and cross damping skew-symmetric).
fn is_isotropic(machine: &Machine) -> bool {
    let same = |[[a, b], [c, d]]: [[f64; 2]; 2]| a.to_bits() == d.to_bits() && b + c == 0.0;
    machine.rotor.bearings.iter().all(|bearing| same(bearing.stiffness) && same(bearing.damping))
}

impl GridSpacing {
    /// Grid spacing of a machine for its largest speed; a given spacing \[rad/s\] makes the grid even.
    pub fn of(machine: &Machine, spacing: Option<f64>) -> Self {
        let law_speeds = machine.rotor.speed_law.iter().flat_map(|law| law.speeds.iter().copied());
        let even = spacing.map(|spacing| Self { spacing, closes: false });
        even.unwrap_or_else(|| Self::reaching(machine, law_speeds.fold(machine.rotor.initial_speed, f64::max)))
    }

    /// Grid spacing of a machine for speeds up to `speed` \[rad/s\]: D is the power of two nearest to speed/N.
    pub fn reaching(machine: &Machine, speed: f64) -> Self {
        let spacing = libm::exp2(libm::round(libm::log2(speed.max(1.0) / BASES_PER_INITIAL_SPEED)));
        Self { spacing, closes: !is_isotropic(machine) }
    }

    /// Index of the highest basis at or below a speed \[rad/s\].
    pub fn below(&self, speed: f64) -> i64 {
        libm::floor(self.position(speed) - 0.5) as i64
    }

    /// Speed W_b of basis b \[rad/s\].
    pub fn speed(&self, b: i64) -> f64 {
        let position = b as f64 + 0.5;
        if self.closes {
            2.0 * self.spacing * libm::sinh(position / (2.0 * BASES_PER_INITIAL_SPEED))
        } else {
            position * self.spacing
        }
    }

    /// Distance from basis b to basis b + 1 \[rad/s\].
    pub fn distance(&self, b: i64) -> f64 {
        if self.closes { self.speed(b + 1) - self.speed(b) } else { self.spacing }
    }

    /// Position of a speed on the grid: the real number b + 1/2 with W_b = `speed`.
    fn position(&self, speed: f64) -> f64 {
        let ratio = speed / self.spacing;
        if self.closes { 2.0 * BASES_PER_INITIAL_SPEED * libm::asinh(0.5 * ratio) } else { ratio }
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
            let grid = GridSpacing { spacing: 4.0, closes };
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
        let grid = GridSpacing { spacing: 4.0, closes: true };
        let distance = |speed: f64| grid.distance(grid.interval_of(speed, 1));
        assert!(distance(0.0) < 0.12 && (1.8..2.2).contains(&distance(150.0)), "{} {}", distance(0.0), distance(150.0));
    }
}
