//! Cells of a smoothed raster over scattered samples; only where samples are near.

use super::place::{Item, Items, Seen, most_frequent};
use super::smooth::{FEWEST, LEAST_WIDTH, Smooth, Smoother, wilson};
use super::{Cell, Frame, Map, Shows};
use crate::estimate::truth::Truth;
use bladeoff_numerics::probability::normal_quantile;

/// Distance between the values of an axis that is drawn value by value; larger than any smoothing width.
const APART: f64 = 10.0;

/// Standard errors below this share of the largest value are rounding errors.
const ROUNDING: f64 = 1e-10;

/// Half the diagonal of a cell of the finest raster: samples in a cell always reach its midpoint.
const LEAST_REACH: f64 = 0.018;

/// Skewness of the noise below which limits have no note: limits of exponential noise (skewness 2) hold in 80 to 92 of 100 cells.
const LEAST_SKEWNESS: f64 = 1.0;

/// Smoothed quantities: values of ok runs, or shares with open runs harmless, harmful, and at their least and most.
struct Series {
    middle: Smoother,
    /// Share with open runs harmful; `None` if no run is open.
    harmful: Option<Smoother>,
    /// Smoothers of half the width for the limits: least and most possible value.
    ends: [Smoother; 2],
}

impl Series {
    fn new(middle: Smoother, others: Option<[Smoother; 3]>) -> Self {
        let half = |of: &Smoother| of.of_width((0.5 * of.width()).max(LEAST_WIDTH));
        match others {
            None => Self { ends: [half(&middle), half(&middle)], harmful: None, middle },
            Some([harmful, least, most]) => Self { ends: [half(&least), half(&most)], harmful: Some(harmful), middle },
        }
    }
}

