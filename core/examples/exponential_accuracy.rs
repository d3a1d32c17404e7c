//! Measures what the exponential engine leaves on the turbine and prints tables of `docs/theory/08-exponential-engine.md`:
//! `cargo run --release --workspace --example exponential_accuracy -- TABLE`, TABLE one of `starts` (nine starts to 6 s, against smaller contact steps),
//! `window` (one long rub against `reduced` at 3.4 us), `modes` and `grid`. One to five minutes each on one core. The candidates on the ring are a constant of the
//! engine: their table is `modes` built with other ones.
#![allow(clippy::print_stdout, reason = "the tables are its output")]

use bladeoff_core::engine::exponential::{FlightSettings, RubbingRun, rubbing_run};
use bladeoff_core::engine::{StepPlan, simulate};
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef};
use bladeoff_model::outcome::Status;

const TURBINE: &str = include_str!("../../studies/machines/lp_turbine.toml");
const EXPONENTIAL: (&str, &str) = ("run.engine", "exponential");
const SHORT: (&str, &str) = ("run.end_time", "3.4 s");

/// Columns of the tables, with their heads.
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

fn machine(sets: &[(&str, &str)]) -> Result<Machine, Failed> {
    let mut def = MachineDef::parse("lp_turbine.toml", TURBINE).map_err(|problems| problems.to_string())?;
    for (path, value) in sets {
        let info = def.resolve(path)?;
        let value = def.parse_value(&info, value)?;
        def.set(&info, &value)?;
    }
    Ok(def.build().map_err(|problems| problems.to_string())?)
}

fn row(sets: &[(&str, &str)]) -> Result<Values, Failed> {
    let machine = machine(sets)?;
    let outcome = simulate(&machine, &Structure::build(&machine, None)?, &mut NoHistory)?;
    if outcome.status != Status::Ok {
        println!("{sets:?}: {} {}", outcome.status.word(), outcome.causes.words().unwrap_or_default());
    }
    let names = columns(&machine);
    let value = |(name, _): (&str, &str)| {
        let at = names.iter().position(|column| column.name == name);
        at.and_then(|at| outcome.values[at]).unwrap_or(f64::NAN)
    };
    Ok(COLUMNS.map(value))
}

fn head(first: &str) {
    println!("\n| {first} | {} |", COLUMNS.map(|(_, name)| name).join(" | "));
    println!("|---|{}", "---:|".repeat(COLUMNS.len()));
}

/// Differences relative to a reference; the energy error as it is.
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

fn default_step() -> Result<f64, Failed> {
    let machine = machine(&[EXPONENTIAL])?;
    Ok(StepPlan::new(&machine, &Structure::build(&machine, None)?)?.step)
}

/// Nine initial speeds about that of the file, each in the default contact step, half and a quarter of it.
fn starts() -> Result<(), Failed> {
    let (speed, step) = (machine(&[])?.rotor.initial_speed, default_step()?);
    let parts = [1.0, 2.0, 4.0];
    let mut found: Vec<[Values; 3]> = Vec::new();
    for start in 0..9 {
        let speed = format!("{:?} rad/s", speed * (1.0 + 1e-3 * f64::from(start - 4)));
        let mut runs = [[0.0; COLUMNS.len()]; 3];
        for (run, part) in runs.iter_mut().zip(parts) {
            let step = format!("{:e} s", step / part);
            *run = row(&[EXPONENTIAL, ("rotor.initial_speed", &speed), ("run.contact_step", &step)])?;
        }
        head(&speed);
        line(&format!("{step:e} s"), &runs[0], &runs[2]);
        line("half", &runs[1], &runs[2]);
        found.push(runs);
    }
    let mean = |run: usize| -> Values {
        std::array::from_fn(|k| found.iter().map(|runs| runs[run][k]).sum::<f64>() / found.len() as f64)
    };
    head("means of nine starts, against a quarter of the step");
    line(&format!("{step:e} s"), &mean(0), &mean(2));
    line("half", &mean(1), &mean(2));
    let largest = |run: usize| -> Values {
        std::array::from_fn(|k| {
            1.0 + found.iter().map(|runs| (runs[run][k] / runs[2][k] - 1.0).abs()).fold(0.0, f64::max)
        })
    };
    line("largest of one start", &largest(0), &[1.0; COLUMNS.len()]);
    line("largest of one start, half", &largest(1), &[1.0; COLUMNS.len()]);
    Ok(())
}

fn window() -> Result<(), Failed> {
    let step = default_step()?;
    let reference = row(&[SHORT, ("run.step", "3.4e-6 s")])?;
    head("to 3.4 s, against reduced at 3.4 us");
    for part in [1.0, 2.0, 4.0, 8.0] {
        let step = format!("{:e} s", step / part);
        line(&step, &row(&[EXPONENTIAL, SHORT, ("run.contact_step", &step)])?, &reference);
    }
    line("reduced, 6.7 us", &row(&[SHORT, ("run.step", "6.7e-6 s")])?, &reference);
    Ok(())
}

/// At a contact step that all of them allow.
fn modes() -> Result<(), Failed> {
    let step = ("run.contact_step", "3.4e-6 s");
    let of = |rotor: &str, ring: &str| {
        row(&[EXPONENTIAL, SHORT, step, ("run.rotor_modes", rotor), ("run.ring_modes", ring)])
    };
    let default = row(&[EXPONENTIAL, SHORT, step])?;
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
    let step = default_step()?;
    let machine = machine(&[EXPONENTIAL, SHORT])?;
    let structure = Structure::build(&machine, None)?;
    let of = |spacing: f64, cells: u32| -> Result<RubbingRun, Failed> {
        // that of the default: the power of two nearest to a 37th of the initial speed
        let default = libm::exp2(libm::round(libm::log2(machine.rotor.initial_speed / 37.5)));
        let settings = FlightSettings { spacing: Some(spacing * default), cells, ..FlightSettings::of_step(step) };
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

fn main() -> Result<(), Failed> {
    match std::env::args().nth(1).as_deref() {
        Some("starts") => starts(),
        Some("window") => window(),
        Some("modes") => modes(),
        Some("grid") => grid(),
        _ => Err("TABLE: starts, window, modes or grid".into()),
    }
}
