//! `[run]` and the prescribed speed.

use super::covered;
use super::limits;
use super::reader::Reader;
use crate::machine::model::{Engine, ForceLocation, Guard, RunSettings, SpeedLaw};
use crate::machine::schema::{CONTACT_STEP, END_TIME, NORMAL_WORK, PENETRATION, STEP, STEP_LIMIT, TWIN, TWIN_LIMIT};
use bladeoff_text::document::units::format_quantity;

/// Default guard on the energy error. Central differences preserve the balance; impulses with exact propagation preserve it to second order in the
/// step, at their default step to 2e-6 (docs/theory/08-exponential-engine.md).
const BALANCE: f64 = 1e-6;
const BALANCE_OF_EXPONENTIAL: f64 = 1e-5;

/// Default guard on the equivalent steps of a contact phase: with fewer, the step changes impulse and filtered force by more than about 5 %
/// (docs/theory/convergence.md). Impulses with exact propagation need a third of the steps of central differences.
const IMPACT_STEPS: f64 = 32.0;
const IMPACT_STEPS_OF_EXPONENTIAL: f64 = 20.0;

/// Default guards for an engine.
pub(in crate::machine) fn guard_of(engine: Engine) -> Guard {
    let (energy_balance, impact_steps) = match engine {
        Engine::Exponential => (BALANCE_OF_EXPONENTIAL, IMPACT_STEPS_OF_EXPONENTIAL),
        _ => (BALANCE, IMPACT_STEPS),
    };
    Guard { normal_work: NORMAL_WORK, energy_balance, penetration: PENETRATION, impact_steps }
}

pub(super) fn run(reader: &mut Reader<'_>) -> Option<RunSettings> {
    let end_time = reader.number(END_TIME);
    let step = reader.number(STEP);
    if let (Some(step), Some(end_time)) = (step, end_time)
        && step > end_time
    {
        let allowed = format!("at most run.end_time = {}", format_quantity(end_time, "s"));
        reader.fail(STEP, "longer than the whole run", allowed);
    }
    let end_speed = reader.number("run.end_speed");
    if let (Some(end), Some(start)) = (end_speed, reader.number("rotor.initial_speed"))
        && end > 0.0
        && end >= start
    {
        let allowed = format!("below rotor.initial_speed = {}, or 0", format_quantity(start, "rad/s"));
        reader.fail("run.end_speed", "the run would end where it starts", allowed);
    }
    twin(reader);
    let engine = covered::choose(reader)?.engine;
    let guard = guard_of(engine);
    Some(RunSettings {
        end_time: end_time?,
        end_speed: end_speed?,
        engine,
        step,
        contact_step: reader.number(CONTACT_STEP),
        force_location: match reader.word("run.force_location")? {
            "current" => ForceLocation::Current,
            _ => ForceLocation::Next,
        },
        rotor_modes: reader.count("run.rotor_modes"),
        torsional_modes: reader.count("run.torsional_modes"),
        ring_modes: reader.count("run.ring_modes"),
        static_residual: reader.word("run.static_residual")? == "on",
        step_limit: reader.number(STEP_LIMIT).map(|steps| steps as u64),
        twin: reader.number(TWIN)?,
        twin_limit: reader.number(TWIN_LIMIT)?,
        guard: Guard {
            normal_work: reader.number("run.guard.normal_work")?,
            energy_balance: reader.number("run.guard.energy_balance").unwrap_or(guard.energy_balance),
            penetration: reader.number("run.guard.penetration")?,
            impact_steps: reader.number("run.guard.impact_steps").unwrap_or(guard.impact_steps),
        },
        limits: limits::limits(reader)?,
        end_beyond: reader.word("run.end_beyond")? == "on",
    })
}

/// Smallest shift of the initial speed that exceeds rounding.
const LEAST_TWIN: f64 = 1e-12;

