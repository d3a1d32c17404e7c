//! Axes of one diaphragm, and of a place in it.

use crate::contact::{ContactReaction, Gap};
use bladeoff_model::machine::Diaphragm;

/// The stator's frame: origin at the diaphragm's centre, turned by its angle against the machine's axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    offset: [f64; 2],
    sin: f64,
    cos: f64,
}

impl Axes {
    pub fn new(diaphragm: &Diaphragm) -> Self {
        let (sin, cos) = libm::sincos(diaphragm.angle);
        Self { offset: diaphragm.contact.offset, sin, cos }
    }

    /// A place, from nodal u and v.
    pub fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.direction([u - self.offset[0], v - self.offset[1]])
    }

    /// A vector (no place) of the machine's axes.
    pub fn direction(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }

    /// A vector (no place) of this frame in the machine's axes.
    pub fn outwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// Rows of u and v turned into rows of this frame's x and y.
    pub fn rows(&self, [u, v]: &[Vec<f64>; 2]) -> [Vec<f64>; 2] {
        let (sin, cos) = (self.sin, self.cos);
        let pair = || u.iter().zip(v);
        [pair().map(|(u, v)| cos * u + sin * v).collect(), pair().map(|(u, v)| cos * v - sin * u).collect()]
    }

    /// Directions x and y in the machine's axes.
    pub fn unit(&self) -> [[f64; 2]; 2] {
        [[self.cos, self.sin], [-self.sin, self.cos]]
    }
}

/// Normal and tangent of a gap's place in the stator's frame.
pub(super) fn directions(gap: &Gap) -> ([f64; 2], [f64; 2]) {
    let n = gap.place.cartesian(gap.normal);
    (n, [-n[1], n[0]])
}

/// Force on the rotor in the stator's frame \[N\].
pub(super) fn on_rotor(force: &ContactReaction, acting: &Gap) -> [f64; 2] {
    let (normal, tangent) = directions(acting);
    [0, 1].map(|axis| -(force.normal * normal[axis] + force.tangential * tangent[axis]))
}

/// `a^T m b`.
pub(super) fn bilinear(m: &[[f64; 2]; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * (m[0][0] * b[0] + m[0][1] * b[1]) + a[1] * (m[1][0] * b[0] + m[1][1] * b[1])
}
