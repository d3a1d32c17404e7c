//! Allowed numbers of a key.

use super::bounds;

/// An interval, open or closed at each end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    low: f64,
    low_allowed: bool,
    high: f64,
    high_allowed: bool,
}

impl Range {
    /// Every finite number.
    pub const ANY: Range = Range::new(f64::NEG_INFINITY, false, f64::INFINITY, false);
    /// Above zero.
    pub const POSITIVE: Range = Range::new(0.0, false, f64::INFINITY, false);
    /// Zero or more.
    pub const NOT_NEGATIVE: Range = Range::new(0.0, true, f64::INFINITY, false);

    const fn new(low: f64, low_allowed: bool, high: f64, high_allowed: bool) -> Self {
        Self { low, low_allowed, high, high_allowed }
    }

    /// Strictly between two numbers.
    #[must_use]
    pub const fn between(low: f64, high: f64) -> Self {
        Self::new(low, false, high, false)
    }

    /// From `low` to `high`, both allowed.
    #[must_use]
    pub const fn from_to(low: f64, high: f64) -> Self {
        Self::new(low, true, high, true)
    }

    /// Replaces infinite ends by the limits of the unit; an interval with a finite high end stays as it is. An open lower end becomes the
    /// smallest number of the unit.
    pub(super) const fn bounded(self, unit: &str) -> Self {
        if self.high < f64::INFINITY {
            return self;
        }
        let (least, most) = bounds::of(unit);
        let (low, low_allowed) = if self.low == f64::NEG_INFINITY {
            (-most, true)
        } else if self.low_allowed {
            (self.low, true)
        } else {
            (least, true)
        };
        Self::new(low, low_allowed, most, true)
    }

    /// From the negative of the high end to the high end.
    #[must_use]
    pub const fn mirrored(self) -> Self {
        Self::new(-self.high, self.high_allowed, self.high, self.high_allowed)
    }

    /// Smallest and largest number of the interval; for an open end its limit.
    #[must_use]
    pub const fn ends(self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Whether the number is allowed; NaN and infinities never are.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        let above = value > self.low || self.low_allowed && value == self.low;
        let below = value < self.high || self.high_allowed && value == self.high;
        value.is_finite() && above && below
    }

    /// Description with the SI unit: "> 0 m", "2 to 10000".
    #[must_use]
    pub fn words(self, unit: &str) -> String {
        let with_unit = |text: String| if unit.is_empty() { text } else { format!("{text} {unit}") };
        let sign = |allowed| if allowed { "=" } else { "" };
        match (self.low.is_finite(), self.high.is_finite()) {
            (false, false) => with_unit("any number".to_owned() + if unit.is_empty() { "" } else { " in" }),
            (true, false) => with_unit(format!(">{} {}", sign(self.low_allowed), short(self.low))),
            (false, true) => with_unit(format!("<{} {}", sign(self.high_allowed), short(self.high))),
            (true, true) if self.low_allowed && self.high_allowed => {
                with_unit(format!("{} to {}", short(self.low), short(self.high)))
            }
            (true, true) => with_unit(format!("> {} and < {}", short(self.low), short(self.high))),
        }
    }
}

/// A limit in short notation.
fn short(number: f64) -> String {
    let size = number.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) { number.to_string() } else { format!("{number:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_count_as_written() {
        assert!(!Range::POSITIVE.contains(0.0) && Range::NOT_NEGATIVE.contains(0.0));
        assert!(!Range::between(-1.0, 0.5).contains(0.5) && Range::from_to(1.0, 4.0).contains(4.0));
        assert!(!Range::ANY.contains(f64::NAN) && !Range::ANY.contains(f64::INFINITY));
    }

    #[test]
    fn words_name_the_limits_and_the_unit() {
        assert_eq!(Range::POSITIVE.words("m"), "> 0 m");
        assert_eq!(Range::NOT_NEGATIVE.words(""), ">= 0");
        assert_eq!(Range::between(-1.0, 0.5).words(""), "> -1 and < 0.5");
        assert_eq!(Range::from_to(1.0, 10_000.0).words(""), "1 to 10000");
        assert_eq!(Range::ANY.words("m/s2"), "any number in m/s2");
        assert_eq!(Range::POSITIVE.bounded("m").words("m"), "1e-9 to 1e6 m");
    }

    #[test]
    fn what_has_no_end_ends_where_its_unit_does() {
        assert_eq!(Range::POSITIVE.bounded("m").ends(), [1e-9, 1e6]);
        assert_eq!(Range::NOT_NEGATIVE.bounded("m").ends(), [0.0, 1e6]);
        assert_eq!(Range::ANY.bounded("m").ends(), [-1e6, 1e6]);
        assert_eq!(Range::NOT_NEGATIVE.bounded("m").mirrored(), Range::ANY.bounded("m"));
        assert_eq!(Range::from_to(1.0, 4.0).bounded("m"), Range::from_to(1.0, 4.0));
        assert_eq!(Range::between(-1.0, 0.5).bounded(""), Range::between(-1.0, 0.5));
    }
}
