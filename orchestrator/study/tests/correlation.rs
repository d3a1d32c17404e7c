//! Correlated parameters.

use bladeoff_numerics::probability::{normal_quantile, normal_tails};
use bladeoff_study::correlation::{ACCURACY, Copula, CorrelationError, Pair, Strength};
use bladeoff_study::uncertain::{Distribution, Uncertain, Values, Written};

fn law(word: &str, keys: &[(&str, f64)]) -> Uncertain {
    let numbers = keys.iter().map(|(key, number)| ((*key).to_owned(), *number)).collect();
    Uncertain::new(Distribution::from_word(word).expect("sound"), &Written { numbers, ..Written::default() }, "")
        .expect("sound")
}

fn empirical(values: Vec<f64>) -> Uncertain {
    let texts = vec![("file".to_owned(), "a.csv".to_owned()), ("column".to_owned(), "b".to_owned())];
    let written = Written { values: Some(Values::Numbers(values)), texts, ..Written::default() };
    Uncertain::new(Distribution::Empirical, &written, "").expect("sound")
}

fn names(count: usize) -> Vec<String> {
    (0..count).map(|i| format!("x{i}")).collect()
}

fn pair(a: usize, b: usize, strength: Strength) -> Pair {
    Pair { between: [a, b], strength }
}

/// Correlation of the normal numbers of two parameters, from the second number after the copula for the inputs 1 and 0.
fn normal_of(laws: &[Uncertain; 2], strength: Strength) -> Result<f64, CorrelationError> {
    let copula = Copula::new(&names(2), laws, &[pair(0, 1, strength)]).map_err(|mut errors| errors.remove(0))?;
    let mut coordinates = [normal_tails(1.0), (0.5, 0.5)];
    copula.apply(&mut coordinates, &mut Vec::new());
    Ok(normal_quantile(coordinates[1].0, coordinates[1].1))
}

fn linear(laws: &[Uncertain; 2], rho: f64) -> f64 {
    normal_of(laws, Strength::Linear(rho)).expect("sound")
}

fn reference_law(text: &str) -> Uncertain {
    let words: Vec<&str> = text.split(' ').collect();
    let number = |place: usize| words[place].parse::<f64>().expect("sound");
    let cut = words.iter().position(|word| *word == "cut");
    // gamma and weibull have the scale 1
    let mut keys = match words[0] {
        "normal" => vec![("mean", number(1)), ("sd", number(2))],
        "uniform" => vec![("lower", number(1)), ("upper", number(2))],
        "exponential" => vec![("mean", number(1))],
        "gamma" | "weibull" => vec![("shape", number(1)), ("scale", 1.0)],
        "gumbel" => vec![("location", number(1)), ("scale", number(2))],
        "beta" => vec![("a", number(1)), ("b", number(2)), ("lower", number(3)), ("upper", number(4))],
        "lognormal" => vec![("median", 1.0), ("cv", libm::sqrt(libm::expm1(number(2) * number(2))))],
        "triangular" => vec![("lower", number(1)), ("mode", number(2)), ("upper", number(3))],
        other => panic!("{other}"),
    };
    if let Some(cut) = cut {
        keys.extend([("lower", number(cut + 1)), ("upper", number(cut + 2))]);
    }
    law(words[0], &keys)
}

#[test]
fn nataf_agrees_with_a_direct_quadrature_in_two_dimensions() {
    let mut worst = 0.0f64;
    let mut count = 0;
    for line in include_str!("reference/nataf.csv").lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(';').collect();
        let laws = [reference_law(cells[0]), reference_law(cells[1])];
        let (r, rho): (f64, f64) = (cells[2].parse().unwrap(), cells[3].parse().unwrap());
        let found = linear(&laws, rho);
        println!("{line}: {:e}", found - r);
        assert!((found - r).abs() < ACCURACY, "{line}: {found}");
        (worst, count) = (worst.max((found - r).abs()), count + 1);
    }
    println!("{count} cases, worst {worst:e}");
    assert_eq!(count, 50);
}

