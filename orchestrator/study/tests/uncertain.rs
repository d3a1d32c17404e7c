//! Distributions of single parameters.

use bladeoff_model::machine::Range;
use bladeoff_study::uncertain::{Distribution, Uncertain, UncertainError, Values, Written};
use proptest::prelude::*;

fn written(keys: &[(&str, f64)]) -> Written {
    Written { numbers: keys.iter().map(|(key, number)| ((*key).to_owned(), *number)).collect(), ..Written::default() }
}

fn law(word: &str, keys: &[(&str, f64)]) -> Uncertain {
    Uncertain::new(Distribution::from_word(word).expect("sound"), &written(keys), "").expect("sound")
}

fn refused(word: &str, written: &Written) -> Vec<(String, String)> {
    let errors = Uncertain::new(Distribution::from_word(word).expect("sound"), written, "m").expect_err("mistakes");
    errors.iter().map(|error: &UncertainError| (error.key().to_owned(), error.to_string())).collect()
}

fn keys_refused(word: &str, keys: &[(&str, f64)]) -> Vec<String> {
    refused(word, &written(keys)).into_iter().map(|(key, _)| key).collect()
}

fn empirical(values: &[f64], keys: &[(&str, f64)]) -> Result<Uncertain, Vec<UncertainError>> {
    let texts = vec![("file".to_owned(), "gaps.csv".to_owned()), ("column".to_owned(), "gap".to_owned())];
    let values = Some(Values::Numbers(values.to_vec()));
    Uncertain::new(Distribution::Empirical, &Written { values, texts, ..written(keys) }, "")
}

fn discrete(values: Values, weights: Option<&[f64]>) -> (Result<Uncertain, Vec<UncertainError>>, Written) {
    let written = Written { values: Some(values), weights: weights.map(<[f64]>::to_vec), ..Written::default() };
    (Uncertain::new(Distribution::Discrete, &written, "m"), written)
}

#[test]
fn quantiles_are_those_of_the_reference_in_both_tails() {
    let text = include_str!("../../../core/numerics/tests/reference/quantiles.csv");
    let (mut worst, mut count) = (0.0f64, 0);
    for line in text.lines().filter(|line| !line.starts_with('#') && !line.starts_with("dist")) {
        let cells: Vec<&str> = line.split(';').collect();
        let a: Vec<f64> = cells[1].split(' ').map(|x| x.parse().unwrap()).collect();
        let (p, want): (f64, f64) = (cells[2].parse().unwrap(), cells[3].parse().unwrap());
        let law = match cells[0] {
            "normal" => law("normal", &[("mean", a[0]), ("sd", a[1])]),
            "lognormal" => {
                let cv = libm::sqrt(libm::expm1(a[1] * a[1]));
                law("lognormal", &[("median", libm::exp(a[0])), ("cv", cv)])
            }
            "uniform" => law("uniform", &[("lower", a[0]), ("upper", a[1])]),
            "triangular" => law("triangular", &[("lower", a[0]), ("mode", a[2]), ("upper", a[1])]),
            "weibull" => law("weibull", &[("shape", a[0]), ("scale", a[1])]),
            "gumbel" => law("gumbel", &[("location", a[0]), ("scale", a[1])]),
            "exponential" => law("exponential", &[("mean", 1.0 / a[0])]),
            "gamma" => law("gamma", &[("shape", a[0]), ("scale", 1.0)]),
            "beta" => law("beta", &[("a", a[0]), ("b", a[1]), ("lower", 0.0), ("upper", 1.0)]),
            other => panic!("{other}"),
        };
        let got = law.quantile(p, 1.0 - p);
        let error = if want == 0.0 { got.abs() } else { ((got - want) / want).abs() };
        // the keys of a lognormal distribution cost a rounding of ln median and sigma, times the 37 standard deviations of 1e-300
        let allowed = if cells[0] == "lognormal" { 4e-13 } else { 1e-12 };
        assert!(error < allowed, "{line}: {got:e}, {error:e}");
        (worst, count) = (worst.max(error), count + 1);
    }
    println!("{count} quantiles, worst relative error {worst:e}");
    assert!(count > 100);
}

