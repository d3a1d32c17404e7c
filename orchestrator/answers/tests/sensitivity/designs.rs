//! Morris and Sobol indices against closed forms and published numbers.

use super::support::{
    DELTA, G, ISHIGAMI, figure, g_function, holds, ishigami, names, near, of_g, points, saltelli, sobol_points,
    trajectories, trajectory,
};
use bladeoff_answers::sensitivity::{Index, Indices, Moved, SensitivityError, morris, sobol};

/// First, total and second orders from SALib 1.6.0 on the same rows: Joe-Kuo points from index 0, N = 1024.
struct Reference {
    first: &'static [f64],
    total: &'static [f64],
    second: &'static [f64],
    /// Widths of its 95 % intervals of first and second order.
    widths: (&'static [f64], &'static [f64]),
}

const OF_ISHIGAMI: Reference = Reference {
    first: &[0.332955105353173, 0.441313938544067, 0.018578437929573],
    total: &[0.558179045711466, 0.443284584030348, 0.242149373354965],
    second: &[-4.955281413510093e-05, 0.2276071055378802, 0.004876551648890354],
    widths: (&[0.1214, 0.1047, 0.1082], &[0.1631, 0.2069, 0.1331]),
};

const OF_G: Reference = Reference {
    first: &[0.714166071875039, 0.175017476541313, 0.02259811089283, 0.00636568917061],
    total: &[0.786218250736382, 0.23620366216374, 0.034056124082858, 0.010269391058704],
    second: &[
        0.058875110735008,
        0.009485025682605,
        0.005577528786954,
        0.002034720282805,
        0.001455330058157,
        0.002243424717814,
    ],
    widths: (&[0.1468, 0.0818, 0.0341, 0.0149], &[0.2070, 0.1757, 0.1731, 0.1180, 0.1166, 0.0523]),
};

/// Estimates agree to 1e-11, and no interval of first or second order is wider than 1.15 times that of SALib, whatever constant is added.
#[test]
fn sobol_is_that_of_salib_on_the_same_rows_with_any_offset() {
    let functions: [(fn(&[f64]) -> f64, usize, &Reference); 2] = [(ishigami, 3, &OF_ISHIGAMI), (g_function, 4, &OF_G)];
    for (f, d, reference) in functions {
        // the mean is 0.9, 1.9 and 27 standard deviations of Ishigami's function from 0; 1.5, 6 and 130 of the g-function
        for offset in [0.0, 3.5, 100.0] {
            let rows = saltelli(|u| f(u) + offset, &sobol_points(1024, &vec![0; 2 * d]), true);
            let found = sobol(&names(d), &rows, true, 0.05).expect("indices");
            let no_wider = |index: Index, width: f64| {
                let found = index.high.zip(index.low).map(|(high, low)| high - low).expect("an interval");
                assert!(found < 1.15 * width, "{found}, SALib {width}, offset {offset}");
            };
            for i in 0..d {
                let (first, total) = (figure(&found, i, |of| of.first), figure(&found, i, |of| of.total));
                near(first, reference.first[i], 1e-11);
                near(total, reference.total[i], 1e-11);
                no_wider(first, reference.widths.0[i]);
            }
            assert_eq!(found.pairs.len(), reference.second.len());
            for (pair, (exact, width)) in found.pairs.iter().zip(reference.second.iter().zip(reference.widths.1)) {
                near(pair.second, *exact, 1e-11);
                no_wider(pair.second, *width);
            }
            assert!(found.notes.is_empty(), "{:?}", found.notes);
        }
    }
}

#[test]
fn sobol_holds_the_exact_indices_of_plain_points() {
    let rows = saltelli(ishigami, &sobol_points(1024, &[0; 6]), false);
    let found = sobol(&names(3), &rows, false, 0.05).expect("indices");
    assert_eq!((found.n, found.left_out, found.interval), (1024, 0, "bootstrap"));
    for (i, (first, total)) in [(0, ISHIGAMI[0]), (1, ISHIGAMI[1]), (2, ISHIGAMI[2])] {
        // SALib 1.6.0 on the same rows
        near(figure(&found, i, |of| of.first), [0.332955075179, 0.441313938544, 0.018578412959][i], 2e-12);
        near(figure(&found, i, |of| of.total), [0.558179045711, 0.443284584030, 0.242149373355][i], 2e-12);
        holds(figure(&found, i, |of| of.first), first);
        holds(figure(&found, i, |of| of.total), total);
    }
    assert!(found.pairs.is_empty() && found.notes.is_empty(), "{:?}", found.notes);
}

