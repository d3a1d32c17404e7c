//! What the workers are told of a study: the plan that all of them read, and the numbers that stand for a sample.

use crate::dispatch;
use bladeoff_protocol::messages::MAX_PARAMS;
use bladeoff_study::{MOST_VARIED, Samples};
use bladeoff_worker::plan::{MachinePlan, Varied, WorkPlan};

const _: () = assert!(MOST_VARIED == MAX_PARAMS, "what a study may vary fits into a message");

/// The plan that workers read: machine, overrides, what varies, basis.
pub(super) fn work_plan(samples: &Samples, basis: Option<Vec<u8>>) -> WorkPlan {
    let study = samples.study();
    let machine = study.machine().expect("a study with a machine");
    let told = samples.parameters().iter().filter(|parameter| study.is_solved(parameter));
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

impl dispatch::Parameters for Samples {
    fn params(&self, sample: u64, out: &mut Vec<f64>) {
        Samples::params(self, sample, out);
    }
}
