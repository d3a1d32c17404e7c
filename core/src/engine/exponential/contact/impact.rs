//! Contact of one step: its input, its result, and the rate of the rotor's surface that its friction work is taken with.
//!
//! ```text
//! W_f = J_t s',   s' = t.v + R theta' - t.w'      friction work of an impulse at n: v rotor's node, theta turn of its section, w ring       (1)
//! theta' = (theta(n+1) - theta(n-1))/2h                                                                                                  (2)
//! damped work = torque (theta' of (2) - mean of theta' before and after the impulse),   torque = -sum J_t R                                   (3)
//! ```
//! The friction law of a step has the displacement (2). The mean of the rates before and after an impulse is what the impulse does on the motion, exactly. The two agree for the spin and for undamped
//! torsional modes. A damped torsional mode decays between two impulses. Its damping therefore also acts on the saw-tooth of the rate that a train of impulses makes:
//!
//! ```text
//! a mode of unit inertia under a steady train J = T h, damping c:   mean of before and after = T (h/2) coth(ch/2),  mean of the step = T/c      (4)
//! ```
//! The difference is about T c h^2/12, and its power, about T^2 c h^2/12, is taken by the shaft's damping. With the mean rates in (1) a surface that rolls without slip had negative friction work: friction returned 0.016 J of 0.018 J to
//! the lab rig at 6.2 us where its ring stops it, now 0.0013 J at most. With (2) friction has the work of the slip that its law limits. The difference is booked as damping, so that the energy balance is unchanged.
//! Source: (4) is the steady state of `v+ = v- e^{-ch} + J`. Limit: the saw-tooth of bending modes is not separated, so the normal work still contains it.
//! Verified by `friction_of_a_rolling_surface_does_not_fall`, `coarse_and_fine_steps_agree_where_both_are_ok` (`tests/rolling.rs`).

use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::torsion::spin::Spin;

/// Impulses and works of the contact of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Impact {
    /// Impulse on the rotor, in the machine's axes \[N s\], and of the friction's torque \[N m s\].
    pub impulse: [f64; 2],
    pub torque: f64,
    /// Sums of normal and tangential impulses \[N s\], works of friction and of normal impulses, taken out \[J\].
    pub normal: f64,
    pub tangential: f64,
    pub friction_work: f64,
    pub normal_work: f64,
    /// Part of the work of the friction torque that the shaft's damping takes ([`SurfaceTurn`]) \[J\].
    pub damped_work: f64,
    /// Least gap that is left \[m\].
    pub gap: f64,
    pub points: usize,
    pub sticks: bool,
    pub reversed: bool,
    /// Angle and slip at the place with the largest normal impulse: \[rad\], \[m/s\].
    pub angle: f64,
    pub slip: f64,
}

/// The step without contact.
pub(crate) struct FreeStep<'a> {
    /// Places of the rotor at n and n+1, its velocity at n, in the machine's axes.
    pub start: [f64; 2],
    pub end: [f64; 2],
    pub velocity: [f64; 2],
    pub response: &'a ImpulseResponse,
    /// Turn of the rotor's surface over the step \[rad\], and per angular impulse; its rate at n \[rad/s\], and the jump of that per angular impulse.
    pub surface_turn: f64,
    pub rolling: f64,
    pub rate: f64,
    pub jump: f64,
    pub spin: &'a Spin,
}

/// Turn of the rotor's surface over contact steps that follow one another.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SurfaceTurn(Option<f64>);

impl SurfaceTurn {
    /// Takes a contact step of `h` \[s\] with its turn \[rad\]; the rate (2) at its beginning \[rad/s\], `None` where no contact step was before.
    #[inline(always)]
    pub fn take(&mut self, turn: f64, h: f64) -> Option<f64> {
        self.0.replace(turn).map(|before| 0.5 * (before + turn) / h)
    }

    /// A step that is no contact step has been made.
    pub fn forget(&mut self) {
        self.0 = None;
    }
}
