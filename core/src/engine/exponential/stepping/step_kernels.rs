//! Kernels of a step: the free motion to n+1, and its completion.
//!
//! ```text
//! propagate   predicted spin and torsion, unbalance forces in the middle of the step, y(n+1) under them, outputs of y(n+1)
//! finish      response to the contact impulse at n, angular momentum and spin at n+1, error of the predicted spin as an impulse at n+1
//! ```
//! Each part is an inline function of its own file ([`Spin::predict`], [`Propagator::advance`], [`Spin::finish_step`],
//! [`IntervalModel::apply_impulses`]). They are compiled into these kernels so that the vector width is chosen once per kernel.

use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::modal::interval_model::{IntervalModel, add_both};
use crate::engine::exponential::modal::propagator::Propagator;
use crate::engine::exponential::torsion::spin::{ContactImpulse, Spin, SpinStep};
use bladeoff_numerics::linalg::lanes::kernel;

kernel! {
    /// Takes spin, modal state and outputs to n+1 as if nothing were touched.
    pub(crate) fn propagate_kernel(
        spin: &mut Spin,
        step: &SpinStep,
        propagator: &Propagator,
        model: &IntervalModel,
        y: &mut [f64],
        outputs: &mut [f64],
    ) {
        spin.predict(step);
        propagator.advance(spin.mid_step_forces(), y);
        model.output_matrix.multiply_inline(y, outputs);
    }
}

kernel! {
    /// Adds the response at n+1 to a contact impulse at n, where the modal state is needed before the step ends.
    pub(crate) fn impulse_kernel(
        spin: &mut Spin,
        step: &SpinStep,
        model: &IntervalModel,
        contact: (&ImpulseResponse, ContactImpulse),
        y: &mut [f64],
        outputs: &mut [f64],
    ) {
        let (response, impulse) = contact;
        spin.apply_impulse(step, impulse, &response.at_unbalances);
        add_unbalance_impulses(spin, model, response, y, outputs);
        add_both(impulse.impulse, &response.outputs, outputs);
        add_both(impulse.impulse, &response.states, y);
    }
}

kernel! {
    /// Ends the step with the gyroscopic momentum at n+1, and with the response to the only contact impulse at n where that is not
    /// yet added.
    pub(crate) fn finish_kernel(
        spin: &mut Spin,
        step: &SpinStep,
        model: &IntervalModel,
        gyroscopic: f64,
        contact: Option<(&ImpulseResponse, ContactImpulse)>,
        y: &mut [f64],
        outputs: &mut [f64],
    ) {
        if let Some((response, impulse)) = contact {
            spin.apply_impulse(step, impulse, &response.at_unbalances);
            add_unbalance_impulses(spin, model, response, y, outputs);
            add_both(impulse.impulse, &response.outputs, outputs);
        }
        let velocities = &outputs.as_chunks::<2>().0[..spin.unbalance_count()];
        spin.finish_step(step, velocities, gyroscopic);
        let contact = contact.map(|(response, impulse)| (impulse.impulse, &response.states));
        model.apply_impulses(spin.correction_impulses(), contact, y, outputs);
    }
}

/// Adds the response of the lateral motion to the change of the unbalances' rates by a contact impulse.
#[inline(always)]
fn add_unbalance_impulses(
    spin: &Spin,
    model: &IntervalModel,
    response: &ImpulseResponse,
    y: &mut [f64],
    outputs: &mut [f64],
) {
    let lists = model.input_vectors.as_chunks::<2>().0.iter().zip(model.outputs_of_impulses.as_chunks::<2>().0);
    for (([first, second], [states, state_outputs]), (input_vectors, vector_outputs)) in
        spin.response_impulses().zip(&response.of_unbalances).zip(lists)
    {
        add_both(first, states, y);
        add_both(first, state_outputs, outputs);
        add_both(second, input_vectors, y);
        add_both(second, vector_outputs, outputs);
    }
}
