//! Massless quasi-static radial spring instead of a ring, for reference cases.
//!
//! The force of step n follows from the positions at n-1, n and n+1, with radii r = |x| and depths `p = max(r - gap, 0)`:
//! ```text
//! F = -k p_n s e,    s = (p_{n+1} - p_{n-1})/(r_{n+1} - r_{n-1}),    e = (x_{n+1} + x_{n-1})/(r_{n+1} + r_{n-1})                (1)
//! V(n+1/2) = k p_n p_{n+1}/2;    e . (x_{n+1} - x_{n-1}) = r_{n+1} - r_{n-1}   =>   F . (x_{n+1} - x_{n-1})/2 = V(n-1/2) - V(n+1/2)
//! ```
//! The work over a step thus equals the change of V to the last digit, wherever contact begins or ends. Within contact s = 1, and e is the direction
//! of `x_n` up to `dt^2`. Where contact begins or ends, s is the fraction of the radial path on which the spring acts. With s = 1 each beginning
//! would remove, and each end would add, up to `k (v dt)^2/8` of energy. The energy of a bouncing rotor would then follow a random walk.
//! Source: discrete gradients (Gonzalez 1996) of V; the scheme is otherwise that of `stepper`.
//! Limits: e rotates the force away from the centre by angles of the order of `r'' dt^2/2`, which cancel over a bounce. The angular momentum about
//! the centre is conserved to second order, not to the last digit.
//! Verified by `bouncing_rubs_keep_their_energy_at_the_default_step` and `a_bounce_on_a_spring_converges_with_order_two` in
//! `tests/contact/bounce.rs`, `annular_rub_radius_converges_with_order_two` in `tests/contact/rub.rs`.

use super::axes::{directions, on_rotor};
use super::bodies::Bodies;
use super::rounds::{Rounds, TOLERANCE, Work};
use super::step_contact::{ContactFailure, StepContact};
use crate::contact::{ContactReaction, Gap, Place, polar_gap};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_model::machine::FrictionLaw;

/// Radial spring at one diaphragm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spring {
    /// Spring stiffness k \[N/m\].
    pub stiffness: f64,
    /// Clearance \[m\].
    pub gap: f64,
}

