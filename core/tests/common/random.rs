//! Random machines, each with nine starts, and their runs from release to 15 ms after first contact. The results of single impacts scatter with
//! the step; the mean of nine starts shows the error of an engine. Shared by `exponential_random.rs` and the example `exponential_accuracy`.
#![allow(dead_code, reason = "the test and the example use their own parts")]

use bladeoff_core::engine::{TimeStep, simulate};
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};
use bladeoff_model::outcome::Outcome;

/// A reproducible stream of random numbers.
struct Stream(u64);

impl Stream {
    /// In 0..1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.next()
    }

    /// Random number, uniform in its logarithm.
    fn decades(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.next())
    }

    fn choice<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.next() * of.len() as f64) as usize]
    }
}

/// Kinds of bearings.
const KINDS: [&str; 4] = ["isotropic", "anisotropic", "damped", "cross-coupled"];

/// Text of a machine of three sections and two discs, with `GAP` and `END` as placeholders; `kind` is that of its bearings.
fn drawn(random: &mut Stream, kind: &str, detection: &str) -> String {
    let lengths: [f64; 3] = std::array::from_fn(|_| random.between(0.25, 0.5));
    let (contact, disc, end) = (lengths[0], lengths[0] + lengths[1], lengths.iter().sum::<f64>());
    let mut text = format!(
        "schema = 1\nname = \"drawn\"\n[run]\nend_time = END\n[rotor]\ninitial_speed = {:?}\ngravity = [0.0, {:?}]\n\
         [rotor.material]\nyoung_modulus = {:e}\npoisson_ratio = 0.3\ndensity = 7850\nshear_coefficient = 0.9\n",
        random.between(200.0, 500.0),
        random.choice(&[0.0, -9.81]),
        random.between(1.9e11, 2.2e11),
    );
    for length in lengths {
        let diameter = random.between(0.028, 0.045);
        let elements = random.choice(&[2, 3]);
        text += &format!("[[rotor.shaft]]\nlength = {length:?}\ndiameter = {diameter:?}\nelements = {elements}\n");
    }
    for (name, position) in [("a", contact), ("b", disc)] {
        let (mass, radius) = (random.between(1.0, 6.0), random.between(0.05, 0.12));
        text += &format!(
            "[rotor.discs.{name}]\nposition = {position:?}\nmass = {mass:?}\ntransverse_inertia = {:?}\npolar_inertia = {:?}\n",
            0.3 * mass * radius * radius,
            0.5 * mass * radius * radius,
        );
    }
    for (name, position) in [("left", 0.0), ("right", end)] {
        let (k, c) = (random.decades(1e6, 1e7), random.between(300.0, 800.0));
        let (stiffness, damping) = match kind {
            "anisotropic" => ([k, 0.0, 0.0, random.between(0.4, 0.8) * k], [c, 0.0, 0.0, random.between(0.5, 2.0) * c]),
            "damped" => ([k, 0.0, 0.0, k], [10.0 * c, 0.0, 0.0, 10.0 * c]),
            "cross-coupled" => {
                let (skew, cross) = (random.between(0.01, 0.05) * k, random.between(-0.2, 0.2) * c);
                ([k, skew, -skew, random.between(0.6, 1.0) * k], [4.0 * c, cross, cross, 3.0 * c])
            }
            _ => ([k, 0.0, 0.0, k], [c, 0.0, 0.0, c]),
        };
        let matrix = |m: [f64; 4]| format!("[[{:?}, {:?}], [{:?}, {:?}]]", m[0], m[1], m[2], m[3]);
        text += &format!(
            "[rotor.bearings.{name}]\nposition = {position:?}\nstiffness = {}\ndamping = {}\naxial_stiffness = 1e6\n",
            matrix(stiffness),
            matrix(damping),
        );
    }
    // released at an angle to the blades
    text += &format!(
        "[rotor.unbalances.blade]\nposition = {disc:?}\nmass = {:?}\nradius = {:?}\nphase = {:?}\n\
         [rotor.damping]\nmass_proportional = {:?}\nstiffness_proportional = {:e}\n[braking]\nconstant = {:?}\nlinear = {:?}\n",
        random.between(0.02, 0.08),
        random.between(0.06, 0.1),
        random.between(0.0, std::f64::consts::TAU),
        random.between(0.0, 8.0),
        random.decades(2e-6, 2e-5),
        random.between(0.0, 0.5),
        random.decades(1e-4, 1e-2),
    );
    if random.next() < 0.5 {
        text += &format!(
            "[rotor.unbalances.residual]\nposition = {contact:?}\nmass = 0.005\nradius = 0.04\nphase = {:?}\npresent = \"before\"\n",
            random.between(0.0, std::f64::consts::TAU)
        );
    }
    let (mean, thickness) = (random.between(0.1, 0.16), random.between(0.004, 0.008));
    let (surface, radius) = random.choice(&[("inner-face", mean - 0.5 * thickness), ("mean-line", mean)]);
    let blades = random.choice(&[4, 6, 8]);
    text += &format!(
        "[diaphragms.seal]\nangle = {:?}\n[diaphragms.seal.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7850\n\
         [diaphragms.seal.ring]\nmean_radius = {mean:?}\nthickness = {thickness:?}\nwidth = 0.015\nelements = 24\n\
         [diaphragms.seal.blades]\ncount = {blades}\nlength = {:?}\nthickness = {:?}\nwidth = 0.015\nelements = 2\n\
         [diaphragms.seal.damping]\nmass_proportional = {:?}\nstiffness_proportional = {:e}\n\
         [diaphragms.seal.contact]\nposition = {contact:?}\nrotor_radius = RADIUS\ngap = GAP\nfriction = {:?}\nfriction_law = \"{}\"\n\
         surface = \"{surface}\"\ndetection = \"{detection}\"\n",
        random.between(0.0, 1.0),
        random.between(0.05, 0.1),
        random.between(0.003, 0.006),
        random.between(20.0, 100.0),
        random.decades(1e-6, 5e-6),
        random.between(0.02, 0.25),
        random.choice(&["slip", "stick-slip"]),
    );
    text.replace("RADIUS", &format!("RADIUS_OF {radius:?}"))
}

