//! Unbalance: a mass on the rotor at a distance from its axis, added or lost.
//!
//! ```text
//! psi = phi + beta_t + a
//! 2T  = m [(u' - d psi' sin psi)^2 + (v' + d psi' cos psi)^2]                       (1)
//! u row    m (u'' - d psi'' sin psi - d psi'^2 cos psi)                              (2)
//! v row    m (v'' + d psi'' cos psi - d psi'^2 sin psi)
//! torsion  m d^2 psi'' + m d (-u'' sin psi + v'' cos psi)
//! gravity  torsion + m d (-g_x sin psi + g_y cos psi)                                   (3)
//! ```
//! phi: mean spin angle, beta_t: torsion angle of node t. The force acts at node k. The mass rotates with node t: node k, or the node of a
//! disc that carries the mass at a different axial position (a row of blades beside its hub). The radius arm does not tilt with the disc.
//! Source: docs/theory/01-shaft-line.md. `m` is negative for a lost mass. The terms with constant coefficients (`m u''`, `m v''`,
//! `m d^2 psi''`) are part of the mass matrices of a run; the other terms are forces, evaluated here.
//!
//! Over a step, the scheme uses the position of the mass `p = (u + d cos psi, v + d sin psi)` and forms no derivative of psi:
//! ```text
//! p''    = (p+ - 2 p + p-)/dt^2                                                        (4)
//! lever  = d [e(psi+) - e(psi-)]/(psi+ - psi-),   torsion row  m lever.(p'' - g)          (5)
//! ```
//! Both converge to (2) and (3) with the square of the step. Their work over a step equals the change of `m |p'|^2/2` and of the potential
//! exactly. With (2) at n instead, a drive that holds the speed would supply too much work, by a share of `(psi' dt)^2/12`. Verified by
//! `forces_are_the_derivative_of_the_lagrangian` (`engine/shaft_line/lagrangian_tests.rs`), the tests below and the Jeffcott cases.

use bladeoff_model::machine::Unbalance;

/// One unbalance at its node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalanceSite {
    /// Node k, on which the unbalance force acts.
    pub node: usize,
    /// Node t, with which the mass rotates.
    pub torsional_node: usize,
    /// Mass m \[kg\], negative for a lost mass.
    pub mass: f64,
    /// Eccentricity d \[m\].
    pub radius: f64,
    /// Phase a from the spin angle \[rad\], positive with positive spin.
    pub phase: f64,
}

/// Force of the terms outside the mass matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalanceForce {
    /// Force on u and v \[N\].
    pub force: [f64; 2],
    /// Torque on the torsional row of node t \[N m\].
    pub torque: f64,
}

impl UnbalanceSite {
    /// Takes the unbalance from the machine.
    #[must_use]
    pub fn new(unbalance: &Unbalance) -> Self {
        Self {
            node: unbalance.node,
            torsional_node: unbalance.torsional_node,
            mass: unbalance.signed_mass(),
            radius: unbalance.radius,
            phase: unbalance.phase,
        }
    }

    /// Force (4), (5), or (2), (3) with [`Turn::instant`]. Arguments: sine and cosine of `psi`, the rotation of the arm, acceleration of
    /// the node and gravity \[m/s2\].
    #[inline]
    #[must_use]
    pub fn force(
        &self,
        (sin, cos): (f64, f64),
        turn: &Turn,
        acceleration: [f64; 2],
        gravity: [f64; 2],
    ) -> UnbalanceForce {
        let md = self.mass * self.radius;
        let ([ax, ay], [gx, gy]) = (acceleration, gravity);
        let (along, across) = turn.lever;
        // direction of the lever: psi + 90 degrees, rotated by half the change of the increment
        let (lever_x, lever_y) = (-(sin * along + cos * across), cos * along - sin * across);
        UnbalanceForce {
            force: [md * (turn.tangential * sin + turn.radial * cos), md * (turn.radial * sin - turn.tangential * cos)],
            torque: -md * ((ax - gx) * lever_x + (ay - gy) * lever_y) - md * self.radius * turn.excess,
        }
    }

