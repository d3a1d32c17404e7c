//! Massless quasi-static radial spring instead of a ring: reference cases.
//!
//! The force of step n follows from its three places, r = |x| their radii and `p = max(r - gap, 0)` their depths:
//! ```text
//! F = -k p_n s e,    s = (p_{n+1} - p_{n-1})/(r_{n+1} - r_{n-1}),    e = (x_{n+1} + x_{n-1})/(r_{n+1} + r_{n-1})                (1)
//! V(n+1/2) = k p_n p_{n+1}/2;    e . (x_{n+1} - x_{n-1}) = r_{n+1} - r_{n-1}   =>   F . (x_{n+1} - x_{n-1})/2 = V(n-1/2) - V(n+1/2)
//! ```
//! so that its work over a step is the change of V to the last digit, wherever contact begins or ends. Inside the spring s = 1, and e is
//! the direction of `x_n` up to `dt^2`: the spring of the place at n. Where contact begins or ends, s is the part of the way
//! on which the spring acts; with s = 1 there each beginning takes, and each end gives, up to `k (v dt)^2/8` that no store has, and
//! a rotor that bounces walks at random away from its energy.
//! Source: discrete gradients (Gonzalez 1996) of V; the scheme is otherwise that of `stepper`.
//! Limits: e turns the force from the centre by `r'' dt^2/2`-like angles, which cancel over a bounce: the moment about the centre is kept to
//! second order, not to the last digit.
//! Verified by `bouncing_rubs_keep_their_energy_at_the_default_step` and `a_bounce_on_a_spring_converges_with_order_two` in
//! `tests/bounce.rs`, `annular_rub_radius_converges_with_order_two` in `tests/rub.rs`.

use super::{ContactFailure, Rounds, Rub, StepContact, TOLERANCE, bilinear, directions, on_rotor};
use crate::contact::{ContactForce, Gap, Place, polar_gap};
use crate::linalg::dot;
use crate::transient::shaft_line::ShaftLine;
use bladeoff_model::machine::FrictionLaw;

impl Rub<'_> {
    /// Massless quasi-static spring: the force (1); where contact begins or ends, and for friction, it depends on the step.
    pub(super) fn spring_contact(
        &mut self,
        line: &mut ShaftLine<'_>,
        time: f64,
        stiffness: f64,
        x_n: [f64; 2],
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Result<Option<StepContact>, ContactFailure> {
        let gap = polar_gap(&self.surface, None, self.rotor_radius, x_n);
        if gap.value >= 0.0 {
            return Ok(None);
        }
        let (full, before) = (-stiffness * gap.value, self.increment(&line.lateral.previous));
        let x_before = [x_n[0] - before[0], x_n[1] - before[1]];
        let (mut sign, mut force) = (0.0, ContactForce { normal: full, tangential: 0.0, sticks: false });
        let mut rounds = Rounds::default();
        loop {
            self.iterations += 1;
            let mut free = std::mem::take(&mut self.candidate);
            let mut free_twist = std::mem::take(&mut self.candidate_twist);
            let driven = line.driven();
            line.respond(time, d, d_twist, &mut free, &mut free_twist);
            let (gap, lean) = leaning(gap, x_before, self.after(x_n, d));
            let (outwards, tangent) = directions(&gap);
            let w_tt = -bilinear(&self.compliance, tangent, tangent)
                - self.rotor_radius * self.rotor_radius * self.twist_compliance;
            let dragged = self.moved_by(tangent.map(|t| -force.tangential * t), self.after(x_n, &free));
            let pushed = self.moved_by(outwards.map(|n| -full * lean * n), [0.0; 2]);
            let normal = full * lean * self.share(x_before, dragged, pushed);
            force.normal = normal;
            self.apply(&ContactForce { tangential: 0.0, ..force }, &gap, &mut free, &mut free_twist);
            match self.law {
                FrictionLaw::Slip => {
                    if rounds.done == 0 {
                        sign = self.centred_slip(line, &gap, &free, &free_twist).signum();
                    }
                    force.tangential = self.friction * normal * sign;
                }
                FrictionLaw::StickSlip => {
                    let dx = self.increment(&free);
                    let slip =
                        tangent[0] * dx[0] + tangent[1] * dx[1] + self.rotor_radius * dot(&self.twist_row, &free_twist);
                    let holding = -slip / w_tt;
                    let limit = self.friction * normal;
                    force.sticks = holding.abs() <= limit;
                    force.tangential = holding.clamp(-limit, limit);
                }
            }
            self.apply(&ContactForce { normal: 0.0, ..force }, &gap, &mut free, &mut free_twist);
            line.add_drive_torque(self.drive_lever * force.tangential * self.rotor_radius);
            let change = self.change(line, driven, (d, d_twist), (&free, &free_twist), normal);
            d.copy_from_slice(&free);
            d_twist.copy_from_slice(&free_twist);
            (self.candidate, self.candidate_twist) = (free, free_twist);
            if rounds.done > 0 && change <= TOLERANCE {
                if normal <= 0.0 {
                    return Ok(None);
                }
                let slip = self.centred_slip(line, &gap, d, d_twist);
                return Ok(Some(StepContact {
                    force,
                    on_rotor: on_rotor(&force, &gap),
                    // the massless stator follows the rotor: nothing penetrates
                    gap: Gap { value: 0.0, ..gap },
                    slip,
                    reversed: self.law == FrictionLaw::Slip && slip * sign < 0.0,
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

    /// A place moved by a force on the rotor over the step.
    fn moved_by(&self, force: [f64; 2], from: [f64; 2]) -> [f64; 2] {
        let w = &self.compliance;
        std::array::from_fn(|axis| from[axis] + w[axis][0] * force[0] + w[axis][1] * force[1])
    }

    /// The share s of (1), from the places at n-1 and, without normal force, at n+1, and the way that the whole force would push it.
    fn share(&self, x_before: [f64; 2], x_free: [f64; 2], pushed: [f64; 2]) -> f64 {
        let before = x_before[0].hypot(x_before[1]);
        let of_the_way = |share: f64| -> f64 {
            let next = (x_free[0] + share * pushed[0]).hypot(x_free[1] + share * pushed[1]);
            let way = next - before;
            if way == 0.0 || before > self.gap && next > self.gap {
                return if next > self.gap { 1.0 } else { 0.0 };
            }
            (((next - self.gap).max(0.0) - (before - self.gap).max(0.0)) / way).clamp(0.0, 1.0)
        };
        // the more the spring pushes, the shorter is its part of the way: one root
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

    /// Potential of a radial spring between two successive rotor centres in the stator's frame, V of (1) \[J\].
    pub fn spring_energy(&self, x: [f64; 2], next: [f64; 2]) -> f64 {
        self.spring.map_or(0.0, |stiffness| 0.5 * stiffness * self.depth(x) * self.depth(next))
    }
}

/// The gap at n with its direction turned to e of (1), and the length of e.
fn leaning(gap: Gap, before: [f64; 2], next: [f64; 2]) -> (Gap, f64) {
    let sum = [before[0] + next[0], before[1] + next[1]];
    let (length, radii) = (sum[0].hypot(sum[1]), before[0].hypot(before[1]) + next[0].hypot(next[1]));
    if length == 0.0 {
        return (gap, 1.0);
    }
    let place = Place { angle: (sum[1] / length, sum[0] / length), ..gap.place };
    (Gap { place, ..gap }, length / radii)
}
