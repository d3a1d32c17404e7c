//! Saltelli's layout: pairs of points A and B, and A with one parameter at a time taken from B.
//!
//! ```text
//! base point j of Sobol's sequence in 2 d dimensions: the first d are A, the others B                       block j
//! its points, in order   A, AB_1 .. AB_d, [BA_1 .. BA_d], B       d + 2 of them, 2 d + 2 with second_order
//! AB_i = A with parameter i of B; BA_i = B with parameter i of A
//! ```
//! The sequence is that of `sobol.rs`, scrambled unless `scramble` = false, from index 0 on. A base point depends on (seed, j, d) alone: more
//! base points change none; another number of parameters changes B.
//!
//! Sources: A. Saltelli, "Making best use of model evaluations to compute sensitivity indices" (2002); A. Saltelli et al., "Variance
//! based sensitivity analysis of model output" (2010).

use super::related::related;
use crate::sampling::sequence::sobol::Sobol;

/// The base points of a design, and the points derived from them.
#[derive(Debug, Clone)]
pub struct Saltelli {
    sobol: Sobol,
    /// Scrambling keys; `None`: not scrambled.
    keys: Option<Vec<u64>>,
    parameters: usize,
    second_order: bool,
}

/// Relation of a point to its base point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The first half of the coordinates.
    A,
    /// A with this parameter of B.
    Ab(usize),
    /// B with this parameter of A.
    Ba(usize),
    /// The second half.
    B,
}

impl Saltelli {
    /// Layout for this number of parameters; `keys` has twice as many dimensions.
    pub(super) fn new(parameters: usize, keys: Option<Vec<u64>>, second_order: bool) -> Self {
        Self { sobol: Sobol::new(2 * parameters), keys, parameters, second_order }
    }

    /// Number of points per base point.
    #[must_use]
    pub fn rows(&self) -> u64 {
        rows(self.parameters, self.second_order)
    }

    /// Whether the layout has the points BA_i.
    #[must_use]
    pub fn has_second_order(&self) -> bool {
        self.second_order
    }

    /// Whether the points are random.
    #[must_use]
    pub fn is_scrambled(&self) -> bool {
        self.keys.is_some()
    }

    /// Relation of a point to its base point.
    #[must_use]
    pub fn role(&self, index: u64) -> Role {
        let place = index % self.rows();
        if place == 0 {
            return Role::A;
        }
        if place == self.rows() - 1 {
            return Role::B;
        }
        let of = place as usize - 1;
        if of < self.parameters { Role::Ab(of) } else { Role::Ba(of - self.parameters) }
    }

    /// Parameters whose values in A and in B are correlated over the first `count` base points, the largest correlation r first. The total index
    /// of such a parameter is biased by a factor of about 1 - r, since E (a - b)^2/2 = V (1 - r): too low for r > 0, too high for r < 0.
    #[must_use]
    pub fn related(&self, count: u64) -> Vec<(usize, f64)> {
        let d = self.parameters;
        let fill = |base: u64, both: &mut [f64]| self.base(base, both);
        let found = related(count, 2 * d, fill, (0..d).map(|parameter| [parameter, d + parameter]));
        found.into_iter().map(|([parameter, _], r)| (parameter, r)).collect()
    }

    /// The coordinates of a base point.
    fn base(&self, base: u64, both: &mut [f64]) {
        match &self.keys {
            Some(keys) => self.sobol.scrambled(base, keys, both),
            None => self.sobol.plain(base, both),
        }
    }

    /// The coordinates of a point.
    pub(super) fn fill(&self, index: u64, point: &mut [f64]) {
        let mut both = vec![0.0; 2 * self.parameters];
        self.base(index / self.rows(), &mut both);
        let (a, b) = both.split_at(self.parameters);
        let (most, exchanged) = match self.role(index) {
            Role::A => (a, None),
            Role::Ab(i) => (a, Some((i, b[i]))),
            Role::Ba(i) => (b, Some((i, a[i]))),
            Role::B => (b, None),
        };
        point.copy_from_slice(most);
        if let Some((parameter, coordinate)) = exchanged {
            point[parameter] = coordinate;
        }
    }
}

/// Number of points per base point.
pub(super) fn rows(parameters: usize, second_order: bool) -> u64 {
    let each = if second_order { 2 } else { 1 };
    each * parameters as u64 + 2
}
