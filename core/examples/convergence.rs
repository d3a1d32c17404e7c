//! Measures convergence and prints the tables of `docs/theory/convergence.md`:
//! `cargo run --release -p bladeoff-core --example convergence > tables.md` (about a quarter of an hour on one core; with the argument
//! `torsion` the tables of torsional moments alone).

#![allow(clippy::print_stdout, reason = "the tables are its output")]

use std::collections::BTreeMap;

use bladeoff_core::engine::simulate;
use bladeoff_core::record::{Follower, Frame, NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};

type Values = BTreeMap<String, f64>;
type Sets<'a> = &'a [(&'a str, &'a str)];

/// Quantities that a 1e-12 change of the initial state hardly changes.
const ROBUST: [&str; 7] = [
    "first_contact_s",
    "end_speed_rad_s",
    "max_bearing_load_N",
    "max_eccentricity_m",
    "max_filtered_contact_force_N",
    "contact_impulse_Ns",
    "friction_energy_J",
];
const RAW: [&str; 2] = ["max_contact_force_N", "impacts"];

const LAB: &str = include_str!("../../studies/machines/lab_rig.toml");
const TURBINE: &str = include_str!("../../studies/machines/lp_turbine_paper.toml");

fn machine(text: &str, sets: Sets) -> Machine {
    let mut def = MachineDef::parse("machine.toml", text).unwrap_or_else(|e| panic!("{e}"));
    // the reference engine, unless `sets` names another one
    def.settle(Engine::Reduced);
    for (path, value) in sets {
        let info = def.resolve(path).unwrap_or_else(|e| panic!("{e}"));
        let value = def.parse_value(&info, value).unwrap_or_else(|e| panic!("{e}"));
        def.set(&info, &value).unwrap_or_else(|e| panic!("{e}"));
    }
    def.build().unwrap_or_else(|e| panic!("{e}"))
}

fn run(machine: &Machine, follower: &mut dyn Follower) -> Values {
    let structure = Structure::build(machine, None).unwrap_or_else(|e| panic!("{e}"));
    let outcome = simulate(machine, &structure, follower).unwrap_or_else(|e| panic!("{e}"));
    columns(machine).into_iter().zip(outcome.values).filter_map(|(c, v)| Some((c.name, v?))).collect()
}

fn values(text: &str, sets: Sets) -> Values {
    run(&machine(text, sets), &mut NoHistory)
}

/// Rotor centre at the contact section, every `every` steps.
struct Orbit {
    every: u64,
    points: Vec<(f64, [f64; 2])>,
}

impl Follower for Orbit {
    fn wants(&mut self, step: u64, _time: f64) -> bool {
        step.is_multiple_of(self.every)
    }
    fn see(&mut self, frame: &Frame<'_>) {
        self.points.extend(frame.contacts.iter().map(|contact| (frame.time, contact.rotor)));
    }
}

fn header(first: &str, names: &[&str]) {
    println!("| {first} | {} |", names.join(" | "));
    println!("|---{}|", "|---:".repeat(names.len()));
}

fn row(first: &str, names: &[&str], values: &Values) {
    let cells: Vec<String> =
        names.iter().map(|name| values.get(*name).map_or_else(|| "-".into(), |v| format!("{v:.6e}"))).collect();
    println!("| {first} | {} |", cells.join(" | "));
}

/// Values and relative differences to a reference run.
fn compare(title: &str, text: &str, names: &[&str], reference: (&str, Sets), others: &[(&str, Sets)]) {
    println!("\n### {title}\n");
    header("run", names);
    let truth = values(text, reference.1);
    row(&format!("{} (reference)", reference.0), names, &truth);
    for (label, sets) in others {
        let found = values(text, sets);
        let cells: Vec<String> = names
            .iter()
            .map(|name| match (found.get(*name), truth.get(*name)) {
                (Some(a), Some(b)) if *b != 0.0 => format!("{:+.2e}", a / b - 1.0),
                (Some(a), Some(b)) => format!("{:+.2e} (absolute)", a - b),
                _ => "-".into(),
            })
            .collect();
        println!("| {label} | {} |", cells.join(" | "));
    }
}

fn step_order_without_contact() {
    println!("\n### Order in the step without contact (lab rig, rotor centre at 0.1 s, gap 5 mm)\n");
    println!("| step [s] | error [m] | order |\n|---:|---:|---:|");
    let place = |divisions: u32| {
        let step = format!("{:e}", 0.1 / f64::from(divisions));
        // the contact radius stays inside the ring: a smaller rotor makes room for the gap
        let sets = [
            ("contact.rotor_radius", "46 mm"),
            ("contact.gap", "5 mm"),
            ("run.end_time", "0.1001"),
            ("run.step", &step),
        ];
        let mut orbit = Orbit { every: u64::from(divisions), points: Vec::new() };
        run(&machine(LAB, &sets), &mut orbit);
        orbit.points[1].1
    };
    let exact = place(640_000);
    let mut last: Option<f64> = None;
    for divisions in [20_000, 40_000, 80_000, 160_000] {
        let found = place(divisions);
        let error = (found[0] - exact[0]).hypot(found[1] - exact[1]);
        let order = last.map_or_else(|| "-".into(), |last| format!("{:.2}", (last / error).log2()));
        println!("| {:e} | {error:.3e} | {order} |", 0.1 / f64::from(divisions));
        last = Some(error);
    }
}