impl Spring {
    /// Corrects the predicted increments for the force (1). Friction, and the force where contact begins or ends, depend on the step.
    pub fn correct(
        &self,
        bodies: &mut Bodies<'_>,
        line: &mut ShaftLine<'_>,
        (time, x_n): (f64, [f64; 2]),
        d: &mut Increments,
        work: &mut Work,
    ) -> Result<Option<StepContact>, ContactFailure> {
        let radius = bodies.section.radius;
        let gap = polar_gap(&bodies.stator.surface, None, radius, x_n);
        if gap.value >= 0.0 {
            return Ok(None);
        }
        let before = bodies.section.increment(&line.lateral.stepper.previous);
        let (full, x_before) = (-self.stiffness * gap.value, [x_n[0] - before[0], x_n[1] - before[1]]);
        let (mut sign, mut force) = (0.0, ContactReaction { normal: full, tangential: 0.0, sticks: false });
        let mut rounds = Rounds::default();
        loop {
            work.iterations += 1;
            let free = &mut work.free;
            let driven = line.spin.driven();
            line.respond(time, d, free);
            let (gap, lean) = leaning(gap, x_before, bodies.after(x_n, d));
            let (outwards, tangent) = directions(&gap);
            let w_tt = -bodies.section.along(tangent, tangent) - bodies.section.rolling();
            let dragged = bodies.section.moved_by(tangent.map(|t| -force.tangential * t), bodies.after(x_n, free));
            let pushed = bodies.section.moved_by(outwards.map(|n| -full * lean * n), [0.0; 2]);
            let normal = full * lean * self.share(x_before, dragged, pushed);
            force.normal = normal;
            bodies.push(&ContactReaction { tangential: 0.0, ..force }, &gap, free);
            match bodies.law {
                FrictionLaw::Slip => {
                    if rounds.done == 0 {
                        sign = bodies.centred_slip(line, &gap, free).signum();
                    }
                    force.tangential = bodies.friction * normal * sign;
                }
                FrictionLaw::StickSlip => {
                    let dx = bodies.section.increment(&free.lateral);
                    let slip = tangent[0] * dx[0] + tangent[1] * dx[1] + radius * bodies.section.turn(&free.torsion);
                    let holding = -slip / w_tt;
                    let limit = bodies.friction * normal;
                    force.sticks = holding.abs() <= limit;
                    force.tangential = holding.clamp(-limit, limit);
                }
            }
            bodies.push(&ContactReaction { normal: 0.0, ..force }, &gap, free);
            line.spin.add_drive_torque(bodies.section.drive_torque(force.tangential) * radius);
            // the force does not close a gap, so rounding of the gap does not affect it
            let change = bodies.change(line, driven, (d, free), normal, 0.0);
            d.copy_from(free);
            if rounds.done > 0 && change <= TOLERANCE {
                if normal <= 0.0 {
                    return Ok(None);
                }
                let slip = bodies.centred_slip(line, &gap, d);
                return Ok(Some(StepContact {
                    force,
                    on_rotor: on_rotor(&force, &gap),
                    // the massless stator follows the rotor, so nothing penetrates
                    gap: Gap { value: 0.0, ..gap },
                    slip,
                    reversed: bodies.law == FrictionLaw::Slip && slip * sign < 0.0,
                    several_minima: false,
                    no_fixed_point: false,
                    points: 1,
                    friction_work: force.tangential * slip * line.dt,
                    normal_work: 0.0,
                    model_work: 0.0,
                }));
            }
            if !rounds.another(change) {
                return Err(ContactFailure::NoConvergence);
            }
        }
    }

    /// Fraction s of (1), from the position at n-1, the position at n+1 without normal force, and the displacement by the full force.
    fn share(&self, x_before: [f64; 2], x_free: [f64; 2], pushed: [f64; 2]) -> f64 {
        let before = libm::hypot(x_before[0], x_before[1]);
        let of_the_way = |share: f64| -> f64 {
            let next = libm::hypot(x_free[0] + share * pushed[0], x_free[1] + share * pushed[1]);
            let way = next - before;
            if way == 0.0 || before > self.gap && next > self.gap {
                return if next > self.gap { 1.0 } else { 0.0 };
            }
            (((next - self.gap).max(0.0) - (before - self.gap).max(0.0)) / way).clamp(0.0, 1.0)
        };
        // a larger force shortens the path in contact, so there is exactly one root
        let (mut low, mut high) = (0.0, 1.0);
        if of_the_way(high) >= high {
            return high;
        }
        while high - low > f64::EPSILON {
            let middle = 0.5 * (low + high);
            if of_the_way(middle) > middle { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    fn depth(&self, [x, y]: [f64; 2]) -> f64 {
        ((x * x + y * y).sqrt() - self.gap).max(0.0)
    }

    /// Potential between two successive rotor centres in the stator's frame, V of (1) \[J\].
    pub fn energy(&self, x: [f64; 2], next: [f64; 2]) -> f64 {
        0.5 * self.stiffness * self.depth(x) * self.depth(next)
    }
}

/// Gap at n with its direction replaced by e of (1), and the length of e.
fn leaning(gap: Gap, before: [f64; 2], next: [f64; 2]) -> (Gap, f64) {
    let sum = [before[0] + next[0], before[1] + next[1]];
    let (length, radii) =
        (libm::hypot(sum[0], sum[1]), libm::hypot(before[0], before[1]) + libm::hypot(next[0], next[1]));
    if length == 0.0 {
        return (gap, 1.0);
    }
    let place = Place { angle: (sum[1] / length, sum[0] / length), ..gap.place };
    (Gap { place, ..gap }, length / radii)
}
