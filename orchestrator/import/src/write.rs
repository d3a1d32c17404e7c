//! Writes the machine file with its comments.

use super::Note;
use super::elements::{Beam, Bearing, Material, Rotor, Shear};
use super::line::{Line, runs};
use super::names::{Names, in_one_line, tag};
use super::support::{Pedestal, Supports};
use std::fmt::Write as _;

/// Axial stiffness of the first bearing if the rotor has none \[N/m\].
const AXIAL: f64 = 1e8;
/// Initial speed if the file has none \[rad/s\].
const SPEED: f64 = 100.0;
/// Smallest ratio of a table's last speed to the initial speed.
const BEYOND: f64 = 1.05;

/// The machine file without its head; assumptions are noted.
pub fn machine(file: &str, rotor: &Rotor, line: &Line<'_>, supports: &Supports<'_>, notes: &mut Vec<Note>) -> String {
    let mut body = String::new();
    run(&mut body, file, supports);
    let material = &line.base[0].material;
    head(&mut body, rotor, material, supports, notes);
    sections(&mut body, line, material);
    layers(&mut body, line, material);
    masses(&mut body, line, supports);
    bearings(&mut body, line, supports, notes);
    damping(&mut body, rotor, supports, notes);
    body.push_str(MISSING);
    body
}

/// Tables that a rotor of ROSS does not have, written as comments.
const MISSING: &str = r#"
# FILL IN: the lost blade. Without an unbalance nothing happens.
# [rotor.unbalances.blade_off]
# position = "1 m"
# mass = "1 kg"
# radius = "0.5 m"
# kind = "lost"

# FILL IN: torques that slow the rotor: T = constant + linear W + quadratic W|W|. Without them the speed changes by friction alone.
# [braking]
# linear = "1 N m s"
# quadratic = "0.01 N m s2"

# FILL IN: each ring that the rotor may touch. A rigid one; a flexible ring has kind = "flexible" (docs/machines.md).
# [diaphragms.seal]
# kind = "rigid"
# [diaphragms.seal.contact]
# position = "1 m"
# rotor_radius = "100 mm"
# gap = "0.5 mm"
# friction = 0.2
"#;

/// A number in a form that is parsed to the same number, always with a point or an exponent.
fn exact(number: f64) -> String {
    if number.abs() >= 1e6 { format!("{number:e}") } else { format!("{number:?}") }
}

/// A computed number, without rounding errors in its last digits.
fn rounded(number: f64) -> String {
    format!("{number:.14e}").parse().map_or_else(|_| exact(number), exact)
}

fn put(out: &mut String, line: impl AsRef<str>) {
    out.push_str(line.as_ref());
    out.push('\n');
}

/// Head of the machine file: the source, and the notes.
pub fn provenance(file: &str, text: &str, rotor: &Rotor, notes: &[Note]) -> String {
    let mut out = String::new();
    let version = rotor.version.as_deref().map_or_else(String::new, |version| format!(" {}", in_one_line(version)));
    put(&mut out, format!("# Machine file of bladeoff, converted from a rotor saved by ROSS{version}."));
    put(&mut out, format!("# File: {}", in_one_line(file)));
    put(&mut out, format!("# {} bytes, BLAKE3 {}", text.len(), blake3::hash(text.as_bytes())));
    put(&mut out, "# Values are SI. Lines with FILL IN mark what a rotor of ROSS does not have.");
    if !notes.is_empty() {
        put(&mut out, "#\n# Not converted, or not as in ROSS:");
        notes.iter().for_each(|note| put(&mut out, format!("# - {note}")));
    }
    out
}

fn run(out: &mut String, file: &str, supports: &Supports<'_>) {
    let stem =
        std::path::Path::new(file).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    put(out, "\nschema = 1");
    put(out, format!("name = \"{}\"", Names::default().like(&stem, "rotor")));
    put(out, "\n[run]");
    put(out, "end_time = 10.0 # FILL IN: end of the run [s]");
    let begins = begins(supports);
    if begins > 0.0 {
        put(out, format!("end_speed = {} # bearing tables begin here", exact(begins)));
    }
}

