//! Spectrogram and order tracking of a channel.
//!
//! ```text
//! spectrogram   |X(t, f)|  windows of equal duration, Blackman-Harris, overlapping
//! orders        the channel resampled at equal steps of the spin angle; |X(t, k)|, k in events per turn
//! amplitude     2 |X| / sum(window): a sine of amplitude A shows as A
//! ```
//! Order tracking keeps what turns with the shaft at one order while the speed falls, which a spectrogram smears.
//! Verified by `a_sine_shows_with_its_frequency_and_amplitude`, `an_order_stays_while_the_speed_falls`.

use super::heat::{Map, map};
use super::style::Scale;
use super::{Figure, FigureError, SpectrumError, plain_name};
use crate::history::{History, Series};
use realfft::RealFftPlanner;
use std::f64::consts::PI;

/// Windows of a map at most.
const COLUMNS: usize = 260;
/// Dynamic range shown [dB].
const RANGE: f64 = 80.0;

/// A signal contains what is above this part of its largest amplitude, in some window.
const CONTAINED: f64 = 0.01;
/// Room above what a signal contains.
const ROOM: f64 = 1.2;
/// Highest order that is drawn by default, at least and at most.
const ORDERS: (f64, f64) = (3.0, 10.0);
/// A signal that changes by less than this part of its size is constant.
const CONSTANT: f64 = 1e-12;
/// Part of the interval of records by which one may differ, and the rounding of their times \[s\].
const UNEVEN: f64 = 0.02;
const ROUNDING: f64 = 2e-9;

/// Columns of amplitudes, from zero frequency up, and the place of each column (window's middle, in samples).
pub(super) struct Stft {
    pub columns: Vec<Vec<f64>>,
    pub middles: Vec<f64>,
}

/// Rows of a spectrum over time that are drawn.
pub(super) struct Content {
    /// Distance of two rows.
    pub resolution: f64,
    /// Rows.
    pub bins: usize,
    /// Largest amplitude in them; above zero.
    pub largest: f64,
}

/// Rows up to `top` \[Hz\], by default as far as the signal contains something, `least` at least.
pub(super) fn content(
    stft: &Stft,
    channel: &Series,
    window: usize,
    interval: f64,
    top: Option<f64>,
    least: f64,
) -> Result<Content, SpectrumError> {
    let resolution = 1.0 / (window as f64 * interval);
    let nyquist = 0.5 / interval;
    let row = resolution / PADDING as f64;
    let top = top.unwrap_or_else(|| (ROOM * row * highest(stft) as f64).max(least)).clamp(8.0 * resolution, nyquist);
    let bins = ((top / row) as usize).clamp(2, PADDING * window / 2);
    Ok(Content { resolution: row, bins, largest: largest(stft, channel, bins)? })
}

/// The highest row in which an amplitude is not small beside the largest one.
fn highest(stft: &Stft) -> usize {
    let most = stft.columns.iter().flat_map(|column| &column[1..]).copied().fold(0.0, f64::max);
    let contained = |column: &Vec<f64>| column.iter().rposition(|value| *value > CONTAINED * most).unwrap_or(0);
    stft.columns.iter().map(contained).max().unwrap_or(0)
}

/// The largest amplitude of the first rows.
fn largest(stft: &Stft, channel: &Series, bins: usize) -> Result<f64, SpectrumError> {
    let largest = stft.columns.iter().flat_map(|column| &column[1..bins]).copied().fold(0.0, f64::max);
    let size = channel.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if largest > CONSTANT * size { Ok(largest) } else { Err(SpectrumError::Constant { channel: channel.name.clone() }) }
}

/// Records at even intervals, `least` of them at least, in which these channels have numbers; and the interval \[s\].
pub(super) fn even_records(
    history: &History,
    channels: &[&Series],
    least: usize,
) -> Result<(usize, f64), SpectrumError> {
    let time = &history.time;
    let records = even(time);
    if records < least {
        return Err(SpectrumError::Short { records, least });
    }
    let interval = (time[records - 1] - time[0]) / (records - 1) as f64;
    let is_off = |pair: &&[f64]| (pair[1] - pair[0] - interval).abs() > UNEVEN * interval + ROUNDING;
    if let Some(pair) = time[..records].windows(2).find(is_off) {
        return Err(SpectrumError::Uneven { at: pair[0], interval });
    }
    for channel in channels {
        if let Some(at) = channel.values[..records].iter().position(|value| !value.is_finite()) {
            return Err(SpectrumError::NoNumber { channel: channel.name.clone(), at: time[at] });
        }
    }
    Ok((records, interval))
}