    /// Kinetic energy of the mass between n and n+1, without the constant-coefficient part \[J\]. Arguments: sine and cosine of psi at n,
    /// increment of psi \[rad\], displacement increment of the node \[m\], step \[s\].
    #[must_use]
    pub fn coupling_energy(&self, (sin, cos): (f64, f64), increment: f64, step: [f64; 2], dt: f64) -> f64 {
        let (half_sin, half_cos) = libm::sincos(0.5 * increment);
        let chord = 2.0 * half_sin;
        let (middle_sin, middle_cos) = (sin * half_cos + cos * half_sin, cos * half_cos - sin * half_sin);
        let coupling = chord * (step[1] * middle_cos - step[0] * middle_sin);
        let bent = 0.5 * self.radius * (chord - increment) * (chord + increment);
        self.mass * self.radius * (coupling + bent) / (dt * dt)
    }

    /// Potential energy of the eccentricity in gravity \[J\], mean of both ends of a step. The weight vector contains the potential energy
    /// of the node itself.
    #[must_use]
    pub fn gravity_energy(&self, (sin, cos): (f64, f64), increment: f64, gravity: [f64; 2]) -> f64 {
        let (turn_sin, turn_cos) = libm::sincos(increment);
        let (next_sin, next_cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
        -0.5 * self.mass * self.radius * (gravity[0] * (cos + next_cos) + gravity[1] * (sin + next_sin))
    }
}

/// Rotation of a unit arm at angle psi: its second derivative in the basis (along the arm, across it), and the lever of (5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Centripetal component `psi'^2` \[1/s2\], positive towards the axis.
    pub radial: f64,
    /// Tangential component `psi''` \[1/s2\].
    pub tangential: f64,
    /// Length of the lever times cosine and sine of its angle from psi + 90 degrees \[-\]; (1, 0) at an instant.
    pub lever: (f64, f64),
    /// Inertia term outside the mass matrix, `lever . e'' - psi''` \[1/s2\].
    pub excess: f64,
}

impl Turn {
    /// Rotation at an instant. `rate`: psi' \[rad/s\], `rate_dot`: psi'' \[rad/s2\].
    #[must_use]
    pub fn instant(rate: f64, rate_dot: f64) -> Self {
        Self { radial: rate * rate, tangential: rate_dot, lever: (1.0, 0.0), excess: 0.0 }
    }

