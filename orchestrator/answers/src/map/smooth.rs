//! Kernel smoother for scattered samples.
//!
//! ```text
//! places u, v: both axes scaled to 0..1;  weight of a sample at distance d: (1 - (d/h)^2)^2 for d < h, else 0
//! values    local linear: value at the place of the plane that fits the weighted samples best
//! shares    local constant: the weighted share, which stays between 0 and 1
//! width h   by leave-one-out cross-validation over a series of widths, each larger by sqrt(2)
//! limits    values: estimate -+ z sqrt(sum (l_i e_i)^2), l_i weight of the sample in the estimate, e_i its leave-one-out residual
//!           shares: E. B. Wilson (1927) for n = (sum w)^2/sum w^2 samples
//!           both with width h/2, or the least width: limits with h ignore the smoothing bias (along a smooth edge of a share 84 to 93 % of
//!           the cells held instead of 95; with h/2 93 to 96 %)
//! ```
//! Limits of values assume normal noise where few samples count; skewed noise has a note, see `skewness`.
//! Where h contains too few samples (edges, sparse regions) the window of that place is widened, see `Smoother::reaching`; such a value has
//! no limits.
//! Both estimators are linear in the samples, so leaving one out needs no second fit: e = (z - estimate)/(1 - l). Sources: W. S. Cleveland
//! (1979); J. Fan, I. Gijbels (1996). More than [`MOST_NODES`] samples are combined at their mean places in 64 x 64 parts of the map.
//! Verified by `a_plane_is_smoothed_to_itself`, `smoothed_limits_hold_the_truth`.

use std::collections::BTreeMap;

/// Largest number of samples kept individually; number of parts along each axis if there are more.
pub const MOST_NODES: usize = 4096;
const PARTS: f64 = 64.0;
/// Largest number of places at which a width is tested.
const TRIED: usize = 512;
/// Tested widths: the least one; each further one is larger by the square root of 2.
pub const LEAST_WIDTH: f64 = 0.05;
const WIDTHS: usize = 11;
/// Largest window of a single place, which weighs all samples of the unit square almost equally. Windows grow by the same steps.
const WIDEST: f64 = 4.0;
/// A fit needs more effective samples than this, or the window is widened: a plane has three coefficients. If no window has enough, the
/// smaller numbers apply in this order; with one sample or less a plane would extrapolate.
const ENOUGH: [f64; 3] = [3.0, 2.0, 1.0];
/// Smallest number of samples that are smoothed.
pub const FEWEST: usize = 10;

/// Samples at one place.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    u: f64,
    v: f64,
    count: f64,
    /// Sums of the values and of their squares.
    sum: f64,
    squares: f64,
}

/// A smoother with its samples.
#[derive(Debug, Clone)]
pub struct Smoother {
    nodes: Vec<Node>,
    /// Offset subtracted from all values, because squares of large values lose digits.
    middle: f64,
    is_share: bool,
    width: f64,
    /// Mean square of the leave-one-out residuals of the samples of each node.
    residual: Vec<f64>,
}

/// A smoothed value with its accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smooth {
    /// Smoothed value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
    /// Effective number of samples: equally many samples of equal weight give the same accuracy.
    pub count: f64,
}

/// Fit at a place.
struct Fit {
    value: f64,
    /// Nearby nodes, and the weight of one sample of each.
    parts: Vec<(usize, f64)>,
}

fn weight(node: &Node, (u, v): (f64, f64), width: f64) -> f64 {
    let (du, dv) = ((node.u - u) / width, (node.v - v) / width);
    let rest = 1.0 - du * du - dv * dv;
    if rest > 0.0 { rest * rest } else { 0.0 }
}

fn put_together(samples: &[(f64, f64, f64)], middle: f64) -> Vec<Node> {
    let single = |&(u, v, z): &(f64, f64, f64)| {
        let off = z - middle;
        Node { u, v, count: 1.0, sum: off, squares: off * off }
    };
    if samples.len() <= MOST_NODES {
        return samples.iter().map(single).collect();
    }
    let mut parts: BTreeMap<(i64, i64), Node> = BTreeMap::new();
    for sample in samples {
        let (one, part) = (single(sample), |place: f64| libm::floor(place * PARTS) as i64);
        let node = parts.entry((part(one.u), part(one.v))).or_default();
        node.count += 1.0;
        // running means keep a place within its part
        node.u += (one.u - node.u) / node.count;
        node.v += (one.v - node.v) / node.count;
        node.sum += one.sum;
        node.squares += one.squares;
    }
    parts.into_values().collect()
}

