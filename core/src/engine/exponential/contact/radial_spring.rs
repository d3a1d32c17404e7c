//! Massless radial spring in place of a ring: its force as an impulse at the beginning of each contact step.
//!
//! ```text
//! p    = |x| - gap,   x = x_m + S J                     penetration and centre of the rotor at n                            (1)
//! q    = p - e.S J                                      penetration of the modes alone                                      (2)
//! J_n  = h K d(q),    K = k/(1 + h k s),   s = e.S(e + J_t/J_n t)                                                           (3)
//! d(q) = mean of max(q + v t, 0) with the weights 1 - |t|/h, -h < t < h                                                     (4)
//! V    = mean of K max(q, 0)^2/2 on the straight line from q(n) to q(n+1)      energy of the spring in the step from n       (5)
//! ```
//! x_m: displacement of the rotor's modes at n \[m\]; S: displacement at n per impulse that a train of impulses lacks, static
//! corrections and truncated modes \[m/(N s)\]; k: stiffness \[N/m\]; e, t: unit vectors of x and across; J = -(J_n e + J_t t):
//! impulse on the rotor \[N s\]; v: rate of q at n.
//!
//! Inside the spring d(q) = q, and the impulse is h times the force at n. S makes the scheme of fourth order for a linear
//! spring: `(k/m) h^2 S` is that of Numerov's method. Within |v| h of the gap, (4) is the impulse of the part of the step in
//! which the spring acts. Without (4) each begin and each end of a contact changes the energy by up to `k (v h)^2/8`, at random.
//!
//! Source: impulses of a potential that is integrated along straight lines (discrete variational integrators), with the static
//! correction of [`super::impulsed_ring`]. Limits: the step is below `2/omega_max` of the rotor held by the spring. Friction has
//! the direction of the slip over the step that it would have without friction. Verified by `tests/exponential/radial_spring.rs`.

use super::contact_step_result::{ContactStepResult, FreeStep, SurfaceTurn};
use super::stator_axes::StatorAxes;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::plane::{across, length, product, times, turned};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::structure::Structure;
use bladeoff_model::machine::{Contact, FrictionLaw};

/// Passes that find the direction e of (1): the impulse turns it by the flexibility S, a small part of the penetration.
const PASSES: usize = 4;

/// Radial spring of a diaphragm.
pub(crate) struct RadialSpring {
    axes: StatorAxes,
    /// k \[N/m\].
    stiffness: f64,
    contact: Contact,
    /// Contact step \[s\].
    h: f64,
    /// Displacement of the rotor's truncated modes per impulse, in the stator's axes \[m/(N s)\].
    truncated_flexibility: [[f64; 2]; 2],
    /// V of (5) in the last step \[J\].
    pub energy: f64,
    /// Whether an impulse acted in the last step.
    pub in_contact: bool,
    /// Share of the first impulse: half a step of its force lies before t = 0.
    share: f64,
    surface_turn: SurfaceTurn,
}

/// Impulse of a step, and the penetration that it follows from.
#[derive(Clone, Copy)]
pub(crate) struct SpringImpulse {
    /// e of (1).
    direction: [f64; 2],
    pub normal: f64,
    tangential: f64,
    sticks: bool,
    /// q of (2) \[m\], and K of (3) \[N/m\].
    depth: f64,
    stiffness: f64,
}

impl RadialSpring {
    /// Creates the spring of a contact around a rotor that starts at a place in the machine's axes, in contact steps of `h`.
    pub fn new(
        (axes, contact, stiffness): (StatorAxes, &Contact, f64),
        structure: &Structure,
        h: f64,
        (start, response): ([f64; 2], &ImpulseResponse),
    ) -> Self {
        let dofs = structure.rotor.plane_places(contact.node);
        let truncated = structure.lateral_residual.as_ref().map_or([[0.0; 2]; 2], |all| {
            turned(axes.angle, &dofs.map(|row| dofs.map(|column| all[(row, column)] / h)))
        });
        let mut spring = Self {
            axes,
            stiffness,
            contact: *contact,
            h,
            truncated_flexibility: truncated,
            energy: 0.0,
            in_contact: false,
            share: 0.5,
            surface_turn: SurfaceTurn::default(),
        };
        let x = axes.place(start);
        let flexibility = spring.flexibility(response);
        let direction = direction_of(x);
        let depth = (length(x) - contact.gap).max(0.0);
        spring.energy = 0.5 * spring.softened(product(direction, times(&flexibility, direction))) * depth * depth;
        spring
    }

