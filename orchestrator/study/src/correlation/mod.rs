//! Dependent parameters: a Gaussian copula over the pairs of `[[correlation]]`.
//!
//! ```text
//! z = Phi^-1(u),  y = L z,  u' = Phi(y),  L L^T = R                 R: correlations of the normal numbers behind the values
//! rank   (Spearman)  r = 2 sin(pi rank/6)                           continuous and empirical parameters
//! linear (Pearson)   r from Corr(x1(z1), x2(z2)) = linear (Nataf)   the same
//! normal             r itself                                       any parameters; the only one of discrete and periodic ones
//! ```
//! Pairs that are not given are independent. A parameter without a pair, and the first of each group, keeps its coordinate bit for bit, so
//! that the strata of a design are kept in that parameter; in the others they are mixed.
//! Source: R. B. Nelsen, "An introduction to copulas" (2006), section 5.1 for the rank.

mod error;
mod hermite;
mod nataf;
mod nearest;

pub use bladeoff_numerics::CorrelationMatrix;
pub use error::{CorrelationError, Possible};
pub use nataf::ACCURACY;
pub use nearest::nearest;

use crate::uncertain::Uncertain;
use bladeoff_numerics::probability::{normal_quantile, normal_tails};
use core::f64::consts::PI;
use nataf::{Nataf, Refused};

/// Correlation of two parameters: value and measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// Spearman's correlation of the ranks.
    Rank(f64),
    /// Pearson's correlation of the values.
    Linear(f64),
    /// Correlation of the normal numbers behind the values.
    Normal(f64),
}

impl Strength {
    /// Key and number.
    #[must_use]
    pub fn parts(self) -> (&'static str, f64) {
        match self {
            Strength::Rank(given) => ("rank", given),
            Strength::Linear(given) => ("linear", given),
            Strength::Normal(given) => ("normal", given),
        }
    }
}

/// A table of `[[correlation]]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Indices of the parameters.
    pub between: [usize; 2],
    /// Value.
    pub strength: Strength,
}

/// Gaussian copula: makes coordinates dependent.
#[derive(Debug, Clone, PartialEq)]
pub struct Copula {
    /// Nonzero entries of L for each parameter, the diagonal one last; empty: the parameter keeps its coordinate.
    rows: Vec<Vec<(usize, f64)>>,
}

impl Copula {
    /// Copula of independent parameters.
    #[must_use]
    pub fn independent(count: usize) -> Self {
        Self { rows: vec![Vec::new(); count] }
    }

