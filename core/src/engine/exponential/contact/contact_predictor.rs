//! Ring and rotor at n+1 as though the impulses of n-1 went on.
//!
//! ```text
//! lacking   of a train J = F h at n: what it lacks of the static displacement, on each mode of the ring and of the rotor, and the modes left out of both      (1)
//! at n+1    impulses J_n and their statics, which are those of the force at n+1:  (what they move by n+1) J_n + lacking (2 J_n - J_(n-1))                     (2)
//! places    from (2) with J_n = J_(n-1), at their places now:  s_n of the ring's modes,  s_x of the rotor                                                   (3)
//! undone    what (3) has of J_n:  (what they move by n+1 + 2 lacking) J_(n-1).  The linear conditions on J_n go on from there
//! ```
//! (3): in the free step ring and rotor are where no impulse of this step is, and a light rub's penetrate there by 0.2 mm. Places and normals taken from it had an error of first order (impulse of a long rub 2e-3 off at 40 us, 5e-4 with (3));
//! in a whip they jumped from step to step. (2): with the statics of J_n instead the force ran ahead of the gap by a step, on that share of the compliance, which damps in proportion to the step: loads and impulses
//! of beginnings of rubs were too small on every machine. Limit: statics of the ring's modes left out are not in the places.
//! Verified by `whip_is_that_of_the_reduced_engine` (`tests/exponential_run.rs`), `random_machines_rub_as_in_the_reduced_engine`.

use super::broad_phase::GapMinimum;
use super::impulsed_ring::STATIC_WEIGHT;
use super::ring_kernels::add_two;
use crate::contact::ContactForce;
use crate::engine::exponential::plane::{across, times};
use crate::linalg::eight::Eight;
use crate::linalg::lanes::{Lane, flat};

/// What is known of n+1 before its impulses.
pub(crate) struct ContactPredictor {
    /// What impulses make of the ring's modes by n+1, with (1), and (1) alone \[1/kg\].
    compliance: Vec<Lane>,
    static_correction: Vec<Lane>,
    /// Sums of the last impulses along the rows of their places, and in the plane: of all parts, and of the normal ones.
    modal_impulses: Vec<Lane>,
    impulse: [f64; 2],
    normal_impulse: [f64; 2],
    /// The ring's modes with s_n, what of them is undone, and their way over the step less the change of (1) of a train that goes on.
    pub ring: Vec<Lane>,
    pub ring_correction: Vec<Lane>,
    pub ring_travel: Vec<Lane>,
    /// s_x, what is undone of it, and that change of the rotor \[m\].
    pub rotor_displacement: [f64; 2],
    pub rotor_correction: [f64; 2],
    pub rotor_travel_correction: [f64; 2],
}

impl ContactPredictor {
    /// Of a ring whose modes' trains lack this.
    pub fn new([yields, lacking]: [Vec<Lane>; 2]) -> Self {
        let zeros = vec![Lane::default(); lacking.len()];
        Self {
            compliance: yields,
            static_correction: lacking,
            modal_impulses: zeros.clone(),
            impulse: [0.0; 2],
            normal_impulse: [0.0; 2],
            ring: zeros.clone(),
            ring_correction: zeros.clone(),
            ring_travel: zeros,
            rotor_displacement: [0.0; 2],
            rotor_correction: [0.0; 2],
            rotor_travel_correction: [0.0; 2],
        }
    }

    /// Nothing presses any more.
    #[inline(always)]
    pub fn reset(&mut self) {
        self.modal_impulses.fill(Lane::default());
        (self.impulse, self.normal_impulse) = ([0.0; 2], [0.0; 2]);
    }

    /// Something presses at a place, of which these are the rows.
    #[inline(always)]
    pub fn add_impulse<V: Eight>(&mut self, position: &GapMinimum, force: &ContactForce, rows: [&[Lane]; 2]) {
        add_two::<V>([force.normal, force.tangential], rows, &mut self.modal_impulses);
        let (n, t) = (position.normal, across(position.normal));
        for i in 0..2 {
            self.normal_impulse[i] += n[i] * force.normal;
            self.impulse[i] += n[i] * force.normal + t[i] * force.tangential;
        }
    }

    /// From what pressed: the ring at n+1 without impulses and its way there are given; what an impulse on the rotor moves it by n+1, what its trains lack, and its
    /// modes left out, in the stator's axes.
    #[inline(always)]
    pub fn predict<V: Eight>(
        &mut self,
        ring: &[Lane],
        ring_travel: &[Lane],
        [moves, lacking, left_out]: [&[[f64; 2]; 2]; 3],
    ) {
        let count = ring.len();
        let (yields, lacks, pressed) =
            (&self.compliance[..count], &self.static_correction[..count], &self.modal_impulses[..count]);
        let (undone, foreseen) = (&mut self.ring_correction[..count], &mut self.ring[..count]);
        let (gone, ring_travel) = (&mut self.ring_travel[..count], &ring_travel[..count]);
        for i in 0..count {
            let pressed = V::load(&pressed[i]);
            let (held, lacks) = (V::load(&yields[i]) * pressed, V::load(&lacks[i]) * pressed);
            (V::load(&ring[i]) + held).store(&mut foreseen[i]);
            (held + lacks).store(&mut undone[i]);
            (V::load(&ring_travel[i]) - V::all(STATIC_WEIGHT) * lacks).store(&mut gone[i]);
        }
        let (moved, lagging) = (times(moves, self.impulse), times(lacking, self.impulse));
        let left_out = times(left_out, self.normal_impulse);
        for i in 0..2 {
            self.rotor_displacement[i] = -(moved[i] + lagging[i] + left_out[i]);
            self.rotor_correction[i] = -(moved[i] + STATIC_WEIGHT * (lagging[i] + left_out[i]));
            self.rotor_travel_correction[i] = -STATIC_WEIGHT * lagging[i];
        }
    }

    /// Statics of what pressed, (1), of the rotor.
    pub fn static_deflection(&self, [lacking, left_out]: [&[[f64; 2]; 2]; 2]) -> [f64; 2] {
        let ([u, v], left_out) = (times(lacking, self.impulse), times(left_out, self.normal_impulse));
        [-u - left_out[0], -v - left_out[1]]
    }

    /// Adds the same of the ring's modes to their amplitudes.
    pub fn add_static_deflection(&self, amplitudes: &mut [f64]) {
        for ((amplitude, lacks), pressed) in
            amplitudes.iter_mut().zip(flat(&self.static_correction)).zip(flat(&self.modal_impulses))
        {
            *amplitude += lacks * pressed;
        }
    }
}
