//! Smoothed maps with bad runs: they affect only the places near them.

use super::maps::{Rows, known, of_z, over, scattered};
use bladeoff_answers::estimate::formula::Formula;
use bladeoff_answers::estimate::input::Label;
use bladeoff_answers::map::{Of, Wanted};
use bladeoff_model::outcome::Status;
use bladeoff_numerics::probability::normal_quantile;

/// Only bad runs could be harmful, and all of them are in one corner: their share rises there and is not spread over the map.
#[test]
fn bad_runs_are_not_smeared_over_a_smoothed_map() {
    let in_corner = |x: f64, y: f64| x < 0.25 && y < 0.25;
    let mut rows = scattered(1200, |_, _, _| 0.0);
    let mut bad = 0;
    for row in 0..rows.status.len() {
        if in_corner(rows.x[row].expect("given"), rows.y[row].expect("given")) {
            (rows.status[row], rows.z[row]) = (Status::Failed, None);
            bad += 1;
        }
    }
    assert!(bad > 40, "{bad} bad runs");
    let map = &rows.maps(&Wanted { of: over(0.5), ..of_z(false) })[0];
    assert!(map.width.is_some_and(|width| width < 0.3), "{:?}", map.width);
    let (mut inside, mut outside) = (0, 0);
    for cell in &map.cells {
        let harmful = cell.estimate_if_bad_harmful.expect("a share");
        assert_eq!(cell.estimate, Some(0.0));
        if cell.x < 0.15 && cell.y < 0.15 {
            assert!(harmful > 0.9 && cell.high > Some(0.95) && cell.low < Some(0.2), "{cell:?}");
            inside += 1;
        } else if cell.x > 0.6 || cell.y > 0.6 {
            // few samples lie within so narrow a window, and the limits are accordingly wide: 0 events in about five; with fewer there is no limit
            let is_unknown = (cell.low, cell.high) == (Some(0.0), Some(1.0));
            assert!(harmful < 1e-9 && (cell.high < Some(0.7) || is_unknown), "{cell:?}");
            outside += u32::from(!is_unknown);
        }
    }
    assert!(inside > 3 && outside > 100, "{inside} {outside}");
}

/// A smoothed difference where both runs of a pair are bad has equal estimates but is open; far from such pairs it is not.
#[test]
fn a_smoothed_difference_is_open_where_both_runs_are_bad() {
    let points = scattered(800, |_, _, _| 0.0);
    let mut rows = Rows { points: Some(800), ..Rows::default() };
    for (x, y) in points.x.iter().zip(&points.y) {
        let place = (x.expect("given"), y.expect("given"));
        rows.add(place, 0.0, "a", 0.0);
        rows.add(place, 0.0, "b", 0.0);
    }
    for row in 0..1600 {
        if rows.x[row].is_some_and(|x| x > 0.7) {
            (rows.status[row], rows.z[row]) = (Status::Failed, None);
        }
    }
    let pair = [Label::Word("a".into()), Label::Word("b".into())];
    let wanted =
        Wanted { of: over(0.5), panels: vec!["way".into()], paired: Some(("way".into(), vec![pair])), ..of_z(false) };
    let found = rows.maps(&wanted);
    let map = found.iter().find(|map| map.difference.is_some()).expect("a difference");
    assert!(map.bad > 100, "{}", map.bad);
    let of = |is: fn(f64) -> bool| map.cells.iter().filter(move |cell| is(cell.x));
    assert!(of(|x| x > 0.75).count() > 20 && of(|x| x > 0.75).all(|cell| map.is_unsure(cell)));
    assert!(of(|x| x < 0.3).count() > 20 && of(|x| x < 0.3).all(|cell| !map.is_unsure(cell)));
}