#[test]
fn sobol_comes_to_the_exact_indices() {
    let shift = [0x1234_5678, 0x9abc_def0, 0x0f1e_2d3c, 0x5a69_7887, 0x7766_5544, 0x0bad_cafe];
    let found =
        sobol(&names(3), &saltelli(ishigami, &sobol_points(1 << 15, &shift), true), true, 0.05).expect("indices");
    for (i, (first, total)) in ISHIGAMI.into_iter().enumerate() {
        near(figure(&found, i, |of| of.first), first, 4e-3);
        near(figure(&found, i, |of| of.total), total, 4e-3);
    }
    // only the first and the third parameter interact
    let second: Vec<f64> = found.pairs.iter().map(|pair| pair.second.estimate.expect("an estimate")).collect();
    assert_eq!(found.pairs[1].between, ["x0".to_owned(), "x2".to_owned()]);
    for (found, exact) in second.iter().zip([0.0, ISHIGAMI[0].1 - ISHIGAMI[0].0, 0.0]) {
        assert!((found - exact).abs() < 8e-3, "{second:?}");
    }
    // independent points, with a confidence level that twenty intervals hold together
    let found = sobol(&names(4), &saltelli(g_function, &points(5, 40_000, 8), true), true, 0.004).expect("indices");
    let mut pair = found.pairs.iter();
    for i in 0..4 {
        let (first, total, _) = of_g(i, 0);
        near(figure(&found, i, |of| of.first), first, 0.03);
        holds(figure(&found, i, |of| of.first), first);
        holds(figure(&found, i, |of| of.total), total);
        for j in i + 1..4 {
            let pair = pair.next().expect("a pair");
            assert_eq!(pair.between, [format!("x{i}"), format!("x{j}")]);
            holds(pair.second, of_g(i, j).2);
        }
    }
    assert!(pair.next().is_none() && G[0] == 0.0);
}

#[test]
fn a_linear_function_has_no_interaction() {
    let f = |u: &[f64]| 10.0 * u[0] - 5.0 * u[1] + 0.0 * u[2];
    let found = sobol(&names(3), &saltelli(f, &points(1, 20_000, 6), true), true, 0.05).expect("indices");
    for (i, exact) in [0.8, 0.2, 0.0].into_iter().enumerate() {
        near(figure(&found, i, |of| of.first), exact, 0.03);
        near(figure(&found, i, |of| of.total), exact, 0.03);
    }
    // the third parameter has no effect: exactly 0
    assert_eq!(figure(&found, 2, |of| of.total), Index { estimate: Some(0.0), low: Some(0.0), high: Some(0.0) });
    assert!(found.pairs.iter().all(|pair| pair.second.estimate.unwrap().abs() < 0.06));
    let (rows, moves) = trajectories(&f, 4, 25, 3);
    let found = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    for (i, slope) in [10.0f64, -5.0, 0.0].into_iter().enumerate() {
        near(figure(&found, i, |of| of.mu), slope, 1e-12);
        near(figure(&found, i, |of| of.mu_star), slope.abs(), 1e-12);
        near(figure(&found, i, |of| of.sigma), 0.0, 1e-12);
    }
}

/// Every start and every order once: exact values over all elementary effects of the grid.
#[test]
fn morris_of_all_trajectories_is_exact() {
    let (mut rows, mut moves) = (Vec::new(), Vec::new());
    for starts in 0..64 {
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            trajectory(&ishigami, &[starts % 4, starts / 4 % 4, starts / 16], &order, &mut rows, &mut moves);
        }
    }
    let found = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    let n = 384.0f64;
    assert_eq!(found.n, 384);
    for (i, mu_star, mu, sigma) in
        [(0, 7.7040541116, 7.7040541116, 6.2487961033), (1, 7.875, 0.0, 7.875), (2, 6.2487961033, 0.0, 8.8371321978)]
    {
        near(figure(&found, i, |of| of.mu_star), mu_star, 1e-9);
        near(figure(&found, i, |of| of.mu), mu, 1e-9);
        near(figure(&found, i, |of| of.sigma), sigma * (n / (n - 1.0)).sqrt(), 1e-9);
        holds(figure(&found, i, |of| of.mu), mu);
    }
    // every effect of the second parameter has the same magnitude
    let star = figure(&found, 1, |of| of.mu_star);
    assert!(star.high.unwrap() - star.low.unwrap() < 1e-12);
    holds(figure(&found, 0, |of| of.mu_star), 7.7040541116);
}

