//! `bladeoff modes`: whirl frequencies, critical speeds, ring frequencies.

use super::error::CliError;
use super::exit::Exit;
use super::json::{JsonObject, number, quoted};
use super::machine::{MachineArgs, build};
use super::output::{print, print_json, remark};
use super::plot::{refuse_other_formats, save};
use crate::engine;
use crate::pictures::{campbell, campbell_speeds, ring_shapes, rotor_shapes, unbalance_response};
use crate::terminal::{matrices_of, range_in_words, with_word};
use bladeoff_answers::figures::{self, Figure};
use bladeoff_answers::summary::{Align, TextTable};
use bladeoff_core::modal::{CriticalSpeed, ModesReport, OVERDAMPED, OverdampedMode, SpeedModes, UnstableRange, Whirl};
use bladeoff_model::machine::Machine;
use bladeoff_text::document::units::{format_digits, parse_bare_or_quantity};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

/// Whirl frequencies and damping, critical speeds, ring frequencies
///
/// For each speed: the damped lateral modes of the shaft line on its bearings with gyroscopic effect. Each has a
/// frequency, damping ratio, logarithmic decrement and sense of whirl. A negative damping ratio means unstable; 0 is
/// within the rounding of the eigenvalue problem.
///
/// The sense is forward, backward, mixed (nodes disagree) or planar (a straight line). The share beside it is +1 for
/// forward circles and -1 for backward ones. A mode keeps its number at all speeds: it is followed from rest by its
/// shape. Motions with a damping ratio from 0.9, or without a frequency, are overdamped. They and their critical speeds are
/// listed separately: no response has a peak there.
///
/// A warning names ranges of speed in which a whirl mode is unstable. The range that is checked goes up to 1.2 times the
/// initial speed, or to the first critical speed or a requested speed if that is higher.
///
/// The critical speeds (spin = whirl frequency) are next. AF is the amplification factor 1/(2 damping ratio), SM the
/// separation margin from the initial speed. The required margin is that of API 617: none for AF below 2.5, else up to 16 %
/// below and 26 % above the initial speed. A dash means not defined: at rest, unstable, or not excited by unbalance.
///
/// At the end are the free torsional and axial frequencies of the shaft line, and the frequencies of each flexible
/// diaphragm with their nodal diameters.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff modes studies/machines/lp_turbine_paper.toml
  bladeoff modes studies/machines/lp_turbine_paper.toml \\
    --speed 0 --speed \"1500 rpm\"
  bladeoff modes studies/machines/lab_rig.toml --json \\
    --set rotor.bearings.left.stiffness=\"1e6 N/m\"
  bladeoff modes studies/machines/lp_turbine_paper.toml \\
    --figures figures")]
pub struct Args {
    #[command(flatten)]
    machine: MachineArgs,

    /// Spin speed, in rad/s or with a unit ("1500 rpm"); may be given several times [default: 0 and the initial speed]
    #[arg(long = "speed", value_name = "SPEED")]
    speeds: Vec<String>,

    /// Largest number of modes printed of each kind; JSON has all
    #[arg(long, value_name = "N", default_value_t = 12)]
    count: usize,

    /// Print JSON: frequencies in Hz, speeds in rad/s
    #[arg(long)]
    json: bool,

    /// Also draw into this directory, as SVG and PNG: Campbell diagram with logarithmic decrements and separation margins,
    /// mode shapes, unbalance response (amplitudes from zero to peak, phase lags), the machine to scale
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
}