/// Largest first speed of the bearing tables \[rad/s\]; 0 without tables.
fn begins(supports: &Supports<'_>) -> f64 {
    tables(supports).map(|bearing| bearing.speeds[0]).fold(0.0, f64::max)
}

/// Bearings with a table over the speed.
fn tables<'s>(supports: &'s Supports<'_>) -> impl Iterator<Item = &'s Bearing> {
    supports.on_shaft.iter().map(|support| support.bearing).filter(|bearing| is_table(bearing))
}

fn is_table(bearing: &Bearing) -> bool {
    bearing.stiffness.iter().chain(&bearing.damping).any(|list| list.iter().any(|value| *value != list[0]))
}

fn head(out: &mut String, rotor: &Rotor, material: &Material, supports: &Supports<'_>, notes: &mut Vec<Note>) {
    let given = [(rotor.rated, "rated_w"), (rotor.largest, "max_w")];
    let given = given.into_iter().find_map(|(speed, name)| Some((speed.filter(|speed| *speed > 0.0)?, name)));
    let ends = tables(supports).filter_map(|bearing| bearing.speeds.last().copied()).fold(f64::INFINITY, f64::min);
    let most = ends / BEYOND;
    let (speed, comment) = match given {
        Some((speed, name)) if speed <= most && speed > begins(supports) => (speed, format!("{name} of the file")),
        Some((speed, name)) if speed <= begins(supports) => {
            let message = format!(
                "bearing tables begin at {} rad/s, above {name} = {} rad/s: initial_speed is higher",
                exact(begins(supports)),
                exact(speed)
            );
            notes.push(Note::new("parameters", message));
            (most, format!("FILL IN: the bearing tables begin above {name} [rad/s]"))
        }
        Some((speed, name)) => {
            let message = format!(
                "a bearing table ends at {} rad/s, below 1.05 times {name} = {} rad/s: initial_speed is lower",
                exact(ends),
                exact(speed)
            );
            notes.push(Note::new("parameters", message));
            (most, "FILL IN: the bearing tables end at 1.05 times this speed [rad/s]".to_owned())
        }
        None if most.is_finite() => (
            most,
            "FILL IN: speed at the blade loss [rad/s]; the bearing tables end at 1.05 times this speed".to_owned(),
        ),
        None => (SPEED, "FILL IN: speed at the blade loss [rad/s]".to_owned()),
    };
    put(out, "\n[rotor]");
    put(out, format!("initial_speed = {} # {comment}", exact(speed)));
    put(out, "# gravity = [0.0, -9.81] # FILL IN: with the weight, bearing forces include the static reaction");
    put(out, "\n[rotor.material]");
    material_keys(out, material);
}

fn material_keys(out: &mut String, material: &Material) {
    put(out, format!("# ROSS: {}", in_one_line(&material.name)));
    put(out, format!("young_modulus = {}", exact(material.moduli[0])));
    put(
        out,
        format!("poisson_ratio = {} # from G_s = {} Pa", exact(material.poisson_ratio()), exact(material.moduli[1])),
    );
    put(out, format!("density = {}", exact(material.density)));
}

/// Writes diameters and shear coefficient of a section or a layer.
fn cross_section(out: &mut String, beam: &Beam) {
    let [[outer, inner], [end_outer, end_inner]] = beam.ends;
    put(out, format!("diameter = {}", exact(outer)));
    put(out, format!("inner_diameter = {}", exact(inner)));
    if end_outer != outer {
        put(out, format!("end_diameter = {}", exact(end_outer)));
    }
    if end_inner != inner {
        put(out, format!("end_inner_diameter = {}", exact(end_inner)));
    }
    match beam.shear {
        Shear::Cowper => {}
        Shear::None => put(out, "shear_coefficient = \"none\""),
        Shear::Hutchinson => put(out, format!("shear_coefficient = {} # Hutchinson", exact(hutchinson(beam)))),
    }
}

