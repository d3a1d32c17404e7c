//! The solver of studies without a machine: formulas of the sample's parameters.

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::messages::{MAX_PARAMS, MAX_VALUES};
use bladeoff_text::formula::{FormulaError, Kind, Program, parse};

use crate::batch_recorder::{BatchRecorder, Sample, Stopped, failed};
use crate::job_spec::FunctionJob;
use crate::solver::Solver;

/// Evaluates the formulas of a plan.
#[derive(Debug)]
pub struct FunctionSolver {
    n_variables: usize,
    programs: Vec<Program>,
    stack: Vec<f64>,
}

/// Why a plan cannot be computed. A study is checked before it runs, so this is a fault of ours or a plan that was not made by
/// `bladeoff run`.
#[derive(Debug, thiserror::Error)]
pub enum FunctionSolverError {
    /// A formula.
    #[error("{name} = {formula:?}, from byte {}: {source}", source.place.start)]
    Formula {
        /// Its name.
        name: String,
        /// Its text.
        formula: String,
        /// What is wrong with it.
        source: FormulaError,
    },
    /// More than a message holds.
    #[error("{found} {what}, at most {most} fit")]
    TooMany {
        /// Variables or formulas.
        what: &'static str,
        /// In the plan.
        found: usize,
        /// Most.
        most: usize,
    },
}

impl FunctionSolver {
    /// A solver for a plan.
    ///
    /// # Errors
    /// What is wrong with the plan.
    pub fn new(job: &FunctionJob) -> Result<Self, FunctionSolverError> {
        let variables = &job.variables;
        let counts = [("variables", variables.len(), MAX_PARAMS), ("formulas", job.formulas.len(), MAX_VALUES)];
        if let Some((what, found, most)) = counts.into_iter().find(|(_, found, most)| found > most) {
            return Err(FunctionSolverError::TooMany { what, found, most });
        }
        let is_called = |name: &str| variables.iter().position(|v| v.name == name || v.short.as_deref() == Some(name));
        let program =
            |one: &crate::job_spec::Formula| {
                parse(&one.formula, Kind::Number, &is_called, &|_| None).map_err(|source| {
                    FunctionSolverError::Formula { name: one.name.clone(), formula: one.formula.clone(), source }
                })
            };
        let programs = job.formulas.iter().map(program).collect::<Result<_, _>>()?;
        Ok(Self { n_variables: variables.len(), programs, stack: Vec::new() })
    }

    /// The outcome of a sample with these values of the variables: a failure where one of them, or what a formula gives, is no finite
    /// number; what is finite stays.
    pub fn outcome(&mut self, params: &[f64]) -> Outcome {
        if params.len() != self.n_variables {
            eprintln!("{} parameters, the plan has {}", params.len(), self.n_variables);
            return failed(Cause::Panicked);
        }
        let stack = &mut self.stack;
        let mut value = |program: &Program| Some(program.value(|number| params[number], stack));
        let values: Vec<Option<f64>> =
            self.programs.iter().map(|program| value(program).filter(|value| value.is_finite())).collect();
        if values.contains(&None) || params.iter().any(|param| !param.is_finite()) {
            return Outcome { values, ..failed(Cause::NonFinite) };
        }
        let (status, causes) = (Status::Ok, CauseSet::default());
        Outcome { status, cause: None, causes, notes: CauseSet::default(), end_cause: EndCause::Evaluated, values }
    }
}

impl Solver for FunctionSolver {
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped> {
        for index in 0..samples.len() {
            let begun = recorder.begin(index);
            let outcome = self.outcome(begun.sample.params);
            recorder.finish(begun, outcome)?;
        }
        Ok(())
    }
}