#[test]
fn moments_after_truncation_are_those_of_the_reference() {
    let mut worst = 0.0f64;
    for line in include_str!("reference/moments.csv").lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(';').collect();
        let keys: Vec<(&str, f64)> = cells[1]
            .split(' ')
            .map(|key| key.split_once('=').unwrap())
            .map(|(key, x)| (key, x.parse().unwrap()))
            .collect();
        let (mean, sd) = law(cells[0], &keys).moments().unwrap();
        let errors = [mean / cells[2].parse::<f64>().unwrap() - 1.0, sd / cells[3].parse::<f64>().unwrap() - 1.0];
        println!("{} {:e} {:e}", cells[0], errors[0], errors[1]);
        worst = errors.iter().fold(worst, |worst, error| worst.max(error.abs()));
        assert!(errors.iter().all(|error| error.abs() < 1e-9), "{line}: {mean} {sd}");
    }
    println!("worst {worst:e}");
}

#[test]
fn moments_without_truncation_agree_with_their_quadrature() {
    // truncated far outside, the same distributions use quadrature
    for (word, keys, far) in [
        ("normal", vec![("mean", 3.0), ("sd", 2.0)], ("upper", 60.0)),
        ("lognormal", vec![("mean", 3.0), ("sd", 2.0)], ("upper", 1e9)),
        ("gamma", vec![("shape", 2.5), ("scale", 3.0)], ("upper", 1e4)),
        ("gumbel", vec![("location", 1.0), ("scale", 2.0)], ("upper", 1e3)),
        ("exponential", vec![("mean", 2.0)], ("upper", 1e3)),
    ] {
        let exact = law(word, &keys).moments().unwrap();
        let mut cut = keys.clone();
        cut.push(far);
        let summed = law(word, &cut).moments().unwrap();
        assert!(
            (exact.0 / summed.0 - 1.0).abs() < 1e-10 && (exact.1 / summed.1 - 1.0).abs() < 1e-10,
            "{word} {exact:?} {summed:?}"
        );
    }
    // far tails: the squares of a Weibull distribution of this shape are dominated by 1 - 1e-29, those of the lognormal by 1 - 1e-22
    let shape = 0.03;
    let (mean, sd) = law("weibull", &[("shape", shape), ("scale", 1.0)]).moments().unwrap();
    let (first, second) = (libm::lgamma(1.0 + 1.0 / shape), libm::lgamma(1.0 + 2.0 / shape));
    let exact = first + 0.5 * (second - 2.0 * first).exp_m1().ln();
    assert!((mean.ln() - first).abs() < 1e-11 && (sd.ln() - exact).abs() < 1e-11, "{mean} {sd}");
    let keys = [("median", 1.0), ("cv", 1e5)];
    let exact = law("lognormal", &keys).moments().unwrap();
    let summed = law("lognormal", &[keys[0], keys[1], ("upper", 1e40)]).moments().unwrap();
    assert!(
        (exact.0 / summed.0 - 1.0).abs() < 1e-10 && (exact.1 / summed.1 - 1.0).abs() < 1e-10,
        "{exact:?} {summed:?}"
    );
    let nearly_two = law("beta", &[("a", 1e-3), ("b", 3e-3), ("lower", 0.0), ("upper", 1.0)]).moments().unwrap();
    assert!((nearly_two.0 - 0.25).abs() < 1e-15 && (nearly_two.1 - (0.1875f64 / 1.004).sqrt()).abs() < 1e-14);
}

#[test]
fn four_ways_to_write_a_lognormal_law_are_one_law() {
    let (mean, cv) = (2.0, 0.3f64);
    let median = mean / (1.0 + cv * cv).sqrt();
    let laws = [
        ("mean", mean, "sd", cv * mean),
        ("mean", mean, "cv", cv),
        ("median", median, "cv", cv),
        ("median", median, "sd", cv * mean),
    ];
    for (place, spot, width, number) in laws {
        let law = law("lognormal", &[(place, spot), (width, number)]);
        let (found, sd) = law.moments().unwrap();
        assert!((found - mean).abs() < 1e-14 && (sd - 0.6).abs() < 1e-14, "{place} {width}: {found} {sd}");
        assert!((law.quantile(0.5, 0.5) / median - 1.0).abs() < 1e-15);
    }
    assert_eq!(law("normal", &[("median", -2.0), ("cv", 0.25)]).moments(), Some((-2.0, 0.5)));
}

