//! Helpers of the verification tests: machines from text, runs, values by column name, time series.
#![allow(dead_code, reason = "each test binary uses its own part")]

use bladeoff_core::engine::simulate;
use bladeoff_core::record::{Follower, Frame, NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef, UnbalanceKind};
use bladeoff_model::outcome::Outcome;

/// A machine from the text of a machine file.
pub fn machine(text: &str) -> Machine {
    let mut def = MachineDef::parse("test.toml", text).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    of_the_reference(&mut def);
    def.build().unwrap_or_else(|problems| panic!("{problems}"))
}

/// Machines without a named engine are tested with the reference engine; tests of the exponential engine name that engine.
fn of_the_reference(def: &mut MachineDef) {
    if def.engine().is_some_and(|choice| choice.is_auto()) {
        def.settle(Engine::Reduced);
    }
}

/// A machine file of the repository.
pub fn study_machine(name: &str) -> String {
    let path = format!("{}/../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// A machine text with values replaced by path.
pub fn machine_with(text: &str, changes: &[(&str, &str)]) -> Machine {
    let mut def = MachineDef::parse("test.toml", text).unwrap_or_else(|problems| panic!("{problems}"));
    for (path, value) in changes {
        let info = def.resolve(path).unwrap_or_else(|error| panic!("{error}"));
        let value = def.parse_value(&info, value).unwrap_or_else(|error| panic!("{error}"));
        def.set(&info, &value).unwrap_or_else(|error| panic!("{error}"));
    }
    of_the_reference(&mut def);
    def.build().unwrap_or_else(|problems| panic!("{problems}"))
}

/// Shaft of 1 m with two discs; both ends have the same bearing table with cross terms.
pub fn table_rotor(interpolation: &str, tail: &str) -> String {
    let bearing = |name: &str, position: f64, axial: &str| {
        format!(
            "[rotor.bearings.{name}]\nposition = {position:?}\n{axial}kind = \"table\"\ninterpolation = \"{interpolation}\"\n[rotor.bearings.{name}.coefficients]\n\
             speeds = [100, 200, 300, 450, 700]\nkxx = [9e7, 7e7, 6e7, 5e7, 4.4e7]\nkxy = [3e7, 2.5e7, 2e7, 1.6e7, 1.2e7]\n\
             kyx = [-6e7, -5e7, -4.6e7, -4.2e7, -4e7]\nkyy = [5e7, 5.5e7, 6e7, 6.6e7, 7.5e7]\n\
             cxx = [6e5, 3.4e5, 2.4e5, 1.7e5, 1.2e5]\ncxy = [-5e4, -4e4, -3e4, -2e4, -1.5e4]\n\
             cyx = [-5e4, -4e4, -3e4, -2e4, -1.5e4]\ncyy = [4e5, 2.6e5, 2e5, 1.5e5, 1.1e5]\n"
        )
    };
    format!(
        "schema = 1\nname = \"tables\"\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 4\ndiameter = 0.07\n\
         [rotor.discs.middle]\nposition = 0.5\nmass = 80\ntransverse_inertia = 0.8\npolar_inertia = 1.5\n\
         [rotor.discs.right]\nposition = 0.75\nmass = 20\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.unbalances.blade]\nposition = 0.5\nmass = 0.05\nradius = 0.1\n{}{}{tail}",
        bearing("left", 0.0, "axial_stiffness = 1e6\n"),
        bearing("right", 1.0, "")
    )
}

/// Rotor of the independent reference of two diaphragms: 1 m long, a disc of 20 kg in the middle, 250 rad/s at t = 0. `of_run`: lines of `[run]`.
pub fn seal_rotor(of_run: &str, diaphragms: &str) -> String {
    let rotor = include_str!("../../src/verification/two_diaphragms.toml");
    format!("schema = 1\nname = \"two\"\n[run]\nend_time = 0.25\n{of_run}\nend_beyond = \"off\"\n{rotor}{diaphragms}")
}

/// Radial spring of [`seal_rotor`].
pub fn spring_seal(name: &str, position: f64, gap: f64) -> String {
    format!(
        "[diaphragms.{name}]\nkind = \"radial-spring\"\nstiffness = 2e6\n[diaphragms.{name}.contact]\nposition = {position:?}\n\
         rotor_radius = 0.04\ngap = {gap:?}\nfriction = 0.15\nfriction_law = \"slip\"\n"
    )
}

/// Text of the lab rig with rings at other positions: names, positions and gaps. `of_run`: lines in place of the end time.
pub fn with_rings(rig: &str, of_run: &str, rings: &[(&str, f64, f64)]) -> String {
    let (before, ring) = rig.split_at(rig.find("[diaphragms.seal]").expect("has a ring"));
    let rings = rings.iter().map(|(name, position, gap)| {
        ring.replace("seal", name)
            .replace("position = \"0.5 m\"", &format!("position = {position:?}"))
            .replace("gap = \"0.5 mm\"", &format!("gap = {gap:?}"))
    });
    before.replace("end_time = \"0.6 s\"", of_run) + &rings.collect::<String>()
}

/// A random rotor whose lost masses may exceed the inertia of their nodes, which does not affect an initial state in the plane of the nodes. Each
/// lost mass is replaced by the same mass and unbalance: `2 m` lost on the axis, and m added opposite.
pub fn drawn(text: &str) -> Machine {
    let lost: Vec<&str> = text
        .split("[rotor.unbalances.")
        .skip(1)
        .filter(|table| table.split("\n[").next().is_some_and(|own| own.contains("kind = \"lost\"")))
        .filter_map(|table| table.split(']').next())
        .collect();
    let mut machine = machine(&text.replace("kind = \"lost\"", "kind = \"added\""));
    let mut opposite = Vec::new();
    for unbalance in machine.rotor.unbalances.iter_mut().filter(|unbalance| lost.contains(&&*unbalance.name)) {
        let mut other = unbalance.clone();
        other.phase += std::f64::consts::PI;
        opposite.push(other);
        (unbalance.kind, unbalance.mass, unbalance.radius) = (UnbalanceKind::Lost, 2.0 * unbalance.mass, 0.0);
    }
    machine.rotor.unbalances.extend(opposite);
    machine
}

/// A run and its row.
pub struct Row {
    pub machine: Machine,
    pub outcome: Outcome,
}

impl Row {
    /// Value of a column; `None` for null.
    pub fn get(&self, name: &str) -> Option<f64> {
        let index = columns(&self.machine).iter().position(|column| column.name == name);
        self.outcome.values[index.unwrap_or_else(|| panic!("no column {name}"))]
    }

    /// Value of a column that must not be null.
    pub fn value(&self, name: &str) -> f64 {
        self.get(name).unwrap_or_else(|| panic!("{name} is null: {:?}", self.outcome))
    }
}

/// Runs a machine.
pub fn run(machine: Machine) -> Row {
    run_seen(machine, &mut NoHistory)
}

/// Runs a machine with a follower.
pub fn run_seen(machine: Machine, follower: &mut dyn Follower) -> Row {
    let structure = Structure::build(&machine, None).unwrap_or_else(|error| panic!("{error}"));
    let outcome = simulate(&machine, &structure, follower).unwrap_or_else(|error| panic!("{error}"));
    Row { machine, outcome }
}

/// Calls a closure at every step.
pub struct Every<F: FnMut(&Frame<'_>)>(pub F);

impl<F: FnMut(&Frame<'_>)> Follower for Every<F> {
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        true
    }
    fn see(&mut self, frame: &Frame<'_>) {
        (self.0)(frame);
    }
}

/// Asserts `|ours/reference - 1| <= tolerance`, naming the quantity; returns the relative error.
#[track_caller]
pub fn close(what: &str, ours: f64, reference: f64, tolerance: f64) -> f64 {
    let error = (ours - reference).abs() / reference.abs();
    assert!(error <= tolerance, "{what}: ours {ours:e}, reference {reference:e}, error {error:.2e} > {tolerance:.1e}");
    error
}

/// Vertex of the parabola through three equally spaced samples, the middle one the largest: (offset in steps, value).
pub fn vertex(before: f64, middle: f64, after: f64) -> (f64, f64) {
    let curvature = before - 2.0 * middle + after;
    let slope = 0.5 * (after - before);
    let offset = -slope / curvature;
    (offset, middle + 0.5 * slope * offset)
}
