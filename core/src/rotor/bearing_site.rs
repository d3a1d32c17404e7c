//! Spring and damper between two points of the lateral motion, or between a point and the ground.

use bladeoff_model::machine::Coefficients;
use bladeoff_numerics::linalg::Matrix;

/// A spring and damper of the lateral motion: a bearing between its node and its pedestal or the ground, or a pedestal on the ground. The
/// stiffness consists of a symmetric part, which has a potential, and a skew part, which has none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingSite {
    /// Node of the bearing.
    pub node: usize,
    /// Indices of X and Y of the moving end in the lateral vector: journal or pedestal.
    pub places: [usize; 2],
    /// Indices of the pedestal that carries the bearing; `None`: the ground.
    pub base: Option<[usize; 2]>,
    /// Complete stiffness matrix K \[N/m\].
    pub stiffness: [[f64; 2]; 2],
    /// Skew part of the stiffness `(kxy - kyx)/2` \[N/m\]; the energy balance accounts for its work separately.
    pub skew: f64,
    /// Damping matrix C \[N s/m\].
    pub damping: [[f64; 2]; 2],
}

impl BearingSite {
    /// A spring of unit stiffness to the ground; its load equals the displacement of its moving end.
    #[must_use]
    pub fn unit(node: usize, places: [usize; 2]) -> Self {
        let stiffness = [[1.0, 0.0], [0.0, 1.0]];
        Self { node, places, base: None, stiffness, skew: 0.0, damping: [[0.0; 2]; 2] }
    }

    /// Displacement or velocity of the moving end relative to the base.
    #[inline]
    #[must_use]
    pub fn across(&self, x: &[f64]) -> [f64; 2] {
        let moving = [x[self.places[0]], x[self.places[1]]];
        match self.base {
            None => moving,
            Some([u, v]) => [moving[0] - x[u], moving[1] - x[v]],
        }
    }

    /// Site at the same place with the difference between given coefficients and those of this site.
    #[must_use]
    pub fn change_to(&self, to: &Coefficients) -> Self {
        let change = |to: &[[f64; 2]; 2], from: &[[f64; 2]; 2]| [0, 1].map(|i| [0, 1].map(|j| to[i][j] - from[i][j]));
        let stiffness = change(&to.stiffness, &self.stiffness);
        let skew = 0.5 * (stiffness[0][1] - stiffness[1][0]);
        Self { stiffness, skew, damping: change(&to.damping, &self.damping), ..*self }
    }

    /// Site at the same place with the coefficients of this site plus those of `change`.
    #[must_use]
    pub fn changed_by(&self, change: &Self) -> Self {
        let sum = |a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]| [0, 1].map(|i| [0, 1].map(|j| a[i][j] + b[i][j]));
        Self {
            stiffness: sum(&self.stiffness, &change.stiffness),
            skew: self.skew + change.skew,
            damping: sum(&self.damping, &change.damping),
            ..*self
        }
    }

    /// Bilinear form `x^T K y` of the symmetric part of the stiffness \[J\].
    #[must_use]
    pub fn stiffness_form(&self, x: [f64; 2], y: [f64; 2]) -> f64 {
        let k = &self.stiffness;
        let cross = 0.5 * (k[0][1] + k[1][0]);
        x[0] * (k[0][0] * y[0] + cross * y[1]) + x[1] * (cross * y[0] + k[1][1] * y[1])
    }

    /// Adds a force to the moving end, and the opposite force to the base.
    #[inline]
    pub fn push(&self, force: [f64; 2], f: &mut [f64]) {
        for axis in 0..2 {
            f[self.places[axis]] += force[axis];
            if let Some(base) = self.base {
                f[base[axis]] -= force[axis];
            }
        }
    }

    /// Rows of the relative displacement [`BearingSite::across`] along X and Y. `row`: row of a degree of freedom.
    #[must_use]
    pub fn rows(&self, row: impl Fn(usize) -> Vec<f64>) -> [Vec<f64>; 2] {
        [0, 1].map(|axis| {
            let mut moving = row(self.places[axis]);
            if let Some(base) = self.base {
                moving.iter_mut().zip(row(base[axis])).for_each(|(part, base)| *part -= base);
            }
            moving
        })
    }

    /// Force `K e` \[N\] that a seat adds to the moving end. `elevation`: offset e of the seat from the bearing line \[m\].
    #[must_use]
    pub fn seat_force(&self, elevation: [f64; 2]) -> [f64; 2] {
        self.load(elevation, [0.0; 2])
    }

    /// Adds a 2 x 2 matrix of the site to a lateral matrix.
    pub(super) fn add_to(&self, value: &[[f64; 2]; 2], nodal: &mut Matrix) {
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            nodal[(self.places[i], self.places[j])] += value[i][j];
            if let Some(base) = self.base {
                nodal[(base[i], base[j])] += value[i][j];
                nodal[(self.places[i], base[j])] -= value[i][j];
                nodal[(base[i], self.places[j])] -= value[i][j];
            }
        }
    }

    /// Load K x + C x' on the bearing \[N\]; the force on the rotor is the opposite.
    #[inline]
    #[must_use]
    pub fn load(&self, x: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let (k, c) = (&self.stiffness, &self.damping);
        [
            k[0][0] * x[0] + k[0][1] * x[1] + c[0][0] * v[0] + c[0][1] * v[1],
            k[1][0] * x[0] + k[1][1] * x[1] + c[1][0] * v[0] + c[1][1] * v[1],
        ]
    }

    /// Power dissipated by the damping, `v^T C v` \[W\]; negative where the damping adds energy.
    #[inline]
    #[must_use]
    pub fn damping_power(&self, v: [f64; 2]) -> f64 {
        let c = &self.damping;
        v[0] * (c[0][0] * v[0] + c[0][1] * v[1]) + v[1] * (c[1][0] * v[0] + c[1][1] * v[1])
    }

    /// Force of the skew stiffness on the rotor, `-[[0, s], [-s, 0]] x` \[N\].
    #[inline]
    #[must_use]
    pub fn skew_force(&self, x: [f64; 2]) -> [f64; 2] {
        [-self.skew * x[1], self.skew * x[0]]
    }
}