#[test]
fn a_sentence_says_what_was_understood() {
    let says = |word: &str, keys: &[(&str, f64)], unit: &str| {
        let written = written(keys);
        Uncertain::new(Distribution::from_word(word).unwrap(), &written, unit).unwrap().sentence(&written, unit)
    };
    assert_eq!(
        says("normal", &[("sd", 1e-4), ("mean", 1e-3), ("lower", 7e-4), ("upper", 1.3e-3)], "m"),
        "normal, mean 1 mm, sd 0.1 mm, cut at 0.7 mm and 1.3 mm: mean 1 mm, sd 98.66 um"
    );
    assert_eq!(
        says("normal", &[("mean", 0.0), ("sd", 1.0), ("upper", 60.0)], "N"),
        "normal, mean 0 N, sd 1 N, cut above 60 N: mean 0 N, sd 1 N"
    );
    assert_eq!(
        says("beta", &[("a", 2.0), ("b", 2.0), ("lower", 0.1), ("upper", 0.3)], ""),
        "beta, a 2, b 2, lower 0.1, upper 0.3: mean 0.2, sd 0.04472"
    );
    let turn = 2.0 * std::f64::consts::PI;
    assert_eq!(
        says("periodic", &[("lower", 0.0), ("upper", turn)], "rad"),
        "periodic, lower 0 deg, upper 360 deg: uniform, both ends are the same"
    );
    let (law, written) = discrete(Values::Numbers(vec![2e-3, 1e-3]), Some(&[1.0, 3.0]));
    assert_eq!(law.unwrap().sentence(&written, "m"), "discrete, 1 mm (75 %), 2 mm (25 %): mean 1.25 mm, sd 0.433 mm");
    let words = Values::Words(vec!["free".to_owned(), "brake".to_owned()]);
    let (law, written) = discrete(words, None);
    assert_eq!(law.unwrap().sentence(&written, ""), "discrete, free (50 %), brake (50 %)");
    let keys = [("lower", 2.0)];
    let texts = vec![("file".to_owned(), "a.csv".to_owned()), ("column".to_owned(), "b".to_owned())];
    let written = Written { values: Some(Values::Numbers(vec![4.0, 1.0, 3.0, 2.0])), texts, ..written_of(&keys) };
    let law = Uncertain::new(Distribution::Empirical, &written, "").unwrap();
    assert_eq!(law.sentence(&written, ""), "empirical, 4 values from 1 to 4, cut below 2: mean 3.2, sd 0.6532");
}

fn written_of(keys: &[(&str, f64)]) -> Written {
    written(keys)
}

#[test]
fn every_mistake_is_named_by_its_key_at_once() {
    assert_eq!(keys_refused("normal", &[("mean", f64::NAN), ("sd", -1.0), ("shape", 2.0)]), ["shape", "mean", "sd"]);
    assert_eq!(keys_refused("normal", &[]), ["mean", "sd"]);
    assert_eq!(keys_refused("normal", &[("mean", 1.0), ("median", 1.0), ("cv", 0.1), ("sd", 0.1)]), ["median", "sd"]);
    assert_eq!(keys_refused("normal", &[("mean", 0.0), ("cv", 0.1)]), ["cv"]);
    assert_eq!(keys_refused("lognormal", &[("mean", -1.0), ("sd", 0.0)]), ["mean", "sd"]);
    assert_eq!(keys_refused("uniform", &[("lower", 2.0), ("upper", 2.0)]), ["lower"]);
    assert_eq!(keys_refused("uniform", &[("lower", -1e308), ("upper", 1e308)]), ["upper"]);
    assert_eq!(keys_refused("log-uniform", &[("lower", 0.0), ("upper", 2.0)]), ["lower"]);
    assert_eq!(keys_refused("triangular", &[("lower", 0.0), ("mode", 3.0), ("upper", 2.0)]), ["mode"]);
    assert_eq!(keys_refused("beta", &[("a", 0.0), ("b", -1.0), ("lower", 3.0), ("upper", 1.0)]), ["a", "b"]);
    assert_eq!(keys_refused("beta", &[("a", 1.0), ("b", 1e9)]), ["lower", "upper", "b"]);
    assert_eq!(keys_refused("gamma", &[("shape", 1.0), ("scale", f64::INFINITY)]), ["scale"]);
    assert_eq!(keys_refused("exponential", &[("mean", 1.0), ("sd", 1.0)]), ["sd"]);
    assert_eq!(keys_refused("periodic", &[("lower", 1.0), ("upper", 0.0)]), ["lower"]);
    assert_eq!(keys_refused("discrete", &[("lower", 1.0)]), ["lower", "values"]);
    assert_eq!(keys_refused("lognormal", &[("median", 1.0), ("cv", 1e300)]), ["cv"]);
    assert_eq!(keys_refused("weibull", &[("shape", 1e-3), ("scale", 1.0)]), ["shape"]);
    let text = &refused("uniform", &written(&[("lower", 2e-3), ("upper", 1e-3)]))[0].1;
    assert_eq!(text, "`lower` = 2 mm; allowed: below `upper` = 1 mm");
    let text = &refused("normal", &written(&[("mean", 1e-3)]))[0].1;
    assert_eq!(
        text,
        "`sd` or `cv` is missing; normal has `mean` or `median`, `sd` or `cv`; with or without `lower`, `upper`"
    );
}

