//! The core solver: the outcome of a sample does not depend on its batch.

mod support;

use std::collections::BTreeMap;

use bladeoff_core::record::columns;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{MachineDef, ParamValue};
use bladeoff_model::outcome::Outcome;
use bladeoff_protocol::messages::{Batch, BatchId};
use bladeoff_worker::core_solver::CoreSolver;
use bladeoff_worker::job_spec::{MachineJob, Varied};
use support::{play, results};

const RIG: &str = include_str!("../../studies/machines/lab_rig.toml");

/// Gap \[m\], thickness of the ring \[m\], detection: two structures other than that of the frozen basis, and one sample without a valid machine.
const SAMPLES: [[f64; 3]; 6] = [
    [0.2e-3, 3e-3, 0.0],
    [0.2e-3, 4e-3, 1.0],
    [0.3e-3, 3e-3, 2.0],
    [0.2e-3, -1.0, 0.0],
    [0.2e-3, 5e-3, 0.0],
    [0.3e-3, 4e-3, 1.0],
];

fn job() -> MachineJob {
    let machine = MachineDef::parse("lab_rig.toml", RIG).expect("the rig").build().expect("the rig");
    let basis = Structure::build(&machine, None).expect("modes").basis().to_bytes();
    let varied = |path: &str, choices: Option<&[&str]>| Varied {
        path: path.to_owned(),
        choices: choices.map(|words| words.iter().map(|&word| word.to_owned()).collect()),
    };
    MachineJob {
        machine_file: "lab_rig.toml".to_owned(),
        machine_toml: RIG.to_owned(),
        fixed: vec![("run.end_time".to_owned(), ParamValue::Number(0.02))],
        varied: vec![
            varied("diaphragms.seal.contact.gap", None),
            varied("diaphragms.seal.ring.thickness", None),
            varied("diaphragms.seal.contact.detection", Some(&["hyp1", "hyp2", "hyp2-frozen"])),
        ],
        basis: Some(basis),
    }
}

/// Outcomes of one worker that gets these samples as one batch.
fn outcomes(job: &MachineJob, order: &[u64]) -> BTreeMap<u64, Outcome> {
    let job = job.clone();
    let params = order.iter().flat_map(|&sample| SAMPLES[sample as usize]).collect();
    let batch = Batch { batch: BatchId(1), attempt: 1, n_params: 3, samples: order.to_vec(), params };
    let reports = play(move || CoreSolver::new(&job).expect("a plan"), batch);
    results(&reports).into_iter().map(|(sample, done)| (sample, done.outcome.clone())).collect()
}

/// Every bit of an outcome.
fn bits(outcome: &Outcome) -> (String, Vec<Option<u64>>) {
    let values = outcome.values.iter().map(|value| value.map(f64::to_bits)).collect();
    (format!("{:?} {:?} {:?} {:?}", outcome.status, outcome.cause, outcome.causes, outcome.end_cause), values)
}

#[test]
fn an_outcome_does_not_depend_on_the_others_of_its_batch_or_their_order() {
    let job = job();
    let mut solver = CoreSolver::new(&job).expect("a plan");
    let (machine, _) = solver.prepare(&SAMPLES[0]).expect("a machine");
    let first_contact = columns(&machine).iter().position(|column| column.name == "first_contact_s").expect("a column");
    let (other, _) = solver.prepare(&SAMPLES[1]).expect("a machine");
    assert!(!solver.prepare(&SAMPLES[0]).expect("a machine").1.fits(&other), "they differ in structure");

    let whole = outcomes(&job, &[0, 1, 2, 3, 4, 5]);
    assert_eq!(whole.len(), SAMPLES.len());
    for (sample, outcome) in &whole {
        // The sample without a valid machine fails, the others rub.
        let has_rubbed = outcome.values.get(first_contact).copied().flatten().is_some();
        assert_eq!(has_rubbed, *sample != 3, "sample {sample}: {:?}", outcome.cause);
    }
    let ways: [&[&[u64]]; 3] =
        [&[&[5, 4, 3, 2, 1, 0]], &[&[3, 1, 5], &[0, 2, 4]], &[&[0], &[1], &[2], &[3], &[4], &[5]]];
    for way in ways {
        let found: BTreeMap<u64, Outcome> = way.iter().flat_map(|order| outcomes(&job, order)).collect();
        assert_eq!(found.len(), SAMPLES.len());
        for (sample, outcome) in &found {
            assert_eq!(bits(outcome), bits(&whole[sample]), "sample {sample} in {way:?}");
        }
    }
}
