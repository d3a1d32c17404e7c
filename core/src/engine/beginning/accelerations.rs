//! Accelerations of the shaft line at t = 0.

use crate::engine::shaft_line::{ShaftLine, masses};
use crate::structure::Structure;
use bladeoff_numerics::linalg::{Matrix, distance, inverse, mul_vec, norm};

/// Maximum number of rounds of the iteration.
const ROUNDS: usize = 2000;

/// Initial accelerations on the coordinates.
#[derive(Debug)]
pub(super) struct Accelerations {
    /// Accelerations of the lateral coordinates.
    pub lateral: Vec<f64>,
    /// Accelerations of the torsional coordinates.
    pub torsion: Vec<f64>,
    /// Whether the iteration converged.
    pub settled: bool,
}

/// Accelerations at the start, from `M a = f(x0, v0, a) - C v0 - K x0`; `None` if a mass matrix is singular.
///
/// The forces depend on the accelerations if an unbalance turns with the spin or a disc tilts. Each round multiplies the error by about
/// `m e^2/(J + m e^2)`. Changes below the rounding of the forces count as converged.
/// Verified by `a_start_that_does_not_settle_is_said`, `a_start_that_does_not_settle_fails` in `tests/contact/rub.rs`.
pub(super) fn accelerations(
    line: &mut ShaftLine<'_>,
    structure: &Structure,
    q: &[f64],
    velocity: &[f64],
    spin: f64,
) -> Option<Accelerations> {
    let part = &structure.lateral;
    let (lateral_mass, torsional_mass) = masses(structure, line.unbalances());
    let (lateral_inverse, torsional_inverse) = (inverse(&lateral_mass)?, inverse(&torsional_mass)?);
    line.instant(q, velocity, spin);
    let (mut a, mut a_torsion) = (vec![0.0; q.len()], vec![0.0; line.torsion.size()]);
    let (mut next, mut next_torsion) = (a.clone(), a_torsion.clone());
    // distributed like the inertia: the static torsion takes the rest of the torques
    let on_spin = line.spin.brake.at_start(spin) + line.torque_before();
    let mut last = f64::INFINITY;
    for _ in 0..ROUNDS {
        line.instant_forces(&a, &a_torsion);
        for (i, force) in line.lateral.force_q.iter_mut().enumerate() {
            let mut sum = *force;
            for j in 0..q.len() {
                sum -= part.stiffness[(i, j)] * q[j] + part.damping[(i, j)] * velocity[j];
            }
            *force = sum;
        }
        for (torque, s) in line.torsion.force_q.iter_mut().zip(&line.spin.row) {
            *torque += on_spin * s;
        }
        mul_vec(&lateral_inverse, &line.lateral.force_q, &mut next);
        mul_vec(&torsional_inverse, &line.torsion.force_q, &mut next_torsion);
        let mut direction = vec![0.0; next_torsion.len()];
        mul_vec(&torsional_inverse, &line.spin.row, &mut direction);
        line.spin.hold_start(spin, &direction, &mut next_torsion);
        let change = distance(&next, &a) + distance(&next_torsion, &a_torsion);
        let scale = norm(&next) + norm(&next_torsion);
        std::mem::swap(&mut a, &mut next);
        std::mem::swap(&mut a_torsion, &mut next_torsion);
        if change <= 1e-13 * scale {
            return Some(Accelerations { lateral: a, torsion: a_torsion, settled: true });
        }
        last = change;
    }
    let settled = last <= rounding(line, structure, &lateral_inverse, q, velocity);
    Some(Accelerations { lateral: a, torsion: a_torsion, settled })
}

/// Rounding of the accelerations at the start due to that of the forces: `8 eps |M^-1| (|K| |q| + |C| |v| + |w|)`.
fn rounding(line: &ShaftLine<'_>, structure: &Structure, inverse: &Matrix, q: &[f64], velocity: &[f64]) -> f64 {
    let size = q.len();
    let part = &structure.lateral;
    let forces: Vec<f64> = (0..size)
        .map(|i| {
            let terms =
                (0..size).map(|j| (part.stiffness[(i, j)] * q[j]).abs() + (part.damping[(i, j)] * velocity[j]).abs());
            terms.sum::<f64>() + line.weight()[i].abs()
        })
        .collect();
    let rows = (0..size).map(|i| (0..size).map(|j| inverse[(i, j)].abs() * forces[j]).sum::<f64>());
    8.0 * f64::EPSILON * norm(&rows.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    /// Whether the start of a Jeffcott rotor (m = k = 1, unbalance 1 at 0.5) with this polar inertia converges.
    fn settles(inertia: f64) -> bool {
        let text = format!(
            "schema = 1\nname = \"start\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 0\n\
             polar_inertia = {inertia:?}\ninitial_speed = 1\n[rotor.bearings.spring]\nstiffness = 1\n\
             [rotor.unbalances.mass]\nmass = 1\nradius = 0.5\n"
        );
        let machine = MachineDef::parse("start.toml", &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut line = ShaftLine::new(&machine, &structure, 1e-3).expect("regular");
        let found = accelerations(&mut line, &structure, &[0.1, 0.2], &[0.3, 0.0], 1.0).expect("regular");
        assert!(found.lateral.iter().chain(&found.torsion).all(|value| value.is_finite()));
        found.settled
    }

    #[test]
    fn a_start_that_does_not_settle_is_said() {
        // each round multiplies the error by m e^2/(J + m e^2)
        assert!(settles(1.0) && settles(0.05));
        assert!(!settles(1e-4));
    }
}