#[test]
fn lists_are_checked_value_by_value() {
    let keys = |values: Values, weights: Option<&[f64]>| -> Vec<String> {
        discrete(values, weights).0.unwrap_err().iter().map(ToString::to_string).collect()
    };
    let numbers = |values: &[f64]| Values::Numbers(values.to_vec());
    assert_eq!(keys(numbers(&[1.0, 2.0]), Some(&[0.0, 0.0])), ["`weights` = 0; allowed: at least one above 0"]);
    assert_eq!(
        keys(numbers(&[1.0, f64::NAN]), Some(&[-1.0, f64::INFINITY, 1.0])),
        [
            "`values`, value 2 = NaN; allowed: a finite number",
            "`weights`, value 1 = -1; allowed: 0 or more",
            "`weights`, value 2 = inf; allowed: 0 or more",
            "`weights` has 3 values; allowed: 2, one for each of `values`"
        ]
    );
    assert_eq!(keys(numbers(&[0.0, 1.0, -0.0]), None), ["`values`, value 3 = 0 m; allowed: each value once"]);
    assert_eq!(keys(numbers(&[]), None), ["`values` has 0 values; allowed: at least 1"]);
    let words = Values::Words(["a", "b", "a"].map(str::to_owned).to_vec());
    assert_eq!(keys(words, None), ["`values`, value 3 = \"a\"; allowed: each value once"]);
    assert_eq!(empirical(&[1.0], &[]).unwrap_err()[0].key(), "column");
    assert_eq!(empirical(&[1.0, 1.0], &[]).unwrap_err()[0].key(), "column");
    assert_eq!(empirical(&[1.0, 2.0], &[("lower", 3.0)]).unwrap_err()[0].key(), "lower");
}

#[test]
fn truncation_to_nothing_is_refused_and_to_a_far_tail_is_not() {
    let errors = refused("normal", &written(&[("mean", 0.0), ("sd", 1e-3), ("lower", 0.05), ("upper", 0.06)]));
    assert_eq!(errors[0].0, "lower");
    assert_eq!(
        errors[0].1,
        "nothing is left between `lower` and `upper`: 50 mm to 60 mm has a probability of 0e0 in normal, mean 0 m, sd 1 mm, cut at 50 mm and 60 mm"
    );
    let far = law("normal", &[("mean", 0.0), ("sd", 1.0), ("lower", 20.0), ("upper", 21.0)]);
    let median = far.quantile(0.5, 0.5);
    // Mills: Q(x) ~ phi(x)/x, so Q halves after ln 2/x
    assert!((median - 20.0 - 2f64.ln() / 20.0).abs() < 2e-4, "{median}");
    assert_eq!(keys_refused("gamma", &[("shape", 2.0), ("scale", 1.0), ("upper", -1.0)]), ["upper"]);
}