#[test]
fn nataf_agrees_with_closed_forms() {
    let normal = || law("normal", &[("mean", 5.0), ("sd", 0.1)]);
    let uniform = || law("uniform", &[("lower", -3.0), ("upper", 8.0)]);
    let lognormal = |sigma: f64| law("lognormal", &[("median", 3.0), ("cv", libm::sqrt(libm::expm1(sigma * sigma)))]);
    let mut worst = [0.0f64; 5];
    for r in [-0.999, -0.9, -0.5, -0.01, 0.0, 1e-6, 0.3, 0.75, 0.98, 0.999] {
        let mut check = |case: usize, laws: [Uncertain; 2], rho: f64| {
            let error = (linear(&laws, rho) - r).abs();
            worst[case] = worst[case].max(error);
            assert!(error < ACCURACY, "case {case}, r = {r}: {error:e}");
        };
        check(0, [normal(), normal()], r);
        check(1, [uniform(), uniform()], 6.0 / std::f64::consts::PI * libm::asin(0.5 * r));
        check(2, [normal(), uniform()], r * libm::sqrt(3.0 / std::f64::consts::PI));
        for sigma in [0.1, 1.0, 1.5] {
            check(3, [normal(), lognormal(sigma)], r * sigma / libm::sqrt(libm::expm1(sigma * sigma)));
        }
        for (s, t) in [(0.1, 0.1), (0.5, 1.0), (1.0, 1.0), (0.2, 1.5)] {
            let rho = libm::expm1(r * s * t) / libm::sqrt(libm::expm1(s * s) * libm::expm1(t * t));
            check(4, [lognormal(s), lognormal(t)], rho);
        }
    }
    println!(
        "normal {:e}, uniform {:e}, normal-uniform {:e}, normal-lognormal {:e}, lognormal {:e}",
        worst[0], worst[1], worst[2], worst[3], worst[4]
    );
}

#[test]
fn heavy_laws_reach_their_correlation_or_are_refused() {
    // sigma 3: cv of 90. The curve is flat for negative r: the correlation of the values is matched, r has fewer valid digits
    let heavy = || law("lognormal", &[("median", 1.0), ("cv", libm::sqrt(libm::expm1(9.0)))]);
    let rho_of = |r: f64| libm::expm1(9.0 * r) / libm::expm1(9.0);
    for r in [-0.2, 0.1, 0.5, 0.9, 0.99] {
        let found = linear(&[heavy(), heavy()], rho_of(r));
        println!("r = {r}: {:e}, correlation {:e}", found - r, rho_of(found) - rho_of(r));
        assert!((rho_of(found) - rho_of(r)).abs() < ACCURACY);
    }
    // almost a step, which the panels cannot resolve
    let step = law("beta", &[("a", 1e-3), ("b", 1e-3), ("lower", 0.0), ("upper", 1.0)]);
    let error = normal_of(&[step, heavy()], Strength::Linear(0.01)).unwrap_err();
    assert!(matches!(error, CorrelationError::Unresolved { .. }), "{error}");
    let absurd = law("lognormal", &[("median", 1.0), ("cv", 1e100)]);
    let error = normal_of(&[absurd, heavy()], Strength::Linear(0.1)).unwrap_err();
    assert!(matches!(error, CorrelationError::Unresolved { .. }), "{error}");
}

#[test]
fn what_the_laws_cannot_have_is_refused_with_what_they_can() {
    let lognormal = || law("lognormal", &[("median", 1.0), ("cv", libm::sqrt(libm::expm1(1.0)))]);
    // (e^-1 - 1)/(e - 1) = -1/e
    let error = normal_of(&[lognormal(), lognormal()], Strength::Linear(-0.37)).unwrap_err();
    let CorrelationError::Unreachable { low, high, .. } = &error else { panic!("{error}") };
    assert!((low + (-1f64).exp()).abs() < 1e-12 && (high - 1.0).abs() < 1e-12, "{low} {high}");
    assert_eq!(
        error.to_string(),
        "`linear` = -0.37: the distributions of x0 and x1 can have from -0.367879 to 1.000000; allowed: between these, or `rank`"
    );
    assert!(linear(&[lognormal(), lognormal()], -0.3678).abs() < 1.0);
    // exponential with itself: at least 1 - pi^2/6
    let exponential = || law("exponential", &[("mean", 2.0)]);
    let error = normal_of(&[exponential(), exponential()], Strength::Linear(-0.7)).unwrap_err();
    let CorrelationError::Unreachable { low, .. } = error else { panic!("{error}") };
    assert!((low - (1.0 - std::f64::consts::PI.powi(2) / 6.0)).abs() < 1e-12, "{low}");
}

