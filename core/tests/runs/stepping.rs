//! Acceptance and reports of single steps: rounding of stiff quasi-static motions, spin at the end, brakes and dampers that act faster than the
//! step, residual penetration.

use crate::common::{Every, Row, close, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::engine::StartError;
use bladeoff_core::engine::{TimeStep, simulate, unresolved_damping};
use bladeoff_core::record::{ContactFrame, NoHistory};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause, Status};

/// A shaft of one element with its blade at one of two bearings.
fn one_element(tail: &str) -> String {
    format!(
        "schema = 1\nname = \"one\"\n[rotor]\ninitial_speed = 300\n[rotor.material]\nyoung_modulus = 2.1e11\n\
         poisson_ratio = 0.3\ndensity = 7850\n[[rotor.shaft]]\nlength = 0.5\ndiameter = 0.03\nelements = 1\n\
         [rotor.bearings.a]\nposition = 0\nstiffness = 1e6\ndamping = 100\naxial_stiffness = 1e6\n\
         [rotor.bearings.b]\nposition = 0.5\nstiffness = 1e6\n[rotor.unbalances.u]\nposition = 0.5\nmass = 0.02\n\
         radius = 0.1\n[diaphragms.d]\nkind = \"rigid\"\n[diaphragms.d.contact]\nposition = 0.5\nrotor_radius = 0.03\n\
         gap = 2e-4\nfriction = 0.1\n[run]\nend_time = 0.05\n{tail}"
    )
}

/// A blade at a stiff bearing displaces the rotor by less than the rounding of its spin angle would at an ordinary bearing: a force of `eps m d
/// psi'/dt` against increments of `m d W^2/K W dt`. All of these runs once ended as `diverged`.
#[test]
fn a_blade_at_a_stiff_bearing_is_no_divergence() {
    let lab = |stiffness: &str, more: &[(&str, &str)]| {
        let mut changes = vec![
            ("run.engine", "full"),
            ("run.end_time", "0.02"),
            ("rotor.unbalances.blade_off.position", "1"),
            ("rotor.bearings.left.stiffness", stiffness),
            ("rotor.bearings.right.stiffness", stiffness),
        ];
        changes.extend(more);
        run(machine_with(&study_machine("lab_rig"), &changes))
    };
    let sound = |name: &str, row: &Row| {
        assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::EndTime), "{name}");
        let (rounds, peak) = (row.value("iterations") / row.value("steps"), row.value("max_bearing_load_N"));
        println!("{name}: {peak:.4} N, {rounds:.1} rounds a step, balance {:.1e}", row.value("energy_error"));
        assert!(row.value("energy_error") < 1e-10 && rounds < 20.0, "{name}");
        peak
    };
    let released = sound("lab rig, 5e7 N/m", &lab("5e7", &[]));
    // with a sixth of the step, the run did not diverge
    let finer = sound("lab rig, 5e7 N/m, 0.1 us", &lab("5e7", &[("run.step", "1e-7")]));
    close("bearing load", released, finer, 1e-4);
    let steady = sound("lab rig, 1e8 N/m, steady", &lab("1e8", &[("rotor.unbalances.blade_off.present", "before")]));
    // m d W^2 of 10 g at 40 mm and 3000 rpm, without the force of the shaft's own mass
    close("steady bearing load", steady, 0.01 * 0.04 * 314.159_265_f64.powi(2), 2e-3);
    let damped = [("rotor.bearings.right.damping", "1e5"), ("run.step", "1e-7")];
    sound("lab rig, damped, 0.1 us", &lab("2e6", &damped));
    for stiffness in ["3e9", "1e10", "1e12"] {
        let changes = [("rotor.bearings.a.stiffness", stiffness), ("rotor.bearings.b.stiffness", stiffness)];
        let row = run(machine_with(&one_element(""), &changes));
        let load = sound(&format!("one element, {stiffness} N/m"), &row);
        // released suddenly: up to twice m d W^2
        assert!((180.0..365.0).contains(&load), "{load}");
    }
    let changes = [
        ("run.engine", "full"),
        ("run.end_time", "2e-3"),
        ("rotor.unbalances.blade_off.position", "6.55"),
        ("rotor.bearings.front.stiffness", "1e12"),
        ("rotor.bearings.rear.stiffness", "1e12"),
    ];
    sound("turbine, 1e12 N/m", &run(machine_with(&study_machine("lp_turbine_paper"), &changes)));
}

