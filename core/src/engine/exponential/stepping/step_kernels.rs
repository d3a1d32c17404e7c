//! A step's motion without contact, in two kernels: to n+1 as it is foreseen, and what happened on the way.
//!
//! ```text
//! set out    spin and twist foretold, forces in the middle of the step, y+ under them, what is read from it             [`Spin::predict`], [`Propagator::advance`]
//! arrive     what an impulse at n has made, momentum and spin at n+1, what was foretold wrongly as an impulse there    [`Spin::complete`], [`Local::strike`]
//! ```
//! Each part is a plain function of its own file, put into one of these two so that vectors are chosen twice a step.

use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::modal::interval_model::{IntervalModel, add_both};
use crate::engine::exponential::modal::propagator::Propagator;
use crate::engine::exponential::torsion::spin::{ContactImpulse, Spin, SpinStep};
use crate::linalg::lanes::kernel;

kernel! {
    /// Takes spin, whirl states and outputs to n+1 as if nothing were touched.
    pub(crate) fn propagate_kernel(
        spin: &mut Spin,
        step: &SpinStep,
        propagator: &Propagator,
        local: &IntervalModel,
        y: &mut [f64],
        seen: &mut [f64],
    ) {
        spin.predict(step);
        propagator.advance(spin.driving(), y);
        local.output_matrix.multiply_inline(y, seen);
    }
}

kernel! {
    /// Adds at n+1 what a blow at n has made, where whirl states are asked for before the step ends.
    pub(crate) fn impulse_kernel(
        spin: &mut Spin,
        step: &SpinStep,
        local: &IntervalModel,
        struck: (&ImpulseResponse, ContactImpulse),
        y: &mut [f64],
        seen: &mut [f64],
    ) {
        let (kick, blow) = struck;
        spin.apply_impulse(step, blow, &kick.at_unbalances);
        answer_to_impulse(spin, local, kick, y, seen);
        add_both(blow.impulse, &kick.outputs, seen);
        add_both(blow.impulse, &kick.states, y);
    }
}

kernel! {
    /// Ends the step with the gyroscopic momentum at n+1, and with what a blow at n has made, where that is not yet there.
    pub(crate) fn finish_kernel(
        spin: &mut Spin,
        step: &SpinStep,
        local: &IntervalModel,
        gyroscopic: f64,
        blow: Option<(&ImpulseResponse, ContactImpulse)>,
        y: &mut [f64],
        seen: &mut [f64],
    ) {
        if let Some((kick, blow)) = blow {
            spin.apply_impulse(step, blow, &kick.at_unbalances);
            answer_to_impulse(spin, local, kick, y, seen);
            add_both(blow.impulse, &kick.outputs, seen);
        }
        let velocities = &seen.as_chunks::<2>().0[..spin.unbalances()];
        spin.finish_step(step, velocities, gyroscopic);
        let blow = blow.map(|(kick, blow)| (blow.impulse, &kick.states));
        local.apply_impulses(spin.left(), blow, y, seen);
    }
}

/// What a blow makes of the unbalances' rates is felt by the rotor.
#[inline(always)]
fn answer_to_impulse(spin: &Spin, local: &IntervalModel, kick: &ImpulseResponse, y: &mut [f64], seen: &mut [f64]) {
    let lists = local.input_vectors.as_chunks::<2>().0.iter().zip(local.outputs_of_impulses.as_chunks::<2>().0);
    for (([at, late], [states, outputs]), (pushes, struck)) in spin.jumps().zip(&kick.of_unbalances).zip(lists) {
        add_both(at, states, y);
        add_both(at, outputs, seen);
        add_both(late, pushes, y);
        add_both(late, struck, seen);
    }
}
