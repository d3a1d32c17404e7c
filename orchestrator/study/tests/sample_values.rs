//! Values of samples, by all steps together.

use bladeoff_model::machine::ParamValue;
use bladeoff_study::correlation::{Copula, Pair, Strength};
use bladeoff_study::derived::{Derived, Variable};
use bladeoff_study::sample_values::{SampleValues, Scratch};
use bladeoff_study::sampling::layout::{LayoutDef, LayoutKind, SamplingLayout};
use bladeoff_study::uncertain::{Distribution, Uncertain, Values, Written};
use proptest::prelude::*;

fn law(word: &str, keys: &[(&str, f64)]) -> Uncertain {
    let numbers = keys.iter().map(|(key, number)| ((*key).to_owned(), *number)).collect();
    Uncertain::new(Distribution::from_word(word).expect("sound"), &Written { numbers, ..Written::default() }, "")
        .expect("sound")
}

fn words(values: &[&str], weights: &[f64]) -> Uncertain {
    let values = Some(Values::Words(values.iter().map(|word| (*word).to_owned()).collect()));
    let written = Written { values, weights: Some(weights.to_vec()), ..Written::default() };
    Uncertain::new(Distribution::Discrete, &written, "").expect("sound")
}

/// Distributions of several kinds; the last one has words.
fn laws() -> Vec<Uncertain> {
    vec![
        law("normal", &[("mean", 1e-3), ("sd", 1e-4), ("lower", 7e-4)]),
        law("gamma", &[("shape", 2.0), ("scale", 3.0)]),
        law("periodic", &[("lower", 0.0), ("upper", 6.0)]),
        law("exponential", &[("mean", 2.0)]),
        law("lognormal", &[("median", 2.0), ("cv", 0.5)]),
        words(&["free", "brake"], &[3.0, 1.0]),
    ]
}

const PAIRS: [Pair; 4] = [
    Pair { between: [0, 1], strength: Strength::Rank(-0.5) },
    Pair { between: [3, 1], strength: Strength::Linear(0.6) },
    Pair { between: [4, 3], strength: Strength::Linear(-0.2) },
    Pair { between: [5, 0], strength: Strength::Normal(0.7) },
];

fn drawing(kind: LayoutKind, samples: u64, replicates: u64, seed: u64) -> SampleValues {
    let laws = laws();
    let names: Vec<String> = (0..laws.len()).map(|i| format!("x{i}")).collect();
    static DEPENDENT: std::sync::OnceLock<Copula> = std::sync::OnceLock::new();
    let copula = match kind {
        LayoutKind::OneAtATime => Copula::independent(laws.len()),
        _ => DEPENDENT.get_or_init(|| Copula::new(&names, &laws, &PAIRS).expect("sound")).clone(),
    };
    let def = match kind {
        LayoutKind::OneAtATime => LayoutDef::new(kind),
        _ => LayoutDef {
            samples: Some(samples),
            replicates: (replicates > 1).then_some(replicates),
            ..LayoutDef::new(kind)
        },
    };
    let layout = SamplingLayout::new(&def, seed, &names, &laws, &copula).expect("sound");
    let mut variables: Vec<Variable> = names.iter().map(|name| Variable::number(name, None, "")).collect();
    variables[5].has_words = true;
    variables.push(Variable::number("speed", None, "rad/s"));
    variables.extend(["total", "part"].map(|name| Variable::number(name, None, "")));
    let formulas = ["part*2 + x1".to_owned(), "x0*speed".to_owned()];
    let derived = Derived::new(variables, &formulas).expect("sound");
    SampleValues::new(laws, copula, Some(layout), derived)
}

fn values(drawing: &SampleValues, index: u64, speed: f64) -> Vec<f64> {
    let mut values = Vec::new();
    drawing.values(index, &[speed], &mut Scratch::default(), &mut values).expect("sound");
    values
}

