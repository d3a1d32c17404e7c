//! Ring and rotor at n+1 with the statics of the impulses at n-1, as though the same forces went on.
//!
//! ```text
//! lacking   of a train J = F h at n: what it lacks of the static displacement, on each mode of the ring and of the rotor, and the rotor's modes left out      (1)
//! s_n = lacking (J_n N + J_t T),   s_x = -lacking (J_n n + J_t t) - left out J_n n         of all that pressed, at their places now
//! ```
//! Places and normals are taken from `n + s_n` and `x + s_x`, and the linear conditions go on from there. In the free step, which has all earlier impulses in it, ring and rotor are where
//! the statics of trains are not: in a whip places and normals then jumped from step to step (forces three times too large; normal forces put in 1 to 17 MJ, the more the smaller the step). Limit: statics of the ring's modes left out are not in the places.
//! Verified by `whip_is_that_of_the_reduced_engine` (`tests/exponential_run.rs`).

use super::plane::{across, times};
use super::rows::{add_both, add_statics};
use super::survey::Place;
use crate::contact::ContactForce;

/// What is known of n+1 before its impulses.
pub(super) struct Foreseen {
    /// (1), of the ring's modes \[1/kg\].
    lacking: Vec<f64>,
    /// s_n, and the ring's modes with it.
    pub statics: Vec<f64>,
    pub ring: Vec<f64>,
    /// s_x without and with the modes left out \[m\].
    pub lagging: [f64; 2],
    pub held: [f64; 2],
}

impl Foreseen {
    /// Of a ring whose modes' trains lack this.
    pub fn new(lacking: Vec<f64>) -> Self {
        let zeros = vec![0.0; lacking.len()];
        Self { lacking, statics: zeros.clone(), ring: zeros, lagging: [0.0; 2], held: [0.0; 2] }
    }

    /// From what pressed, with the ring's modes along its normal and tangent; the ring at n+1 without impulses; and what trains of impulses on the rotor lack, and
    /// its modes left out, in the stator's axes.
    pub fn take(
        &mut self,
        pressed: &[(Place, ContactForce)],
        rows: &[[Vec<f64>; 2]],
        ring: &[f64],
        [lacking, left_out]: [&[[f64; 2]; 2]; 2],
    ) {
        self.statics.fill(0.0);
        let (mut along, mut normal) = ([0.0; 2], [0.0; 2]);
        for ((place, force), rows) in pressed.iter().zip(rows) {
            add_both([force.normal, force.tangential], rows.each_ref().map(Vec::as_slice), &mut self.statics);
            let (n, t) = (place.normal, across(place.normal));
            for i in 0..2 {
                normal[i] += n[i] * force.normal;
                along[i] += n[i] * force.normal + t[i] * force.tangential;
            }
        }
        add_statics(&self.lacking, ring, &mut self.statics, &mut self.ring);
        self.lagging = times(lacking, along).map(|part| -part);
        let left_out = times(left_out, normal);
        self.held = [0, 1].map(|i| self.lagging[i] - left_out[i]);
    }
}
