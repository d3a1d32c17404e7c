//! Waterfall: spectra of a channel at evenly spaced speeds, one behind the other.
//!
//! ```text
//! speed(t) -> speeds, evenly spaced between the largest and the smallest -> the window around the first instant with this speed -> |X(f)|
//! ```
//! Lines through the origin are orders of the spin. The amplitude is that of [`super::spectrum`].
//! Verified by `spectra_are_those_of_their_speeds`.

use super::contacts::critical_passages;
use super::spectrum::{Content, Stft, content, even_records, stft, window_of};
use super::style::{GREY, Scale, rimmed};
use super::{COLOURS, Figure, FigureError, HEAD, SpectrumError, plain_name};
use crate::drawing::{Anchor, Axis, BLACK, Frame, Ruling, TEXT, WHITE, shown};
use crate::history::{History, Series};
use std::f64::consts::PI;

/// Spectra at most.
const SPECTRA: usize = 40;
/// The largest amplitude is as high as so many distances of two spectra.
const HEIGHT: f64 = 5.0;
/// Width of the name of an order \[px\].
const ORDER_WIDTH: f64 = 24.0;
/// Share of the largest speed by which the speed has to change.
const CHANGE: f64 = 0.05;

/// A spectrum: its speed \[rad/s\] and the amplitudes.
type Spectrum = (f64, Vec<f64>);

/// Spectra from the highest speed to the lowest.
fn spectra(stft: &Stft, speed: &[f64]) -> Result<Vec<Spectrum>, SpectrumError> {
    let of = |middle: &f64| speed[(*middle as usize).min(speed.len() - 1)];
    let speeds: Vec<f64> = stft.middles.iter().map(of).collect();
    let (low, high) = speeds.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), w| (low.min(*w), high.max(*w)));
    if speeds.len() < 2 || high - low < CHANGE * high || high <= 0.0 {
        return Err(SpectrumError::SteadySpeed { from: low, to: high });
    }
    let count = SPECTRA.min(speeds.len());
    let mut chosen: Vec<usize> = (0..count)
        .filter_map(|k| {
            let wanted = high + (low - high) * k as f64 / (count - 1) as f64;
            (0..speeds.len()).min_by(|a, b| (speeds[*a] - wanted).abs().total_cmp(&(speeds[*b] - wanted).abs()))
        })
        .collect();
    chosen.dedup();
    Ok(chosen.into_iter().map(|at| (speeds[at], stft.columns[at].clone())).collect())
}

