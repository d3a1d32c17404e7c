//! Static flexibility of the modes that the reduced engine leaves out, at the contact (`docs/theory/05-reduction.md`).
//!
//! The ring and the rotor that touch are those of the modes kept plus the static displacement of the modes left out under the
//! normal forces of the step. Place, normal and gap of a contact are all taken from this whole displacement: with a place from the
//! modes kept alone the force would not stand normal to the surface it acts on, and would work.

use super::{Rub, bilinear, directions};
use crate::contact::Gap;
use crate::linalg::{axpy, column_of};
use crate::structure::Structure;

impl Rub<'_> {
    /// Static flexibility of the modes left out: gap at one place by a unit normal force at another \[m/N\].
    ///
    /// It is symmetric, so what it holds is an energy. The gap by a friction force is left out with its counterpart, the slip
    /// by a normal force: at one point both vanish by mirror symmetry at blades and half-way between them, and one without
    /// the other would give or take energy in every cycle of the two forces.
    pub(super) fn residual_between(&self, at: &Gap, acting: &Gap) -> f64 {
        let (here, _) = directions(at);
        let (there, _) = directions(acting);
        let mut sum = bilinear(&self.residual, here, there);
        if let Some((ring, residual)) = self.ring.as_ref().and_then(|ring| Some((ring, ring.residual?))) {
            debug_assert!(ring.field.len() == residual.nrows());
            let ([h_r, h_t], [n_r, n_t]) = (at.normal, acting.normal);
            let shapes = self.surface.shapes(acting.place.element, acting.place.xi);
            for (i, r_i, t_i) in self.surface.shapes(at.place.element, at.place.xi) {
                let row = h_r * r_i + h_t * t_i;
                for (j, r_j, t_j) in shapes {
                    sum += row * residual[(i, j)] * (n_r * r_j + n_t * t_j);
                }
            }
        }
        sum
    }

    /// Lets the modes left out spring back: under no force.
    pub(super) fn spring_back(&mut self) {
        self.shift = [0.0; 2];
        if let Some(ring) = &mut self.ring {
            ring.left_out.fill(0.0);
        }
    }

    /// Lets the modes left out follow one more normal force \[N\] at a place.
    pub(super) fn give_way(&mut self, acting: &Gap, normal: f64) {
        let (n, _) = directions(acting);
        for axis in 0..2 {
            self.shift[axis] -= normal * (self.residual[axis][0] * n[0] + self.residual[axis][1] * n[1]);
        }
        if let Some(ring) = &mut self.ring
            && let Some(residual) = ring.residual
        {
            let [n_r, n_t] = acting.normal;
            for (dof, r, t) in self.surface.shapes(acting.place.element, acting.place.xi) {
                axpy(normal * (n_r * r + n_t * t), column_of(residual, dof), &mut ring.left_out);
            }
        }
    }
}

/// Residual flexibility of the rotor at a node, turned into the stator's axes.
pub(super) fn residual_at(structure: &Structure, node: usize, (sin, cos): (f64, f64)) -> [[f64; 2]; 2] {
    let Some(all) = &structure.lateral_residual else { return [[0.0; 2]; 2] };
    let places = structure.rotor.plane_places(node);
    let axes = [[cos, sin], [-sin, cos]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let mut sum = 0.0;
            for (a, &row) in places.iter().enumerate() {
                for (b, &col) in places.iter().enumerate() {
                    sum += axes[i][a] * all[(row, col)] * axes[j][b];
                }
            }
            sum
        })
    })
}
