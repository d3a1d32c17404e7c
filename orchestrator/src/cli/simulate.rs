//! `bladeoff simulate`: computes one transient.

use super::error::CliError;
use super::exit::Exit;
use super::history::{HistoryArgs, watched};
use super::json::JsonObject;
use super::machine::{MachineArgs, build, refused, set};
use super::output::{print_json, remark, tell};
use crate::engine::{self, EngineError};
use crate::engine_choice::machine_alone;
use crate::plausible::implausible;
use crate::start_check::placed;
use crate::terminal::{
    OutcomeView, bearing_remarks, cause_in_words, describe_outcome, matrices_of, unstable, with_word,
};
use bladeoff_answers::summary::duration;
use bladeoff_answers::tables::{ENGINE as ENGINE_COLUMN, NOTES, TableSchema, verdict_fields};
use bladeoff_core::engine::TimeStep;
use bladeoff_model::machine::{Detection, ENGINE, Engine, EngineChoice, Machine, MachineDef, STEP, is_detection};
use bladeoff_model::outcome::{Outcome, Status};
use bladeoff_study::show;
use bladeoff_system::call::word;
use bladeoff_text::document::units::format_quantity;
use std::time::Instant;

/// Long help.
const ABOUT: &str = "\
Compute one blade-off transient and print its results

The run ends when the rotor has stopped, at `run.end_time`, at `run.end_speed`, at a limit of the model or with a failure.

  ok        exit code 0
  beyond    exceeded a limit (`run.limit`); a warning
            names it; exit code 0
  invalid   finished, but a numerical check failed; a
            warning names it; exit code 0
  failed    ended early; values up to then; exit code 4

The progress of a longer run is printed on standard error: a bar on a terminal, otherwise a line after 5 s and every 30 s; \
nothing with --json.";

/// Compute one blade-off transient and print its results
#[derive(Debug, clap::Args)]
#[command(long_about = ABOUT, after_help = "Examples:
  bladeoff simulate studies/machines/lab_rig.toml
  bladeoff simulate studies/machines/lab_rig.toml \\
    --set contact.gap=\"0.4 mm\" --detection hyp1
  bladeoff simulate studies/machines/lab_rig.toml \\
    --engine full --step \"1 us\"
  bladeoff simulate studies/machines/lp_turbine_paper.toml \\
    --json | jq .first_contact_s
  bladeoff simulate studies/machines/lp_turbine_paper.toml \\
    --history turbine.mcap --every \"0.2 ms\"")]
pub struct Args {
    #[command(flatten)]
    machine: MachineArgs,

    /// Engine, instead of the machine's. `reduced`: modes of rotor and ring. `full`: all finite-element degrees of
    /// freedom. `exponential`: the modes, propagated exactly, with contact by impulses (fast; docs/features.md lists what it covers).
    /// `auto`: `exponential` where it covers the machine, otherwise `reduced`
    #[arg(long, value_parser = Engine::CHOICES)]
    engine: Option<String>,

    /// Contact detection, instead of the machine's
    #[arg(long, value_parser = Detection::WORDS)]
    detection: Option<String>,

    /// Time step, in seconds or with a unit ("2 us"). A step that is too large is rejected with the largest allowed one
    #[arg(long, value_name = "STEP")]
    step: Option<String>,

    /// Print one JSON object whose keys are the column names of result tables, also when the run fails
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    history: HistoryArgs,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let mut definition = definition(args)?;
    let mut machine = build(&definition, &given(args))?;
    let started = Instant::now();
    let words = matrices_of(&machine);
    let mut set_up = || machine_alone(&mut definition, &mut machine);
    let (structure, choice) = if args.json { set_up() } else { with_word(|| words.clone(), set_up) }?;
    let refusal = |error: EngineError| match placed(&error, &definition, &machine, |_| false) {
        Some(problems) => refused(problems, &given(args)),
        None => error.into(),
    };
    implausible(&machine).iter().for_each(|text| remark(&format!("warning: {text}")));
    let time_step = engine::time_step(&machine, &structure).map_err(refusal)?;
    let history = args.history.settings(&machine, &time_step)?;
    let (outcome, history) =
        watched(&machine, &structure, history.as_ref(), !args.json).map_err(|error| match error {
            CliError::Engine(error) => refusal(error),
            other => other,
        })?;
    let wall = started.elapsed();
    let columns = engine::columns(&machine);
    let view = OutcomeView { columns: &columns, outcome: &outcome };
    let step = view.value("step_s").unwrap_or(time_step.step);
    if args.json {
        print_json(&json(&machine, view))?;
    } else {
        let mut text = heading(&machine, &args.machine.changed(&definition), choice.as_ref(), &time_step, step);
        text.push_str(&describe_outcome(&machine, view));
        text.push_str(&format!("{:<32} {}\n", "computed in", duration(wall)));
        tell(&text)?;
    }
    for note in bearing_remarks(&machine, &structure, step).iter().chain(&history) {
        remark(note);
    }
    let initial = machine.rotor.initial_speed;
    if let (Some(ratio), Some(at)) = (view.value("least_damping_ratio"), view.value("least_damping_at_rad_s"))
        && ratio < 0.0
    {
        let end = view.value("end_speed_rad_s").unwrap_or(at);
        let visited = [end.min(at).min(initial), end.max(at).max(initial)];
        unstable(&machine, &structure, visited).iter().for_each(|range| remark(&format!("warning: {range}")));
    }
    Ok(verdict(&outcome))
}

