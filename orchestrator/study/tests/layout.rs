//! Positions of the points of a design.

use bladeoff_study::correlation::{Copula, Pair, Strength};
use bladeoff_study::sampling::layout::{Base, LayoutDef, LayoutError, LayoutKind, SamplingLayout, Standing};
use bladeoff_study::uncertain::{Distribution, Uncertain, Values, Written};
use proptest::prelude::*;

fn law(word: &str, keys: &[(&str, f64)]) -> Uncertain {
    let numbers = keys.iter().map(|(key, number)| ((*key).to_owned(), *number)).collect();
    Uncertain::new(Distribution::from_word(word).expect("sound"), &Written { numbers, ..Written::default() }, "")
        .expect("sound")
}

fn uniforms(count: usize) -> Vec<Uncertain> {
    (0..count).map(|_| law("uniform", &[("lower", 0.0), ("upper", 1.0)])).collect()
}

fn names(count: usize) -> Vec<String> {
    (0..count).map(|i| format!("x{i}")).collect()
}

fn made(def: &LayoutDef, laws: &[Uncertain]) -> Result<SamplingLayout, Vec<LayoutError>> {
    SamplingLayout::new(def, 7, &names(laws.len()), laws, &Copula::independent(laws.len()))
}

fn def(kind: LayoutKind, samples: u64, replicates: u64) -> LayoutDef {
    let replicates = (replicates > 1).then_some(replicates);
    LayoutDef { samples: Some(samples), replicates, ..LayoutDef::new(kind) }
}

fn point(layout: &SamplingLayout, index: u64, dimensions: usize) -> Vec<f64> {
    let mut point = vec![0.0; dimensions];
    layout.fill(index, &mut point);
    point
}

fn keys(def: &LayoutDef, laws: &[Uncertain]) -> Vec<(&'static str, String)> {
    made(def, laws).expect_err("mistakes").iter().map(|error| (error.key(), error.to_string())).collect()
}

