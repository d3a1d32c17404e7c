//! Bearing tables on the exponential engine: coast-downs, rubs and pedestals against the reference engines, the energy balance, and the end of the
//! table.

use crate::common::{Every, Row, close, machine_with, run, run_seen, study_machine, table_rotor};
use crate::free_run::free_run;
use bladeoff_core::engine::exponential::StepSettings;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};

/// A coast-down through both critical speeds, braked hard.
const COAST_DOWN: &str =
    "[rotor]\ninitial_speed = 360\n[braking]\nconstant = 600\n[run]\nend_time = 2\nend_speed = 250\n";

/// The lab rig whose left bearing has a table with cross terms.
pub fn rig() -> String {
    let linear = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\n";
    let table = "kind = \"table\"\ninterpolation = \"pchip\"\ncoefficients = { speeds = [0, 100, 200, 400], kxx = [3.2e6, 2.4e6, 2e6, 1.7e6], \
                 kxy = [4e5, 3e5, 2e5, 1e5], kyx = [-2e5, -1.5e5, -1e5, -1e5], kyy = [2.4e6, 2.2e6, 2e6, 1.9e6], \
                 cxx = [2e3, 1e3, 700, 600], cxy = [-200, -100, -100, -50], cyx = [-200, -100, -100, -50], cyy = [1500, 900, 600, 500] }\n";
    let text = study_machine("lab_rig").replacen(linear, table, 1);
    assert!(text.contains("kind = \"table\""));
    text
}

fn free(machine: &Machine, structure: &Structure, [step, spacing]: [f64; 2]) -> [f64; 3] {
    let settings = StepSettings { spacing: Some(spacing), cells: 80, ..StepSettings::of_step(step) };
    let found = free_run(machine, structure, settings, 300.0).expect("has bases");
    [found.end_speed, found.largest_loads[0], found.largest_loads[1]]
}

/// With converged steps, all three engines agree to 1e-5, and the spin converges with the square of the distance between two bases.
#[test]
fn a_coast_down_through_the_table_is_that_of_the_reference_engines() {
    const COLUMNS: [&str; 3] = ["end_speed_rad_s", "max_bearing_load_left_N", "max_bearing_load_right_N"];
    let tail = COAST_DOWN.replace("end_time = 2", "end_time = 0.3");
    for interpolation in ["linear", "pchip"] {
        let of_engine = |engine: &str| {
            machine_with(&table_rotor(interpolation, &tail), &[("run.engine", engine), ("run.step", "2 us")])
        };
        let [full, reduced] = ["full", "reduced"].map(|engine| run(of_engine(engine)));
        let mut machine = of_engine("reduced");
        (machine.run.engine, machine.run.step) = (Engine::Exponential, None);
        let structure = Structure::build(&machine, None).expect("buildable");
        let ours = [8.0, 4.0, 2.0, 1.0].map(|spacing| free(&machine, &structure, [1e-5, spacing]));
        for (i, column) in COLUMNS.into_iter().enumerate() {
            let wanted = full.value(column);
            close(column, reduced.value(column), wanted, 1e-7);
            let error = close(&format!("{interpolation} {column}"), ours[3][i], wanted, 1e-5);
            println!("{interpolation} {column}: {error:.1e}");
        }
        let changes = [0, 1, 2].map(|i| (ours[i][0] - ours[i + 1][0]).abs());
        println!("{interpolation}: the spin changes by {changes:?} with half the spacing");
        // a table of straight lines has corners at its own speeds, wherever the bases are: its error decreases less evenly
        let least = if interpolation == "pchip" { [3.5, 3.5] } else { [1.5, 3.5] };
        assert!((0..2).all(|i| changes[i] > least[i] * changes[i + 1]), "{interpolation}: {changes:?}");
    }
}