/// The iterations of a step hardly converge if an unbalance has almost all of the mass and inertia: the residual is not rounding, so there is no
/// result.
#[test]
fn rounds_that_do_not_contract_are_not_accepted() {
    let row = run(machine(
        "schema = 1\nname = \"heavy\"\n[run]\nend_time = 1\nstep = 1e-3\n[rotor]\nkind = \"point-mass\"\nmass = 1e-3\n\
         polar_inertia = 1e-7\ninitial_speed = 10\n[rotor.bearings.s]\nstiffness = 1\n[rotor.unbalances.u]\n\
         mass = 5\nradius = 0.04\n",
    ));
    println!("{:?} {:?}", row.outcome.cause, row.outcome.end_cause);
    assert_eq!(row.outcome.status, Status::Failed);
    assert_eq!(row.outcome.cause, Some(Cause::Diverged));
}

/// A rotor that crosses its ring within a step ends the run, and one that hangs outside does not start. Both were once `ok` without contact.
#[test]
fn a_rotor_that_leaves_its_ring_ends_there() {
    /// Inner radius of the rig's undeformed ring \[m\].
    const RADIUS: f64 = 50.5e-3;
    let rig = study_machine("lab_rig");
    for (detection, diaphragm, engine, velocity) in [
        // crosses the ring within a step
        ("hyp2", "flexible", "reduced", "3e5"),
        ("hyp2-frozen", "flexible", "reduced", "3e5"),
        ("hyp2", "rigid", "reduced", "3e5"),
        ("hyp1", "flexible", "full", "1e5"),
        // pushes the ring outwards, which was once followed to ten times its radius
        ("hyp1", "flexible", "reduced", "1e4"),
        ("hyp1", "flexible", "full", "1e4"),
        ("hyp2", "flexible", "full", "1e4"),
        ("hyp2-frozen", "flexible", "reduced", "1e4"),
        ("hyp2-frozen", "flexible", "full", "2e3"),
    ] {
        let (from, to) = (rig.find("[diaphragms.seal.material]"), rig.find("[diaphragms.seal.contact]"));
        let mut text = rig.clone();
        if diaphragm == "rigid" {
            text.replace_range(from.expect("a ring")..to.expect("a contact"), "kind = \"rigid\"\n");
        }
        let changes = [
            ("contact.detection", detection),
            ("rotor.initial.velocity[0]", velocity),
            ("run.step", "1e-6"),
            ("run.engine", engine),
            ("run.end_beyond", "off"),
        ];
        let row = run(machine_with(&text, &changes));
        assert_eq!(
            row.outcome.cause,
            Some(Cause::OutsideRing),
            "{detection} {diaphragm} {engine} {velocity}: {:?}",
            row.outcome
        );
        assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Failed, EndCause::Failure));
        assert_eq!(Cause::OutsideRing.word(), "outside_ring");
        let eccentricity = row.value("max_eccentricity_m");
        println!("{detection} {diaphragm} {engine} {velocity}: {:e} s, {eccentricity} m", row.value("end_time_s"));
        assert!(row.value("end_time_s") > 0.0);
        assert!(eccentricity < RADIUS, "no instant beyond the undeformed ring is in the row: {eccentricity}");
    }
    // a spring deflects as far as it is pressed, so the rotor stays in contact
    let pressed = |kind: &str, tail: &str| {
        format!(
            "schema = 1\nname = \"p\"\n[run]\nend_time = 10\nstep = 1e-3\n[rotor.bearings.s]\nstiffness = 1.0\n\
             [diaphragms.d]\nkind = {kind}\n[diaphragms.d.contact]\nrotor_radius = 1.0\ngap = 0.5\nfriction = 0.0\ndetection = \"hyp1\"\n\
             [rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\ninitial_speed = 1\n{tail}"
        )
    };
    let row = run(machine(&pressed("\"radial-spring\"\nstiffness = 4.0", "[rotor.initial]\nvelocity = [4.0, 0.0]\n")));
    assert!(row.value("contact_time_s") > 0.1 && row.value("max_eccentricity_m") > 1.5, "{:?}", row.outcome);
    assert_ne!(row.outcome.cause, Some(Cause::OutsideRing));
    // the sag is not a number of the file: only the start of the run can detect it
    let heavy = machine(&pressed("\"rigid\"", "gravity = [0.0, -3.0]\n"));
    let structure = Structure::build(&heavy, None).expect("buildable");
    let refused = simulate(&heavy, &structure, &mut NoHistory).expect_err("it hangs outside");
    assert!(refused.to_string().contains("starts outside diaphragm d: its centre is 3 m"), "{refused}");
}