/// Options that override the file.
fn given(args: &Args) -> Vec<String> {
    let mut given = args.machine.given();
    for (option, value) in [("--engine", &args.engine), ("--step", &args.step), ("--detection", &args.detection)] {
        given.extend(value.as_ref().map(|value| format!("{option} {}", word(value))));
    }
    given
}

fn definition(args: &Args) -> Result<MachineDef, CliError> {
    let mut machine = args.machine.load()?;
    if let Some(engine) = &args.engine {
        option(&args.machine, &mut machine, ENGINE, engine, &format!("--engine {engine}"))?;
    }
    if let Some(step) = &args.step {
        option(&args.machine, &mut machine, STEP, step, &format!("--step {step}"))?;
    }
    if let Some(detection) = &args.detection {
        let argument = format!("--detection {detection}");
        let paths: Vec<String> =
            machine.paths().into_iter().map(|info| info.path).filter(|path| is_detection(path)).collect();
        if paths.is_empty() {
            let message = "the machine has no diaphragm".to_owned();
            return Err(CliError::Argument { argument, message, allowed: None });
        }
        for path in paths {
            option(&args.machine, &mut machine, &path, detection, &argument)?;
        }
    }
    Ok(machine)
}

/// Sets the value of an option. `--set` may repeat it, but a different value is an error: one of the two would be ignored silently.
fn option(
    given: &MachineArgs,
    machine: &mut MachineDef,
    path: &str,
    value: &str,
    argument: &str,
) -> Result<(), CliError> {
    let of_set = given.changed(machine).into_iter().find(|(changed, _)| changed == path);
    set(machine, path, value, argument)?;
    let info = machine.resolve(path).ok();
    let shown = info.and_then(|info| Some(show(&info, &machine.parse_value(&info, value).ok()?)));
    match of_set {
        Some((path, other)) if shown.as_ref() != Some(&other) => Err(CliError::Argument {
            argument: argument.to_owned(),
            message: format!("--set gives {path} another value, {other}"),
            allowed: Some("one of the two".to_owned()),
        }),
        _ => Ok(()),
    }
}

fn verdict(outcome: &Outcome) -> Exit {
    let causes = || {
        outcome.causes.iter().map(|cause| format!("  {}: {}", cause.word(), cause_in_words(cause))).collect::<Vec<_>>()
    };
    match outcome.status {
        Status::Ok => Exit::Ok,
        Status::Invalid => {
            remark(&format!("warning: the run is invalid; do not use its values\n{}", causes().join("\n")));
            Exit::Ok
        }
        Status::Beyond => {
            let limit = "warning: beyond the model; the values up to `beyond_s` are lower bounds of what would follow";
            remark(&format!("{limit}\n{}", causes().join("\n")));
            Exit::Ok
        }
        Status::Failed | Status::Quarantined => {
            remark(&format!("the run failed\n{}", causes().join("\n")));
            Exit::Failures
        }
    }
}

/// Description of the run; `changed`: overridden parameters; `step`: time step, which may be smaller than the initial one \[s\].
fn heading(
    machine: &Machine,
    changed: &[(String, String)],
    choice: Option<&EngineChoice>,
    time_step: &TimeStep,
    step: f64,
) -> String {
    let detection = engine::detection(machine).unwrap_or("no diaphragm");
    let [used, default, largest] =
        [step, time_step.step, time_step.largest_allowed()].map(|step| format_quantity(step, "s"));
    let finer = if step < time_step.step {
        format!("; {default} by default, refined for short impacts")
    } else {
        String::new()
    };
    let step = format!("{used} (largest allowed {largest}{finer})");
    let set = changed.iter().map(|(path, value)| ("set", format!("{path} = {value}")));
    // only the engine name, if the file does not use `auto`
    let auto = choice.filter(|choice| choice.is_auto()).map(|choice| choice.words("the machine"));
    let engine = auto.unwrap_or_else(|| machine.run.engine.word().to_owned());
    let rest = [("engine", engine), ("detection", detection.to_owned()), ("time step", step)];
    std::iter::once(("machine", machine.name.clone()))
        .chain(set)
        .chain(rest)
        .map(|(name, value)| format!("{name:<32} {value}\n"))
        .collect()
}

/// Verdict and values of a run as JSON, with the column names as keys.
pub(super) fn json(machine: &Machine, view: OutcomeView<'_>) -> String {
    let outcome = view.outcome;
    let mut object = JsonObject::default();
    for field in verdict_fields() {
        let word = match field.name.as_str() {
            "detection" => engine::detection(machine).map(str::to_owned),
            "status" => Some(outcome.status.word().to_owned()),
            "cause" => outcome.cause.map(|cause| cause.word().to_owned()),
            "causes" => outcome.causes.words(),
            NOTES => outcome.notes.words(),
            _ => Some(outcome.end_cause.word().to_owned()),
        };
        object.word(&field.name, word.as_deref());
    }
    let schema = TableSchema::new(Vec::new(), view.columns);
    for field in schema.outcome() {
        object.number(field, view.value(&field.name));
    }
    object.word(ENGINE_COLUMN, Some(machine.run.engine.word()));
    object.finish()
}
