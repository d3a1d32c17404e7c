//! Speeds of the grid's stations.
//!
//! ```text
//! even          W_b = (b + 1/2) D                                                                                         (1)
//! closing in    W_b = 2 D sinh((b + 1/2)/2N)      about D/2 apart at N D, which the initial speed is near, D/37 at rest   (2)
//! ```
//! (2) where a shaft line is not the same in all directions: a slow spin turns planes into circles within some rad/s, a fast one has circles. From station to station of (1) with 4 rad/s a whip of the turbine on such
//! bearings lost 2e-4 of its energies as it came to rest, with (2) 2.5e-6 (with N for 2N 8e-6). Where a shaft line is isotropic, the spin turns circles alone. Verified by the tests below and
//! `whips_on_anisotropic_bearings_balance_their_energies` (`tests/exponential_run.rs`).

use bladeoff_model::machine::Machine;

/// N.
const BASES_PER_INITIAL_SPEED: f64 = 37.5;
/// Of a number of stations the first is the same for all speeds about it, so that runs that begin at different speeds go by one chain.
const TOGETHER: f64 = 8.0;

/// One of the two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GridSpacing {
    /// D \[rad/s\].
    pub spacing: f64,
    pub closes: bool,
}

/// Whether the shaft line is the same in all directions.
fn is_isotropic(machine: &Machine) -> bool {
    let same = |[[a, b], [c, d]]: [[f64; 2]; 2]| a.to_bits() == d.to_bits() && b + c == 0.0;
    machine.rotor.bearings.iter().all(|bearing| same(bearing.stiffness) && same(bearing.damping))
}

impl GridSpacing {
    /// Scale of a machine's speeds; a grid with a given spacing is even.
    pub fn of(machine: &Machine, spacing: Option<f64>) -> Self {
        let law = machine.rotor.speed_law.iter().flat_map(|law| law.speeds.iter().copied());
        let even = spacing.map(|spacing| Self { spacing, closes: false });
        even.unwrap_or_else(|| Self::reaching(machine, law.fold(machine.rotor.initial_speed, f64::max)))
    }

    /// Scale for a machine up to a speed \[rad/s\].
    pub fn reaching(machine: &Machine, speed: f64) -> Self {
        let spacing = libm::exp2(libm::round(libm::log2(speed.max(1.0) / BASES_PER_INITIAL_SPEED)));
        Self { spacing, closes: !is_isotropic(machine) }
    }

    /// The largest b with W_b at most a speed.
    pub fn below(&self, speed: f64) -> i64 {
        libm::floor(self.place(speed) - 0.5) as i64
    }

    /// W_b.
    pub fn speed(&self, b: i64) -> f64 {
        let place = b as f64 + 0.5;
        if self.closes {
            2.0 * self.spacing * libm::sinh(place / (2.0 * BASES_PER_INITIAL_SPEED))
        } else {
            place * self.spacing
        }
    }

    /// Of a station and the next one: how far they are apart.
    pub fn distance(&self, b: i64) -> f64 {
        if self.closes { self.speed(b + 1) - self.speed(b) } else { self.spacing }
    }

    /// b + 1/2 of a speed.
    fn place(&self, speed: f64) -> f64 {
        let parts = speed / self.spacing;
        if self.closes { 2.0 * BASES_PER_INITIAL_SPEED * libm::asinh(0.5 * parts) } else { parts }
    }

    /// The cell that has a speed, of so many from each station to the next.
    pub fn cell_of(&self, speed: f64, cells: i64) -> i64 {
        if !self.closes {
            return libm::floor((self.place(speed) - 0.5) * cells as f64) as i64;
        }
        let b = self.below(speed);
        let within = libm::floor((speed - self.speed(b)) / self.distance(b) * cells as f64) as i64;
        b * cells + within.clamp(0, cells - 1)
    }

    /// The station at which the chain of runs from a speed begins.
    pub fn anchor(&self, speed: f64) -> i64 {
        (libm::round(self.place(speed) / TOGETHER) * TOGETHER) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_is_in_its_cell() {
        for closes in [false, true] {
            let scale = GridSpacing { spacing: 4.0, closes };
            for n in -400..800 {
                let speed = 0.37 * f64::from(n) + 0.01;
                let index = scale.cell_of(speed, 40);
                let (b, j) = (index.div_euclid(40), index.rem_euclid(40) as f64);
                let width = scale.distance(b) / 40.0;
                let from = scale.speed(b) + j * width;
                assert!(speed > from - 1e-9 && speed < from + width + 1e-9, "{closes} {speed}: {from} {width}");
                assert!((scale.speed(b + 1) - scale.speed(b) - scale.distance(b)).abs() < 1e-12);
            }
        }
        let scale = GridSpacing { spacing: 4.0, closes: true };
        let apart = |speed: f64| scale.distance(scale.cell_of(speed, 1));
        assert!(apart(0.0) < 0.12 && (1.8..2.2).contains(&apart(150.0)), "{} {}", apart(0.0), apart(150.0));
    }
}