/// Windows are padded with zeros to so many times their length: rows between the frequencies that a window resolves.
const PADDING: usize = 2;

/// Blackman-Harris window: side lobes at -92 dB, below what is shown (Harris 1978, the minimum 4-term window).
fn taper(share: f64) -> f64 {
    let angle = 2.0 * PI * share;
    0.35875 - 0.48829 * angle.cos() + 0.14128 * (2.0 * angle).cos() - 0.01168 * (3.0 * angle).cos()
}

pub(super) fn stft(samples: &[f64], window: usize) -> Stft {
    let hop = (window / 32).max((samples.len().saturating_sub(window)) / COLUMNS).max(1);
    let taper: Vec<f64> = (0..window).map(|k| taper(k as f64 / window as f64)).collect();
    let sum: f64 = taper.iter().sum();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(PADDING * window);
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    let (mut columns, mut middles) = (Vec::new(), Vec::new());
    let mut from = 0;
    while from + window <= samples.len() {
        let part = &samples[from..from + window];
        let mean = part.iter().sum::<f64>() / window as f64;
        input[window..].fill(0.0);
        for ((x, sample), taper) in input.iter_mut().zip(part).zip(&taper) {
            *x = (sample - mean) * taper;
        }
        // lengths are those the plan made
        if transform.process(&mut input, &mut output).is_err() {
            break;
        }
        columns.push(output.iter().map(|value| 2.0 * value.norm() / sum).collect());
        middles.push(from as f64 + 0.5 * window as f64);
        from += hop;
    }
    Stft { columns, middles }
}

/// Window length: a power of two near an eighth of the samples, and not much longer than 32 turns of the fastest spin \[Hz\]: an event of some turns in a long run
/// would have a small amplitude in a longer window.
pub(super) fn window_of(samples: usize, interval: f64, spin: f64) -> usize {
    let turns = if spin > 0.0 { (32.0 / (spin * interval)).min(16384.0) as usize } else { 16384 };
    (samples / 8).min(turns).next_power_of_two().clamp(64, 16384)
}

/// Records at even intervals: all but the last, which is the run's end, where that lies off the interval.
pub(super) fn even(time: &[f64]) -> usize {
    let &[.., before, last] = time else { return time.len() };
    let interval = time[1] - time[0];
    if ((last - before) / interval - 1.0).abs() < 1e-6 { time.len() } else { time.len() - 1 }
}

/// Spectrogram of a channel, up to `top` \[Hz\] (by default what the signal contains, and 1x at least).
///
/// # Errors
/// Too few records or uneven ones or a constant signal.
pub fn spectrogram(history: &History, name: &str, channel: &Series, top: Option<f64>) -> Result<Figure, FigureError> {
    let (records, interval) = even_records(history, &[channel], 256)?;
    let speed = history.channel("rotor.speed_rad_s").map_or(&[][..], |speed| &speed.values);
    let spin = speed.iter().filter(|w| w.is_finite()).fold(0.0_f64, |most, w| most.max(w.abs())) / (2.0 * PI);
    let window = window_of(records, interval, spin);
    let stft = stft(&channel.values[..records], window);
    let Content { resolution, bins, largest } = content(&stft, channel, window, interval, top, ROOM * spin)?;
    let half = 0.5 * window as f64 * interval;
    let x_range = (history.time[0] + half, history.time[records - 1] - half);
    let top = bins as f64 * resolution;
    let lines = synchronous(history, x_range, top);
    let title = format!("{name}: spectrogram of {}", plain_name(&channel.name, &channel.unit));
    let note = format!("Blackman-Harris windows of {} s", crate::drawing::shown(window as f64 * interval));
    Ok(draw(&stft, channel, (bins, largest), (&title, &note, "frequency [Hz]", 8), x_range, top, &lines))
}

/// The lines 1x, 2x, 3x of the spin over time.
fn synchronous(history: &History, (from, to): (f64, f64), top: f64) -> Vec<(String, Vec<(f64, f64)>)> {
    let Some(speed) = history.channel("rotor.speed_rad_s") else { return Vec::new() };
    (1..=3)
        .map(|order| {
            let points = history.time.iter().zip(&speed.values).step_by((history.time.len() / 200).max(1));
            let points = points.filter(|(time, _)| (from..=to).contains(*time));
            let points: Vec<(f64, f64)> = points
                .map(|(time, speed)| (*time, f64::from(order) * speed / (2.0 * PI)))
                .filter(|p| p.1 <= top)
                .collect();
            (format!("{order}×"), points)
        })
        .filter(|(_, points)| points.len() > 1)
        .collect()
}

