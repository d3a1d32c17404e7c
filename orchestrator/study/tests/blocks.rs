//! Designs whose points form blocks: Morris trajectories and Saltelli's layout.

use bladeoff_study::correlation::{Copula, Pair, Strength};
use bladeoff_study::derived::{Derived, Variable};
use bladeoff_study::sample_values::{SampleValues, Scratch};
use bladeoff_study::sampling::layout::{LayoutDef, LayoutError, LayoutKind, Move, Role, SamplingLayout, Standing};
use bladeoff_study::uncertain::{Distribution, Uncertain, Values, Written};
use proptest::prelude::*;
use std::f64::consts::PI;

fn law(word: &str, keys: &[(&str, f64)]) -> Uncertain {
    let numbers = keys.iter().map(|(key, number)| ((*key).to_owned(), *number)).collect();
    Uncertain::new(Distribution::from_word(word).expect("sound"), &Written { numbers, ..Written::default() }, "")
        .expect("sound")
}

fn uniforms(count: usize, lower: f64, upper: f64) -> Vec<Uncertain> {
    (0..count).map(|_| law("uniform", &[("lower", lower), ("upper", upper)])).collect()
}

fn names(count: usize) -> Vec<String> {
    (0..count).map(|i| format!("x{i}")).collect()
}

fn made(def: &LayoutDef, seed: u64, laws: &[Uncertain]) -> Result<SamplingLayout, Vec<LayoutError>> {
    SamplingLayout::new(def, seed, &names(laws.len()), laws, &Copula::independent(laws.len()))
}

fn morris(trajectories: u64, levels: u64) -> LayoutDef {
    LayoutDef { trajectories: Some(trajectories), levels: Some(levels), ..LayoutDef::new(LayoutKind::Morris) }
}

fn saltelli(samples: u64, second_order: bool) -> LayoutDef {
    LayoutDef { samples: Some(samples), second_order: Some(second_order), ..LayoutDef::new(LayoutKind::Saltelli) }
}

fn point(layout: &SamplingLayout, index: u64, dimensions: usize) -> Vec<f64> {
    let mut point = vec![0.0; dimensions];
    layout.fill(index, &mut point);
    point
}

/// Values of every point for the given distributions.
fn values(layout: &SamplingLayout, laws: &[Uncertain]) -> Vec<Vec<f64>> {
    let variables = names(laws.len()).iter().map(|name| Variable::number(name, None, "")).collect();
    let drawing = SampleValues::new(
        laws.to_vec(),
        Copula::independent(laws.len()),
        Some(layout.clone()),
        Derived::none(variables),
    );
    let (mut scratch, mut values) = (Scratch::default(), Vec::new());
    let mut one = |index| {
        drawing.values(index, &[], &mut scratch, &mut values).expect("finite");
        values.clone()
    };
    (0..layout.count()).map(&mut one).collect()
}

fn ishigami(x: &[f64]) -> f64 {
    libm::sin(x[0]) + 7.0 * libm::sin(x[1]).powi(2) + 0.1 * x[2].powi(4) * libm::sin(x[0])
}

