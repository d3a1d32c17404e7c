//! Features that each engine covers: machines with one additional feature, tried on each engine.

use super::{head, row};
use crate::support::root;
use bladeoff_model::machine::{Engine, MachineDef};
use std::fs;

/// A feature and the change of the test rig that adds it: text of the file, and its replacement.
type Feature = (&'static str, &'static str, &'static str);

const RUN: &str = "end_time = \"0.6 s\"                 # without an end time it stops near 2.1 s\n";
const SPEED: &str = "initial_speed = \"3000 rpm\"\n";
const DETECTION: &str = "detection = \"hyp2\"\n";
const LEFT: &str = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\naxial_stiffness = \"1e6 N/m\"\n";
const SHAFT: &str = "shear_coefficient = 0.9\n";
const SEAL: &str = "elements = 16\n";
const BLADES: &str = "count = 8\n";
/// Stands for the whole diaphragm, which is replaced.
const DIAPHRAGM: &str = "";

const FEATURES: [Feature; 34] = [
    ("detection `hyp2`, flexible ring", DETECTION, "detection = \"hyp2\"\n"),
    ("detection `hyp1`", DETECTION, "detection = \"hyp1\"\n"),
    ("detection `hyp2-frozen`", DETECTION, "detection = \"hyp2-frozen\"\n"),
    ("`hyp2` with several contact points", DETECTION, "detection = \"hyp2\"\npoints = \"several\"\n"),
    ("`hyp2` with one contact point", DETECTION, "detection = \"hyp2\"\npoints = \"one\"\n"),
    ("friction that sticks and slides back", DETECTION, "detection = \"hyp2\"\nfriction_law = \"stick-slip\"\n"),
    ("contact force at the place of step n", RUN, "end_time = \"0.6 s\"\nforce_location = \"current\"\n"),
    ("rigid ring", DIAPHRAGM, "kind = \"rigid\"\n"),
    ("radial spring as ring", DIAPHRAGM, "kind = \"radial-spring\"\nstiffness = \"1e7 N/m\"\n"),
    ("ring without blades", BLADES, "count = 0\n"),
    ("ring of more than 200 elements", SEAL, "elements = 240\n"),
    (
        "yield strength of ring and blades",
        "[diaphragms.seal.ring]\n",
        "yield_strength = \"400 MPa\"\n\n[diaphragms.seal.ring]\n",
    ),
    ("yield strength of the shaft", SHAFT, "shear_coefficient = 0.9\nyield_strength = \"400 MPa\"\n"),
    ("shaft without shear deformation", SHAFT, "shear_coefficient = \"none\"\n"),
    (
        "anisotropic bearings",
        LEFT,
        "stiffness = [[\"2e6 N/m\", 0.0], [0.0, \"3e6 N/m\"]]\ndamping = \"600 N s/m\"\naxial_stiffness = \"1e6 N/m\"\n",
    ),
    (
        "cross-coupled bearings",
        LEFT,
        "stiffness = [[\"2e6 N/m\", \"1e5 N/m\"], [\"-1e5 N/m\", \"2e6 N/m\"]]\ndamping = \"600 N s/m\"\naxial_stiffness = \"1e6 N/m\"\n",
    ),
    (
        "clearance of a bearing, as a limit",
        LEFT,
        "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\nclearance = \"0.2 mm\"\naxial_stiffness = \"1e6 N/m\"\n",
    ),
    (
        "bearing on a pedestal",
        "[rotor.unbalances.blade_off]\n",
        "[rotor.bearings.left.pedestal]\nmass = \"5 kg\"\nstiffness = \"1e7 N/m\"\n\n[rotor.unbalances.blade_off]\n",
    ),
    (
        "monitor of the displacement at a place without contact",
        "[rotor.unbalances.blade_off]\n",
        "[monitors.oil_seal]\nposition = \"0.1 m\"\ngap = \"0.5 mm\"\n\n[rotor.unbalances.blade_off]\n",
    ),
    (
        "bearing off the bearing line (elevation)",
        LEFT,
        "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\nelevation = [\"0 mm\", \"0.1 mm\"]\naxial_stiffness = \"1e6 N/m\"\n",
    ),
    (
        "bearing table over the speed",
        LEFT,
        "kind = \"table\"\ncoefficients = { speeds = [\"0 rpm\", \"4000 rpm\"], kxx = [2e6, 3e6], kyy = [2e6, 3e6], cxx = [600, 500], cyy = [600, 500] }\naxial_stiffness = \"1e6 N/m\"\n",
    ),
    (
        "torques over time, with a short circuit",
        "[braking]\n",
        "[torques.drive]\nposition = \"0.3 m\"\ntimes = [\"0.1 s\", \"0.1 s\"]\nvalues = [\"5 N m\", 0]\n\
         [torques.generator]\nposition = \"0.9 m\"\nbalance = true\nshort_circuit = { start = \"0.1 s\", frequency = \"3000 rpm\", amplitude = \"9 N m\", decay = \"0.1 s\" }\n\n[braking]\n",
    ),
    (
        "braking table over the speed",
        "[braking]\n",
        "[braking]\nspeeds = [0, \"4000 rpm\"]\ntorques = [0, \"1 N m\"]\n",
    ),
    ("gravity", "gravity = [0.0, 0.0]\n", "gravity = [0.0, -9.81]\n"),
    ("lost mass of a disc", "phase = \"0 deg\"\n", "phase = \"0 deg\"\nkind = \"lost\"\ndisc = \"right\"\n"),
    (
        "residual unbalance beside the lost mass",
        "[rotor.damping]\n",
        "[rotor.unbalances.residual]\nposition = \"0.4 m\"\nmass = \"1 g\"\nradius = \"40 mm\"\n\n[rotor.damping]\n",
    ),
    ("loss at a time or at a speed", "phase = \"0 deg\"\n", "phase = \"0 deg\"\nrelease_speed = \"2990 rpm\"\n"),
    ("prescribed speed", SPEED, "initial_speed = \"3000 rpm\"\nspeed_law = { acceleration = \"-20 rad/s2\" }\n"),
    ("rotor at rest at t = 0", SPEED, "initial_speed = \"0 rpm\"\n"),
    (
        "initial displacement",
        SPEED,
        "initial_speed = \"3000 rpm\"\ninitial = { displacement = [\"0.1 mm\", \"0 mm\"] }\n",
    ),
    ("twin run", RUN, "end_time = \"0.6 s\"\ntwin = 1e-6\n"),
    ("time step `run.step`", RUN, "end_time = \"0.6 s\"\nstep = \"2 us\"\n"),
    ("time step `run.contact_step`", RUN, "end_time = \"0.6 s\"\ncontact_step = \"10 us\"\n"),
    (
        "several diaphragms",
        "[diaphragms.seal]\n",
        "[diaphragms.other]\nkind = \"radial-spring\"\nstiffness = \"1e7 N/m\"\n[diaphragms.other.contact]\nposition = \"0.4 m\"\nrotor_radius = \"50 mm\"\ngap = \"0.5 mm\"\nfriction = 0.15\ndetection = \"hyp2\"\n\n[diaphragms.seal]\n",
    ),
];

const ENGINES: [Engine; 3] = [Engine::Exponential, Engine::Reduced, Engine::Full];

pub fn page() -> String {
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("shipped");
    let mut page = head(&["feature", "`exponential`", "`reduced`", "`full`", "`auto` selects"]);
    let mut rejected = 0;
    for (name, from, to) in FEATURES {
        let text = changed(&rig, from, to);
        let mut cells = vec![name.to_owned()];
        for engine in ENGINES {
            let is_accepted = build(&text, engine.word()).is_ok();
            rejected += usize::from(!is_accepted);
            cells.push(if is_accepted { "yes" } else { "-" }.to_owned());
        }
        let chosen =
            MachineDef::parse("rig.toml", &text).ok().filter(|def| def.build().is_ok()).and_then(|def| def.engine());
        cells.push(chosen.map_or("-".to_owned(), |choice| format!("`{}`", choice.engine.word())));
        page += &row(&cells);
    }
    assert!(rejected > 3 && build(&rig, "exponential").is_ok(), "engines differ: {rejected}");
    page
}

fn build(text: &str, engine: &str) -> Result<(), String> {
    let text = text.replacen("[run]\n", &format!("[run]\nengine = \"{engine}\"\n"), 1);
    let def = MachineDef::parse("rig.toml", &text).map_err(|problems| problems.to_string())?;
    def.build().map(|_| ()).map_err(|problems| problems.to_string())
}

fn changed(rig: &str, from: &str, to: &str) -> String {
    let text = if from == DIAPHRAGM {
        let (before, diaphragm) = rig.split_once("[diaphragms.seal]\n").expect("the rig has a diaphragm");
        let (_, contact) = diaphragm.split_once("[diaphragms.seal.contact]\n").expect("with a contact");
        format!("{before}[diaphragms.seal]\n{to}\n[diaphragms.seal.contact]\n{contact}")
    } else {
        assert!(rig.contains(from), "the rig has {from}");
        rig.replacen(from, to, 1)
    };
    assert!(ENGINES.iter().any(|engine| build(&text, engine.word()).is_ok()), "{to}: {:?}", build(&text, "reduced"));
    text
}