/// Starts of a machine: initial speeds of 0.996 to 1.004 of the drawn one. This shifts the first contact by several contact steps or more. The number
/// of impacts stays the same on all of the ten machines but the first (which touches after 0.12 s, one to three times); gaps of 0.992 to 1.008 change
/// the number on four.
pub const STARTS: usize = 9;

/// Compared columns with their headings.
pub const COMPARED: [(&str, &str); 6] = [
    ("end_speed_rad_s", "end speed"),
    ("max_bearing_load_N", "bearing load"),
    ("contact_impulse_Ns", "impulse"),
    ("friction_energy_J", "friction energy"),
    ("max_filtered_contact_force_N", "1 ms force"),
    ("max_eccentricity_m", "eccentricity"),
];

/// A machine drawn at random.
pub struct Drawn {
    pub kind: &'static str,
    text: String,
    /// Gap over the eccentricity of a free run \[-\].
    share: f64,
}

/// A start of a machine.
pub struct Start<'a> {
    machine: &'a Drawn,
    /// Initial speed over the drawn one \[-\].
    speed: f64,
    /// \[m\]
    gap: f64,
    /// \[s\]
    pub first_contact: f64,
}

/// Results of a run: compared values, first contact, number of impacts and energy error.
pub struct Found {
    pub values: [f64; COMPARED.len()],
    pub first_contact: Option<f64>,
    pub impacts: f64,
    pub energy_error: f64,
    pub step: f64,
    pub outcome: Outcome,
}

