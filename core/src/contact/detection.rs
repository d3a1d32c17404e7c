//! Closest point of the deformed ring: the global minimum of `|P(alpha) - x|` over all angles.
//!
//! The ring is sampled more finely than its elements. Every sampled local minimum that could be the global one is refined to the root of `d.P_alpha`.
//! The refinement is one-sided at element ends, where the curvature of the cubic elements jumps and a minimum may be at the kink. Several minima
//! exist in heavy rub; the lowest is used. Source: docs/theory/03-contact.md, Hyp 2.
//! Verified by `detection_equals_brute_force_on_two_thousand_deformed_rings`, many with several minima (`tests/contact/detection.rs`).

use super::gap::Place;
use crate::stator::{Sample, Surface};

/// Search for contact places on one ring.
#[derive(Debug, Clone)]
pub struct Detector {
    /// Contact surface of the ring.
    surface: Surface,
    /// Number of samples per element.
    per_element: usize,
    /// Shape functions at the samples of one element.
    samples: Vec<Sample>,
    /// sin and cos of the angle of each sample.
    angles: Vec<(f64, f64)>,
    /// Squared distance of each sample from the rotor centre \[m2\].
    distances: Vec<f64>,
}

/// Minimum number of samples of a ring.
const SAMPLES: usize = 128;

impl Detector {
    /// Detector for a contact surface.
    #[must_use]
    pub fn new(surface: Surface) -> Self {
        let per_element = SAMPLES.div_ceil(surface.nodes).max(4);
        let count = per_element * surface.nodes;
        let angles = (0..count)
            .map(|i| libm::sincos(surface.angle(i / per_element, (i % per_element) as f64 / per_element as f64)))
            .collect();
        let samples = (0..per_element).map(|k| surface.sample(k as f64 / per_element as f64)).collect();
        Self { surface, per_element, samples, angles, distances: vec![0.0; count] }
    }

    /// Place of the global minimum of the distance to `x` on a ring with nodal degrees of freedom `field`.
    #[must_use]
    pub fn closest(&mut self, field: &[f64], x: [f64; 2]) -> Place {
        self.sample(field, x);
        let lowest = self.distances.iter().copied().fold(f64::INFINITY, f64::min);
        let mut best: Option<(f64, usize, f64)> = None;
        for i in 0..self.distances.len() {
            // a parabola through three samples dips below the middle one by at most an eighth of its second difference
            if self.dip(i).is_none_or(|dip| self.distances[i] - dip > lowest) {
                continue;
            }
            for candidate in self.refine(field, x, i) {
                if best.is_none_or(|(distance, ..)| candidate.0 < distance) {
                    best = Some(candidate);
                }
            }
        }
        let (_, element, xi) = best.unwrap_or((0.0, 0, 0.0));
        Place::in_element(&self.surface, element, xi)
    }

    /// Number of local minima nearer than `radius`, among the samples of the last search.
    #[must_use]
    pub fn minima_within(&self, radius: f64) -> usize {
        (0..self.distances.len()).filter(|&i| self.distances[i] < radius * radius && self.dip(i).is_some()).count()
    }

    /// Places of all local minima of the distance, by ascending angle.
    pub fn minima(&mut self, field: &[f64], x: [f64; 2], places: &mut Vec<Place>) {
        self.sample(field, x);
        places.clear();
        for i in (0..self.distances.len()).filter(|&i| self.dip(i).is_some()) {
            let lowest = self.refine(field, x, i).min_by(|a, b| a.0.total_cmp(&b.0));
            places.extend(lowest.map(|(_, element, xi)| Place::in_element(&self.surface, element, xi)));
        }
    }

    /// Upper bound of the dip of the squared distance below a sample that is not above its neighbours; `None` for any other sample.
    fn dip(&self, i: usize) -> Option<f64> {
        let count = self.distances.len();
        let (left, here, right) =
            (self.distances[(i + count - 1) % count], self.distances[i], self.distances[(i + 1) % count]);
        (here <= left && here <= right).then(|| 0.5 * (left - here).max(right - here))
    }

    /// Computes squared distances at the samples.
    fn sample(&mut self, field: &[f64], x: [f64; 2]) {
        let Self { surface, per_element, samples, angles, distances } = self;
        let elements = angles.chunks_exact(*per_element).zip(distances.chunks_exact_mut(*per_element));
        for (element, (angles, distances)) in elements.enumerate() {
            for ((sample, (sin, cos)), distance) in samples.iter().zip(angles).zip(distances) {
                let [radial, tangential] = surface.displaced(field, element, sample);
                let dr = radial - (cos * x[0] + sin * x[1]);
                let dt = tangential - (cos * x[1] - sin * x[0]);
                *distance = dr * dr + dt * dt;
            }
        }
    }

