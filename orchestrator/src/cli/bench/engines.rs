//! `bladeoff bench engines`: cost of a transient on the engine `reduced`, in this or another program, and on `exponential`.

use super::super::error::CliError;
use super::super::exit::Exit;
use super::super::output::{print, remark};
use super::host::{Folder, hardware, load};
use crate::engine;
use crate::run::timestamp;
use bladeoff_answers::summary::{Align, TextTable};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{END_TIME, Engine, Machine, MachineDef, ParamValue};
use bladeoff_model::outcome::Outcome;
use bladeoff_system::files::FileError;
use bladeoff_worker::process::thread_cpu_time;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// Cost of a transient on the engines "reduced" and "exponential", side by side
///
/// Transients: the turbine to 6 s with each of the three detections, the lab rig, and 6 s of free motion of the turbine
/// without its diaphragm, alternately on both engines. Variants of the lab rig with nearly the same motion follow: bearing
/// tables, pedestals, both, and a second ring out of reach. A second table compares their CPU time per step with that of
/// the lab rig. CPU time is printed. It is longer on a busy computer: measure on a
/// quiet one, and use ratios of a busy one with care. Runs of a study share matrices, modes and bases, so the set-up is
/// printed separately. With --against, the runs of "reduced" are computed by another bladeoff program, without the CPU
/// time of its start.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Another bladeoff program, which computes the runs of "reduced" by its command `simulate`
    #[arg(long, value_name = "BINARY")]
    against: Option<PathBuf>,

    /// Runs of "reduced" per transient; "exponential" has five times as many
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,

    /// Begin no further run after this many minutes; each transient has at least one run of each engine
    #[arg(long, value_name = "MINUTES", default_value_t = 10.0, value_parser = minutes)]
    minutes: f64,

    /// Compute only this fraction of each transient, from its beginning, where contact may not occur
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = part)]
    part: f64,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn minutes(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|minutes| (0.0..=1440.0).contains(minutes)).ok_or_else(|| "must be 0 to 1440".to_owned())
}

fn part(text: &str) -> Result<f64, String> {
    let part = text.parse().ok().filter(|part| *part > 0.0 && *part <= 1.0);
    part.ok_or_else(|| "must be above 0 and at most 1".to_owned())
}

/// Number of runs of the fast engine for each run of the other engine.
const MORE: u32 = 5;
/// End time of a run whose CPU time is that of the program start \[s\].
const AT_ONCE: f64 = 1e-4;

// links to studies/machines: a published package contains the files themselves
const TURBINE: &str = include_str!("lp_turbine_paper.toml");
pub(super) const RIG: &str = include_str!("lab_rig.toml");

/// A transient: name, machine, and whether contact occurs.
struct Case {
    name: &'static str,
    text: String,
    touches: bool,
}

/// Name of the transient with which its variants are compared.
const REFERENCE: &str = "lab rig";

/// The lab rig with additional parts. Tables and pedestals have nearly the stiffness of its bearings, so motion and contact are nearly the same.
fn variants() -> [Case; 4] {
    let linear = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"";
    let table = "kind = \"table\"\ncoefficients.speeds = [0, 200, 400]\ncoefficients.kxx = [2e6, 2.01e6, 2.02e6]\n\
                 coefficients.kyy = [2e6, 2.01e6, 2.02e6]\ncoefficients.cxx = [606, 603, 600]\ncoefficients.cyy = [606, 603, 600]";
    let pedestal = |name| format!("[rotor.bearings.{name}.pedestal]\nmass = 20\nstiffness = 2e9\ndamping = 1e4\n");
    let pedestals = format!("\n{}{}", pedestal("left"), pedestal("right"));
    let tables = RIG.replace(linear, table);
    let ring =
        RIG.split_once("[diaphragms.seal]").map_or("", |(_, ring)| ring).replace("diaphragms.seal", "diaphragms.far");
    let far = format!("\n[diaphragms.far]{}", ring.replace("position = \"0.5 m\"", "position = \"0.15 m\""));
    let case = |name, text| Case { name, text, touches: true };
    [
        case("lab rig, tables", tables.clone()),
        case("lab rig, pedestals", RIG.to_owned() + &pedestals),
        case("lab rig, tables and pedestals", tables + &pedestals),
        case("lab rig, a ring out of reach", RIG.to_owned() + &far),
    ]
}