fn point_mass(run: &str, tail: &str) -> String {
    format!(
        "schema = 1\nname = \"pm\"\n[run]\n{run}\n[rotor]\nkind = \"point-mass\"\nmass = 10\npolar_inertia = 0.5\n\
         initial_speed = 200\n[rotor.bearings.b]\nstiffness = 1e6\ndamping = 10\n{tail}"
    )
}

/// A machine whose whole mass is an unbalance of 1 kg at 0.5 m, J = 0.05: the effective mass is `m J/(J + m d^2) = m/6` across the arm, m along it.
fn all_on_an_arm(speed: f64, settings: &str, tail: &str) -> Machine {
    machine(&format!(
        "schema = 1\nname = \"arm\"\n[run]\nend_time = 40\n{settings}\n[rotor]\nkind = \"point-mass\"\nmass = 0\npolar_inertia = 0.05\n\
         initial_speed = {speed:?}\n[rotor.bearings.b]\nstiffness = 1\n[rotor.unbalances.u]\nmass = 1\nradius = 0.5\n{tail}"
    ))
}

fn plan(machine: &Machine) -> Result<TimeStep, StartError> {
    TimeStep::new(machine, &Structure::build(machine, None).expect("buildable"))
}

/// The limit is `2/sqrt(6 k/m)` = 0.816 s. It was once 2 s: a run with 0.83 s was `ok`, stopped without a brake, at 2.6 times the load.
#[test]
fn a_step_that_a_point_on_its_arm_does_not_bear_is_refused() {
    let of = |step: &str, tail: &str| plan(&all_on_an_arm(0.3, &format!("step = {step}"), tail));
    let Err(StartError::StepTooLarge { limit, .. }) = of("0.83", "") else { panic!("{:?}", of("0.83", "")) };
    close("limit", limit, 2.0 / 6.0_f64.sqrt(), 1e-9);
    assert!(of("0.81", "").is_ok());
    // at some time the arm is perpendicular to the stiffer axis, whatever its phase
    for axes in [[0.1, 1.0], [1.0, 0.1]] {
        let mut machine = all_on_an_arm(0.3, "step = 0.81", "");
        machine.rotor.bearings[0].stiffness = [[axes[0], 0.0], [0.0, axes[1]]];
        close("limit", plan(&machine).expect("stable").largest_step, 2.0 / 6.0_f64.sqrt(), 1e-9);
    }
    // the torque of the unbalance does not change a prescribed spin: the effective mass is the whole mass
    let driven = of("0.83", "[rotor.speed_law]\nacceleration = 0\n").expect("stable");
    close("limit of a prescribed speed", driven.largest_step, 2.0, 1e-9);
}

