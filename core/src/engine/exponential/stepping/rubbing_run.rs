//! Run with contact without observation of stresses and energies, for tests of the contact steps.

use super::transient::Transient;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::plane::length;
use crate::engine::exponential::settings::StepSettings;
use crate::record::LastMillisecond;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Results of a run with contact.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RubbingRun {
    /// Time of the first contact \[s\].
    pub first_contact: Option<f64>,
    /// Spin at the end \[rad/s\].
    pub end_speed: f64,
    /// Largest load of each bearing, in the machine's order \[N\].
    pub largest_loads: Vec<f64>,
    /// Largest mean of the normal force over 1 ms \[N\].
    pub largest_filtered_force: f64,
    /// Normal impulse of all contact \[N s\].
    pub impulse: f64,
    /// Work of friction \[J\].
    pub friction_energy: f64,
    /// Work of the normal impulses, positive where it leaves the motion \[J\].
    pub normal_work: f64,
    /// Largest distance of the rotor's centre at the contact from the stator's centre \[m\].
    pub eccentricity: f64,
    /// Numbers of contact steps, of contact steps with contact, and of steps of free motion.
    pub steps: [u64; 3],
}

/// Computes a whole run up to `run.end_time` with contact at the first diaphragm, in contact steps of `settings.step` \[s\]; with
/// `takes_long_steps` in longer steps where the gap allows.
///
/// # Errors
/// [`ExponentialError`] for a machine that is not covered or has no modal basis at a speed of the run.
pub fn rubbing_run(
    machine: &Machine,
    structure: &Structure,
    settings: StepSettings,
    takes_long_steps: bool,
) -> Result<RubbingRun, ExponentialError> {
    let mut transient = Transient::new(machine, structure, settings, takes_long_steps)?;
    let h = settings.step;
    let mut filter = LastMillisecond::new(h);
    let window = filter.length() as f64 * h;
    let bearings = structure.rotor.bearings.len();
    let offset = machine.diaphragms.first().map_or([0.0; 2], |diaphragm| diaphragm.contact.offset);
    let mut run = RubbingRun { largest_loads: vec![0.0; bearings], ..RubbingRun::default() };
    while transient.free_motion.time() < machine.run.end_time - 0.5 * h {
        let doublings = transient.next_step_doublings();
        transient.step(doublings)?;
        let contact = transient.contacts.first();
        let ([x, y], impact) =
            contact.map_or(([0.0; 2], None), |contact| (contact.displacement, contact.impact.as_ref()));
        run.eccentricity = run.eccentricity.max(length([x - offset[0], y - offset[1]]));
        match doublings {
            Some(doublings) => {
                (0..1 << doublings).for_each(|_| filter.slide(0.0));
                run.steps[2] += 1;
            }
            None => {
                run.steps[0] += 1;
                filter.slide(impact.map_or(0.0, |impact| impact.normal));
                if let Some(sum) = filter.sum() {
                    run.largest_filtered_force = run.largest_filtered_force.max(sum / window);
                }
            }
        }
        if let Some(impact) = impact {
            run.steps[1] += 1;
            run.impulse += impact.normal;
            run.friction_energy += impact.friction_work;
            run.normal_work += impact.normal_work;
            run.first_contact = run.first_contact.or(Some(transient.free_motion.time()));
        }
        for (largest, load) in run.largest_loads.iter_mut().zip(transient.loads().bearings) {
            *largest = largest.max(length(*load));
        }
    }
    run.end_speed = transient.free_motion.speed();
    Ok(run)
}