fn cases() -> Vec<Case> {
    // the tables of the diaphragm are at the end of the file
    let flight = TURBINE.split_once("[diaphragms").map_or(TURBINE, |(before, _)| before).to_owned();
    let detected = |detection: &str| TURBINE.replace("detection = \"hyp2\"", &format!("detection = \"{detection}\""));
    let cases = [
        Case { name: "turbine to 6 s", text: TURBINE.to_owned(), touches: true },
        Case { name: "turbine to 6 s, hyp1", text: detected("hyp1"), touches: true },
        Case { name: "turbine to 6 s, hyp2-frozen", text: detected("hyp2-frozen"), touches: true },
        Case { name: REFERENCE, text: RIG.to_owned(), touches: true },
        Case { name: "6 s of free motion", text: flight, touches: false },
    ];
    cases.into_iter().chain(variants()).collect()
}

/// CPU times of a transient \[s\].
struct Measured {
    name: &'static str,
    /// CPU time of each run of `reduced`, and of each run of `exponential`.
    reduced: Vec<f64>,
    exponential: Vec<f64>,
    /// Matrices, modes and bases, computed once for all runs of `exponential`.
    set_up: f64,
    first_contact: Option<f64>,
    /// Work of a run of `reduced` in this program, and of a run of `exponential`.
    work: [Option<Work>; 2],
}

/// Steps of a run, and its time in contact \[s\].
#[derive(Clone, Copy)]
struct Work {
    steps: f64,
    contact: f64,
}

impl Work {
    fn of(machine: &Machine, outcome: &Outcome) -> Option<Self> {
        let contact = value_of(machine, outcome, "contact_time_s").unwrap_or(0.0);
        Some(Self { steps: value_of(machine, outcome, "steps")?, contact })
    }
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let deadline = Instant::now() + Duration::from_secs_f64(60.0 * args.minutes);
    let begun = (timestamp(SystemTime::now()), load());
    let folder = Folder::new()?;
    let mut all = Vec::new();
    for case in cases() {
        remark(&format!("{} ...", case.name));
        all.push(measure(&case, args, &folder.0, deadline)?);
    }
    let (date, before) = begun;
    let after = load();
    if args.json {
        let cases: Vec<Value> = all.iter().map(|one| figures(one, &all)).collect();
        let against = args.against.as_ref().map(|path| path.to_string_lossy().into_owned());
        let text = json!({
            "date": date, "hardware": hardware(), "load_before": before, "load_after": after, "against": against,
            "part": args.part, "cases": cases,
        });
        print(&format!("{text}\n"))?;
        return Ok(Exit::Ok);
    }
    let of = match &args.against {
        Some(path) => format!("reduced: {}", bladeoff_system::shown(path)),
        None => "reduced: this program".to_owned(),
    };
    let part = if args.part < 1.0 { format!("; the first {} of each", args.part) } else { String::new() };
    print(&format!("{date}, {}, load before and after: {before}, {after}\n{of}{part}\n\n{}", hardware(), text(&all)))?;
    Ok(Exit::Ok)
}

fn measure(case: &Case, args: &Args, folder: &Path, deadline: Instant) -> Result<Measured, CliError> {
    let machine = |engine| machine(case, engine, args.part);
    let (fast, slow) = (machine(Engine::Exponential)?, machine(Engine::Reduced)?);
    let before = thread_cpu_time();
    let structure = engine::build(&fast)?;
    engine::try_start(&fast, &structure)?;
    // includes the bases for the speeds that the run reaches
    let first = engine::simulate(&fast, &structure)?;
    let with_bases = (thread_cpu_time() - before).as_secs_f64();
    let first_contact = value_of(&fast, &first, "first_contact_s");
    let expected = case.touches && args.part >= 1.0;
    if first_contact.is_some() != expected && (expected || !case.touches) {
        let source = std::io::Error::other(format!("{}: contact is not as expected", case.name));
        return Err(FileError::at("measure", folder)(source).into());
    }
    let program = args.against.as_deref().map(|binary| Program::new(binary, case, &slow, folder)).transpose()?;
    let own = if program.is_none() { Some(engine::build(&slow)?) } else { None };
    let work = [None, Work::of(&fast, &first)];
    let mut measured =
        Measured { name: case.name, reduced: Vec::new(), exponential: Vec::new(), set_up: 0.0, first_contact, work };
    for repeat in 0..args.repeats {
        if repeat > 0 && Instant::now() >= deadline {
            break;
        }
        measured.reduced.push(match (&program, &own) {
            (Some(program), _) => program.run()?,
            (None, Some(structure)) => {
                let (time, outcome) = run(&slow, structure)?;
                measured.work[0] = Work::of(&slow, &outcome);
                time
            }
            (None, None) => break,
        });
        for _ in 0..MORE {
            measured.exponential.push(run(&fast, &structure)?.0);
        }
    }
    measured.set_up = (with_bases - least(&measured.exponential)).max(0.0);
    Ok(measured)
}

