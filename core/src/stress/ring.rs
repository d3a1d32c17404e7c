//! Stress of the diaphragm's ring: membrane and bending.

use super::blades::BladeStresses;
use super::fibres::{Fibres, Pairs};
use crate::linalg::Matrix;
use crate::structure::RingPart;
use bladeoff_model::machine::FlexibleStator;

/// Stresses of a ring and of its blades from the coordinates of the ring.
///
/// ```text
/// sigma = E [(v/R + u,s) +- (h/2) (v/R^2 + v,ss)]        at the inner and the outer face; h radial thickness, R mean radius
/// ```
/// evaluated at both ends of every ring element, where u,s and v,s are degrees of freedom. Source: membrane strain and change of curvature of the
/// element's own strain energy (docs/theory/02-diaphragm.md); Timoshenko and Gere, Theory of Elastic Stability, art. 7.1. Deviation: none;
/// the paper reports no stresses.
///
/// # Units
/// SI; angles from blade 0, in the diaphragm's own axes.
/// # Limits
/// Nominal, planar, thin: no bending out of the plane, no torsion of the section, no stress concentration at a blade's root; the curved-beam factor
/// `1 + O(h/R)` of the inner face is not in it. Under a load inside an element the bending moment lacks up to `F l/8` (l: length of an element).
/// In a reduced engine stresses beside the contact lack the modes left out.
/// # Verified by
/// `tests/ring_stresses.rs`
#[derive(Debug, Clone)]
pub(crate) struct RingStresses {
    pairs: Pairs,
    ring: Fibres,
    blades: Option<BladeStresses>,
    /// Angle of one element \[rad\], and elements.
    spacing: f64,
    elements: usize,
    amplitudes: Vec<f64>,
}

/// Fibres of one ring element: two faces at two ends.
const OF_ELEMENT: usize = 4;

/// What is not above these is not asked for \[Pa\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub ring: f64,
    pub blades: f64,
    pub bending: f64,
}

/// Largest stresses of an instant \[Pa\], each where it may be above what is known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Largest {
    pub ring: Option<f64>,
    /// Axial and bending.
    pub blades: Option<f64>,
    pub bending: Option<f64>,
}

impl RingStresses {
    /// Of a flexible stator.
    pub fn new(stator: &FlexibleStator, part: &RingPart) -> Self {
        let coordinates = &part.part.coordinates;
        let (size, pairs) = (coordinates.size(), Pairs::of(&part.part));
        let (r, count) = (stator.ring.mean_radius, stator.ring.elements);
        let spacing = 2.0 * std::f64::consts::PI / count as f64;
        let l = spacing * r;
        let (young, half) = (stator.young_modulus, 0.5 * stator.ring.thickness);
        let bending = young * half;
        let row = |terms: &[(usize, f64)]| {
            let mut row = vec![0.0; size];
            terms.iter().for_each(|&(dof, factor)| coordinates.add_row(dof, factor, &mut row));
            row
        };
        let mut columns = Matrix::zeros(size, OF_ELEMENT * count);
        for element in 0..count {
            // [u, u_s, v, v_s] of its nodes
            let nodes = [4 * element, 4 * ((element + 1) % count)];
            for (end, &node) in nodes.iter().enumerate() {
                let membrane = row(&[(node + 1, young), (node + 2, young / r)]);
                let (sign, other) = (if end == 0 { 1.0 } else { -1.0 }, nodes[1 - end]);
                let square = l * l;
                // second derivative of the cubic at this end, from this end
                let curved = row(&[
                    (node + 2, bending * (1.0 / (r * r) - 6.0 / square)),
                    (node + 3, -sign * bending * 4.0 / l),
                    (other + 2, bending * 6.0 / square),
                    (other + 3, -sign * bending * 2.0 / l),
                ]);
                let place = OF_ELEMENT * element + 2 * end;
                for (j, (membrane, curved)) in membrane.iter().zip(&curved).enumerate() {
                    columns[(j, place)] = membrane + curved;
                    columns[(j, place + 1)] = membrane - curved;
                }
            }
        }
        Self {
            ring: Fibres::new(&columns, &pairs, coordinates.shapes().is_some()),
            blades: BladeStresses::new(stator, part, &pairs),
            pairs,
            spacing,
            elements: count,
            amplitudes: Vec::new(),
        }
    }

    /// Whether there are blades.
    pub fn has_blades(&self) -> bool {
        self.blades.is_some()
    }

    /// Largest stresses of coordinates, as far as a bound says that they may be above what is known.
    ///
    /// The bound also keeps a ring that has come to rest cheap: its coordinates decay to subnormal numbers, whose products are slow.
    pub fn above(&mut self, known: &Known, q: &[f64]) -> Largest {
        let Self { pairs, ring, blades, amplitudes, .. } = self;
        pairs.amplitudes(q, amplitudes);
        let of = |fibres: &Fibres, known: f64| (fibres.bound(amplitudes) > known).then(|| fibres.largest(q));
        let blades = blades.as_ref();
        Largest {
            ring: of(ring, known.ring),
            blades: blades.and_then(|blades| of(&blades.both, known.blades)),
            bending: blades.and_then(|blades| of(&blades.bending, known.bending)),
        }
    }

    /// Bounds of the stresses of ring and blades of such amplitudes of all coordinates \[Pa\].
    pub fn bounds(&mut self, q: &[f64]) -> [f64; 2] {
        let Self { pairs, ring, blades, amplitudes, .. } = self;
        pairs.amplitudes(q, amplitudes);
        [ring.bound(amplitudes), blades.as_ref().map_or(0.0, |blades| blades.both.bound(amplitudes))]
    }

    /// Angle \[rad\], from 0 to below 2 pi, of the largest stress of the ring, which [`RingStresses::above`] has found.
    pub fn angle_of(&self, largest: f64, q: &[f64]) -> f64 {
        let fibre = self.ring.place_of(largest, q);
        let node = fibre / OF_ELEMENT + (fibre % OF_ELEMENT) / 2;
        (node % self.elements) as f64 * self.spacing
    }

    /// Number of the blade, from 0, of the largest stress of the blades.
    pub fn blade_of(&self, largest: f64, q: &[f64]) -> usize {
        self.blades.as_ref().map_or(0, |blades| blades.blade_of(blades.both.place_of(largest, q)))
    }
}