fn any_kind() -> impl Strategy<Value = (LayoutKind, u64)> {
    prop_oneof![
        Just((LayoutKind::MonteCarlo, 1)),
        (1u64..20).prop_map(|replicates| (LayoutKind::LatinHypercube, replicates)),
        (1u64..20).prop_map(|replicates| (LayoutKind::Sobol, replicates)),
        (1u64..20).prop_map(|replicates| (LayoutKind::Halton, replicates)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn a_design_grows_without_moving_a_point((kind, replicates) in any_kind(), seed: u64, small in 0u32..6, more in 1u32..4, dimensions in 1usize..9) {
        let laws = uniforms(dimensions + 2);
        let names = names(dimensions + 2);
        let copula = Copula::independent(dimensions + 2);
        let layout = |samples: u64, replicates: u64, dimensions: usize| {
            SamplingLayout::new(&def(kind, samples, replicates), seed, &names[..dimensions], &laws[..dimensions], &copula).unwrap()
        };
        let few = layout(1 << small, replicates, dimensions);
        let many = layout(1 << (small + more), replicates, dimensions + 2);
        let alone = layout(1 << (small + more), 1, dimensions);
        prop_assert_eq!(few.count(), replicates << small);
        for index in 0..few.count() {
            let here = point(&few, index, dimensions);
            prop_assert!(here.iter().all(|u| *u > 0.0 && *u < 1.0));
            // more samples and more parameters
            prop_assert_eq!(&here, &point(&many, index, dimensions + 2)[..dimensions]);
            // the first replicate is the same without the others
            if few.replicate(index) == 0 && kind != LayoutKind::MonteCarlo {
                prop_assert_eq!(&here, &point(&alone, few.block(index), dimensions));
            }
        }
        // replicates differ
        if replicates > 1 {
            prop_assert_ne!(point(&few, 0, dimensions), point(&few, 1, dimensions));
        }
    }

    #[test]
    fn every_replicate_of_a_hypercube_and_of_sobol_has_one_point_in_each_slice(kind in prop_oneof![Just(LayoutKind::LatinHypercube), Just(LayoutKind::Sobol)], seed: u64, power in 0u32..7, replicates in 1u64..5) {
        let laws = uniforms(4);
        let layout = SamplingLayout::new(&def(kind, 128, replicates), seed, &names(4), &laws, &Copula::independent(4)).unwrap();
        let slices = 1u64 << power;
        for replicate in 0..replicates {
            for dimension in 0..4 {
                let mut found: Vec<u64> = (0..slices)
                    .map(|j| replicates * j + replicate)
                    .map(|index| (point(&layout, index, 4)[dimension] * slices as f64) as u64)
                    .collect();
                found.sort_unstable();
                prop_assert!(found.into_iter().eq(0..slices));
            }
        }
    }

    #[test]
    fn a_limit_takes_whole_blocks_and_is_the_beginning_of_a_larger_one((kind, replicates) in any_kind(), limit in 0u64..400) {
        let layout = made(&def(kind, 16, replicates), &uniforms(2)).unwrap();
        let count = layout.limited(limit);
        prop_assert!(count >= replicates && count <= layout.count() && count.is_multiple_of(replicates));
        prop_assert!(count <= limit.max(replicates));
        match kind {
            // replicates with a power of two of points, which allow an interval
            LayoutKind::LatinHypercube | LayoutKind::Sobol => {
                prop_assert!((count / replicates).is_power_of_two() && 2 * count > limit.min(layout.count()));
                prop_assert_eq!(layout.whole(count), count);
            }
            _ => prop_assert!(count + replicates > limit.min(layout.count())),
        }
        prop_assert!(layout.whole(count) <= count && layout.whole(layout.whole(count)) == layout.whole(count));
    }
}

#[test]
fn points_are_pinned() {
    // recorded once from this implementation: a change here changes the results of every study with a design
    let expected: [(LayoutKind, [u64; 2]); 4] = PINNED;
    let mut wrong = Vec::new();
    for (kind, bits) in expected {
        let layout = made(&def(kind, 64, if kind == LayoutKind::MonteCarlo { 1 } else { 3 }), &uniforms(3)).unwrap();
        let found = point(&layout, 37, 3);
        println!("{kind:?}: [{:#x}, {:#x}],", found[0].to_bits(), found[2].to_bits());
        wrong.extend(([found[0].to_bits(), found[2].to_bits()] != bits).then_some(kind));
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

const PINNED: [(LayoutKind, [u64; 2]); 4] = [
    (LayoutKind::MonteCarlo, [0x3fc8_b2e7_cc03_95fc, 0x3fe3_f076_bcf2_6865]),
    (LayoutKind::LatinHypercube, [0x3fd3_1663_d7c6_e496, 0x3fe5_317b_12ee_3103]),
    (LayoutKind::Sobol, [0x3fe7_a042_6a0a_26cb, 0x3fbb_e92b_de27_68c8]),
    (LayoutKind::Halton, [0x3fee_5871_e7cc_844d, 0x3f5e_5a60_c62a_76df]),
];

#[test]
fn unscrambled_sequences_begin_as_published() {
    let plain = |kind| LayoutDef { scramble: Some(false), ..def(kind, 8, 1) };
    let sobol = made(&plain(LayoutKind::Sobol), &uniforms(4)).unwrap();
    assert_eq!(point(&sobol, 0, 4), [0.0; 4]);
    assert_eq!(point(&sobol, 4, 4), [0.375, 0.375, 0.625, 0.875]);
    let halton = made(&plain(LayoutKind::Halton), &uniforms(3)).unwrap();
    assert_eq!(point(&halton, 3, 3), [0.75, 1.0 / 9.0, 0.6]);
    assert_eq!(sobol.standing(8), Standing::NoInterval("points that are not scrambled are not random"));
}

#[test]
fn unscrambled_point_0_is_refused_where_it_would_be_infinite() {
    let laws = [
        law("normal", &[("mean", 0.0), ("sd", 1.0)]),
        law("exponential", &[("mean", 1.0)]),
        law("gumbel", &[("location", 0.0), ("scale", 1.0)]),
    ];
    let plain = LayoutDef { scramble: Some(false), ..def(LayoutKind::Sobol, 8, 1) };
    let found = keys(&plain, &laws);
    assert_eq!(found.iter().map(|(key, _)| *key).collect::<Vec<_>>(), ["scramble", "scramble"]);
    assert!(found[0].1.contains("x0") && found[1].1.contains("x2"), "{found:?}");
    let cut = [law("normal", &[("mean", 0.0), ("sd", 1.0), ("lower", -3.0)]), law("exponential", &[("mean", 1.0)])];
    assert!(made(&plain, &cut).is_ok());
    let pair = Pair { between: [0, 1], strength: Strength::Rank(0.5) };
    let copula = Copula::new(&names(2), &cut, &[pair]).unwrap();
    assert_eq!(
        SamplingLayout::new(&plain, 7, &names(2), &cut, &copula).unwrap_err(),
        [LayoutError::UnboundedByCorrelation]
    );
    assert!(SamplingLayout::new(&def(LayoutKind::Sobol, 8, 1), 7, &names(2), &cut, &copula).is_ok());
    let steps = LayoutDef::new(LayoutKind::OneAtATime);
    assert_eq!(
        SamplingLayout::new(&steps, 7, &names(2), &cut, &copula).unwrap_err(),
        [LayoutError::Correlated { kind: LayoutKind::OneAtATime }]
    );
}

#[test]
fn keys_that_do_not_go_together_are_refused_all_at_once() {
    let laws = uniforms(2);
    let all = LayoutDef {
        samples: Some(100),
        replicates: Some(16),
        scramble: Some(true),
        base: Some(Base::Median),
        quantiles: Some(vec![0.1]),
        ..LayoutDef::new(LayoutKind::MonteCarlo)
    };
    let found = keys(&all, &laws);
    assert_eq!(found.iter().map(|(key, _)| *key).collect::<Vec<_>>(), ["replicates", "scramble", "base", "quantiles"]);
    assert_eq!(
        found[0].1,
        "`replicates` with kind = \"monte-carlo\": its points are already independent; allowed: only `samples` = 1600"
    );
    let found = keys(&LayoutDef { kind: LayoutKind::OneAtATime, ..all.clone() }, &laws);
    assert_eq!(found.iter().map(|(key, _)| *key).collect::<Vec<_>>(), ["samples", "replicates", "scramble"]);
    let found = keys(&LayoutDef { scramble: Some(false), ..def(LayoutKind::LatinHypercube, 1000, 16) }, &laws);
    assert_eq!(found.iter().map(|(key, _)| *key).collect::<Vec<_>>(), ["scramble", "samples"]);
    assert_eq!(found[1].1, "`samples` = 1000; allowed: a power of two: 512 or 1024");
    assert_eq!(keys(&LayoutDef { scramble: Some(false), ..def(LayoutKind::Halton, 10, 2) }, &laws)[0].0, "replicates");
    assert_eq!(keys(&LayoutDef::new(LayoutKind::Sobol), &laws)[0].0, "samples");
    assert_eq!(keys(&def(LayoutKind::MonteCarlo, 0, 1), &laws)[0].1, "`samples` = 0; allowed: 1 to 100000000");
    assert_eq!(
        keys(&def(LayoutKind::Halton, 10_000_000, 16), &laws)[0].1,
        "`samples` = 10000000; allowed: 1 to 6250000 (100000000 points in 16 replicates)"
    );
    assert_eq!(keys(&LayoutDef { replicates: Some(0), ..def(LayoutKind::Halton, 10, 1) }, &laws)[0].0, "replicates");
    assert_eq!(
        keys(&def(LayoutKind::MonteCarlo, 10, 1), &uniforms(129))[0].1,
        "the design has 129 uncertain parameters; allowed: 1 to 128"
    );
    assert_eq!(keys(&def(LayoutKind::MonteCarlo, 10, 1), &[])[0].0, "kind");
    let quantiles = |list: &[f64], base: Option<Base>| LayoutDef {
        quantiles: Some(list.to_vec()),
        base,
        ..LayoutDef::new(LayoutKind::OneAtATime)
    };
    let found = keys(&quantiles(&[0.1, 0.1, 0.5, 1.5, f64::NAN], None), &laws);
    assert_eq!(found.len(), 4, "{found:?}");
    assert_eq!(keys(&quantiles(&[], None), &laws)[0].1, "`quantiles` = 0 values; allowed: 1 to 100 values");
    assert!(made(&quantiles(&[0.5], Some(Base::Nominal(vec![Some(0.0), Some(0.0)]))), &laws).is_ok());
    let normal = [law("normal", &[("mean", 0.0), ("sd", 1.0)])];
    assert_eq!(
        keys(&quantiles(&[0.9, 1.0], None), &normal)[0].1,
        "`quantiles`, value 2 = 1; allowed: above 0 and below 1: x0 has no such end"
    );
    let nominal = LayoutDef { base: Some(Base::Nominal(vec![None])), ..LayoutDef::new(LayoutKind::OneAtATime) };
    assert_eq!(keys(&nominal, &normal)[0].0, "base");
}

#[test]
fn intervals_are_made_of_what_is_whole() {
    let laws = uniforms(2);
    let standing = |layout: &SamplingLayout, count| layout.standing(count);
    let monte_carlo = made(&def(LayoutKind::MonteCarlo, 100, 1), &laws).unwrap();
    assert_eq!((standing(&monte_carlo, 37), monte_carlo.whole(37)), (Standing::Independent, 37));
    let cubes = made(&def(LayoutKind::LatinHypercube, 64, 16), &laws).unwrap();
    assert_eq!(standing(&cubes, 1024), Standing::Replicates(16));
    assert_eq!(standing(&cubes, 16), Standing::Replicates(16));
    assert_eq!(standing(&cubes, 16 * 63), Standing::NoInterval("replicates of a size that is no power of two"));
    assert_eq!(standing(&cubes, 1000), Standing::NoInterval("replicates of different sizes"));
    assert_eq!((cubes.whole(1000), cubes.whole(15), cubes.whole(1024)), (512, 0, 1024));
    let halton = made(&def(LayoutKind::Halton, 63, 16), &laws).unwrap();
    assert_eq!((standing(&halton, 160), halton.whole(170)), (Standing::Replicates(16), 160));
    let few = made(&def(LayoutKind::Sobol, 64, 15), &laws).unwrap();
    assert_eq!(standing(&few, few.count()), Standing::NoInterval("fewer than 16 replicates"));
    assert_eq!(few.notes(&Copula::independent(2)), ["answers have no interval: 15 replicates, 16 are needed"]);
    assert!(cubes.notes(&Copula::independent(2)).is_empty());
}

#[test]
fn scale_shrinks_to_powers_of_two_where_the_kind_needs_them() {
    let laws = uniforms(2);
    let count = |kind, samples, replicates, factor| {
        made(&def(kind, samples, replicates), &laws).unwrap().scaled(factor).count()
    };
    assert_eq!(count(LayoutKind::MonteCarlo, 1000, 1, 0.25), 250);
    assert_eq!(count(LayoutKind::MonteCarlo, 1000, 1, 1e-9), 1);
    assert_eq!(count(LayoutKind::Sobol, 1024, 16, 0.3), 16 * 256);
    assert_eq!(count(LayoutKind::LatinHypercube, 1024, 16, 1e-9), 16);
    assert_eq!(count(LayoutKind::LatinHypercube, 1024, 16, 1.0), 16 * 1024);
    assert_eq!(count(LayoutKind::Halton, 1000, 16, 0.3), 16 * 300);
    let whole = made(&def(LayoutKind::Sobol, 1024, 16), &laws).unwrap();
    let part = whole.clone().scaled(0.3);
    assert!((0..part.count()).step_by(97).all(|index| point(&whole, index, 2) == point(&part, index, 2)));
    assert_eq!(made(&LayoutDef::new(LayoutKind::OneAtATime), &laws).unwrap().scaled(0.1).count(), 5);
}

#[test]
fn one_at_a_time_changes_one_parameter_from_the_base_point() {
    let words = Values::Words(["a", "b", "c"].map(str::to_owned).to_vec());
    let written = Written { values: Some(words), weights: Some(vec![1.0, 3.0, 1.0]), ..Written::default() };
    let list = Uncertain::new(Distribution::Discrete, &written, "").unwrap();
    let laws = [law("uniform", &[("lower", 0.0), ("upper", 10.0)]), list, law("normal", &[("mean", 5.0), ("sd", 1.0)])];
    let values = |layout: &SamplingLayout| -> Vec<Vec<f64>> {
        let draw = bladeoff_study::sample_values::SampleValues::new(
            laws.to_vec(),
            Copula::independent(3),
            Some(layout.clone()),
            bladeoff_study::derived::Derived::none(
                (0..3).map(|i| bladeoff_study::derived::Variable::number(&format!("x{i}"), None, "")).collect(),
            ),
        );
        let mut out = Vec::new();
        (0..layout.count())
            .map(|index| {
                draw.values(index, &[], &mut bladeoff_study::sample_values::Scratch::default(), &mut out).unwrap();
                out.clone()
            })
            .collect()
    };
    let layout =
        made(&LayoutDef { quantiles: Some(vec![0.25]), ..LayoutDef::new(LayoutKind::OneAtATime) }, &laws).unwrap();
    let all = values(&layout);
    let low = laws[2].quantile(0.25, 0.75);
    assert_eq!(all, [[5.0, 1.0, 5.0], [5.0, 0.0, 5.0], [5.0, 2.0, 5.0], [2.5, 1.0, 5.0], [5.0, 1.0, low]]);
    assert_eq!((0..5).map(|index| layout.block(index)).collect::<Vec<_>>(), [0, 1, 1, 2, 2]);
    assert_eq!(
        (0..5).map(|index| layout.steps().unwrap().changed(index)).collect::<Vec<_>>(),
        [None, Some(1), Some(1), Some(0), Some(2)]
    );
    assert_eq!([1, 2, 3, 4, 5, 9].map(|limit| layout.limited(limit)), [1, 1, 3, 3, 5, 5]);
    // an additional quantile changes no point
    let more = made(&LayoutDef { quantiles: Some(vec![0.25, 0.75]), ..LayoutDef::new(LayoutKind::OneAtATime) }, &laws)
        .unwrap();
    assert_eq!(values(&more)[..5], all[..]);
    assert_eq!(more.count(), 7);
    let nominal = LayoutDef {
        base: Some(Base::Nominal(vec![Some(1.0), Some(2.0), Some(3.0)])),
        ..LayoutDef::new(LayoutKind::OneAtATime)
    };
    let nominal = made(&nominal, &laws).unwrap();
    assert_eq!(values(&nominal)[..3], [[1.0, 2.0, 3.0], [1.0, 0.0, 3.0], [1.0, 1.0, 3.0]]);
    assert_eq!(nominal.count(), 1 + 2 + 4);
}

/// Linear scrambling once gave two of 30 parameters a correlation of 0.99 in a replicate of 64 points.
#[test]
fn a_replicate_of_too_few_points_is_reported_with_its_worst_pair() {
    let said = |kind: LayoutKind, samples: u64, parameters: usize| {
        let layout = made(&def(kind, samples, 16), &uniforms(parameters)).unwrap();
        let names = names(parameters);
        layout.related(layout.count(), &names.iter().map(String::as_str).collect::<Vec<_>>())
    };
    for kind in [LayoutKind::Sobol, LayoutKind::Halton] {
        assert_eq!(said(kind, 64, 4), None);
        assert_eq!(said(kind, 4096, 30), None);
        let few = said(kind, 64, 30).expect("a warning");
        let (begin, pair) = few.split_once(". The values of x").expect("the pair");
        assert_eq!(begin, "64 points of a replicate are few for 30 parameters");
        let (_, r) = pair.split_once(" have correlation ").expect("a number");
        let r: f64 = r.split(',').next().expect("a number").parse().expect("a number");
        let most = if kind == LayoutKind::Halton { 0.5 } else { 0.9 };
        assert!((0.3..most).contains(&r.abs()), "{few}");
        assert!(few.contains(" of 435 pairs "), "{few}");
    }
    // the rule for sequences does not apply to randomly paired points
    assert_eq!(said(LayoutKind::LatinHypercube, 64, 30), None);
}