/// Shear coefficient of a hollow circular section after Hutchinson, J. Appl. Mech. 68 (2001), at the middle of the element.
fn hutchinson(beam: &Beam) -> f64 {
    let [[outer, inner], [end_outer, end_inner]] = beam.ends;
    let (ratio, nu) = ((inner + end_inner) / (outer + end_outer), beam.material.poisson_ratio());
    let square = ratio * ratio;
    let sum = (1.0 + square) * (1.0 + square);
    6.0 * sum * (1.0 + nu) / (sum * (7.0 + 12.0 * nu + 4.0 * nu * nu) + 4.0 * square * (5.0 + 6.0 * nu + 2.0 * nu * nu))
}

fn nodes(run: &[&Beam]) -> String {
    let first = run.first().map_or(0, |beam| beam.node);
    format!("nodes {first} to {}", first + run.len())
}

fn length(run: &[&Beam]) -> f64 {
    run.first().map_or(0.0, |beam| beam.length * run.len() as f64)
}

fn sections(out: &mut String, line: &Line<'_>, common: &Material) {
    for run in runs(&line.base) {
        put(out, "\n[[rotor.shaft]]");
        put(out, format!("# {}", nodes(&run)));
        put(out, format!("length = {}", rounded(length(&run))));
        put(out, format!("elements = {}", run.len()));
        cross_section(out, run[0]);
        if !run[0].material.is_like(common) {
            put(out, "[rotor.shaft.material]");
            material_keys(out, &run[0].material);
        }
    }
}

fn layers(out: &mut String, line: &Line<'_>, common: &Material) {
    let mut names = Names::default();
    for run in runs(&line.layers) {
        let name = names.like(tag(&run[0].element), "layer");
        put(out, format!("\n[rotor.layers.{name}]"));
        put(out, format!("# {}: {}", in_one_line(&run[0].element), nodes(&run)));
        put(out, format!("position = {}", rounded(line.nodes[run[0].node])));
        put(out, format!("length = {}", rounded(line.nodes[run[0].node + run.len()] - line.nodes[run[0].node])));
        cross_section(out, run[0]);
        if !run[0].material.is_like(common) {
            put(out, format!("[rotor.layers.{name}.material]"));
            material_keys(out, &run[0].material);
        }
    }
}

fn masses(out: &mut String, line: &Line<'_>, supports: &Supports<'_>) {
    let mut names = Names::default();
    let mut disc = |element: &str, node: usize, [mass, transverse, polar]: [f64; 3]| {
        put(out, format!("\n[rotor.discs.{}]", names.like(tag(element), "disc")));
        put(out, format!("# {}: node {node}", in_one_line(element)));
        put(out, format!("position = {}", rounded(line.nodes[node])));
        put(out, format!("mass = {}", exact(mass)));
        put(out, format!("transverse_inertia = {}", exact(transverse)));
        put(out, format!("polar_inertia = {}", exact(polar)));
    };
    for one in &supports.discs {
        disc(&one.element, one.node, [one.mass, one.transverse, one.polar]);
    }
    for one in &supports.masses {
        disc(&one.element, one.node, [0.5 * (one.mass[0] + one.mass[1]), 0.0, 0.0]);
    }
}