#[test]
fn empirical_laws_reach_their_linear_correlation() {
    let sample = |seed: u64, count: u64| {
        let source = bladeoff_study::sampling::sequence::random::Source::new(seed, "test", 0);
        let value = |i| {
            let mut u = [0.0];
            source.fill(i, &mut u);
            libm::pow(-libm::log(u[0]), 1.3)
        };
        empirical((0..count).map(value).collect())
    };
    for (count, rho) in [(7, 0.5), (100, 0.9), (1000, -0.4), (30, -0.45)] {
        let laws = [sample(1, count), sample(2, count)];
        let r = linear(&laws, rho);
        let direct = by_quadrature(&laws, r);
        println!("{count} values, rho {rho}: r = {r}, off by {:e}", direct - rho);
        assert!((direct - rho).abs() < ACCURACY, "{direct}");
    }
    let r = linear(&[sample(1, 30_000), sample(2, 5)], 0.3);
    println!("30000 and 5 values, rho 0.3: r = {r}");
    // corners, and a correlation close to the largest possible one: computed or rejected, never wrong
    for rho in [0.9, 0.93, 0.95, 0.96] {
        let laws = [sample(1, 12), sample(2, 14)];
        match normal_of(&laws, Strength::Linear(rho)) {
            Ok(r) => println!("rho {rho}: r = {r}"),
            Err(error) => {
                println!("{error}");
                assert!(
                    matches!(error, CorrelationError::Unresolved { .. } | CorrelationError::Unreachable { .. }),
                    "{error}"
                );
            }
        }
    }
}

