//! Rows in a stream of pieces are answered as rows in memory, to the last bit.

use super::support::made::Made;
use super::support::{asked, exceedance, made, mean, probability, quantile, replicated};
use bladeoff_answers::ask::{Question, Streamed, Whole, answer_each};
use bladeoff_answers::estimate::input::{Cells, Column, Design, DesignKind, Study};
use std::ops::Range;

/// Rows of a study, with the points that they belong to.
fn piece<'a>(study: &Study<'a>, rows: Range<usize>) -> Study<'a> {
    let groups = study.groups.len();
    let column = |column: &Column<'a>| {
        let cells = match column.cells {
            Cells::Numbers(values, nature) => {
                Cells::Numbers(&values[rows.clone()], nature.with(|held| &held[rows.clone()]))
            }
            Cells::Words(words, list) => Cells::Words(&words[rows.clone()], list),
        };
        Column { name: column.name.clone(), unit: column.unit.clone(), cells, unjudged: column.unjudged }
    };
    Study {
        columns: study.columns.iter().map(column).collect(),
        status: &study.status[rows.clone()],
        causes: &study.causes[rows.clone()],
        ends: &study.ends[rows.clone()],
        groups: study.groups.clone(),
        design: Design {
            replicate: &study.design.replicate[rows.start / groups..rows.end.div_ceil(groups)],
            ..study.design.clone()
        },
    }
}

fn passes(study: &Made, size: usize) {
    let study = study.study();
    let questions: Vec<Question> =
        [probability("y > 40"), quantile(0.5), quantile(0.9), mean(), exceedance()].map(asked).into();
    let questions: Vec<&Question> = questions.iter().collect();
    let mut by_replicate = vec![0; study.design.replicates];
    study.design.replicate.iter().for_each(|replicate| by_replicate[*replicate as usize] += 1);
    let whole = Whole { head: piece(&study, 0..0), points: study.points() as u64, by_replicate };
    let mut streamed = Streamed::new(&whole, &questions);
    let rows = study.status.len();
    loop {
        for from in (0..rows).step_by(size) {
            streamed.see(&piece(&study, from..rows.min(from + size)), from as u64);
        }
        if !streamed.go_on() {
            break;
        }
    }
    let held = answer_each(&study, questions.iter().copied()).expect("answers");
    assert_eq!(streamed.answers(), held);
}

#[test]
fn rows_that_pass_by_are_answered_as_rows_in_memory() {
    // more values in each group than are kept
    let values: Vec<f64> = (0..262_144).map(|row| f64::from((row * 7919) % 4999) / 50.0).collect();
    for (kind, replicates) in [(DesignKind::MonteCarlo, 1), (DesignKind::Sobol, 16), (DesignKind::Morris, 1)] {
        for bad in [0, 3] {
            let mut study = replicated(made(&values), kind, replicates).varied("way", &["a", "b"]);
            (0..bad).for_each(|row| study.fail(1000 * row, "diverged"));
            (0..bad).for_each(|row| study.exceed(1000 * row + 7, "ring_displacement", true));
            // pieces that begin within a point
            passes(&study, 30_001);
        }
    }
}