impl Smoother {
    /// A smoother of samples (u, v, value), with the width that predicts best; `is_share`: values are 0 or 1 (in differences -1 to 1).
    /// `None` if there are too few samples.
    pub fn new(samples: &[(f64, f64, f64)], is_share: bool) -> Option<Self> {
        Self::with(samples, is_share, None)
    }

    /// As [`Smoother::new`], with a width that was chosen for other values at these places.
    pub fn with(samples: &[(f64, f64, f64)], is_share: bool, width: Option<f64>) -> Option<Self> {
        if samples.len() < FEWEST {
            return None;
        }
        let middle =
            if is_share { 0.0 } else { samples.iter().map(|sample| sample.2).sum::<f64>() / samples.len() as f64 };
        let nodes = put_together(samples, middle);
        let mut smoother = Self { nodes, middle, is_share, width: 1.0, residual: Vec::new() };
        smoother.width = width.unwrap_or_else(|| smoother.choose());
        smoother.residual = (0..smoother.nodes.len()).map(|node| smoother.left_out(node)).collect();
        Some(smoother)
    }

    /// A smoother of these samples with another width.
    pub fn of_width(&self, width: f64) -> Self {
        let mut other = self.clone();
        if width != self.width {
            other.width = width;
            other.residual = (0..other.nodes.len()).map(|node| other.left_out(node)).collect();
        }
        other
    }

    /// Skewness of the leave-one-out residuals, and the mean number of samples of a node.
    pub fn skewness(&self) -> (f64, f64) {
        let (mut squares, mut cubes, mut n, mut samples) = (0.0, 0.0, 0.0, 0.0);
        for (at, node) in self.nodes.iter().enumerate() {
            let Some(off) = self.off(at) else { continue };
            (squares, cubes) = (squares + off * off, cubes + off * off * off);
            (n, samples) = (n + 1.0, samples + node.count);
        }
        let variance: f64 = squares / n;
        let skewness = cubes / n / (variance * variance.sqrt());
        (if skewness.is_finite() { skewness } else { 0.0 }, samples / n)
    }

    /// Leave-one-out residual of the mean of a node's samples; `None` if no other sample predicts the mean.
    fn off(&self, at: usize) -> Option<f64> {
        let node = &self.nodes[at];
        let fit = self.fit((node.u, node.v))?;
        let (_, own) = fit.parts.iter().find(|(place, _)| *place == at)?;
        let rest = 1.0 - own * node.count;
        (rest > 1e-6).then(|| (node.sum / node.count - fit.value) / rest)
    }

    /// Width as a share of the range of an axis.
    pub fn width(&self) -> f64 {
        self.width
    }

    fn choose(&mut self) -> f64 {
        let step = self.nodes.len().div_ceil(TRIED);
        let mut best = (f64::INFINITY, 1.0);
        for k in 0..WIDTHS {
            self.width = LEAST_WIDTH * libm::pow(2.0, 0.5 * k as f64);
            let tried = (0..self.nodes.len()).step_by(step);
            let score: f64 = tried.map(|node| self.nodes[node].count * self.left_out(node)).sum();
            // the wider of equally good widths: it scatters less
            if score <= best.0 * (1.0 + 1e-9) {
                best = (score.min(best.0), self.width);
            }
        }
        best.1
    }

    /// Mean square of the leave-one-out residuals of the samples of a node.
    fn left_out(&self, at: usize) -> f64 {
        let node = &self.nodes[at];
        let mean = node.sum / node.count;
        let scatter = (node.squares / node.count - mean * mean).max(0.0);
        let fit = self.fit((node.u, node.v));
        let own = fit.as_ref().and_then(|fit| fit.parts.iter().find(|(place, _)| *place == at));
        match (&fit, own) {
            (Some(fit), Some((_, own))) if 1.0 - own > 1e-6 => {
                let off = mean - fit.value;
                (scatter + off * off) / ((1.0 - own) * (1.0 - own))
            }
            // no prediction: a penalty larger than the scatter of all values
            _ => {
                let all = self.nodes.iter().fold((0.0, 0.0), |(n, sum), node| (n + node.count, sum + node.sum));
                let off = mean - all.1 / all.0;
                4.0 * (scatter + off * off) + f64::MIN_POSITIVE
            }
        }
    }