/// Correlation of two distributions by the joint density of both normal numbers, on panels that end at the corners of each distribution.
fn by_quadrature(laws: &[Uncertain; 2], r: f64) -> f64 {
    // Gauss-Legendre quadrature with five nodes
    const RULE: [(f64, f64); 5] = [
        (0.0, 128.0 / 225.0),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let at = |law: &Uncertain, z: f64| {
        let (p, q) = normal_tails(z);
        law.quantile(p, q)
    };
    let nodes = |law: &Uncertain| -> Vec<(f64, f64)> {
        let (mean, sd) = law.moments().expect("sound");
        let mut edges: Vec<f64> = (0..=180).map(|k| f64::from(k) * 0.1 - 9.0).collect();
        edges.extend(law.kinks().into_iter().map(|p| normal_quantile(p, 1.0 - p)));
        edges.sort_by(f64::total_cmp);
        let panel = |pair: &[f64]| {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            RULE.map(|(x, weight)| (middle + half * x, half * weight))
        };
        let all = edges.windows(2).flat_map(panel);
        all.map(|(z, weight)| (z, weight * (at(law, z) - mean) / sd)).collect()
    };
    let (first, second) = (nodes(&laws[0]), nodes(&laws[1]));
    let s = 1.0 - r * r;
    let mut sum = 0.0;
    for &(x, a) in &first {
        let inner: f64 = second.iter().map(|&(y, b)| b * (-(x * x - 2.0 * r * x * y + y * y) / (2.0 * s)).exp()).sum();
        sum += a * inner;
    }
    sum / (2.0 * std::f64::consts::PI * s.sqrt())
}

#[test]
fn rank_is_spearmans_of_any_continuous_laws() {
    let laws = [
        law("gamma", &[("shape", 0.5), ("scale", 1.0)]),
        law("beta", &[("a", 2.0), ("b", 0.5), ("lower", 0.0), ("upper", 1.0)]),
    ];
    let r = normal_of(&laws, Strength::Rank(0.6)).unwrap();
    assert!((r - 2.0 * (std::f64::consts::PI * 0.1).sin()).abs() < 1e-15);
    assert!((normal_of(&laws, Strength::Normal(-0.25)).unwrap() + 0.25).abs() < 1e-15);
}

#[test]
fn every_pair_that_cannot_be_is_named() {
    let words = Values::Words(["a", "b"].map(str::to_owned).to_vec());
    let list =
        Uncertain::new(Distribution::Discrete, &Written { values: Some(words), ..Written::default() }, "").unwrap();
    let laws = [
        law("normal", &[("mean", 0.0), ("sd", 1.0)]),
        list,
        law("periodic", &[("lower", 0.0), ("upper", 1.0)]),
        law("exponential", &[("mean", 1.0)]),
    ];
    let pairs = [
        pair(0, 0, Strength::Rank(0.1)),
        pair(0, 1, Strength::Rank(0.1)),
        pair(2, 0, Strength::Linear(0.1)),
        pair(0, 3, Strength::Rank(1.0)),
        pair(3, 0, Strength::Rank(0.5)),
        pair(1, 2, Strength::Normal(f64::NAN)),
        pair(1, 3, Strength::Normal(0.2)),
    ];
    let errors = Copula::new(&names(4), &laws, &pairs).unwrap_err();
    let shown: Vec<(usize, String)> = errors.iter().map(|error| (error.pair(), error.to_string())).collect();
    let expected = [
        (0, "`between` names x0 twice; allowed: two different parameters"),
        (
            1,
            "`rank` of x1, which is discrete; allowed: `normal`, the correlation of the normal numbers behind the values",
        ),
        (
            2,
            "`linear` of x2, which is periodic; allowed: `normal`, the correlation of the normal numbers behind the values",
        ),
        (3, "`rank` = 1; allowed: above -1 and below 1 (use [[derived]] for a parameter that another one determines)"),
        (4, "table 4 already gives the correlation of x3 and x0"),
        (
            5,
            "`normal` = NaN; allowed: above -1 and below 1 (use [[derived]] for a parameter that another one determines)",
        ),
    ];
    assert_eq!(shown.len(), expected.len());
    for ((pair, text), (number, expected)) in shown.iter().zip(expected) {
        assert_eq!((*pair, text.as_str()), (number, expected));
    }
    let list = &laws[1..2];
    assert!(Copula::new(&names(1), list, &[]).unwrap().is_independent());
}

#[test]
fn an_impossible_matrix_is_refused_with_one_that_is_possible() {
    let normal = || law("normal", &[("mean", 0.0), ("sd", 1.0)]);
    let exponential = || law("exponential", &[("mean", 1.0)]);
    let laws = [normal(), exponential(), exponential(), normal(), normal()];
    let kinds: [fn(f64) -> Strength; 3] = [Strength::Rank, Strength::Linear, Strength::Normal];
    for kind in kinds {
        // 0 and 2 alike, 2 and 3 alike, but 0 and 3 opposite; 4 is not part of the contradiction
        let pairs = [pair(0, 2, kind(0.8)), pair(2, 3, kind(0.8)), pair(3, 0, kind(-0.8)), pair(1, 4, kind(0.3))];
        let error = Copula::new(&names(5), &laws, &pairs).unwrap_err().remove(0);
        println!("{error}");
        let CorrelationError::Impossible { nearest, .. } = &error else { panic!("{error}") };
        let given: Vec<_> = nearest.iter().filter_map(|possible| Some((possible.pair?, possible.nearest))).collect();
        assert_eq!(given.len(), 4);
        let mut again = pairs;
        for (number, nearest) in given {
            again[number].strength = match again[number].strength {
                Strength::Rank(_) => Strength::Rank(nearest),
                Strength::Linear(_) => Strength::Linear(nearest),
                Strength::Normal(_) => Strength::Normal(nearest),
            };
        }
        assert!((again[3].strength.parts().1 - 0.3).abs() < 1e-4, "what is possible stays: {again:?}");
        assert!(
            again[..3].iter().zip(&pairs).all(|(new, old)| new.strength.parts().1.abs() < old.strength.parts().1.abs())
        );
        assert!(nearest.iter().all(|possible| possible.pair.is_some()), "{error}");
        Copula::new(&names(5), &laws, &again).expect("the nearest is possible");
    }
}

#[test]
fn the_nearest_of_many_is_possible_too() {
    let count = 24;
    let laws: Vec<Uncertain> = (0..count).map(|_| law("normal", &[("mean", 0.0), ("sd", 1.0)])).collect();
    let source = bladeoff_study::sampling::sequence::random::Source::new(5, "test", 0);
    let mut pairs = Vec::new();
    for i in 0..count {
        for j in 0..i {
            let mut u = [0.0];
            source.fill((i * count + j) as u64, &mut u);
            pairs.push(pair(i, j, Strength::Normal(1.6 * u[0] - 0.8)));
        }
    }
    let error = Copula::new(&names(count), &laws, &pairs).unwrap_err().remove(0);
    let CorrelationError::Impossible { nearest, .. } = &error else { panic!("{error}") };
    for possible in nearest {
        pairs[possible.pair.unwrap()].strength = Strength::Normal(possible.nearest);
    }
    Copula::new(&names(count), &laws, &pairs).expect("the nearest is possible");
    assert!(error.to_string().contains(" and 256 more"), "{error}");
}

#[test]
fn coordinates_that_no_pair_changes_keep_their_bits_and_tails_go_through() {
    let laws: Vec<Uncertain> = (0..4).map(|_| law("normal", &[("mean", 0.0), ("sd", 1.0)])).collect();
    let copula = Copula::new(&names(4), &laws, &[pair(3, 1, Strength::Normal(0.6))]).unwrap();
    let mut coordinates = [(0.3, 0.7), (1e-17, 1.0), (0.9, 0.1), (1.0, 1e-17)];
    let before = coordinates;
    copula.apply(&mut coordinates, &mut Vec::new());
    assert_eq!(coordinates[..3], before[..3]);
    // 0.6 (-x) + 0.8 x = 0.2 x
    let x = normal_quantile(1.0, 1e-17);
    let (p, q) = normal_tails(0.2 * x);
    assert!((coordinates[3].0 - p).abs() < 1e-15 && (coordinates[3].1 - q).abs() < 1e-15);
}