#[test]
fn a_small_scatter_beside_a_large_effect_is_not_lost() {
    let f = |u: &[f64]| 1e9 * u[0] + u[1] * u[1];
    let (rows, moves) = trajectories(&f, 9, 40, 2);
    let found = morris(&names(2), &rows, &moves, DELTA, 0.05).expect("effects");
    // only rounding errors of 1e9; the effects of the second parameter are u + delta/2 twice: 2/3 or 4/3
    near(figure(&found, 0, |of| of.sigma), 0.0, 1e-5);
    near(figure(&found, 1, |of| of.mu), 1.0, 0.2);
    near(figure(&found, 1, |of| of.sigma), 1.0 / 3.0, 0.1);
}

#[test]
fn what_has_no_scatter_has_no_interval() {
    let flat = sobol(&names(2), &saltelli(|_| 0.1, &points(1, 64, 4), true), true, 0.05).expect("indices");
    assert!(flat.of.iter().all(|(_, of)| of.first == Some(Index::default()) && of.total == Some(Index::default())));
    assert!(flat.interval == "none" && flat.notes[0].contains("does not vary"), "{:?}", flat.notes);
    // far from 0 the output varies, but not more than its rounding error
    let far = sobol(&names(2), &saltelli(|u| 1e15 + libm::sin(6.0 * u[0]), &points(1, 64, 4), true), true, 0.05);
    let far = far.expect("indices");
    assert_eq!(far.without, Some("the output varies less than the rounding error of its mean"));
    assert!(flat.without == Some("the output does not vary") && far.of[0].1.first == Some(Index::default()));
    let none = sobol(&names(2), &[], false, 0.05).expect("indices");
    assert!(none.n == 0 && none.notes[0].contains("no base point"), "{:?}", none.notes);
    let (rows, moves) = trajectories(&ishigami, 4, 9, 3);
    let few = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    let mu = figure(&few, 0, |of| of.mu_star);
    assert!(mu.estimate.is_some() && mu.low.is_none() && few.notes[0].contains("no interval: 9 trajectories"));
    let one = morris(&names(3), &rows[..4], &moves[..4], DELTA, 0.05).expect("effects");
    assert_eq!(figure(&one, 0, |of| of.sigma).estimate, None);
    let (rows, moves) = trajectories(&ishigami, 4, 20, 3);
    let sure = morris(&names(3), &rows, &moves, DELTA, 1e-3).expect("effects");
    let usual = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    let width =
        |of: &Indices| figure(of, 0, |of| of.mu_star).high.zip(figure(of, 0, |of| of.mu_star).low).map(|(h, l)| h - l);
    assert!(sure.interval == "bootstrap" && width(&sure) > width(&usual), "more resamples: {:?}", sure.notes);
    let surest = morris(&names(3), &rows, &moves, DELTA, 1e-6).expect("effects");
    assert!(surest.interval == "none" && surest.notes[0].contains("limits that rare"), "{:?}", surest.notes);
}

#[test]
fn rows_of_another_design_are_refused() {
    let (rows, mut moves) = trajectories(&ishigami, 4, 3, 3);
    assert_eq!(morris(&[], &rows, &moves, DELTA, 0.05), Err(SensitivityError::Parameters));
    assert_eq!(sobol(&[], &rows, false, 0.05), Err(SensitivityError::Parameters));
    let length = morris(&names(3), &rows[1..], &moves, DELTA, 0.05);
    assert!(matches!(length, Err(SensitivityError::Length { found: 12, rows: 11, .. })), "{length:?}");
    moves[6] = moves[5];
    let twice = morris(&names(3), &rows, &moves, DELTA, 0.05);
    assert_eq!(twice, Err(SensitivityError::Moves { block: 1, parameters: 3 }));
    moves[6] = Some(Moved { parameter: 7, up: true });
    assert!(morris(&names(3), &rows, &moves, DELTA, 0.05).is_err());
}

#[test]
fn indices_are_json_by_parameter() {
    let found = sobol(&names(3), &saltelli(ishigami, &points(1, 64, 6), false), false, 0.05).expect("indices");
    let json = serde_json::to_value(&found).expect("JSON");
    let first = &json["x1"]["first"];
    assert!(first["low"].as_f64() < first["estimate"].as_f64() && first["estimate"].as_f64() < first["high"].as_f64());
    let keys: Vec<&String> = json["x0"].as_object().expect("a map").keys().collect();
    assert_eq!(keys, ["first", "total"]);
    let (rows, moves) = trajectories(&ishigami, 4, 12, 3);
    let found = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    let json = serde_json::to_value(&found).expect("JSON");
    let mut keys: Vec<&String> = json["x0"].as_object().expect("a map").keys().collect();
    keys.sort();
    assert_eq!(keys, ["mu", "mu_star", "sigma"]);
    assert!(json["x2"]["mu_star"]["high"].is_number());
    assert_eq!(found, morris(&names(3), &rows, &moves, DELTA, 0.05).expect("the same"));
}
