//! The combinations of a study and their order: pure functions of (axis lengths, seed, index).
//!
//! ```text
//! axis lengths  n_0, n_1, ..., n_m          as the study file gives them; the first axis is the slowest
//!   thin        n_i -> max(2, round(n_i F)) end points kept (`--scale F`)
//!   grid        index <-> one position per axis (mixed radix)
//!   shuffle     a permutation of the indices, pure in (seed, count); `--limit N` takes its first N
//!   selection   sample 0..n of the present study -> index; ascending, so that the table reads like the grid
//! ```
//! The samples themselves are not stored: each is computed from its number when needed.

mod grid;
mod thin;

pub use grid::Grid;
pub use thin::Thinned;

use super::shuffle::Shuffle;

/// The combinations of a study after `--scale` and `--limit`.
#[derive(Debug, Clone, PartialEq)]
pub struct Combinations {
    axes: Vec<Thinned>,
    grid: Grid,
    selected: Option<Vec<u64>>,
}

/// Reason for rejecting a set of combinations.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CombinationError {
    /// The product of the axis lengths is too large.
    #[error("the study has {count} samples; at most {limit} are allowed")]
    TooMany {
        /// Product of the axis lengths.
        count: u128,
        /// Largest allowed number.
        limit: u64,
    },
    /// A scale factor outside (0, 1].
    #[error("the scale is {value}; it must be above 0 and at most 1")]
    Scale {
        /// Scale as given.
        value: f64,
    },
    /// A limit of 0.
    #[error("the limit is 0; it must be at least 1")]
    Nothing,
}

impl Combinations {
    /// Most samples of one study: a million core-hours at half a minute each.
    pub const LIMIT: u64 = 100_000_000;

    /// Combinations of axes with these lengths (each >= 1), thinned by `scale` and limited to `limit` samples.
    ///
    /// # Errors
    /// More than [`Combinations::LIMIT`] samples after thinning, a scale outside (0, 1], or a limit of 0.
    pub fn new(lengths: &[u64], seed: u64, scale: Option<f64>, limit: Option<u64>) -> Result<Self, CombinationError> {
        let factor = scale.unwrap_or(1.0);
        if !(factor > 0.0 && factor <= 1.0) {
            return Err(CombinationError::Scale { value: factor });
        }
        if limit == Some(0) {
            return Err(CombinationError::Nothing);
        }
        let axes: Vec<Thinned> = lengths.iter().map(|&length| Thinned::new(length, factor)).collect();
        let kept: Vec<u64> = axes.iter().map(|axis| axis.kept()).collect();
        let grid =
            Grid::new(&kept, Self::LIMIT).map_err(|count| CombinationError::TooMany { count, limit: Self::LIMIT })?;
        let selected = limit.filter(|&limit| limit < grid.count()).map(|limit| {
            let shuffle = Shuffle::new(seed, grid.count());
            let mut first: Vec<u64> = (0..limit).map(|position| shuffle.apply(position)).collect();
            first.sort_unstable();
            first
        });
        Ok(Self { axes, grid, selected })
    }

    /// Combinations with the `points` of a design of uncertain parameters as the slowest axis, not thinned, and axes with these lengths, thinned.
    ///
    /// # Errors
    /// As [`Combinations::new`].
    pub fn of_points(points: u64, lengths: &[u64], scale: Option<f64>) -> Result<Self, CombinationError> {
        let mut design = Self::new(lengths, 0, scale, None)?;
        design.axes.insert(0, Thinned::new(points, 1.0));
        let kept = design.kept();
        let limit = Self::LIMIT;
        design.grid = Grid::new(&kept, limit).map_err(|count| CombinationError::TooMany { count, limit })?;
        Ok(design)
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.selected.as_ref().map_or(self.grid.count(), |selected| selected.len() as u64)
    }

    /// Number of kept points of each axis.
    #[must_use]
    pub fn kept(&self) -> Vec<u64> {
        self.axes.iter().map(|axis| axis.kept()).collect()
    }

    /// Position on each axis, in the numbering of the study file, of sample `sample` < `count()`.
    #[must_use]
    pub fn positions(&self, sample: u64) -> Vec<u64> {
        let index = match &self.selected {
            Some(selected) => selected[usize::try_from(sample).expect("a sample number indexes memory")],
            None => sample,
        };
        let mut positions = self.grid.positions(index);
        for (position, axis) in positions.iter_mut().zip(&self.axes) {
            *position = axis.original(*position);
        }
        positions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn all(design: &Combinations) -> Vec<Vec<u64>> {
        (0..design.count()).map(|sample| design.positions(sample)).collect()
    }

    proptest! {
        #[test]
        fn every_combination_comes_exactly_once(lengths in prop::collection::vec(1u64..6, 0..5), seed: u64) {
            let design = Combinations::new(&lengths, seed, None, None).expect("a small grid");
            let samples = all(&design);
            prop_assert_eq!(samples.len() as u64, lengths.iter().product::<u64>());
            prop_assert!(samples.windows(2).all(|pair| pair[0] < pair[1]), "ascending, first axis slowest");
            prop_assert!(samples.iter().all(|p| p.iter().zip(&lengths).all(|(p, n)| p < n)));
        }

        #[test]
        fn a_larger_limit_holds_the_smaller_one(lengths in prop::collection::vec(1u64..7, 1..4), seed: u64, a in 1u64..40, b in 1u64..40) {
            let (a, b) = (a.min(b), a.max(b));
            let few: BTreeSet<_> = all(&Combinations::new(&lengths, seed, None, Some(a)).expect("small")).into_iter().collect();
            let many: BTreeSet<_> = all(&Combinations::new(&lengths, seed, None, Some(b)).expect("small")).into_iter().collect();
            let whole = lengths.iter().product::<u64>();
            prop_assert_eq!(few.len() as u64, a.min(whole));
            prop_assert_eq!(many.len() as u64, b.min(whole));
            prop_assert!(few.is_subset(&many));
        }
    }

    #[test]
    fn thinning_keeps_the_end_points_of_every_axis() {
        let design = Combinations::new(&[9, 1, 3], 1, Some(0.01), None).expect("small");
        assert_eq!(design.kept(), [2, 1, 2]);
        assert_eq!(all(&design), [[0, 0, 0], [0, 0, 2], [8, 0, 0], [8, 0, 2]]);
    }

    #[test]
    fn a_grid_of_a_million_millions_is_refused_with_its_count() {
        let error = Combinations::new(&[1_000_000, 1_000_000], 0, None, None).expect_err("too many");
        assert_eq!(error.to_string(), "the study has 1000000000000 samples; at most 100000000 are allowed");
        let error = Combinations::new(&[u64::MAX; 12], 0, None, None).expect_err("too many for u128, too");
        assert!(matches!(error, CombinationError::TooMany { .. }));
    }

    #[test]
    fn a_scale_outside_its_range_is_refused() {
        for scale in [0.0, -1.0, 1.5, f64::NAN] {
            assert!(matches!(Combinations::new(&[3], 0, Some(scale), None), Err(CombinationError::Scale { .. })));
        }
    }
}
