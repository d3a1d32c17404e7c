//! A condition that is certain within bounds is true for every value of its variables.

use bladeoff_answers::estimate::span::Span;
use bladeoff_answers::estimate::truth::{Truth, span, truth, truth_of_known};
use bladeoff_text::formula::{Kind, Program, parse};

struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.0 >> 33
    }
    fn below(&mut self, count: u64) -> u64 {
        self.next() % count
    }
    fn unit(&mut self) -> f64 {
        self.next() as f64 / (1u64 << 31) as f64
    }
    fn number(&mut self) -> f64 {
        match self.below(6) {
            0 => self.below(5) as f64 - 2.0,
            1 => 1e3 * (self.unit() - 0.5),
            2 => 1e-3 * (self.unit() - 0.5),
            _ => 4.0 * (self.unit() - 0.5),
        }
    }
    fn numeric(&mut self, depth: u32) -> String {
        if depth == 0 {
            return match self.below(5) {
                0 => format!("({})", self.number()),
                1 => "2".into(),
                _ => ["a", "b", "c"][self.below(3) as usize].into(),
            };
        }
        let (x, y) = (self.numeric(depth - 1), self.numeric(depth - 1));
        match self.below(20) {
            0..=2 => format!("({x} + {y})"),
            3..=4 => format!("({x} - {y})"),
            5..=7 => format!("({x} * {y})"),
            8..=9 => format!("({x} / {y})"),
            10 => format!("({x} ^ {y})"),
            11 => format!("({x} ^ 2)"),
            12 => format!("({x} ^ 3)"),
            13 => format!("(-{x})"),
            14 => format!("min({x}, {y})"),
            15 => format!("max({x}, {y}, 1)"),
            16 => format!("hypot({x}, {y})"),
            17 => format!("atan2({x}, {y})"),
            _ => {
                let all = ["abs", "sqrt", "exp", "ln", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "floor"];
                format!("{}({x})", all[self.below(all.len() as u64) as usize])
            }
        }
    }
    fn condition(&mut self, depth: u32) -> String {
        if depth == 0 || self.below(3) == 0 {
            let sign = ["<", "<=", ">", ">=", "==", "!="][self.below(6) as usize];
            let (depth, other) = (self.below(4) as u32, self.below(2) as u32);
            return format!("{} {sign} {}", self.numeric(depth), self.numeric(other));
        }
        let (x, y) = (self.condition(depth - 1), self.condition(depth - 1));
        match self.below(3) {
            0 => format!("(({x}) and ({y}))"),
            1 => format!("(({x}) or ({y}))"),
            _ => format!("(not ({x}))"),
        }
    }
    fn span(&mut self) -> Span {
        let lo = self.number();
        match self.below(6) {
            0 => Span::point(lo),
            1 => Span::from(lo),
            2 => Span::WHOLE,
            3 => Span { lo, hi: lo + self.unit(), empty: true, lost: false },
            4 => Span::NONE,
            _ => Span { lo, hi: lo + 3.0 * self.unit(), empty: false, lost: false },
        }
    }
    fn inside(&mut self, span: Span) -> f64 {
        if span.lo > span.hi || (span.empty && self.below(4) == 0) {
            return f64::NAN;
        }
        let (lo, hi) = (span.lo.max(-1e4), span.hi.min(1e4));
        match self.below(5) {
            0 => lo,
            1 => hi,
            2 if span.hi == f64::INFINITY => 1e300,
            3 if span.lo < 0.0 && span.hi > 0.0 => 0.0,
            _ => lo + self.unit() * (hi - lo),
        }
    }
}

fn program(text: &str, kind: Kind) -> Program {
    let known = |name: &str| ["a", "b", "c"].iter().position(|known| *known == name);
    parse(text, kind, &known, &|_| None).unwrap_or_else(|error| panic!("{text}: {error:?}"))
}

