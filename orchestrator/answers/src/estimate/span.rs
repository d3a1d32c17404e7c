//! Interval arithmetic for numbers of which only bounds are known.
//!
//! A span contains every possible value of a number. It also records whether the number may be missing: because an event did not happen
//! (`empty`), or because a formula has no value (`lost`; the logarithm of a negative number). [`super::truth`] treats the two differently.
//! The bounds of a result are the operation applied to the bounds of its operands. Plain operations round monotonically, so no value lies
//! outside; functions of `libm` are only accurate to the last digit, and their bounds are widened a little. An infinite bound is no bound.
//! Source: R. E. Moore, "Interval analysis" (1966). Verified by `tests/uncertainty/spans.rs`: values drawn inside stay inside.

use bladeoff_text::formula::{Function, call};

/// Relative widening of the bounds of a `libm` function.
const OUT: f64 = 1e-15;

/// Bounds on a number. `lo > hi` means that there is no value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Lower bound.
    pub lo: f64,
    /// Upper bound.
    pub hi: f64,
    /// Whether the number may be missing.
    pub empty: bool,
    /// Whether the number may be missing because a formula has no value; then `empty` holds as well.
    pub lost: bool,
}

impl Span {
    /// An unknown number.
    pub const WHOLE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, empty: true, lost: false };
    /// An unknown number whose formula may have no value.
    pub const LOST: Self = Self { lost: true, ..Self::WHOLE };
    /// A missing number.
    pub const NONE: Self = Self { lo: f64::INFINITY, hi: f64::NEG_INFINITY, empty: true, lost: false };

    /// A known number; NaN is a missing one.
    #[must_use]
    pub fn point(value: f64) -> Self {
        if value.is_nan() { Self::NONE } else { Self { lo: value, hi: value, empty: false, lost: false } }
    }

    /// A result of an operation on known numbers; NaN is lost.
    #[must_use]
    pub fn result(value: f64) -> Self {
        if value.is_nan() { Self { lost: true, ..Self::NONE } } else { Self::point(value) }
    }

    /// A number of at least this value.
    #[must_use]
    pub fn from(value: f64) -> Self {
        Self { lo: value, hi: f64::INFINITY, empty: false, lost: false }
    }

    /// The number, if it is known.
    #[must_use]
    pub fn known(self) -> Option<f64> {
        (self.lo == self.hi && !self.empty).then_some(self.lo)
    }

    fn is_none(self) -> bool {
        self.lo > self.hi
    }

    fn is_unbounded(self) -> bool {
        self.lo == f64::NEG_INFINITY || self.hi == f64::INFINITY
    }

    fn holds(self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }

    /// A missing number; lost if one of the operands is.
    fn nothing(of: &[Self]) -> Self {
        Self { lost: of.iter().any(|one| one.lost), ..Self::NONE }
    }

    /// An unknown number, missing or lost if one of the operands may be; `lost`: the operation itself may have no value.
    fn doubts(of: &[Self], lost: bool) -> Self {
        let (empty, lost) = (of.iter().any(|one| one.empty) || lost, of.iter().any(|one| one.lost) || lost);
        Self { empty, lost, ..Self::WHOLE }
    }

    /// The span with these bounds; unknown if one of them is NaN.
    fn ends(self, lo: f64, hi: f64) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::LOST } else { Self { lo, hi, ..self } }
    }

    /// Result of an increasing function of `libm`.
    fn grown(self, of: impl Fn(f64) -> f64) -> Self {
        self.ends(of(self.lo), of(self.hi)).widened()
    }

    fn widened(self) -> Self {
        let out = |end: f64, sign: f64| if end.is_finite() { end + sign * OUT * end.abs() } else { end };
        self.ends(out(self.lo, -1.0), out(self.hi, 1.0))
    }

    /// The span with the least and the largest of the values at four corners.
    fn corners(self, values: [f64; 4]) -> Self {
        if values.iter().any(|value| value.is_nan()) {
            return Self::LOST;
        }
        let (lo, hi) = values[1..].iter().fold((values[0], values[0]), |(lo, hi), &v| (lo.min(v), hi.max(v)));
        Self { lo, hi, ..self }
    }

    /// -a.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo, ..self }
    }

    /// a + b.
    #[must_use]
    pub fn plus(self, b: Self) -> Self {
        if self.is_none() || b.is_none() {
            return Self::nothing(&[self, b]);
        }
        let opposed = (self.hi == f64::INFINITY && b.lo == f64::NEG_INFINITY)
            || (self.lo == f64::NEG_INFINITY && b.hi == f64::INFINITY);
        Self::doubts(&[self, b], opposed).ends(self.lo + b.lo, self.hi + b.hi)
    }

    /// a b.
    #[must_use]
    pub fn times(self, b: Self) -> Self {
        if self.is_none() || b.is_none() {
            return Self::nothing(&[self, b]);
        }
        // an unbounded number times 0 is 0 here; infinity times 0 would be NaN
        let product = |x: f64, y: f64| if x == 0.0 || y == 0.0 { 0.0 } else { x * y };
        let lost = (self.is_unbounded() && b.holds(0.0)) || (b.is_unbounded() && self.holds(0.0));
        let all = [product(self.lo, b.lo), product(self.lo, b.hi), product(self.hi, b.lo), product(self.hi, b.hi)];
        Self::doubts(&[self, b], lost).corners(all)
    }

    /// a / b.
    #[must_use]
    pub fn over(self, b: Self) -> Self {
        if self.is_none() || b.is_none() {
            return Self::nothing(&[self, b]);
        }
        if b.holds(0.0) || (self.is_unbounded() && b.is_unbounded()) {
            return Self::LOST;
        }
        Self::doubts(&[self, b], false).corners([self.lo / b.lo, self.lo / b.hi, self.hi / b.lo, self.hi / b.hi])
    }

    /// a ^ b.
    #[must_use]
    pub fn power(self, b: Self) -> Self {
        // pow(x, 0) = pow(1, y) = 1 even if the other operand is NaN
        if self.is_none() || b.is_none() || self.empty || b.empty {
            return Self::LOST;
        }
        let pow = libm::pow;
        if self.lo > 0.0 || (self.lo == 0.0 && b.lo > 0.0) {
            let all = [pow(self.lo, b.lo), pow(self.lo, b.hi), pow(self.hi, b.lo), pow(self.hi, b.hi)];
            return Self::doubts(&[], false).corners(all).widened();
        }
        match b.known() {
            Some(n) if n > 0.0 && libm::fmod(n, 2.0) == 0.0 => self.absolute().grown(|x| pow(x, n)),
            Some(n) if n > 0.0 && libm::fmod(n, 2.0) == 1.0 => self.grown(|x| pow(x, n)),
            _ => Self::LOST,
        }
    }

    fn absolute(self) -> Self {
        if self.lo >= 0.0 {
            self
        } else if self.hi <= 0.0 {
            self.negated()
        } else {
            Self { lo: 0.0, hi: self.hi.max(-self.lo), ..self }
        }
    }

    /// The part within the domain of a function.
    fn within(self, from: f64, to: f64) -> Self {
        let outside = self.lo < from || self.hi > to;
        Self::doubts(&[self], outside).ends(self.lo.max(from), self.hi.min(to))
    }

    /// Result of a function of at least one span.
    #[must_use]
    pub fn of(function: Function, arguments: &[Self]) -> Self {
        let (a, b) = (arguments[0], arguments[arguments.len() - 1]);
        // leave open what these functions return for a missing number
        if arguments.iter().any(|argument| argument.is_none()) {
            return match function {
                Function::Hypot => Self { empty: true, ..Self::doubts(arguments, false) },
                _ => Self::nothing(arguments),
            };
        }
        let doubts = Self::doubts(arguments, false);
        let extremes = |pick: fn(f64, f64) -> f64| {
            let step = |kept: Self, next: &Self| doubts.ends(pick(kept.lo, next.lo), pick(kept.hi, next.hi));
            arguments[1..].iter().fold(doubts.ends(a.lo, a.hi), step)
        };
        let one = |x: f64| call(function, &[x]);
        let defined = |from: f64, to: f64| {
            let part = a.within(from, to);
            if part.is_none() { Self::nothing(&[part]) } else { part.grown(one) }
        };
        match function {
            Function::Abs => a.absolute(),
            Function::Floor => a.ends(one(a.lo), one(a.hi)),
            Function::Exp | Function::Atan => a.grown(one),
            Function::Sqrt | Function::Ln | Function::Log10 => defined(0.0, f64::INFINITY),
            Function::Asin => defined(-1.0, 1.0),
            Function::Acos => {
                let part = a.within(-1.0, 1.0);
                if part.is_none() { Self::nothing(&[part]) } else { part.ends(one(part.hi), one(part.lo)).widened() }
            }
            Function::Sin | Function::Cos => Self::doubts(arguments, a.is_unbounded()).ends(-1.0, 1.0),
            Function::Tan => Self::LOST,
            Function::Atan2 => doubts.ends(-core::f64::consts::PI, core::f64::consts::PI),
            Function::Hypot => {
                let (x, y) = (a.absolute(), b.absolute());
                doubts.ends(libm::hypot(x.lo, y.lo), libm::hypot(x.hi, y.hi)).widened()
            }
            Function::Min => extremes(f64::min),
            Function::Max => extremes(f64::max),
        }
    }
}
