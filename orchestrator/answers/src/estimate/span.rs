//! Numbers of which only bounds are known.
//!
//! A span holds every value that the number may have, and whether it may have none. Its ends are the operation's results at the
//! ends of its operands: plain operations round monotonically, so no value lies outside; functions of `libm` do so to the last
//! digit only, and their ends are moved out by a few. An end at infinity says that there is no bound.
//! Source: R. E. Moore, "Interval analysis" (1966). Verified by `tests/uncertainty/spans.rs`: values drawn inside stay inside.

use bladeoff_model::formula::{Function, call};

/// By how much the ends of a function's span are moved out, relative.
const OUT: f64 = 1e-15;

/// What a number may be. No value at all: `lo > hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Least value.
    pub lo: f64,
    /// Largest value.
    pub hi: f64,
    /// It may be no number.
    pub empty: bool,
}

impl Span {
    /// Nothing is known.
    pub const WHOLE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, empty: true };
    /// It is no number.
    pub const NONE: Self = Self { lo: f64::INFINITY, hi: f64::NEG_INFINITY, empty: true };

    /// A number that is known.
    #[must_use]
    pub fn point(value: f64) -> Self {
        if value.is_nan() { Self::NONE } else { Self { lo: value, hi: value, empty: false } }
    }

    /// At least this.
    #[must_use]
    pub fn from(value: f64) -> Self {
        Self { lo: value, hi: f64::INFINITY, empty: false }
    }

    /// The number, where it is known.
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

    /// From ends of which one may be no number: then the value may be anything.
    fn ends(lo: f64, hi: f64, empty: bool) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::WHOLE } else { Self { lo, hi, empty } }
    }

    /// Of a growing function of `libm`.
    fn grown(self, of: impl Fn(f64) -> f64, empty: bool) -> Self {
        Self::ends(of(self.lo), of(self.hi), empty).widened()
    }

    fn widened(self) -> Self {
        let out = |end: f64, sign: f64| if end.is_finite() { end + sign * OUT * end.abs() } else { end };
        Self { lo: out(self.lo, -1.0), hi: out(self.hi, 1.0), empty: self.empty }
    }

    /// Least and largest of values at corners.
    fn corners(values: [f64; 4], empty: bool) -> Self {
        if values.iter().any(|value| value.is_nan()) {
            return Self::WHOLE;
        }
        let (lo, hi) = values[1..].iter().fold((values[0], values[0]), |(lo, hi), &v| (lo.min(v), hi.max(v)));
        Self { lo, hi, empty }
    }

    /// -a.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo, empty: self.empty }
    }

    /// a + b.
    #[must_use]
    pub fn plus(self, b: Self) -> Self {
        if self.is_none() || b.is_none() {
            return Self::NONE;
        }
        let opposed = (self.hi == f64::INFINITY && b.lo == f64::NEG_INFINITY)
            || (self.lo == f64::NEG_INFINITY && b.hi == f64::INFINITY);
        Self::ends(self.lo + b.lo, self.hi + b.hi, self.empty || b.empty || opposed)
    }

    /// a b.
    #[must_use]
    pub fn times(self, b: Self) -> Self {
        if self.is_none() || b.is_none() {
            return Self::NONE;
        }
        // no bound times nothing is nothing; infinity times nothing would be no number
        let product = |x: f64, y: f64| if x == 0.0 || y == 0.0 { 0.0 } else { x * y };
        let lost = (self.is_unbounded() && b.holds(0.0)) || (b.is_unbounded() && self.holds(0.0));
        let all = [product(self.lo, b.lo), product(self.lo, b.hi), product(self.hi, b.lo), product(self.hi, b.hi)];
        Self::corners(all, self.empty || b.empty || lost)
    }

    /// a / b.
    #[must_use]
    pub fn over(self, b: Self) -> Self {
        if self.is_none() || b.is_none() {
            return Self::NONE;
        }
        if b.holds(0.0) || (self.is_unbounded() && b.is_unbounded()) {
            return Self::WHOLE;
        }
        Self::corners([self.lo / b.lo, self.lo / b.hi, self.hi / b.lo, self.hi / b.hi], self.empty || b.empty)
    }

    /// a ^ b.
    #[must_use]
    pub fn power(self, b: Self) -> Self {
        // pow(x, 0) = pow(1, y) = 1 even where the other is no number
        if self.is_none() || b.is_none() || self.empty || b.empty {
            return Self::WHOLE;
        }
        let pow = libm::pow;
        if self.lo > 0.0 || (self.lo == 0.0 && b.lo > 0.0) {
            let all = [pow(self.lo, b.lo), pow(self.lo, b.hi), pow(self.hi, b.lo), pow(self.hi, b.hi)];
            return Self::corners(all, false).widened();
        }
        match b.known() {
            Some(n) if n > 0.0 && libm::fmod(n, 2.0) == 0.0 => self.absolute().grown(|x| pow(x, n), false),
            Some(n) if n > 0.0 && libm::fmod(n, 2.0) == 1.0 => self.grown(|x| pow(x, n), false),
            _ => Self::WHOLE,
        }
    }

    fn absolute(self) -> Self {
        if self.lo >= 0.0 {
            self
        } else if self.hi <= 0.0 {
            self.negated()
        } else {
            Self { lo: 0.0, hi: self.hi.max(-self.lo), empty: self.empty }
        }
    }

    /// The part of it where a function is defined.
    fn within(self, from: f64, to: f64) -> Self {
        let empty = self.empty || self.lo < from || self.hi > to;
        Self { lo: self.lo.max(from), hi: self.hi.min(to), empty }
    }

    /// A function of spans, at least one.
    #[must_use]
    pub fn of(function: Function, arguments: &[Self]) -> Self {
        let (a, b) = (arguments[0], arguments[arguments.len() - 1]);
        // what these give for no number is left open
        if arguments.iter().any(|argument| argument.is_none()) {
            return if matches!(function, Function::Hypot) { Self::WHOLE } else { Self::NONE };
        }
        let empty = arguments.iter().any(|argument| argument.empty);
        let extremes = |pick: fn(f64, f64) -> f64| {
            let step = |kept: Self, next: &Self| Self { lo: pick(kept.lo, next.lo), hi: pick(kept.hi, next.hi), empty };
            arguments[1..].iter().fold(Self { empty, ..a }, step)
        };
        let one = |x: f64| call(function, &[x]);
        let defined = |from: f64, to: f64| {
            let part = a.within(from, to);
            if part.is_none() { Self::NONE } else { part.grown(one, part.empty) }
        };
        match function {
            Function::Abs => a.absolute(),
            Function::Floor => Self::ends(one(a.lo), one(a.hi), empty),
            Function::Exp | Function::Atan => a.grown(one, empty),
            Function::Sqrt | Function::Ln | Function::Log10 => defined(0.0, f64::INFINITY),
            Function::Asin => defined(-1.0, 1.0),
            Function::Acos => {
                let part = a.within(-1.0, 1.0);
                if part.is_none() { Self::NONE } else { Self::ends(one(part.hi), one(part.lo), part.empty).widened() }
            }
            Function::Sin | Function::Cos => Self { lo: -1.0, hi: 1.0, empty: empty || a.is_unbounded() },
            Function::Tan => Self::WHOLE,
            Function::Atan2 => Self { lo: -core::f64::consts::PI, hi: core::f64::consts::PI, empty },
            Function::Hypot => {
                let (x, y) = (a.absolute(), b.absolute());
                Self::ends(libm::hypot(x.lo, y.lo), libm::hypot(x.hi, y.hi), empty).widened()
            }
            Function::Min => extremes(f64::min),
            Function::Max => extremes(f64::max),
        }
    }
}
