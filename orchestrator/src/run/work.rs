//! What the workers are told of a study: the plan that all of them read, and the numbers that stand for a sample.

use crate::dispatch;
use bladeoff_protocol::messages::MAX_PARAMS;
use bladeoff_study::{MOST_VARIED, Output, Parameter, Samples, Subject};
use bladeoff_worker::plan::{Formula, FunctionPlan, MachinePlan, Variable, Varied, WorkPlan};

const _: () = assert!(MOST_VARIED == MAX_PARAMS, "what a study may vary fits into a message");

/// The plan that workers read: machine, overrides, what varies, basis; or variables and formulas.
pub(super) fn work_plan(samples: &Samples, basis: Option<Vec<u8>>) -> WorkPlan {
    let study = samples.study();
    let told = samples.parameters().iter().filter(|parameter| study.is_solved(parameter));
    let machine = match &study.subject {
        Subject::Machine(machine) => machine,
        Subject::Function(model) => {
            let variable = |one: &Parameter| Variable { name: one.info.path.clone(), short: one.short.clone() };
            return WorkPlan::Function(FunctionPlan {
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
    WorkPlan::Machine(MachinePlan {
        machine_file: machine.file.clone(),
        machine_toml: machine.text.clone(),
        fixed: machine.fixed.iter().map(|(info, value)| (info.path.clone(), value.clone())).collect(),
        varied: varied.chain(twin).collect(),
        basis,
    })
}

fn formula(output: &Output) -> Formula {
    Formula { name: output.name.clone(), formula: output.text.clone() }
}

impl dispatch::Parameters for Samples {
    fn params(&self, sample: u64, out: &mut Vec<f64>) {
        Samples::params(self, sample, out);
    }
}
