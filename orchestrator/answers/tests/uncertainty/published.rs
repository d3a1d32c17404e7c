//! Published small probabilities, through studies of functions: events where g < 0.
//!
//! RP22, four branches, R - S with correlated terms and RP107, with the values that numerical integration gives.

use crate::support::asked;
use crate::support::made::{Made, points_of};
use bladeoff_answers::ask::{Answer, QuestionDef, answer};
use bladeoff_answers::estimate::input::DesignKind;
use bladeoff_model::probability::normal_quantile;

fn rp22(x: &[f64]) -> f64 {
    2.5 - (x[0] + x[1]) / 2f64.sqrt() + 0.1 * (x[0] - x[1]) * (x[0] - x[1])
}

fn four_branch(x: &[f64]) -> f64 {
    let (difference, sum) = (x[0] - x[1], (x[0] + x[1]) / 2f64.sqrt());
    let bent = 3.0 + 0.1 * difference * difference;
    (bent - sum).min(bent + sum).min(7.0 / 2f64.sqrt() - difference.abs())
}

/// R ~ N(4, 1), S ~ N(2, 1), correlation 0.5.
fn load(x: &[f64]) -> f64 {
    let (r, s) = (4.0 + x[0], 2.0 + 0.5 * x[0] + 0.75f64.sqrt() * x[1]);
    r - s
}

fn rp107(x: &[f64]) -> f64 {
    5.0 * 10f64.sqrt() - x.iter().sum::<f64>()
}

/// Points of a design in the normal space.
fn normal(kind: DesignKind, dimensions: usize, replicates: usize, samples: usize) -> Vec<Vec<f64>> {
    let points = points_of(kind, 20261122, dimensions, replicates, samples);
    points.iter().map(|point| point.iter().map(|&u| normal_quantile(u, 1.0 - u)).collect()).collect()
}

fn found(g: fn(&[f64]) -> f64, points: &[Vec<f64>], kind: DesignKind, replicates: usize, confidence: f64) -> Answer {
    let mut made = Made::new(vec![("y", points.iter().map(|x| Some(g(x))).collect())]);
    made.replicate = (0..points.len()).map(|point| (point % replicates) as u32).collect();
    (made.kind, made.replicates) = (kind, replicates);
    let confidence = Some(confidence);
    let def = QuestionDef { probability: Some("y < 0".into()), confidence, ..QuestionDef::default() };
    answer(&made.study(), &asked(def)).expect("an answer").answers.remove(0)
}

/// Twelve intervals of 95 % would miss one in every other run of other seeds: those of 99.9 % are asked to hold.
#[test]
fn intervals_hold_the_published_values() {
    let problems: [(&str, fn(&[f64]) -> f64, f64); 3] = [
        ("RP22", rp22, 4.207305511300e-3),
        ("four-branch", four_branch, 2.222795066194e-3),
        ("R - S", load, 2.275013194818e-2),
    ];
    for (kind, replicates, samples) in [
        (DesignKind::MonteCarlo, 1, 1 << 17),
        (DesignKind::Sobol, 32, 1 << 12),
        (DesignKind::LatinHypercube, 32, 1 << 12),
        (DesignKind::Halton, 32, 1 << 12),
    ] {
        let points = normal(kind, 2, replicates, samples);
        for (name, g, truth) in problems {
            let usual = found(g, &points, kind, replicates, 0.95);
            let found = found(g, &points, kind, replicates, 0.999);
            let (low, high) = (found.low.expect("a limit"), found.high.expect("a limit"));
            let (estimate, error) =
                (found.estimate.expect("a number"), found.estimate.expect("a number") / truth - 1.0);
            let (from, to) = (usual.low.expect("a limit"), usual.high.expect("a limit"));
            let word = kind.word();
            println!(
                "{name:12} {word:16} {estimate:.4e} ({:+.1} %), 95 % {from:.4e} .. {to:.4e}, {truth:.4e}",
                100.0 * error
            );
            assert!(low <= truth && truth <= high, "{name} {word}: {low} {truth} {high}");
            assert!(high - low < 0.5 * truth, "{name} {word}");
        }
    }
}

#[test]
fn few_events_are_contained() {
    let points = normal(DesignKind::MonteCarlo, 10, 1, 100_000);
    let found = found(rp107, &points, DesignKind::MonteCarlo, 1, 0.95);
    assert!(found.low.unwrap() <= 2.866515718792e-7 && 2.866515718792e-7 <= found.high.unwrap(), "{found:?}");
    assert!(found.high.unwrap() > 0.0 && found.high.unwrap() < 1e-4);
}
