//! Contact conditions at several coupled points.

use bladeoff_model::machine::FrictionLaw;

/// Maximum number of points.
pub(crate) const POINTS: usize = 24;
/// Gap and slip at one point (rows) per unit normal and unit tangential force at another (columns) \[m/N\]: `[[W_nn, W_nt], [W_tn, W_tt]]`.
pub(crate) type Block = [[f64; 2]; 2];

/// Conditions (1) of [`super`]; their number of points is the number of forces to be found.
pub(crate) struct Coupled {
    /// Delassus operator W: `w[k][j]` is the response at point k to forces at point j \[m/N\].
    pub w: [[Block; POINTS]; POINTS],
    /// Gap g0 and slip s0 at each point without forces \[m\].
    pub start: [[f64; 2]; POINTS],
    /// Friction coefficient mu.
    pub friction: f64,
    /// Friction law: sliding only, or sticking and sliding.
    pub law: FrictionLaw,
    /// Slip direction of [`FrictionLaw::Slip`], +1 or -1.
    pub sign: f64,
}

impl Coupled {
    /// Gap and slip (1) at a point under all forces \[m\].
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
