//! Response spectrum of a force: largest response of an oscillator to it, over the oscillator's frequency.
//!
//! ```text
//! u'' + 2 z w u' + w^2 u = w^2 F(t),   u(0) = F(0), u'(0) = 0,   S(w) = max |u|        z: damping ratio                         (1)
//! u = u_h + F0 + b t - 2 z b/w                                                        F = F0 + b t between two records          (2)
//! ```
//! u is the static force that would bend the oscillator as far. (2) is exact for straight lines between the records; u_h is the free motion.
//! Source: Nigam, Jennings, Bull. Seism. Soc. Am. 59 (1969), 909-922. Limits: the largest value is that of the records, so a period needs twenty of them.
//! Verified by `a_resonant_sine_is_magnified_by_the_damping`, `a_step_doubles_the_response`.

use super::panels::{Line, Panel, panels};
use super::style::Scale;
use super::{Figure, FigureError, plain_name};
use crate::history::{History, Series};
use std::f64::consts::TAU;

/// Frequencies of a spectrum.
const FREQUENCIES: usize = 240;
/// Records of a period of the highest frequency.
const RECORDS: f64 = 20.0;
/// Records at least.
const LEAST: usize = 64;

/// Largest response (1) of an oscillator of frequency `w` \[rad/s\] to a force in records of `interval` \[s\].
fn largest_response(force: &[f64], interval: f64, w: f64, damping: f64) -> f64 {
    let turning = w * (1.0 - damping * damping).sqrt();
    let decay = (-damping * w * interval).exp();
    let (sin, cos) = (turning * interval).sin_cos();
    let (mut u, mut v) = (force.first().copied().unwrap_or(0.0), 0.0);
    let mut largest = u.abs();
    for pair in force.windows(2) {
        let slope = (pair[1] - pair[0]) / interval;
        let lag = 2.0 * damping * slope / w;
        let (a, b) = (u - pair[0] + lag, v - slope);
        u = decay * (a * cos + (b + damping * w * a) / turning * sin) + pair[1] - lag;
        v = decay * (b * cos - (damping * w * b + w * w * a) / turning * sin) + slope;
        largest = largest.max(u.abs());
    }
    largest
}

/// Response spectra of channels of one history, up to `top` \[Hz\] (by default a twentieth of the record rate), for oscillators of one damping ratio below 1.
///
/// # Errors
/// Too few records.
pub fn response_spectrum(
    history: &History,
    name: &str,
    channels: &[&Series],
    damping: f64,
    top: Option<f64>,
) -> Result<Figure, FigureError> {
    let (records, interval) = super::spectrum::even_records(history, channels, LEAST)?;
    let resolved = 1.0 / (RECORDS * interval);
    let top = top.map_or(resolved, |top| top.min(resolved));
    let spectrum = |channel: &Series| -> Vec<(f64, f64)> {
        let at = |k: usize| {
            let frequency = top * k as f64 / FREQUENCIES as f64;
            (frequency, largest_response(&channel.values[..records], interval, TAU * frequency, damping))
        };
        (1..=FREQUENCIES).map(at).collect()
    };
    let mut units: Vec<&str> = channels.iter().map(|channel| channel.unit.as_str()).collect();
    units.sort_unstable();
    units.dedup();
    let of_unit = |unit: &str| {
        let of = channels.iter().filter(|channel| channel.unit == unit);
        let of: Vec<_> = of.map(|channel| (plain_name(&channel.name, unit), spectrum(channel))).collect();
        panel(unit, of)
    };
    let of_units: Vec<Panel> = units.into_iter().map(of_unit).collect();
    let title = format!("{name}: response spectrum, damping ratio {damping}");
    Ok(panels(&title, "frequency of the oscillator [Hz]", &of_units))
}

/// Panel with the spectra of all channels of one unit.
fn panel(unit: &str, spectra: Vec<(String, Vec<(f64, f64)>)>) -> Panel {
    let largest = spectra.iter().flat_map(|(_, points)| points).map(|point| point.1).fold(0.0, f64::max);
    let scale = Scale::of(unit, largest);
    let lines = spectra.into_iter().map(|(name, points)| {
        let points = points.into_iter().map(|(frequency, value)| (frequency, value * scale.factor)).collect();
        Line::new(&name, points)
    });
    let y_range = Some((0.0, if largest > 0.0 { 1.05 * largest * scale.factor } else { 1.0 }));
    let quantity = if unit == "N" { "equivalent static force" } else { "equivalent static value" };
    Panel { y_label: scale.label(quantity), lines: lines.collect(), y_range, ..Panel::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resonant_sine_is_magnified_by_the_damping() {
        // 40 periods at resonance: 1/(2 z)
        let (w, interval) = (TAU * 25.0, 1e-4);
        let force: Vec<f64> = (0..16_000).map(|k| (w * interval * f64::from(k)).sin()).collect();
        let found = largest_response(&force, interval, w, 0.05);
        assert!((found / 10.0 - 1.0).abs() < 2e-3, "{found}");
        // far above the force it is static
        let stiff = largest_response(&force, interval, 40.0 * w, 0.05);
        assert!((stiff - 1.0).abs() < 2e-2, "{stiff}");
    }

    #[test]
    fn a_step_doubles_the_response() {
        // from 0 to 1 within one record: 1 + e^(-pi z/sqrt(1 - z^2))
        let force: Vec<f64> = std::iter::once(0.0).chain(std::iter::repeat_n(1.0, 4000)).collect();
        let (damping, w) = (0.05_f64, TAU * 10.0);
        let wanted = 1.0 + (-std::f64::consts::PI * damping / (1.0 - damping * damping).sqrt()).exp();
        let found = largest_response(&force, 1e-5 * 10.0, w, damping);
        assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
        // a constant force moves nothing
        assert!((largest_response(&[3.0; 100], 1e-3, w, damping) - 3.0).abs() < 1e-12);
    }
}
