//! Unbalance: a mass on the rotor away from its axis, added or lost.
//!
//! ```text
//! psi = phi + beta_t + a
//! 2T  = m [(u' - d psi' sin psi)^2 + (v' + d psi' cos psi)^2]                       (1)
//! u row    m (u'' - d psi'' sin psi - d psi'^2 cos psi)                              (2)
//! v row    m (v'' + d psi'' cos psi - d psi'^2 sin psi)
//! twist    m d^2 psi'' + m d (-u'' sin psi + v'' cos psi)
//! gravity  twist + m d (-g_x sin psi + g_y cos psi)                                   (3)
//! ```
//! k is the node where the mass pulls, t the one with which it turns: the same, or that of a disc that carries it and stands elsewhere (a
//! row of blades beside its hub). The arm does not tilt with the disc.
//! Source: docs/theory/01-shaft-line.md. `m` is negative for a lost mass. The terms with constant coefficients (`m u''`, `m v''`,
//! `m d^2 psi''`) are part of the mass matrices of a run; the rest are forces, evaluated here.
//!
//! Over a step the mass is taken where it is, at `p = (u + d cos psi, v + d sin psi)`, and no derivative of psi is formed:
//! ```text
//! p''    = (p+ - 2 p + p-)/dt^2                                                        (4)
//! lever  = d [e(psi+) - e(psi-)]/(psi+ - psi-),   twist row  m lever.(p'' - g)          (5)
//! ```
//! Both tend to (2) and (3) with the square of the step, and their work over a step is exactly the change of `m |p'|^2/2` and
//! of the potential: with (2) at n instead, a drive that holds the speed would put in `(psi' dt)^2/12` of its work too much.
//! Verified by `forces_are_the_derivative_of_the_lagrangian` (`engine/shaft_line/lagrangian_tests.rs`), the tests below and the
//! Jeffcott cases.

use bladeoff_model::machine::Unbalance;

/// One unbalance at its node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalanceSite {
    /// Node k.
    pub node: usize,
    /// Node t, with which it turns.
    pub twist_node: usize,
    /// Mass \[kg\], negative for a lost mass.
    pub mass: f64,
    /// Eccentricity d \[m\].
    pub radius: f64,
    /// Phase a \[rad\].
    pub phase: f64,
}

/// Force of the terms that are not part of the mass matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalanceForce {
    /// On u and v \[N\].
    pub force: [f64; 2],
    /// On the twist row \[N m\].
    pub torque: f64,
}

impl UnbalanceSite {
    /// From the machine.
    #[must_use]
    pub fn new(unbalance: &Unbalance) -> Self {
        Self {
            node: unbalance.node,
            twist_node: unbalance.twist_node,
            mass: unbalance.signed_mass(),
            radius: unbalance.radius,
            phase: unbalance.phase,
        }
    }

    /// Forces (4), (5), or (2), (3) with [`Turn::instant`], at sine and cosine of `psi`, the node's acceleration \[m/s2\] and
    /// gravity \[m/s2\].
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
        // the lever's direction is psi + 90 degrees, turned by half the change of the increment
        let (lever_x, lever_y) = (-(sin * along + cos * across), cos * along - sin * across);
        UnbalanceForce {
            force: [md * (turn.tangential * sin + turn.radial * cos), md * (turn.radial * sin - turn.tangential * cos)],
            torque: -md * ((ax - gx) * lever_x + (ay - gy) * lever_y) - md * self.radius * turn.excess,
        }
    }

    /// Kinetic energy of the mass between n and n+1 less its constant-coefficient part \[J\]: sine and cosine of psi at n, its
    /// increment, the node's increment \[m\] and the step \[s\].
    #[must_use]
    pub fn coupling_energy(&self, (sin, cos): (f64, f64), increment: f64, step: [f64; 2], dt: f64) -> f64 {
        let (half_sin, half_cos) = libm::sincos(0.5 * increment);
        let chord = 2.0 * half_sin;
        let (middle_sin, middle_cos) = (sin * half_cos + cos * half_sin, cos * half_cos - sin * half_sin);
        let coupling = chord * (step[1] * middle_cos - step[0] * middle_sin);
        let bent = 0.5 * self.radius * (chord - increment) * (chord + increment);
        self.mass * self.radius * (coupling + bent) / (dt * dt)
    }

    /// Potential energy of the eccentricity in gravity \[J\], the mean of both ends of a step; the part of the node itself is in
    /// the weight vector.
    #[must_use]
    pub fn gravity_energy(&self, (sin, cos): (f64, f64), increment: f64, gravity: [f64; 2]) -> f64 {
        let (turn_sin, turn_cos) = libm::sincos(increment);
        let (next_sin, next_cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
        -0.5 * self.mass * self.radius * (gravity[0] * (cos + next_cos) + gravity[1] * (sin + next_sin))
    }
}

/// How a unit arm at angle psi turns: its second derivative in the basis (along the arm, across it), and the lever of (5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Towards the axis, `psi'^2` \[1/s2\].
    pub radial: f64,
    /// Across, `psi''` \[1/s2\].
    pub tangential: f64,
    /// Length of the lever times cosine and sine of its angle from psi + 90 degrees; (1, 0) in an instant.
    pub lever: (f64, f64),
    /// `lever . e'' - psi''`: what the mass matrix does not have \[1/s2\].
    pub excess: f64,
}

impl Turn {
    /// In an instant, of spin rate psi' and its derivative.
    #[must_use]
    pub fn instant(rate: f64, rate_dot: f64) -> Self {
        Self { radial: rate * rate, tangential: rate_dot, lever: (1.0, 0.0), excess: 0.0 }
    }

    /// Over a step, of the increments of psi before and after n \[rad\] and the step \[s\].
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
        /// Work of all forces on the mass over a step = change of its kinetic and potential energy.
        #[test]
        fn the_work_of_a_step_is_the_change_of_energy(
            psi in -3.0..3.0f64, before in -0.2..0.2f64, after in -0.2..0.2f64,
            step in prop::array::uniform4(-1e-2..1e-2f64), gravity in prop::array::uniform2(-10.0..10.0f64),
        ) {
            let dt = 1e-3;
            let site = UnbalanceSite { node: 0, twist_node: 1, mass: -2.5, radius: 0.3, phase: 0.0 };
            let (d0, d1) = ([step[0], step[1]], [step[2], step[3]]);
            let acceleration = [0, 1].map(|k| (d1[k] - d0[k]) / (dt * dt));
            let force = site.force(libm::sincos(psi), &Turn::stepped(before, after, dt), acceleration, gravity);
            // all of m p'' and m lever.(p'' - g), the constant-coefficient part with it
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

        /// The coupling energy is that of the mass as a point.
        #[test]
        fn the_energy_is_that_of_the_point(psi in -3.0..3.0f64, turn in -0.2..0.2f64, x in -1e-2..1e-2f64, y in -1e-2..1e-2f64) {
            let (dt, site) = (1e-3, UnbalanceSite { node: 0, twist_node: 1, mass: 2.0, radius: 0.3, phase: 0.0 });
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