/// The regime of a place is that of the nearest runs, regardless of the smoothing width.
#[test]
fn regimes_are_those_of_the_nearest_runs() {
    // noise requires a large width; free in the left third, heavy beyond
    let mut rows = scattered(900, |_, _, u| 2.0 + u);
    for row in 0..900 {
        let is_free = rows.x[row].is_some_and(|x| x < 0.3);
        rows.regime[row] = Some(if is_free { "free" } else { "heavy" }.to_owned());
    }
    let map = &rows.maps(&of_z(false))[0];
    assert!(map.width.is_some_and(|width| width > 0.7), "{:?}", map.width);
    let wrong = map.cells.iter().filter(|cell| {
        let is_free = cell.regime.as_deref() == Some("free");
        (cell.x < 0.26 && !is_free) || (cell.x > 0.34 && is_free)
    });
    assert_eq!((wrong.count(), map.cells.len() > 1000), (0, true));
}

/// The values of failed runs are unknown: within one smoothing width of such a run a mean has no limits and is that of the other runs.
#[test]
fn a_smoothed_mean_near_bad_runs_has_no_limits() {
    let mut rows = scattered(2000, |x, y, u| (20.0 * x).sin() + 0.5 * y + 0.2 * u);
    for row in 0..2000 {
        if rows.x[row].is_some_and(|x| x > 0.8) && row % 3 == 0 {
            (rows.status[row], rows.z[row]) = (Status::Failed, None);
        }
    }
    let map = &rows.maps(&of_z(false))[0];
    let width = map.width.expect("smoothed");
    assert!(map.bad > 50 && width < 0.6, "{} {width}", map.bad);
    let (mut near, mut far, mut few) = (0, 0, 0);
    for cell in &map.cells {
        if cell.x > 0.82 {
            assert_eq!((cell.low, cell.high, cell.estimate_if_bad_harmful), (None, None, None), "{cell:?}");
            near += 1;
        } else if cell.x < 0.78 - width && cell.low.is_none() {
            // at edges, where the window contains too few samples
            few += 1;
        } else if cell.x < 0.78 - width {
            assert!(cell.low.is_some() && cell.high.is_some() && cell.estimate_if_bad_harmful == cell.estimate);
            far += 1;
        }
    }
    assert!(near > 50 && far > 50 && 10 * few < far, "{near} {far} {few}");
    assert!(map.notes.iter().any(|note| note.contains("without limits")), "{:?}", map.notes);
}

/// Limits of a share along a smooth edge; limits from the full width would hold in 84 of 100 cells.
#[test]
fn limits_hold_along_a_smooth_edge() {
    let share = |x: f64, y: f64| 1.0 / (1.0 + (-4.0 * (2.0 * x + y - 1.5)).exp());
    let (mut held, mut of) = (0, 0);
    for count in [800, 2400] {
        let rows = scattered(count, |x, y, u| if u < share(x, y) { 2.0 } else { 0.0 });
        let map = &rows.maps(&Wanted { of: over(1.0), ..of_z(false) })[0];
        let is_inside = |truth: f64, low: Option<f64>, high: Option<f64>| low <= Some(truth) && Some(truth) <= high;
        held += map.cells.iter().filter(|cell| is_inside(share(cell.x, cell.y), cell.low, cell.high)).count();
        of += map.cells.len();
    }
    assert!(of > 2000 && held as f64 > 0.9 * of as f64, "{held} of {of}");
}

