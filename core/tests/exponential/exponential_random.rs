//! Random machines: the exponential engine against the reduced one with small steps, from release to 15 ms after first contact. Single impacts
//! scatter, so means over nine starts are compared. Errors of the default steps of both: `exponential_accuracy -- random`
//! (docs/theory/08-exponential-engine.md).

use crate::random::{COMPARED, Drawn, Found, STARTS, difference, machines};
use bladeoff_model::machine::Engine;
use bladeoff_model::outcome::Status;

/// Limits of the compared columns, for mean differences over nine starts. First: at the default contact step, for each machine. Second: the same
/// relative to the error of `reduced` at its default step, for means over all machines. Third: at an eleventh of the default step, for each machine;
/// there the error of the candidates on a ring of 24 elements remains (up to 4e-3 of a load).
const LIMITS: [[f64; 3]; COMPARED.len()] =
    [[1e-4, 0.5, 1e-4], [1e-2, 0.4, 1e-2], [1e-2, 0.4, 5e-3], [1e-2, 0.4, 5e-3], [2e-2, 0.5, 1e-2], [2e-3, 0.6, 2e-3]];

/// Runs of all starts of a machine: reference, exponential engine with fine steps, both engines with their default steps. The reference is `reduced`,
/// whose error is of first order in the step: extrapolated from its default step and a quarter of it.
fn runs_of(machine: &Drawn) -> [Vec<Found>; 4] {
    let [largest, step] = machine.steps();
    let starts = machine.starts();
    assert_eq!(starts.len(), STARTS, "{}: every start touches", machine.kind);
    let of = |engine, step: Option<f64>| starts.iter().map(|start| start.run(engine, step)).collect::<Vec<Found>>();
    let (reduced, mut reference) = (of(Engine::Reduced, None), of(Engine::Reduced, Some(0.25 * step)));
    for (quarter, default) in reference.iter_mut().zip(&reduced) {
        for (value, coarse) in quarter.values.iter_mut().zip(default.values) {
            *value += (*value - coarse) / 3.0;
        }
    }
    [reference, of(Engine::Exponential, Some(0.0625 * largest)), of(Engine::Exponential, None), reduced]
}

#[test]
fn random_machines_rub_as_in_the_reduced_engine() {
    let all = machines(10, "hyp2");
    let mut wrong = Vec::new();
    let mut sums = [[0.0; COMPARED.len()]; 2];
    // this test takes longer than the others, so its machines are computed in parallel
    let runs: Vec<[Vec<Found>; 4]> = std::thread::scope(|scope| {
        let threads: Vec<_> = all.iter().map(|machine| scope.spawn(|| runs_of(machine))).collect();
        threads.into_iter().map(|thread| thread.join().expect("runs")).collect()
    });
    for (case, (machine, [reference, fine, exponential, reduced])) in all.iter().zip(&runs).enumerate() {
        let kind = machine.kind;
        for (start, runs) in [reference, fine, exponential, reduced].iter().flat_map(|runs| runs.iter().enumerate()) {
            assert!(runs.values[2] > 0.0, "{case}, {kind}, {start} touches: {:?}", runs.outcome);
            if runs.outcome.status != Status::Ok {
                wrong.push(format!("{case}, {kind}, {start}: {:?}", runs.outcome));
            }
            let (first, expected) =
                (runs.first_contact.expect("contact"), reference[start].first_contact.expect("contact"));
            if (first - expected).abs() > runs.step + reference[start].step {
                wrong.push(format!("{case}, {kind}, {start}: first contact {first}, {expected}"));
            }
        }
        for (start, run) in fine.iter().enumerate().filter(|(_, run)| run.energy_error > 1e-6) {
            wrong.push(format!("{case}, {kind}, {start}: energy error {:.1e}", run.energy_error));
        }
        for (column, (name, _)) in COMPARED.iter().enumerate() {
            let off = [exponential, fine, reduced].map(|runs| difference(runs, reference, column)[0]);
            let [at_default, _, at_fine] = LIMITS[column];
            println!("{case}, {kind}, {name}: {:+.1e}, fine {:+.1e}, reduced {:+.1e}", off[0], off[1], off[2]);
            for (off, limit) in [(off[0], at_default), (off[1], at_fine)] {
                if off.is_nan() || off.abs() > limit {
                    wrong.push(format!("{case}, {kind}, {name}: {off:+.2e}, allowed {limit:.0e}"));
                }
            }
            sums[0][column] += off[0].abs();
            sums[1][column] += off[2].abs();
        }
    }
    for (column, (name, _)) in COMPARED.iter().enumerate() {
        let [exponential, reduced] = sums.map(|sums| sums[column] / all.len() as f64);
        println!(
            "{name}, mean of {}: {exponential:.1e}, reduced {reduced:.1e}, {:.2}",
            all.len(),
            exponential / reduced
        );
        // the default contact step was selected by this criterion
        if !(exponential > 0.0 && exponential < LIMITS[column][1] * reduced) {
            wrong.push(format!("{name} at the default steps: {exponential:e}, reduced {reduced:e}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
