//! Sag of the rotor under its own weight, and Rayleigh's estimate of the first bending frequency.
//!
//! ```text
//! (K + K_skew) q = g M e           e: all nodes move by 1 along one axis, g = 9.80665 m/s2                  (1)
//! w^2 = q^T K q / q^T M q                                                                                    (2)
//! ```
//! (2) is an upper bound of the first frequency at rest. It is a few per cent too high if the static deflection resembles the first mode
//! shape. Source: Rayleigh's quotient with the static deflection. Limits: no gyroscopic moments and no damping. Verified by
//! `a_point_mass_sags_and_swings_in_closed_form`, and against the modes of the shipped machines by `the_estimate_is_near_the_first_mode`.

use super::unbalance::LinearRotor;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{Vector, solve};

/// Standard gravity \[m/s2\].
const GRAVITY: f64 = 9.80665;

/// A rotor under its weight normal to the shaft, regardless of the gravity in its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnderWeight {
    /// Largest sag of a node, in the softer direction \[m\].
    pub sag: f64,
    /// Estimate w (2) of the first bending frequency in that direction \[rad/s\].
    pub frequency: f64,
    /// Mass of the rotor \[kg\].
    pub mass: f64,
}

/// Returns sag and first bending frequency; `None` if the rotor is not supported.
#[must_use]
pub fn under_weight(machine: &Machine) -> Option<UnderWeight> {
    let rotor = LinearRotor::new(machine);
    let along = |axis: usize| {
        let mut unit = Vector::zeros(rotor.mass.nrows());
        (0..rotor.matrices.nodes).for_each(|node| unit[rotor.matrices.plane_places(node)[axis]] = 1.0);
        let mass = unit.dot(&(&rotor.mass * &unit));
        let deflection = solve(&rotor.stiffness, &(&rotor.mass * &unit * GRAVITY))?;
        let sag = (0..rotor.matrices.nodes).map(|node| {
            let [u, v] = rotor.matrices.plane_places(node).map(|dof| deflection[dof]);
            libm::hypot(u, v)
        });
        let sag = sag.fold(0.0, f64::max);
        let square = deflection.dot(&(&rotor.stiffness * &deflection)) / deflection.dot(&(&rotor.mass * &deflection));
        (sag.is_finite() && square > 0.0).then(|| UnderWeight { sag, frequency: square.sqrt(), mass })
    };
    let [x, y] = [along(0)?, along(1)?];
    Some(if x.sag >= y.sag { x } else { y })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::whirl_modes;
    use bladeoff_model::machine::MachineDef;

    fn machine(text: &str) -> Machine {
        MachineDef::parse("test.toml", text).expect("valid").build().expect("valid")
    }

    #[test]
    fn a_point_mass_sags_and_swings_in_closed_form() {
        let text = "schema = 1\nname = \"m\"\n[rotor]\nkind = \"point-mass\"\nmass = 1.5\npolar_inertia = 1.0\ninitial_speed = 1.0\n\
            [rotor.bearings.support]\nstiffness = [[400.0, 0.0], [0.0, 200.0]]\n\
            [rotor.unbalances.blade]\nmass = 0.5\nradius = 0.3\n[run]\nend_time = 1.0\n";
        let found = under_weight(&machine(text)).expect("held");
        assert!((found.sag / (2.0 * GRAVITY / 200.0) - 1.0).abs() < 1e-14, "{found:?}");
        assert!((found.frequency / 10.0 - 1.0).abs() < 1e-14, "{found:?}");
    }

    #[test]
    fn the_estimate_is_near_the_first_mode() {
        for text in [
            include_str!("../../../studies/machines/lab_rig.toml"),
            include_str!("../../../studies/machines/lp_turbine_paper.toml"),
        ] {
            let machine = machine(text);
            let found = under_weight(&machine).expect("held");
            let first = whirl_modes(&machine, &[0.0]).expect("solvable")[0].1[0].frequency;
            let ratio = found.frequency / first;
            assert!((0.999..1.05).contains(&ratio), "{ratio}: {found:?}");
            assert!(found.sag > 1e-6 && found.sag < 0.01, "{found:?}");
        }
    }
}