fn machine(case: &Case, engine: Engine, part: f64) -> Result<Machine, CliError> {
    let mut definition = MachineDef::parse(case.name, &case.text)?;
    definition.settle(engine);
    if let Ok(info) = definition.resolve(END_TIME)
        && let Some(ParamValue::Number(end)) = info.value
    {
        definition.set(&info, &ParamValue::Number(part * end)).expect("a time that is shorter");
    }
    Ok(definition.build()?)
}

/// CPU time \[s\] and outcome of one run.
fn run(machine: &Machine, structure: &Structure) -> Result<(f64, Outcome), CliError> {
    let before = thread_cpu_time();
    let outcome = engine::simulate(machine, structure)?;
    Ok(((thread_cpu_time() - before).as_secs_f64(), outcome))
}

fn value_of(machine: &Machine, outcome: &Outcome, name: &str) -> Option<f64> {
    let place = engine::columns(machine).iter().position(|column| column.name == name)?;
    outcome.values.get(place).copied().flatten()
}

/// Another program, prepared to compute a transient.
struct Program<'a> {
    binary: &'a Path,
    machine: PathBuf,
    end: f64,
    /// CPU time of its start, including modes \[s\].
    start: f64,
}

impl<'a> Program<'a> {
    fn new(binary: &'a Path, case: &Case, machine: &Machine, folder: &Path) -> Result<Self, CliError> {
        let path = folder.join(format!("{}.toml", case.name.replace(' ', "-")));
        fs::write(&path, &case.text).map_err(FileError::at("write", &path))?;
        let mut program = Self { binary, machine: path, end: machine.run.end_time, start: 0.0 };
        program.start = program.cpu(AT_ONCE)?;
        Ok(program)
    }

    fn run(&self) -> Result<f64, CliError> {
        Ok((self.cpu(self.end)? - self.start).max(0.0))
    }

    /// CPU time of a run with this end time \[s\].
    fn cpu(&self, end: f64) -> Result<f64, CliError> {
        let failed = |source| FileError::at("run", self.binary)(source);
        let before = of_children().map_err(failed)?;
        let mut command = Command::new(self.binary);
        command.arg("simulate").arg(&self.machine).args(["--engine", "reduced", "--json"]);
        command.args(["--set", &format!("{END_TIME}={end:?}")]);
        let output = command.stdin(Stdio::null()).output().map_err(failed)?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            return Err(failed(std::io::Error::other(format!("{}: {said}", output.status))).into());
        }
        Ok(of_children().map_err(failed)? - before)
    }
}

/// Ticks per second of the CPU times in /proc, 100 on every supported Linux.
const TICKS: f64 = 100.0;

/// CPU time of all ended child processes \[s\].
fn of_children() -> std::io::Result<f64> {
    let text = fs::read_to_string("/proc/self/stat")?;
    // after the name in parentheses, which may contain any characters: state is field 3, cutime and cstime are 16 and 17
    let fields: Vec<&str> = text.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace().collect();
    let ticks = |field: usize| fields.get(field - 3).and_then(|text| text.parse::<f64>().ok());
    match (ticks(16), ticks(17)) {
        (Some(user), Some(system)) => Ok((user + system) / TICKS),
        _ => Err(std::io::Error::other("/proc/self/stat has no CPU time of children")),
    }
}

fn least(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted.len().saturating_sub(1) / 2, sorted.len() / 2);
    sorted.get(low).zip(sorted.get(high)).map_or(f64::NAN, |(low, high)| 0.5 * (low + high))
}

