//! Coverage of the intervals of a comparison, over repeated studies with known differences.

use super::apart::{Rest, apart};
use super::draw::Draw;
use super::found::Interval;
use super::paired::{Pairs, difference};
use crate::estimate::scheme::Scheme;
use crate::tables::{ColumnHead, HeadKind};

const REPEATS: usize = 2000;

fn head() -> ColumnHead {
    ColumnHead { name: "g".into(), unit: String::new(), kind: HeadKind::Numbers }
}

/// Approximately normal numbers: sums of twelve uniform ones, from SplitMix64.
struct Numbers(u64);

impl Numbers {
    fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.even()).sum::<f64>() - 6.0
    }
}

/// Share of the repetitions whose interval contains the true value.
fn coverage(truth: f64, mut repeat: impl FnMut(&mut Numbers) -> Interval) -> f64 {
    let mut numbers = Numbers(7);
    let holds =
        |found: Interval| found.low.is_some_and(|low| low <= truth) && found.high.is_some_and(|high| truth <= high);
    (0..REPEATS).filter(|_| holds(repeat(&mut numbers))).count() as f64 / REPEATS as f64
}

fn paired(a: &[f64], b: &[f64], rows_per_point: u64) -> Interval {
    let rows: Vec<(usize, usize)> = (0..a.len()).map(|row| (row, row)).collect();
    let samples: Vec<u64> = (0..a.len() as u64).collect();
    let points = a.len() / rows_per_point as usize;
    let draw = Draw::whole(Scheme::Independent, rows_per_point, vec![0; points]);
    let clusters = draw.clusters(samples.iter().copied());
    difference(&head(), a, b, &Pairs { rows: &rows, samples: (&samples, &samples), clusters: &clusters }).mean
}

#[test]
fn a_mean_difference_is_held_as_often_as_said() {
    let share = coverage(0.3, |numbers| {
        let a: Vec<f64> = (0..30).map(|_| 10.0 * numbers.normal()).collect();
        let b: Vec<f64> = a.iter().map(|a| a + 0.3 + numbers.normal()).collect();
        paired(&a, &b, 1)
    });
    assert!((0.935..0.965).contains(&share), "{share}");
}

#[test]
fn rows_of_a_point_that_move_together_are_no_more_than_points() {
    let moves = |numbers: &mut Numbers| -> Vec<f64> {
        (0..30).flat_map(|_| [numbers.normal(); 4]).collect::<Vec<_>>().iter().map(|common| 0.3 + common).collect()
    };
    let zeros = vec![0.0; 120];
    let share = coverage(0.3, |numbers| paired(&zeros, &moves(numbers), 4));
    assert!((0.935..0.965).contains(&share), "{share}");
    // treating the rows as independent gives far too narrow intervals
    let share = coverage(0.3, |numbers| paired(&zeros, &moves(numbers), 1));
    assert!(share < 0.8, "{share}");
}

fn two(a: &[f64], b: &[f64]) -> super::found::Apart {
    let side = |values: &[f64]| {
        let rows: Vec<usize> = (0..values.len()).collect();
        let draw = Draw::whole(Scheme::Independent, 1, vec![0; values.len()]);
        (draw.clusters(0..values.len() as u64), rows)
    };
    let ((of_a, rows_a), (of_b, rows_b)) = (side(a), side(b));
    let samples: Vec<u64> = (0..a.len().max(b.len()) as u64).collect();
    let rest_a = Rest { rows: &rows_a, samples: &samples, is_ok: &|_| true, clusters: &of_a };
    let rest_b = Rest { rows: &rows_b, samples: &samples, is_ok: &|_| true, clusters: &of_b };
    apart(&head(), (a, &rest_a), (b, &rest_b))
}

#[test]
fn two_samples_are_held_however_they_depend_on_one_another() {
    let alone = |numbers: &mut Numbers| -> Vec<f64> { (0..60).map(|_| numbers.normal()).collect() };
    let independent = |numbers: &mut Numbers| (alone(numbers), alone(numbers));
    let opposed = |numbers: &mut Numbers| {
        let a = alone(numbers);
        let b: Vec<f64> = a.iter().map(|a| -a).collect();
        (a, b)
    };
    let alike = |numbers: &mut Numbers| {
        let a = alone(numbers);
        let b: Vec<f64> = a.iter().map(|a| a + 0.1 * numbers.normal()).collect();
        (a, b)
    };
    type Drawn<'a> = &'a dyn Fn(&mut Numbers) -> (Vec<f64>, Vec<f64>);
    let drawn: [Drawn<'_>; 3] = [&independent, &opposed, &alike];
    for (at, draw) in drawn.into_iter().enumerate() {
        let share = coverage(0.0, |numbers| {
            let (a, b) = draw(numbers);
            two(&a, &b).mean
        });
        assert!((0.93..0.97).contains(&share), "mean {at}: {share}");
        let share = coverage(0.0, |numbers| {
            let (a, b) = draw(numbers);
            two(&a, &b).quantiles.swap_remove(0).difference
        });
        assert!(share >= 0.94, "median {at}: {share}");
    }
}

/// Studies with the same seed: limits that allowed any dependence between the studies were 10 and 6 times as wide.
#[test]
fn studies_of_one_seed_are_compared_point_by_point() {
    let mut numbers = Numbers(3);
    let a: Vec<f64> = (0..1000).map(|_| numbers.normal()).collect();
    let b: Vec<f64> = a.iter().map(|a| a + 0.5 + 0.1 * numbers.normal()).collect();
    let found = two(&a, &b);
    let width = |of: &Interval| of.high.zip(of.low).map(|(high, low)| high - low).expect("limits");
    // Student's t of the differences
    let t = width(&paired(&a, &b, 1));
    assert!((0.9..1.1).contains(&(width(&found.mean) / t)), "{} {t}", width(&found.mean));
    assert!(width(&found.quantiles[0].difference) < 0.08, "{:?}", found.quantiles[0]);
}

#[test]
fn a_bad_row_bounds_no_quantile_of_few_and_moves_no_mean() {
    let values: Vec<f64> = (0..60).map(f64::from).collect();
    let rows: Vec<usize> = (0..60).collect();
    let draw = Draw::whole(Scheme::Independent, 1, vec![0; 60]);
    let clusters = draw.clusters(0..60);
    let samples: Vec<u64> = (0..60).collect();
    let good = Rest { rows: &rows, samples: &samples, is_ok: &|_| true, clusters: &clusters };
    // two thirds of B have no value
    let bad = Rest { rows: &rows, samples: &samples, is_ok: &|row| row % 3 == 0, clusters: &clusters };
    let found = apart(&head(), (&values, &good), (&values, &bad));
    assert_eq!((found.values_b, found.bad_b, found.mean.estimate), (20, 40, Some(28.5 - 29.5)));
    let median = &found.quantiles[0];
    assert_eq!((median.difference.low, median.difference.high), (None, None), "the median may be anything");
}