/// Relative rounding error of a printed speed, for comparison with the end of a table.
const ROUNDED: f64 = 1e-4;
/// Highest speed that may be requested \[rad/s\].
const FASTEST: f64 = 1e6;

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    if let Some(directory) = &args.figures {
        refuse_other_formats(directory, "--figures", &[])?;
    }
    let machine = build(&args.machine.load()?, &args.machine.given())?;
    let speeds = speeds(args, &machine)?;
    let (report, unstable) = with_word(
        || matrices_of(&machine),
        || {
            let report = engine::modes(&machine, &speeds)?;
            let top = speeds.iter().copied().fold(highest(&machine, &report.critical_speeds), f64::max);
            let unstable = engine::unstable_speeds(&machine, &engine::build(&machine)?, [0.0, top])?;
            Ok::<_, CliError>((report, unstable))
        },
    )?;
    if args.json {
        print_json(&json(&machine, &report, &unstable))?
    } else {
        print(&text(&machine, &report, args.count))?;
        outside_tables(&machine, &report).iter().for_each(|note| remark(&format!("note: {note}")));
        unstable.iter().for_each(|range| remark(&format!("warning: {}", range_in_words(range))));
    }
    if let Some(directory) = &args.figures {
        remark(&save(&with_word(|| format!("drawing {}", machine.name), || figures(&machine))?, directory)?.join("\n"));
    }
    Ok(Exit::Ok)
}

/// Highest speed of diagrams and of the search for instability \[rad/s\]: 1.2 times the running speed, or the first critical speed if that
/// is higher.
fn highest(machine: &Machine, critical: &[CriticalSpeed]) -> f64 {
    let first = critical.iter().find(|critical| critical.is_excited_by_unbalance()).or(critical.first());
    1.2 * machine.rotor.initial_speed.max(first.map_or(0.0, |critical| critical.speed))
}

/// The figures that exist for a machine.
fn figures(machine: &Machine) -> Result<Vec<(String, Figure)>, CliError> {
    let structure = engine::build(machine)?;
    let report = engine::modes(machine, &[])?;
    let critical = &report.critical_speeds;
    let top = highest(machine, critical);
    // a machine that neither rotates nor has a critical speed
    let top = if top > 0.0 { top } else { 2.0 * PI };
    let followed = engine::followed_modes(machine, &campbell_speeds(top))?;
    let mut all = vec![("campbell".to_owned(), campbell(machine, &followed, critical, top))];
    let drawn = [
        ("machine", figures::machine(machine)),
        ("mode-shapes", rotor_shapes(machine, &structure)),
        ("unbalance-response", unbalance_response(machine, critical, top)),
    ];
    all.extend(drawn.into_iter().filter_map(|(name, figure)| Some((name.to_owned(), figure?))));
    let rings = ring_shapes(machine, &structure, &report);
    let several = rings.len() > 1;
    let file = |name: String| if several { format!("ring-modes-{name}") } else { "ring-modes".to_owned() };
    all.extend(rings.into_iter().map(|(name, figure)| (file(name), figure)));
    Ok(all)
}

fn speeds(args: &Args, machine: &Machine) -> Result<Vec<f64>, CliError> {
    if args.speeds.is_empty() {
        let mut speeds = vec![0.0];
        speeds.extend(Some(machine.rotor.initial_speed).filter(|speed| *speed != 0.0));
        return Ok(speeds);
    }
    let read = |text: &String| {
        let refused = |message| CliError::Argument {
            argument: format!("--speed {text}"),
            message,
            allowed: Some(format!("a speed from 0 to {FASTEST:e} rad/s such as \"1500 rpm\", or a number in rad/s")),
        };
        let speed = parse_bare_or_quantity(text, "rad/s").map_err(|error| refused(error.to_string()))?;
        if (0.0..=FASTEST).contains(&speed) { Ok(speed) } else { Err(refused("out of range".to_owned())) }
    };
    args.speeds.iter().map(read).collect()
}