fn text(all: &[Measured]) -> String {
    let mut table = TextTable::new(&[
        ("CPU time [s]", Align::Left),
        ("reduced: least", Align::Right),
        ("median", Align::Right),
        ("runs", Align::Right),
        ("exponential: least", Align::Right),
        ("median", Align::Right),
        ("runs", Align::Right),
        ("set-up", Align::Right),
        ("ratio: least", Align::Right),
        ("median", Align::Right),
    ]);
    for one in all {
        let seconds = |value: f64| if value < 1.0 { format!("{value:.4}") } else { format!("{value:.2}") };
        let mut cells = vec![one.name.to_owned()];
        for times in [&one.reduced, &one.exponential] {
            cells.extend([seconds(least(times)), seconds(median(times)), times.len().to_string()]);
        }
        cells.push(seconds(one.set_up));
        cells.extend([least, median].map(|of| format!("{:.1}", of(&one.reduced) / of(&one.exponential))));
        table.row(cells);
    }
    format!("{}\n{}", table.render(""), per_step(all))
}

/// CPU time per step of the variants, relative to that of the lab rig. `reduced` is empty if another program computed it.
fn per_step(all: &[Measured]) -> String {
    let mut table = TextTable::new(&[
        ("per step, relative to the lab rig", Align::Left),
        ("reduced", Align::Right),
        ("steps", Align::Right),
        ("contact [ms]", Align::Right),
        ("exponential", Align::Right),
        ("steps", Align::Right),
        ("contact [ms]", Align::Right),
    ]);
    for one in all.iter().filter(|one| one.name.starts_with(REFERENCE)) {
        let mut cells = vec![one.name.to_owned()];
        for (work, ratio) in one.work.iter().zip(relative(one, all)) {
            let number =
                |value: Option<f64>, digits| value.map_or_else(String::new, |value| format!("{value:.digits$}"));
            cells.push(number(ratio, 3));
            cells.extend([number(work.map(|work| work.steps), 0), number(work.map(|work| 1e3 * work.contact), 2)]);
        }
        table.row(cells);
    }
    table.render("")
}

/// Smallest CPU time per step relative to the lab rig, on `reduced` and on `exponential`.
fn relative(one: &Measured, all: &[Measured]) -> [Option<f64>; 2] {
    let cost = |of: &Measured, engine: usize| {
        let times = [&of.reduced, &of.exponential][engine];
        of.work[engine].map(|work| least(times) / work.steps)
    };
    let reference = all.iter().find(|other| other.name == REFERENCE);
    [0, 1].map(|engine| Some(cost(one, engine)? / cost(reference?, engine)?))
}

fn figures(one: &Measured, all: &[Measured]) -> Value {
    let of = |times: &[f64]| json!({ "least_s": least(times), "median_s": median(times), "runs": times });
    let ratio = |of: fn(&[f64]) -> f64| of(&one.reduced) / of(&one.exponential);
    json!({
        "name": one.name, "reduced": of(&one.reduced), "exponential": of(&one.exponential), "set_up_s": one.set_up,
        "first_contact_s": one.first_contact, "ratio_least": ratio(least), "ratio_median": ratio(median),
        "steps": one.work.map(|work| work.map(|work| work.steps)),
        "per_step_of_lab_rig": Some(relative(one, all)).filter(|_| one.name.starts_with(REFERENCE)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "sums of few bits")]
    fn medians_are_the_middle_and_cases_are_what_their_names_say() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0]), least(&[2.0, 1.0])), (2.0, 2.5, 1.0));
        assert!(median(&[]).is_nan());
        for case in cases() {
            let machine = machine(&case, Engine::Exponential, 0.5).expect("a machine");
            assert_eq!(machine.diaphragms.is_empty(), !case.touches, "{}", case.name);
            assert_eq!(machine.run.end_time, if case.name.starts_with(REFERENCE) { 0.3 } else { 3.0 });
            let tables = machine.rotor.bearings.iter().filter(|bearing| bearing.table.is_some()).count();
            let pedestals = machine.rotor.bearings.iter().filter(|bearing| bearing.pedestal.is_some()).count();
            let has = |word: &str| case.name.contains(word);
            assert_eq!([tables, pedestals], [2 * usize::from(has("tables")), 2 * usize::from(has("pedestals"))]);
            assert_eq!(machine.diaphragms.len(), usize::from(case.touches) + usize::from(has("out of reach")));
        }
        assert!(of_children().expect("the kernel says it") >= 0.0);
    }
}