    /// S of (1).
    fn flexibility(&self, response: &ImpulseResponse) -> [[f64; 2]; 2] {
        let mut sum = turned(self.axes.angle, &response.static_correction);
        for i in 0..2 {
            for j in 0..2 {
                sum[i][j] += self.truncated_flexibility[i][j];
            }
        }
        sum
    }

    /// K of (3) for a flexibility s \[m/(N s)\].
    fn softened(&self, flexibility: f64) -> f64 {
        self.stiffness / (1.0 + self.h * self.stiffness * flexibility)
    }

    /// Takes a step of free motion: the spring is not touched.
    pub fn pass(&mut self) {
        (self.energy, self.in_contact, self.share) = (0.0, false, 1.0);
        self.surface_turn.forget();
    }

    /// Passes a contact step in which the spring is not reached.
    pub fn pass_step(&mut self, surface_turn: f64) {
        (self.energy, self.in_contact, self.share) = (0.0, false, 1.0);
        self.surface_turn.take(surface_turn, self.h);
    }

    /// Distance from the gap at which (4) begins, for a velocity of the rotor at n \[m\].
    pub fn reach(&self, velocity: [f64; 2]) -> f64 {
        self.h * length(velocity)
    }

    /// Contact impulse on the rotor of an impulse of the spring.
    pub fn contact_impulse(&self, free: &FreeStep<'_>, found: &SpringImpulse) -> ContactImpulse {
        let (normal, tangential) = (self.share * found.normal, self.share * found.tangential);
        let (direction, tangent) = (found.direction, across(found.direction));
        let impulse = self.axes.to_machine([0, 1].map(|i| -(normal * direction[i] + tangential * tangent[i])));
        ContactImpulse {
            diaphragm: free.diaphragm,
            impulse,
            torque: -tangential * self.contact.rotor_radius,
            speed_jump: free.spin.speed_jump(impulse, &free.response.at_unbalances),
        }
    }

    /// Ends a contact step with an impulse of [`RadialSpring::find_impulse`]. Returns the contact of the step; `None` where nothing
    /// touches.
    pub fn finish_step(&mut self, free: &FreeStep<'_>, found: &SpringImpulse) -> Option<ContactStepResult> {
        let contact = self.contact_impulse(free, found);
        let SpringImpulse { direction, normal, tangential, sticks, depth, stiffness } = *found;
        let share = std::mem::replace(&mut self.share, 1.0);
        let (normal, tangential) = (share * normal, share * tangential);
        self.in_contact = normal > 0.0;
        let (tangent, impulse) = (across(direction), contact.impulse);
        // energy (5), with the penetration that the impulse leaves at n+1
        let response = free.response.displacement;
        let end = [0, 1].map(|i| free.end[i] + product(response[i], impulse));
        let before = self.energy;
        self.energy = stiffness * mean_square(depth, length(self.axes.place(end)) - self.contact.gap);
        if !self.in_contact {
            self.surface_turn.take(free.surface_turn, self.h);
            return None;
        }
        let radius = self.contact.rotor_radius;
        let motion = free.mean_motion(contact, &mut self.surface_turn, self.h);
        let velocity = self.axes.to_stator(motion.velocity);
        let slip = product(tangent, velocity) + radius * motion.surface_rate;
        Some(ContactStepResult {
            contact,
            normal,
            tangential,
            friction_work: tangential * slip,
            normal_work: normal * product(direction, velocity) - (self.energy - before),
            model_work: 0.0,
            damped_work: contact.torque * (motion.surface_rate - motion.rate),
            // the massless stator follows the rotor
            gap: 0.0,
            points: 1,
            sticks,
            reversed: self.contact.friction_law == FrictionLaw::Slip && slip * tangential < 0.0,
            no_fixed_point: false,
            angle: libm::atan2(direction[1], direction[0]),
            slip,
        })
    }

