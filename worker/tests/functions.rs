//! The solver of formulas: values, failures and bytes of outcomes.

mod support;

use std::collections::BTreeMap;

use bladeoff_model::outcome::{Cause, EndCause, Outcome, Status};
use bladeoff_protocol::messages::{Batch, BatchId, MAX_PARAMS};
use bladeoff_worker::function_solver::{FunctionSolver, FunctionSolverError};
use bladeoff_worker::job_spec::{Formula, FunctionJob, Variable};
use support::{play, results};

fn job(variables: &[&str], formulas: &[(&str, &str)]) -> FunctionJob {
    let variable = |name: &&str| Variable { name: (*name).to_owned(), short: None };
    let formula = |(name, text): &(&str, &str)| Formula { name: (*name).to_owned(), formula: (*text).to_owned() };
    FunctionJob {
        variables: variables.iter().map(variable).collect(),
        formulas: formulas.iter().map(formula).collect(),
    }
}

/// Outcomes of one worker that gets these samples as one batch; `values` gives the parameters of each.
fn outcomes(job: &FunctionJob, samples: &[u64], values: impl Fn(u64) -> Vec<f64>) -> BTreeMap<u64, Outcome> {
    let (job, n_params) = (job.clone(), job.variables.len());
    let params = samples.iter().flat_map(|&sample| values(sample)).collect();
    let batch = Batch { batch: BatchId(1), attempt: 1, n_params, samples: samples.to_vec(), params };
    let reports = play(move || FunctionSolver::new(&job).expect("a plan"), batch);
    results(&reports).into_iter().map(|(sample, done)| (sample, done.outcome.clone())).collect()
}

fn bits(outcome: &Outcome) -> (Status, Vec<Option<u64>>) {
    (outcome.status, outcome.values.iter().map(|value| value.map(f64::to_bits)).collect())
}

#[test]
fn formulas_are_evaluated_for_each_sample_whatever_its_batch() {
    let mut job = job(&["x", "growth"], &[("g", "3 - x"), ("h", "y * x / 2")]);
    job.variables[1].short = Some("y".to_owned());
    let values = |sample: u64| vec![0.1 * sample as f64, 1.0 + sample as f64];
    let all: Vec<u64> = (0..32).collect();
    let whole = outcomes(&job, &all, values);
    assert_eq!(whole.len(), 32);
    for (sample, outcome) in &whole {
        let (x, y) = (0.1 * *sample as f64, 1.0 + *sample as f64);
        let expected = [3.0 - x, y * x / 2.0];
        assert_eq!(outcome.values, expected.map(Some));
        assert_eq!((outcome.status, outcome.cause, outcome.end_cause), (Status::Ok, None, EndCause::Evaluated));
    }
    let back: Vec<u64> = (0..32).rev().collect();
    let singly: BTreeMap<u64, Outcome> = all.iter().flat_map(|&one| outcomes(&job, &[one], values)).collect();
    for other in [outcomes(&job, &back, values), singly] {
        assert!(other.iter().all(|(sample, outcome)| bits(outcome) == bits(&whole[sample])));
    }
}

#[test]
fn a_value_that_is_not_finite_fails_its_sample_and_keeps_the_others() {
    let job = job(&["x"], &[("root", "sqrt(x)"), ("g", "x + 1"), ("inverse", "1 / x"), ("both", "sqrt(x) / x")]);
    let found = outcomes(&job, &[0, 1, 2], |sample| vec![[4.0, 0.0, -1.0][sample as usize]]);
    assert_eq!(found[&0].values, [Some(2.0), Some(5.0), Some(0.25), Some(0.5)]);
    assert_eq!(found[&0].status, Status::Ok);
    assert_eq!(found[&1].values, [Some(0.0), Some(1.0), None, None]);
    assert_eq!(found[&2].values, [None, Some(0.0), Some(-1.0), None]);
    for failed in [&found[&1], &found[&2]] {
        assert_eq!((failed.status, failed.cause), (Status::Failed, Some(Cause::NonFinite)));
        assert_eq!((failed.causes.words().as_deref(), failed.end_cause), (Some("non_finite"), EndCause::Failure));
    }
}

#[test]
fn a_variable_that_is_no_number_fails_its_sample() {
    let job = job(&["x", "none"], &[("g", "x + 1"), ("h", "none * 0")]);
    let found = outcomes(&job, &[0, 1], |sample| vec![1.0, [f64::NAN, 2.0][sample as usize]]);
    assert_eq!((found[&0].status, found[&0].cause), (Status::Failed, Some(Cause::NonFinite)));
    assert_eq!(found[&0].values, [Some(2.0), None]);
    assert_eq!(found[&1].values, [Some(2.0), Some(0.0)]);
}

#[test]
fn as_many_variables_as_a_message_holds() {
    let names: Vec<String> = (0..MAX_PARAMS).map(|i| format!("x{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    assert_eq!(names.len(), 128);
    let sum = names.join(" + ");
    let full = job(&names, &[("g", &sum)]);
    let found = outcomes(&full, &[0, 1], |sample| (0..128).map(|i| (i as u64 * (1 + sample)) as f64).collect());
    assert_eq!([found[&0].values[0], found[&1].values[0]], [Some(8128.0), Some(16256.0)]);
    let more: Vec<&str> = names.iter().copied().chain(["y"]).collect();
    let error = FunctionSolver::new(&job(&more, &[("g", "y")])).expect_err("one more");
    assert!(matches!(error, FunctionSolverError::TooMany { found: 129, most: 128, .. }), "{error}");
}

#[test]
fn a_plan_that_cannot_be_computed_is_refused() {
    for (text, words) in [("x + y", "there is no variable `y`"), ("x > 1", "a number is expected"), ("", "no formula")]
    {
        let error = FunctionSolver::new(&job(&["x"], &[("g", text)])).expect_err("no formula of these variables");
        assert!(error.to_string().contains(words), "{error}");
    }
}
