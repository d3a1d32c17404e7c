//! `--scale F`: fewer points of an axis, including its end points.

/// An axis with a part of its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Thinned {
    length: u64,
    kept: u64,
}

impl Thinned {
    /// Keeps `max(2, round(length * factor))` points, spread evenly; an axis of one point stays.
    #[must_use]
    pub fn new(length: u64, factor: f64) -> Self {
        // Axis lengths are far below 2^53; the limit on samples rejects longer axes.
        let wanted = (length as f64 * factor).round() as u64;
        Self { length, kept: wanted.clamp(2.min(length), length) }
    }

    /// Number of points kept.
    #[must_use]
    pub fn kept(&self) -> u64 {
        self.kept
    }

    /// Position on the whole axis of kept point `position` < `kept()`.
    #[must_use]
    pub fn original(&self, position: u64) -> u64 {
        if self.kept < 2 {
            return 0;
        }
        // round(position * (length - 1) / (kept - 1)) in integers: the last point is kept exactly.
        let (span, parts) = (u128::from(self.length - 1), u128::from(self.kept - 1));
        let rounded = (2 * u128::from(position) * span + parts) / (2 * parts);
        u64::try_from(rounded).expect("at most length - 1, a u64")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn kept_points_ascend_from_the_first_to_the_last(length in 1u64..2000, factor in 0.001f64..=1.0) {
            let axis = Thinned::new(length, factor);
            let points: Vec<u64> = (0..axis.kept()).map(|position| axis.original(position)).collect();
            prop_assert!(points.len() as u64 >= length.min(2));
            prop_assert_eq!(points[0], 0);
            prop_assert_eq!(points[points.len() - 1], length - 1);
            prop_assert!(points.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn factor_one_keeps_every_point() {
        let axis = Thinned::new(7, 1.0);
        assert_eq!((0..axis.kept()).map(|p| axis.original(p)).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5, 6]);
    }
}
