//! From one basis to the next, in as many equal parts as there are cells between them.
//!
//! ```text
//! X = L+ R = 1 + N:     X^a = 1 + a N + a (a - 1)/2 N^2 + ...,     a = 1/m and -1/m                                       (1)
//! ```
//! With the bases of [`super::pairs`], X has ones on its pairs but for second order, and N is small: what the whirl states of one speed are in
//! those of the next. Where it is not small (a pair was not found again, modes cross within a spacing), X is taken as a whole in the middle.
//! Verified by the tests below.

use crate::linalg::lanes::add_scaled;
use crate::linalg::{Matrix, mul};

/// Largest norm of N (Frobenius) for which (1) is used.
const SMALL: f64 = 0.3;

/// The change of basis between two stations, upwards and downwards.
#[derive(Debug, Clone)]
pub(crate) enum BasisChange {
    /// X to the power of half a cell and of a cell.
    Gradual { half: [Matrix; 2], whole: [Matrix; 2] },
    /// X and its inverse, in the middle.
    AtOnce([Matrix; 2]),
}

impl BasisChange {
    /// Between the right vectors below and the left vectors above, and back; `cells` between them.
    pub fn new(up: Matrix, down: Matrix, cells: i64) -> Self {
        let size = up.nrows();
        let rest = &up - Matrix::identity(size, size);
        if rest.norm() > SMALL {
            return BasisChange::AtOnce([up, down]);
        }
        let half = powers(&rest, 0.5 / cells as f64);
        BasisChange::Gradual { whole: half.each_ref().map(|half| mul(half, half)), half }
    }
}

/// `(1 + N)^a` and `(1 + N)^-a`, the binomial series of both by the same powers of N.
fn powers(rest: &Matrix, a: f64) -> [Matrix; 2] {
    let one = Matrix::identity(rest.nrows(), rest.ncols());
    let (exponents, mut factors) = ([a, -a], [a, -a]);
    let (mut sums, mut power, mut k) = ([one.clone() + rest * a, one - rest * a], rest.clone(), 1.0);
    while factors[1].abs() * power.norm() > 1e-17 {
        power = mul(&power, rest);
        for ((sum, factor), exponent) in sums.iter_mut().zip(&mut factors).zip(exponents) {
            *factor *= (exponent - k) / (k + 1.0);
            add_scaled(*factor, power.as_slice(), sum.as_mut_slice());
        }
        k += 1.0;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_parts_as_cells_are_the_whole_change() {
        let up = Matrix::from_fn(6, 6, |i, j| {
            let one = if i == j { 1.0 } else { 0.0 };
            one + 0.01 * (((i * 7 + j * 5) % 11) as f64 - 5.0) / 5.0
        });
        let down = crate::linalg::inverse(&up).expect("regular");
        let BasisChange::Gradual { half, whole } = BasisChange::new(up.clone(), down, 10) else {
            panic!("a change by a per cent is gradual");
        };
        let mut product = half[0].clone();
        for _ in 0..9 {
            product = mul(&whole[0], &product);
        }
        assert!((mul(&half[0], &product) - &up).amax() < 1e-14);
        assert!((mul(&whole[0], &whole[1]) - Matrix::identity(6, 6)).amax() < 1e-15);
        let turned = Matrix::from_row_slice(2, 2, &[0.0, 1.0, -1.0, 0.0]);
        assert!(matches!(BasisChange::new(turned.clone(), -turned, 10), BasisChange::AtOnce(_)));
    }
}
