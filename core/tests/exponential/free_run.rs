//! Run without contact and without observation, in equal steps of free motion.

use crate::parabola_peak::ParabolaPeak;
use bladeoff_core::engine::exponential::{ExponentialError, FreeMotion, StepSettings};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Machine;

/// Results of a run without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeRun {
    /// Spin at the end \[rad/s\].
    pub end_speed: f64,
    /// Largest load of each bearing, in the machine's order \[N\].
    pub largest_loads: Vec<f64>,
    /// Time at which the falling spin first passes the speed `passed` \[s\]; `None` if it does not.
    pub passing: Option<f64>,
    /// Number of modal bases that were computed, and a bound of their condition.
    pub bases: (usize, f64),
}

/// Computes a run in equal steps up to `run.end_time`, as if there were no diaphragm. `passed` is a speed whose time of passing is reported
/// \[rad/s\].
///
/// # Errors
/// [`ExponentialError`] for a machine that is not covered or has no modal basis at a speed of the run.
pub fn free_run(
    machine: &Machine,
    structure: &Structure,
    settings: StepSettings,
    passed: f64,
) -> Result<FreeRun, ExponentialError> {
    let mut motion = FreeMotion::new(machine, structure, settings)?;
    let bearings = structure.rotor.bearings.len();
    let mut peaks = vec![ParabolaPeak::default(); bearings];
    let mut passing = None;
    let steps = (machine.run.end_time / settings.step).round() as u64;
    for step in 0..=steps {
        for (bearing, peak) in peaks.iter_mut().enumerate() {
            let [x, y] = motion.load(bearing);
            peak.add(x * x + y * y);
        }
        if step == steps {
            break;
        }
        let (time, before) = (motion.time(), motion.speed());
        motion.advance(0)?;
        if passing.is_none() && (before - passed) * (motion.speed() - passed) <= 0.0 && before > motion.speed() {
            passing = Some(time + settings.step * (before - passed) / (before - motion.speed()));
        }
    }
    Ok(FreeRun {
        end_speed: motion.speed(),
        largest_loads: peaks.iter().map(|peak| peak.value.sqrt()).collect(),
        passing,
        bases: motion.visited_bases(),
    })
}
