//! Machine files with torques and a braking table: their equilibrium at the start.

use crate::common::{build, parse, set, shipped};
use bladeoff_model::machine::{MachineDef, RotorKind};

/// The lab rig with a braking table, a torque with a jump, and one that balances and has a short circuit.
fn with_torques() -> String {
    shipped("lab_rig").replacen(
        "[braking]\nconstant = \"0.1 N m\"\nlinear = \"2e-3 N m s\"\nquadratic = \"1e-5 N m s2\"",
        "[braking]\nspeeds = [0, \"1500 rpm\", \"6000 rpm\"]\ntorques = [\"0.2 N m\", \"1 N m\", \"4 N m\"]\n\
         [torques.steam]\nposition = 0.3\ntimes = [\"0.1 s\", \"0.1 s\", \"0.2 s\"]\nvalues = [\"20 N m\", \"10 N m\", 0]\n\
         [torques.generator]\nposition = 0.9\nbalance = true\ntimes = [\"0 s\", \"0.2 s\"]\nfactors = [1, 0]\n\
         [torques.generator.short_circuit]\nstart = \"50 ms\"\nfrequency = \"3000 rpm\"\namplitude = \"-60 N m\"\ndecay = \"0.1 s\"\n\
         double_amplitude = \"30 N m\"",
        1,
    )
}

#[test]
fn torques_are_in_equilibrium_at_the_start() {
    let mut def = parse(&with_torques());
    let machine = def.build().unwrap();
    assert_eq!(
        machine.braking.table,
        [[0.0, 0.2], [50.0 * std::f64::consts::PI, 1.0], [200.0 * std::f64::consts::PI, 4.0]]
    );
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { panic!() };
    let [steam, generator] = &machine.torques[..] else { panic!("{:?}", machine.torques) };
    assert_eq!((shaft.nodes[steam.node], shaft.nodes[generator.node]), (0.3, 0.9));
    assert_eq!(steam.before(), 20.0);
    assert!((steam.at(0.15) - 5.0).abs() < 1e-12, "{}", steam.at(0.15));
    // 3000 rpm is a third of the way from 1500 to 6000 rpm: the brake torque is 2 N m
    assert!((generator.before() + 18.0).abs() < 1e-12, "{}", generator.before());
    assert_eq!(generator.times, [0.0, 0.2]);
    let fault = generator.short_circuit.unwrap();
    assert_eq!((fault.start, fault.amplitudes, fault.decays), (0.05, [-60.0, 30.0], [0.1, 0.1]));
    assert!((fault.frequency - 100.0 * std::f64::consts::PI).abs() < 1e-12);
    let identity = def.identity(0);
    set(&mut def, "torques.steam.values[0]", "30 N m");
    assert_ne!(def.identity(0), identity);
    assert!((def.build().unwrap().torques[1].before() + 28.0).abs() < 1e-12);
    set(&mut def, "generator.short_circuit.amplitude", "-70 N m");
    set(&mut def, "generator.balance", "false");
    assert!(def.build().unwrap_err().to_string().contains("factors of nothing"));
    // a drive compensates the remainder of all torques
    let driven = shipped("lab_rig").replacen(
        "[braking]",
        "[rotor.speed_law]\nacceleration = 1\n[torques.a]\nposition = 0.5\ntimes = [0]\nvalues = [5]\n[braking]",
        1,
    );
    assert_eq!(build(&driven).torques[0].before(), 5.0);
}

#[test]
fn the_written_record_of_torques_builds_the_same_machine() {
    let def = parse(&with_torques());
    let record = def.to_toml();
    let again = MachineDef::parse("record", &record).unwrap_or_else(|problems| panic!("{problems}\n{record}"));
    assert_eq!(again.build().unwrap(), def.build().unwrap(), "{record}");
    assert_eq!(again.to_toml(), record);
}

/// A mass point has no torsion, so no torsional effect is neglected.
#[test]
fn torques_on_a_mass_point_need_no_other_engine() {
    let point = "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\ninitial_speed = 100\n\
        [rotor.bearings.a]\nstiffness = 4e4\n[torques.fan]\nbalance = true\n[torques.motor]\ntimes = [0.1, 0.1]\nvalues = [1, 3]\n";
    let def = parse(point);
    let machine = def.build().unwrap();
    let engine = |machine: &bladeoff_model::machine::Machine| machine.run.engine.word();
    let spin = |def: &MachineDef, machine| {
        let lines = def.assumptions(machine);
        lines.iter().find(|line| line.topic == "spin").map(|line| line.text.clone()).unwrap()
    };
    assert_eq!(engine(&machine), "exponential");
    let said = spin(&def, &machine);
    assert!(said.contains("(fan -1 N m; motor 1 N m to 3 N m)") && !said.contains("torsion"), "{said}");
    let (def, shaft) = (parse(&with_torques()), build(&with_torques()));
    assert_eq!(engine(&shaft), "reduced");
    let said = spin(&def, &shaft);
    let amounts =
        "steam 20 N m to 0 N m; generator -18 N m to 0 N m, short circuit of 50 Hz from 50 ms with up to 90 N m";
    assert!(said.contains(amounts) && said.ends_with("static torsion"), "{said}");
}
