//! What holds at several coupled contact points.

use bladeoff_model::machine::FrictionLaw;

/// Points that there is room for.
pub(crate) const POINTS: usize = 24;
/// Gap and slip at one point by a unit normal and a unit tangential force at another \[m/N\].
pub(crate) type Block = [[f64; 2]; 2];

/// The conditions (1) of [`super`] of as many points as forces are asked for.
pub(crate) struct Coupled {
    pub w: [[Block; POINTS]; POINTS],
    /// Gap and slip without forces \[m\].
    pub start: [[f64; 2]; POINTS],
    pub friction: f64,
    pub law: FrictionLaw,
    /// Slip direction of [`FrictionLaw::Slip`].
    pub sign: f64,
}

impl Coupled {
    /// Gap and slip at a point under all forces \[m\].
    #[inline(always)]
    pub(super) fn moved(&self, k: usize, forces: &[[f64; 2]]) -> [f64; 2] {
        let [mut gap, mut slip] = self.start[k];
        for (block, [normal, tangential]) in self.w[k].iter().zip(forces) {
            gap += block[0][0] * normal + block[0][1] * tangential;
            slip += block[1][0] * normal + block[1][1] * tangential;
        }
        [gap, slip]
    }
}