fn twin(reader: &mut Reader<'_>) {
    let Some(shift) = reader.number(TWIN).filter(|shift| *shift > 0.0) else { return };
    if shift < LEAST_TWIN {
        reader.fail(TWIN, "smaller than the rounding of the speed", format!("0, or {LEAST_TWIN:e} to 0.01"));
    } else if reader.number("rotor.initial_speed") == Some(0.0)
        && !reader.is_given("rotor.speed_law.acceleration")
        && !reader.is_given("rotor.speed_law.speeds")
    {
        reader.fail(TWIN, "an initial speed of 0 has no relative shift", "0, or a rotor.initial_speed above 0");
    }
}

/// The prescribed speed. Outer `None`: invalid.
pub(super) fn speed_law(reader: &mut Reader<'_>, end_time: Option<f64>) -> Option<Option<SpeedLaw>> {
    const ACCELERATION: &str = "rotor.speed_law.acceleration";
    const TIMES: &str = "rotor.speed_law.times";
    const SPEEDS: &str = "rotor.speed_law.speeds";
    let initial = reader.number("rotor.initial_speed");
    let given = (reader.is_given(ACCELERATION), reader.is_given(TIMES), reader.is_given(SPEEDS));
    match given {
        (false, false, false) => Some(None),
        (true, false, false) => {
            let (acceleration, initial, end_time) = (reader.number(ACCELERATION)?, initial?, end_time?);
            let last = initial + acceleration * end_time;
            if !last.is_finite() {
                reader.fail(ACCELERATION, "the speed becomes infinite before run.end_time", "a finite speed");
                return None;
            }
            // A rotor that is braked to rest stays at rest.
            let rest = -initial / acceleration;
            let (time, speed) = if last < 0.0 { (rest, 0.0) } else { (end_time, last) };
            if time > 0.0 {
                Some(Some(SpeedLaw { times: vec![0.0, time], speeds: vec![initial, speed] }))
            } else {
                Some(Some(SpeedLaw { times: vec![0.0], speeds: vec![initial] }))
            }
        }
        (true, _, _) => {
            reader.fail(ACCELERATION, "given beside times or speeds", "either acceleration, or times and speeds");
            None
        }
        (false, true, false) => {
            reader.missing_here(SPEEDS, SPEEDS);
            None
        }
        (false, false, true) => {
            reader.missing_here(TIMES, TIMES);
            None
        }
        (false, true, true) => points(reader, TIMES, SPEEDS, initial).map(Some),
    }
}

fn points(reader: &mut Reader<'_>, at: &str, of: &str, initial: Option<f64>) -> Option<SpeedLaw> {
    let (times, speeds) = (reader.list(at), reader.list(of));
    let mut right = true;
    if let (Some(times), Some(speeds)) = (&times, &speeds)
        && times.len() != speeds.len()
    {
        let message = format!("{} times and {} speeds", times.len(), speeds.len());
        reader.fail(of, message, "as many speeds as times");
        right = false;
    }
    if let Some(times) = &times {
        if times[0] != 0.0 {
            reader.fail(&format!("{at}[0]"), "the speed law does not start at t = 0", "0 s");
            right = false;
        }
        if let Some(i) = (1..times.len()).find(|&i| times[i] <= times[i - 1]) {
            let allowed = format!("later than {}", format_quantity(times[i - 1], "s"));
            reader.fail(&format!("{at}[{i}]"), "times do not ascend", allowed);
            right = false;
        }
    }
    let mut speeds = speeds;
    if let (Some(speeds), Some(initial)) = (&mut speeds, initial) {
        if (speeds[0] - initial).abs() > 1e-9 * initial {
            let allowed = format!("rotor.initial_speed = {}", format_quantity(initial, "rad/s"));
            reader.fail(&format!("{of}[0]"), "not the speed the rotor starts with", allowed);
            right = false;
        }
        speeds[0] = initial;
    }
    right.then_some(SpeedLaw { times: times?, speeds: speeds? })
}