/// The default grid and steps: every column of loads and energies is within the errors of the engine without tables.
#[test]
fn a_coast_down_with_default_steps_is_within_the_errors_of_the_engine() {
    for interpolation in ["linear", "pchip"] {
        let of = |changes: &[(&str, &str)]| run(machine_with(&table_rotor(interpolation, COAST_DOWN), changes));
        let full = of(&[("run.engine", "full"), ("run.step", "4 us")]);
        let ours = of(&[("run.engine", "exponential")]);
        assert_eq!((ours.outcome.status.word(), ours.outcome.end_cause.word()), ("ok", "end_speed"));
        for (column, within) in [
            ("max_bearing_load_left_N", 2e-4),
            ("max_bearing_load_right_N", 2e-4),
            ("max_bearing_force_x_left_N", 2e-4),
            ("max_bearing_force_y_right_N", 2e-4),
            ("max_upward_bearing_force_left_N", 1e-3),
            ("max_bending_stress_Pa", 1e-3),
            ("end_time_s", 1e-4),
            ("least_damping_ratio", 1e-3),
        ] {
            println!("{column}: {:.1e}", close(column, ours.value(column), full.value(column), within));
        }
        assert!(ours.value("energy_error") < 2e-7, "{}", ours.value("energy_error"));
    }
}

/// Largest error of a run's energy balance relative to its largest stored energy: as computed, and without the work of the tables.
fn balance(machine: Machine) -> (Row, [f64; 2]) {
    let (mut first, mut errors, mut largest) = (None, [0.0_f64; 2], 0.0_f64);
    let row = run_seen(
        machine,
        &mut Every(|frame| {
            let (total, tables) = (frame.energies.stored() + frame.energies.taken(), frame.energies.tables);
            let start = *first.get_or_insert(total);
            errors = [errors[0].max((total - start).abs()), errors[1].max((total + tables - start).abs())];
            largest = largest.max(frame.energies.stored());
        }),
    );
    (row, errors.map(|error| error / largest))
}

/// When the speed changes, a table adds energy, which is a separate term: without it the balance does not close. Checked in a coast-down, and in a
/// rub that brakes the rotor.
#[test]
fn the_change_of_stiffness_with_the_speed_puts_in_energy() {
    // soft bearings with a light, heavily unbalanced rotor: they hold much of the energy
    let mut soft = table_rotor("pchip", &COAST_DOWN.replace("600", "60").replace("end_speed = 250", "end_speed = 110"));
    for (from, to) in [
        ("interpolation = \"pchip\"", "interpolation = \"pchip\"\nstiffness_factor = 0.03\ndamping_factor = 0.01"),
        ("kxx = [9e7, 7e7, 6e7,", "kxx = [3e8, 1.5e8, 6e7,"),
        ("kyy = [5e7, 5.5e7, 6e7,", "kyy = [2e8, 1e8, 6e7,"),
        ("kxy = ", "#"),
        ("kyx = ", "#"),
        ("polar_inertia = 1.5", "polar_inertia = 0.15"),
        ("mass = 0.05", "mass = 0.5"),
    ] {
        soft = soft.replace(from, to);
    }
    let coast_down = machine_with(&soft, &[("run.engine", "exponential")]);
    let steep = rig().replace("kxx = [3.2e6, 2.4e6, 2e6, 1.7e6]", "kxx = [2e7, 1.2e7, 4e6, 1.7e6]");
    let changes = [("run.end_time", "0.5 s"), ("run.engine", "exponential"), ("contact.friction", "0.5")];
    let rub = machine_with(&steep, &changes);
    for (what, machine, within, least) in [("coast-down", coast_down, 4e-6, 30.0), ("rub", rub, 3e-6, 5.0)] {
        let (row, [with, without]) = balance(machine);
        println!("{what}: with the term {with:.1e}, without {without:.1e}, row {:.1e}", row.value("energy_error"));
        assert!(with < within && row.value("energy_error") < within, "{what}: {with:e}");
        assert!(without > least * with, "{what}: {without:e}");
        assert_eq!(row.get("impacts").is_some_and(|impacts| impacts > 0.0), what == "rub");
    }
}

