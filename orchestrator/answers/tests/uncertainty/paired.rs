//! Limits of paired differences: coverage, and width compared with limits that ignore the pairing.
//!
//! The table in the documentation: `COVERAGE_STUDIES=1000 cargo test --release -p bladeoff -p bladeoff-answers --test answers paired -- --nocapture`.

use bladeoff_answers::estimate::difference::{of_probabilities, of_quantiles, of_two};
use bladeoff_answers::estimate::figures::Figures;
use bladeoff_answers::estimate::known::{Truths, Values};
use bladeoff_answers::estimate::quantile::quantile;
use bladeoff_answers::estimate::reach::{Arms, reach};
use bladeoff_answers::estimate::scheme::Scheme;
use bladeoff_answers::estimate::truth::Truth;
use bladeoff_numerics::probability::normal_quantile;
use bladeoff_system::random::{SplitMix, finaliser};

fn studies() -> u64 {
    std::env::var("COVERAGE_STUDIES").map_or(100, |word| word.parse().expect("a number of studies"))
}

/// Three independent normal numbers to a pair of values.
type Pair = fn([f64; 3]) -> (f64, f64);

/// Name, pair, exact quantiles of both by the normal quantile.
type Case = (&'static str, Pair, fn(f64) -> f64);

const CASES: [Case; 7] = [
    ("shifted by a constant", |z| (z[0], z[0] - 1.0), |_| 1.0),
    ("correlation 0.99", |z| (z[0], 0.99 * z[0] + 0.1411 * z[1]), |_| 0.0),
    ("correlation 0.9, scales 1 and 1.5", |z| (z[0], 1.5 * (0.9 * z[0] + 0.43589 * z[1])), |q| -0.5 * q),
    ("correlation 0.9, lognormal", |z| (z[0].exp(), (0.9 * z[0] + 0.43589 * z[1]).exp()), |_| 0.0),
    ("independent", |z| (z[0], z[1]), |_| 0.0),
    ("independent, scales 1 and 4", |z| (z[0], 4.0 * z[1]), |q| -3.0 * q),
    ("correlation -0.9", |z| (z[0], -0.9 * z[0] + 0.43589 * z[1]), |_| 0.0),
];

fn pairs(pair: Pair, seed: u64, count: usize) -> (Values, Values) {
    let mut random = SplitMix(finaliser(finaliser(seed) ^ 0x9a17));
    let (mut a, mut b) = (Values::default(), Values::default());
    for point in 0..count as u32 {
        let z = std::array::from_fn(|_| {
            let u = random.unit().max(1e-12);
            normal_quantile(u, 1.0 - u)
        });
        let values = pair(z);
        for (of, value) in [(&mut a, values.0), (&mut b, values.1)] {
            of.point.push(point);
            of.low.push(value);
            of.high.push(value);
        }
    }
    (a, b)
}

fn width(found: &Figures) -> f64 {
    found.high.zip(found.low).map(|(high, low)| high - low).expect("limits")
}

/// Independent points, and 16 replicates of independent points.
#[test]
fn limits_of_paired_quantiles_hold_and_are_narrow() {
    let repeats = studies();
    for scheme in [Scheme::Independent, Scheme::Replicated(16)] {
        for (n, u) in [(64, 0.5), (1024, 0.5), (1024, 0.95)] {
            for (name, pair, exact) in CASES {
                let exact = exact(normal_quantile(u, 1.0 - u));
                let (mut held, mut narrow, mut wide) = (0u64, 0.0, 0.0);
                for repeat in 0..repeats {
                    let (a, b) = pairs(pair, 1 + repeat, n);
                    let part = |point: usize| if scheme == Scheme::Independent { 0 } else { point % 16 };
                    let found = of_quantiles(&a, &b, u, &scheme, part, 0.05);
                    let plain = |of: &Values| quantile(of, u, &scheme, part, 0.025);
                    let (low, high) = (found.low.expect("a limit"), found.high.expect("a limit"));
                    held += u64::from(low <= exact + 1e-9 && exact <= high + 1e-9);
                    narrow += width(&found);
                    wide += width(&of_two(&plain(&a), &plain(&b)));
                }
                let share = held as f64 / repeats as f64;
                println!(
                    "{scheme:?}, {n} points, quantile {u}, {name}: {held}/{repeats}, {:.1} times narrower",
                    wide / narrow
                );
                let least = 0.93 - 3.0 * (0.93 * 0.07 / repeats as f64).sqrt();
                assert!(share >= least, "{n} {u} {name}: {share}");
                if name == "correlation 0.99" && n == 1024 {
                    assert!(wide > 3.0 * narrow, "{n} {u}: {wide} {narrow}");
                }
            }
        }
    }
}

/// Limits for `n` points, of which `only_a` satisfy only the first of two conditions and `only_b` only the second.
fn counted(only_a: usize, only_b: usize, n: usize) -> (f64, f64, Figures) {
    let truths = |from: usize, count: usize| {
        let of = (0..n).map(|point| if (from..from + count).contains(&point) { Truth::Yes } else { Truth::No });
        Truths { of: of.collect(), ..Truths::default() }
    };
    let found = of_probabilities(&truths(0, only_a), &truths(only_a, only_b), &Scheme::Independent, |_| 0, 0.05);
    (found.low.expect("a limit"), found.high.expect("a limit"), found)
}

/// The coverage of 95 % limits of a difference of probabilities, computed over all outcomes, is never below 95 %.
#[test]
fn limits_of_paired_probabilities_hold_over_all_outcomes() {
    for n in [20usize, 50] {
        let factorial: Vec<f64> = (0..=n)
            .scan(0.0, |sum, k| {
                *sum += if k > 0 { (k as f64).ln() } else { 0.0 };
                Some(*sum)
            })
            .collect();
        let mut outcomes = Vec::new();
        for a in 0..=n {
            for b in 0..=n - a {
                let (low, high, _) = counted(a, b, n);
                outcomes.push((a, b, low, high));
            }
        }
        let shares: Vec<f64> = (0..=24).map(|k| 0.02 * 50f64.powf(f64::from(k) / 25.0)).chain([0.0, 0.97]).collect();
        // also cases in which almost every point differs: p + q near 1
        let sums = [1.0, 1.0 - 0.2 / n as f64, 1.0 - 1.0 / n as f64, 1.0 - 3.0 / n as f64];
        let mut least = (1.0, 0.0, 0.0);
        for &p in &shares {
            let others = shares.iter().copied().chain(sums.map(|sum| sum - p));
            for q in others.filter(|q| *q >= 0.0 && p + *q <= 1.0) {
                let log = |count: usize, p: f64| if count == 0 { 0.0 } else { count as f64 * p.ln() };
                let chance = |a: usize, b: usize| {
                    let rest = n - a - b;
                    let ways = factorial[n] - factorial[a] - factorial[b] - factorial[rest];
                    (ways + log(a, p) + log(b, q) + log(rest, (1.0 - p - q).max(0.0))).exp()
                };
                let holds =
                    |(_, _, low, high): &&(usize, usize, f64, f64)| *low <= p - q + 1e-12 && p - q <= *high + 1e-12;
                let held: f64 = outcomes.iter().filter(holds).map(|(a, b, ..)| chance(*a, *b)).sum();
                if held < least.0 {
                    least = (held, p, q);
                }
            }
        }
        println!("{n} points: at least {:.4}, of {:.3} and {:.3}", least.0, least.1, least.2);
        assert!(least.0 >= 0.95, "{n}: {least:?}");
    }
}

#[test]
fn limits_of_paired_probabilities_are_near_to_the_asymptotic_ones() {
    // 200 of 2000 points differ: earlier limits were 1.2 and 1.6 times as wide
    for (only_a, only_b) in [(100, 100), (200, 0)] {
        let (low, high, found) = counted(only_a, only_b, 2000);
        let (p, q) = (only_a as f64 / 2000.0, only_b as f64 / 2000.0);
        let asymptotic = 2.0 * 1.959964 * ((p + q - (p - q) * (p - q)) / 2000.0).sqrt();
        assert!((high - low) < 1.1 * asymptotic, "{low} {high} {asymptotic}");
        assert_eq!(found.estimate, Some(p - q));
    }
    // no point differs: limits of 3.7 points on both sides, as without an event
    let (low, high, _) = counted(0, 0, 1000);
    assert!(low == -high && high > 0.0036 && high < 0.0053, "{low} {high}");
}

#[test]
fn arms_of_correlated_estimates_are_put_together() {
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
    let (a, b) = (Arms { below: 3.0, above: 5.0 }, Arms { below: 2.0, above: 4.0 });
    let independent = reach(a, b, 0.0);
    near(independent.below, 5.0);
    near(independent.above, 29f64.sqrt());
    let opposed = reach(a, b, -1.0);
    near(opposed.below, 7.0);
    near(opposed.above, 7.0);
    // fully correlated: downwards 3 and 2, upwards 5 and 4
    let alike = reach(a, b, 1.0);
    near(alike.below, 1.0);
    near(alike.above, 1.0);
    let same = reach(a, a, 1.0);
    near(same.below + same.above, 0.0);
    let open = Arms { below: 3.0, above: f64::INFINITY };
    assert!(reach(a, open, 0.5).below.is_infinite() && reach(open, b, 0.5).below.is_finite());
}
