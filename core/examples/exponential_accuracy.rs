//! Measures what the exponential engine leaves and prints tables of `docs/theory/10-exponential-accuracy.md`:
//! `cargo run --release --workspace --example exponential_accuracy -- TABLE`, TABLE one of `starts` (81 starts of the turbine to 6 s and of the lab rig to 0.5 s, against smaller contact steps),
//! `places` (nine starts of both machines with `hyp1` and `hyp2-frozen`, against `reduced`, for `docs/theory/09-one-place.md`), `random` (ten machines of random dimensions, nine starts each, against `reduced` at an eighth of its default step; `random hyp1` and `random hyp2-frozen` likewise), `window` (one long rub of the turbine against `reduced` at 3.4 us), `modes` and `grid`.
//! One to five minutes each on one core. The candidates on the ring are a constant of the engine: their table is `modes` built with other ones.
#![allow(clippy::print_stdout, reason = "the tables are its output")]

#[path = "../tests/common/random.rs"]
mod random;

use bladeoff_core::engine::exponential::{RubbingRun, StepSettings, rubbing_run};
use bladeoff_core::engine::{TimeStep, simulate};
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};
use bladeoff_model::outcome::Status;
use random::{COMPARED, Found, STARTS, difference, machines};

const TURBINE: &str = include_str!("../../studies/machines/lp_turbine_paper.toml");
const RIG: &str = include_str!("../../studies/machines/lab_rig.toml");
const EXPONENTIAL: (&str, &str) = ("run.engine", "exponential");
const SHORT: (&str, &str) = ("run.end_time", "3.4 s");

/// Columns of the tables with their headings.
const COLUMNS: [(&str, &str); 13] = [
    ("end_speed_rad_s", "end speed"),
    ("max_bearing_load_front_N", "front"),
    ("max_bearing_load_rear_N", "rear"),
    ("contact_impulse_Ns", "impulse"),
    ("friction_energy_J", "friction energy"),
    ("max_filtered_contact_force_N", "1 ms force"),
    ("max_eccentricity_m", "eccentricity"),
    ("first_contact_s", "first contact"),
    ("contact_time_s", "contact time"),
    ("max_bending_stress_Pa", "shaft bending"),
    ("max_torsional_moment_Nm", "torsional moment"),
    ("max_blade_bending_stress_Pa", "blade bending"),
    ("energy_error", "energy error (value)"),
];

type Values = [f64; COLUMNS.len()];
type Failed = Box<dyn std::error::Error>;

fn machine(file: &str, sets: &[(&str, &str)]) -> Result<Machine, Failed> {
    let mut def = MachineDef::parse("machine.toml", file).map_err(|problems| problems.to_string())?;
    for (path, value) in sets {
        let info = def.resolve(path)?;
        let value = def.parse_value(&info, value)?;
        def.set(&info, &value)?;
    }
    Ok(def.build().map_err(|problems| problems.to_string())?)
}

fn row(machine: &Machine) -> Result<Values, Failed> {
    let outcome = simulate(machine, &Structure::build(machine, None)?, &mut NoHistory)?;
    if outcome.status != Status::Ok {
        println!("{:?}: {} {}", machine.run, outcome.status.word(), outcome.causes.words().unwrap_or_default());
    }
    let names = columns(machine);
    let value = |(name, _): (&str, &str)| {
        // names of the bearings of the lab rig
        let also = name.replace("front", "left").replace("rear", "right");
        let at = names.iter().position(|column| column.name == name || column.name == also);
        at.and_then(|at| outcome.values[at]).unwrap_or(f64::NAN)
    };
    Ok(COLUMNS.map(value))
}

fn head(first: &str) {
    println!("\n| {first} | {} |", COLUMNS.map(|(_, name)| name).join(" | "));
    println!("|---|{}", "---:|".repeat(COLUMNS.len()));
}

/// Prints differences relative to a reference; the energy error unchanged.
fn line(name: &str, found: &Values, reference: &Values) {
    let cell = |k: usize| {
        if k + 1 == COLUMNS.len() {
            format!("{:.1e}", found[k])
        } else {
            format!("{:+.1e}", found[k] / reference[k] - 1.0)
        }
    };
    println!("| {name} | {} |", (0..COLUMNS.len()).map(cell).collect::<Vec<_>>().join(" | "));
}

fn plan(file: &str) -> Result<TimeStep, Failed> {
    let machine = machine(file, &[EXPONENTIAL])?;
    Ok(TimeStep::new(&machine, &Structure::build(&machine, None)?)?)
}