#[test]
fn a_rub_with_a_table_is_that_of_the_reduced_engine() {
    let text = rig().replace("gravity = [0.0, 0.0]", "gravity = [0.0, -9.81]")
        + "\n[monitors.seal]\nposition = \"0.3 m\"\ngap = \"0.1 mm\"\n";
    let of = |engine, step| run(machine_with(&text, &[("run.end_time", "0.2 s"), ("run.engine", engine), step]));
    let reduced = of("reduced", ("run.step", "1.7 us"));
    let ours = of("exponential", ("run.contact_step", "1.7 us"));
    assert!(reduced.value("impacts") > 0.0 && ours.value("impacts") > 0.0, "touches");
    for (column, within) in [
        ("first_contact_s", 1e-4),
        ("end_speed_rad_s", 1e-4),
        ("max_bearing_load_left_N", 5e-3),
        ("max_bearing_load_right_N", 5e-3),
        ("max_upward_bearing_force_left_N", 5e-3),
        ("max_displacement_seal_m", 1e-3),
        ("max_filtered_contact_force_N", 5e-3),
        ("contact_impulse_Ns", 3e-3),
        ("friction_energy_J", 3e-3),
    ] {
        println!("{column}: {:.1e}", close(column, ours.value(column), reduced.value(column), within));
    }
    assert!(ours.value("energy_error") < 1e-6, "{}", ours.value("energy_error"));
}

/// A run that leaves its table ends at the same instant as on the full engine, within one contact step, for falling and rising speeds.
#[test]
fn a_run_that_leaves_the_table_ends_where_the_full_engine_ends() {
    let falling = "[rotor]\ninitial_speed = 130\n[run]\nend_time = 2\nend_speed = 100\n[braking]\nconstant = 600\n";
    let rising =
        "[rotor]\ninitial_speed = 640\n[rotor.speed_law]\nacceleration = 100\n[run]\nend_time = 0.2\nend_speed = 100\n";
    for (tail, cut) in [(falling, false), (rising, true)] {
        let of = |engine: &str| {
            let mut machine = machine_with(&table_rotor("pchip", tail), &[("run.engine", engine)]);
            // the check of a file would reject this value
            machine.run.end_speed = 0.0;
            if cut {
                machine.run.end_time = 2.0;
                machine.rotor.speed_law.iter_mut().for_each(|law| {
                    (law.times, law.speeds) = (vec![0.0, 2.0], vec![640.0, 840.0]);
                });
            }
            run(machine)
        };
        let [full, ours] = ["full", "exponential"].map(of);
        for row in [&full, &ours] {
            let words = (row.outcome.status.word(), row.outcome.end_cause.word());
            assert_eq!(words, ("beyond", "table_range"));
            assert_eq!(row.outcome.cause.map(|cause| cause.word()), Some("table_range"));
        }
        let late = ours.value("end_time_s") - full.value("end_time_s");
        println!("{late:e} of {:e}", ours.value("step_s"));
        assert!(late.abs() <= ours.value("step_s") + full.value("step_s"), "{late:e}");
    }
}

/// Coefficients that change faster than the largest number of bases can follow are rejected.
#[test]
fn a_table_with_more_detail_than_the_grid_is_rejected() {
    let speeds: Vec<String> = (0..300).map(|i| format!("{}", 100 + 2 * i)).collect();
    let jagged: Vec<&str> = (0..300).map(|i| if i % 2 == 0 { "4e7" } else { "9e7" }).collect();
    let mut text = table_rotor("linear", COAST_DOWN);
    for (from, to) in [
        ("speeds = [100, 200, 300, 450, 700]", format!("speeds = [{}]", speeds.join(", "))),
        ("kxx = [9e7, 7e7, 6e7, 5e7, 4.4e7]", format!("kxx = [{}]", jagged.join(", "))),
    ] {
        text = text.replace(from, &to);
    }
    for line in text.clone().lines().filter(|line| line.starts_with(['k', 'c']) && line.contains(" = [")) {
        if !line.starts_with("kxx") && !line.starts_with("kind") {
            let first = line.split(['[', ',']).nth(1).expect("a list");
            let list = vec![first; 300].join(", ");
            text = text.replace(line, &format!("{} = [{list}]", &line[..3]));
        }
    }
    let machine = machine_with(&text, &[("run.engine", "exponential")]);
    let structure = Structure::build(&machine, None).expect("buildable");
    let refused = bladeoff_core::engine::simulate(&machine, &structure, &mut bladeoff_core::record::NoHistory)
        .expect_err("no basis follows it")
        .to_string();
    assert!(refused.contains("bearing tables with more detail than its grid of speeds"), "{refused}");
}

#[test]
fn a_machine_with_tables_is_given_this_engine() {
    let def = MachineDef::parse("test.toml", &table_rotor("linear", COAST_DOWN)).expect("parses");
    assert_eq!(def.engine().map(|choice| choice.engine), Some(Engine::Exponential));
}