/// One line for each bearing table that does not cover all speeds of the report.
fn outside_tables(machine: &Machine, report: &ModesReport) -> Vec<String> {
    let rpm = |speed: f64| shown(speed * 30.0 / PI);
    let tables = machine.rotor.bearings.iter().filter_map(|bearing| Some((&bearing.name, bearing.table.as_ref()?)));
    tables
        .filter_map(|(name, table)| {
            let [first, last] = table.range();
            // a speed in rounded rpm may exceed the end of the table slightly
            let is_outside = |speed: &f64| *speed < first * (1.0 - ROUNDED) || *speed > last * (1.0 + ROUNDED);
            let asked = report.speeds.iter().map(|speed| speed.speed).filter(is_outside);
            let mut outside: Vec<String> = asked.map(|speed| format!("whirl at {} rpm", rpm(speed))).collect();
            let critical = report.critical_speeds.iter().map(|critical| critical.speed);
            let of = report.critical_speeds.len();
            let beyond: Vec<f64> = critical.filter(is_outside).collect();
            if !beyond.is_empty() {
                outside.push(format!("{} of {of} critical speeds", beyond.len()));
            }
            let [low, high] = [first, last].map(rpm);
            (!outside.is_empty()).then(|| {
                format!(
                    "rotor.bearings.{name}: its table covers {low} to {high} rpm; {} lie outside, where the coefficients of the nearer end of the \
                     table are used",
                    outside.join(", ")
                )
            })
        })
        .collect()
}

fn hertz(frequency: f64) -> f64 {
    frequency / (2.0 * PI)
}

fn text(machine: &Machine, report: &ModesReport, count: usize) -> String {
    let mut text = format!("machine {}\n", machine.name);
    for speed in &report.speeds {
        text.push_str(&whirl_table(speed, count));
        text.push_str(&overdamped_table(speed, count));
    }
    text.push_str(&critical_table(&report.critical_speeds, machine.rotor.initial_speed, count));
    text.push_str(&overdamped_critical_table(&report.overdamped_critical_speeds, count));
    for (name, frequencies) in [("torsion, free", &report.torsion), ("axial", &report.axial)] {
        let list: Vec<String> = frequencies.iter().take(count).map(|frequency| shown(hertz(*frequency))).collect();
        let list = if list.is_empty() { "none".to_owned() } else { list.join(", ") };
        writeln!(text, "\n{name} Hz{}: {list}", more(frequencies.len(), count)).expect(STRING);
    }
    for (name, modes) in &report.rings {
        writeln!(text, "\ndiaphragm {name}{}", more(modes.len(), count)).expect(STRING);
        let mut table = TextTable::new(&[
            ("mode", Align::Right),
            ("frequency Hz", Align::Right),
            ("nodal diameters", Align::Right),
        ]);
        for (at, mode) in modes.iter().take(count).enumerate() {
            table.row(vec![(at + 1).to_string(), shown(hertz(mode.frequency)), mode.nodal_diameters.to_string()]);
        }
        text.push_str(&table.render("  "));
    }
    text
}

fn critical_table(critical: &[CriticalSpeed], running: f64, count: usize) -> String {
    let mut table = TextTable::new(&[
        ("speed rpm", Align::Right),
        ("Hz", Align::Right),
        ("damping ratio", Align::Right),
        ("log decrement", Align::Right),
        ("whirl", Align::Left),
        ("share", Align::Right),
        ("AF", Align::Right),
        ("SM %", Align::Right),
        ("required %", Align::Right),
    ]);
    let percent = |margin: Option<f64>| match margin {
        None => "-".to_owned(),
        Some(margin) if margin >= 10.0 => ">999".to_owned(),
        Some(margin) => format!("{:.1}", 100.0 * margin),
    };
    let factor = |factor: f64| if factor.is_finite() { format_digits(factor, "", 3) } else { "inf".to_owned() };
    for critical in critical.iter().take(count) {
        let frequency = hertz(critical.speed);
        table.row(vec![
            shown(frequency * 60.0),
            shown(frequency),
            shown(critical.damping_ratio),
            shown(critical.decrement()),
            critical.whirl.word().to_owned(),
            share(critical.share),
            critical.amplification().map_or("-".to_owned(), factor),
            percent(critical.separation(running)),
            percent(critical.required_separation(running)),
        ]);
    }
    let near: Vec<String> = critical
        .iter()
        .filter(|critical| critical.is_too_near(running))
        .map(|critical| shown(hertz(critical.speed) * 60.0))
        .collect();
    let near = if near.is_empty() {
        String::new()
    } else {
        format!("  Below the required separation margin: {} rpm.\n", near.join(", "))
    };
    let more = more(critical.len(), count);
    format!("\ncritical speeds{more}\n{}{}{near}", table.render("  "), excited(critical))
}