/// Fills the cells of a map.
pub(super) fn fill(frame: &Frame<'_>, items: &Items, map: &mut Map, is_share: bool) {
    map.shows = if is_share { Shows::SmoothedProbability } else { Shows::SmoothedMean };
    let scale = |axis: &super::Axis, is_single: bool| {
        let at = axis.at.clone();
        let (first, last) = (at[0], at[at.len() - 1]);
        // midpoints of the outer cells: half a cell inside the range
        let half = if at.len() > 1 { 0.5 * (last - first) / (at.len() - 1) as f64 } else { 0.5 };
        move |value: f64| match at.binary_search_by(|known| known.total_cmp(&value)) {
            Ok(place) if is_single => APART * place as f64,
            _ => (value - first + half) / (last - first + 2.0 * half),
        }
    };
    let (single_x, single_y) = frame.places.single;
    if map.x.at.is_empty() || map.y.at.is_empty() || items.list.is_empty() {
        return;
    }
    let (u, v) = (scale(&map.x, single_x), scale(&map.y, single_y));
    let place = |item: &Item| (u(item.x), v(item.y));
    if !is_share {
        let ends = items.list.iter().filter_map(|item| known(item.seen));
        map.runs = ends.fold(None, |ends: Option<(f64, f64)>, value| {
            let (low, high) = ends.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        });
    }
    let Some(series) = series(items, place, is_share) else {
        map.notes.push(format!("fewer than {FEWEST} runs have a value: nothing is smoothed"));
        map.undrawn = Some(map.n);
        return;
    };
    let width = series.middle.width();
    map.width = Some(width);
    let columns = if single_x {
        map.x.at.len()
    } else if single_y {
        map.y.at.len()
    } else {
        1
    };
    let samples = items.list.len() as f64 / columns as f64;
    let reach = if columns > 1 { 4.0 / samples } else { 1.75 / samples.sqrt() }.max(LEAST_REACH);
    map.notes.push(told(is_share, width, reach));
    if !frame.study.design.is_random() {
        map.notes.push(
            "the samples are chosen, not random: the limits describe their scatter around the smoothed values"
                .to_owned(),
        );
    }
    if !is_share && map.bad > 0 {
        let what = map.bad_in_words();
        map.notes.push(format!(
            "{what} ({}) have no value and are not in any mean; marks show where they are. Near a mark the mean is \
             that of the other runs, without limits",
            map.bad
        ));
    }
    let (xs, ys) = (map.x.edges(), map.y.edges());
    let index =
        |edges: &[f64], value: f64| (edges.partition_point(|edge| *edge <= value).max(1) - 1).min(edges.len() - 2);
    let mut counts = vec![(0, 0, 0); map.x.at.len() * map.y.at.len()];
    let mut undrawn = 0;
    for item in &items.list {
        let count: &mut (u64, u64, u64) = &mut counts[index(&xs, item.x) * map.y.at.len() + index(&ys, item.y)];
        *count = (count.0 + 1, count.1 + u64::from(item.is_bad()), count.2 + u64::from(item.is_beyond()));
    }
    // a column with few samples does not show its scatter; a share has Wilson's limits
    let is_told = is_share || columns == 1 || samples >= FEWEST as f64;
    let z = normal_quantile(1.0 - frame.alpha / 2.0, frame.alpha / 2.0);
    let largest = items.list.iter().map(size).fold(0.0_f64, f64::max);
    let is_pair = map.difference.is_some();
    let open: Vec<(f64, f64)> = items
        .list
        .iter()
        .filter(|item| if is_share { item.seen.is_open() } else { item.is_bad() })
        .map(place)
        .collect();
    let is_open_at = |(u, v): (f64, f64), width: f64| {
        open.iter().any(|(x, y)| (x - u) * (x - u) + (y - v) * (y - v) < width * width)
    };
    let skewed = if is_share { None } else { series.skewed() };
    let (mut limited, mut doubtful) = (0u64, 0u64);
    for (at, (n, bad, beyond)) in counts.into_iter().enumerate() {
        let (i, j) = (at / map.y.at.len(), at % map.y.at.len());
        let here = (u(map.x.at[i]), v(map.y.at[j]));
        if series.middle.nearest(here) > reach {
            undrawn += n;
            continue;
        }
        let Some((mut found, window)) = series.middle.reaching(here) else {
            undrawn += n;
            continue;
        };
        // the error of an exact plane is rounding, not scatter
        if found.error < ROUNDING * largest {
            found.error = 0.0;
        }
        if is_share && !is_pair {
            // a sum of weights may exceed 1 by rounding
            found.value = found.value.clamp(0.0, 1.0);
        }
        let Some(Figures { harmful, low, high }) = series.figures(here, (found, window), z, is_share && !is_pair)
        else {
            undrawn += n;
            continue;
        };
        let is_open = is_open_at(here, window);
        // the values of bad runs are unknown: limits near one apply to the other runs only
        let is_known = is_share || !is_open;
        let is_limited = is_told || found.error == 0.0;
        let has_limits = is_known && is_limited;
        if has_limits && low.is_some() && found.error > 0.0 {
            limited += 1;
            doubtful += u64::from(
                skewed.is_some_and(|(_, wanted)| series.ends[0].at(here).is_some_and(|of| of.count < wanted)),
            );
        }
        map.cells.push(Cell {
            at: (i, j),
            x: map.x.at[i],
            y: map.y.at[j],
            n,
            bad,
            beyond,
            estimate: Some(found.value),
            estimate_if_bad_harmful: Some(harmful).filter(|_| is_known),
            low: low.filter(|_| has_limits),
            high: high.filter(|_| has_limits),
            upper: None,
            upper_if_bad_harmful: None,
            regime: regime(items, place, here, &map.regimes),
            half_width: low.zip(high).filter(|_| is_limited).map(|(low, high)| 0.5 * (high - low)),
            is_open,
        });
    }
    map.undrawn = Some(undrawn);
    if let Some((skewness, wanted)) = skewed.filter(|_| doubtful > 0) {
        map.notes.push(format!(
            "the values are skewed (skewness {skewness:.1}) and the samples are too few in {doubtful} of {limited} \
             cells with limits. Limits of such cells held in 57 to 90 of 100 tests, not in 95. A window needs \
             {wanted:.0} equal samples or more"
        ));
    }
    if undrawn > 0 {
        let of = if is_pair { "pairs" } else { "runs" };
        map.notes.push(format!(
            "{undrawn} of {} {of} lie in cells that are not drawn: no run with a value is within {reach:.2} of these cells",
            map.n
        ));
    }
}

/// Value to be smoothed; `None` for a bad run, whose value is unknown.
fn known(seen: Seen) -> Option<f64> {
    match seen {
        Seen::Value(low, high) if low == high => Some(low),
        _ => None,
    }
}

fn size(item: &Item) -> f64 {
    known(item.seen).map_or(0.0, f64::abs)
}

fn told(is_share: bool, width: f64, reach: f64) -> String {
    let how = if is_share { "weighted shares" } else { "local linear fits" };
    format!(
        "smoothed: {how} of the samples within {:.2} of the range of both axes (width by cross-validation; wider and \
         without limits where samples are too few). About 95 % limits, without the bias of smoothing. Nothing is \
         drawn beyond {:.2} from a sample",
        width, reach
    )
}

