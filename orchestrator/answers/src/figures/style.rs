//! Colours, numbers on axes, and the unit a reader wants to see.

pub use crate::estimate::input::plain_name;
use plotters::style::RGBColor;

/// Okabe-Ito, without its yellow, which is too light for lines.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];
/// Grid and quiet lines.
pub const GREY: RGBColor = RGBColor(150, 150, 150);
/// Bold grid lines.
pub(super) const GRID: RGBColor = RGBColor(222, 222, 222);

/// Units of the drawing per SVG pixel: the library rounds places to whole units, and whole pixels make curves jagged.
pub(super) const FINE: u32 = 4;
/// Text sizes.
pub(super) const TITLE: (&str, u32) = ("sans-serif", 17 * FINE);
pub(super) const TEXT: (&str, u32) = ("sans-serif", 13 * FINE);
pub(super) const SMALL: (&str, u32) = ("sans-serif", 12 * FINE);

/// Half the extents of both axes on one scale: those asked for, one of them widened to the plotting area's shape.
///
/// The area is the one of the chart itself (`ChartContext::plotting_area`), without margins, labels and caption: reckoned from what
/// surrounds it, circles were up to 4 % off round. Verified by `what_is_drawn_to_scale_is_round`.
pub(super) fn to_scale((width, height): (u32, u32), (half_x, half_y): (f64, f64)) -> (f64, f64) {
    let (width, height) = (f64::from(width.max(1)), f64::from(height.max(1)));
    let pixels = (width / half_x).min(height / half_y);
    (width / pixels, height / pixels)
}

/// Factor and name that turn SI values into readable ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Multiplies the SI value.
    pub factor: f64,
    /// The unit shown.
    pub unit: String,
}

impl Scale {
    /// For values of an SI unit whose largest size is `largest`.
    #[must_use]
    pub fn of(unit: &str, largest: f64) -> Self {
        let shown = match unit {
            "rad/s" => return Self { factor: 30.0 / std::f64::consts::PI, unit: "rpm".to_owned() },
            "rad" => return Self { factor: 180.0 / std::f64::consts::PI, unit: "°".to_owned() },
            "N m" => "N·m",
            "m" | "N" | "Pa" | "J" | "s" | "Hz" => unit,
            _ => return Self { factor: 1.0, unit: unit.to_owned() },
        };
        let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
        // lengths and times have no kilo and mega on a drawing
        let at_most = if matches!(unit, "m" | "s") { 1.0 } else { 1e9 };
        let (size, prefix) = prefixes
            .into_iter()
            .find(|(size, _)| *size <= at_most && largest.abs() >= *size)
            .unwrap_or(if largest == 0.0 { (1.0, "") } else { (1e-9, "n") });
        Self { factor: 1.0 / size, unit: format!("{prefix}{shown}") }
    }

    /// "gap \[mm\]".
    #[must_use]
    pub fn label(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name} [{}]", self.unit) }
    }
}

/// A number in a picture: four significant digits at most, no trailing zeros.
pub(super) fn tick(value: f64) -> String {
    with_digits(value, 4, 2)
}

/// A number on an axis from `low` to `high`: as [`tick`], with more digits where numbers of a short range differ in those.
pub(super) fn tick_within(value: f64, (low, high): (f64, f64)) -> String {
    let step = (high - low).abs() / MOST_TICKS;
    if value.abs() < 1e-6 * step {
        return "0".to_owned();
    }
    let digits = digits_of(low.abs().max(high.abs()), step);
    with_digits(value, digits.max(4), digits.max(2))
}

/// Numbers on an axis at most.
const MOST_TICKS: f64 = 20.0;

/// Significant digits in which numbers of this size differ that are a step apart.
pub(crate) fn digits_of(size: f64, step: f64) -> usize {
    let digits = libm::ceil(libm::log10(size / step) - 1e-9) + 1.0;
    if digits.is_finite() { digits.clamp(1.0, 15.0) as usize } else { 1 }
}

