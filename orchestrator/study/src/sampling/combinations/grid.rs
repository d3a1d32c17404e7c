//! Mixed-radix numbering of a grid: the first axis is the slowest, as in nested loops.

/// A full grid of axes with at least one point each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    lengths: Vec<u64>,
    count: u64,
}

impl Grid {
    /// A grid with these axis lengths; without axes there is one empty combination.
    ///
    /// # Errors
    /// The number of combinations (at most `u128::MAX`) if it exceeds `limit`.
    pub fn new(lengths: &[u64], limit: u64) -> Result<Self, u128> {
        let count = lengths.iter().fold(1u128, |product, &length| product.saturating_mul(u128::from(length)));
        match u64::try_from(count) {
            Ok(count) if count <= limit => Ok(Self { lengths: lengths.to_vec(), count }),
            _ => Err(count),
        }
    }

    /// Number of combinations.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Position on each axis of combination `index` < `count()`.
    #[must_use]
    pub fn positions(&self, index: u64) -> Vec<u64> {
        debug_assert!(index < self.count);
        let mut rest = index;
        let mut positions = vec![0; self.lengths.len()];
        for (position, &length) in positions.iter_mut().zip(&self.lengths).rev() {
            *position = rest % length;
            rest /= length;
        }
        positions
    }

    /// The combination at these positions: the inverse of [`Grid::positions`].
    #[must_use]
    pub fn index(&self, positions: &[u64]) -> u64 {
        positions.iter().zip(&self.lengths).fold(0, |index, (&position, &length)| index * length + position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn index_and_positions_are_inverse(lengths in prop::collection::vec(1u64..9, 0..6), pick: u64) {
            let grid = Grid::new(&lengths, u64::MAX).expect("fits");
            let index = pick % grid.count();
            prop_assert_eq!(grid.index(&grid.positions(index)), index);
        }
    }

    #[test]
    fn first_axis_is_the_slowest() {
        let grid = Grid::new(&[2, 3], 6).expect("six");
        assert_eq!(grid.positions(0), [0, 0]);
        assert_eq!(grid.positions(1), [0, 1]);
        assert_eq!(grid.positions(3), [1, 0]);
    }
}
