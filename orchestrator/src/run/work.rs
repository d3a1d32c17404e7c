//! Plan of a study for its workers, and the numbers that represent a sample.

use crate::dispatch;
use bladeoff_model::machine::{ENGINE, Engine, ParamValue};
use bladeoff_protocol::messages::MAX_PARAMS;
use bladeoff_study::{Fixed, MOST_VARIED, MachineSubject, Output, Parameter, Samples, Subject};
use bladeoff_worker::job_spec::{Formula, FunctionJob, JobSpec, MachineJob, Variable, Varied};

const _: () = assert!(MOST_VARIED == MAX_PARAMS, "what a study may vary fits into a message");

/// Plan for workers: machine, overrides, varied parameters and basis, or variables and formulas.
pub(super) fn job_spec(samples: &Samples, basis: Option<Vec<u8>>) -> JobSpec {
    let study = samples.study();
    let told = samples.parameters().iter().filter(|parameter| study.is_solved(parameter));
    let machine = match &study.subject {
        Subject::Machine(machine) => machine,
        Subject::Function(model) => {
            let variable = |one: &Parameter| Variable { name: one.info.path.clone(), short: one.short.clone() };
            return JobSpec::Function(FunctionJob {
                variables: told.map(variable).collect(),
                formulas: model.outputs.iter().map(formula).collect(),
            });
        }
    };
    let varied = told.map(|varied| Varied {
        path: varied.info.path.clone(),
        choices: varied.words().map(|words| words.iter().map(|word| (*word).to_owned()).collect()),
    });
    let twin = study.twin.iter().map(|twin| Varied { path: twin.info.path.clone(), choices: None });
    JobSpec::Machine(MachineJob {
        machine_file: machine.file.clone(),
        machine_toml: machine.text.clone(),
        fixed: fixed(machine),
        varied: varied.chain(twin).collect(),
        basis,
    })
}

/// Overrides, with the engine that `auto` selected. A plan without an engine means `reduced`
/// ([`planned_engine`](bladeoff_worker::job_spec::planned_engine)), as before the choice existed.
fn fixed(machine: &MachineSubject) -> Vec<(String, ParamValue)> {
    let pair = |one: &Fixed| (one.info.path.clone(), one.value.clone());
    let mut fixed: Vec<(String, ParamValue)> = machine.fixed.iter().map(pair).collect();
    let Some(choice) = machine.engine.as_ref().filter(|choice| choice.is_auto()) else { return fixed };
    let word = ParamValue::Choice(choice.engine.word().to_owned());
    match fixed.iter_mut().find(|(path, _)| path == ENGINE) {
        Some((_, value)) => *value = word,
        None if choice.engine != Engine::Reduced => fixed.push((ENGINE.to_owned(), word)),
        None => {}
    }
    fixed
}

fn formula(output: &Output) -> Formula {
    Formula { name: output.name.clone(), formula: output.text.clone() }
}

impl dispatch::Parameters for Samples {
    fn params(&self, sample: u64, out: &mut Vec<f64>) {
        Samples::params(self, sample, out);
    }
}