/// Released 0.1 m across its arm, the mass oscillates with 0.1 N at most. The default step was once 1 s: `diverged`, or `ok` with 0.167 N.
#[test]
fn a_point_on_its_arm_at_rest_is_resolved() {
    for speed in [0.0, 1e-3] {
        let machine = all_on_an_arm(speed, "", "[rotor.initial]\ndisplacement = [0.0, 0.1]\n");
        let step = plan(&machine).expect("stable").step;
        let row = run(machine);
        println!("{speed} rad/s: step {step} s, {:.6} N", row.value("max_bearing_load_N"));
        assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes.words());
        close("load", row.value("max_bearing_load_N"), 0.1, 1e-3);
    }
}

/// A run that its step limit ends has no more steps than the limit, however late its end time is.
#[test]
fn a_step_limit_counts_where_steps_are_too_many() {
    let of = |limit: &str| machine(&point_mass(&format!("end_time = 1e6\nstep = 1e-5\n{limit}"), ""));
    let Err(StartError::TooManySteps { steps, .. }) = plan(&of("")) else { panic!("{:?}", plan(&of(""))) };
    close("steps", steps, 1e11, 1e-9);
    assert!(matches!(plan(&of("step_limit = 20000000000")), Err(StartError::TooManySteps { .. })));
    let row = run(of("step_limit = 1000"));
    assert_eq!((row.value("steps"), row.outcome.cause), (1000.0, Some(Cause::StepLimit)));
}

/// A run of up to eight steps has a second energy balance at its last step. Without it, the error was 0 in every case and the guard had no effect.
#[test]
fn a_run_of_few_steps_has_an_energy_guard() {
    for steps in [2, 5, 8, 9] {
        let settings = format!("end_time = {}\nstep = 1e-3\nguard.energy_balance = 1e-30", 1e-3 * f64::from(steps));
        let unbalance = "[rotor.unbalances.u]\nmass = 0.5\nradius = 0.1\n";
        let mut seen = Vec::new();
        let row = run_seen(
            machine(&point_mass(&settings, unbalance)),
            &mut Every(|frame| seen.push((frame.energies.stored(), frame.energies.taken()))),
        );
        assert_eq!(row.value("steps"), f64::from(steps));
        let (first, last) = (seen[0], seen[steps as usize - 1]);
        let error = (last.0 + last.1 - (first.0 + first.1)).abs() / first.0.abs().max(last.0.abs());
        println!("{steps} steps: energy error {:.2e}", row.value("energy_error"));
        assert!((row.value("energy_error") - error).abs() <= 1e-12 * error && error > 0.0, "{error}");
        assert_eq!((row.outcome.status, row.outcome.cause), (Status::Invalid, Some(Cause::EnergyBalance)));
    }
}

/// `end_speed_rad_s` against closed forms: exact for constant accelerations, order 2 otherwise. The value was once the spin half a step earlier, of
/// order 1.
#[test]
fn the_spin_at_the_end_is_of_second_order() {
    let end = |step: f64, tail: &str| {
        let row = run(machine(&point_mass(&format!("end_time = 1\nstep = {step:?}"), tail)));
        assert_eq!(row.outcome.end_cause, EndCause::EndTime, "{:?}", row.outcome);
        (row.value("end_time_s"), row.value("end_speed_rad_s"))
    };
    let error = |step: f64, tail: &str, exact: &dyn Fn(f64) -> f64| {
        let (time, speed) = end(step, tail);
        (speed - exact(time)).abs()
    };
    let law = "[rotor.speed_law]\nacceleration = 1e4\n";
    assert!(error(1e-3, law, &|t| 200.0 + 1e4 * t) < 1e-9);
    // beyond the last corner of a speed law the value of the law, not an extrapolation across the corner
    let corner = "[rotor.speed_law]\ntimes = [0, 0.9995]\nspeeds = [200, 300]\n";
    assert!(error(1e-3, corner, &|_| 300.0) < 1e-9);
    let constant = "[braking]\nconstant = 50\n";
    assert!(error(1e-3, constant, &|t| 200.0 - 100.0 * t) < 1e-9);
    let linear = "[braking]\nlinear = 0.5\n";
    let quadratic = "[braking]\nquadratic = 0.01\n";
    let laws: [(&str, &dyn Fn(f64) -> f64); 2] =
        [(linear, &|t: f64| 200.0 * (-t).exp()), (quadratic, &|t: f64| 200.0 / (1.0 + 200.0 * 0.02 * t))];
    for (tail, exact) in laws {
        let (coarse, fine) = (error(4e-3, tail, exact), error(2e-3, tail, exact));
        let order = (coarse / fine).log2();
        println!("{tail:?}: {fine:.1e} rad/s at 2 ms, order {order:.3}");
        assert!((order - 2.0).abs() < 0.05, "{order}");
    }
}