fn series(items: &Items, place: impl Fn(&Item) -> (f64, f64), is_share: bool) -> Option<Series> {
    let samples = |of: &dyn Fn(Seen) -> Option<f64>| -> Vec<(f64, f64, f64)> {
        let with = |item: &Item| of(item.seen).map(|value| (place(item).0, place(item).1, value));
        items.list.iter().filter_map(with).collect()
    };
    if !is_share {
        return Some(Series::new(Smoother::new(&samples(&known), false)?, None));
    }
    let number = |is: bool| f64::from(u8::from(is));
    let of = |truth: fn(Truth) -> bool, other: fn(Truth) -> bool| {
        move |seen| match seen {
            Seen::Truth(a) => Some(number(truth(a))),
            Seen::Truths(a, b) => Some(number(truth(a)) - number(other(b))),
            _ => None,
        }
    };
    let middle = Smoother::new(&samples(&of(Truth::low, Truth::low)), true)?;
    if !items.list.iter().any(|item| item.seen.is_open()) {
        return Some(Series::new(middle, None));
    }
    let others = [
        samples(&of(Truth::high, Truth::high)),
        samples(&of(Truth::low, Truth::high)),
        samples(&of(Truth::high, Truth::low)),
    ];
    // All shares need one width, or an estimate could lie outside its limits: the narrowest that any of them needs. Constant samples
    // (as if only bad runs can be harmful) fit any width and are not considered.
    let varies = |samples: &[(f64, f64, f64)]| samples.windows(2).any(|pair| pair[0].2 != pair[1].2);
    let mut width = middle.width();
    for samples in others.iter().filter(|samples| varies(samples)) {
        width = Smoother::new(samples, true)?.width().min(width);
    }
    let middle = middle.of_width(width);
    let [harmful, least, most] = others.map(|samples| Smoother::with(&samples, true, Some(width)));
    Some(Series::new(middle, Some([harmful?, least?, most?])))
}

impl Series {
    /// Skewness of the noise, if it is not small, and the number of samples that the limits then need: 25 times its square, as for a mean.
    fn skewed(&self) -> Option<(f64, f64)> {
        let (skewness, each) = self.middle.skewness();
        let wanted = libm::ceil(25.0 * skewness * skewness * each);
        (skewness.abs() > LEAST_SKEWNESS).then_some((skewness, wanted))
    }

    /// Estimate with bad runs harmful, and limits, for a window; `None` if no sample is near.
    fn figures(
        &self,
        here: (f64, f64),
        (found, window): (Smooth, f64),
        z: f64,
        is_plain_share: bool,
    ) -> Option<Figures> {
        let most = if is_plain_share { 1.0 } else { f64::INFINITY };
        let harmful = match &self.harmful {
            Some(harmful) => harmful.within(here, window)?.min(most),
            None => found.value,
        };
        // A share has limits for any number of samples: 0 to 1 without samples, or in a widened window. A value has none if few samples do not
        // show the scatter.
        let limits = |of: &Smoother| {
            let is_widened = window > self.middle.width();
            if is_plain_share && is_widened {
                return Some((0.0, 1.0));
            }
            if is_plain_share {
                let smooth = of.of_few(here);
                return Some(smooth.map_or((0.0, 1.0), |of| wilson(of.value.clamp(0.0, 1.0), of.count, z)));
            }
            if found.error == 0.0 {
                return Some((found.value, found.value));
            }
            // narrower windows, which show the bias of a widened one, have too few samples
            if is_widened {
                return None;
            }
            let smooth = of.at(here)?;
            Some((smooth.value - z * smooth.error, smooth.value + z * smooth.error))
        };
        let [least, most] = &self.ends;
        // at shares of 0 and 1 rounding separates equal numbers
        let (low, high) = (limits(least).map(|limits| limits.0), limits(most).map(|limits| limits.1));
        let ends = low.zip(high).map(|(low, high)| (low.min(found.value), high.max(harmful)));
        Some(Figures { harmful, low: ends.map(|ends| ends.0), high: ends.map(|ends| ends.1) })
    }
}

/// Figures of a cell besides its estimate.
struct Figures {
    harmful: f64,
    low: Option<f64>,
    high: Option<f64>,
}

/// Largest number of samples searched for the regime of a place.
const ASKED: usize = 4096;

/// Number of nearest samples that determine the regime of a place.
const NEIGHBOURS: usize = 5;

/// Most frequent regime of the nearest ok runs; the worst of equally frequent ones. Independent of the smoothing width of the column.
/// Source: E. Fix, J. L. Hodges, "Discriminatory analysis" (1951).
fn regime(items: &Items, place: impl Fn(&Item) -> (f64, f64), (u, v): (f64, f64), words: &[String]) -> Option<String> {
    if words.is_empty() {
        return None;
    }
    let asked = items.list.iter().step_by(items.list.len().div_ceil(ASKED).max(1));
    let mut near: Vec<(f64, u32)> = asked
        .filter_map(|item| {
            let (x, y) = place(item);
            Some(((x - u) * (x - u) + (y - v) * (y - v), item.regime?))
        })
        .collect();
    if near.len() > NEIGHBOURS {
        near.select_nth_unstable_by(NEIGHBOURS - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(NEIGHBOURS);
    }
    most_frequent(near.into_iter().map(|(_, regime)| (regime, 1.0)), words)
}