/// Draws the waterfall of a channel up to `top` \[Hz\] (by default what the signal contains), with the critical speeds that are marked in the file.
///
/// # Errors
/// No speed, a steady speed, too few records or a constant signal.
pub fn waterfall(history: &History, name: &str, channel: &Series, top: Option<f64>) -> Result<Figure, FigureError> {
    let speed = history.channel("rotor.speed_rad_s").ok_or(SpectrumError::NoSpeed)?;
    let (records, interval) = even_records(history, &[channel, speed], 256)?;
    let spin = speed.values.iter().fold(0.0_f64, |most, w| most.max(w.abs())) / (2.0 * PI);
    let window = window_of(records, interval, spin);
    let stft = stft(&channel.values[..records], window);
    let Content { resolution, bins, largest } = content(&stft, channel, window, interval, top, 1.2 * spin)?;
    let spectra = spectra(&stft, &speed.values[..records])?;
    let rpm = |speed: f64| speed * 30.0 / PI;
    let (first, last) = (rpm(spectra[0].0), rpm(spectra[spectra.len() - 1].0));
    let height = HEIGHT * (first - last) / spectra.len() as f64;
    let top = (bins - 1) as f64 * resolution;
    let scale = Scale::of(&channel.unit, largest);
    let title = format!("{name}: waterfall of {}", plain_name(&channel.name, &channel.unit));
    let range = (last - 0.06 * (first - last), first + 1.05 * height);
    let x = Axis::between("frequency [Hz]", (0.0, top)).most(10);
    let y = Axis::between("spin speed [rpm]", range).most(10);
    let frame = Frame::new(&x, &y, [74.0, HEAD + 8.0, 792.0, 508.0]);
    let figure = Figure::draw((900, 560), &title, |svg| {
        frame.axes(svg, Ruling::Grid, 58.0);
        // the slowest in front
        for (speed, amplitudes) in &spectra {
            let base = rpm(*speed);
            let line: Vec<(f64, f64)> = amplitudes[..bins]
                .iter()
                .enumerate()
                .map(|(bin, amplitude)| (bin as f64 * resolution, base + height * (amplitude / largest).min(1.0)))
                .collect();
            let ends = [(top, range.0.max(base)), (0.0, range.0.max(base))];
            frame.area(svg, WHITE.fill(), line.iter().copied().chain(ends));
            frame.line(svg, COLOURS[0].stroke(1.0), line);
        }
        let mut free = f64::NEG_INFINITY;
        for order in [1.0, 2.0, 3.0] {
            let end = first.min(60.0 * top / order);
            if end > last {
                let line = [(last * order / 60.0, last), (end * order / 60.0, end)];
                frame.line(svg, BLACK.dashed(1.0, [6, 4]), line);
                if let Some((x, y)) = frame.place(line[0]) {
                    let x = x.max(free);
                    free = x + ORDER_WIDTH;
                    rimmed(svg, (x, y + 16.0), Anchor::Middle, [WHITE, BLACK], &format!("{order}×"));
                }
            }
        }
        let criticals = critical_passages(history).into_iter().map(|(_, w)| rpm(w));
        let mut shown_at: Vec<f64> = criticals.filter(|critical| (last..=first).contains(critical)).collect();
        shown_at.sort_by(|a, b| b.total_cmp(a));
        // what the height of a line means
        let right = 800.0;
        let bar = frame.height * height / (range.1 - range.0);
        let (x, y) = (right + 10.0, HEAD + 30.0);
        svg.path(BLACK.stroke(1.0), format_args!("M{x},{y}v{bar:.1}m-4,0h8M{},{y}h8", x - 4.0));
        let amplitude = format!("{} {}", shown(largest * scale.factor), scale.unit);
        for (text, off) in [("amplitude", -8.0), (&amplitude, 8.0)] {
            svg.text("", (x + 8.0, y + bar / 2.0 + off + TEXT), Anchor::Start, text);
        }
        // beside the line, and below what is there already
        let mut free = y + bar + 24.0;
        for critical in shown_at {
            frame.line(svg, GREY.dashed(1.0, [3, 3]), [(0.0, critical), (top, critical)]);
            let at = frame.up(critical).unwrap_or(free).max(free);
            for (text, off) in [("critical speed", -7.0), (&*format!("{} rpm", critical.round()), 8.0)] {
                svg.text("", (right, at + off + TEXT), Anchor::Start, text);
            }
            free = at + 34.0;
        }
    });
    Ok(figure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_are_those_of_their_speeds() {
        // 1x and a steady 80 Hz while the spin falls from 50 to 25 turns a second in 4 s
        let time: Vec<f64> = (0..8_000).map(|k| f64::from(k) * 5e-4).collect();
        let speed: Vec<f64> = time.iter().map(|t| 2.0 * PI * (50.0 - 6.25 * t)).collect();
        let angle = time.iter().map(|t| 2.0 * PI * (50.0 * t - 3.125 * t * t));
        let x: Vec<f64> = angle.zip(&time).map(|(a, t)| 3e-4 * a.cos() + 1e-4 * (2.0 * PI * 80.0 * t).cos()).collect();
        let window = 512;
        let found = spectra(&stft(&x, window), &speed).expect("a falling speed");
        assert!(found.len() > 30, "{}", found.len());
        assert!(found.windows(2).all(|pair| pair[0].0 > pair[1].0), "from the fastest");
        let resolution = 1.0 / (2.0 * window as f64 * 5e-4);
        for (speed, amplitudes) in &found {
            let peak = (0..amplitudes.len()).max_by(|a, b| amplitudes[*a].total_cmp(&amplitudes[*b])).expect("bins");
            let frequency = peak as f64 * resolution;
            assert!((frequency - speed / (2.0 * PI)).abs() < 2.0, "{frequency} at {}", speed / (2.0 * PI));
            let steady = amplitudes[(80.0 / resolution).round() as usize];
            assert!((steady / 1e-4 - 1.0).abs() < 0.05, "{steady}");
        }
        let series = |name: &str, values: Vec<f64>| Series { name: name.into(), unit: "m".into(), values };
        let channel = series("bearing.a.y_m", x);
        let history = |speed: Vec<f64>| History {
            time: time.clone(),
            channels: vec![series("rotor.speed_rad_s", speed), channel.clone()],
            ..History::default()
        };
        let drawn = waterfall(&history(speed), "run", &channel, None).expect("drawn");
        for part in ["spin speed [rpm]", "frequency [Hz]", "1×", "amplitude"] {
            assert!(drawn.svg().contains(part), "{part}");
        }
        let steady = waterfall(&history(vec![300.0; 8000]), "run", &channel, None);
        assert!(matches!(steady, Err(FigureError::Spectrum(SpectrumError::SteadySpeed { .. }))));
    }
}