fn step_order_with_contact() {
    println!(
        "\n### Order in the step with contact (lab rig to 0.155 s, relative error of impulse and friction energy)\n"
    );
    println!(
        "| force location | step [s] | impulse | order | friction energy | order |\n|---|---:|---:|---:|---:|---:|"
    );
    let at = |location: &str, step: f64| {
        let step = format!("{step:e}");
        values(LAB, &[("run.end_time", "0.155 s"), ("run.step", &step), ("run.force_location", location)])
    };
    let exact = at("current", 1.25e-7);
    for location in ["next", "current"] {
        let mut last: Option<[f64; 2]> = None;
        for step in [4e-6, 2e-6, 1e-6, 5e-7] {
            let found = at(location, step);
            let error = ["contact_impulse_Ns", "friction_energy_J"].map(|name| (found[name] / exact[name] - 1.0).abs());
            let order = |i: usize| {
                last.map_or_else(|| "-".into(), |last: [f64; 2]| format!("{:.2}", (last[i] / error[i]).log2()))
            };
            println!("| {location} | {step:e} | {:.2e} | {} | {:.2e} | {} |", error[0], order(0), error[1], order(1));
            last = Some(error);
        }
    }
}

fn perturbation(title: &str, text: &str, sets: Sets, every: u64, after: &[f64]) {
    println!("\n### Growth of a 1e-12 m change of the start ({title})\n");
    let orbit = |displacement: &str| {
        let mut all = sets.to_vec();
        all.push(("rotor.initial.displacement[0]", displacement));
        let mut orbit = Orbit { every, points: Vec::new() };
        let values = run(&machine(text, &all), &mut orbit);
        (orbit.points, values)
    };
    let (base, truth) = orbit("0");
    let first = truth["first_contact_s"];
    let (moved, _) = orbit("1e-12");
    println!("| after first contact [s] | distance of the rotor centres [m] |\n|---:|---:|");
    for wanted in after {
        let i = base.iter().position(|(t, _)| *t >= first + wanted).unwrap_or(base.len() - 1);
        let (a, b) = (base[i].1, moved[i].1);
        println!("| {wanted} | {:.1e} |", (a[0] - b[0]).hypot(a[1] - b[1]));
    }
    println!(
        "\nScatter (largest relative difference to the undisturbed run) over changes of 1e-12, 2e-12, 3e-12, 5e-12, 8e-12 m:\n"
    );
    let names: Vec<&str> = ROBUST.iter().chain(&RAW).copied().collect();
    header("", &names);
    let mut scatter = Values::new();
    for displacement in ["1e-12", "2e-12", "3e-12", "5e-12", "8e-12"] {
        let (_, found) = orbit(displacement);
        for name in &names {
            let difference = (found[*name] / truth[*name] - 1.0).abs();
            let largest = scatter.entry((*name).to_owned()).or_insert(0.0);
            *largest = largest.max(difference);
        }
    }
    row("scatter", &names, &scatter);
}

/// Largest torsional moments of the turbine: modes against full finite elements, then the influences on the result of the whole run.
fn torsion() {
    let moments: Vec<String> = columns(&machine(TURBINE, &[]))
        .into_iter()
        .map(|column| column.name)
        .filter(|name| name.starts_with("max_torsional_moment") && name.ends_with("_Nm"))
        .collect();
    let moments: Vec<&str> = moments.iter().map(String::as_str).collect();
    let short = ("run.end_time", "3.4 s");
    compare(
        "Torsional moments against full finite elements, turbine to 3.4 s",
        TURBINE,
        &moments,
        ("full", &[short, ("run.engine", "full")]),
        &[
            ("3 torsional modes", &[short, ("run.torsional_modes", "3")]),
            ("no static residual", &[short, ("run.static_residual", "off")]),
            ("all torsional modes and static residual (default)", &[short]),
        ],
    );
    compare(
        "Torsional moments, step, turbine to 6 s",
        TURBINE,
        &moments,
        ("6.7e-6 s", &[("run.step", "6.7e-6")]),
        &[("2.7e-5 s (default)", &[]), ("1.35e-5 s", &[("run.step", "1.35e-5")])],
    );
    let undamped = ("rotor.damping.torsional", "0");
    compare(
        "Torsional moments, what they depend on, turbine to 6 s",
        TURBINE,
        &moments,
        ("default", &[]),
        &[
            ("full finite elements", &[("run.engine", "full")]),
            ("36 rotor, 48 ring modes", &[("run.rotor_modes", "36"), ("run.ring_modes", "48")]),
            ("64 ring modes", &[("run.ring_modes", "64")]),
            (
                "shaft elements x2",
                &[
                    ("rotor.shaft[0].elements", "4"),
                    ("rotor.shaft[1].elements", "4"),
                    ("rotor.shaft[2].elements", "8"),
                    ("rotor.shaft[3].elements", "4"),
                    ("rotor.shaft[4].elements", "4"),
                ],
            ),
            ("0.1 % more lost mass", &[("blade_off.mass", "12.012 kg")]),
            ("0.2 % more lost mass", &[("blade_off.mass", "12.024 kg")]),
            ("0.1 % less lost mass", &[("blade_off.mass", "11.988 kg")]),
            ("half the torsional damping", &[("rotor.damping.torsional", "1e-5")]),
            ("twice the torsional damping", &[("rotor.damping.torsional", "4e-5")]),
            ("no torsional damping", &[undamped]),
            ("no torsional damping, 0.1 % more lost mass", &[undamped, ("blade_off.mass", "12.012 kg")]),
            ("no torsional damping, 0.1 % less lost mass", &[undamped, ("blade_off.mass", "11.988 kg")]),
        ],
    );
}

