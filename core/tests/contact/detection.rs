//! Exact detection against brute force on random deformed rings, many with several minima.

use crate::common::{machine, study_machine};
use bladeoff_core::contact::{Detector, exact_gap, polar_gap};
use bladeoff_core::stator::{RingMatrices, Surface};
use bladeoff_model::machine::DiaphragmKind;

/// A reproducible stream of random numbers in -1..1.
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Contact surface of a ring in a machine file, with its contact radius and R_r.
fn surface(name: &str, inner: bool) -> (Surface, f64) {
    let m = machine(&study_machine(name));
    let DiaphragmKind::Flexible(stator) = &m.diaphragms[0].kind else { panic!("a flexible diaphragm") };
    let contact = m.diaphragms[0].contact;
    (RingMatrices::assemble(stator).surface(contact.rotor_radius + contact.gap, inner), contact.rotor_radius)
}

/// A field of `harmonics` waves of a given size in u and v with their slopes, as nodal displacements of the ring.
fn field(surface: &Surface, mean_radius: f64, size: f64, harmonics: usize, random: &mut Stream) -> Vec<f64> {
    let mut all = vec![0.0; 4 * surface.nodes];
    for n in 1..=harmonics {
        let scale = size / n as f64;
        let (a, b, c, d) = (random.next() * scale, random.next() * scale, random.next() * scale, random.next() * scale);
        for node in 0..surface.nodes {
            let (s, k) = (n as f64 * surface.angle(node, 0.0)).sin_cos();
            let wave = n as f64 / mean_radius;
            all[4 * node] += a * k + b * s;
            all[4 * node + 1] += wave * (b * k - a * s);
            all[4 * node + 2] += c * k + d * s;
            all[4 * node + 3] += wave * (d * k - c * s);
        }
    }
    all
}

/// Smallest distance of the ring from x, by 4000 samples and golden-section searches around the lowest, and the number of separate minima that are
/// below the highest point by more than rounding. Six waves of 6 mm have a curvature of at most 0.2 m/rad^2, so the sample beside a minimum is within
/// 1e-7 m of it, and the search starts at every minimum within 1e-6 m.
fn brute_force(surface: &Surface, field: &[f64], x: [f64; 2]) -> (f64, usize) {
    const COUNT: usize = 4000;
    let distance = |alpha: f64| {
        let (element, xi) = surface.locate(alpha);
        let point = surface.point(field, element, xi);
        let (s, c) = alpha.sin_cos();
        let (px, py) = (c * point.radial - s * point.tangential, s * point.radial + c * point.tangential);
        (px - x[0]).hypot(py - x[1])
    };
    let turn = 2.0 * std::f64::consts::PI;
    let all: Vec<f64> = (0..COUNT).map(|i| distance(turn * i as f64 / COUNT as f64)).collect();
    let lowest = all.iter().copied().fold(f64::MAX, f64::min);
    let (mut best, mut minima) = (f64::MAX, 0);
    for i in 0..COUNT {
        let (before, here, after) = (all[(i + COUNT - 1) % COUNT], all[i], all[(i + 1) % COUNT]);
        if here < before && here <= after {
            minima += 1;
            if here < lowest + 1e-6 {
                let (mut a, mut b) = (turn * (i as f64 - 1.0) / COUNT as f64, turn * (i as f64 + 1.0) / COUNT as f64);
                let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
                while b - a > 1e-10 {
                    let (p, q) = (b - golden * (b - a), a + golden * (b - a));
                    if distance(p) < distance(q) { b = q } else { a = p }
                }
                best = best.min(distance(0.5 * (a + b)));
            }
        }
    }
    (best.min(lowest), minima)
}

#[test]
fn detection_equals_brute_force_on_two_thousand_deformed_rings() {
    let mut random = Stream(7);
    let mut counts = [0_usize; 6];
    let mut largest = 0.0_f64;
    let mut cases = 0;
    for (name, mean_radius, size, eccentricity) in
        [("lp_turbine_paper", 0.353, 6e-3, 14e-3), ("lab_rig", 0.052, 4e-4, 1e-3)]
    {
        for inner in [true, false] {
            let (surface, radius) = surface(name, inner);
            let mut detector = Detector::new(surface);
            for case in 0..550 {
                let harmonics = 1 + case % 6;
                let ring = field(&surface, mean_radius, size * (0.05 + random.next().abs()), harmonics, &mut random);
                // from the centre to well beyond the gap
                let (r, angle) = (eccentricity * random.next().abs(), std::f64::consts::PI * random.next());
                let x = [r * angle.cos(), r * angle.sin()];
                let place = detector.closest(&ring, x);
                let gap = exact_gap(&surface, Some(&ring), radius, x, place).value;
                let (distance, minima) = brute_force(&surface, &ring, x);
                let error = (gap - (distance - radius)).abs() / radius;
                largest = largest.max(error);
                assert!(error < 1e-13, "{name} inner {inner} case {case}: {gap} {}", distance - radius);
                counts[minima.min(5)] += 1;
                cases += 1;
            }
        }
    }
    println!("{cases} rings: largest error {largest:.1e} of R_r; with 1, 2, 3, 4, 5+ minima: {:?}", &counts[1..]);
    assert!(cases >= 2000 && counts[0] == 0);
    assert!(counts[2] >= 300 && counts[3] >= 150, "{counts:?}");
}