/// The run ends with the first step whose end is at or below `run.end_speed`, and the row has the speed at that end.
#[test]
fn a_run_ends_in_the_step_that_reaches_its_end_speed() {
    // 200 - 100 t: 150 rad/s at 0.5 s, the end of a step; 149.95 rad/s half a step later
    for (wanted, time) in [(150.02, 0.5), (149.95, 0.501)] {
        let settings = format!("end_time = 1\nend_speed = {wanted:?}\nstep = 1e-3");
        let row = run(machine(&point_mass(&settings, "[braking]\nconstant = 50\n")));
        assert_eq!(row.outcome.end_cause, EndCause::EndSpeed);
        assert!((row.value("end_time_s") - time).abs() < 1e-9, "{}", row.value("end_time_s"));
        assert!((row.value("end_speed_rad_s") - (200.0 - 100.0 * time)).abs() < 1e-9);
    }
}

/// Brakes with a time constant far below the step: the centred scheme alone would reverse the rotor, or grow without bound.
#[test]
fn brakes_that_stop_a_rotor_within_a_step_stop_it() {
    let laws = ["linear = 1e2", "linear = 1e3", "linear = 1e6", "quadratic = 1e9", "constant = 1e7", "constant = 1e9"];
    for law in laws {
        let mut taken = 0.0;
        let text = one_element(&format!("[braking]\n{law}\n"));
        let row = run_seen(machine(&text), &mut Every(|frame| taken = frame.energies.braking));
        assert_eq!(
            (row.outcome.status, row.outcome.end_cause),
            (Status::Ok, EndCause::Stopped),
            "{law}: {:?}",
            row.outcome
        );
        println!("{law}: stops at {:e} s, brake took {taken:.2} J", row.value("stop_time_s"));
        assert!(row.value("steps") < 40.0 && row.value("end_speed_rad_s").abs() < f64::MIN_POSITIVE, "{law}");
        assert!(row.value("friction_energy_J") >= 0.0 && row.value("energy_error") < 1e-9 && taken > 0.0, "{law}");
    }
}

/// A brake almost as fast as the step: in the centred scheme, `J W' = -c W` multiplies the spin by `(1 - x)/(1 + x)` per step, `x = c dt/(2 J)`. The
/// iterations of a step contracted by x only.
#[test]
fn a_brake_nearly_as_fast_as_the_step_slows_as_the_scheme_says() {
    let (step, inertia) = (1e-3, 0.5);
    for x in [0.5, 0.9, 0.99] {
        let mut speeds = Vec::new();
        let tail = format!("[braking]\nlinear = {:?}\n", x * 2.0 * inertia / step);
        let text = point_mass("end_time = 4e-3\nstep = 1e-3", &tail);
        let row = run_seen(machine(&text), &mut Every(|frame| speeds.push(frame.speed)));
        assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::EndTime), "{:?}", row.outcome);
        close("first speed", speeds[0], 200.0, 1e-11);
        for pair in speeds.windows(2) {
            close("ratio of speeds", pair[1] / pair[0], (1.0 - x) / (1.0 + x), 1e-9);
        }
        println!("x {x}: {} rounds in {} steps", row.value("iterations"), row.value("steps"));
    }
}