/// A number with so many significant digits at most, and with so many where it has a power of ten.
fn with_digits(value: f64, digits: usize, of_powers: usize) -> String {
    if value.abs() < 1e-12 {
        return "0".to_owned();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.*e}", of_powers - 1);
        let (number, power) = text.split_once('e').unwrap_or((&text, "0"));
        let number = if number.len() > number.find('.').map_or(0, |dot| dot + 2) {
            let short = number.trim_end_matches('0');
            if short.ends_with('.') { format!("{short}0") } else { short.to_owned() }
        } else {
            number.to_owned()
        };
        return format!("{number}e{power}").replace('-', "−");
    }
    let decimals = (digits as i32 - 1 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.*}", decimals.min(digits + 2));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}

/// A number with so many decimals, and a minus of a number's width; no negative zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.parse() == Ok(0.0) { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// A range with some room around the values; never empty.
pub(super) fn roomy(values: impl Iterator<Item = f64>, room: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|value| value.is_finite()) {
        low = low.min(value);
        high = high.max(value);
    }
    if low > high {
        return (0.0, 1.0);
    }
    let width = high - low;
    let pad = if width > 1e-9 * high.abs().max(low.abs()) { room * width } else { 0.5 * high.abs().max(1e-9) };
    (low - pad, high + pad)
}

/// Viridis at 0..=1.
#[must_use]
pub fn viridis(share: f64) -> RGBColor {
    const STOPS: [(f64, f64, f64); 9] = [
        (68.0, 1.0, 84.0),
        (71.0, 44.0, 122.0),
        (59.0, 81.0, 139.0),
        (44.0, 113.0, 142.0),
        (33.0, 144.0, 141.0),
        (39.0, 173.0, 129.0),
        (92.0, 200.0, 99.0),
        (170.0, 220.0, 50.0),
        (253.0, 231.0, 37.0),
    ];
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let from = (place as usize).min(STOPS.len() - 2);
    let t = place - from as f64;
    let mix = |a: f64, b: f64| (a + t * (b - a)).round() as u8;
    let (a, b) = (STOPS[from], STOPS[from + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_on_axes_are_short() {
        for (value, text) in [
            (0.30000000000000004, "0.3"),
            (1500.0, "1500"),
            (-0.25, "−0.25"),
            (0.0, "0"),
            (2.5e-7, "2.5e−7"),
            (12.0, "12"),
        ] {
            assert_eq!(tick(value), text);
        }
    }

    #[test]
    fn numbers_of_a_short_range_differ() {
        for (from, step) in [(3.0012, 1e-4), (1.2e6, 2.5e4), (-1e6, 1e2), (7.2e-9, 1e-11), (0.0, 0.1), (-0.5, 0.1)] {
            let range = (from, from + 10.0 * step);
            let texts: Vec<String> = (0..=10).map(|k| tick_within(from + f64::from(k) * step, range)).collect();
            let number = |text: &String| text.replace('−', "-").parse::<f64>().expect("a number");
            assert!(texts.windows(2).all(|pair| pair[0] != pair[1]), "{texts:?}");
            for (k, text) in (0..).zip(&texts) {
                let value = from + f64::from(k) * step;
                assert!((number(text) - value).abs() < 0.01 * step, "{text} is not {value}");
            }
        }
        assert_eq!([0.3, 1500.0].map(|value| tick_within(value, (0.0, 2000.0))), ["0.3", "1500"]);
        assert_eq!(tick_within(2e6, (0.0, 4e6)), "2.0e6");
    }

    #[test]
    fn fixed_decimals_have_no_negative_zero() {
        assert_eq!([fixed(-1.3e-5, 3), fixed(-0.25, 2), fixed(1.0, 0)], ["0.000", "\u{2212}0.25", "1"]);
    }

    #[test]
    fn units_are_those_a_reader_wants() {
        assert_eq!(Scale::of("N", 1.3e6).label("bearing load"), "bearing load [MN]");
        assert_eq!(Scale::of("m", 8e-3).label("gap"), "gap [mm]");
        assert_eq!(Scale::of("rad/s", 157.0).unit, "rpm");
        assert_eq!(Scale::of("m", 5.0).unit, "m");
        assert_eq!(plain_name("bearing.front.load_N", "N"), "bearing front load");
    }
}