#[test]
fn detection_finds_the_lowest_of_two_nearly_equal_minima() {
    // an oval ring with the rotor at its centre has two minima half a turn apart; a shift of 1e-9 m determines the lower one
    let (surface, radius) = surface("lp_turbine_paper", true);
    let mut ring = vec![0.0; 4 * surface.nodes];
    for node in 0..surface.nodes {
        let (s, c) = (2.0 * surface.angle(node, 0.0)).sin_cos();
        ring[4 * node + 2] = -2e-3 * c;
        ring[4 * node + 3] = 2e-3 * 2.0 * s / 0.353;
        // inextensional: u' = -v
        ring[4 * node] = 1e-3 * s;
        ring[4 * node + 1] = 1e-3 * 2.0 * c / 0.353;
    }
    let mut detector = Detector::new(surface);
    for shift in [1e-9, -1e-9, 1e-7, -1e-7] {
        let place = detector.closest(&ring, [shift, 0.0]);
        assert!(place.angle.1 * shift > 0.0, "the minimum on the side of the shift: {place:?}");
        let gap = exact_gap(&surface, Some(&ring), radius, [shift, 0.0], place).value;
        assert!((gap - (8e-3 - 2e-3 - shift.abs())).abs() < 1e-12, "{gap}");
    }
}

#[test]
fn centred_rotor_has_finite_gaps_on_any_ring() {
    let mut random = Stream(3);
    for inner in [true, false] {
        let (surface, radius) = surface("lp_turbine_paper", inner);
        let mut detector = Detector::new(surface);
        for size in [0.0, 1e-9, 1e-3, 2e-2] {
            let ring = field(&surface, 0.353, size, 4, &mut random);
            for x in [[0.0, 0.0], [-0.0, 0.0], [1e-300, 0.0], [0.0, -1e-18]] {
                let place = detector.closest(&ring, x);
                let exact = exact_gap(&surface, Some(&ring), radius, x, place);
                let (distance, _) = brute_force(&surface, &ring, x);
                assert!((exact.value - (distance - radius)).abs() < 1e-13);
                let polar = polar_gap(&surface, Some(&ring), radius, x);
                for gap in [exact, polar] {
                    let numbers = [gap.value, gap.model_slope, gap.place.alpha, gap.place.xi];
                    assert!(numbers.iter().chain(&gap.normal).chain(&gap.rotor_gradient).all(|n| n.is_finite()));
                }
            }
        }
    }
}

#[test]
fn exact_gap_gradient_holds_at_the_minimum_as_the_place_moves() {
    // envelope theorem: the total derivative, with the minimum recomputed, equals the partial one
    let mut random = Stream(11);
    let (surface, radius) = surface("lp_turbine_paper", true);
    let mut detector = Detector::new(surface);
    let mut checked = 0;
    for _ in 0..200 {
        let ring = field(&surface, 0.353, 1e-3, 3, &mut random);
        let x = [8e-3 * random.next(), 8e-3 * random.next()];
        let place = detector.closest(&ring, x);
        let gap = exact_gap(&surface, Some(&ring), radius, x, place);
        let gradient = gap.place.cartesian(gap.rotor_gradient);
        let mut value = |x: [f64; 2]| {
            let place = detector.closest(&ring, x);
            (exact_gap(&surface, Some(&ring), radius, x, place).value, place.alpha)
        };
        let h = 1e-7;
        for axis in 0..2 {
            let (mut up, mut down) = (x, x);
            up[axis] += h;
            down[axis] -= h;
            let ((a, at_a), (b, at_b)) = (value(up), value(down));
            // excludes jumps to another minimum
            if (at_a - at_b).abs() < 0.01 {
                assert!((gradient[axis] - (a - b) / (2.0 * h)).abs() < 1e-6);
                checked += 1;
            }
        }
    }
    assert!(checked > 300, "{checked}");
}