fn any_def() -> impl Strategy<Value = LayoutDef> {
    prop_oneof![
        (1u64..20, 1u64..5).prop_map(|(trajectories, half)| morris(trajectories, 2 * half)),
        (0u32..5, any::<bool>()).prop_map(|(power, second_order)| saltelli(1 << power, second_order)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn growth_moves_no_point_and_a_limit_takes_whole_blocks(def in any_def(), seed: u64, dimensions in 1usize..7, limit in 0u64..400) {
        let laws = uniforms(dimensions, -1.0, 1.0);
        let few = made(&def, seed, &laws).unwrap();
        let more = LayoutDef { trajectories: def.trajectories.map(|n| n + 7), samples: def.samples.map(|n| 4 * n), ..def.clone() };
        let many = made(&more, seed, &laws).unwrap();
        let blocks = def.trajectories.or(def.samples).unwrap();
        prop_assert_eq!(few.count(), blocks * few.rows());
        for index in 0..few.count() {
            let here = point(&few, index, dimensions);
            prop_assert!(here.iter().all(|u| (0.0..=1.0).contains(u)));
            prop_assert_eq!(here, point(&many, index, dimensions));
            prop_assert_eq!((few.block(index), few.replicate(index)), (index / few.rows(), 0));
        }
        let taken = many.limited(limit);
        prop_assert!(taken >= many.rows() && taken <= many.count() && taken.is_multiple_of(many.rows()));
        prop_assert!(taken <= limit.max(many.rows()) && taken + many.rows() > limit.min(many.count()));
        prop_assert!(matches!(few.standing(few.count()), Standing::NoInterval(_)));
    }

    #[test]
    fn every_parameter_of_a_trajectory_moves_once_by_delta(seed: u64, half in 1u64..6, dimensions in 1usize..9) {
        let layout = made(&morris(12, 2 * half), seed, &uniforms(dimensions, 0.0, 1.0)).unwrap();
        let trajectories = layout.trajectories().expect("trajectories");
        for index in 0..layout.count() {
            let here = point(&layout, index, dimensions);
            let levels = here.iter().map(|u| u * (2 * half - 1) as f64);
            prop_assert!(levels.into_iter().all(|level| (level - level.round()).abs() < 1e-12));
            let Some(Move { parameter, up }) = trajectories.moved(index) else {
                prop_assert!(index.is_multiple_of(layout.rows()));
                continue;
            };
            let before = point(&layout, index - 1, dimensions);
            for other in 0..dimensions {
                let moved = if other != parameter { 0.0 } else if up { trajectories.delta() } else { -trajectories.delta() };
                prop_assert!((here[other] - before[other] - moved).abs() < 1e-12);
            }
            let block = index - index % layout.rows();
            let earlier = (block..index).filter_map(|index| trajectories.moved(index)).any(|moved| moved.parameter == parameter);
            prop_assert!(!earlier);
        }
    }

    #[test]
    fn blocks_of_saltelli_exchange_one_parameter(seed: u64, second_order: bool, dimensions in 1usize..8) {
        let layout = made(&saltelli(8, second_order), seed, &uniforms(dimensions, 0.0, 1.0)).unwrap();
        let saltelli = layout.saltelli().expect("a layout of Saltelli");
        let rows = saltelli.rows();
        prop_assert_eq!(rows, if second_order { 2 } else { 1 } * dimensions as u64 + 2);
        for block in 0..8 {
            let (a, b) = (point(&layout, block * rows, dimensions), point(&layout, (block + 1) * rows - 1, dimensions));
            prop_assert!(a.iter().zip(&b).all(|(a, b)| a != b));
            let mut roles = Vec::new();
            for index in block * rows..(block + 1) * rows {
                let mut expected = Vec::new();
                for parameter in 0..dimensions {
                    expected.push(match saltelli.role(index) {
                        Role::A => a[parameter],
                        Role::B => b[parameter],
                        Role::Ab(i) => if i == parameter { b[parameter] } else { a[parameter] },
                        Role::Ba(i) => if i == parameter { a[parameter] } else { b[parameter] },
                    });
                }
                prop_assert_eq!(point(&layout, index, dimensions), expected);
                roles.push(saltelli.role(index));
            }
            let mut expected = vec![Role::A];
            expected.extend((0..dimensions).map(Role::Ab));
            expected.extend((0..dimensions).map(Role::Ba).filter(|_| second_order));
            expected.push(Role::B);
            prop_assert_eq!(roles, expected);
        }
    }
}

/// Results of another program: unscrambled Joe-Kuo points from index 0, N = 1024, first order of Saltelli (2010), total of Jansen.
#[test]
fn unscrambled_saltelli_points_give_the_published_estimates() {
    let laws = uniforms(3, -PI, PI);
    let layout = made(&LayoutDef { scramble: Some(false), ..saltelli(1024, false) }, 7, &laws).unwrap();
    let f: Vec<f64> = values(&layout, &laws).iter().map(|x| ishigami(x)).collect();
    let blocks: Vec<&[f64]> = f.chunks_exact(5).collect();
    let both: Vec<f64> = blocks.iter().flat_map(|block| [block[0], block[4]]).collect();
    let mean = both.iter().sum::<f64>() / 2048.0;
    let variance = both.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / 2048.0;
    for (i, first, total) in
        [(1, 0.332739378383, 0.558179045711), (2, 0.441313938544, 0.443284584030), (3, 0.018399909008, 0.242149373355)]
    {
        let over = |of: &dyn Fn(&[f64]) -> f64| blocks.iter().map(|block| of(block)).sum::<f64>() / 1024.0 / variance;
        assert!((over(&|y| y[4] * (y[i] - y[0])) - first).abs() < 2e-12, "{i}");
        assert!((over(&|y| 0.5 * (y[0] - y[i]) * (y[0] - y[i])) - total).abs() < 2e-12, "{i}");
    }
}

/// Reference: exact values over all elementary effects of the grid of 4 levels.
#[test]
fn trajectories_draw_every_elementary_effect_as_often() {
    let laws = uniforms(3, -PI, PI);
    let layout = made(&morris(20_000, 4), 20261122, &laws).unwrap();
    let trajectories = layout.trajectories().unwrap();
    let all = values(&layout, &laws);
    let mut effects = vec![Vec::new(); 3];
    for index in 0..layout.count() {
        let Some(Move { parameter, up }) = trajectories.moved(index) else { continue };
        let (before, here) = (ishigami(&all[index as usize - 1]), ishigami(&all[index as usize]));
        effects[parameter].push((here - before) / trajectories.delta() * if up { 1.0 } else { -1.0 });
    }
    let mean = |list: &[f64], of: fn(f64) -> f64| list.iter().map(|e| of(*e)).sum::<f64>() / list.len() as f64;
    for (list, mu_star, sigma) in [
        (&effects[0], 7.7040541116, 6.2487961033),
        (&effects[1], 7.875, 7.875),
        (&effects[2], 6.2487961033, 8.8371321978),
    ] {
        assert_eq!(list.len(), 20_000);
        let star = mean(list, f64::abs);
        let deviation = (mean(list, |e| e * e) - mean(list, |e| e).powi(2)).sqrt();
        // five standard errors of the mean of this many effects
        assert!((star - mu_star).abs() < 5.0 * sigma / 20_000f64.sqrt(), "{star} {mu_star}");
        assert!((deviation - sigma).abs() < 0.02 * sigma, "{deviation} {sigma}");
    }
    // starts of the first parameter and orders of moves are equally frequent
    let mut starts = [0; 4];
    let mut orders = std::collections::BTreeMap::new();
    for t in 0..20_000 {
        starts[(point(&layout, 4 * t, 3)[0] * 3.0).round() as usize] += 1;
        let order: Vec<usize> =
            (1..4).filter_map(|step| trajectories.moved(4 * t + step)).map(|m| m.parameter).collect();
        *orders.entry(order).or_insert(0) += 1;
    }
    assert!(starts.iter().all(|count: &i32| (count - 5000).abs() < 350), "{starts:?}");
    assert!(orders.len() == 6 && orders.values().all(|count: &i32| (count - 3333).abs() < 300), "{orders:?}");
}

#[test]
fn levels_are_finite_for_every_law() {
    let words = Values::Words(["a", "b", "c"].map(str::to_owned).to_vec());
    let written = Written { values: Some(words), weights: Some(vec![1.0, 2.0, 1.0]), ..Written::default() };
    let laws = [
        law("normal", &[("mean", 0.0), ("sd", 1.0)]),
        law("lognormal", &[("median", 2.0), ("cv", 0.5)]),
        law("normal", &[("mean", 0.0), ("sd", 1.0), ("lower", -2.0), ("upper", 2.0)]),
        law("periodic", &[("lower", 0.0), ("upper", 8.0)]),
        Uncertain::new(Distribution::Discrete, &written, "").unwrap(),
    ];
    let layout = made(&morris(200, 4), 3, &laws).unwrap();
    let all = values(&layout, &laws);
    let seen = |parameter: usize| {
        let mut found: Vec<f64> = all.iter().map(|x| x[parameter]).collect();
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    };
    // 0.5 % and 99.5 %: normal -2.5758293035489; between them at thirds of the range
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    assert_eq!(seen(0).len(), 4);
    near(seen(0)[0], -2.5758293035489);
    near(seen(0)[3], 2.5758293035489);
    near(seen(0)[1], laws[0].quantile(0.335, 0.665));
    // both ends are cut though one of them is finite: 0 is not among the values
    near(seen(1)[0], laws[1].quantile(0.005, 0.995));
    assert_eq!((seen(2)[0], seen(2)[3]), (-2.0, 2.0));
    assert_eq!(seen(3), [0.0, 2.0, 4.0, 6.0]);
    assert_eq!(seen(4), [0.0, 1.0, 2.0]);
    let trajectories = layout.trajectories().unwrap();
    for (index, pair) in all.windows(2).enumerate() {
        let Some(Move { parameter, up }) = trajectories.moved(index as u64 + 1) else { continue };
        assert_eq!(pair[1][parameter] > pair[0][parameter], up, "{parameter}");
        assert_ne!(pair[1][parameter], pair[0][parameter]);
        if parameter == 3 {
            assert_eq!((pair[1][3] - pair[0][3]).abs(), 4.0);
        }
    }
}

#[test]
fn what_does_not_go_together_is_refused() {
    let laws = uniforms(3, 0.0, 1.0);
    let keys = |def: &LayoutDef, laws: &[Uncertain]| -> Vec<(&'static str, String)> {
        made(def, 7, laws).expect_err("mistakes").iter().map(|error| (error.key(), error.to_string())).collect()
    };
    let every = LayoutDef {
        samples: Some(100),
        replicates: Some(4),
        scramble: Some(false),
        quantiles: Some(vec![0.1]),
        trajectories: Some(0),
        levels: Some(5),
        second_order: Some(true),
        ..LayoutDef::new(LayoutKind::Morris)
    };
    let found = keys(&every, &laws);
    let at = |found: &[(&'static str, String)]| found.iter().map(|(key, _)| *key).collect::<Vec<_>>();
    assert_eq!(
        at(&found),
        ["samples", "replicates", "scramble", "quantiles", "second_order", "levels", "trajectories"]
    );
    assert_eq!(found[5].1, "`levels` = 5; allowed: an even number from 2 to 64: a move goes half of them");
    assert_eq!(found[6].1, "`trajectories` = 0; allowed: 1 to 25000000 (100000000 points, 4 for each)");
    assert_eq!(found[4].1, "`second_order` with kind = \"morris\": it belongs to \"saltelli\"");
    let found = keys(&LayoutDef { kind: LayoutKind::Saltelli, scramble: None, ..every.clone() }, &laws);
    assert_eq!(at(&found), ["replicates", "quantiles", "trajectories", "levels", "samples"]);
    assert_eq!(found[4].1, "`samples` = 100; allowed: a power of two: 64 or 128");
    assert_eq!(
        keys(&saltelli(1 << 24, true), &laws)[0].1,
        "`samples` = 16777216; allowed: 1 to 12500000 (100000000 points, 8 for each)"
    );
    assert!(keys(&LayoutDef::new(LayoutKind::Morris), &laws)[0].1.contains("`trajectories` is missing"));
    assert!(keys(&LayoutDef::new(LayoutKind::Saltelli), &laws)[0].1.contains("`samples` is missing"));
    assert_eq!(at(&keys(&LayoutDef { kind: LayoutKind::Sobol, ..every }, &laws))[..2], ["quantiles", "trajectories"]);
    // correlation, and a first point at infinity
    let pair = Pair { between: [0, 2], strength: Strength::Rank(0.5) };
    let copula = Copula::new(&names(3), &laws, &[pair]).unwrap();
    for def in [morris(10, 4), saltelli(8, false), LayoutDef { scramble: Some(false), ..saltelli(8, false) }] {
        let errors = SamplingLayout::new(&def, 7, &names(3), &laws, &copula).unwrap_err();
        assert_eq!(errors, [LayoutError::Correlated { kind: def.kind }]);
        assert!(errors[0].to_string().contains("changes one parameter at a time"));
    }
    let endless = [law("normal", &[("mean", 0.0), ("sd", 1.0)])];
    let plain = LayoutDef { scramble: Some(false), ..saltelli(8, false) };
    assert_eq!(at(&keys(&plain, &endless)), ["scramble"]);
    assert!(made(&saltelli(8, false), 7, &endless).is_ok());
}

#[test]
fn scale_takes_the_first_blocks() {
    let laws = uniforms(3, 0.0, 1.0);
    let (paths, pairs) = (made(&morris(30, 4), 1, &laws).unwrap(), made(&saltelli(64, true), 1, &laws).unwrap());
    assert_eq!(paths.clone().scaled(0.5).count(), 15 * 4);
    assert_eq!(paths.clone().scaled(1e-9).count(), 4);
    assert_eq!(pairs.clone().scaled(0.3).count(), 16 * 8);
    assert_eq!((paths.whole(11), pairs.whole(17), pairs.whole(7)), (8, 16, 0));
    assert_eq!(paths.notes(&Copula::independent(3)).len(), 1);
    assert!(!made(&LayoutDef { scramble: Some(false), ..saltelli(8, false) }, 1, &laws).unwrap().is_scrambled());
    assert!(pairs.is_scrambled());
}

#[test]
fn points_are_pinned() {
    // recorded once from this implementation: a change here changes the results of every study with such a design
    let laws = uniforms(3, 0.0, 1.0);
    let pairs = made(&saltelli(64, false), 7, &laws).unwrap();
    assert_ne!(point(&pairs, 37, 3), point(&made(&saltelli(64, false), 8, &laws).unwrap(), 37, 3));
    let found = [point(&pairs, 37, 3)[0].to_bits(), point(&pairs, 39, 3)[2].to_bits()];
    let paths = made(&morris(8, 4), 7, &laws).unwrap();
    let moves: Vec<(usize, bool)> =
        (8..16).filter_map(|index| paths.trajectories().unwrap().moved(index)).map(|m| (m.parameter, m.up)).collect();
    assert_eq!(found, PINNED);
    assert_eq!(moves, MOVES);
}

const PINNED: [u64; 2] = [0x3fe5_db35_99bd_bc79, 0x3fec_e1d9_78fd_23d3];
const MOVES: [(usize, bool); 6] = [(0, true), (2, false), (1, false), (2, false), (1, false), (0, false)];

/// Reads a study file with `design` as its `[design]`.
fn study(design: &str) -> Result<bladeoff_study::Study, bladeoff_study::StudyError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.toml");
    let text = format!(
        "schema = 1\nmodel = \"function\"\n[function]\ny = \"a + b\"\n[design]\n{design}\n\
         [[uncertain]]\nname = \"a\"\ndistribution = \"normal\"\nmean = 0\nsd = 1\n\
         [[uncertain]]\nname = \"b\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n"
    );
    std::fs::write(&path, text).expect("written");
    bladeoff_study::load(&path, |_| Vec::new())
}

#[test]
fn a_study_file_has_the_keys_of_both_designs() {
    let samples = |design: &str| {
        let study = study(design).unwrap_or_else(|error| panic!("{error:?}"));
        bladeoff_study::Samples::new(study, None, None).expect("samples").count()
    };
    assert_eq!(samples("kind = \"morris\"\ntrajectories = 20\nlevels = 6"), 60);
    assert_eq!(samples("kind = \"morris\"\ntrajectories = 20"), 60);
    assert_eq!(samples("kind = \"saltelli\"\nsamples = 64"), 256);
    assert_eq!(samples("kind = \"saltelli\"\nsamples = 64\nsecond_order = true"), 384);
    let wrong = |design: &str, words: &[&str]| {
        let Err(error) = study(design) else { panic!("{design} is refused") };
        let text = format!("{error} {error:?}");
        for word in words {
            assert!(text.contains(word), "{word}: {text}");
        }
    };
    wrong("kind = \"moris\"\ntrajectories = 20", &["morris"]);
    wrong("kind = \"morris\"\ntrajectorys = 20", &["trajectories", "design.trajectorys"]);
    wrong("kind = \"morris\"\ntrajectories = 20\nlevels = 3", &["design.levels", "an even number from 2 to 64"]);
    wrong("kind = \"saltelli\"\nsamples = 64\nsecond_order = 1", &["design.second_order", "true or false"]);
    wrong("kind = \"saltelli\"\nsamples = 60", &["a power of two: 32 or 64"]);
    wrong("kind = \"sobol\"\nsamples = 64\ntrajectories = 3", &["design.trajectories", "morris"]);
}

/// Samples go through an axis in turn: every second sample has one of the two values.
#[test]
fn values_that_follow_from_an_axis_are_all_found_in_a_large_study() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.toml");
    let text = "schema = 1\nmodel = \"function\"\n[function]\ny = \"a + d\"\n[design]\nkind = \"monte-carlo\"\nsamples = 100000\n\
         [[vary]]\nname = \"which\"\nvalues = [0, 1]\n\
         [[uncertain]]\nname = \"a\"\ndistribution = \"normal\"\nmean = 0\nsd = 1\n\
         [[derived]]\nname = \"d\"\nformula = \"10*which\"\n";
    std::fs::write(&path, text).expect("written");
    let study = bladeoff_study::load(&path, |_| Vec::new()).unwrap_or_else(|error| panic!("{error:?}"));
    let samples = bladeoff_study::Samples::new(study, None, None).expect("samples");
    assert_eq!(samples.count(), 200_000);
    let values = samples.different_values(16);
    let of = |name: &str| {
        let place = samples.parameters().iter().position(|one| one.info.path == name).expect("a parameter");
        values[place].len()
    };
    assert_eq!([of("which"), of("a"), of("d")], [2, 16, 2]);
}
