//! Static flexibility of the modes that the reduced engine leaves out, at the contact (`docs/theory/05-reduction.md`).

use super::{Rub, StepContact, bilinear, directions};
use crate::contact::{ContactForce, Gap};
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

    /// By how much the modes left out open the gap at a place in a contact step just solved, all its points together \[m\].
    pub fn yielding_in(&self, at: &Gap, contact: &StepContact) -> f64 {
        if contact.points > 1 { self.yielding_of(at, &self.points) } else { self.yielding(at, &contact.force) }
    }

    /// By how much the modes left out open the gap at a place under a contact force there \[m\].
    pub(super) fn yielding(&self, acting: &Gap, force: &ContactForce) -> f64 {
        self.residual_between(acting, acting) * force.normal
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
