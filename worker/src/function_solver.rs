//! Solver of studies without a machine: evaluates formulas of the parameters.

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::messages::{MAX_PARAMS, MAX_VALUES};
use bladeoff_text::formula::{FormulaError, Kind, Program, parse};

use crate::batch_recorder::{BatchRecorder, Sample, Stopped, failed};
use crate::job_spec::FunctionJob;
use crate::solver::Solver;

/// Solver for the formulas of a plan.
#[derive(Debug)]
pub struct FunctionSolver {
    n_variables: usize,
    programs: Vec<Program>,
    stack: Vec<f64>,
}

/// Error of a plan. A study is checked before it runs, so the cause is a defect of this program or a plan that `bladeoff run` did
/// not write.
#[derive(Debug, thiserror::Error)]
pub enum FunctionSolverError {
    /// Invalid formula.
    #[error("{name} = {formula:?}, from byte {}: {source}", source.place.start)]
    Formula {
        /// Name.
        name: String,
        /// Text.
        formula: String,
        /// Defect.
        source: FormulaError,
    },
    /// More variables or formulas than a message holds.
    #[error("{found} {what}, at most {most} fit")]
    TooMany {
        /// Variables or formulas.
        what: &'static str,
        /// Number in the plan.
        found: usize,
        /// Largest number.
        most: usize,
    },
}

impl FunctionSolver {
    /// Creates the solver of a plan.
    ///
    /// # Errors
    /// An invalid plan.
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

    /// Computes the outcome of a sample: a failure if a variable or the result of a formula is not finite; finite values are
    /// kept.
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
