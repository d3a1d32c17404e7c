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
use super::rows::add_two;
use super::survey::Place;
use crate::contact::ContactForce;
use crate::linalg::eight::Eight;
use crate::linalg::lanes::{LANES, Lane};

/// What is known of n+1 before its impulses.
pub(super) struct Foreseen {
    /// What impulses make of the ring's modes by n+1, with (1), and (1) alone \[1/kg\].
    yields: Vec<Lane>,
    lacking: Vec<Lane>,
    /// Sums of the last impulses along the rows of their places, and in the plane: of all parts, and of the normal ones.
    pressed: Vec<Lane>,
    along: [f64; 2],
    normal: [f64; 2],
    /// s_n, and the ring's modes with it; and their way over the step less what of it is (1).
    pub statics: Vec<Lane>,
    pub ring: Vec<Lane>,
    pub way: Vec<Lane>,
    /// s_x without and with the modes left out \[m\].
    pub lagging: [f64; 2],
    pub held: [f64; 2],
}

impl Foreseen {
    /// Of a ring whose modes' trains lack this.
    pub fn new([yields, lacking]: [Vec<Lane>; 2]) -> Self {
        let zeros = vec![Lane::default(); lacking.len()];
        Self {
            yields,
            lacking,
            pressed: zeros.clone(),
            along: [0.0; 2],
            normal: [0.0; 2],
            statics: zeros.clone(),
            ring: zeros.clone(),
            way: zeros,
            lagging: [0.0; 2],
            held: [0.0; 2],
        }
    }

    /// Nothing presses any more.
    #[inline(always)]
    pub fn forget(&mut self) {
        self.pressed.fill(Lane::default());
        (self.along, self.normal) = ([0.0; 2], [0.0; 2]);
    }

    /// Something presses at a place, of which these are the rows.
    #[inline(always)]
    pub fn press<V: Eight>(&mut self, place: &Place, force: &ContactForce, rows: [&[Lane]; 2]) {
        add_two::<V>([force.normal, force.tangential], rows, &mut self.pressed);
        let (n, t) = (place.normal, across(place.normal));
        for i in 0..2 {
            self.normal[i] += n[i] * force.normal;
            self.along[i] += n[i] * force.normal + t[i] * force.tangential;
        }
    }

    /// From what pressed: the ring at n+1 without impulses and its way there are given; what impulses on the rotor move it by n+1, what of that their trains lack, and
    /// its modes left out, in the stator's axes.
    #[inline(always)]
    pub fn take<V: Eight>(&mut self, ring: &[Lane], way: &[Lane], [whole, lacking, left_out]: [&[[f64; 2]; 2]; 3]) {
        let count = ring.len();
        let (yields, lacks, pressed) = (&self.yields[..count], &self.lacking[..count], &self.pressed[..count]);
        let (statics, foreseen) = (&mut self.statics[..count], &mut self.ring[..count]);
        let (gone, way) = (&mut self.way[..count], &way[..count]);
        for i in 0..count {
            let pressed = V::load(&pressed[i]);
            let held = V::load(&yields[i]) * pressed;
            held.store(&mut statics[i]);
            (V::load(&ring[i]) + held).store(&mut foreseen[i]);
            (V::load(&way[i]) - V::load(&lacks[i]) * pressed).store(&mut gone[i]);
        }
        (_, self.held) = self.behind([whole, left_out]);
        (self.lagging, _) = self.behind([lacking, left_out]);
    }

    /// s_x without and with the modes left out.
    #[inline(always)]
    pub fn behind(&self, [lacking, left_out]: [&[[f64; 2]; 2]; 2]) -> ([f64; 2], [f64; 2]) {
        let ([u, v], left_out) = (times(lacking, self.along), times(left_out, self.normal));
        ([-u, -v], [-u - left_out[0], -v - left_out[1]])
    }

    /// s_n of a mode.
    pub fn static_of(&self, mode: usize) -> f64 {
        let (i, k) = (mode / LANES, mode % LANES);
        self.lacking[i].0[k] * self.pressed[i].0[k]
    }
}
