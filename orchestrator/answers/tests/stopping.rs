//! Stopping rules: end of a study with a required precision.

use bladeoff_answers::estimate::figures::{Figures, Method};
use bladeoff_answers::estimate::proportion::{Tally, proportion};
use bladeoff_answers::estimate::scheme::Scheme;
use bladeoff_answers::stop::{Hindrance, InterimAnalysis, Precision, StopRule, expected, half_width, interim_analyses};
use bladeoff_system::random::{SplitMix, finaliser};

const ALPHA: f64 = 0.05;
const RELATIVE: StopRule = StopRule { half_width: None, relative: Some(0.1), samples: None };

/// Probability with these numbers of events and bad runs.
fn share(n: u64, events: u64, bad: u64, alpha: f64) -> Figures {
    proportion(&[Tally { n, low: events, high: events + bad }], &Scheme::Independent, alpha)
}

/// The interim analysis at which a study with these events ends after `done` points, and whether it is precise enough there; `None` if it
/// continues. Second: points of the analyses.
fn stand(rule: &StopRule, events: &[bool], done: u64) -> (Option<(InterimAnalysis, bool)>, Vec<u64>) {
    let mut seen = Vec::new();
    for look in
        interim_analyses(rule.end(events.len() as u64), ALPHA).into_iter().take_while(|look| look.points <= done)
    {
        let count = events[..look.points as usize].iter().filter(|event| **event).count();
        let enough = rule.asks_for_width() && {
            seen.push(look.points);
            rule.is_enough(&[share(look.points, count as u64, 0, ALPHA)])
        };
        if enough || look.is_last {
            return (Some((look, enough)), seen);
        }
    }
    (None, seen)
}

fn events(seed: u64, count: usize, p: f64) -> Vec<bool> {
    let mut random = SplitMix(finaliser(seed.wrapping_add(0x5eed)));
    (0..count).map(|_| random.unit() < p).collect()
}

#[test]
fn looks_double_and_spend_alpha_once() {
    let found = interim_analyses(3000, 0.05);
    let points: Vec<u64> = found.iter().map(|look| look.points).collect();
    assert_eq!(points, [256, 512, 1024, 2048, 3000]);
    let levels: Vec<f64> = found.iter().map(|look| look.alpha).collect();
    assert_eq!(levels, [0.025, 0.0125, 0.00625, 0.003125, 0.003125]);
    assert!((levels.iter().sum::<f64>() - 0.05).abs() < 1e-15);
    assert!(found.iter().filter(|look| look.is_last).count() == 1 && found[4].is_last);
    // the end is not analysed twice
    assert_eq!(interim_analyses(512, 0.05).iter().map(|look| look.points).collect::<Vec<_>>(), [256, 512]);
    assert_eq!(interim_analyses(100, 0.05), [InterimAnalysis { points: 100, alpha: 0.05, is_last: true }]);
}

#[test]
fn the_first_look_that_is_precise_enough_decides_whatever_is_done_beyond() {
    let events = events(5, 1 << 15, 0.3);
    let (Some((end, true)), _) = stand(&RELATIVE, &events, 1 << 15) else { panic!("precise enough") };
    assert!(end.points > 512 && end.points < 1 << 14 && !end.is_last, "{end:?}");
    for done in (0..1u64 << 15).step_by(301) {
        let (found, seen) = stand(&RELATIVE, &events, done);
        assert_eq!(found, (done >= end.points).then_some((end, true)), "{done}");
        assert!(seen.iter().all(|points| *points <= end.points), "later looks are not looked at");
    }
    // the plain 95 % interval meets the requirement
    let of_first = |points: u64| {
        let count = events[..points as usize].iter().filter(|event| **event).count() as u64;
        share(points, count, 0, ALPHA)
    };
    let found = of_first(end.points);
    let half = 0.5 * (found.high.unwrap() - found.low.unwrap());
    assert!(half <= 0.1 * found.estimate.unwrap());
    let before = of_first(end.points / 2);
    assert!(matches!(RELATIVE.precision(&before), Precision::Wide { half, wanted } if half > wanted));
}

#[test]
fn every_width_that_is_given_holds_and_samples_end_it() {
    let rule = StopRule { half_width: Some(0.05), relative: Some(0.1), samples: None };
    assert_eq!((rule.wanted(0.9), rule.wanted(0.2)), (Some(0.05), Some(0.2 * 0.1)));
    let events = events(7, 4000, 0.01);
    let tight = StopRule { half_width: Some(1e-6), relative: None, samples: Some(1000) };
    let (found, seen) = stand(&tight, &events, 4000);
    assert_eq!(seen, [256, 512, 1000]);
    assert!(matches!(found, Some((look, false)) if look.points == 1000 && look.is_last));
    let only = StopRule { samples: Some(700), ..StopRule::default() };
    let (found, seen) = stand(&only, &events, 4000);
    assert!(matches!(found, Some((look, false)) if look.points == 700) && seen.is_empty(), "{seen:?}");
    assert_eq!(stand(&only, &events, 699).0, None);
    assert_eq!(stand(&StopRule { half_width: Some(0.4), ..StopRule::default() }, &events, 300).1, [256]);
    assert!(!only.is_enough(&[]), "nothing is not precise");
}

