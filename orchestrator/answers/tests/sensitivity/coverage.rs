//! Coverage of the intervals, over repeated small studies with known indices.

use super::support::{
    DELTA, ISHIGAMI, figure, g_function, ishigami, names, nested, of_g, points, saltelli, sobol_points, trajectories,
};
use bladeoff_answers::sensitivity::{
    Given, Index, Indices, Input, OfParameter, Parts, Similar, dependence, given_data, morris, sobol,
};
use bladeoff_numerics::probability::normal_quantile;
use bladeoff_system::random::finaliser;
use std::f64::consts::PI;

fn studies() -> Option<u64> {
    std::env::var("COVERAGE_STUDIES").ok().map(|word| word.parse().expect("a number of studies"))
}

/// Exact value of an index: name, parameter, value, and access to the index.
type Exact<'a> = (&'a str, usize, f64, fn(&OfParameter) -> Option<Index>);

/// For each index, the number of studies whose interval contains the exact value, and the mean width; prints a line of the table each.
fn count(name: &str, make: impl Fn(u64) -> Indices, exact: &[Exact<'_>]) -> Vec<(String, f64)> {
    let repeats = studies().unwrap_or(60);
    let mut held = vec![(0u32, 0.0); exact.len()];
    for repeat in 0..repeats {
        let found = make(1 + repeat);
        for ((held, width), &(_, parameter, exact, of)) in held.iter_mut().zip(exact) {
            let index = figure(&found, parameter, of);
            let (low, high) = (index.low.expect("a lower limit"), index.high.expect("an upper limit"));
            *held += u32::from(low <= exact && exact <= high);
            *width += (high - low) / repeats as f64;
        }
    }
    let line = |((held, width), (what, parameter, ..)): (&(u32, f64), &Exact<'_>)| {
        let name = format!("{name}: {what} of x{parameter}");
        println!("{name:<52} {held:>5}/{repeats} width {width:.4}");
        (name, f64::from(*held) / repeats as f64)
    };
    held.iter().zip(exact).map(line).collect()
}

/// Asserts a coverage of at least this share, less three standard deviations for this number of studies.
#[track_caller]
fn at_least(part: f64, lines: &[(String, f64)]) {
    let repeats = studies().unwrap_or(60) as f64;
    let least = part - 3.0 * (part * (1.0 - part) / repeats).sqrt();
    for (name, held) in lines {
        assert!(*held >= least, "{name}: {held}, at least {least}");
    }
}

fn both(i: usize, first: f64, total: f64) -> [Exact<'static>; 2] {
    [("first", i, first, |of| of.first), ("total", i, total, |of| of.total)]
}

#[test]
fn coverage_of_sobol_indices() {
    let exact: Vec<Exact<'_>> = (0..3).flat_map(|i| both(i, ISHIGAMI[i].0, ISHIGAMI[i].1)).collect();
    for base in [64, 256, 1024] {
        let independent = |seed: u64| {
            sobol(&names(3), &saltelli(ishigami, &points(seed, base, 6), false), false, 0.05).expect("indices")
        };
        at_least(
            if base < 256 { 0.88 } else { 0.91 },
            &count(&format!("{base} independent base points"), independent, &exact),
        );
    }
    let sequence = |seed: u64| {
        let shift: Vec<u64> = points(seed, 1, 6)[0].iter().map(|u| (u * 4294967296.0) as u64).collect();
        let base = sobol_points(256, &shift);
        sobol(&names(3), &saltelli(ishigami, &base, false), false, 0.05).expect("indices")
    };
    at_least(0.98, &count("256 base points of a sequence", sequence, &exact));
    let exact: Vec<Exact<'_>> = (0..4).flat_map(|i| both(i, of_g(i, 0).0, of_g(i, 0).1)).collect();
    let of_g = |seed: u64| {
        sobol(&names(4), &saltelli(g_function, &points(seed, 256, 8), false), false, 0.05).expect("indices")
    };
    at_least(0.93, &count("g-function, 256 independent base points", of_g, &exact));
}

/// Lognormal outputs exp(sum s_i z_i) with heavy tails, which a note reports. `COVERAGE_STUDIES=400` gives the numbers in the documentation.
#[test]
fn coverage_of_heavy_tails() {
    let lognormal = |s: [f64; 3]| {
        move |u: &[f64]| u.iter().zip(s).map(|(u, s)| s * normal_quantile(*u, 1.0 - u)).sum::<f64>().exp()
    };
    let exact = |s: [f64; 3]| -> Vec<Exact<'static>> {
        let each = s.map(|s| (s * s).exp());
        let all: f64 = each.iter().product();
        (0..3)
            .flat_map(|i| both(i, (each[i] - 1.0) / (all - 1.0), (each[i] - 1.0) * all / each[i] / (all - 1.0)))
            .collect()
    };
    let noted = |indices: &Indices| {
        indices.notes.iter().any(|note| note.contains("of the variance: with such tails, 95 % intervals"))
    };
    for (s, least) in
        [([0.3, 0.3, 0.3], 0.88), ([0.8, 0.8, 0.8], 0.82), ([1.2, 1.2, 1.2], 0.72), ([1.5, 0.8, 0.3], 0.72)]
    {
        for base in [64, 256, 1024] {
            let heavy = std::cell::Cell::new(0u64);
            let make = |seed: u64| {
                let rows = saltelli(lognormal(s), &points(seed, base, 6), false);
                let found = sobol(&names(3), &rows, false, 0.05).expect("indices");
                heavy.set(heavy.get() + u64::from(noted(&found)));
                found
            };
            at_least(least, &count(&format!("exp of {s:?}, {base} base points"), make, &exact(s)));
            let (heavy, repeats) = (heavy.get(), studies().unwrap_or(60));
            println!("exp of {s:?}, {base} base points: a note in {heavy} of {repeats}");
            match s[0] {
                0.3 if base >= 256 => assert!(20 * heavy <= repeats, "{heavy} of {repeats}"),
                1.2 => assert!(2 * heavy > repeats, "{heavy} of {repeats}"),
                _ => {}
            }
        }
    }
}

