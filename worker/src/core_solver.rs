//! Solver of machines: sets the parameters of a sample in the machine and simulates it.

use bladeoff_core::engine::{self, StartError};
use bladeoff_core::modal::{Basis, BasisError};
use bladeoff_core::record::NoHistory;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef, ParamValue, PathError, PathInfo, ValueError};
use bladeoff_model::outcome::{Cause, Outcome};
use bladeoff_text::document::Problems;

use crate::batch_recorder::{BatchRecorder, Sample, Stopped, failed};
use crate::job_spec::MachineJob;
use crate::solver::Solver;

/// Solver for the samples of a plan.
pub struct CoreSolver {
    def: MachineDef,
    varied: Vec<Parameter>,
    basis: Option<Basis>,
    /// Structure of the last sample; most samples of a study share it.
    structure: Option<Structure>,
}

struct Parameter {
    path: PathInfo,
    choices: Option<Vec<String>>,
}

/// Error of a plan or of a sample. A study is checked before it runs, so the cause is a defect of this program or a plan that
/// `bladeoff run` did not write.
#[derive(Debug, thiserror::Error)]
pub enum SolverError {
    /// Invalid machine file, or invalid machine with the parameters.
    #[error("{0}")]
    Machine(Problems),
    /// Invalid path of the plan.
    #[error("{0}")]
    Path(PathError),
    /// Invalid value.
    #[error("{0}")]
    Value(ValueError),
    /// Error of the basis or of the model built with it.
    #[error("{0}")]
    Basis(BasisError),
    /// Run that cannot start.
    #[error("{0}")]
    Start(StartError),
    /// Wrong number of parameters.
    #[error("{found} parameters, the plan has {expected}")]
    Count {
        /// Number in the sample.
        found: usize,
        /// Number in the plan.
        expected: usize,
    },
    /// Number that is not an index into the choices.
    #[error("{path}: {value} is not a number from 0 to {last}")]
    Choice {
        /// The parameter.
        path: String,
        /// The number.
        value: f64,
        /// Largest index.
        last: usize,
    },
}

impl CoreSolver {
    /// Creates the solver of a plan.
    ///
    /// # Errors
    /// An invalid plan.
    pub fn new(job: &MachineJob) -> Result<Self, SolverError> {
        let mut def = MachineDef::parse(&job.machine_file, &job.machine_toml).map_err(SolverError::Machine)?;
        for (path, value) in &job.fixed {
            let path = def.resolve(path).map_err(SolverError::Path)?;
            def.set(&path, value).map_err(SolverError::Value)?;
        }
        // a plan with another engine names it (`planned_engine`)
        if def.engine().is_some_and(|choice| choice.is_auto()) {
            def.settle(Engine::Reduced);
        }
        let mut varied = Vec::with_capacity(job.varied.len());
        for parameter in &job.varied {
            let path = def.resolve(&parameter.path).map_err(SolverError::Path)?;
            varied.push(Parameter { path, choices: parameter.choices.clone() });
        }
        let basis = job.basis.as_deref().map(Basis::from_bytes).transpose().map_err(SolverError::Basis)?;
        Ok(Self { def, varied, basis, structure: None })
    }

    /// Computes one sample.
    ///
    /// # Errors
    /// A sample without a valid machine, or a run that cannot start.
    pub fn simulate(&mut self, params: &[f64]) -> Result<Outcome, SolverError> {
        let (machine, structure) = self.prepare(params)?;
        engine::simulate(&machine, structure, &mut NoHistory).map_err(SolverError::Start)
    }

    /// Computes one sample as an outcome; an error becomes a failure.
    fn outcome(&mut self, sample: Sample<'_>) -> Outcome {
        self.simulate(sample.params).unwrap_or_else(|error| {
            eprintln!("sample {} cannot be computed: {error}", sample.number);
            failed(match error {
                // the sag or the steady state is not an input of the study, and a large study does not try every start before its run
                SolverError::Start(StartError::StartsOutside { .. }) => Cause::OutsideRing,
                // a study does not try every basis either, nor the feedback of an unbalance into an undamped torsional mode
                SolverError::Start(StartError::NoBasis { .. } | StartError::NotCovered { .. }) => Cause::NoBasis,
                _ => Cause::Panicked,
            })
        })
    }

    /// Lists the table column of each parameter, in order.
    pub fn parameter_columns(&self) -> impl Iterator<Item = String> + '_ {
        self.varied.iter().map(|parameter| parameter.path.column())
    }

    /// Builds machine and structure of one sample.
    ///
    /// # Errors
    /// A sample whose parameters do not give a machine.
    pub fn prepare(&mut self, params: &[f64]) -> Result<(Machine, &Structure), SolverError> {
        self.prepare_changed(params, |_| Ok(()))
    }

    /// Builds machine and structure of one sample after `change` has set further values. These values stay set, so the solver must not compute other
    /// samples.
    ///
    /// # Errors
    /// A sample whose parameters do not give a machine; errors of `change`.
    pub fn prepare_changed<E: From<SolverError>>(
        &mut self,
        params: &[f64],
        change: impl FnOnce(&mut MachineDef) -> Result<(), E>,
    ) -> Result<(Machine, &Structure), E> {
        if params.len() != self.varied.len() {
            return Err(SolverError::Count { found: params.len(), expected: self.varied.len() }.into());
        }
        for (parameter, &value) in self.varied.iter().zip(params) {
            let value = parameter.value(value)?;
            self.def.set(&parameter.path, &value).map_err(SolverError::Value)?;
        }
        change(&mut self.def)?;
        let machine = self.def.build().map_err(SolverError::Machine)?;
        let structure = match self.structure.take() {
            Some(structure) if structure.fits(&machine) => self.structure.insert(structure),
            last => {
                // A sample that changes inputs of the basis gets a separate basis.
                let structure = match (Structure::build(&machine, self.basis.as_ref()), last) {
                    (Err(BasisError::OtherStructure { .. }), Some(last)) => last.rebuilt(&machine),
                    (Err(BasisError::OtherStructure { .. }), None) => Structure::build(&machine, None),
                    (built, _) => built,
                };
                self.structure.insert(structure.map_err(SolverError::Basis)?)
            }
        };
        Ok((machine, structure))
    }
}

impl Parameter {
    fn value(&self, value: f64) -> Result<ParamValue, SolverError> {
        let Some(choices) = &self.choices else { return Ok(ParamValue::Number(value)) };
        let is_index = value.fract() == 0.0 && value >= 0.0 && value < choices.len() as f64;
        if !is_index {
            let last = choices.len().saturating_sub(1);
            return Err(SolverError::Choice { path: self.path.path.clone(), value, last });
        }
        Ok(ParamValue::Choice(choices[value as usize].clone()))
    }
}

impl Solver for CoreSolver {
    /// Computes the samples one after the other: computing several together has no advantage here.
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped> {
        for index in 0..samples.len() {
            let begun = recorder.begin(index);
            let outcome = self.outcome(begun.sample);
            recorder.finish(begun, outcome)?;
        }
        Ok(())
    }

    fn recover(&mut self) {
        self.structure = None;
    }
}