#[test]
fn bad_runs_and_figures_without_an_interval_are_told_apart() {
    let rule = StopRule { half_width: Some(0.02), ..StopRule::default() };
    assert_eq!(rule.precision(&share(4000, 400, 0, 0.05)), Precision::Enough);
    assert_eq!(rule.precision(&share(4000, 400, 400, 0.05)), Precision::BadRuns);
    assert!(matches!(rule.precision(&share(400, 40, 0, 0.05)), Precision::Wide { .. }));
    assert_eq!(rule.precision(&Figures::over(100)), Precision::NoInterval);
    let open = Figures { estimate: Some(1.0), statistical: Some(0.01), ..Figures::over(100) };
    assert_eq!(rule.precision(&open), Precision::BadRuns);
    // a relative width is not possible for a figure of 0
    assert!(matches!(RELATIVE.precision(&share(4000, 0, 0, 0.05)), Precision::Wide { wanted: 0.0, .. }));
}

#[test]
fn what_no_further_point_makes_precise_is_told_from_what_is_only_wide() {
    let rule = StopRule { half_width: Some(0.02), ..StopRule::default() };
    assert_eq!(rule.hindrance(&share(4000, 400, 0, 0.05), 0, 0.05), None, "precise enough");
    assert_eq!(
        rule.hindrance(&share(100, 10, 1, 0.05), 1, 0.05),
        None,
        "wide, and one bad run in a hundred leaves half a per cent"
    );
    let Some(Hindrance::BadRuns { open: Some(open), wanted: 0.02, is_sure: true }) =
        rule.hindrance(&share(400, 40, 40, 0.05), 40, 0.05)
    else {
        panic!("a tenth of the runs is bad")
    };
    assert!((open - 0.05).abs() < 0.01, "{open}");
    // a mean without limits; the same figure without bad runs only has no interval yet
    let mean = Figures { estimate: Some(1.0), statistical: Some(0.5), ..Figures::over(100) };
    assert_eq!(rule.hindrance(&mean, 1, 0.05), Some(Hindrance::BadRuns { open: None, wanted: 0.02, is_sure: true }));
    // the share of so few bad runs is uncertain: half a per cent would suffice
    let strict = StopRule { half_width: Some(0.005), ..StopRule::default() };
    let few = strict.hindrance(&share(512, 0, 4, 0.0125), 4, 0.0125);
    assert!(
        matches!(few, Some(Hindrance::BadRuns { open: Some(open), is_sure: false, .. }) if open > 0.005),
        "{few:?}"
    );
    assert_eq!(strict.precision(&share(1 << 16, 0, 328, 1e-4)), Precision::Enough, "half a per cent of bad runs");
    let many = strict.hindrance(&share(8192, 480, 160, 0.001), 160, 0.001);
    assert!(matches!(many, Some(Hindrance::BadRuns { is_sure: true, .. })), "{many:?}");
    assert_eq!(rule.hindrance(&mean, 0, 0.05), None);
    assert_eq!(rule.hindrance(&Figures::over(100), 0, 0.05), Some(Hindrance::NoNumber));
    assert_eq!(RELATIVE.hindrance(&share(4000, 0, 0, 0.05), 0, 0.05), Some(Hindrance::Zero));
    // a parameter without effect has an index of 0 in every resample: fully precise
    let index = Figures {
        estimate: Some(0.0),
        harmful: Some(0.0),
        low: Some(0.0),
        high: Some(0.0),
        statistical: Some(0.0),
        ..Figures::over(64)
    };
    assert_eq!(RELATIVE.hindrance(&index, 0, 0.05), None);
}

#[test]
fn a_forecast_is_what_comes_at_the_same_rates() {
    let at = (1024, 1 << 14);
    // exact limits with proportionally more events and bad runs
    let found = half_width(&share(1024, 30, 0, ALPHA), ALPHA, at).expect("a forecast");
    let real = share(1 << 14, 480, 0, ALPHA);
    assert!((found - 0.5 * (real.high.unwrap() - real.low.unwrap())).abs() < 1e-15);
    // no event: the limit decreases with the number of points, not with its root
    let none = half_width(&share(1024, 0, 0, ALPHA), ALPHA, at).expect("a forecast");
    assert!((none - 0.5 * share(1 << 14, 0, 0, ALPHA).high.unwrap()).abs() < 1e-15);
    // the widening by bad runs remains
    let open = half_width(&share(1024, 30, 100, ALPHA), ALPHA, at).expect("a forecast");
    assert!(open - found > 0.4 * 100.0 / 1024.0, "{open} {found}");
    // a mean: the half width decreases with the root of the number of points
    let mean = Figures {
        estimate: Some(1.0),
        low: Some(0.9),
        high: Some(1.1),
        statistical: Some(0.2),
        method: Method::Student,
        ..Figures::over(1024)
    };
    let half = half_width(&mean, ALPHA, at).expect("a forecast");
    assert!((half - 0.1 / 4.0).abs() < 1e-12, "{half}");
    assert_eq!(half_width(&Figures::over(3), ALPHA, at), None);
}

#[test]
fn the_look_that_is_expected_is_about_the_one_that_comes() {
    let mut off = Vec::new();
    let analyses: Vec<u64> = interim_analyses(1 << 16, ALPHA).iter().map(|look| look.points).collect();
    let now = analyses[2];
    for seed in 0..20 {
        let events = events(100 + seed, 1 << 16, 0.05);
        let Some((end, true)) = stand(&RELATIVE, &events, 1 << 16).0 else { panic!("precise enough") };
        let count = events[..now as usize].iter().filter(|event| **event).count() as u64;
        let found = expected(&RELATIVE, &[(share(now, count, 0, ALPHA), ALPHA)], now, &analyses).expect("an analysis");
        assert!(end.points > now);
        off.push(libm::log2(found as f64 / end.points as f64).abs());
    }
    assert!(off.iter().all(|off| *off <= 1.0) && off.iter().sum::<f64>() < 15.0, "{off:?}");
    // never reached
    assert_eq!(expected(&RELATIVE, &[(share(now, 100, 900, ALPHA), ALPHA)], now, &analyses), None);
}