fn shown(value: f64) -> String {
    format_digits(value, "", 5)
}

/// Net share of the whirl sense, with its sign; 0 if the sense is undetermined.
fn share(value: f64) -> String {
    if value.abs() < 0.005 { "0.00".to_owned() } else { format!("{value:+.2}") }
}

/// Note on the critical speeds that unbalance excites, if they include others than forward ones.
fn excited(critical: &[CriticalSpeed]) -> &'static str {
    if critical.iter().any(|critical| critical.whirl != Whirl::Forward && critical.is_excited_by_unbalance()) {
        "  Unbalance excites modes of every sense here, except backward ones with share -1.00: do not filter by `forward` alone.\n"
    } else {
        ""
    }
}

fn whirl_table(speed: &SpeedModes, count: usize) -> String {
    let (at, more) = (format_digits(speed.speed, "rad/s", 6), more(speed.whirl.len(), count));
    let mut table = TextTable::new(&[
        ("mode", Align::Right),
        ("frequency Hz", Align::Right),
        ("damping ratio", Align::Right),
        ("log decrement", Align::Right),
        ("whirl", Align::Left),
        ("share", Align::Right),
    ]);
    for (number, mode) in speed.whirl.iter().take(count) {
        table.row(vec![
            number.to_string(),
            shown(hertz(mode.frequency)),
            shown(mode.damping_ratio),
            shown(mode.decrement()),
            mode.whirl.word().to_owned(),
            share(mode.share),
        ]);
    }
    format!("\nwhirl at {at}{more}\n{}", table.render("  "))
}

/// Table of overdamped motions; empty without any.
fn overdamped_table(speed: &SpeedModes, count: usize) -> String {
    if speed.overdamped.is_empty() {
        return String::new();
    }
    let (at, more) = (format_digits(speed.speed, "rad/s", 6), more(speed.overdamped.len(), count));
    let mut table =
        TextTable::new(&[("decay 1/s", Align::Right), ("frequency Hz", Align::Right), ("damping ratio", Align::Right)]);
    for mode in speed.overdamped.iter().take(count) {
        let frequency = if mode.frequency > 0.0 { shown(hertz(mode.frequency)) } else { "none".to_owned() };
        table.row(vec![shown(mode.decay), frequency, shown(mode.damping_ratio)]);
    }
    let is_pair = |pair: &[OverdampedMode]| {
        pair.iter().all(|mode| mode.frequency == 0.0) && (pair[0].decay / pair[1].decay - 1.0).abs() < SAME
    };
    let has_pairs = speed.overdamped.windows(2).any(is_pair);
    let pairs = if has_pairs { "  Two equal rows are a pair: the same motion in each of two planes.\n" } else { "" };
    format!("\noverdamped at {at}: no whirl (damping ratio from {OVERDAMPED}){more}\n{}{pairs}", table.render("  "))
}

/// Critical speeds of overdamped motions; empty without any.
fn overdamped_critical_table(critical: &[CriticalSpeed], count: usize) -> String {
    if critical.is_empty() {
        return String::new();
    }
    let mut table = TextTable::new(&[
        ("speed rpm", Align::Right),
        ("Hz", Align::Right),
        ("damping ratio", Align::Right),
        ("whirl", Align::Left),
        ("share", Align::Right),
    ]);
    for critical in critical.iter().take(count) {
        let frequency = hertz(critical.speed);
        table.row(vec![
            shown(frequency * 60.0),
            shown(frequency),
            shown(critical.damping_ratio),
            critical.whirl.word().to_owned(),
            share(critical.share),
        ]);
    }
    let more = more(critical.len(), count);
    format!("\noverdamped critical speeds: no peak (damping ratio from {OVERDAMPED}){more}\n{}", table.render("  "))
}

/// Relative difference of two decay rates that count as equal: rounding of a double eigenvalue.
const SAME: f64 = 2e-6;

const STRING: &str = "writing to a String cannot fail";

fn more(all: usize, count: usize) -> String {
    if all > count { format!(" (the first {count} of {all})") } else { String::new() }
}

