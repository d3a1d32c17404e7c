//! Angles: results in rad are directions, so 3.1 and -3.1 differ by 0.08.
//!
//! ```text
//! B - A   in [-pi, pi], along the shorter arc
//! mean    direction of the sum of unit vectors
//! ```

use crate::estimate::figures::Sum;
use std::f64::consts::TAU;

/// Unit of the columns whose values are angles.
const ANGLE: &str = "rad";

/// Whether the values of a column are angles.
pub(super) fn is_angle(unit: &str) -> bool {
    unit == ANGLE
}

/// B - A in the unit of a column.
pub(super) fn difference(unit: &str, a: f64, b: f64) -> f64 {
    if is_angle(unit) { libm::remainder(b - a, TAU) } else { b - a }
}

/// Mean of numbers or of angles.
#[derive(Default)]
pub(super) struct Mean {
    count: f64,
    sum: Sum,
    sine: Sum,
    cosine: Sum,
}

impl Mean {
    pub fn add(&mut self, unit: &str, value: f64) {
        self.count += 1.0;
        self.sum.add(value);
        if is_angle(unit) {
            self.sine.add(libm::sin(value));
            self.cosine.add(libm::cos(value));
        }
    }

    /// The mean; NaN without values.
    pub fn value(&self, unit: &str) -> f64 {
        match is_angle(unit) && self.count > 0.0 {
            true => libm::atan2(self.sine.value(), self.cosine.value()),
            false => self.sum.value() / self.count,
        }
    }
}

/// The angles of two columns within half a turn of the mean of A, so that their means and quantiles are those of numbers.
pub(super) fn unwrapped(unit: &str, a: &[f64], b: &[f64]) -> [Vec<f64>; 2] {
    let mut mean = Mean::default();
    a.iter().filter(|value| !value.is_nan()).for_each(|value| mean.add(unit, *value));
    let middle = Some(mean.value(unit)).filter(|mean| mean.is_finite()).unwrap_or(0.0);
    [a, b].map(|values| values.iter().map(|value| middle + difference(unit, middle, *value)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn angles_differ_the_short_way_round_and_other_numbers_as_they_are() {
        for (a, b, expected) in
            [(3.1, -3.1, TAU - 6.2), (-3.1, 3.1, 6.2 - TAU), (PI, -PI, 0.0), (0.1, 0.3, 0.2), (0.0, 7.0, 7.0 - TAU)]
        {
            let found = difference("rad", a, b);
            assert!((found - expected).abs() < 1e-14, "{a} {b}: {found}");
        }
        assert_eq!(difference("N", 3.1, -3.1), -6.2);
        assert!(difference("rad", f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn the_mean_of_angles_beside_the_cut_is_beside_the_cut() {
        let mut mean = Mean::default();
        [3.1, -3.1, PI].iter().for_each(|angle| mean.add("rad", *angle));
        assert!((mean.value("rad").abs() - PI).abs() < 1e-12, "{}", mean.value("rad"));
        assert!(Mean::default().value("rad").is_nan());
        let [a, b] = unwrapped("rad", &[3.1, f64::NAN, PI], &[-3.1]);
        assert!(a[1].is_nan() && (b[0] - (TAU - 3.1)).abs() < 1e-12 && (a[0] - 3.1).abs() < 1e-12, "{a:?} {b:?}");
    }
}