/// Sparse towards the edges (sums of uniform numbers), few, uneven samples: sparse places are drawn with a wider window and without limits.
#[test]
fn samples_are_drawn_where_they_lie() {
    for count in [10, 16, 64, 256, 2000] {
        let draws = scattered(4 * count, |_, _, _| 0.0);
        let mut rows = Rows { points: Some(count), ..Rows::default() };
        let sum = |of: &[Option<f64>], at: usize| (0..4).filter_map(|k| of[4 * at + k]).sum::<f64>().powi(3);
        for at in 0..count {
            let (x, y) = (sum(&draws.x, at), sum(&draws.y, at));
            rows.add((x, y), 0.0, "a", 40.0 * (0.3 * x).sin() + y);
        }
        let map = &rows.maps(&of_z(false))[0];
        let drawn: u64 = map.cells.iter().map(|cell| cell.n).sum();
        assert_eq!((drawn, map.undrawn), (count as u64, Some(0)), "{count}: width {:?}", map.width);
        assert!(map.cells.iter().all(|cell| cell.estimate.is_some_and(f64::is_finite)));
        let without = map.cells.iter().filter(|cell| cell.low.is_none()).count();
        assert!(without > 0 && map.lacks_limits(), "{count}");
        let (least, most) = map.runs.expect("values");
        assert_eq!(rows.z.iter().flatten().copied().fold(f64::INFINITY, f64::min), least);
        assert_eq!(rows.z.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max), most);
        let share = &rows.maps(&Wanted { of: over(50.0), ..of_z(false) })[0];
        assert_eq!((share.cells.iter().map(|cell| cell.n).sum::<u64>(), share.runs), (count as u64, None));
    }
}

/// Four given values of y, each with the same four random x: y is drawn value by value, and a plane is reproduced.
#[test]
fn given_values_are_columns_beside_few_random_ones() {
    let mut rows = Rows { points: Some(4), ..Rows::default() };
    for x in [0.1, 0.43, 0.52, 0.97] {
        for y in [0.0, 0.25, 0.75, 1.0] {
            rows.add((x, y), 0.0, "a", 100.0 - 100.0 * y + 7.0 * x);
        }
    }
    let map = &rows.maps(&Wanted { varied: (false, true), ..of_z(false) })[0];
    assert_eq!(map.y.at, [0.0, 0.25, 0.75, 1.0]);
    assert_eq!((map.cells.iter().map(|cell| cell.n).sum::<u64>(), map.undrawn), (16, Some(0)));
    for cell in &map.cells {
        let off = cell.estimate.expect("a number") - (100.0 - 100.0 * cell.y + 7.0 * cell.x);
        assert!(off.abs() < 1e-9, "{cell:?}");
    }
    assert!(map.cells.len() == map.x.at.len() * 4);
    // four samples with scatter do not determine limits
    rows.z.iter_mut().enumerate().for_each(|(at, z)| *z = z.map(|z| z + ((at * 7919) % 11) as f64));
    let map = &rows.maps(&Wanted { varied: (false, true), ..of_z(false) })[0];
    assert!(map.lacks_limits() && map.cells.iter().all(|cell| cell.low.is_none() && cell.high.is_none()));
}

/// Runs in cells that are not drawn are reported and counted: failed runs far from any run with a value.
#[test]
fn samples_that_are_not_drawn_are_counted() {
    let mut rows = scattered(400, |x, _, _| x);
    let mut gone = 0;
    for row in 0..400 {
        if rows.x[row].is_some_and(|x| x > 0.7) {
            (rows.status[row], rows.z[row]) = (Status::Failed, None);
            gone += 1;
        }
    }
    let map = &rows.maps(&of_z(false))[0];
    let drawn: u64 = map.cells.iter().map(|cell| cell.n).sum();
    let undrawn = map.undrawn.expect("smoothed");
    assert!(undrawn > 20 && undrawn < gone && drawn + undrawn == 400, "{undrawn} of {gone}");
    let told = format!("{undrawn} of 400 runs lie in cells that are not drawn");
    assert!(map.notes.iter().any(|note| note.contains(&told)), "{:?}", map.notes);
}

