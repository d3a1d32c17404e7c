//! `bladeoff check`: everything about a study except its results.

use super::answer::asked_in_words;
use super::check_json;
use super::error::CliError;
use super::estimate::estimate;
use super::exit::Exit;
use super::forecast;
use super::functions;
use super::output::{print, print_json, remark, tell, width};
use super::run::{PartArgs, default_workers};
use super::shared::shared;
use crate::engine;
use crate::engine_choice::machine_alone;
use crate::html_report::{bearings_of, reservations, reservations_of, unstable_of};
use crate::plausible::{implausible, implausible_of, unreleased, unreleased_of};
use crate::questions::related;
use crate::start_check::placed;
use crate::terminal::{Stability, bearings_beyond, matrices_of, unstable, with_word};
use bladeoff_answers::summary::{Align, TextTable, counted, wrapped};
use bladeoff_core::engine::speeds_of_run;
use bladeoff_core::modal::equilibrium;
use bladeoff_model::machine::{Machine, MachineDef, ParamValue};
use bladeoff_study::{
    Axis, Fixed, Origin, Samples, StudyError, fixed_angle, idle_levels, read_input, show, with_tables,
};
use bladeoff_system::shown;
use bladeoff_text::document::MAX_FILE_BYTES;
use bladeoff_text::document::units::format_digits;
use std::path::{Path, PathBuf};

/// Check a study: parameters, number of samples, duration; or check a machine
///
/// Reads study, machine and points file and reports every problem with its place. Prints each uncertain parameter as it
/// was interpreted, with mean and standard deviation after truncation. Builds the machine of every sample, so that
/// impossible combinations are found before anything runs (above 100000 samples: every value and every corner). Prints
/// the engine with the reason, the assumptions of the machine, and a forecast of contact.
///
/// Then times up to seven samples, spread over all axes, each for at most 20 s of CPU time and together 90 s. From these
/// it estimates the duration of the whole study as a range. Nothing is written. A machine file is checked alone, up to
/// the start of its run.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bladeoff check studies/first-look.toml\n  bladeoff check studies/first-look.toml --list | less\n  bladeoff check studies/first-look.toml --json \\\n    | jq .estimate"
)]
pub struct Args {
    /// Study file (TOML; format in docs/studies.md)
    study: PathBuf,

    /// Print every sample with its number and parameters, tab-separated, in SI units; no sample is timed
    #[arg(long)]
    list: bool,

    /// Print JSON: samples, parameters, design, questions, assumptions, warnings and the estimated duration
    #[arg(long, conflicts_with = "list")]
    json: bool,

    #[command(flatten)]
    part: PartArgs,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let samples = match args.part.load(&args.study) {
        // a machine file alone has no samples to list and no parts, so it is accepted only without these options
        Err(CliError::Study(StudyError::AMachine { path })) if !args.list && args.part.words().is_empty() => {
            return machine(&path, args.json);
        }
        samples => samples?,
    };
    if args.list {
        list(&samples)?;
        return Ok(Exit::Ok);
    }
    if args.json {
        print_json(&check_json::of_study(&samples)?)?;
        return Ok(Exit::Ok);
    }
    tell(&(describe(&samples) + &asked_in_words(&samples)?))?;
    let more = forecast::of_study(&samples, width());
    if !more.is_empty() {
        tell(&more)?;
    }
    if let Some(model) = samples.study().function() {
        functions::estimate(&samples, model, default_workers())?;
        return Ok(Exit::Ok);
    }
    for said in idle_levels(&samples) {
        remark(&format!("\n{said}"));
    }
    if let Some(found) = fixed_angle(&samples) {
        remark(&format!("\n{}", found.text().trim_end()));
    }
    for note in bearings_of(&samples) {
        remark(&format!("\nnote: {note}"));
    }
    for note in unreleased_of(&samples) {
        remark(&format!("\nnote: {note}\n"));
    }
    for one in reservations_of(&samples) {
        remark(&format!("\nnote: {}", one.text));
    }
    for text in implausible_of(&samples) {
        remark(&format!("\nwarning: {text}"));
    }
    for range in unstable_of(&samples) {
        remark(&format!("\nwarning: {range}"));
    }
    estimate(&samples)?;
    Ok(Exit::Ok)
}