fn kinds() -> impl Strategy<Value = (LayoutKind, u64)> {
    prop_oneof![
        Just((LayoutKind::MonteCarlo, 1)),
        Just((LayoutKind::OneAtATime, 1)),
        (1u64..6).prop_map(|replicates| (LayoutKind::LatinHypercube, replicates)),
        (1u64..6).prop_map(|replicates| (LayoutKind::Sobol, replicates)),
        (1u64..6).prop_map(|replicates| (LayoutKind::Halton, replicates)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn a_sample_alone_is_the_sample_in_order_whatever_was_drawn_before((kind, replicates) in kinds(), seed: u64) {
        let (drawing, larger) = (drawing(kind, 16, replicates, seed), drawing(kind, 64, replicates, seed));
        let (mut scratch, mut out) = (Scratch::default(), Vec::new());
        let count = drawing.layout().expect("a plan").count();
        let mut in_order = Vec::new();
        for index in 0..count {
            drawing.values(index, &[100.0], &mut scratch, &mut out).unwrap();
            in_order.push(out.clone());
        }
        for index in (0..count).rev() {
            let alone = values(&drawing, index, 100.0);
            prop_assert_eq!(&alone, &in_order[index as usize]);
            prop_assert_eq!(&alone, &values(&larger, index, 100.0), "growth moves no sample");
            // the same points for every combination of [[vary]]
            let other = values(&drawing, index, 200.0);
            prop_assert_eq!(&alone[..6], &other[..6]);
            prop_assert_eq!(alone.len(), 9);
            prop_assert!(alone.iter().all(|value| value.is_finite()));
            prop_assert_eq!(alone[8], alone[0] * 100.0);
            prop_assert_eq!(alone[7], alone[8] * 2.0 + alone[1]);
            prop_assert!(alone[5] == 0.0 || alone[5] == 1.0);
        }
        // another seed is another design
        if kind != LayoutKind::OneAtATime {
            let other = self::drawing(kind, 16, replicates, seed ^ 1);
            prop_assert_ne!(values(&other, 0, 100.0), values(&drawing, 0, 100.0));
        }
    }
}

#[test]
fn threads_share_a_drawing() {
    let drawing = drawing(LayoutKind::Sobol, 256, 4, 3);
    let all: Vec<Vec<f64>> = (0..1024).map(|index| values(&drawing, index, 1.0)).collect();
    let (drawing, all) = (&drawing, &all);
    std::thread::scope(|scope| {
        for thread in 0..4 {
            scope.spawn(move || {
                for index in (0..1024).rev().filter(|index| index % 4 == thread) {
                    assert_eq!(values(drawing, index, 1.0), all[index as usize]);
                }
            });
        }
    });
}

#[test]
fn values_are_pinned_to_the_bit() {
    // recorded once from this implementation: FNV-1a over the bits of 96 samples, through every distribution, the copula and the formulas
    let found =
        [LayoutKind::MonteCarlo, LayoutKind::LatinHypercube, LayoutKind::Sobol, LayoutKind::Halton].map(|kind| {
            let drawing = drawing(kind, 128, if kind == LayoutKind::MonteCarlo { 1 } else { 3 }, 11);
            let all = (0..96).flat_map(|index| values(&drawing, index, 314.0));
            all.fold(0xcbf2_9ce4_8422_2325u64, |hash, value| (hash ^ value.to_bits()).wrapping_mul(0x100_0000_01b3))
        });
    println!("{found:x?}");
    assert_eq!(found, PINNED);
}

const PINNED: [u64; 4] = [0xb119_9a3f_81bc_f2bd, 0x1f4f_a3b7_ed79_c1e3, 0xe34a_0e3c_94fa_2116, 0xcd5e_61f4_42be_7c44];

#[test]
fn words_come_as_words() {
    let drawing = drawing(LayoutKind::MonteCarlo, 100, 1, 1);
    assert_eq!(drawing.param(5, 1.0), ParamValue::Choice("brake".to_owned()));
    assert_eq!(drawing.param(0, 1.0), ParamValue::Number(1.0));
    assert_eq!(drawing.param(8, 1.0), ParamValue::Number(1.0));
}

/// Rows of a batch, by variable.
type Batch = Vec<Vec<f64>>;

const BATCHES: u64 = 64;
const SIZE: u64 = 4096;

fn draw_batches(drawing: &SampleValues) -> Vec<Batch> {
    let (mut scratch, mut out) = (Scratch::default(), Vec::new());
    let mut batch = |batch: u64| {
        let mut columns: Batch = vec![Vec::new(); drawing.variables().len()];
        for index in batch * SIZE..(batch + 1) * SIZE {
            drawing.values(index, &[1.0], &mut scratch, &mut out).expect("sound");
            columns.iter_mut().zip(&out).for_each(|(column, value)| column.push(*value));
        }
        columns
    };
    (0..BATCHES).map(&mut batch).collect()
}

/// Mean over batches of a statistic of two variables, and the standard error of that mean.
fn over(batches: &[Batch], pair: [usize; 2], statistic: impl Fn(&[f64], &[f64]) -> f64) -> (f64, f64) {
    let found: Vec<f64> = batches.iter().map(|batch| statistic(&batch[pair[0]], &batch[pair[1]])).collect();
    let count = found.len() as f64;
    let mean = found.iter().sum::<f64>() / count;
    let variance = found.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| f(x - ma, y - mb)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

fn ranks(x: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|&i, &j| x[i].total_cmp(&x[j]));
    let mut ranks = vec![0.0; x.len()];
    order.into_iter().enumerate().for_each(|(rank, place)| ranks[place] = rank as f64);
    ranks
}

#[test]
fn draws_have_the_correlations_that_were_asked_for() {
    let drawing = drawing(LayoutKind::MonteCarlo, 1 << 18, 1, 20_261_122);
    let drawn = draw_batches(&drawing);
    let check = |name: &str, (mean, error): (f64, f64), wanted: f64| {
        println!(
            "{name}: {mean:.5} wanted {wanted:.5}, standard error {error:.5}, off by {:.2}",
            (mean - wanted) / error
        );
        assert!(error < 2.5e-3, "{name}: {error}");
        assert!((mean - wanted).abs() < 4.0 * error, "{name}: {mean} for {wanted}, standard error {error}");
    };
    check("rank -0.5", over(&drawn, [0, 1], |a, b| pearson(&ranks(a), &ranks(b))), -0.5);
    check("linear 0.6", over(&drawn, [3, 1], pearson), 0.6);
    check("linear -0.2", over(&drawn, [4, 3], pearson), -0.2);
    check("independent", over(&drawn, [2, 4], pearson), 0.0);
    // a word above its median means z > Phi^-1(3/4), with r = 0.7: P(word and x0 above its median)
    let both = over(&drawn, [5, 0], |word, x| {
        let median = laws()[0].quantile(0.5, 0.5);
        word.iter().zip(x).filter(|(word, x)| **word == 1.0 && **x > median).count() as f64 / word.len() as f64
    });
    check("word and value", both, BOTH);
    // each distribution is unchanged: means within their own standard error
    for number in [0, 1, 3, 4] {
        let (mean, sd) = laws()[number].moments().unwrap();
        let (found, error) = over(&drawn, [number, number], |x, _| x.iter().sum::<f64>() / x.len() as f64);
        println!("mean of x{number}: {found} wanted {mean}, standard error {error}");
        assert!((found - mean).abs() < 4.0 * error && error < 1.5 * sd / 512.0, "x{number}: {found} {mean} {error}");
    }
}

/// P(z1 > 0.6745, z2 > 0), correlation 0.7: mpmath's quadrature.
const BOTH: f64 = 0.217735565469;