/// Order map of a channel, up to order `top` (by default what the signal contains, 3 to 10).
///
/// # Errors
/// No spin angle, too few or too many turns for the records or a constant signal.
pub fn order_map(history: &History, name: &str, channel: &Series, top: Option<f64>) -> Result<Figure, FigureError> {
    /// Samples per turn: orders up to a quarter of it are clean.
    const PER_TURN: f64 = 64.0;
    const TURNS: f64 = 16.0;
    let angle = history.channel("rotor.angle_rad").ok_or(SpectrumError::NoAngle)?;
    for series in [angle, channel] {
        if let Some(at) = series.values.iter().position(|value| !value.is_finite()) {
            return Err(SpectrumError::NoNumber { channel: series.name.clone(), at: history.time[at] }.into());
        }
    }
    let angle = &angle.values;
    let first = angle.first().copied().unwrap_or(0.0);
    let turns = (angle.last().copied().unwrap_or(0.0) - first) / (2.0 * PI);
    if turns < 1.5 * TURNS {
        return Err(SpectrumError::FewTurns { turns, least: 1.5 * TURNS }.into());
    }
    let per_record = turns / angle.len() as f64;
    if per_record > 1.0 {
        return Err(SpectrumError::FastTurns { per_record }.into());
    }
    // linear interpolation at equal angles; the angle of a run that is braked to rest never falls
    let count = (turns * PER_TURN) as usize;
    let (mut samples, mut times) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut at = 0;
    for k in 0..count {
        let wanted = first + 2.0 * PI * k as f64 / PER_TURN;
        while at + 2 < angle.len() && angle[at + 1] < wanted {
            at += 1;
        }
        let t = ((wanted - angle[at]) / (angle[at + 1] - angle[at]).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        samples.push(channel.values[at] + t * (channel.values[at + 1] - channel.values[at]));
        times.push(history.time[at] + t * (history.time[at + 1] - history.time[at]));
    }
    let window = (TURNS * PER_TURN) as usize;
    let stft = stft(&samples, window);
    let per_order = PADDING as f64 * TURNS;
    let contained = || (ROOM * highest(&stft) as f64 / per_order).clamp(ORDERS.0, ORDERS.1).ceil();
    let bins = ((top.unwrap_or_else(contained) * per_order) as usize).clamp(2, PADDING * window / 4);
    let largest = largest(&stft, channel, bins)?;
    // columns are even in turns: put them where they are in time
    let middles: Vec<f64> = stft.middles.iter().map(|middle| times[(*middle as usize).min(count - 1)]).collect();
    let x_range = (middles[0], middles[middles.len() - 1]);
    let even: Vec<Vec<f64>> = (0..COLUMNS)
        .map(|k| {
            let time = x_range.0 + (x_range.1 - x_range.0) * (k as f64 + 0.5) / COLUMNS as f64;
            let next = middles.partition_point(|middle| *middle < time).min(middles.len() - 1);
            stft.columns[next].clone()
        })
        .collect();
    let even = Stft { columns: even, middles: Vec::new() };
    let title = format!("{name}: orders of {}", plain_name(&channel.name, &channel.unit));
    let note = format!("Blackman-Harris windows of {TURNS} turns");
    // a number at each order, as far as there is room
    let named = (&*title, &*note, "order [events per turn]", 12);
    Ok(draw(&even, channel, (bins, largest), named, x_range, bins as f64 / per_order, &[]))
}

fn draw(
    stft: &Stft,
    channel: &Series,
    (bins, largest): (usize, f64),
    (title, note, y_label, y_labels): (&str, &str, &str, u32),
    x_range: (f64, f64),
    top: f64,
    lines: &[(String, Vec<(f64, f64)>)],
) -> Figure {
    let scale = Scale::of(&channel.unit, largest);
    let decibel = |value: f64| 20.0 * (value / largest).max(1e-12).log10();
    let columns: Vec<Vec<f64>> =
        stft.columns.iter().map(|column| column[..bins].iter().map(|value| decibel(*value)).collect()).collect();
    let full = largest * scale.factor;
    let z_label = format!("amplitude [dB re {} {}]", crate::drawing::shown(full), scale.unit);
    map(&Map {
        title,
        note,
        x_label: "time [s]",
        y_label,
        z_label: &z_label,
        x_range,
        y_range: (0.0, top),
        y_labels,
        columns: &columns,
        z_range: (-RANGE, 0.0),
        lines,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_shows_with_its_frequency_and_amplitude() {
        let samples: Vec<f64> = (0..8192).map(|k| 3.0 * (2.0 * PI * 0.0625 * f64::from(k)).sin() + 5.0).collect();
        let stft = stft(&samples, 512);
        for column in &stft.columns {
            let (bin, value) = column.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("not empty");
            assert_eq!(bin, 32 * PADDING);
            assert!((value - 3.0).abs() < 1e-9);
            assert!(column[0] < 1e-9, "the mean is taken out");
        }
    }

    #[test]
    fn the_range_is_what_the_signal_contains_and_nothing_is_drawn_empty() {
        let time: Vec<f64> = (0..8_000).map(|k| f64::from(k) * 1e-4).collect();
        let series = |values: Vec<f64>| Series { name: "a.x_m".into(), unit: "m".into(), values };
        let of = |values: Vec<f64>| {
            let channel = series(values);
            let (_, interval) = even_records(&History { time: time.clone(), ..History::default() }, &[&channel], 256)?;
            content(&stft(&channel.values, 1024), &channel, 1024, interval, None, 0.0)
        };
        let sine = |frequency: f64| time.iter().map(|t| 1e-5 * (2.0 * PI * frequency * t).sin()).collect::<Vec<_>>();
        for frequency in [200.0, 1000.0] {
            let found = of(sine(frequency)).expect("a signal");
            let top = found.bins as f64 * found.resolution;
            assert!((frequency..1.5 * frequency).contains(&top), "{frequency}: {top}");
            assert!((found.largest / 1e-5 - 1.0).abs() < 0.02, "{}", found.largest);
        }
        assert!(matches!(of(vec![4.2; 8_000]), Err(SpectrumError::Constant { .. })));
        let mut broken = sine(200.0);
        broken[77] = f64::NAN;
        assert!(matches!(of(broken), Err(SpectrumError::NoNumber { at, .. }) if at == time[77]));
        let gap =
            History { time: time.iter().map(|t| if *t > 0.3 { t + 0.01 } else { *t }).collect(), ..History::default() };
        assert!(matches!(even_records(&gap, &[], 256), Err(SpectrumError::Uneven { .. })));
    }

    #[test]
    fn an_end_off_the_interval_is_no_sample() {
        let mut time: Vec<f64> = (0..300).map(|k| f64::from(k) * 1e-4).collect();
        assert_eq!(even(&time), 300);
        time.push(299.3 * 1e-4);
        assert_eq!(even(&time), 300);
        assert_eq!((even(&[]), even(&[0.0]), even(&[0.0, 1.0])), (0, 1, 2));
    }

    #[test]
    fn angles_that_run_away_from_the_records_are_refused() {
        let time: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let of = |name: &str, values: Vec<f64>| Series { name: name.to_owned(), unit: String::new(), values };
        let channel = of("x_m", time.iter().map(|t| (50.0 * t).sin()).collect());
        for factor in [1e4, 1e92] {
            let angle = of("rotor.angle_rad", time.iter().map(|t| factor * t).collect());
            let history = History { time: time.clone(), channels: vec![angle, channel.clone()], ..History::default() };
            let error = order_map(&history, "a", &channel, None).expect_err("too fast").to_string();
            assert!(error.contains("at least one record a turn"), "{error}");
        }
    }

    #[test]
    fn an_order_stays_while_the_speed_falls() {
        // spin from 50 to 25 turns a second in 4 s; a channel that turns with it three times
        let time: Vec<f64> = (0..40_000).map(|k| f64::from(k) * 1e-4).collect();
        let angle: Vec<f64> = time.iter().map(|t| 2.0 * PI * (50.0 * t - 3.125 * t * t)).collect();
        let third: Vec<f64> = angle.iter().map(|a| (3.0 * a).cos()).collect();
        let series = |name: &str, values: Vec<f64>| Series { name: name.into(), unit: "m".into(), values };
        let channel = series("x_m", third);
        let history =
            History { time, channels: vec![series("rotor.angle_rad", angle), channel.clone()], ..History::default() };
        let figure = order_map(&history, "run", &channel, None).expect("enough turns");
        assert!(figure.svg().contains("order [events per turn]"));
        // order 3 with its room: numbers up to 4
        let is_tick = |figure: &Figure, tick: &str| figure.svg().contains(&format!(">{tick}</text>"));
        assert!(is_tick(&figure, "4") && !is_tick(&figure, "5"), "{}", figure.svg());
        assert!(spectrogram(&history, "run", &channel, None).expect("enough records").svg().contains("frequency [Hz]"));
    }
}