    /// Rotation over a step. `before`, `after`: increments of psi before and after n \[rad\], `dt`: step \[s\].
    #[inline]
    #[must_use]
    pub fn stepped(before: f64, after: f64, dt: f64) -> Self {
        let ((s0, c0), (s1, c1)) = (libm::sincos(0.5 * before), libm::sincos(0.5 * after));
        let square = 1.0 / (dt * dt);
        // sine and cosine of the mean increment and of half the difference
        let (mean_sin, mean_cos) = (s1 * c0 + c1 * s0, c1 * c0 - s1 * s0);
        let (half_sin, half_cos) = (s1 * c0 - c1 * s0, c1 * c0 + s1 * s0);
        let mean = 0.5 * (before + after);
        let length = if mean.abs() < 1e-4 { 1.0 - mean * mean / 6.0 } else { mean_sin / mean };
        let radial = 2.0 * (s0 * s0 + s1 * s1);
        let tangential = 2.0 * mean_cos * half_sin;
        let excess = length * (tangential * half_cos + radial * half_sin) - (after - before);
        Self {
            radial: radial * square,
            tangential: tangential * square,
            lever: (length * half_cos, length * half_sin),
            excess: excess * square,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_short_step_turns_as_an_instant_with_order_two() {
        let (rate, rate_dot) = (150.0, 900.0);
        let exact = Turn::instant(rate, rate_dot);
        let error = |dt: f64| {
            let angle = |t: f64| rate * t + 0.5 * rate_dot * t * t;
            let turn = Turn::stepped(-angle(-dt), angle(dt), dt);
            let lever = (turn.lever.0 - 1.0).abs() + (turn.lever.1).abs();
            [(turn.radial - exact.radial).abs(), (turn.tangential - exact.tangential).abs(), lever, turn.excess.abs()]
        };
        let (coarse, fine) = (error(2e-3), error(1e-3));
        for (coarse, fine) in coarse.iter().zip(fine) {
            assert!((3.9..4.1).contains(&(coarse / fine)), "{coarse} {fine}");
        }
    }

    proptest! {
        /// The work of all forces on the mass over a step equals the change of its kinetic and potential energy.
        #[test]
        fn the_work_of_a_step_is_the_change_of_energy(
            psi in -3.0..3.0f64, before in -0.2..0.2f64, after in -0.2..0.2f64,
            step in prop::array::uniform4(-1e-2..1e-2f64), gravity in prop::array::uniform2(-10.0..10.0f64),
        ) {
            let dt = 1e-3;
            let site = UnbalanceSite { node: 0, torsional_node: 1, mass: -2.5, radius: 0.3, phase: 0.0 };
            let (d0, d1) = ([step[0], step[1]], [step[2], step[3]]);
            let acceleration = [0, 1].map(|k| (d1[k] - d0[k]) / (dt * dt));
            let force = site.force(libm::sincos(psi), &Turn::stepped(before, after, dt), acceleration, gravity);
            // complete terms m p'' and m lever.(p'' - g), with their constant-coefficient parts
            let inertia = site.mass * site.radius * site.radius;
            let lateral = [0, 1].map(|k| site.mass * acceleration[k] - force.force[k]);
            let torque = inertia * (after - before) / (dt * dt) - force.torque;
            let work = 0.5 * (lateral[0] * (d0[0] + d1[0]) + lateral[1] * (d0[1] + d1[1]) + torque * (before + after));
            let energy = |angle: f64, turn: f64, d: [f64; 2]| {
                let constant = 0.5 * (site.mass * (d[0] * d[0] + d[1] * d[1]) + inertia * turn * turn) / (dt * dt);
                constant
                    + site.coupling_energy(libm::sincos(angle), turn, d, dt)
                    + site.gravity_energy(libm::sincos(angle), turn, gravity)
            };
            let change = energy(psi, after, d1) - energy(psi - before, before, d0);
            let scale = energy(psi, after, d1).abs() + energy(psi - before, before, d0).abs() - inertia / (dt * dt);
            prop_assert!((work - change).abs() < 1e-12 * scale, "{work} {change}");
        }

        /// The coupling energy completes the kinetic energy of a point mass.
        #[test]
        fn the_energy_is_that_of_the_point(psi in -3.0..3.0f64, turn in -0.2..0.2f64, x in -1e-2..1e-2f64, y in -1e-2..1e-2f64) {
            let (dt, site) = (1e-3, UnbalanceSite { node: 0, torsional_node: 1, mass: 2.0, radius: 0.3, phase: 0.0 });
            let at = |angle: f64| [site.radius * angle.cos(), site.radius * angle.sin()];
            let (from, to) = (at(psi), at(psi + turn));
            let step = [x + to[0] - from[0], y + to[1] - from[1]];
            let whole = 0.5 * site.mass * (step[0] * step[0] + step[1] * step[1]) / (dt * dt);
            let constant = 0.5 * site.mass * (x * x + y * y + (site.radius * turn).powi(2)) / (dt * dt);
            let coupling = site.coupling_energy(libm::sincos(psi), turn, [x, y], dt);
            prop_assert!((whole - constant - coupling).abs() < 1e-12 * (whole + constant) + 1e-9);
        }
    }
}
