//! Numbers of which only bounds are known.
//!
//! A span holds every value that the number may have, and whether it may have none: because nothing of the kind happened, or because a
//! formula has no value there (the logarithm of a negative number), which is not the same ([`super::truth`]). Its ends are the operation's results at the
//! ends of its operands: plain operations round monotonically, so no value lies outside; functions of `libm` do so to the last
//! digit only, and their ends are moved out by a few. An end at infinity says that there is no bound.
//! Source: R. E. Moore, "Interval analysis" (1966). Verified by `tests/uncertainty/spans.rs`: values drawn inside stay inside.

use bladeoff_text::formula::{Function, call};

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
    /// It may be no number because a formula has no value; then it is `empty`, too.
    pub lost: bool,
}

impl Span {
    /// Nothing is known.
    pub const WHOLE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, empty: true, lost: false };
    /// Nothing is known, and a formula may have no value.
    pub const LOST: Self = Self { lost: true, ..Self::WHOLE };
    /// It is no number.
    pub const NONE: Self = Self { lo: f64::INFINITY, hi: f64::NEG_INFINITY, empty: true, lost: false };

    /// A number that is known.
    #[must_use]
    pub fn point(value: f64) -> Self {
        if value.is_nan() { Self::NONE } else { Self { lo: value, hi: value, empty: false, lost: false } }
    }

    /// What an operation gives for numbers that are known.
    #[must_use]
    pub fn result(value: f64) -> Self {
        if value.is_nan() { Self { lost: true, ..Self::NONE } } else { Self::point(value) }
    }

    /// At least this.
    #[must_use]
    pub fn from(value: f64) -> Self {
        Self { lo: value, hi: f64::INFINITY, empty: false, lost: false }
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

    /// Without values; what is lost stays lost.
    fn nothing(of: &[Self]) -> Self {
        Self { lost: of.iter().any(|one| one.lost), ..Self::NONE }
    }

    /// As little known as these; `lost`: or because a formula has no value.
    fn doubts(of: &[Self], lost: bool) -> Self {
        let (empty, lost) = (of.iter().any(|one| one.empty) || lost, of.iter().any(|one| one.lost) || lost);
        Self { empty, lost, ..Self::WHOLE }
    }

    /// With these ends, of which one may be no number: then the value may be anything.
    fn ends(self, lo: f64, hi: f64) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::LOST } else { Self { lo, hi, ..self } }
    }

    /// Of a growing function of `libm`.
    fn grown(self, of: impl Fn(f64) -> f64) -> Self {
        self.ends(of(self.lo), of(self.hi)).widened()
    }

    fn widened(self) -> Self {
        let out = |end: f64, sign: f64| if end.is_finite() { end + sign * OUT * end.abs() } else { end };
        self.ends(out(self.lo, -1.0), out(self.hi, 1.0))
    }

    /// With the least and the largest of values at corners.
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
        // no bound times nothing is nothing; infinity times nothing would be no number
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
        // pow(x, 0) = pow(1, y) = 1 even where the other is no number
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

    /// The part of it where a function is defined.
    fn within(self, from: f64, to: f64) -> Self {
        let outside = self.lo < from || self.hi > to;
        Self::doubts(&[self], outside).ends(self.lo.max(from), self.hi.min(to))
    }

    /// A function of spans, at least one.
    #[must_use]
    pub fn of(function: Function, arguments: &[Self]) -> Self {
        let (a, b) = (arguments[0], arguments[arguments.len() - 1]);
        // what these give for no number is left open
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