    fn fit(&self, place: (f64, f64)) -> Option<Fit> {
        self.fit_over(place, self.width, self.is_share)
    }

    /// `is_mean`: weighted mean instead of a plane.
    fn fit_over(&self, place: (f64, f64), width: f64, is_mean: bool) -> Option<Fit> {
        let mut parts: Vec<(usize, f64)> = Vec::new();
        let (mut total, mut du, mut dv) = (0.0, 0.0, 0.0);
        for (at, node) in self.nodes.iter().enumerate() {
            let w = weight(node, place, width);
            if w > 0.0 {
                parts.push((at, w));
                let w = w * node.count;
                total += w;
                du += w * (node.u - place.0);
                dv += w * (node.v - place.1);
            }
        }
        if total <= 0.0 {
            return None;
        }
        let (du, dv) = (du / total, dv / total);
        let offset = |node: &Node| (node.u - place.0 - du, node.v - place.1 - dv);
        // contribution of the slope: -(du, dv) S^-1 (u_i - mean)
        let (a, b) = if is_mean {
            (0.0, 0.0)
        } else {
            let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
            for &(at, w) in &parts {
                let (node, (x, y)) = (&self.nodes[at], offset(&self.nodes[at]));
                let w = w * node.count / total;
                (uu, uv, vv) = (uu + w * x * x, uv + w * x * y, vv + w * y * y);
            }
            slope((uu, uv, vv), (du, dv), width)
        };
        let mut value = 0.0;
        for (at, w) in &mut parts {
            let node = &self.nodes[*at];
            let (x, y) = offset(node);
            *w *= (1.0 - a * x - b * y) / total;
            value += *w * node.sum;
        }
        Some(Fit { value, parts })
    }

    /// Smoothed value at a place; `None` if no sample is near, or too few for a standard error (a plane has three coefficients).
    pub fn at(&self, place: (f64, f64)) -> Option<Smooth> {
        self.of_few(place).filter(|smooth| smooth.count > ENOUGH[0])
    }

    /// Smoothed value at a place, and its window: the width, or wider if that contains too few samples; `None` if no window contains a sample.
    /// If no window contains enough samples for a plane, the value is their mean.
    pub fn reaching(&self, place: (f64, f64)) -> Option<(Smooth, f64)> {
        let steps = (0..).map(|k| self.width * libm::pow(2.0, 0.5 * f64::from(k)));
        let widths: Vec<f64> = steps.take_while(|width| *width < WIDEST).chain([WIDEST]).collect();
        for enough in ENOUGH {
            for &width in &widths {
                if let Some(found) = self.over(place, width, self.is_share).filter(|found| found.count > enough) {
                    return Some((found, width));
                }
            }
        }
        Some((self.over(place, WIDEST, true)?, WIDEST))
    }

    /// Smoothed value for a window that [`Self::reaching`] chose for other values of the same samples.
    pub fn within(&self, place: (f64, f64), width: f64) -> Option<f64> {
        self.over(place, width, self.is_share).map(|found| found.value)
    }

    /// As [`Self::at`], for any number of samples.
    pub fn of_few(&self, place: (f64, f64)) -> Option<Smooth> {
        self.over(place, self.width, self.is_share)
    }

    fn over(&self, place: (f64, f64), width: f64, is_mean: bool) -> Option<Smooth> {
        let fit = self.fit_over(place, width, is_mean)?;
        let (mut error, mut squares) = (0.0, 0.0);
        for &(at, part) in &fit.parts {
            let count = self.nodes[at].count;
            error += count * part * part * self.residual[at];
            squares += count * part * part;
        }
        Some(Smooth { value: fit.value + self.middle, error: error.sqrt(), count: 1.0 / squares })
    }