fn json(machine: &Machine, report: &ModesReport, unstable: &[UnstableRange]) -> String {
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    let mut object = JsonObject::default();
    object.word("machine", Some(&machine.name));
    let speeds = report.speeds.iter().map(|speed| {
        let modes = speed.whirl.iter().map(|(mode_number, mode)| {
            format!(
                "\n      {{\"mode\": {mode_number}, \"frequency_Hz\": {}, \"damping_ratio\": {}, \"log_decrement\": {}, \
                 \"whirl\": {}, \"whirl_share\": {}}}",
                number(hertz(mode.frequency)),
                number(mode.damping_ratio),
                number(mode.decrement()),
                quoted(mode.whirl.word()),
                number(mode.share)
            )
        });
        let overdamped = speed.overdamped.iter().map(|mode| {
            format!(
                "\n      {{\"decay_per_s\": {}, \"frequency_Hz\": {}, \"damping_ratio\": {}}}",
                number(mode.decay),
                number(hertz(mode.frequency)),
                number(mode.damping_ratio)
            )
        });
        let (modes, overdamped) = (list(modes.collect()), list(overdamped.collect()));
        format!(
            "\n    {{\"speed_rad_s\": {}, \"modes\": {modes}, \"overdamped\": {overdamped}}}",
            number(speed.speed)
        )
    });
    object.raw("whirl", &list(speeds.collect()));
    let running = machine.rotor.initial_speed;
    let optional = |value: Option<f64>| number(value.unwrap_or(f64::NAN));
    let critical = report.critical_speeds.iter().map(|critical| {
        format!(
            "\n    {{\"speed_rad_s\": {}, \"damping_ratio\": {}, \"log_decrement\": {}, \"whirl\": {}, \"whirl_share\": {}, \
             \"excited_by_unbalance\": {}, \"amplification_factor\": {}, \"separation_margin\": {}, \
             \"required_separation_margin\": {}}}",
            number(critical.speed),
            number(critical.damping_ratio),
            number(critical.decrement()),
            quoted(critical.whirl.word()),
            number(critical.share),
            critical.is_excited_by_unbalance(),
            optional(critical.amplification()),
            optional(critical.separation(running)),
            optional(critical.required_separation(running))
        )
    });
    object.raw("critical_speeds", &list(critical.collect()));
    let overdamped = report.overdamped_critical_speeds.iter().map(|critical| {
        format!(
            "\n    {{\"speed_rad_s\": {}, \"damping_ratio\": {}, \"whirl\": {}, \"whirl_share\": {}}}",
            number(critical.speed),
            number(critical.damping_ratio),
            quoted(critical.whirl.word()),
            number(critical.share)
        )
    });
    object.raw("overdamped_critical_speeds", &list(overdamped.collect()));
    let ranges = unstable.iter().map(|range| {
        format!(
            "\n    {{\"from_rad_s\": {}, \"to_rad_s\": {}, \"frequency_Hz\": {}, \"damping_ratio\": {}, \"at_rad_s\": {}}}",
            number(range.from),
            number(range.to),
            number(hertz(range.worst.frequency)),
            number(range.worst.ratio),
            number(range.worst_at)
        )
    });
    object.raw("unstable", &list(ranges.collect()));
    let frequencies = |all: &[f64]| list(all.iter().map(|frequency| number(hertz(*frequency))).collect());
    object.raw("torsion_Hz", &frequencies(&report.torsion));
    object.raw("axial_Hz", &frequencies(&report.axial));
    let rings = report.rings.iter().map(|(name, modes)| {
        let modes = modes.iter().map(|mode| {
            format!(
                "\n      {{\"frequency_Hz\": {}, \"nodal_diameters\": {}}}",
                number(hertz(mode.frequency)),
                mode.nodal_diameters
            )
        });
        format!("\n    {{\"diaphragm\": {}, \"modes\": {}}}", quoted(name), list(modes.collect()))
    });
    object.raw("rings", &list(rings.collect()));
    object.raw("notes", &list(outside_tables(machine, report).iter().map(|note| quoted(note)).collect()));
    object.finish()
}