fn main() {
    if std::env::args().nth(1).as_deref() == Some("torsion") {
        return torsion();
    }
    let all: Vec<&str> = ROBUST.iter().chain(&RAW).copied().collect();
    step_order_without_contact();
    step_order_with_contact();
    compare(
        "Step, reduced engine, lab rig",
        LAB,
        &all,
        ("4.25e-7 s", &[("run.step", "4.25e-7")]),
        &[
            ("3.4e-6 s (default)", &[("run.step", "3.4e-6")]),
            ("1.7e-6 s", &[("run.step", "1.7e-6")]),
            ("8.5e-7 s", &[("run.step", "8.5e-7")]),
        ],
    );
    let short = ("run.end_time", "3.4 s");
    compare(
        "Step, reduced engine, turbine to 3.4 s",
        TURBINE,
        &all,
        ("3.4e-6 s", &[short, ("run.step", "3.4e-6")]),
        &[
            ("2.7e-5 s (default)", &[short]),
            ("1.35e-5 s", &[short, ("run.step", "1.35e-5")]),
            ("6.7e-6 s", &[short, ("run.step", "6.7e-6")]),
        ],
    );
    compare(
        "Modes against full finite elements, lab rig",
        LAB,
        &all,
        ("full", &[("run.engine", "full")]),
        &[
            ("8 rotor, 36 ring", &[("run.rotor_modes", "8")]),
            ("16 rotor, 36 ring", &[("run.rotor_modes", "16")]),
            ("24 rotor, 36 ring (default)", &[]),
            ("24 rotor, 36 ring, no static residual", &[("run.static_residual", "off")]),
            ("24 rotor, 13 ring", &[("run.ring_modes", "13")]),
            ("24 rotor, 24 ring", &[("run.ring_modes", "24")]),
            ("24 rotor, 48 ring", &[("run.ring_modes", "48")]),
            ("3 torsional modes", &[("run.torsional_modes", "3")]),
        ],
    );
    compare(
        "Modes against full finite elements, turbine to 3.4 s",
        TURBINE,
        &all,
        ("full", &[short, ("run.engine", "full")]),
        &[
            ("8 rotor, 36 ring", &[short, ("run.rotor_modes", "8")]),
            ("16 rotor, 36 ring", &[short, ("run.rotor_modes", "16")]),
            ("24 rotor, 36 ring (default)", &[short]),
            ("24 rotor, 36 ring, no static residual", &[short, ("run.static_residual", "off")]),
            ("24 rotor, 13 ring", &[short, ("run.ring_modes", "13")]),
            ("24 rotor, 24 ring", &[short, ("run.ring_modes", "24")]),
            ("24 rotor, 64 ring", &[short, ("run.ring_modes", "64")]),
            ("36 rotor, 96 ring", &[short, ("run.rotor_modes", "36"), ("run.ring_modes", "96")]),
            ("3 torsional modes", &[short, ("run.torsional_modes", "3")]),
        ],
    );
    torsion();
    compare(
        "Mesh, reduced engine, lab rig (modes as by default)",
        LAB,
        &ROBUST,
        (
            "x4",
            &[
                ("rotor.shaft[0].elements", "8"),
                ("rotor.shaft[1].elements", "16"),
                ("rotor.shaft[2].elements", "8"),
                ("ring.elements", "64"),
            ],
        ),
        &[
            ("as shipped", &[]),
            (
                "x2",
                &[
                    ("rotor.shaft[0].elements", "4"),
                    ("rotor.shaft[1].elements", "8"),
                    ("rotor.shaft[2].elements", "4"),
                    ("ring.elements", "32"),
                ],
            ),
        ],
    );
    perturbation("lab rig", LAB, &[], 20, &[0.0, 0.005, 0.01, 0.02, 0.05, 0.1]);
    perturbation("turbine to 3.4 s", TURBINE, &[short], 4, &[0.0, 0.02, 0.05, 0.1, 0.2, 0.3]);
}
