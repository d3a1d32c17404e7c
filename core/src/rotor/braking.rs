//! Torque that decelerates the disconnected shaft line.

use bladeoff_model::machine::Braking;

/// Braking torque on the spin.
///
/// ```text
/// T = -(c0 sign(W) + c1 W + c2 W|W|)       W inertia-weighted mean spin [rad/s]
/// ```
/// Source: docs/theory/01-shaft-line.md (paper, section 3: aerodynamic and Newtonian fluid friction).
/// It acts as `T s_i` on node i with the weights `s = j/J_t`, so that its power is `T W <= 0`.
///
/// # Returns
/// T \[N m\], opposite to W; 0 at W = 0 (the transient treats the effect of c0 at rest).
/// # Verified by
/// `braking_always_takes_energy`
#[must_use]
pub fn braking_torque(braking: &Braking, speed: f64) -> f64 {
    if speed == 0.0 {
        return 0.0;
    }
    -(braking.constant * speed.signum() + braking.linear * speed + braking.quadratic * speed * speed.abs())
}

/// Coulomb part of [`braking_torque`], independent of the magnitude of W: `-c0 sign(W)` \[N m\].
#[must_use]
pub fn constant_torque(braking: &Braking, speed: f64) -> f64 {
    if speed == 0.0 { 0.0 } else { -braking.constant * speed.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braking_always_takes_energy() {
        let braking = Braking { constant: 2.0, linear: 3.0, quadratic: 0.5 };
        for speed in [-10.0, -0.1, 0.1, 10.0] {
            assert!(braking_torque(&braking, speed) * speed < 0.0);
        }
        assert!((braking_torque(&braking, 2.0) + 10.0).abs() < 1e-15);
        assert!(braking_torque(&braking, 0.0).abs() < f64::MIN_POSITIVE);
    }
}