    /// Distance to the nearest sample.
    pub fn nearest(&self, (u, v): (f64, f64)) -> f64 {
        let square = |node: &Node| (node.u - u) * (node.u - u) + (node.v - v) * (node.v - v);
        self.nodes.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
    }
}

/// S^-1 d; along one direction if the samples lie on a line.
fn slope((uu, uv, vv): (f64, f64, f64), (du, dv): (f64, f64), width: f64) -> (f64, f64) {
    let determinant = uu * vv - uv * uv;
    let scale = width * width;
    if determinant > 1e-6 * scale * scale {
        return ((vv * du - uv * dv) / determinant, (uu * dv - uv * du) / determinant);
    }
    match uu.max(vv) {
        most if most <= 1e-3 * scale => (0.0, 0.0),
        most if most == uu => (du / uu, 0.0),
        _ => (0.0, dv / vv),
    }
}

/// Limits of a share of `count` samples (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927)); `z`: quantile of the normal distribution.
pub fn wilson(share: f64, count: f64, z: f64) -> (f64, f64) {
    let square = z * z / count;
    let middle = (share + 0.5 * square) / (1.0 + square);
    let half = z * ((share * (1.0 - share)).max(0.0) / count + 0.25 * square / count).sqrt() / (1.0 + square);
    ((middle - half).max(0.0), (middle + half).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that fill the square evenly.
    fn spread(count: usize) -> impl Iterator<Item = (f64, f64)> {
        (0..count).map(|k| {
            let part = |step: f64| (0.5 + step * k as f64).fract();
            (part(0.754_877_666_246_692_7), part(0.569_840_290_998_053_2))
        })
    }

    #[test]
    fn a_plane_is_smoothed_to_itself() {
        for count in [60, 6000] {
            let samples: Vec<_> = spread(count).map(|(u, v)| (u, v, 3.0 + 2.0 * u - 5.0 * v)).collect();
            let smoother = Smoother::new(&samples, false).expect("enough");
            for (u, v) in [(0.5, 0.5), (0.02, 0.98), (0.9, 0.1)] {
                let found = smoother.at((u, v)).expect("samples are near");
                let off = found.value - (3.0 + 2.0 * u - 5.0 * v);
                assert!(off.abs() < 1e-9 && found.error < 0.05, "{count}: {off} {}", found.error);
            }
        }
    }

    #[test]
    fn leaving_one_out_is_fitting_without_it() {
        let samples: Vec<_> = spread(40).map(|(u, v)| (u, v, libm::sin(5.0 * u) + v * v)).collect();
        let smoother = Smoother::with(&samples, false, Some(0.6)).expect("enough");
        for (at, &(u, v, z)) in samples.iter().enumerate() {
            let mut others = samples.clone();
            others.remove(at);
            let without = Smoother::with(&others, false, Some(0.6)).expect("enough").fit((u, v)).expect("near");
            let without = without.value + others.iter().map(|other| other.2).sum::<f64>() / others.len() as f64;
            let off = smoother.left_out(at).sqrt();
            assert!((off - (z - without).abs()).abs() < 1e-9, "{at}: {off} {}", z - without);
        }
    }

    #[test]
    fn a_wave_takes_a_narrow_width_and_noise_a_wide_one() {
        let wave: Vec<_> = spread(900).map(|(u, v)| (u, v, libm::sin(20.0 * u))).collect();
        let noise: Vec<_> = spread(900).enumerate().map(|(k, (u, v))| (u, v, ((k * 7919) % 101) as f64)).collect();
        let width = |samples: &[(f64, f64, f64)]| Smoother::new(samples, false).expect("enough").width();
        assert!(width(&wave) < 0.2 && width(&noise) > 0.7, "{} {}", width(&wave), width(&noise));
    }

    #[test]
    fn limits_of_a_share_are_wilsons() {
        // 8 of 10 at 95 %: 0.4902 to 0.9433 (A. Agresti, B. A. Coull, 1998)
        let (low, high) = wilson(0.8, 10.0, 1.959_964);
        assert!((low - 0.490_16).abs() < 1e-4 && (high - 0.943_32).abs() < 1e-4, "{low} {high}");
    }
}