#[test]
fn coverage_of_elementary_effects() {
    let of = [(7.7040541116, 6.2487961033), (7.875, 7.875), (6.2487961033, 8.8371321978)];
    let each = |(i, (star, sigma)): (usize, &(f64, f64))| -> [Exact<'static>; 2] {
        [("mu*", i, *star, |of| of.mu_star), ("sigma", i, *sigma, |of| of.sigma)]
    };
    // every effect of x1 has the same magnitude, so its interval has no width
    let all = of.iter().enumerate().flat_map(each);
    let exact: Vec<Exact<'_>> = all.filter(|(what, i, ..)| (*what, *i) != ("mu*", 1)).collect();
    for (count_of, least) in [(10, 0.86), (20, 0.9), (50, 0.92), (200, 0.93)] {
        let make = |seed: u64| {
            let (rows, moves) = trajectories(&ishigami, seed, count_of, 3);
            morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects")
        };
        at_least(least, &count(&format!("{count_of} trajectories"), make, &exact));
    }
}

#[test]
fn coverage_of_what_needs_no_design() {
    let table = |seed: u64, rows: usize, f: &dyn Fn(&[f64]) -> f64| {
        let base = points(seed, rows, 4);
        let columns: Vec<Vec<f64>> = (0..4).map(|i| base.iter().map(|u| u[i]).collect()).collect();
        let output: Vec<Option<f64>> = base.iter().map(|u| Some(f(u))).collect();
        let input = |(name, values)| Input { name, values, has_words: false };
        let inputs = names(3).into_iter().zip(columns.iter().map(Vec::as_slice)).map(input).collect();
        given_data(&Given { inputs, output: &output, parts: Parts::Independent }, 0.05).expect("figures")
    };
    // a sum of normal numbers and noise: Spearman is 6/pi asin(rho/2), and so is the regression of independent ranks
    let slopes = [1.0, 0.6, 0.2, 0.5];
    let length = slopes.iter().map(|c| c * c).sum::<f64>().sqrt();
    let linear = |u: &[f64]| u.iter().zip(slopes).map(|(u, c)| c * normal_quantile(*u, 1.0 - u)).sum();
    let rank = |i: usize| 6.0 / PI * (0.5 * slopes[i] / length).asin();
    let each = |i: usize| -> [Exact<'static>; 2] {
        [("Spearman", i, rank(i), |of| of.spearman), ("regression", i, rank(i), |of| of.rank_regression)]
    };
    let exact: Vec<Exact<'_>> = (0..3).flat_map(each).collect();
    for rows in [64, 512] {
        at_least(0.92, &count(&format!("{rows} rows"), |seed| table(seed, rows, &linear), &exact));
    }
    let first = |i: usize| -> Exact<'static> { ("first order by ranks", i, ISHIGAMI[i].0, |of| of.first) };
    let exact: Vec<Exact<'_>> = (0..3).map(first).collect();
    for (rows, least) in [(256, 0.87), (1024, 0.92)] {
        at_least(least, &count(&format!("{rows} rows"), |seed| table(seed, rows, &|u| ishigami(&u[..3])), &exact));
    }
}

