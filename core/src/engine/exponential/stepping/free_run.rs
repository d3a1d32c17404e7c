//! A whole run without contact, for tests of the propagation.

use super::free_motion::FreeMotion;
use super::parabola_peak::ParabolaPeak;
use crate::engine::exponential::error::ExponentialError;
use crate::engine::exponential::settings::StepSettings;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Result of a run without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeRun {
    /// Spin at the end \[rad/s\].
    pub end_speed: f64,
    /// Largest load of each bearing, in the machine's order \[N\].
    pub largest_loads: Vec<f64>,
    /// Time at which the spin first passed the speed asked for \[s\]; `None` where it did not.
    pub passing: Option<f64>,
    /// Stations visited, and a bound of the condition of their bases.
    pub stations: (usize, f64),
}

/// A whole run in equal steps up to `run.end_time`, as if nothing were there to touch; `passed` is a speed \[rad/s\] whose time is asked for.
///
/// # Errors
/// [`ExponentialError`].
pub fn free_run(
    machine: &Machine,
    structure: &Structure,
    settings: StepSettings,
    passed: f64,
) -> Result<FreeRun, ExponentialError> {
    let mut flight = FreeMotion::new(machine, structure, settings)?;
    let bearings = structure.rotor.bearings.len();
    let mut peaks = vec![ParabolaPeak::default(); bearings];
    let mut passing = None;
    let steps = libm::round(machine.run.end_time / settings.step) as u64;
    for step in 0..=steps {
        for (bearing, peak) in peaks.iter_mut().enumerate() {
            let [x, y] = flight.load(bearing);
            peak.add(x * x + y * y);
        }
        if step == steps {
            break;
        }
        let (time, before) = (flight.time(), flight.speed());
        flight.advance(0)?;
        if passing.is_none() && (before - passed) * (flight.speed() - passed) <= 0.0 && before > flight.speed() {
            passing = Some(time + settings.step * (before - passed) / (before - flight.speed()));
        }
    }
    Ok(FreeRun {
        end_speed: flight.speed(),
        largest_loads: peaks.iter().map(|peak| peak.value.sqrt()).collect(),
        passing,
        stations: flight.visited_bases(),
    })
}