/// The machines, the same in every call, with the contact detection `detection`.
pub fn machines(count: usize, detection: &str) -> Vec<Drawn> {
    let mut random = Stream(2026);
    (0..count)
        .map(|case| {
            let kind = KINDS[case % KINDS.len()];
            Drawn { kind, text: drawn(&mut random, kind, detection), share: random.between(0.5, 0.9) }
        })
        .collect()
}

impl Drawn {
    fn machine(&self, gap: f64, end: f64, engine: Engine) -> Machine {
        let (before, after) = self.text.split_once("RADIUS_OF ").expect("a radius");
        let (radius, after) = after.split_once('\n').expect("a line");
        let rotor = radius.parse::<f64>().expect("a number") - gap;
        let text = format!("{before}{rotor:?}\n{after}")
            .replace("GAP", &format!("{gap:?}"))
            .replace("END", &format!("{end:?}"));
        let mut def = MachineDef::parse("drawn.toml", &text).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        def.settle(engine);
        def.build().unwrap_or_else(|problems| panic!("{problems}"))
    }

    /// `2/omega_max` of the ring's modes, and default step of the reduced engine \[s\].
    pub fn steps(&self) -> [f64; 2] {
        let plan = |engine| {
            let machine = self.machine(0.001, 0.1, engine);
            TimeStep::new(&machine, &Structure::build(&machine, None).expect("buildable")).expect("a step")
        };
        [2.0 / plan(Engine::Exponential).highest_frequency, plan(Engine::Reduced).step]
    }

    /// Nine starts with a gap that a free run exceeds; a start without contact is left out.
    pub fn starts(&self) -> Vec<Start<'_>> {
        let free = found(&self.machine(0.04, 0.15, Engine::Exponential));
        assert_eq!(free.first_contact, None, "free");
        let gap = self.share * free.values[COMPARED.len() - 1];
        (0..STARTS)
            .filter_map(|start| {
                let speed = 1.0 + 1e-3 * (start as f64 - 0.5 * (STARTS - 1) as f64);
                let mut machine = self.machine(gap, 0.15, Engine::Exponential);
                machine.rotor.initial_speed *= speed;
                Some(Start { machine: self, speed, gap, first_contact: found(&machine).first_contact? })
            })
            .collect()
    }
}

impl Start<'_> {
    /// Runs to 15 ms after first contact, with this step \[s\] or the engine's default.
    pub fn run(&self, engine: Engine, step: Option<f64>) -> Found {
        let mut machine = self.machine.machine(self.gap, self.first_contact + 0.015, engine);
        machine.rotor.initial_speed *= self.speed;
        let key = if engine == Engine::Exponential { &mut machine.run.contact_step } else { &mut machine.run.step };
        *key = step;
        found(&machine)
    }
}

fn found(machine: &Machine) -> Found {
    let structure = Structure::build(machine, None).unwrap_or_else(|error| panic!("{error}"));
    let outcome = simulate(machine, &structure, &mut NoHistory).unwrap_or_else(|error| panic!("{error}"));
    let names = columns(machine);
    let get = |name: &str| names.iter().position(|c| c.name == name).and_then(|at| outcome.values[at]);
    let value = |name: &str| get(name).unwrap_or(f64::NAN);
    Found {
        values: COMPARED.map(|(name, _)| value(name)),
        first_contact: get("first_contact_s"),
        impacts: value("impacts"),
        energy_error: value("energy_error"),
        step: value("step_s"),
        outcome,
    }
}

/// Mean difference between runs and reference runs of the same starts, and scatter of a single difference, both relative to the mean of the reference.
pub fn difference(found: &[Found], reference: &[Found], column: usize) -> [f64; 2] {
    let count = found.len() as f64;
    let mean = reference.iter().map(|run| run.values[column]).sum::<f64>() / count;
    let each = || found.iter().zip(reference).map(|(a, b)| (a.values[column] - b.values[column]) / mean);
    let off = each().sum::<f64>() / count;
    [off, (each().map(|one| (one - off) * (one - off)).sum::<f64>() / (count - 1.0)).sqrt()]
}
