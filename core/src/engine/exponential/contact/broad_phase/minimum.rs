//! Minimum of the gap beside a ring point, from the gaps at the point and at its neighbours ([`crate::engine::exponential::contact::gap_minimum`]).

use super::super::gap_minimum::{GapMinimum, parabola_offset};
use super::super::ring_kernels::products_with;
use super::super::ring_points::{RingPoints, parabola};
use super::BroadPhase;
use crate::eight::{Eight, by_width};
use crate::engine::exponential::plane::length;
use bladeoff_numerics::linalg::lanes::Lane;

impl BroadPhase {
    /// Gap minimum beside a point; otherwise the point itself.
    #[inline(always)]
    pub fn minimum_near(&mut self, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum {
        find_minimum(self, ring, c, x, q)
    }

    #[inline(always)]
    fn minimum_kernel<V: Eight>(&mut self, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum {
        let [before, next] = ring.neighbours(c);
        let three = [before, c, next];
        let tangential = products_with::<V, 3>([ring.rows(before)[1], ring.rows(c)[1], ring.rows(next)[1]], q);
        let [mut clearances, mut gaps] = [[0.0; 3]; 2];
        for i in 0..3 {
            clearances[i] = self.clearance::<V>(ring, three[i], x, q);
            let (sin, cos) = ring.angles[three[i]];
            let (outwards, across) = (clearances[i] + self.rotor_radius, tangential[i] - (cos * x[1] - sin * x[0]));
            gaps[i] = (outwards * outwards + across * across).sqrt() - self.rotor_radius;
        }
        let offset = parabola_offset(gaps);
        let weights = parabola(offset);
        let gap = self.radius - self.rotor_radius;
        let (mut v, mut u) = (0.0, 0.0);
        for i in 0..3 {
            let (sin, cos) = ring.angles[three[i]];
            // v follows from the clearance
            v += weights[i] * (clearances[i] - gap + (cos * x[0] + sin * x[1]));
            u += weights[i] * tangential[i];
        }
        minimum_at(ring, [self.radius, self.rotor_radius], (c, offset), [v, u], x)
    }
}

/// Gap minimum at an offset from a point, where the ring is displaced by `[v, u]` and the rotor by x \[m\]; radii of the ring's
/// surface and of the rotor.
#[inline(always)]
pub(in crate::engine::exponential::contact) fn minimum_at(
    ring: &RingPoints,
    [surface_radius, rotor_radius]: [f64; 2],
    (c, offset): (usize, f64),
    [v, u]: [f64; 2],
    x: [f64; 2],
) -> GapMinimum {
    // the direction of the minimum: a small rotation from that of the point
    let turn = offset * ring.spacing;
    let (tilt, square) = (turn * (1.0 - turn * turn / 6.0), turn * turn);
    let straight = 1.0 - 0.5 * square * (1.0 - square / 12.0);
    let (sin, cos) = ring.angles[c];
    let (sin, cos) = (sin * straight + cos * tilt, cos * straight - sin * tilt);
    let distance = [surface_radius + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])];
    let whole = length(distance);
    let polar = [distance[0] / whole, distance[1] / whole];
    let normal = [cos * polar[0] - sin * polar[1], sin * polar[0] + cos * polar[1]];
    GapMinimum { index: c, offset, gap: whole - rotor_radius, polar, normal }
}

// A function of its own: code that is called from many places is then only once in the instruction cache.
by_width! { fn find_minimum(search: &mut BroadPhase, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum = find_minimum_kernel }

#[inline(always)]
fn find_minimum_kernel<V: Eight>(
    search: &mut BroadPhase,
    ring: &RingPoints,
    c: usize,
    x: [f64; 2],
    q: &[Lane],
) -> GapMinimum {
    search.minimum_kernel::<V>(ring, c, x, q)
}