/// Checks a single machine: whether its run can start; prints the engine.
fn machine(path: &Path, as_json: bool) -> Result<Exit, CliError> {
    let text = with_tables(path, read_input(path, MAX_FILE_BYTES as u64)?)?;
    let mut definition = MachineDef::parse(&path.to_string_lossy(), &text)?;
    let mut machine = definition.build()?;
    let words = matrices_of(&machine);
    let (structure, choice) = with_word(|| words.clone(), || machine_alone(&mut definition, &mut machine))?;
    if let Err(error) = engine::try_start(&machine, &structure) {
        return Err(placed(&error, &definition, &machine, |_| false).map_or_else(|| error.into(), CliError::from));
    }
    let step = engine::time_step(&machine, &structure)?.step;
    let mut notes: Vec<String> = bearings_beyond(&machine, &structure, step).iter().map(|note| note.text()).collect();
    notes.extend(unreleased(&machine));
    notes.extend(reservations(&machine).into_iter().map(|one| one.text));
    let mut warnings = implausible(&machine);
    warnings.extend(unstable(&machine, &structure, speeds_of_run(&machine)).iter().map(ToString::to_string));
    if as_json {
        print_json(&check_json::of_machine(&definition, &machine, &notes, &warnings))?;
        return Ok(Exit::Ok);
    }
    let choice = choice.map(|choice| format!("Engine: {}\n", choice.words("the machine"))).unwrap_or_default();
    let mut stability = Stability::with(structure.clone());
    let more = forecast::of_machine(&definition, &machine, &mut stability, width());
    let rest = at_rest(&machine);
    tell(&format!("{}: a machine whose run can start\n{choice}{rest}{more}", definition.name()))?;
    notes.iter().for_each(|note| remark(&format!("note: {note}")));
    warnings.iter().for_each(|text| remark(&format!("warning: {text}")));
    Ok(Exit::Ok)
}

/// Sag and bearing reactions before the run; empty if no load acts on the rotor at rest.
fn at_rest(machine: &Machine) -> String {
    let Some(found) = equilibrium(machine) else { return String::new() };
    let place = found.position.map(|z| format!(" at {}", format_digits(z, "m", 4))).unwrap_or_default();
    let mut lines =
        vec![format!("Static equilibrium: largest displacement {}{place}", format_digits(found.sag, "m", 4))];
    let mut pedestals = found.pedestals.iter();
    let components = |force: &[f64; 2]| {
        // relative to the other component this value is rounding error
        let least = 1e-9 * force[0].abs().max(force[1].abs());
        let [x, y] = force.map(|value| format_digits(if value.abs() < least { 0.0 } else { value }, "N", 4));
        format!("{x} along X, {y} along Y")
    };
    for (bearing, force) in machine.rotor.bearings.iter().zip(&found.bearings) {
        lines.push(format!("  force on bearing {}: {}", bearing.name, components(force)));
        if let Some(force) = bearing.pedestal.and_then(|_| pedestals.next()) {
            lines.push(format!("  force of its pedestal on the ground: {}", components(force)));
        }
    }
    lines.join("\n") + "\n"
}