/// Sixteen scrambled copies of one sequence: neighbours in a column belong to different copies, so first orders are not biased.
#[test]
fn coverage_of_first_orders_from_replicates_of_a_sequence() {
    let table = |seed: u64, each: usize| {
        let plain = sobol_points(each, &[0; 6]);
        let scrambled = |replicate: u64| {
            let key = |i: u64| finaliser(finaliser(977 * seed + replicate) ^ i);
            let point = move |point: &Vec<f64>| (0..3).map(|i| nested(point[i], key(i as u64))).collect::<Vec<f64>>();
            plain.iter().map(point).collect::<Vec<_>>()
        };
        let base: Vec<Vec<f64>> = (0..16).flat_map(scrambled).collect();
        let replicate: Vec<u32> = (0..16 * each).map(|row| (row / each) as u32).collect();
        let columns: Vec<Vec<f64>> = (0..3).map(|i| base.iter().map(|u| u[i]).collect()).collect();
        let output: Vec<Option<f64>> = base.iter().map(|u| Some(ishigami(u))).collect();
        let input = |(name, values)| Input { name, values, has_words: false };
        let inputs = names(3).into_iter().zip(columns.iter().map(Vec::as_slice)).map(input).collect();
        given_data(&Given { inputs, output: &output, parts: Parts::Replicates(&replicate, 16) }, 0.05).expect("figures")
    };
    let first = |i: usize| -> Exact<'static> { ("first order by ranks", i, ISHIGAMI[i].0, |of| of.first) };
    let exact: Vec<Exact<'_>> = (0..3).map(first).collect();
    for each in [16, 64, 128] {
        at_least(0.94, &count(&format!("16 replicates of {each}"), |seed| table(seed, each), &exact));
    }
}

#[test]
fn coverage_of_the_level_of_hsic() {
    let repeats = 10 * studies().unwrap_or(40);
    let mut below = [0u32; 3];
    for repeat in 0..repeats {
        let base = points(1000 + repeat, 60, 4);
        let column = |i: usize| base.iter().map(|u| u[i]).collect::<Vec<f64>>();
        let words: Vec<f64> = column(1).iter().map(|u| (3.0 * u).floor()).collect();
        let y: Vec<f64> = base.iter().map(|u| normal_quantile(u[2], 1.0 - u[2])).collect();
        let with: Vec<f64> = y.iter().zip(column(3)).map(|(y, u)| y + 2.0 * (6.0 * u).sin()).collect();
        let p_value = |x: &[f64], similar, y: &[f64]| dependence(x, similar, y).expect("a dependence").p_value;
        let found = [
            p_value(&column(0), Similar::Near, &y),
            p_value(&words, Similar::Same, &y),
            p_value(&column(3), Similar::Near, &with),
        ];
        below.iter_mut().zip(found).for_each(|(count, p)| *count += u32::from(p < 0.05));
    }
    println!("p below 0.05 of {repeats}: without dependence {} and {}, with one {}", below[0], below[1], below[2]);
    let n = repeats as f64;
    // documented in hsic.rs: 4 to 7 % at a level of 5 %
    let scatter = |share: f64| 3.0 * (share * (1.0 - share) * n).sqrt();
    let within = 0.04 * n - scatter(0.04)..=0.07 * n + scatter(0.07);
    assert!(below[..2].iter().all(|count| within.contains(&f64::from(*count))), "{below:?}");
    assert!(f64::from(below[2]) > 0.8 * n, "{below:?}");
}