    /// Impulse (3) and its friction.
    pub fn find_impulse(&self, free: &FreeStep<'_>) -> SpringImpulse {
        let Self { axes, contact, h, .. } = self;
        let (modes, velocity) = (axes.place(free.start), axes.to_stator(free.velocity));
        let (response, flexibility) =
            (turned(axes.angle, &free.response.displacement), self.flexibility(free.response));
        let travel = axes.to_stator([free.end[0] - free.start[0], free.end[1] - free.start[1]]);
        let turn = contact.rotor_radius * free.surface_turn;
        let rolling = contact.rotor_radius * contact.rotor_radius * free.rolling;
        let mut found = SpringImpulse {
            direction: direction_of(modes),
            normal: 0.0,
            tangential: 0.0,
            sticks: false,
            depth: 0.0,
            stiffness: self.stiffness,
        };
        let mut impulse = [0.0; 2];
        for _ in 0..PASSES {
            let settled = times(&flexibility, impulse);
            let x = [modes[0] + settled[0], modes[1] + settled[1]];
            let e = direction_of(x);
            let t = across(e);
            let ratio = if found.normal > 0.0 { found.tangential / found.normal } else { 0.0 };
            let s = product(e, times(&flexibility, [e[0] + ratio * t[0], e[1] + ratio * t[1]]));
            let depth = length(x) - contact.gap - product(e, settled);
            let stiffness = self.softened(s);
            let normal = h * stiffness * smoothed(depth, h * product(e, velocity).abs());
            // slip over the step under the normal impulse alone, and per tangential impulse
            let pushed = times(&response, e);
            let slip = product(t, travel) - normal * product(t, pushed) + turn;
            let limit = contact.friction * normal;
            let (tangential, sticks) = match contact.friction_law {
                FrictionLaw::Slip => (limit * slip.signum(), false),
                FrictionLaw::StickSlip => {
                    let holding = slip / (product(t, times(&response, t)) + rolling);
                    (holding.clamp(-limit, limit), holding.abs() <= limit)
                }
            };
            impulse = [0, 1].map(|i| -(normal * e[i] + tangential * t[i]));
            found = SpringImpulse { direction: e, normal, tangential, sticks, depth, stiffness };
        }
        found
    }
}

/// Unit vector of a displacement; that of the x axis at the centre.
fn direction_of(x: [f64; 2]) -> [f64; 2] {
    let distance = length(x);
    if distance > 0.0 { x.map(|part| part / distance) } else { [1.0, 0.0] }
}

/// d(q) of (4); `width`: |v| h \[m\].
fn smoothed(depth: f64, width: f64) -> f64 {
    if depth >= width {
        return depth.max(0.0);
    }
    let cubed = |reach: f64| reach * reach * reach / (6.0 * width * width);
    match depth {
        _ if depth <= -width => 0.0,
        _ if depth < 0.0 => cubed(width + depth),
        _ => depth + cubed(width - depth),
    }
}

/// Mean of max(q, 0)^2/2 on the straight line between two penetrations.
fn mean_square(one: f64, other: f64) -> f64 {
    let (low, high) = (one.min(other), one.max(other));
    if low >= 0.0 {
        (one * one + one * other + other * other) / 6.0
    } else if high > 0.0 {
        high * high * high / (6.0 * (high - low))
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_passage_through_the_gap_has_the_work_of_the_spring() {
        // wherever the instants lie, the sum of d(q) v h up to n is V of the step from n
        for phase in [0.0, 0.13, 0.5, 0.77] {
            let (h, v) = (0.01, 3.0);
            let mut work = 0.0;
            for n in -5..40 {
                let q = (f64::from(n) + phase) * v * h;
                work += smoothed(q, v * h) * v * h;
                let energy = mean_square(q, q + v * h);
                assert!((work - energy).abs() < 1e-14, "phase {phase}, n {n}: {work} {energy}");
            }
            assert!(work > 0.5, "the spring is pressed");
        }
    }
}
