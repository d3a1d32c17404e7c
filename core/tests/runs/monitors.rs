//! Monitors: displacement of a place of the shaft, and time above a clearance there.

use crate::common::{Every, Row, machine, run, run_seen};
use bladeoff_core::record::columns;
use bladeoff_core::structure::Structure;
use std::sync::OnceLock;

const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");
const GAP: f64 = 4e-4;

fn text(engine: &str, monitors: &str) -> String {
    RIG.replace("end_time = \"0.6 s\"", &format!("end_time = 0.2\nengine = \"{engine}\"")) + monitors
}

fn monitors() -> String {
    format!("\n[monitors.seal]\nposition = 0.5\ngap = {GAP:?}\n[monitors.quarter]\nposition = 0.3\ngap = \"5 mm\"\n")
}

const ENGINES: [&str; 3] = ["exponential", "reduced", "full"];

/// Rows of the rig with monitors, in the order of [`ENGINES`].
fn monitored() -> &'static [Row; 3] {
    static ROWS: OnceLock<[Row; 3]> = OnceLock::new();
    ROWS.get_or_init(|| {
        ENGINES.map(|engine| {
            let row = run(machine(&text(engine, &monitors())));
            assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
            row
        })
    })
}

#[test]
fn a_monitor_at_the_contact_has_the_displacement_of_the_rotor_there() {
    for (engine, row) in ENGINES.iter().zip(monitored()) {
        let (found, expected) = (row.value("max_displacement_seal_m"), row.value("max_eccentricity_m"));
        assert!((found - expected).abs() < 3e-4 * expected, "{engine}: {found}, not {expected}");
        let place = row.value("max_displacement_quarter_m");
        assert!(place > 0.0 && place < found, "{engine}: {place}");
        assert_eq!(row.value("time_above_gap_quarter_s"), 0.0);
    }
}

/// The time above the gap is the sum of the steps whose displacement in the history exceeds the gap.
#[test]
fn the_time_above_the_gap_is_that_of_the_history() {
    let mut by_steps = 0.0;
    let reduced = machine(&text("reduced", &monitors()));
    let rotor = Structure::build(&reduced, None).expect("buildable").rotor;
    let [u, v] = rotor.plane_places(reduced.monitors[0].node);
    let step = 2e-5;
    let mut last = 0.0;
    let row = run_seen(
        reduced,
        &mut Every(|frame| {
            let [x, y] = [frame.displacement[u], frame.displacement[v]];
            if x.hypot(y) > GAP && frame.time - last < step {
                by_steps += frame.time - last;
            }
            last = frame.time;
        }),
    );
    let found = row.value("time_above_gap_seal_s");
    println!("reduced {found} s, by its steps {by_steps} s");
    assert!(found > 0.05, "{found}");
    assert!((found - by_steps).abs() < 2e-3 * found, "{found}, not {by_steps}");
    let exponential = monitored()[0].value("time_above_gap_seal_s");
    println!("exponential {exponential} s");
    assert!((exponential - found).abs() < 5e-3 * found, "{exponential}, not {found}");
}

/// A monitor has no contact: if its node exists anyway, the reference engines compute the same digits.
#[test]
fn a_monitor_changes_no_digit_of_the_reference_engines() {
    for (engine, watched) in ENGINES.iter().zip(monitored()).skip(1) {
        let alone = run(machine(&text(engine, "")));
        for column in columns(&alone.machine) {
            let name = &*column.name;
            assert_eq!(watched.get(name).map(f64::to_bits), alone.get(name).map(f64::to_bits), "{engine}: {name}");
        }
    }
}