#[test]
fn values_outside_the_machines_range_have_their_probability_from_both_tails() {
    let outside = |law: &Uncertain, range: Range| law.outside(range).iter().sum::<f64>();
    let seven = 7.619_853_024_160_527e-24;
    let normal = law("normal", &[("mean", 1e-3), ("sd", 1e-4)]);
    let [below, above] = normal.outside(Range::POSITIVE);
    assert!((below / seven - 1.0).abs() < 1e-12 && above == 0.0, "{below:e} {above:e}");
    assert!(normal.refuse_outside(Range::POSITIVE, "m").is_ok());
    let [below, above] = normal.outside(Range::from_to(-1.0, 2e-3));
    assert!((above / seven - 1.0).abs() < 1e-12 && below == 0.0, "{below:e} {above:e}");
    let both = outside(&law("normal", &[("mean", 0.0), ("sd", 1.0)]), Range::from_to(-3.0, 2.0));
    assert!((both - (1.349_898_031_630_094_6e-3 + 2.275_013_194_817_921e-2)).abs() < 1e-16);
    // truncated: the removed part has no probability, the rest a larger one
    let cut = law("normal", &[("mean", 0.0), ("sd", 1.0), ("lower", 0.0)]);
    assert_eq!(outside(&cut, Range::NOT_NEGATIVE), 0.0);
    assert!((outside(&cut, Range::from_to(0.0, 2.0)) - 2.0 * 2.275_013_194_817_921e-2).abs() < 1e-15);
    // an open end has no probability in a distribution with a density, but may have one in a list of values
    assert_eq!(outside(&law("uniform", &[("lower", 0.0), ("upper", 1.0)]), Range::POSITIVE), 0.0);
    let uniform = law("uniform", &[("lower", -1.0), ("upper", 1.0)]);
    assert_eq!(uniform.outside(Range::between(-0.5, 0.75)), [0.25, 0.125]);
    let (list, _) = discrete(Values::Numbers(vec![0.0, 1.0, 2.0]), Some(&[1.0, 2.0, 1.0]));
    let list = list.unwrap();
    assert_eq!((list.outside(Range::POSITIVE), list.outside(Range::NOT_NEGATIVE)), ([0.25, 0.0], [0.0, 0.0]));
    assert_eq!(list.outside(Range::between(-1.0, 2.0)), [0.0, 0.25]);
    let sample = empirical(&[0.0, 0.0, 1.0, 2.0], &[]).unwrap();
    assert_eq!((sample.outside(Range::POSITIVE), sample.outside(Range::NOT_NEGATIVE)), ([0.375, 0.0], [0.0, 0.0]));
    assert_eq!(sample.outside(Range::from_to(0.0, 1.5)), [0.0, 0.25]);
    let angle = law("periodic", &[("lower", 0.0), ("upper", 4.0)]);
    assert_eq!(angle.outside(Range::from_to(1.0, 3.5)), [0.25, 0.125]);
    // rejected at the side with the larger probability
    let wide = law("normal", &[("mean", 1e-3), ("sd", 2e-4)]);
    let error = wide.refuse_outside(Range::POSITIVE, "m").unwrap_err();
    assert_eq!(error.key(), "lower");
    let text =
        "values that are not allowed have a probability of 2.9e-7, above 1e-12; allowed: > 0 m; `lower` cuts them off";
    assert_eq!(error.to_string(), text);
    assert_eq!(wide.refuse_outside(Range::from_to(-1.0, 1.5e-3), "m").unwrap_err().key(), "upper");
    assert_eq!(list.refuse_outside(Range::POSITIVE, "m").unwrap_err().key(), "values");
}

#[test]
fn an_empirical_law_has_the_mean_of_its_sample_and_stays_in_it() {
    let sample = [3.0, 1.0, 10.0, 2.5, 4.0];
    let law = empirical(&sample, &[]).unwrap();
    let (mean, sd) = law.moments().unwrap();
    assert!((mean - 4.1).abs() < 1e-15);
    let spread = (sample.iter().map(|x| (x - 4.1) * (x - 4.1)).sum::<f64>() / 5.0).sqrt();
    assert!(sd < spread && sd > 0.8 * spread, "{sd} {spread}");
    // x_i at (i - 1/2)/n, from both tails
    for (place, value) in [1.0, 2.5, 3.0, 4.0, 10.0].into_iter().enumerate() {
        let p = (place as f64 + 0.5) / 5.0;
        assert!((law.quantile(p, 1.0 - p) - value).abs() < 1e-14);
    }
    assert_eq!((law.quantile(0.0, 1.0), law.quantile(1.0, 0.0), law.quantile(0.05, 0.95)), (1.0, 10.0, 1.0));
    assert!((law.quantile(0.8, 0.2) - 7.0).abs() < 1e-14);
    // truncated in the middle of a piece; reference by a midpoint sum
    let cut = empirical(&sample, &[("lower", 2.0), ("upper", 7.0)]).unwrap();
    assert_eq!((cut.quantile(0.0, 1.0), cut.quantile(1.0, 0.0)), (2.0, 7.0));
    let count = 100_000;
    let values = (0..count).map(|k| (f64::from(k) + 0.5) / f64::from(count)).map(|p| cut.quantile(p, 1.0 - p));
    let sum = values.clone().sum::<f64>() / f64::from(count);
    let square = values.map(|x| (x - sum) * (x - sum)).sum::<f64>() / f64::from(count);
    let (mean, sd) = cut.moments().unwrap();
    assert!((mean - sum).abs() < 1e-8 && (sd - square.sqrt()).abs() < 1e-8, "{mean} {sum}");
}

