//! Contact of one step: its input, its result, and the surface rate of its friction work.
//!
//! ```text
//! W_f = J_t s',   s' = t.v + R theta' - t.w'                friction work of an impulse at n                                     (1)
//! theta' = (theta(n+1) - theta(n-1))/2h                                                                                          (2)
//! W_d = tau (theta' of (2) - mean of theta' before and after the impulse),   tau = -sum J_t R                                   (3)
//! ```
//! v: velocity of the rotor's node; theta: angle of its section; w': velocity of the ring; R: radius of the rotor; t: tangent of
//! the point; W_d: part of the friction torque's work that damping of the torsion takes.
//!
//! The friction law of a step limits the displacement in (2). The mean of the rates before and after an impulse is exactly the
//! work of the impulse on the motion. Both agree for the spin and for undamped torsional modes. A damped torsional mode decays
//! between two impulses, so its damping also acts on the saw-tooth of the rate that a train of impulses makes:
//!
//! ```text
//! mode of unit inertia, damping c, train J = T h:   mean of before and after = T (h/2) coth(c h/2),   mean of the step = T/c     (4)
//! ```
//! The difference is about T c h^2/12. Its power, about T^2 c h^2/12, is taken by the shaft's damping. With the mean rates in (1)
//! a surface that rolls without slip had negative friction work: 0.016 J of 0.018 J came back on the lab rig at 6.2 us where its
//! ring stops it, now 0.0013 J at most. With (2) friction has the work of the slip that its law limits. (3) is booked as damping,
//! so the energy balance is unchanged.
//!
//! Source: (4) is the steady state of `v+ = v- e^{-c h} + J`. Limits: the saw-tooth of bending modes is not separated, so the
//! normal work still contains it. Verified by `friction_of_a_rolling_surface_does_not_fall`,
//! `coarse_and_fine_steps_agree_and_are_ok` (`tests/contact/rolling.rs`).

use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::plane::product;
use crate::engine::exponential::torsion::spin::{ContactImpulse, Spin};

/// Result of a contact step: sums of its impulses, their works, and the contact with the largest normal impulse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactStepResult {
    /// Impulse on the rotor, in the machine's axes.
    pub contact: ContactImpulse,
    /// Sums of the normal and of the tangential impulses \[N s\].
    pub normal: f64,
    pub tangential: f64,
    /// Works of friction and of normal impulses, positive where they leave the motion \[J\].
    pub friction_work: f64,
    pub normal_work: f64,
    /// Work of the normal impulse of `hyp1` on its moving place \[J\] ([`super::single_place`]).
    pub model_work: f64,
    /// W_d of (3) \[J\].
    pub damped_work: f64,
    /// Smallest gap that is left \[m\].
    pub gap: f64,
    /// Number of points with an impulse; whether all of them stick; whether slip is against the assumed direction at one of them.
    pub points: usize,
    pub sticks: bool,
    pub reversed: bool,
    /// Whether one-point `hyp2` has the place without impulses, because no place is the nearest under its own impulse.
    pub no_fixed_point: bool,
    /// Angle of the point with the largest normal impulse in the stator's axes \[rad\], and slip rate there \[m/s\].
    pub angle: f64,
    pub slip: f64,
}

/// Contact step without contact at one diaphragm: the input of its contact. Displacements and turns include the impulses at the
/// other diaphragms.
#[derive(Clone, Copy)]
pub(crate) struct FreeStep<'a> {
    /// Index of the diaphragm, in the machine's order.
    pub diaphragm: usize,
    /// Displacements of the rotor at n and n+1 \[m\] and its velocity at n \[m/s\], in the machine's axes.
    pub start: [f64; 2],
    pub end: [f64; 2],
    pub velocity: [f64; 2],
    /// Response of the rotor to an impulse at n.
    pub response: &'a ImpulseResponse,
    /// Turn of the rotor's section over the step \[rad\], and per angular impulse \[rad/(N m s)\].
    pub surface_turn: f64,
    pub rolling: f64,
    /// Rate of turn of the section at n \[rad/s\], and its jump per angular impulse \[1/(kg m2)\].
    pub rate: f64,
    pub jump: f64,
    /// Half the jumps of velocity \[m/s\] and rate \[rad/s\] by the impulses at the other diaphragms.
    pub other_velocity: [f64; 2],
    pub other_rate: f64,
    /// Spin and torsion.
    pub spin: &'a Spin,
}

/// Motion of the rotor's surface at n: means of the rates before and after the impulses.
pub(crate) struct MeanMotion {
    /// Velocity of the rotor's centre in the machine's axes \[m/s\].
    pub velocity: [f64; 2],
    /// Rate of turn of its section, and that of (2), which friction works on \[rad/s\].
    pub rate: f64,
    pub surface_rate: f64,
}

impl FreeStep<'_> {
    /// Motion at n under a contact impulse, in contact steps of `h` \[s\].
    #[inline(always)]
    pub fn mean_motion(&self, contact: ContactImpulse, turn: &mut SurfaceTurn, h: f64) -> MeanMotion {
        let ContactImpulse { impulse, torque, speed_jump, .. } = contact;
        let jump = self.response.velocity_jump;
        let unbalance_jump = self.spin.contact_velocity_jump(contact, &self.response.at_unbalances);
        let velocity = [0, 1]
            .map(|i| self.velocity[i] + 0.5 * (product(jump[i], impulse) + unbalance_jump[i]) + self.other_velocity[i]);
        let rate = self.rate + 0.5 * (self.jump * torque + speed_jump) + self.other_rate;
        let surface_rate = turn.take(self.surface_turn + self.rolling * torque, h).unwrap_or(rate);
        MeanMotion { velocity, rate, surface_rate }
    }
}

/// Turn of the rotor's section over the last contact step \[rad\]; `None` after a step of free motion.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SurfaceTurn(Option<f64>);

impl SurfaceTurn {
    /// Replaces the turn by that of the present contact step of `h` \[s\]. Returns the rate (2) at n \[rad/s\]; `None` where the
    /// step before was free motion.
    #[inline(always)]
    pub fn take(&mut self, turn: f64, h: f64) -> Option<f64> {
        self.0.replace(turn).map(|before| 0.5 * (before + turn) / h)
    }

    /// Forgets the turn, after a step of free motion.
    pub fn forget(&mut self) {
        self.0 = None;
    }
}