    /// Copula of these parameters and pairs.
    ///
    /// # Errors
    /// Every impossible pair; if each pair is possible, their contradiction.
    pub fn new(names: &[String], laws: &[Uncertain], pairs: &[Pair]) -> Result<Self, Vec<CorrelationError>> {
        let mut nataf = Nataf::new(laws);
        let (mut errors, mut normals) = (Vec::new(), Vec::new());
        for (number, pair) in pairs.iter().enumerate() {
            match normal(names, laws, pairs, number, &mut nataf) {
                Ok(r) => normals.push((pair.between, r)),
                Err(error) => errors.push(error),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        // parameters without a pair change nothing
        let mut named: Vec<usize> = pairs.iter().flat_map(|pair| pair.between).collect();
        named.sort_unstable();
        named.dedup();
        let place = |number: usize| named.binary_search(&number).expect("it is named");
        let mut matrix = CorrelationMatrix::identity(named.len());
        for ([a, b], r) in normals {
            matrix.set_both(place(a), place(b), r);
        }
        let Some(factor) = matrix.cholesky() else {
            return Err(vec![impossible(names, pairs, &named, &matrix, &mut nataf)]);
        };
        let mut copula = Self::independent(laws.len());
        for (i, &number) in named.iter().enumerate() {
            let row: Vec<(usize, f64)> =
                (0..=i).map(|j| (named[j], factor.at(i, j))).filter(|(_, entry)| *entry != 0.0).collect();
            if row.len() > 1 {
                copula.rows[number] = row;
            }
        }
        Ok(copula)
    }

    /// Whether all parameters are independent.
    #[must_use]
    pub fn is_independent(&self) -> bool {
        self.rows.iter().all(Vec::is_empty)
    }

    /// Makes independent coordinates (p and q = 1 - p) dependent; `normals` is scratch.
    pub fn apply(&self, coordinates: &mut [(f64, f64)], normals: &mut Vec<f64>) {
        if self.is_independent() {
            return;
        }
        normals.clear();
        normals.extend(coordinates.iter().map(|&(p, q)| normal_quantile(p, q)));
        for (row, coordinate) in self.rows.iter().zip(coordinates) {
            if !row.is_empty() {
                *coordinate = normal_tails(row.iter().map(|&(j, entry)| entry * normals[j]).sum());
            }
        }
    }
}

/// The correlation of the normal numbers of a pair.
fn normal(
    names: &[String],
    laws: &[Uncertain],
    pairs: &[Pair],
    number: usize,
    nataf: &mut Nataf<'_>,
) -> Result<f64, CorrelationError> {
    let Pair { between: [a, b], strength } = pairs[number];
    let (key, given) = strength.parts();
    let pair = number;
    if a == b {
        return Err(CorrelationError::Itself { pair, name: names[a].clone() });
    }
    let same = |other: &Pair| other.between == [a, b] || other.between == [b, a];
    if let Some(first) = pairs[..number].iter().position(same) {
        return Err(CorrelationError::Repeated { pair, first, a: names[a].clone(), b: names[b].clone() });
    }
    if !(given > -1.0 && given < 1.0) {
        return Err(CorrelationError::Value { pair, key, given });
    }
    if !matches!(strength, Strength::Normal(_))
        && let Some(&one) = [a, b].iter().find(|one| !laws[**one].is_ordered())
    {
        let law = match &laws[one] {
            Uncertain::Periodic(..) => "periodic",
            _ => "discrete",
        };
        return Err(CorrelationError::NotContinuous { pair, key, name: names[one].clone(), law });
    }
    match strength {
        Strength::Rank(rank) => Ok(2.0 * libm::sin(PI * rank / 6.0)),
        Strength::Normal(r) => Ok(r),
        Strength::Linear(linear) => nataf.normal(a, b, linear).map_err(|refused| {
            let (a, b) = (names[a].clone(), names[b].clone());
            match refused {
                Refused::Unreachable { low, high } => CorrelationError::Unreachable { pair, given, a, b, low, high },
                Refused::Unresolved { bound, reason } => {
                    CorrelationError::Unresolved { pair, given, a, b, bound, reason }
                }
            }
        }),
    }
}

/// Error for an impossible matrix, with the nearest possible one: its numbers are rounded to the fewest digits with which it stays possible.
fn impossible(
    names: &[String],
    pairs: &[Pair],
    named: &[usize],
    matrix: &CorrelationMatrix,
    nataf: &mut Nataf<'_>,
) -> CorrelationError {
    // rounding an entry to five digits cannot make an eigenvalue negative
    let found = nearest(matrix, 1e-5 * named.len() as f64);
    let mut exact = Vec::new();
    for i in 0..named.len() {
        for j in 0..i {
            let (a, b, r) = (named[j], named[i], found.at(i, j));
            let pair = pairs.iter().position(|pair| pair.between == [a, b] || pair.between == [b, a]);
            let strength = match pair.map(|pair| pairs[pair].strength) {
                Some(Strength::Rank(_)) => Strength::Rank(6.0 / PI * libm::asin(0.5 * r)),
                Some(Strength::Linear(_)) => Strength::Linear(nataf.linear(a, b, r)),
                _ => Strength::Normal(r),
            };
            exact.push((pair, [j, i], strength));
        }
    }
    let mut listed = Vec::new();
    // a linear correlation may need more digits than it was given with
    for ten in [1e5, 1e7, 1e9, 1e12] {
        listed.clear();
        let mut rounded = CorrelationMatrix::identity(named.len());
        for &(pair, [j, i], strength) in &exact {
            let (key, value) = strength.parts();
            let nearest = libm::round(value * ten) / ten;
            if pair.is_none() && nearest == 0.0 {
                continue;
            }
            let r = match strength {
                Strength::Rank(_) => 2.0 * libm::sin(PI * nearest / 6.0),
                Strength::Linear(_) => nataf.normal(named[j], named[i], nearest).unwrap_or(f64::NAN),
                Strength::Normal(_) => nearest,
            };
            rounded.set_both(i, j, r);
            let given = pair.map(|pair| pairs[pair].strength.parts().1);
            let names = [names[named[j]].clone(), names[named[i]].clone()];
            listed.push(Possible { pair, names, key, given, nearest });
        }
        if rounded.cholesky().is_some() {
            break;
        }
    }
    CorrelationError::Impossible { pair: 0, nearest: listed }
}