#[test]
fn a_discrete_law_gives_each_value_its_part_even_a_rare_one() {
    let (law, _) = discrete(Values::Numbers(vec![5.0, 1.0, 3.0]), Some(&[1e-18, 3.0, 1.0]));
    let law = law.unwrap();
    assert_eq!([0.1, 0.74, 0.76, 0.999].map(|p| law.quantile(p, 1.0 - p)), [1.0, 1.0, 3.0, 3.0]);
    // 1 - 1e-19 is 1 as a double: the upper tail is more precise
    assert_eq!((law.quantile(1.0, 1e-19), law.quantile(1.0, 1e-18)), (5.0, 3.0));
    let (law, _) = discrete(Values::Numbers(vec![1.0, 2.0, 3.0, 4.0]), Some(&[0.0, 1.0, 1.0, 0.0]));
    let law = law.unwrap();
    assert_eq!(law.ends(), [2.0, 3.0]);
    let words = Values::Words(["z", "a", "m"].map(str::to_owned).to_vec());
    let (law, _) = discrete(words, Some(&[1.0, 1.0, 2.0]));
    let law = law.unwrap();
    assert_eq!([0.2, 0.4, 0.6, 0.9].map(|p| law.quantile(p, 1.0 - p)), [0.0, 1.0, 2.0, 2.0]);
    assert_eq!(law.words().unwrap(), ["z", "a", "m"]);
    assert!(law.moments().is_none());
}

#[test]
fn a_periodic_law_wraps() {
    let law = law("periodic", &[("lower", 1.0), ("upper", 3.0)]);
    assert_eq!((law.quantile(0.0, 1.0), law.quantile(0.25, 0.75), law.quantile(1.0, 1e-300)), (1.0, 1.5, 1.0));
    assert!(law.moments().is_none() && !law.is_ordered());
}

fn any_law() -> impl Strategy<Value = Uncertain> {
    let shape = prop_oneof![-3.0..6.0f64].prop_map(|exponent| 10f64.powf(exponent));
    (0..11usize, shape.clone(), shape, -1.0..1.0f64).prop_map(|(kind, a, b, x)| match kind {
        0 => law("normal", &[("mean", x), ("sd", a)]),
        1 => law("lognormal", &[("median", b), ("cv", a.min(100.0))]),
        2 => law("uniform", &[("lower", x), ("upper", x + a)]),
        3 => law("log-uniform", &[("lower", a), ("upper", a * (1.0 + b))]),
        4 => law("triangular", &[("lower", x), ("mode", x + a), ("upper", x + a + b)]),
        5 => law("beta", &[("a", a), ("b", b), ("lower", x), ("upper", x + 1.0)]),
        6 => law("gamma", &[("shape", a), ("scale", b)]),
        7 => law("weibull", &[("shape", a.max(0.05)), ("scale", b)]),
        8 => law("gumbel", &[("location", x), ("scale", a)]),
        9 => law("exponential", &[("mean", a)]),
        _ => law("normal", &[("mean", 0.0), ("sd", 1.0), ("lower", x), ("upper", x + a)]),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn quantiles_ascend_through_both_tails_and_are_numbers(law in any_law()) {
        let small = [1.2e-16, 1e-12, 1e-6, 1e-3, 0.02, 0.1, 0.25, 0.4, 0.499_999, 0.5];
        let lower = small.iter().map(|&p| (p, 1.0 - p));
        let upper = small.iter().rev().map(|&q| (1.0 - q, q));
        let values: Vec<f64> = lower.chain(upper).map(|(p, q)| law.quantile(p, q)).collect();
        prop_assert!(values.iter().all(|value| value.is_finite()), "{law:?}: {values:?}");
        let slack = |pair: &[f64]| 1e-13 * pair[0].abs().max(pair[1].abs());
        prop_assert!(values.windows(2).all(|pair| pair[1] >= pair[0] - slack(pair)), "{law:?}: {values:?}");
        let [least, most] = law.ends();
        prop_assert!(least <= values[0] + slack(&values[..1].repeat(2)) && most >= values[values.len() - 1] - slack(&values[values.len() - 1..].repeat(2)), "{law:?}");
        let (mean, sd) = law.moments().expect("a number");
        prop_assert!(mean.is_finite() && sd.is_finite() && sd >= 0.0 && mean >= least && mean <= most, "{law:?} {mean} {sd}");
    }
}
