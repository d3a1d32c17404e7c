//! Axes of a stator: origin at its centre, turned by its angle against the machine's axes.

use bladeoff_model::machine::Diaphragm;

/// Position of a stator in the machine's axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StatorAxes {
    /// Sine and cosine of the stator's angle.
    pub angle: (f64, f64),
    /// Centre of the stator in the machine's axes \[m\].
    offset: [f64; 2],
}

impl StatorAxes {
    /// Creates the axes of a diaphragm's stator.
    pub fn new(diaphragm: &Diaphragm) -> Self {
        Self { angle: libm::sincos(diaphragm.angle), offset: diaphragm.contact.offset }
    }

    /// Displacement of the rotor from the stator's centre \[m\], in the machine's axes, for one from their origin.
    pub fn displacement_from_centre(self, displacement: [f64; 2]) -> [f64; 2] {
        [displacement[0] - self.offset[0], displacement[1] - self.offset[1]]
    }

    /// Displacement of the rotor from the stator's centre in the stator's axes \[m\], for one in the machine's axes from their
    /// origin.
    pub fn place(self, displacement: [f64; 2]) -> [f64; 2] {
        self.to_stator(self.displacement_from_centre(displacement))
    }

    /// Components in the stator's axes of a vector in the machine's axes.
    #[inline(always)]
    pub fn to_stator(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// Components in the machine's axes of a vector in the stator's axes.
    #[inline(always)]
    pub fn to_machine(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x - sin * y, sin * x + cos * y]
    }
}
