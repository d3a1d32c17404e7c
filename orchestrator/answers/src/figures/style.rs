//! Colours, numbers on axes, and the unit a reader wants to see.

use crate::drawing::{Anchor, Rgb, Svg};
pub use crate::estimate::input::plain_name;

/// Okabe-Ito, without its yellow, which is too light for lines.
pub const COLOURS: [Rgb; 7] = [
    Rgb(0, 114, 178),
    Rgb(213, 94, 0),
    Rgb(0, 158, 115),
    Rgb(204, 121, 167),
    Rgb(86, 180, 233),
    Rgb(230, 159, 0),
    Rgb(0, 0, 0),
];
/// Grid and quiet lines.
pub const GREY: Rgb = Rgb(150, 150, 150);

/// Draws small text with a rim, so that it is read on any ground.
pub(super) fn rimmed(svg: &mut Svg, place: (f64, f64), anchor: Anchor, [rim, ink]: [Rgb; 2], text: &str) {
    let rim = format!("{} stroke=\"{rim}\" stroke-width=\"3\" paint-order=\"stroke\"", ink.fill());
    svg.text(rim, place, anchor, text);
}

/// Half the extents of both axes on one scale: those asked for, one of them widened to the shape of the frame.
///
/// Verified by `what_is_drawn_to_scale_is_round`.
pub(super) fn to_scale((width, height): (f64, f64), (half_x, half_y): (f64, f64)) -> (f64, f64) {
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

/// A number with so many decimals, and a minus of a number's width; no negative zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.parse() == Ok(0.0) { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// Viridis at 0..=1.
#[must_use]
pub fn viridis(share: f64) -> Rgb {
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
    Rgb(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

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
