//! Exact correction of the increments before t = 0 for a start under contact, if plain rounds do not converge.

use crate::engine::shaft_line::{Increments, ShaftLine, masses};
use crate::structure::Structure;
use bladeoff_numerics::linalg::{Matrix, axpy, dot, inverse, mul, mul_vec};

/// Correction (2) of [`super::loaded`]; lateral coordinates first, torsional ones after them.
pub(super) struct Centring {
    /// Matrix `(dt^2/2) M^-1 A` of the lateral motion, and that of the torsion.
    blocks: [Matrix; 2],
    /// Rank-one terms `u y^T` added by the rounds (Broyden's method).
    secants: Vec<(Vec<f64>, Vec<f64>)>,
    /// Last correction, and the error that it was computed for.
    last: Option<(Vec<f64>, Vec<f64>)>,
}

impl Centring {
    /// Matrices `(dt^2/2) M^-1 A = 1/2 + (dt/4) M^-1 C` of lateral motion and torsion: change of the increments before t = 0 per change of the
    /// centred ones. `None` if a mass matrix is singular.
    pub fn new(line: &ShaftLine<'_>, structure: &Structure) -> Option<Self> {
        let (lateral_mass, torsional_mass) = masses(structure, line.unbalances());
        let half = |mass: &Matrix, damping: &Matrix| {
            let moved = mul(&inverse(mass)?, damping);
            Some(Matrix::identity(mass.nrows(), mass.nrows()) * 0.5 + moved * (0.25 * line.dt))
        };
        let blocks =
            [half(&lateral_mass, &structure.lateral.damping)?, half(&torsional_mass, &structure.torsion.damping)?];
        Some(Self { blocks, secants: Vec::new(), last: None })
    }

    /// Adds the correction for an error of the centred increments to `previous`.
    pub fn correct(&mut self, error: &Increments, previous: &mut Increments) {
        let step = self.correction([error.lateral.as_slice(), &error.torsion].concat());
        let (lateral, torsion) = step.split_at(error.lateral.len());
        axpy(1.0, lateral, &mut previous.lateral);
        axpy(1.0, torsion, &mut previous.torsion);
    }

    fn correction(&mut self, error: Vec<f64>) -> Vec<f64> {
        if let Some((step, before)) = self.last.take() {
            let gained: Vec<f64> = before.iter().zip(&error).map(|(a, b)| a - b).collect();
            let (square, expected) = (dot(&gained, &gained), self.times(&gained));
            if square > 0.0 {
                let u = step.iter().zip(&expected).map(|(s, e)| (s - e) / square).collect();
                self.secants.push((u, gained));
            }
        }
        let step = self.times(&error);
        self.last = Some((step.clone(), error));
        step
    }

    fn times(&self, error: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; error.len()];
        let lateral = self.blocks[0].nrows();
        mul_vec(&self.blocks[0], &error[..lateral], &mut product[..lateral]);
        mul_vec(&self.blocks[1], &error[lateral..], &mut product[lateral..]);
        for (u, y) in &self.secants {
            axpy(dot(y, error), u, &mut product);
        }
        product
    }
}