#[test]
fn what_is_certain_holds_for_every_value_inside() {
    let mut draw = Draw(7);
    let (mut values, mut spans, mut known) = (Vec::new(), Vec::new(), Vec::new());
    let mut certain = [0u32; 3];
    for _ in 0..60_000 {
        let text = draw.condition(2);
        let program = program(&text, Kind::Truth);
        let of = [draw.span(), draw.span(), draw.span()];
        let found = truth(&program, |number| of[number], &mut spans);
        certain[found as usize] += 1;
        for _ in 0..12 {
            let x = [draw.inside(of[0]), draw.inside(of[1]), draw.inside(of[2])];
            let holds = program.value(|number| x[number], &mut values) == 1.0;
            let fits = match found {
                Truth::Yes => holds,
                Truth::No => !holds,
                Truth::Open => true,
            };
            assert!(fits, "{text} of {of:?} is {found:?}, but not at {x:?}");
            // as for an ok run: a formula without a value leaves the condition open
            let judged = truth_of_known(&program, |number| x[number], &mut known);
            assert!(found == Truth::Open || found == judged, "{text} of {of:?} is {found:?}, but {judged:?} at {x:?}");
        }
    }
    println!("no, open, yes: {certain:?}");
    assert!(certain.iter().all(|count| *count > 5000), "{certain:?}");
}

#[test]
fn values_stay_inside_their_span() {
    let mut draw = Draw(11);
    let (mut values, mut spans) = (Vec::new(), Vec::new());
    let mut bounded = 0u32;
    for _ in 0..60_000 {
        let depth = 1 + draw.below(3) as u32;
        let text = draw.numeric(depth);
        let program = program(&text, Kind::Number);
        let of = [draw.span(), draw.span(), draw.span()];
        let found = span(&program, |number| of[number], &mut spans);
        bounded += u32::from(found.lo.is_finite() && found.hi.is_finite() && found.lo < found.hi);
        for _ in 0..12 {
            let x = [draw.inside(of[0]), draw.inside(of[1]), draw.inside(of[2])];
            let value = program.value(|number| x[number], &mut values);
            let fits = if value.is_nan() { found.empty } else { found.lo <= value && value <= found.hi };
            assert!(fits, "{text} of {of:?} is {found:?}, but {value} at {x:?}");
        }
    }
    assert!(bounded > 5000, "{bounded}");
}

#[test]
fn what_was_reached_decides_what_it_can() {
    let of = |text: &str, load: Span| truth(&program(text, Kind::Truth), |_| load, &mut Vec::new());
    let reached = Span::from(5.0);
    assert_eq!(of("a > 3", reached), Truth::Yes);
    assert_eq!(of("a < 3", reached), Truth::No);
    assert_eq!(of("a > 8", reached), Truth::Open);
    assert_eq!(of("not a > 3", reached), Truth::No);
    assert_eq!(of("a > 3 and a > 8", reached), Truth::Open);
    assert_eq!(of("a > 3 or a > 8", reached), Truth::Yes);
    assert_eq!(of("2 * a ^ 2 - 1 > 48", reached), Truth::Yes);
    let upto = Span { lo: 3.0, hi: 5.0, empty: false, lost: false };
    assert_eq!((of("a > 5", upto), of("a >= 5", upto), of("a < 3", upto)), (Truth::No, Truth::Open, Truth::No));
    assert_eq!((of("a <= 5", upto), of("a >= 3", upto), of("a == 6", upto)), (Truth::Yes, Truth::Yes, Truth::No));
    // no comparison holds for a missing number
    assert_eq!(of("a > 3", Span::NONE), Truth::No);
    assert_eq!(of("a != 3", Span::NONE), Truth::Yes);
    assert_eq!(of("a*0 == 0", Span::WHOLE), Truth::Open);
    // a formula that has, or may have, no value leaves the condition open, unless other terms determine it
    let minus = Span::point(-1.0);
    for text in ["ln(a) > 0", "not ln(a) > 0", "ln(a) != 0", "a > 0 or sqrt(a) > 1", "min(ln(a), 0) > 1"] {
        assert_eq!(of(text, minus), Truth::Open, "{text}");
    }
    assert_eq!((of("a < 0 or ln(a) > 1", minus), of("a > 0 and ln(a) > 1", minus)), (Truth::Yes, Truth::No));
    let around = Span { lo: -1.0, ..upto };
    assert_eq!((of("sqrt(a) >= 0", around), of("sqrt(a) < 0", around)), (Truth::Open, Truth::Open));
    assert_eq!((of("a != 3", Span::LOST), of("a != 3 or 1 > 0", Span::LOST)), (Truth::Open, Truth::Yes));
}
