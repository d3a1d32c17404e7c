//! Axes of one diaphragm, and polar axes at one of its places.

use crate::contact::{ContactReaction, Gap};
use bladeoff_model::machine::Diaphragm;

/// Stator's frame: origin at the diaphragm's centre, rotated by its angle relative to the machine's axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    /// Position of the diaphragm's centre in the machine's axes \[m\].
    offset: [f64; 2],
    /// sin of the diaphragm's angle.
    sin: f64,
    /// cos of the diaphragm's angle.
    cos: f64,
}

impl Axes {
    pub fn new(diaphragm: &Diaphragm) -> Self {
        let (sin, cos) = libm::sincos(diaphragm.angle);
        Self { offset: diaphragm.contact.offset, sin, cos }
    }

    /// Position in this frame, from nodal u and v \[m\].
    pub fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.direction([u - self.offset[0], v - self.offset[1]])
    }

    /// Rotates a vector (not a position) from the machine's axes to this frame.
    pub fn direction(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }

    /// Rotates a vector (not a position) from this frame to the machine's axes.
    pub fn outwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// Rotates rows of u and v into rows of x and y in this frame.
    pub fn rows(&self, [u, v]: &[Vec<f64>; 2]) -> [Vec<f64>; 2] {
        let (sin, cos) = (self.sin, self.cos);
        let pair = || u.iter().zip(v);
        [pair().map(|(u, v)| cos * u + sin * v).collect(), pair().map(|(u, v)| cos * v - sin * u).collect()]
    }

    /// Unit vectors x and y in the machine's axes.
    pub fn unit(&self) -> [[f64; 2]; 2] {
        [[self.cos, self.sin], [-self.sin, self.cos]]
    }
}

/// Normal (from rotor to ring) and tangent at a gap's place, in the stator's frame.
pub(super) fn directions(gap: &Gap) -> ([f64; 2], [f64; 2]) {
    let n = gap.place.cartesian(gap.normal);
    (n, [-n[1], n[0]])
}

/// Force on the rotor in the stator's frame \[N\].
pub(super) fn on_rotor(force: &ContactReaction, acting: &Gap) -> [f64; 2] {
    let (normal, tangent) = directions(acting);
    [0, 1].map(|axis| -(force.normal * normal[axis] + force.tangential * tangent[axis]))
}

/// Bilinear form `a^T m b`.
pub(super) fn bilinear(m: &[[f64; 2]; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * (m[0][0] * b[0] + m[0][1] * b[1]) + a[1] * (m[1][0] * b[0] + m[1][1] * b[1])
}