/// `2/omega_max` of the ring's modes \[s\].
fn largest_step(file: &str) -> Result<f64, Failed> {
    Ok(2.0 / plan(file)?.highest_frequency)
}

/// Contact steps of the tables of starts, as parts of `2/omega_max`: candidates for the default, and the reference, an eighth of `2/omega_max`.
const PARTS: [f64; 5] = [0.9, 2.0 / 3.0, 0.5, 0.25, 0.125];

/// Number of initial speeds around that of a file: the 1 ms force of one start scatters by 1 %, the mean of nine by 0.3 %.
const SPEEDS: i32 = 81;

/// This number of initial speeds, -0.4 to +0.4 %, each with contact steps of all parts.
fn starts(file: &str, end: &str) -> Result<(), Failed> {
    let of = |sets: &[(&str, &str)]| machine(file, &[&[EXPONENTIAL, ("run.end_time", end)], sets].concat());
    let (speed, largest) = (of(&[])?.rotor.initial_speed, largest_step(file)?);
    let mut found: Vec<Vec<Values>> = Vec::new();
    for start in 0..SPEEDS {
        let speed = format!("{:?} rad/s", speed * (1.0 + 1e-4 * f64::from(start - SPEEDS / 2)));
        let run = |part: &f64| {
            let step = format!("{:e} s", part * largest);
            row(&of(&[("rotor.initial_speed", &speed), ("run.contact_step", &step)])?)
        };
        found.push(PARTS.iter().map(run).collect::<Result<_, _>>()?);
    }
    let reference = PARTS.len() - 1;
    let mean = |part: usize| -> Values {
        std::array::from_fn(|k| found.iter().map(|runs| runs[part][k]).sum::<f64>() / found.len() as f64)
    };
    let largest_of = |part: usize| -> Values {
        let of = |k: usize| {
            let one = |runs: &Vec<Values>| {
                if k + 1 == COLUMNS.len() {
                    runs[part][k]
                } else {
                    (runs[part][k] / runs[reference][k] - 1.0).abs() + 1.0
                }
            };
            found.iter().map(one).fold(0.0, f64::max)
        };
        std::array::from_fn(of)
    };
    head(&format!("means of {SPEEDS} starts to {end}, against {} of 2/omega_max = {largest:.3e} s", PARTS[reference]));
    for (part, name) in PARTS.iter().enumerate().take(reference) {
        line(&format!("{name:.3}"), &mean(part), &mean(reference));
    }
    for (part, name) in PARTS.iter().enumerate().take(reference) {
        line(&format!("{name:.3}, largest of one"), &largest_of(part), &[1.0; COLUMNS.len()]);
    }
    Ok(())
}

fn window() -> Result<(), Failed> {
    let largest = largest_step(TURBINE)?;
    let of = |sets: &[(&str, &str)]| row(&machine(TURBINE, &[&[SHORT], sets].concat())?);
    let reference = of(&[("run.step", "3.4e-6 s")])?;
    head("to 3.4 s, against reduced at 3.4 us");
    for part in [0.9, 2.0 / 3.0, 0.5, 0.25, 0.125, 0.0625] {
        let step = format!("{:e} s", part * largest);
        line(&format!("{part:.3}"), &of(&[EXPONENTIAL, ("run.contact_step", &step)])?, &reference);
    }
    line("reduced, 6.7 us", &of(&[("run.step", "6.7e-6 s")])?, &reference);
    line("reduced, default", &of(&[("run.engine", "reduced")])?, &reference);
    Ok(())
}

/// Numbers of modes, at a contact step that all of them allow.
fn modes() -> Result<(), Failed> {
    let step = ("run.contact_step", "3.4e-6 s");
    let of = |rotor: &str, ring: &str| {
        row(&machine(TURBINE, &[EXPONENTIAL, SHORT, step, ("run.rotor_modes", rotor), ("run.ring_modes", ring)])?)
    };
    let default = row(&machine(TURBINE, &[EXPONENTIAL, SHORT, step])?)?;
    println!("{default:?}");
    let reference = of("48", "96")?;
    head("to 3.4 s at 3.4 us, against 48 rotor and 96 ring modes");
    line("default", &default, &reference);
    for (rotor, ring) in
        [("16", "36"), ("24", "24"), ("24", "36"), ("24", "48"), ("24", "64"), ("24", "96"), ("36", "36"), ("48", "36")]
    {
        line(&format!("{rotor} rotor, {ring} ring"), &of(rotor, ring)?, &reference);
    }
    Ok(())
}

