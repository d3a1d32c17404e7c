//! Invalid machine files: every mistake is reported with its position, key and reason, all at once, and no text makes the reader panic.

use crate::common::shipped;
use bladeoff_model::machine::MachineDef;
use bladeoff_text::document::Problems;
use proptest::prelude::*;

fn problems(text: &str) -> Problems {
    MachineDef::parse("test.toml", text).err().unwrap_or_else(|| panic!("accepted:\n{text}"))
}

/// Line of the `nth` occurrence (from 1) of a piece of text.
fn line_of(text: &str, piece: &str, nth: usize) -> usize {
    let at = text.match_indices(piece).nth(nth - 1).unwrap_or_else(|| panic!("{piece} is not there")).0;
    text[..at].matches('\n').count() + 1
}

/// Text to replace (its first occurrence), replacement, and the expected problem: text on its line, key, part of the message.
type Case = (&'static str, &'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const SHAFT_CASES: &[Case] = &[
    // The file.
    ("schema = 1", "schema = 2", "schema = 2", "schema", "version 2 of the machine format is not known; this program reads version 1"),
    ("schema = 1", "schema = \"1\"", "schema =", "schema", "not known"),
    ("schema = 1\n", "", "# Test rig", "schema", "missing"),
    ("name = \"lab_rig\"\n", "", "# Test rig", "name", "missing"),
    ("name = \"lab_rig\"", "name = \"\"", "name =", "name", "not a usable name"),
    ("name = \"lab_rig\"", "name = 3", "name =", "name", "text in quotes is expected, not a whole number"),
    ("name = \"lab_rig\"", "name = \"x\"\nauthor = \"me\"", "author", "author", "unknown key"),
    ("[run]", "[run", "[run", "", "not valid TOML"),
    ("[run]", "[run]\nend_time = 3", "end_time = \"0.6", "", "not valid TOML: duplicate key"),
    // Unknown names and their nearest.
    ("friction = 0.15", "fricton = 0.15", "fricton", "diaphragms.seal.contact.fricton", "unknown key; allowed: position, rotor_radius"),
    ("friction = 0.15", "fricton = 0.15", "fricton", "diaphragms.seal.contact.fricton", "did you mean `friction`?"),
    ("friction = 0.15", "fricton = 0.15", "[diaphragms.seal.contact]", "diaphragms.seal.contact.friction", "missing: Coulomb friction coefficient; allowed: 0 to 100"),
    ("[braking]", "[breaking]", "[breaking]", "breaking", "unknown table; allowed: schema, name, run"),
    ("[braking]", "[breaking]", "[breaking]", "breaking", "did you mean `braking`?"),
    ("[rotor.bearings.left]", "[rotor.bearing.left]", "[rotor.bearing.left]", "rotor.bearing", "did you mean `bearings`?"),
    // Types.
    ("gap = \"0.5 mm\"", "gap = true", "gap = true", "diaphragms.seal.contact.gap", "expected, not a boolean"),
    ("gap = \"0.5 mm\"", "gap = 2026-01-01", "gap = 2026", "diaphragms.seal.contact.gap", "not a date or time"),
    ("gap = \"0.5 mm\"", "gap = 07:30:00", "gap = 07", "diaphragms.seal.contact.gap", "gap = 07:30:00:"),
    ("gap = \"0.5 mm\"", "gap = [1]", "gap = [1]", "diaphragms.seal.contact.gap", "not an array"),
    ("gap = \"0.5 mm\"", "gap = {a = 1}", "gap = {", "diaphragms.seal.contact.gap", "not a table"),
    ("detection = \"hyp2\"", "detection = 2", "detection = 2", "diaphragms.seal.contact.detection", "a word in quotes is expected, not a whole number"),
    ("detection = \"hyp2\"", "detection = \"hyp2_frozen\"", "detection =", "diaphragms.seal.contact.detection", "allowed: \"hyp1\", \"hyp2\", \"hyp2-frozen\"; did you mean `hyp2-frozen`?"),
    ("elements = 16", "elements = 16.5", "elements = 16.5", "diaphragms.seal.ring.elements", "a whole number is expected"),
    ("elements = 16", "elements = \"16\"", "elements = \"16\"", "diaphragms.seal.ring.elements", "a whole number is expected, not a string"),
    ("[braking]\n", "braking = 3\n[other]\n", "braking = 3", "rotor.damping.braking", "unknown key"),
    ("gravity = [0.0, 0.0]", "gravity = [0.0, 0.0]\nmaterial = 3\n[rotor.x]", "[rotor.material]", "", "not valid TOML: duplicate key at `material`"),
    ("offset = [\"0 mm\", \"0 mm\"]", "offset = [0]", "offset = [0]", "diaphragms.seal.contact.offset", "1 components instead of 2"),
    ("offset = [\"0 mm\", \"0 mm\"]", "offset = 0", "offset = 0", "diaphragms.seal.contact.offset", "two components are expected"),
    ("offset = [\"0 mm\", \"0 mm\"]", "offset = [0, \"1 s\"]", "offset =", "diaphragms.seal.contact.offset[1]", "does not fit"),
    ("stiffness = \"2e6 N/m\"", "stiffness = [[1e6, 0], [0]]", "stiffness = [[", "rotor.bearings.left.stiffness", "not a 2x2 matrix"),
    ("[rotor.damping]\nmass_proportional = \"5 1/s\"\nstiffness_proportional = \"2e-5 s\"", "[rotor.damping]", "[rotor.damping]", "rotor.damping", "empty table"),
    ("[rotor.bearings.left]", "[rotor.bearings.\"left side\"]", "[rotor.bearings.\"left", "rotor.bearings.left side", "not a usable name"),
    ("[rotor.bearings.left]", "[rotor.bearings.left_at_s]", "[rotor.bearings.left_at", "rotor.bearings.left_at_s", "another result column"),
    ("[rotor.bearings.left]", "[rotor.bearings.\u{6c}2_N]", "[rotor.bearings.l2", "rotor.bearings.l2_N", "not a usable name"),
    // Units and ranges.
    ("gap = \"0.5 mm\"", "gap = \"0.5 mn\"", "gap =", "diaphragms.seal.contact.gap", "gap = \"0.5 mn\": unknown unit `mn`, write \"8 mm\", \"0.55 m\"; allowed: 1e-9 to 1e6 m; did you mean `mm`?"),
    ("gap = \"0.5 mm\"", "gap = \"0.5 kg\"", "gap =", "diaphragms.seal.contact.gap", "gap = \"0.5 kg\": the unit `kg` does not fit: m is expected, such as \"8 mm\""),
    ("gap = \"0.5 mm\"", "gap = \"0.5\"", "gap =", "diaphragms.seal.contact.gap", "has no unit"),
    ("gap = \"0.5 mm\"", "gap = \"0 mm\"", "gap =", "diaphragms.seal.contact.gap", "out of range; allowed: 1e-9 to 1e6 m"),
    ("gap = \"0.5 mm\"", "gap = -0.0005", "gap =", "diaphragms.seal.contact.gap", "out of range"),
    ("gap = \"0.5 mm\"", "gap = nan", "gap =", "diaphragms.seal.contact.gap", "out of range"),
    ("gap = \"0.5 mm\"", "gap = 1e999", "gap =", "diaphragms.seal.contact.gap", "out of range"),
    ("friction = 0.15", "friction = -0.15", "friction =", "diaphragms.seal.contact.friction", "friction = -0.15: out of range; allowed: 0 to 100"),
    ("friction = 0.15", "friction = \"0.15 deg\"", "friction =", "diaphragms.seal.contact.friction", "a pure number such as 0.2 or"),
    ("initial_speed = \"3000 rpm\"", "initial_speed = \"50 Hz\"", "initial_speed", "rotor.initial_speed", "write the value in rpm or rad/s or rev/s"),
    ("initial_speed = \"3000 rpm\"", "initial_speed = \"-3000 rpm\"", "initial_speed", "rotor.initial_speed", "out of range"),
    ("initial_speed = \"3000 rpm\"", "initial_speed = 1e300", "initial_speed", "rotor.initial_speed", "out of range; allowed: 0 to 1e6 rad/s"),
    ("end_time = \"0.6 s\"", "end_time = 1e-300", "end_time", "run.end_time", "out of range; allowed: 1e-10 to 1e6 s"),
    ("mass = \"10 g\"", "mass = 1e300", "mass = 1e300", "rotor.unbalances.blade_off.mass", "out of range; allowed: 0 to 1e9 kg"),
    ("phase = \"0 deg\"", "release_time = -1", "release_time = -1", "rotor.unbalances.blade_off.release_time", "out of range; allowed: 0 to"),
    ("phase = \"0 deg\"", "release_time = \"3 rpm\"", "release_time", "rotor.unbalances.blade_off.release_time", "the unit `rpm` does not fit: s is expected"),
    ("phase = \"0 deg\"", "release_speed = 0", "release_speed = 0", "rotor.unbalances.blade_off.release_speed", "out of range"),
    ("phase = \"0 deg\"", "release_time = 1\nrelease_speed = 300", "release_speed = 300", "rotor.unbalances.blade_off.release_speed", "release_time is given too; allowed: at most one of"),
    ("phase = \"0 deg\"", "present = \"before\"\nrelease_speed = 300", "release_speed = 300", "rotor.unbalances.blade_off.release_speed", "present before has no release"),
    ("phase = \"0 deg\"", "release_tim = 1", "release_tim = 1", "rotor.unbalances.blade_off.release_tim", "did you mean `release_time`?"),
    ("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 1e300], [0, 2e6]]", "stiffness = [[", "rotor.bearings.left.stiffness[0][1]", "out of range; allowed: -1e18 to 1e18 N/m"),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "poisson_ratio = 0.5", "rotor.material.poisson_ratio", "> -1 and < 0.5"),
    ("shear_coefficient = 0.9", "shear_coefficient = \"cooper\"", "shear_coefficient", "rotor.material.shear_coefficient", "did you mean `cowper`?"),
    ("elements = 16", "elements = 0", "elements = 0", "diaphragms.seal.ring.elements", "4 to 600"),
    ("elements = 2", "elements = 1000000000", "elements = 1000000000", "rotor.shaft[0].elements", "1 to 500"),
    ("end_time = \"0.6 s\"", "end_time = \"0 s\"", "end_time", "run.end_time", "out of range"),
    ("end_time = \"0.6 s\"", "end_time = 1\nrotor_modes = 1", "rotor_modes", "run.rotor_modes", "2 to 10000"),
    ("end_time = \"0.6 s\"", "end_time = 1\nguard = {normal_wrok = 1}", "guard", "run.guard.normal_wrok", "did you mean `normal_work`?"),
    // Across keys.
    ("end_time = \"0.6 s\"", "end_time = 1\nstep = 2", "step = 2", "run.step", "longer than the whole run; allowed: at most run.end_time = 1 s"),
    ("end_time = \"0.6 s\"", "end_time = 1\nend_speed = \"3000 rpm\"", "end_speed", "run.end_speed", "below rotor.initial_speed = 3000 rpm"),
    ("position = \"0.4 m\"", "position = \"0.4005 m\"", "position = \"0.4005 m\"", "rotor.discs.left.position", "0.5 mm from the node at 400 mm: the element between them would be too short to be computed with; allowed: 400 mm, or at least 1 mm away from it"),
    ("position = \"0.4 m\"", "position = \"0.399998 m\"", "position = \"0.399998 m\"", "rotor.discs.left.position", "from the node at 400 mm"),
    ("position = \"1 m\"", "position = \"1.1 m\"", "position = \"1.1 m\"", "rotor.bearings.right.position", "outside the shaft; allowed: 0 to 1 m"),
    ("position = \"0.5 m\"", "position = \"1.55 m\"", "position = \"1.55 m\"", "diaphragms.seal.contact.position", "outside the shaft"),
    ("axial_stiffness = \"1e6 N/m\"\n", "", "[rotor.bearings.left]", "rotor.bearings.left.axial_stiffness", "no axial support"),
    ("[rotor.bearings.right]\nposition = \"1 m\"", "[rotor.bearings.right]\nposition = \"0 m\"", "[rotor.bearings.left]", "rotor.bearings", "no lateral support"),
    ("diameter = \"25 mm\"", "diameter = \"25 mm\"\ninner_diameter = \"25 mm\"", "inner_diameter", "rotor.shaft[0].inner_diameter", "below diameter = 25 mm"),
    ("diameter = \"25 mm\"", "diameter = \"25 mm\"\nend_inner_diameter = \"25 mm\"", "end_inner_diameter", "rotor.shaft[0].end_inner_diameter", "below end_diameter = 25 mm"),
    ("diameter = \"25 mm\"", "diameter = \"25 mm\"\ninner_diameter = \"20 mm\"\nend_diameter = \"15 mm\"", "end_diameter", "rotor.shaft[0].end_diameter", "above end_inner_diameter = 20 mm"),
    ("[rotor.discs.left]", "[rotor.layers.hub]\nposition = 0.9\nlength = \"0.2 m\"\ndiameter = 0.1\ninner_diameter = 0.025\n[rotor.discs.left]", "length = \"0.2 m\"", "rotor.layers.hub.length", "outside the shaft; allowed: 0 to 1 m"),
    ("[rotor.discs.left]", "[rotor.layers.hub]\nposition = 0.1\nlength = 1e-7\ndiameter = 0.1\ninner_diameter = 0.025\n[rotor.discs.left]", "length = 1e-7", "rotor.layers.hub.length", "too short to be computed with"),
    ("[rotor.discs.left]", "[rotor.layers.hub]\nposition = 0.1\nlength = 0.1\ndiameter = 0.1\ninner_diameter = 0.1\n[rotor.discs.left]", "inner_diameter", "rotor.layers.hub.inner_diameter", "below diameter = 100 mm"),
    ("length = \"300 mm\"\n", "", "[[rotor.shaft]]", "rotor.shaft[0].length", "missing"),
    ("length = \"300 mm\"\n", "element_lengths = [0.3]\n", "element_lengths", "rotor.shaft[0].element_lengths", "either length and elements, or element_lengths"),
    ("length = \"300 mm\"\n", "element_lengths = []\n", "element_lengths", "rotor.shaft[0].element_lengths", "a list of 0 entries"),
    ("diameter = \"25 mm\"", "diameter = 0.025\nshear_coefficient = 0.9\nmaterial = {shear_coefficient = 0.8}", "shear_coefficient = 0.9\nmat", "rotor.shaft[0].shear_coefficient", "given twice"),
    ("elements = 16", "elements = 20", "elements = 20", "diaphragms.seal.ring.elements", "a multiple of blades.count = 8"),
    ("count = 8\n", "", "[diaphragms.seal.blades]", "diaphragms.seal.blades.count", "missing"),
    ("length = \"40 mm\"\n", "", "[diaphragms.seal.blades]", "diaphragms.seal.blades.length", "missing"),
    ("thickness = \"3 mm\"", "thickness = \"104 mm\"", "thickness = \"104 mm\"", "diaphragms.seal.ring.thickness", "no inner edge"),
    ("gap = \"0.5 mm\"", "gap = \"5 mm\"", "gap = \"5 mm\"", "diaphragms.seal.contact.gap", "gap = 5 mm: rotor_radius + gap = 55 mm does not fit the ring, whose inner face (mean_radius - thickness/2) is at 50.5 mm: from this rotor_radius to that face there are 0.5 mm; allowed: rotor_radius + gap from 47.5 mm to 52 mm (a thickness"),
    ("rotor_radius = \"50 mm\"", "rotor_radius = \"30 mm\"", "rotor_radius", "diaphragms.seal.contact.rotor_radius", "rotor_radius = 30 mm: rotor_radius + gap = 30.5 mm does not fit the ring, whose inner face (mean_radius - thickness/2) is at 50.5 mm: from this rotor_radius to that face there are 20.5 mm"),
    ("rotor_radius = \"50 mm\"", "rotor_radius = \"60 mm\"", "rotor_radius", "diaphragms.seal.contact.rotor_radius", "this rotor_radius lies 9.5 mm beyond that face"),
    ("[diaphragms.seal.material]", "kind = \"rigid\"\n[diaphragms.seal.material]", "young_modulus = \"200 GPa\"", "diaphragms.seal.material.young_modulus", "does not belong to kind = \"rigid\""),
    ("[diaphragms.seal.material]", "stiffness = \"1 N/m\"\n[diaphragms.seal.material]", "stiffness = \"1 N/m\"", "diaphragms.seal.stiffness", "only with kind = \"radial-spring\""),
    ("[braking]", "[rotor.speed_law]\nacceleration = 1\ntimes = [0]\n[braking]", "acceleration", "rotor.speed_law.acceleration", "either acceleration, or times and speeds"),
    ("[braking]", "[rotor.speed_law]\ntimes = [0]\n[braking]", "[rotor.speed_law]", "rotor.speed_law.speeds", "missing"),
    ("[braking]", "[rotor.speed_law]\ntimes = [0, 1]\nspeeds = [\"3000 rpm\"]\n[braking]", "speeds =", "rotor.speed_law.speeds", "2 times and 1 speeds"),
    ("[braking]", "[rotor.speed_law]\ntimes = [0, 1, 1]\nspeeds = [\"3000 rpm\", 1, 2]\n[braking]", "times =", "rotor.speed_law.times[2]", "do not ascend"),
    ("[braking]", "[rotor.speed_law]\ntimes = [1, 2]\nspeeds = [\"3000 rpm\", 1]\n[braking]", "times =", "rotor.speed_law.times[0]", "does not start at t = 0"),
    ("[braking]", "[rotor.speed_law]\ntimes = [0, 2]\nspeeds = [\"2000 rpm\", 1]\n[braking]", "speeds =", "rotor.speed_law.speeds[0]", "rotor.initial_speed = 3000 rpm"),
    ("[braking]\n", "[braking]\nspeeds = [0, 400]\n", "[braking]", "braking.torques", "missing: braking torques at these speeds"),
    ("[braking]\n", "[braking]\ntorques = [0, 400]\n", "[braking]", "braking.speeds", "missing"),
    ("[braking]\n", "[braking]\nspeeds = [0, 400]\ntorques = [1]\n", "torques = [1]", "braking.torques", "1 torques for 2 speeds; allowed: as many"),
    ("[braking]\n", "[braking]\nspeeds = [1, 400]\ntorques = [1, 2]\n", "speeds = [1", "braking.speeds[0]", "does not begin at rest; allowed: 0 rad/s"),
    ("[braking]\n", "[braking]\nspeeds = [0, 0]\ntorques = [1, 2]\n", "speeds = [0", "braking.speeds[1]", "speeds do not ascend; allowed: above 0 rpm"),
    ("[braking]\n", "[braking]\nspeeds = [0, 100]\ntorques = [1, 2]\n", "speeds = [0", "braking.speeds[1]", "the table ends below rotor.initial_speed = 3000 rpm"),
    ("[braking]\n", "[braking]\nspeeds = [0, 400]\ntorques = [1, -2]\n", "torques = [1", "braking.torques[1]", "out of range; allowed: 0 to"),
    ("[braking]", "[torques.a]\nposition = 0.5\ntimes = [0]\nvalues = [5]\n[braking]", "[torques.a]", "torques", "the torques and braking add up to 3.28472 N m at t = 0 (braking: -1.71528 N m), not to 0; allowed: balance = true of one torque, which then takes the rest, or values that add up to 0"),
    ("[braking]", "[torques.a]\nposition = 0.5\n[braking]", "[torques.a]", "torques.a.values", "missing: torques at these times"),
    ("[braking]", "[torques.a]\nposition = 0.5\ntimes = [0]\n[braking]", "[torques.a]", "torques.a.values", "missing"),
    ("[braking]", "[torques.a]\nposition = 0.5\nvalues = [0]\n[braking]", "[torques.a]", "torques.a.times", "missing"),
    ("[braking]", "[torques.a]\nposition = 1.5\nbalance = true\n[braking]", "position = 1.5", "torques.a.position", "outside the shaft; allowed: 0 to 1 m"),
    ("[braking]", "[torques.a]\nbalance = true\n[braking]", "[torques.a]", "torques.a.position", "missing"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = \"yes\"\n[braking]", "balance =", "torques.a.balance", "not an allowed word; allowed: \"false\", \"true\""),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = 1\n[braking]", "balance =", "torques.a.balance", "expected, not a whole number"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\ntimes = [0]\nvalues = [3]\n[braking]", "values =", "torques.a.values", "the torque is what balance makes it"),
    ("[braking]", "[torques.a]\nposition = 0.5\ntimes = [0]\nvalues = [0.1]\nfactors = [1]\n[braking]", "factors =", "torques.a.factors", "factors of nothing; allowed: values, or balance = true"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\ntimes = [0, 1]\nfactors = [2, 1]\n[braking]", "factors =", "torques.a.factors[0]", "has the factor 1 at t = 0; allowed: 1"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\ntimes = [0, 1]\nfactors = [1]\n[braking]", "factors =", "torques.a.factors", "1 for 2 times; allowed: as many"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\ntimes = [0, 2, 1]\nfactors = [1, 1, 1]\n[braking]", "times = [0, 2", "torques.a.times[2]", "times do not ascend; allowed: not before 2 s"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\ntimes = [0, 0, 0]\nfactors = [1, 1, 1]\n[braking]", "times = [0, 0", "torques.a.times[2]", "later than 0 s: a jump has two values at one time"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\n[torques.b]\nposition = 0.7\nbalance =  true\n[braking]", "balance =  true", "torques.b.balance", "a has balance = true too; allowed: balance = true of one torque"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\nshort_circuit = {start = 0, frequency = 314, decay = 1}\n[braking]", "short_circuit", "torques.a.short_circuit.amplitude", "missing: amplitude of the part"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\nshort_circuit = {start = 0, frequency = \"50 Hz\", amplitude = 1, decay = 1}\n[braking]", "short_circuit", "torques.a.short_circuit.frequency", "Hz"),
    ("[braking]", "[torques.a]\nposition = 0.5\nbalance = true\nshort_circuit = {start = 0, frequency = 314, amplitude = 1, decay = 0}\n[braking]", "short_circuit", "torques.a.short_circuit.decay", "out of range"),
    ("[rotor]\n", "[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\n", "length = \"300 mm\"", "rotor.shaft[0].length", "only with rotor.kind = \"shaft\""),
    ("[rotor]\n", "[rotor]\nmass = 1\n", "mass = 1\n", "rotor.mass", "only with rotor.kind = \"point-mass\""),
    ("[rotor]\n", "[rotor]\nkind = \"pointmass\"\n", "kind =", "rotor.kind", "did you mean `point-mass`?"),
];

#[rustfmt::skip]
const POINT_CASES: &[Case] = &[
    ("mass = 10\n", "", "[rotor]", "rotor.mass", "missing: mass of the mass point"),
    ("mass = 10\n", "mass = 0\n", "mass = 0", "rotor.mass", "no mass, its unbalances included"),
    ("polar_inertia = 1\n", "polar_inertia = 0\n", "polar_inertia", "rotor.polar_inertia", "out of range"),
    ("radius = 0.01", "radius = 100", "polar_inertia", "rotor.polar_inertia", "more inertia than the rotor"),
    ("[rotor.bearings.b]\n", "[rotor.bearings.b]\nposition = 0\n", "position", "rotor.bearings.b.position", "only with rotor.kind = \"shaft\""),
    ("gap = 0.001", "gap = 0.001\nposition = 0", "position", "diaphragms.d.contact.position", "only with rotor.kind = \"shaft\""),
    ("stiffness = 1e6", "stiffness = [[1e6, 0], [0, 0]]", "[rotor.bearings.b]", "rotor.bearings", "no lateral support"),
    ("stiffness = 1e6", "stiffness = \"0 N/m\"", "[rotor.bearings.b]", "rotor.bearings", "resists every translation"),
    ("kind = \"radial-spring\"\n", "kind = \"radial-spring\"\ndamping = {mass_proportional = 1}\n", "damping", "diaphragms.d.damping.mass_proportional", "only with kind = \"flexible\""),
    ("stiffness = 1e8\n", "", "[diaphragms.d]", "diaphragms.d.stiffness", "missing: contact force over penetration; allowed: 1e-9 to 1e18 N/m"),
];

/// A syntax error does not hide the other problems of a file; problems that only follow from it are not reported.
#[test]
fn problems_beside_a_syntax_error_are_reported() {
    let text = shipped("lab_rig")
        .replacen("gap = \"0.5 mm\"", "gap = 0.5 mm", 1)
        .replacen("rotor_radius = \"50 mm\"", "rotor_radius = = 3", 1)
        .replacen("friction = 0.15", "fricton = 0.15", 1)
        .replacen("elements = 16", "elements = 16.5", 1)
        .replacen("length = \"40 mm\"\n", "", 1);
    let found = problems(&text);
    let told: Vec<String> = found.list.iter().map(ToString::to_string).collect();
    let all = told.join("\n");
    for part in [
        "not valid TOML: string values must be quoted",
        "not valid TOML: extra `=`",
        "did you mean `friction`?",
        "a whole number is expected",
    ] {
        assert!(all.contains(part), "{part} is not in\n{all}");
    }
    assert_eq!(told.len(), 4, "{all}");
}

const POINT: &str = "schema = 1\nname = 'p'\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 10\npolar_inertia = 1\n\
    initial_speed = 100\n[rotor.bearings.b]\nstiffness = 1e6\n[rotor.unbalances.u]\nmass = 0.001\nradius = 0.01\n\
    kind = \"lost\"\n[diaphragms.d]\nkind = \"radial-spring\"\nstiffness = 1e8\n[diaphragms.d.contact]\n\
    rotor_radius = 0.1\ngap = 0.001\nfriction = 0.1\n";

fn check(base: &str, cases: &[Case]) {
    let mut missed = Vec::new();
    for &(from, to, at, key, part) in cases {
        assert!(base.contains(from), "{from}");
        let text = base.replacen(from, to, 1);
        let found = problems(&text);
        let line = line_of(&text, at, 1);
        let hit = found.list.iter().any(|p| p.line == line && p.key == key && p.to_string().contains(part));
        if !hit {
            missed.push(format!("{from} -> {to}: expected line {line}, `{key}`, `{part}`; found\n{found}"));
        }
        assert!(found.list.windows(2).all(|pair| pair[0].span.start <= pair[1].span.start));
    }
    assert!(missed.is_empty(), "{}", missed.join("\n\n"));
}

#[test]
fn every_mistake_is_reported_with_line_key_and_reason() {
    assert!(SHAFT_CASES.len() + POINT_CASES.len() > 80);
    check(&shipped("lab_rig"), SHAFT_CASES);
    MachineDef::parse("p", POINT).unwrap_or_else(|problems| panic!("{problems}"));
    check(POINT, POINT_CASES);
}

#[test]
fn one_mistake_is_one_problem() {
    let text = shipped("lab_rig");
    for (from, to) in [
        ("gap = \"0.5 mm\"", "gap = \"0 mm\""),
        ("position = \"0.4 m\"", "position = \"0.4005 m\""),
        ("rotor_radius = \"50 mm\"", "rotor_radius = \"30 mm\""),
        ("offset = [\"0 mm\", \"0 mm\"]", "offset = [0]"),
        ("stiffness = \"2e6 N/m\"", "stiffness = [[1]]"),
        ("elements = 2", "elements = 0"),
        ("diameter = \"25 mm\"", "diameter = \"25\""),
        ("density = \"7850 kg/m3\"", ""),
        ("initial_speed = \"3000 rpm\"", "initial_speed = \"3000\""),
        ("end_time = \"0.6 s\"", "end_time = []"),
        ("[rotor]\n", "[rotor]\nkind = \"pointmass\"\n"),
        ("[diaphragms.seal.material]", "kind = \"stiff\"\n[diaphragms.seal.material]"),
    ] {
        let found = problems(&text.replacen(from, to, 1));
        assert_eq!(found.list.len(), 1, "{from} -> {to}\n{found}");
    }
}

#[test]
fn a_file_with_eight_mistakes_reports_all_eight() {
    let mut text = shipped("lp_turbine_paper");
    for (from, to) in [
        ("end_time = \"6 s\"", "end_time = \"-6 s\""),
        ("density = \"7850 kg/m3\"", "density = \"7850 kg/m2\""),
        ("position = \"2.55 m\"", "position = \"2.551 m\""),
        ("axial_stiffness = \"1e8 N/m\"", "axial_stifness = \"1e8 N/m\""),
        ("quadratic = ", "cubic = "),
        ("elements = 48", "elements = 50"),
        ("gap = \"8 mm\"", "gap = 0"),
        ("detection = \"hyp2\"", "detection = \"hyp4\""),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let found = problems(&text);
    let keys: Vec<&str> = found.list.iter().map(|problem| problem.key.as_str()).collect();
    for key in [
        "run.end_time",
        "rotor.material.density",
        "rotor.discs.inner_front.position",
        "rotor.bearings.front.axial_stifness",
        "rotor.bearings.front.axial_stiffness",
        "braking.cubic",
        "diaphragms.mid.ring.elements",
        "diaphragms.mid.contact.gap",
        "diaphragms.mid.contact.detection",
    ] {
        assert!(keys.contains(&key), "{key} is not among\n{found}");
    }
    assert_eq!(keys.len(), 9, "{found}");
    assert!(found.to_string().lines().all(|line| line.starts_with("test.toml:")));
}

#[test]
fn huge_and_deep_files_are_refused_quickly() {
    let base = shipped("lab_rig");
    let many = |piece: &str, count: usize| format!("{base}\n{}", piece.repeat(count));
    for text in [
        many("[[rotor.shaft]]\nlength = 1\nelements = 500\ndiameter = 1\n", 900),
        many("[[rotor.shaft]]\n", 20_000),
        many("x", 500_000),
        format!("{base}\n[a{}]", ".a".repeat(100_000)),
        base.replace("gravity = [0.0, 0.0]", &format!("gravity = {}1{}", "[".repeat(10_000), "]".repeat(10_000))),
        base.replace("gravity = [0.0, 0.0]", &format!("gravity = [{}]", "0,".repeat(200_000))),
        base.replace("gap = \"0.5 mm\"", &format!("gap = \"{} mm\"", "9".repeat(100_000))),
        base.replace("gap = \"0.5 mm\"", &format!("gap = \"1 {}\"", "mm ".repeat(100_000))),
        format!("{base}\n{}", (0..20_000).map(|i| format!("[rotor.bearings.b{i}]\nposition=0\n")).collect::<String>()),
        format!("{base}\n{}", (0..40_000).map(|i| format!("key_{i} = 1\n")).collect::<String>()),
    ] {
        assert!(problems(&text).list.len() <= 200);
    }
}

/// Mutates a text: byte flips, lines deleted, doubled or exchanged, numbers replaced.
fn mutate(text: &str, steps: &[(u8, usize, u8)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for &(kind, at, byte) in steps {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let mut lines: Vec<&str> = text.lines().collect();
        let count = lines.len().max(1);
        match kind % 6 {
            0 => {
                let len = bytes.len().max(1);
                if let Some(target) = bytes.get_mut(at % len) {
                    *target = byte;
                }
                continue;
            }
            1 if !lines.is_empty() => {
                lines.remove(at % count);
            }
            2 if !lines.is_empty() => lines.insert(usize::from(byte) % count, lines[at % count]),
            3 if !lines.is_empty() => lines.swap(at % count, usize::from(byte) % count),
            _ => {}
        }
        let mut text = lines.join("\n");
        if kind % 6 >= 4 {
            let numbers =
                ["1e308", "-1", "0", "9".repeat(30).as_str(), "nan", "1e-320", "\"\"", "[[]]"].map(str::to_owned);
            let digits: Vec<usize> = text.match_indices(|c: char| c.is_ascii_digit()).map(|(i, _)| i).collect();
            if let Some(&place) = digits.get(at % digits.len().max(1)) {
                text.replace_range(place..=place, &numbers[usize::from(byte) % numbers.len()]);
            }
        }
        bytes = text.into_bytes();
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn mutated_machines_are_read_or_refused(
        turbine in any::<bool>(),
        steps in prop::collection::vec((any::<u8>(), any::<usize>(), any::<u8>()), 1..8),
    ) {
        let text = mutate(&shipped(if turbine { "lp_turbine_paper" } else { "lab_rig" }), &steps);
        match MachineDef::parse("m", &text) {
            Ok(def) => {
                let machine = def.build().expect("parse checks what build checks");
                let record = def.to_toml();
                let again = MachineDef::parse("record", &record).unwrap_or_else(|problems| panic!("{problems}\n{record}"));
                prop_assert_eq!(again.build().unwrap(), machine);
            }
            Err(problems) => {
                prop_assert!(!problems.list.is_empty());
                for problem in &problems.list {
                    prop_assert!(problem.line >= 1 && text.get(problem.span.clone()).is_some());
                }
            }
        }
    }

    #[test]
    fn any_value_text_is_read_or_refused(path in ".{0,20}", text in ".{0,20}") {
        let def = MachineDef::parse("m", POINT).unwrap();
        let _ = def.resolve(&path);
        for info in def.paths() {
            if let Ok(value) = def.parse_value(&info, &text) {
                prop_assert!(def.check_value(&info, &value).is_ok());
            }
        }
    }
}
