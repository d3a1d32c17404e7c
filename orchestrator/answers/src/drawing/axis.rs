//! Axes of a chart: range, ticks and labels.

use bladeoff_text::document::units::format_digits;

/// Width of a letter of a label, as part of the width of a chart.
const LETTER: f64 = 0.0105;

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the quantity, with unit.
    pub label: String,
    /// Values at both ends; exponents of ten on a logarithmic axis.
    pub(crate) range: (f64, f64),
    /// Whether the axis is logarithmic.
    pub(crate) log: bool,
    /// Names at 0, 1, ... from the top; none: numbers.
    pub(crate) words: Vec<String>,
    /// Values with ticks; empty: round values.
    pub(crate) at: Vec<f64>,
    /// Approximate number of ticks at round values.
    pub(crate) most: u32,
    /// Whether the numbers and the label are drawn.
    pub(crate) has_numbers: bool,
}

impl Axis {
    fn new(label: String, range: (f64, f64)) -> Self {
        Self { label, range, log: false, words: Vec::new(), at: Vec::new(), most: 7, has_numbers: true }
    }

    /// Axis of numbers, from the smallest to the largest value.
    pub(crate) fn tight(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        Self::new(label.into(), roomy(values, 0.0))
    }

    /// Axis of numbers between two values.
    pub(crate) fn between(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self::new(label.into(), range)
    }

    /// This axis with about `most` ticks.
    pub(crate) fn most(self, most: u32) -> Self {
        Self { most, ..self }
    }

    /// Axis of numbers, with a margin around the values.
    #[must_use]
    pub fn numbers(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        Self::new(label.into(), roomy(values, 0.04))
    }

    /// Logarithmic axis of numbers above zero, with a margin around the values.
    #[must_use]
    pub fn log(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        let powers = values.filter(|value| *value > 0.0).map(libm::log10);
        Self { log: true, ..Self::new(label.into(), roomy(powers, 0.04)) }
    }

    /// Axis of names, the first at the top.
    #[must_use]
    pub fn words(words: Vec<String>) -> Self {
        let range = (words.len() as f64 - 0.4, -0.6);
        Self { words, ..Self::new(String::new(), range) }
    }

    /// This axis with exactly this range of values.
    #[must_use]
    pub fn from_to(mut self, low: f64, high: f64) -> Self {
        self.range = if self.log { (libm::log10(low), libm::log10(high)) } else { (low, high) };
        self
    }

    /// This axis with ticks at these values.
    #[must_use]
    pub fn at(mut self, values: Vec<f64>) -> Self {
        self.at = values;
        self
    }

    /// Place of a value along the axis, from 0 to 1 within the range; `None` for a value without a place.
    pub(crate) fn share(&self, value: f64) -> Option<f64> {
        let value = if self.log { libm::log10(value) } else { value };
        let share = share_of(value, self.range);
        // zero and below lie before the start of a logarithmic axis
        if self.log && value == f64::NEG_INFINITY { Some(-1.0) } else { Some(share).filter(|share| share.is_finite()) }
    }

    /// Ends of the range as values.
    pub(crate) fn ends(&self) -> (f64, f64) {
        if self.log { (libm::exp10(self.range.0), libm::exp10(self.range.1)) } else { self.range }
    }

    /// Ticks whose labels do not overlap along a horizontal axis; the last tick stays.
    fn apart(&self, ticks: Vec<(f64, String)>) -> Vec<(f64, String)> {
        let mut kept: Vec<(f64, String)> = Vec::new();
        for (value, label) in ticks.into_iter().rev() {
            let is_free = kept.last().is_none_or(|(next, beside)| {
                let room = LETTER * 0.5 * (label.len() + beside.len() + 3) as f64;
                self.share(*next).zip(self.share(value)).is_some_and(|(next, at)| (next - at).abs() >= room)
            });
            if is_free {
                kept.push((value, label));
            }
        }
        kept.reverse();
        kept
    }

    /// Values of the ticks, with their labels.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        if !self.words.is_empty() {
            return self.words.iter().enumerate().map(|(at, word)| (at as f64, word.clone())).collect();
        }
        if !self.at.is_empty() {
            return self.apart(self.at.iter().map(|value| (*value, exact(*value))).collect());
        }
        let (low, high) = (self.range.0.min(self.range.1), self.range.0.max(self.range.1));
        if self.log {
            let (first, last) = (libm::ceil(low) as i32, libm::floor(high) as i32);
            if last - first >= 2 {
                let every = 1 + (last - first) / 8;
                return (first..=last)
                    .step_by(every as usize)
                    .map(|power| (libm::exp10(f64::from(power)), power_of_ten(power)))
                    .collect();
            }
            let mantissas = |power| [1.0, 2.0, 5.0].map(|m: f64| m * libm::exp10(f64::from(power)));
            let all = (libm::floor(low) as i32..=last).flat_map(mantissas);
            return all
                .filter(|value| (low..=high).contains(&libm::log10(*value)))
                .map(|value| (value, number(value, 4)))
                .collect();
        }
        let most = f64::from(self.most);
        let rough = high / most - low / most;
        let size = libm::exp10(libm::floor(libm::log10(rough)));
        let step = size * [1.0, 2.0, 5.0, 10.0].into_iter().find(|step| step * size >= rough).unwrap_or(10.0);
        let first = libm::ceil(low / step - 1e-9);
        let count = libm::floor(high / step + 1e-9) - first;
        let digits = digits_of(low.abs().max(high.abs()), step).max(4);
        (0..=(count.clamp(-1.0, 20.0) as i64))
            .map(|at| (first + at as f64) * step)
            .map(|value| (value, number(value, digits)))
            .collect()
    }
}

