//! Basis change between two neighbouring modal bases, in as many equal parts as there are speed intervals between them.
//!
//! ```text
//! X = L+ R = 1 + N:     X^a = 1 + a N + a (a - 1)/2 N^2 + ...,     a = 1/m and -1/m                                       (1)
//! ```
//! `R`: right vectors of one basis, `L+`: left vectors of the next, `m`: intervals between them, `X`: modal state of the one basis in the other.
//! Modal planes are aligned with their neighbour (`modal_planes`), so the blocks of X on them are 1 except for second-order terms, and N is small.
//! Where N is not small (a plane is not found again, or modes cross within a grid spacing), X is applied at once in the middle between the bases.
//! Verified by the test below and by `modal_states_are_transformed_from_basis_to_basis_gradually_and_at_once` (`speed_grid.rs`).

use bladeoff_numerics::linalg::lanes::add_scaled;
use bladeoff_numerics::linalg::{Matrix, mul};

/// Largest Frobenius norm of N for a gradual change by (1).
const MAX_GRADUAL_NORM: f64 = 0.3;

/// Basis change between two modal bases; each array holds the matrices for rising and for falling speed.
#[derive(Debug, Clone)]
pub(crate) enum BasisChange {
    /// Change over half an interval and over a whole one: `X^(1/2m)` and `X^(1/m)`.
    Gradual { half: [Matrix; 2], whole: [Matrix; 2] },
    /// X and its inverse, applied in the middle between the bases.
    AtOnce([Matrix; 2]),
}

impl BasisChange {
    /// Basis change with X upwards and downwards, and `intervals` speed intervals between the bases.
    pub fn new(up: Matrix, down: Matrix, intervals: i64) -> Self {
        let size = up.nrows();
        let n = &up - Matrix::identity(size, size);
        if n.norm() > MAX_GRADUAL_NORM {
            return BasisChange::AtOnce([up, down]);
        }
        let half = powers(&n, 0.5 / intervals as f64);
        BasisChange::Gradual { whole: half.each_ref().map(|half| mul(half, half)), half }
    }
}

/// Powers `(1 + N)^a` and `(1 + N)^-a`, whose binomial series share the powers of N.
fn powers(n: &Matrix, a: f64) -> [Matrix; 2] {
    let identity = Matrix::identity(n.nrows(), n.ncols());
    let (exponents, mut factors) = ([a, -a], [a, -a]);
    let (mut sums, mut power, mut k) = ([identity.clone() + n * a, identity - n * a], n.clone(), 1.0);
    while factors[1].abs() * power.norm() > 1e-17 {
        power = mul(&power, n);
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
            let diagonal = if i == j { 1.0 } else { 0.0 };
            diagonal + 0.01 * (((i * 7 + j * 5) % 11) as f64 - 5.0) / 5.0
        });
        let down = bladeoff_numerics::linalg::inverse(&up).expect("regular");
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