    /// Minima in the two sample intervals around sample i, and the sample itself, as (squared distance, element, xi).
    fn refine(&self, field: &[f64], x: [f64; 2], i: usize) -> impl Iterator<Item = (f64, usize, f64)> + use<> {
        let count = self.distances.len();
        let step = 1.0 / self.per_element as f64;
        let before = (i + count - 1) % count;
        let place = |sample: usize| (sample / self.per_element, (sample % self.per_element) as f64 * step);
        let mut found = [None; 3];
        let (element, xi) = place(i);
        found[0] = Some((self.distances[i], element, xi));
        for (slot, start) in [(1, before), (2, i)] {
            let (element, from) = place(start);
            if let Some(xi) = self.root(field, x, element, from, from + step) {
                found[slot] = Some((self.slope_and_distance(field, x, element, xi).1, element, xi));
            }
        }
        found.into_iter().flatten()
    }

    /// Slope `d.P_alpha` and squared distance `|d|^2` at a place.
    fn slope_and_distance(&self, field: &[f64], x: [f64; 2], element: usize, xi: f64) -> (f64, f64) {
        let point = self.surface.point(field, element, xi);
        let (sin, cos) = libm::sincos(self.surface.angle(element, xi));
        let dr = point.radial - (cos * x[0] + sin * x[1]);
        let dt = point.tangential - (cos * x[1] - sin * x[0]);
        let slope = dr * (point.radial_slope - point.tangential) + dt * (point.radial + point.tangential_slope);
        (slope, dr * dr + dt * dt)
    }

    /// Root of the slope where it changes from negative to positive within one element (Illinois variant of regula falsi).
    fn root(&self, field: &[f64], x: [f64; 2], element: usize, from: f64, to: f64) -> Option<f64> {
        let slope = |xi: f64| self.slope_and_distance(field, x, element, xi).0;
        let (mut a, mut b) = (from, to);
        let (mut fa, mut fb) = (slope(a), slope(b));
        if fa > 0.0 || fb < 0.0 {
            return None;
        }
        let mut side = 0_i8;
        for _ in 0..60 {
            if fb - fa <= 0.0 {
                break;
            }
            let c = ((a * fb - b * fa) / (fb - fa)).clamp(a, b);
            let fc = slope(c);
            if fc == 0.0 || b - a < 1e-15 {
                return Some(c);
            }
            if fc < 0.0 {
                if c - a < 1e-15 && side == -1 {
                    return Some(c);
                }
                (a, fa) = (c, fc);
                if side == -1 {
                    fb *= 0.5;
                }
                side = -1;
            } else {
                if b - c < 1e-15 && side == 1 {
                    return Some(c);
                }
                (b, fb) = (c, fc);
                if side == 1 {
                    fa *= 0.5;
                }
                side = 1;
            }
        }
        Some(0.5 * (a + b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::exact_gap;
    use crate::stator::steel_ring;

    #[test]
    fn the_closest_place_and_the_number_of_minima() {
        let surface = steel_ring(24, 0.353, 0.328, true);
        let mut detector = Detector::new(surface);
        let field = vec![0.0; 96];
        for k in 0..200 {
            let gamma = f64::from(k) * 0.0317;
            let x = [4e-3 * gamma.cos(), 4e-3 * gamma.sin()];
            let place = detector.closest(&field, x);
            let gap = exact_gap(&surface, Some(&field), 0.32, x, place);
            assert!((gap.value - 4e-3).abs() < 1e-15, "{}", gap.value);
            assert!(gap.normal[1].abs() < 1e-12);
        }
        // a wave with two lobes pressed in at 0 and pi: a centred rotor is nearest at both, and at no place within a smaller radius
        let lobes: Vec<f64> = (0..96)
            .map(|i| if i % 4 == 2 { -1e-3 * (f64::from(i / 4) / 6.0 * std::f64::consts::PI).cos() } else { 0.0 })
            .collect();
        let _ = detector.closest(&lobes, [0.0, 0.0]);
        assert_eq!((detector.minima_within(0.3275), detector.minima_within(0.3269)), (2, 0));
        let centred = detector.closest(&field, [0.0, 0.0]);
        assert!(centred.alpha.is_finite());
    }
}
