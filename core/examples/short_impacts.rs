//! Measures the impulse of a first contact against full finite elements, on machines varied at random, and prints the table of
//! `docs/theory/short-impacts.md`: `cargo run --release -p bladeoff-core --example short_impacts` (four minutes on one core).

#![allow(clippy::print_stdout, reason = "the table is its output")]

use bladeoff_core::engine::simulate;
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef, ParamValue};
use bladeoff_model::outcome::Cause;

const MACHINES: [(&str, &str); 3] = [
    ("short_impacts", include_str!("../tests/data/short_impacts.toml")),
    ("heavy_unbalance", include_str!("../tests/data/heavy_unbalance.toml")),
    ("ring_24_blades", include_str!("../tests/data/ring_24_blades.toml")),
];
/// Varied quantities with their range of factors.
const VARIED: [(&str, f64, f64); 5] = [
    ("ring.thickness", 0.4, 2.0),
    ("ring.width", 0.5, 2.0),
    ("blades.length", 0.5, 1.5),
    ("blades.thickness", 0.5, 2.0),
    ("contact.gap", 0.3, 1.0),
];
const PER_MACHINE: usize = 16;

/// Pseudo-random number of 0 to 1 (a linear congruential generator with the constants of Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn set(def: &mut MachineDef, path: &str, value: &str) {
    let info = def.resolve(path).unwrap_or_else(|e| panic!("{e}"));
    let value = def.parse_value(&info, value).unwrap_or_else(|e| panic!("{e}"));
    def.set(&info, &value).unwrap_or_else(|e| panic!("{e}"));
}

/// Whether `modal_basis` is a cause, and first contact \[s\], steps per impact, step \[s\], impulse \[N s\]; `None` for a run without contact.
fn run(machine: &Machine, structure: &Structure) -> Option<(bool, [f64; 4])> {
    let outcome = simulate(machine, structure, &mut NoHistory).ok()?;
    let columns = columns(machine);
    let value = |name: &str| outcome.values[columns.iter().position(|column| column.name == name)?];
    let names = ["first_contact_s", "steps_per_impact", "step_s", "contact_impulse_Ns"];
    let [first, steps, step, impulse] = names.map(value);
    Some((outcome.causes.contains(Cause::ModalBasis), [first?, steps?, step?, impulse?]))
}

/// A row of the table: share, whether the run is invalid by it, impact length \[s\], error of the impulse, and that of the step.
fn row(text: &str, random: &mut Random) -> Option<(f64, bool, f64, f64, f64)> {
    let mut def = MachineDef::parse("machine.toml", text).unwrap_or_else(|e| panic!("{e}"));
    let nominal = def.build().unwrap_or_else(|e| panic!("{e}"));
    let name = nominal.diaphragms[0].name.clone();
    for (path, low, high) in VARIED {
        let path = format!("diaphragms.{name}.{path}");
        let info = def.resolve(&path).unwrap_or_else(|e| panic!("{e}"));
        let Some(ParamValue::Number(before)) = info.value else { panic!("{path}: a number") };
        let factor = low * (high / low).powf(random.next());
        set(&mut def, &path, &format!("{:e}", before * factor));
    }
    let of = |changes: &[(&str, &str)]| {
        let mut def = def.clone();
        changes.iter().for_each(|(path, value)| set(&mut def, path, value));
        let machine = def.build().ok()?;
        let structure = Structure::build(&machine, None).ok()?;
        let found = run(&machine, &structure)?;
        Some((machine, structure, found))
    };
    let (.., (_, [first, ..])) = of(&[("run.engine", "exponential")])?;
    let end = format!("{:e}", first + 1e-3);
    let ends = ("run.end_time", end.as_str());
    let (machine, structure, (is_short, [_, steps, step, impulse])) = of(&[ends, ("run.engine", "exponential")])?;
    let quarter = format!("{:e}", 0.25 * step);
    let fine = of(&[ends, ("run.engine", "exponential"), ("run.contact_step", &quarter)])?;
    let full = of(&[ends, ("run.engine", "full")])?;
    let share = structure.share_of_impacts(&machine, 0, steps * step);
    let error = |of: &(Machine, Structure, (bool, [f64; 4]))| impulse / of.2.1[3] - 1.0;
    Some((share, is_short, steps * step, error(&full), error(&fine)))
}

fn main() {
    let mut random = Random(2);
    let mut rows = Vec::new();
    for (name, text) in MACHINES {
        for _ in 0..PER_MACHINE {
            if let Some(row) = row(text, &mut random) {
                rows.push((name, row));
            }
        }
    }
    rows.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
    println!(
        "| machine | impact [us] | share | `modal_basis` | impulse against `full` | against a quarter of the step |"
    );
    println!("|---|---:|---:|---|---:|---:|");
    for (name, (share, is_short, length, full, fine)) in rows {
        let said = if is_short { "yes" } else { "no" };
        let [share, full, fine] = [share, full, fine].map(|part| 100.0 * part);
        println!("| {name} | {:.0} | {share:.2} % | {said} | {full:+.1} % | {fine:+.1} % |", 1e6 * length);
    }
}