/// Bad runs in which the event is known do not leave a difference of shares open.
#[test]
fn a_difference_of_known_events_is_not_open() {
    let mut rows = Rows::default();
    for x in [0.0, 1.0] {
        for y in [0.0, 1.0] {
            rows.add((x, y), 0.0, "a", 1.0);
            rows.add((x, y), 0.0, "b", 2.0);
        }
    }
    (rows.status[0], rows.z[0]) = (Status::Failed, None);
    let difference = |text: &str| {
        let pair = [Label::Word("b".into()), Label::Word("a".into())];
        let of = Of::Probability(Formula::condition(text, &known()).expect("a condition"));
        let paired = Some(("way".into(), vec![pair]));
        let found = rows.maps(&Wanted { of, panels: vec!["way".into()], paired, ..of_z(true) });
        let map = found.into_iter().find(|map| map.difference.is_some()).expect("a difference");
        (map.bad, map.cells.iter().filter(|cell| map.is_unsure(cell)).count())
    };
    // the inputs of a bad run are known, its results are not
    assert_eq!((difference("x > 0.5"), difference("z > 0.5")), ((1, 0), (1, 1)));
}

/// Number of cells whose limits contain the true mean of noise on a plane, number of cells with limits, and whether skewness was reported.
fn held_of_noise(seed: u64, samples: usize, noise: &dyn Fn(f64) -> f64) -> (usize, usize, bool) {
    let mut random = bladeoff_system::random::SplitMix(seed);
    let mut rows = Rows { points: Some(samples), ..Rows::default() };
    for _ in 0..samples {
        let (x, y, u) = (random.unit(), random.unit(), random.unit());
        rows.add((x, y), 0.0, "a", x + 0.5 * y + noise(u));
    }
    let map = &rows.maps(&of_z(false))[0];
    let ends = map.cells.iter().filter_map(|cell| Some((cell.x + 0.5 * cell.y, cell.low?, cell.high?)));
    let (held, of) =
        ends.fold((0, 0), |(held, of), (mean, low, high)| (held + usize::from(low <= mean && mean <= high), of + 1));
    (held, of, map.notes.iter().any(|note| note.contains("the values are skewed")))
}

/// Limits of normal noise hold and have no note; limits of lognormal noise hold less often, and a note reports it.
/// All noise has mean 0 and standard deviation 1. `COVERAGE_STUDIES=40` gives the numbers in the documentation.
#[test]
fn skewed_noise_of_a_smoothed_map_is_reported() {
    let studies = std::env::var("COVERAGE_STUDIES").map_or(3, |word| word.parse().expect("a number"));
    let lognormal = |s: f64| {
        let (mean, deviation) = ((0.5 * s * s).exp(), ((s * s).exp() * ((s * s).exp() - 1.0)).sqrt());
        move |u: f64| ((s * normal_quantile(u, 1.0 - u)).exp() - mean) / deviation
    };
    let exponential = |u: f64| -(1.0 - u).ln() - 1.0;
    let normal = |u: f64| normal_quantile(u, 1.0 - u);
    type Noise<'a> = (&'a str, Box<dyn Fn(f64) -> f64>);
    let noises: [Noise<'_>; 5] = [
        ("normal", Box::new(normal)),
        ("exponential", Box::new(exponential)),
        ("lognormal 0.5", Box::new(lognormal(0.5))),
        ("lognormal 1", Box::new(lognormal(1.0))),
        ("lognormal 1.5", Box::new(lognormal(1.5))),
    ];
    for samples in [100, 300, 1000] {
        for (name, noise) in &noises {
            let (mut held, mut of, mut noted) = (0, 0, 0);
            for seed in 0..studies {
                let one = held_of_noise(1000 * samples as u64 + seed, samples, noise);
                (held, of, noted) = (held + one.0, of + one.1, noted + u64::from(one.2));
            }
            let share = held as f64 / of as f64;
            println!(
                "{samples} samples, {name} noise: {:.1} of 100 cells held, a note in {noted} of {studies}",
                100.0 * share
            );
            match *name {
                "normal" => assert!(share > 0.85 && noted == 0, "{samples}: {share} {noted}"),
                "lognormal 1.5" => assert!(10 * noted >= 9 * studies, "{samples}: {share} {noted}"),
                _ => {}
            }
        }
    }
}
