//! The beginning of a run: state and accelerations at t = 0, and the fictitious increments of the step before.

use super::{ShaftLine, distance, masses, norm};
use crate::linalg::{Matrix, dot};
use crate::rotor::Turn;
use crate::structure::Structure;
use crate::transient::prescribed::slope_of;

/// Rounds of the iteration for the accelerations at the start.
const ROUNDS: usize = 2000;

impl ShaftLine<'_> {
    /// Sets the state at n = 0 from coordinates, velocities and accelerations (increments of the step before are fictitious:
    /// `d- = dt v0 - dt^2 a0/2`, which makes the first step second order).
    pub fn start(&mut self, q: &[f64], velocity: &[f64], acceleration: &[f64], spin: f64, spin_acceleration: &[f64]) {
        let dt = self.dt;
        self.lateral.q.copy_from_slice(q);
        for i in 0..q.len() {
            self.lateral.previous[i] = dt * velocity[i] - 0.5 * dt * dt * acceleration[i];
        }
        for i in 0..self.rigid.len() {
            self.twist.previous[i] = dt * spin * self.rigid[i] - 0.5 * dt * dt * spin_acceleration[i];
        }
        self.lateral_map.expand(&self.lateral.q, &mut self.x);
        self.lateral_map.expand(&self.lateral.previous, &mut self.x_previous);
        self.twist_map.expand(&self.twist.previous, &mut self.psi_previous);
        self.refresh();
    }

    /// Replaces the fictitious increments before t = 0.
    pub fn restart(&mut self, previous: &[f64], twist_previous: &[f64]) {
        self.lateral.previous.copy_from_slice(previous);
        self.twist.previous.copy_from_slice(twist_previous);
        self.lateral_map.expand(&self.lateral.previous, &mut self.x_previous);
        self.twist_map.expand(&self.twist.previous, &mut self.psi_previous);
    }

    /// `(dt^2/2) M^-1 A = 1/2 + (dt/4) M^-1 C` of the lateral motion and of the twist: what the increments before t = 0 change by for
    /// a change of the centred ones; `None` where a mass matrix is singular.
    pub fn centring(&self, structure: &Structure) -> Option<[Matrix; 2]> {
        let (lateral_mass, twist_mass) = masses(structure, &self.unbalances);
        let half = |mass: &Matrix, damping: &Matrix| {
            let moved = crate::linalg::mul(&crate::linalg::inverse(mass)?, damping);
            Some(Matrix::identity(mass.nrows(), mass.nrows()) * 0.5 + moved * (0.25 * self.dt))
        };
        Some([half(&lateral_mass, &structure.lateral.damping)?, half(&twist_mass, &structure.twist.damping)?])
    }

    /// Forces in the instant of v, a, v_psi, a_psi at the place n.
    pub(super) fn instant_forces(&mut self) {
        for (site, turn) in self.unbalances.iter().zip(&mut self.turns) {
            *turn = Turn::instant(self.v_psi[site.twist_node], self.a_psi[site.twist_node]);
        }
        self.forces();
    }

    /// Accelerations at the start, from `M a = f(x0, v0, a) - C v0 - K x0`, in coordinates, and whether the iteration for them
    /// settled; `None` where a mass matrix is singular.
    ///
    /// The forces depend on the accelerations where an unbalance turns with the spin and where a disc tilts: a round gains
    /// a factor of about `m e^2/(J + m e^2)`. Below the rounding of the forces it settles to nothing.
    /// Verified by `a_start_that_does_not_settle_is_said`, `a_start_that_does_not_settle_fails` in `tests/rub.rs`.
    pub fn initial_acceleration(
        &mut self,
        structure: &Structure,
        q: &[f64],
        velocity: &[f64],
        spin: f64,
    ) -> Option<(Vec<f64>, Vec<f64>, bool)> {
        let (lateral_mass, twist_mass) = masses(structure, &self.unbalances);
        let (inverse, twist_inverse) = (crate::linalg::inverse(&lateral_mass)?, crate::linalg::inverse(&twist_mass)?);
        self.lateral_map.expand(q, &mut self.x);
        self.refresh();
        self.lateral_map.expand(velocity, &mut self.v);
        self.v_psi.fill(spin);
        let (mut a, mut a_twist) = (vec![0.0; q.len()], vec![0.0; self.rigid.len()]);
        let size = q.len();
        let mut next = vec![0.0; size];
        let mut next_twist = a_twist.clone();
        let brake = self.brake.at_start(spin);
        let mut last = f64::INFINITY;
        for _ in 0..ROUNDS {
            self.lateral_map.expand(&a, &mut self.a);
            self.twist_map.expand(&a_twist, &mut self.a_psi);
            self.instant_forces();
            if self.has_skew {
                for bearing in &self.rotor.bearings {
                    let skew = bearing.skew_force(self.rotor.at(bearing.node, &self.x));
                    self.rotor.add_at(bearing.node, skew, &mut self.force);
                }
            }
            self.lateral_map.project(&self.force, &mut self.force_q);
            for i in 0..size {
                let mut sum = self.force_q[i] + self.weight[i];
                for j in 0..size {
                    sum -= structure.lateral.stiffness[(i, j)] * q[j] + structure.lateral.damping[(i, j)] * velocity[j];
                }
                self.force_q[i] = sum;
            }
            self.twist_map.project(&self.torque, &mut self.torque_q);
            for (sum, s) in self.torque_q.iter_mut().zip(&self.spin_row) {
                *sum += brake * s;
            }
            crate::linalg::mul_vec(&inverse, &self.force_q, &mut next);
            crate::linalg::mul_vec(&twist_inverse, &self.torque_q, &mut next_twist);
            let mut direction = vec![0.0; next_twist.len()];
            crate::linalg::mul_vec(&twist_inverse, &self.spin_row, &mut direction);
            if spin == 0.0 {
                self.brake.hold_start(&self.spin_row, &direction, &mut next_twist);
            }
            if let Some(prescribed) = &self.prescribed {
                let wanted = slope_of(&prescribed.law, 0.0);
                let missing = (wanted - dot(&self.spin_row, &next_twist)) / dot(&self.spin_row, &direction);
                crate::linalg::axpy(missing, &direction, &mut next_twist);
            }
            let change = distance(&next, &a) + distance(&next_twist, &a_twist);
            let scale = norm(&next) + norm(&next_twist);
            std::mem::swap(&mut a, &mut next);
            std::mem::swap(&mut a_twist, &mut next_twist);
            if change <= 1e-13 * scale {
                return Some((a, a_twist, true));
            }
            last = change;
        }
        let settled = last <= self.rounding_of_accelerations(structure, &inverse, q, velocity);
        Some((a, a_twist, settled))
    }

    /// What rounding of the forces leaves of the accelerations at the start: `8 eps |M^-1| (|K| |q| + |C| |v| + |w|)`.
    fn rounding_of_accelerations(&self, structure: &Structure, inverse: &Matrix, q: &[f64], velocity: &[f64]) -> f64 {
        let size = q.len();
        let part = &structure.lateral;
        let forces: Vec<f64> = (0..size)
            .map(|i| {
                let terms = (0..size)
                    .map(|j| (part.stiffness[(i, j)] * q[j]).abs() + (part.damping[(i, j)] * velocity[j]).abs());
                terms.sum::<f64>() + self.weight[i].abs()
            })
            .collect();
        let rows = (0..size).map(|i| (0..size).map(|j| inverse[(i, j)].abs() * forces[j]).sum::<f64>());
        8.0 * f64::EPSILON * norm(&rows.collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    /// Whether the start of a Jeffcott rotor (m = k = 1, unbalance 1 at 0.5) with such an inertia of its spin settles.
    fn settles(inertia: f64) -> bool {
        let text = format!(
            "schema = 1\nname = \"start\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 0\n\
             polar_inertia = {inertia:?}\ninitial_speed = 1\n[rotor.bearings.spring]\nstiffness = 1\n\
             [rotor.unbalances.mass]\nmass = 1\nradius = 0.5\n"
        );
        let machine = MachineDef::parse("start.toml", &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut line = ShaftLine::new(&machine, &structure, 1e-3).expect("regular");
        let (a, a_twist, settled) =
            line.initial_acceleration(&structure, &[0.1, 0.2], &[0.3, 0.0], 1.0).expect("regular");
        assert!(a.iter().chain(&a_twist).all(|value| value.is_finite()));
        settled
    }

    #[test]
    fn a_start_that_does_not_settle_is_said() {
        // a round gains a factor of m e^2/(J + m e^2)
        assert!(settles(1.0) && settles(0.05));
        assert!(!settles(1e-4));
    }
}
