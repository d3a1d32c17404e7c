//! What impulses at places of the contact do to gap and slip at others.

use super::candidates::Candidates;
use super::kick::Kick;
use super::plane::{across, by_rows, product, times, turned};
use super::rows::along_both;
use super::survey::Place;
use crate::contact::complementarity::Block;

/// Displacements of the rotor per impulse, in the stator's axes: of its modes with what trains lack, and of those left out; slip of its surface per impulse.
pub(super) struct Moved {
    rotor: [[f64; 2]; 2],
    left_out: [[f64; 2]; 2],
    rolling: f64,
}

impl Moved {
    /// In a stator's axes of this sine and cosine.
    pub fn new(angle: (f64, f64), left_out: [[f64; 2]; 2], kick: &Kick, rolling: f64) -> Self {
        let whole = [0, 1].map(|i| [0, 1].map(|j| kick.moved[i][j] + kick.lacking[i][j]));
        Self { rotor: turned(angle, &whole), left_out, rolling }
    }

    /// Displacement of the rotor by an impulse along normal and tangent of a place, as [`Moved::beyond_modes`] has it.
    pub fn of_rotor(&self, acting: &Place, normal: f64, tangential: f64) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let along = [0, 1].map(|i| normal * m[i] + tangential * s[i]);
        let (whole, left_out) = (times(&self.rotor, along), times(&self.left_out, m));
        [0, 1].map(|i| whole[i] + normal * left_out[i])
    }

    /// What is no mode of the ring in the gap at a place by a unit normal and a unit tangential impulse at another.
    pub fn beyond_modes(&self, ring: &Candidates, at: &Place, acting: &Place) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let left_out = product(at.normal, times(&self.left_out, m))
            + product(at.polar, by_rows(&ring.left_out(at.index, acting.index), acting.polar));
        [product(at.normal, times(&self.rotor, m)) + left_out, product(at.normal, times(&self.rotor, s))]
    }

    /// Gap and slip at a place by a unit normal and a unit tangential impulse at another: the ring's modes along normal and tangent of the one, and what
    /// those impulses make of them.
    pub fn coupling(&self, ring: &Candidates, at: (&Place, [&[f64]; 2]), acting: (&Place, [&[f64]; 2])) -> Block {
        let ((at, rows), (acting, by)) = (at, acting);
        let ring_moves = along_both(rows, by);
        let [n, t] = self.beyond_modes(ring, at, acting);
        let (m, s) = (acting.normal, across(acting.normal));
        let along = across(at.normal);
        [
            [n + ring_moves[0], t + ring_moves[1]],
            [
                -product(along, times(&self.rotor, m)) - ring_moves[2],
                -product(along, times(&self.rotor, s)) - ring_moves[3] - self.rolling,
            ],
        ]
    }
}