fn grid() -> Result<(), Failed> {
    let step = plan(TURBINE)?.step;
    let machine = machine(TURBINE, &[EXPONENTIAL, SHORT])?;
    let structure = Structure::build(&machine, None)?;
    let of = |spacing: f64, cells: u32| -> Result<RubbingRun, Failed> {
        // the default spacing: the power of two nearest to a 37th of the initial speed
        let default = libm::exp2(libm::round(libm::log2(machine.rotor.initial_speed / 37.5)));
        let settings = StepSettings { spacing: Some(spacing * default), cells, ..StepSettings::of_step(step) };
        Ok(rubbing_run(&machine, &structure, settings, true)?)
    };
    let values = |run: &RubbingRun| {
        let first = run.first_contact.unwrap_or(f64::NAN);
        [
            run.end_speed,
            run.largest_loads[0],
            run.largest_loads[1],
            run.impulse,
            run.friction_energy,
            run.largest_filtered_force,
            run.eccentricity,
            first,
        ]
    };
    let reference = values(&of(0.125, 80)?);
    println!(
        "\n| spacing, cells, to 3.4 s at {step:e} s, against an eighth of the spacing with 80 | {} |",
        COLUMNS[..8].iter().map(|(_, name)| *name).collect::<Vec<_>>().join(" | ")
    );
    println!("|---|{}", "---:|".repeat(8));
    for (spacing, cells) in [(2.0, 80), (1.0, 40), (0.5, 20), (1.0, 8), (1.0, 160), (0.25, 10), (0.125, 40)] {
        let found = values(&of(spacing, cells)?);
        let cells_of: Vec<String> = found.iter().zip(reference).map(|(a, b)| format!("{:+.1e}", a / b - 1.0)).collect();
        println!("| {spacing}, {cells} | {} |", cells_of.join(" | "));
    }
    Ok(())
}

/// Contact steps and the default step of `reduced` against `reduced` at an eighth of that step, and against the limit of the exponential engine.
fn random_machines(detection: &str) -> Result<(), Failed> {
    let mut all: Vec<[Vec<[[f64; 2]; COMPARED.len()]>; 2]> = Vec::new();
    let names: Vec<String> =
        PARTS.iter().map(|part| format!("{part:.3}")).chain(["reduced".to_owned(), "limit".to_owned()]).collect();
    println!(
        "\n| machine | kind | starts | first contact | impacts | spread of load, impulse | largest energy error, not ok, at {names:?} |\n|---|---|---:|---:|---:|---:|---|"
    );
    for (case, machine) in machines(10, detection).iter().enumerate() {
        let [largest, step] = machine.steps();
        let starts = machine.starts();
        if starts.len() < STARTS {
            return Err(format!("machine {case} touches in {} starts", starts.len()).into());
        }
        let of =
            |engine, step: f64| -> Vec<Found> { starts.iter().map(|start| start.run(engine, Some(step))).collect() };
        let reference = of(Engine::Reduced, 0.125 * step);
        let limit = of(Engine::Exponential, 0.03125 * largest);
        let mut runs: Vec<Vec<Found>> = PARTS.iter().map(|part| of(Engine::Exponential, part * largest)).collect();
        runs.push(of(Engine::Reduced, step));
        let spread = |column: usize| {
            let least = reference.iter().map(|run| run.values[column]).fold(f64::INFINITY, f64::min);
            let most = reference.iter().map(|run| run.values[column]).fold(0.0, f64::max);
            100.0 * (most / least - 1.0)
        };
        let impacts: Vec<String> = reference.iter().map(|run| format!("{}", run.impacts)).collect();
        let energy: Vec<String> = runs
            .iter()
            .map(|runs| {
                let wrong = runs.iter().filter(|run| run.outcome.status != Status::Ok).count();
                format!("{:.1e} {wrong}", runs.iter().map(|run| run.energy_error).fold(0.0, f64::max))
            })
            .collect();
        println!(
            "| {case} | {} | {} | {:.4} to {:.4} s | {} | {:.1} %, {:.1} % | {} |",
            machine.kind,
            starts.len(),
            starts.iter().map(|s| s.first_contact).fold(f64::INFINITY, f64::min),
            starts.iter().map(|s| s.first_contact).fold(0.0, f64::max),
            impacts.join(" "),
            spread(1),
            spread(2),
            energy.join(", ")
        );
        let mut against = [&reference, &limit].map(|against| -> Vec<[[f64; 2]; COMPARED.len()]> {
            runs.iter().map(|runs| std::array::from_fn(|column| difference(runs, against, column))).collect()
        });
        against[0].push(std::array::from_fn(|column| difference(&limit, &reference, column)));
        all.push(against);
    }
    for (column, (_, head)) in COMPARED.iter().enumerate() {
        println!("\n| {head}, 1e-4, mean (scatter) | {} |\n|---|{}", names.join(" | "), "---:|".repeat(names.len()));
        for (case, [found, _]) in all.iter().enumerate() {
            let cells: Vec<String> = found
                .iter()
                .map(|found| format!("{:+.1} ({:.1})", 1e4 * found[column][0], 1e4 * found[column][1]))
                .collect();
            println!("| {case} | {} |", cells.join(" | "));
        }
    }
    for (against, what) in ["reduced at an eighth", "the own limit"].iter().enumerate() {
        for (kind, of) in ["mean of |mean difference|", "largest |mean difference|", "signed mean", "scatter (rms)"]
            .iter()
            .enumerate()
        {
            println!(
                "\n| {of}, against {what} | {} |\n|---|{}",
                COMPARED.map(|(_, head)| head).join(" | "),
                "---:|".repeat(COMPARED.len())
            );
            for (run, name) in names.iter().enumerate().take(all[0][against].len()) {
                let cells: Vec<String> = (0..COMPARED.len())
                    .map(|column| {
                        let each = || all.iter().map(|found| found[against][run][column]);
                        let count = all.len() as f64;
                        let value = match kind {
                            0 => each().map(|[mean, _]| mean.abs()).sum::<f64>() / count,
                            1 => each().map(|[mean, _]| mean.abs()).fold(0.0, f64::max),
                            2 => each().map(|[mean, _]| mean).sum::<f64>() / count,
                            _ => (each().map(|[_, scatter]| scatter * scatter).sum::<f64>() / count).sqrt(),
                        };
                        format!("{value:+.1e}")
                    })
                    .collect();
                println!("| {name} | {} |", cells.join(" | "));
            }
        }
    }
    Ok(())
}