/// Given values are shown as they are given: 16384 points are not 16380.
fn exact(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 { format!("{value}") } else { shown(value) }
}

fn power_of_ten(power: i32) -> String {
    match power {
        -3 => "0.001".to_owned(),
        -2 => "0.01".to_owned(),
        -1 => "0.1".to_owned(),
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        2 => "100".to_owned(),
        3 => "1000".to_owned(),
        _ => format!("1e{power}").replace('-', "\u{2212}"),
    }
}

/// A number of a chart in a text, four digits.
#[must_use]
pub fn shown(value: f64) -> String {
    if value.abs() < 1e-12 { "0".to_owned() } else { format_digits(value, "", 4) }
}

/// A number in a picture, with a minus of a number's width.
pub(crate) fn number(value: f64, digits: usize) -> String {
    if value.abs() < 1e-12 { "0".to_owned() } else { format_digits(value, "", digits).replace('-', "\u{2212}") }
}

/// A number of a range, with the digits in which a twentieth of the range shows.
pub(crate) fn number_within(value: f64, (low, high): (f64, f64)) -> String {
    number(value, digits_of(low.abs().max(high.abs()), (high - low).abs() / 20.0).max(4))
}

/// Significant digits in which numbers of this size differ that are a step apart.
fn digits_of(size: f64, step: f64) -> usize {
    let digits = libm::ceil(libm::log10(size / step) - 1e-9) + 1.0;
    if digits.is_finite() { digits.clamp(1.0, 15.0) as usize } else { 1 }
}

/// Share of the way from a low value to a high one, also where their distance is no number that a computer has.
pub(crate) fn share_of(value: f64, (low, high): (f64, f64)) -> f64 {
    (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low)
}

/// A range with some room around the values, as a share of it; never empty, and of finite numbers.
fn roomy(values: impl Iterator<Item = f64>, room: f64) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return (0.0, 1.0);
    }
    let half = 0.5 * high - 0.5 * low;
    let largest = high.abs().max(low.abs());
    let room = if half > 5e-10 * largest { 2.0 * room * half } else { 0.5 * largest.max(1e-9) };
    ((low - room).max(f64::MIN), (high + room).min(f64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let texts = |axis: &Axis| axis.ticks().into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts(&Axis::numbers("", [0.0, 10.0].into_iter())), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(texts(&Axis::log("", [1e-4, 1.0].into_iter())), ["1e−4", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(texts(&Axis::log("", [0.12, 0.7].into_iter())), ["0.2", "0.5"]);
        assert_eq!(texts(&Axis::words(vec!["a".into(), "b".into()])), ["a", "b"]);
        for axis in [
            Axis::numbers("", [3.0].into_iter()),
            Axis::numbers("", [-1e300, 1e300].into_iter()),
            Axis::numbers("", [f64::MIN, f64::MAX].into_iter()),
            Axis::numbers("", [5e-324, 0.0].into_iter()),
            Axis::log("", [5.0].into_iter()),
        ] {
            assert!((1..=21).contains(&axis.ticks().len()), "{:?}", axis.ticks());
        }
    }

    #[test]
    fn numbers_of_a_short_range_differ() {
        for (from, to) in [(3.2171, 3.2174), (-1000.002, -1000.001), (1.5e7, 1.50001e7), (0.0, 3.0)] {
            let texts: Vec<String> =
                Axis::numbers("", [from, to].into_iter()).ticks().into_iter().map(|(_, text)| text).collect();
            assert!(texts.len() > 3 && texts.windows(2).all(|pair| pair[0] != pair[1]), "{texts:?}");
        }
    }

    #[test]
    fn labels_of_given_ticks_do_not_run_together() {
        let looks: Vec<f64> = (8..20).map(|power| f64::from(1 << power)).chain([1e6]).collect();
        let axis = Axis::log("points", looks.iter().copied()).at(looks.clone());
        let found = axis.ticks();
        let of = |label: &str| found.iter().any(|(_, text)| text == label);
        assert!(of("1000000") && !of("524288") && found.len() > 5, "{found:?}");
        let few = Axis::log("points", [256.0, 512.0, 1024.0].into_iter()).at(vec![256.0, 512.0, 1024.0]);
        assert_eq!(few.ticks().len(), 3);
    }

    #[test]
    fn names_go_downwards_and_logarithms_have_no_zero() {
        let words = Axis::words(vec!["first".into(), "last".into()]);
        assert!(words.share(0.0) > words.share(1.0));
        let log = Axis::log("", [0.1, 10.0].into_iter());
        assert!((log.share(1.0).expect("on it") - 0.5).abs() < 1e-12);
        assert_eq!(log.share(0.0), Some(-1.0), "below the frame");
        assert_eq!(log.share(-1.0), None);
    }
}