/// One mass: x = c dt/(2 m), exactly, and the largest value of several bearings.
#[test]
fn damping_beyond_the_step_is_told() {
    let told = |text: &str, changes: &[(&str, &str)]| {
        let machine = machine_with(text, changes);
        let structure = Structure::build(&machine, None).expect("built");
        let plan = TimeStep::new(&machine, &structure).expect("planned");
        unresolved_damping(&machine, &structure, plan.step)
    };
    let text = point_mass("end_time = 1\nstep = 1e-3", "");
    assert_eq!(told(&text, &[("rotor.bearings.b.damping", "1.99e4")]), []);
    let found = told(&text, &[("rotor.bearings.b.damping", "5e4")]).pop().expect("x = 2.5");
    close("ratio", found.ratio, 2.5, 1e-12);
    close("step", found.step, 4e-4, 1e-12);
    // the lab rig with its blade at a damper that clamps the shaft almost rigidly: 39.4 N with every step that resolves the damper
    let lab = study_machine("lab_rig");
    for engine in ["full", "reduced"] {
        let changes = |step| {
            [
                ("run.engine", engine),
                ("run.end_time", "0.02"),
                ("run.step", step),
                ("rotor.unbalances.blade_off.position", "1"),
                ("rotor.bearings.right.damping", "1e6"),
            ]
        };
        let load = |step| run(machine_with(&lab, &changes(step))).value("max_bearing_load_N");
        let found = told(&lab, &changes("6e-7")).pop().expect("the default damping is 600 N s/m");
        assert_eq!(found.bearing, "right");
        let fitting = format!("{:e}", found.step);
        let [coarse, fine] = ["6e-7", &fitting].map(load);
        println!("{engine}: x {:.2} and {coarse:.2} N at 0.6 us, {fine:.2} N at {fitting} s", found.ratio);
        assert!(coarse > 50.0);
        close("largest bearing load", fine, 39.45, 2e-3);
        assert_eq!(told(&lab, &changes("1e-7")), []);
    }
}

/// The row and the history agree on the largest penetration and its time.
#[test]
fn the_row_and_the_history_tell_the_same_penetration() {
    for (engine, detection) in [("reduced", "hyp2"), ("full", "hyp2"), ("reduced", "hyp1"), ("reduced", "hyp2-frozen")]
    {
        // released at this speed, the rotor touches after 47 ms
        let changes = [
            ("run.engine", engine),
            ("run.end_time", "0.07"),
            ("rotor.initial_speed", "300"),
            ("contact.detection", detection),
        ];
        let (mut deepest, mut at) = (0.0_f64, 0.0);
        let row = run_seen(
            machine_with(&study_machine("lab_rig"), &changes),
            &mut Every(|frame| {
                let [ContactFrame { gap, .. }] = *frame.contacts else { unreachable!("a diaphragm") };
                if -gap > deepest {
                    (deepest, at) = (-gap, frame.time);
                }
            }),
        );
        let said = row.value("residual_penetration_m");
        println!(
            "{engine} {detection}: row {said:e} at {:e}, history {deepest:e} at {at:e}",
            row.value("residual_penetration_at_s")
        );
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        assert!((said - deepest).abs() < 1e-15, "{said:e} {deepest:e}");
        // the frozen contact place leaves more penetration than rounding
        assert!(detection != "hyp2-frozen" || deepest > 1e-10, "{deepest:e}");
        // a penetration of rounding size occurs at an arbitrary instant
        assert!(deepest < 1e-15 || (row.value("residual_penetration_at_s") - at).abs() < 1e-12);
    }
}
