//! The scale of colour of a kind of pictures, and the levels that are marked on it.

use super::super::style::{Scale, viridis};
use crate::drawing::{Rgb, number, number_within};

/// What pictures share a scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Value,
    Difference,
    Width,
}

/// From values to colours.
#[derive(Debug, Clone)]
pub struct Colours {
    kind: Kind,
    low: f64,
    high: f64,
    is_logarithmic: bool,
    scale: Scale,
    /// Ascending, in SI.
    pub levels: Vec<f64>,
}

/// Steps of colour, so that neighbours of one step look alike.
pub const STEPS: usize = 64;
/// Values that differ by more than this factor have a logarithmic scale.
const DECADES: f64 = 30.0;
/// Below and above the middle of differences: Okabe-Ito's blue and vermillion.
const BELOW: [f64; 3] = [0.0, 114.0, 178.0];
const MIDDLE: [f64; 3] = [247.0, 247.0, 247.0];
const ABOVE: [f64; 3] = [213.0, 94.0, 0.0];

impl Colours {
    /// For these values of a unit; `None`: shares, in per cent.
    pub fn new(kind: Kind, values: impl Iterator<Item = f64>, unit: Option<&str>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        values.filter(|value| value.is_finite()).for_each(|value| (low, high) = (low.min(value), high.max(value)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        match kind {
            Kind::Difference => {
                high = high.abs().max(low.abs());
                low = -high;
            }
            Kind::Width => low = 0.0,
            Kind::Value if unit.is_none() => low = 0.0,
            Kind::Value => {}
        }
        let is_logarithmic = kind == Kind::Value && unit.is_some() && low > 0.0 && high / low > DECADES;
        let is_nothing = kind == Kind::Width && high == 0.0;
        let levels = if is_nothing {
            vec![0.0]
        } else if is_logarithmic {
            decades(low, high)
        } else {
            even(low, high)
        };
        if kind == Kind::Width && high == 0.0 {
            // nothing is uncertain: one colour, and a scale that says so
            high = if unit.is_none() { 0.01 } else { 1.0 };
        } else if high - low <= 1e-12 * high.abs() {
            let room = 0.05 * high.abs().max(1e-9);
            (low, high) = (low - room, high + room);
        }
        let scale = match unit {
            None => Scale { factor: 100.0, unit: "%".to_owned() },
            Some(unit) => Scale::of(unit, high.abs().max(low.abs())),
        };
        Self { kind, low, high, is_logarithmic, scale, levels }
    }

    /// "max bearing load [MN]".
    pub fn label(&self, name: &str) -> String {
        let logarithmic = if self.is_logarithmic { ", logarithmic" } else { "" };
        self.scale.label(&format!("{name}{logarithmic}"))
    }

    /// The unit of the values.
    pub fn scale(&self) -> &Scale {
        &self.scale
    }

    /// A level as it is marked.
    pub fn mark(&self, level: f64) -> String {
        let of = |value: f64| value * self.scale.factor;
        if self.is_logarithmic { number(of(level), 4) } else { number_within(of(level), (of(self.low), of(self.high))) }
    }

    /// The place of a value on the scale, 0 to 1.
    pub fn share(&self, value: f64) -> f64 {
        let share = if self.is_logarithmic {
            libm::log(value / self.low) / libm::log(self.high / self.low)
        } else {
            (value - self.low) / (self.high - self.low)
        };
        share.clamp(0.0, 1.0)
    }

    /// The colour at a place on the scale.
    pub fn at(&self, share: f64) -> Rgb {
        let share = stepped(share);
        if self.kind != Kind::Difference {
            return viridis(share);
        }
        let (end, part) = if share < 0.5 { (BELOW, 1.0 - 2.0 * share) } else { (ABOVE, 2.0 * share - 1.0) };
        let mix = |at: usize| (MIDDLE[at] + part * (end[at] - MIDDLE[at])).round() as u8;
        Rgb(mix(0), mix(1), mix(2))
    }
}

/// The step of colour of a place on the scale.
pub fn stepped(share: f64) -> f64 {
    libm::rint(share * STEPS as f64) / STEPS as f64
}

/// Round numbers between these, five to nine of them.
fn even(low: f64, high: f64) -> Vec<f64> {
    let width = high - low;
    if width <= 1e-12 * high.abs().max(low.abs()) {
        return Vec::new();
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(width / 8.0)));
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let step = steps.into_iter().find(|step| width / step <= 9.0).unwrap_or(10.0 * power);
    let from = libm::ceil(low / step) as i64;
    let levels = (from..from + 12).map(|k| k as f64 * step);
    inside(levels, low, high)
}

/// Those that are not at an end, where rounding alone would draw a line.
fn inside(levels: impl Iterator<Item = f64>, low: f64, high: f64) -> Vec<f64> {
    let room = 1e-6 * (high - low);
    levels.filter(|level| *level > low + room && *level < high - room).collect()
}

/// 1, 2, 5 of each power of ten between these; of many powers the 1 alone.
fn decades(low: f64, high: f64) -> Vec<f64> {
    let (from, to) = (libm::floor(libm::log10(low)) as i32, libm::ceil(libm::log10(high)) as i32);
    let steps: &[f64] = if to - from > 4 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let levels = (from..=to).flat_map(|power| steps.iter().map(move |step| step * libm::pow(10.0, f64::from(power))));
    inside(levels, low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_round_and_inside() {
        assert_eq!(even(0.0, 1.0), [0.2, 0.4, 0.6000000000000001, 0.8]);
        assert_eq!(even(-30.0, 30.0), [-20.0, -10.0, 0.0, 10.0, 20.0]);
        assert_eq!(decades(3e5, 2e7), [5e5, 1e6, 2e6, 5e6, 1e7]);
        assert!(even(2.0, 2.0).is_empty());
    }

    #[test]
    fn a_difference_of_nothing_is_the_middle() {
        let colours = Colours::new(Kind::Difference, [-1.0, 3.0].into_iter(), Some("N"));
        assert_eq!((colours.share(0.0), colours.share(-3.0), colours.share(3.0)), (0.5, 0.0, 1.0));
        let wide = Colours::new(Kind::Value, [1e5, 1e7].into_iter(), Some("N"));
        assert!((wide.share(1e6) - 0.5).abs() < 1e-12 && wide.label("load") == "load, logarithmic [MN]");
    }
}