fn bearings(out: &mut String, line: &Line<'_>, supports: &Supports<'_>, notes: &mut Vec<Note>) {
    let mut names = Names::default();
    let held = supports.on_shaft.iter().any(|support| support.bearing.axial > 0.0);
    for (i, support) in supports.on_shaft.iter().enumerate() {
        let bearing = support.bearing;
        let name = names.like(tag(&bearing.element), "bearing");
        put(out, format!("\n[rotor.bearings.{name}]"));
        put(out, format!("# {}: node {}", in_one_line(&bearing.element), bearing.node));
        put(out, format!("position = {}", rounded(line.nodes[bearing.node])));
        let axial = if !held && i == 0 { AXIAL } else { bearing.axial };
        if !held && i == 0 {
            notes.push(Note::new(
                &bearing.element,
                "no bearing has an axial stiffness kzz, which a machine needs once: 1e8 N/m here",
            ));
        }
        let axial_line = match (axial > 0.0, !held && i == 0) {
            (false, _) => String::new(),
            (true, false) => format!("axial_stiffness = {}\n", exact(axial)),
            (true, true) => format!(
                "axial_stiffness = {} # FILL IN: ROSS has none; it does not affect lateral motion\n",
                exact(axial)
            ),
        };
        if is_table(bearing) {
            put(out, "kind = \"table\"");
            put(out, "interpolation = \"pchip\"");
            out.push_str(&axial_line);
            table(out, &name, bearing);
            notes.push(Note::new(&bearing.element, "ROSS has other curves (cubic splines) between the speeds of a table, and beyond its ends: coefficients differ there, not at the speeds themselves"));
        } else {
            for (key, matrix) in [("stiffness", &bearing.stiffness), ("damping", &bearing.damping)] {
                let [xx, xy, yx, yy] = [0, 1, 2, 3].map(|k| exact(matrix[k][0]));
                put(out, format!("{key} = [[{xx}, {xy}], [{yx}, {yy}]]"));
            }
            out.push_str(&axial_line);
        }
        if let Some(pedestal) = &support.pedestal {
            self::pedestal(out, &name, pedestal);
        }
    }
}

fn table(out: &mut String, name: &str, bearing: &Bearing) {
    put(out, format!("[rotor.bearings.{name}.coefficients]"));
    let mut list = |key: &str, values: &[f64]| {
        let values: Vec<String> = values.iter().map(|value| exact(*value)).collect();
        put(out, format!("{key} = [{}]", values.join(", ")));
    };
    list("speeds", &bearing.speeds);
    let names = ["kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy"];
    for (key, values) in names.into_iter().zip(bearing.stiffness.iter().chain(&bearing.damping)) {
        list(key, values);
    }
}

fn pedestal(out: &mut String, name: &str, pedestal: &Pedestal) {
    put(out, format!("[rotor.bearings.{name}.pedestal]"));
    let elements: Vec<String> = pedestal.elements.iter().map(|element| in_one_line(element)).collect();
    put(out, format!("# {}", elements.join(", ")));
    for (key, [x, y]) in [("mass", pedestal.mass), ("stiffness", pedestal.stiffness), ("damping", pedestal.damping)] {
        put(out, format!("{key} = [{}, {}]", exact(x), exact(y)));
    }
}

/// Writes Rayleigh damping if all shaft elements have the same.
fn damping(out: &mut String, rotor: &Rotor, supports: &Supports<'_>, notes: &mut Vec<Note>) {
    let Some(first) = rotor.beams.first().map(|beam| beam.damping) else { return };
    if rotor.beams.iter().any(|beam| beam.damping != first) {
        notes.push(Note::new(
            "ShaftElement",
            "alpha and beta differ between elements: damping is left out, because a machine has one pair",
        ));
        return;
    }
    let [alpha, beta] = first;
    if alpha == 0.0 && beta == 0.0 {
        return;
    }
    if alpha > 0.0 && !(supports.discs.is_empty() && supports.masses.is_empty()) {
        notes.push(Note::new("ShaftElement", "alpha acts on discs and point masses as well, which ROSS leaves undamped: decrements are larger here, several times with heavy discs"));
    }
    put(out, "\n[rotor.damping]");
    let _ = writeln!(out, "mass_proportional = {}\nstiffness_proportional = {}", exact(alpha), exact(beta));
}