fn describe(samples: &Samples) -> String {
    let study = samples.study();
    let mut text = format!(
        "{}: {} of {}\n\n",
        study.name,
        counted(samples.count(), "sample"),
        match study.function() {
            Some(model) => functions::formulas(model),
            None => format!("machine {}", shown(study.subject_name())),
        }
    );
    text.push_str(&drawn(samples));
    let mut table = TextTable::new(&[("varies", Align::Left), ("points", Align::Right), ("values", Align::Left)]);
    for (axis, kept) in study.axes.iter().zip(samples.kept()) {
        for varied in &axis.varied {
            let show = |position| show(&varied.info, &varied.values.at(position));
            let values = match axis.length {
                1..=4 => (0..axis.length).map(show).collect::<Vec<_>>().join(", "),
                length => format!("{}, {} ... {}", show(0), show(1), show(length - 1)),
            };
            table.row(vec![varied.info.path.clone(), points(axis, kept), values]);
        }
    }
    if study.parameters().is_empty() {
        text.push_str("Nothing varies.\n");
    } else if !study.axes.is_empty() {
        text.push_str(&table.fitting("", width()));
    }
    if let Some(choice) = study.engine() {
        text.push_str(&format!(
            "\n{}",
            wrapped(&format!("Engine: {}", choice.words("every sample")), width().unwrap_or(usize::MAX), "", "  ")
        ));
    }
    let fixed = study.machine().map(|machine| machine.fixed.as_slice()).unwrap_or_default();
    if !fixed.is_empty() {
        text.push_str("\nFixed by [set]:\n");
        for Fixed { info, value, .. } in fixed {
            text.push_str(&format!("  {} = {}\n", info.path, show(info, value)));
        }
    }
    if let Some(model) = study.function() {
        return text + &functions::described(model);
    }
    let shared = shared(samples);
    if !shared.is_empty() {
        text.push_str(&format!("\n{shared}"));
    }
    text
}

/// The design, and the interpretation of each uncertain and each derived parameter.
fn drawn(samples: &Samples) -> String {
    let study = samples.study();
    let width = width().unwrap_or(usize::MAX);
    let mut text = String::new();
    if let Some(layout) = samples.layout() {
        let (points, uncertain) = (
            counted(samples.points(), "point"),
            counted(study.sampled.distributions.len() as u64, "uncertain parameter"),
        );
        text.push_str(&format!("Design: {}, {points} of {uncertain}", layout.kind().word()));
        if layout.replicates() > 1 {
            text.push_str(&format!(", in {}", counted(layout.replicates(), "replicate")));
        }
        let groups = samples.groups().len() as u64;
        if groups > 1 {
            text.push_str(&format!("; the same points in each of {}", counted(groups, "combination")));
        }
        text.push_str(".\n");
        // statistics of the points that are used, not of all points in the file
        let whole = study.sampled.values.layout().and_then(|layout| layout.without_interval(layout.count()));
        let others = study.sampled.notes.iter().filter(|note| whole.as_ref() != Some(note));
        for note in layout.without_interval(samples.points()).iter().chain(&related(samples)).chain(others) {
            text.push_str(&wrapped(&format!("Note: {note}."), width, "", ""));
        }
        text.push('\n');
    }
    let mut lines = String::new();
    for (number, parameter) in study.parameters().iter().enumerate() {
        let said = match parameter.origin {
            Origin::Uncertain(_) => study.sampled.distributions[number].clone(),
            Origin::Derived(formula) => format!("= {}", study.sampled.formulas[formula]),
            Origin::Varied(..) => continue,
        };
        let name = match &parameter.short {
            Some(short) => format!("{} ({short})", parameter.info.path),
            None => parameter.info.path.clone(),
        };
        lines.push_str(&format!("{name}\n{}", wrapped(&said, width, "  ", "  ")));
    }
    for said in &study.sampled.correlated {
        lines.push_str(&wrapped(said, width, "", "  "));
    }
    if !lines.is_empty() {
        text.push_str(&lines);
        if !study.axes.is_empty() {
            text.push('\n');
        }
    }
    text
}

fn points(axis: &Axis, kept: u64) -> String {
    if kept == axis.length { kept.to_string() } else { format!("{kept} of {}", axis.length) }
}

fn list(samples: &Samples) -> Result<(), CliError> {
    let mut text = String::from("sample");
    for varied in samples.parameters() {
        text.push_str(&format!("\t{}", varied.column().name));
    }
    text.push('\n');
    for sample in 0..samples.count() {
        text.push_str(&sample.to_string());
        for value in samples.values(sample) {
            match value {
                ParamValue::Number(number) => text.push_str(&format!("\t{number:?}")),
                ParamValue::Choice(word) => text.push_str(&format!("\t{word}")),
            }
        }
        text.push('\n');
        if text.len() > 1 << 16 {
            print(&text)?;
            text.clear();
        }
    }
    print(&text)
}
