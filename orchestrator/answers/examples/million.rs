//! Time and memory of all figures of a million rows: `cargo run --release -p bladeoff-answers --example million`
//! (bounds: 10 s of processor time and 1 GB for each design, the rows themselves included).

#![allow(clippy::print_stdout, reason = "the measurements are its output")]

use bladeoff_answers::ask::{Known, Names, Question, QuestionDef, answer, answer_all};
use bladeoff_answers::estimate::input::{Cells, Column, Design, DesignKind, Group, Label, Nature, Study};
use bladeoff_answers::gate::Gate;
use bladeoff_model::outcome::{Cause, CauseSet, Status};

const POINTS: usize = 500_000;
const WAYS: [&str; 2] = ["a", "b"];

/// A line of this process's status: other processes do not count.
fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("VmHWM: unknown").to_owned()
}

/// Processor time of this process so far \[s\].
fn seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = stat.rsplit(')').next().unwrap_or("").split_whitespace().skip(11).take(2);
    ticks.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn label(way: &str) -> Label {
    Label::Word(way.to_owned())
}

fn questions(names: &Names) -> Vec<Question> {
    let y = || Some("y".to_owned());
    let condition = || Some("y > 9.2 and sqrt(u) < 0.9 or max(y, 3*u) > 12".to_owned());
    let base = || QuestionDef { name: "q".to_owned(), ..QuestionDef::default() };
    let less = || QuestionDef { difference: Some(WAYS.map(label)), vary: Some("way".to_owned()), ..base() };
    let defs = [
        QuestionDef { probability: Some("y > 9.2".to_owned()), ..base() },
        QuestionDef { probability: condition(), ..base() },
        QuestionDef { quantile: Some(0.95), of: y(), ..base() },
        QuestionDef { quantile: Some(0.5), of: y(), ..base() },
        QuestionDef { mean: y(), ..base() },
        QuestionDef { exceedance: y(), ..base() },
        QuestionDef { fragility: Some("u".to_owned()), probability: condition(), ..base() },
        QuestionDef { fragility: Some("way".to_owned()), probability: condition(), ..base() },
        QuestionDef { probability: condition(), ..less() },
        QuestionDef { quantile: Some(0.95), of: y(), ..less() },
        QuestionDef { mean: y(), ..less() },
    ];
    defs.into_iter().map(|def| Question::new(&def, names).expect("a question of these columns")).collect()
}

fn main() {
    let names = Names {
        known: Known { columns: vec![("y".to_owned(), true), ("u".to_owned(), true)], ..Known::default() },
        uncertain: vec!["u".to_owned()],
        varied: vec![("way".to_owned(), WAYS.map(label).to_vec())],
    };
    let questions = questions(&names);
    for (kind, replicates) in [(DesignKind::MonteCarlo, 1), (DesignKind::Sobol, 16)] {
        let mut state = 1u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 12) as f64 + 0.5) / (1u64 << 52) as f64
        };
        let rows = POINTS * WAYS.len();
        let points: Vec<f64> = (0..POINTS).map(|_| draw()).collect();
        let u: Vec<_> = (0..rows).map(|row| Some(points[row / WAYS.len()])).collect();
        let y: Vec<_> = (0..rows).map(|row| Some(-libm::log(points[row / WAYS.len()]) - libm::log(draw()))).collect();
        let (mut status, mut causes) = (vec![Status::Ok; rows], vec![CauseSet::default(); rows]);
        let mut held = vec![None; rows];
        for row in (0..rows).step_by(101) {
            status[row] = Status::Failed;
            causes[row].insert(Cause::Diverged);
            held[row] = (row % 3 == 0).then_some(1.0);
        }
        let column = |name: &str, cells| Column { name: name.to_owned(), unit: String::new(), cells };
        let replicate: Vec<u32> = (0..POINTS).map(|point| (point % replicates) as u32).collect();
        let study = Study {
            columns: vec![
                column("y", Cells::Numbers(&y, Nature::Grows(Some(&held)))),
                column("u", Cells::Numbers(&u, Nature::Given)),
            ],
            status: &status,
            causes: &causes,
            groups: WAYS.map(|way| Group(vec![("way".to_owned(), label(way))])).to_vec(),
            design: Design { kind, scrambled: true, replicates, replicate: &replicate, complete: true },
        };
        println!("{}: rows alone {}", kind.word(), peak());
        for question in &questions {
            let start = seconds();
            let answered = answer(&study, question).expect("columns that are there");
            println!("{:>8.3} s  {}", seconds() - start, answered.answers[0].sentence);
        }
        let start = seconds();
        let (answers, _) = answer_all(&study, &questions).expect("columns that are there");
        println!("{:>8.3} s  all, {} answers; {}", seconds() - start, answers.answers.len(), peak());
        let start = seconds();
        let gate = Gate::new("P(y > 9.2) < 0.01", None, &names).expect("a gate of these columns");
        if let Ok(decisions) = gate.judge(&study) {
            println!("{:>8.3} s  {}", seconds() - start, decisions[0].sentence);
        }
    }
}