/// Number of initial speeds around that of a file in the tables of `places`.
const PLACE_STARTS: i32 = 9;

/// Means of nine starts with one contact place per step, against `reduced` at an eighth of the largest step of the ring.
fn places() -> Result<(), Failed> {
    for (file, end) in [(RIG, "0.5 s"), (TURBINE, "6 s")] {
        let (speed, largest) = (machine(file, &[("run.end_time", end)])?.rotor.initial_speed, largest_step(file)?);
        for detection in ["hyp1", "hyp2-frozen"] {
            let mean = |engine: &str, part: f64| -> Result<Values, Failed> {
                let key = if engine == "reduced" { "run.step" } else { "run.contact_step" };
                let step = format!("{:e} s", part * largest);
                let mut sum = [0.0; COLUMNS.len()];
                for start in 0..PLACE_STARTS {
                    let speed = format!("{:?} rad/s", speed * (1.0 + 1e-3 * f64::from(start - PLACE_STARTS / 2)));
                    let sets = [
                        ("run.engine", engine),
                        ("contact.detection", detection),
                        ("run.end_time", end),
                        ("rotor.initial_speed", &speed),
                        (key, &step),
                    ];
                    let values = row(&machine(file, &sets)?)?;
                    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value / f64::from(PLACE_STARTS));
                }
                Ok(sum)
            };
            let reference = mean("reduced", 0.125)?;
            head(&format!(
                "{detection}, means of {PLACE_STARTS} starts to {end}, against reduced at {:.3e} s",
                0.125 * largest
            ));
            for part in PARTS {
                line(&format!("{part:.3}"), &mean("exponential", part)?, &reference);
            }
            for part in [0.5, 0.25] {
                line(&format!("reduced, {part:.3}"), &mean("reduced", part)?, &reference);
            }
        }
    }
    Ok(())
}

fn main() -> Result<(), Failed> {
    match std::env::args().nth(1).as_deref() {
        Some("starts") => starts(TURBINE, "6 s").and_then(|()| starts(RIG, "0.5 s")),
        Some("window") => window(),
        Some("modes") => modes(),
        Some("grid") => grid(),
        Some("places") => places(),
        Some("random") => random_machines(std::env::args().nth(2).as_deref().unwrap_or("hyp2")),
        _ => Err("TABLE: starts, places, window, modes, grid or random".into()),
    }
}
