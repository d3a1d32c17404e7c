//! The solver against independent computations, with parameters of no published case. `data/outside/references.json` comes from independent
//! Python programs (see its `source`); the other references are closed forms. The models go through the machine format.

use crate::common::{Every, Row, close, drawn, machine, run, run_seen, study_machine};
use bladeoff_core::modal::{Whirl, report, whirl_modes};
use bladeoff_core::rotor::RotorMatrices;
use bladeoff_model::outcome::{EndCause, Status};
use serde_json::Value;

fn references() -> Value {
    serde_json::from_str(include_str!("../data/outside/references.json")).expect("the references are JSON")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

/// Four shaft lines drawn at random: hollow and stepped, several materials and shear coefficients, two discs on a node,
/// overhangs, bearings isotropic, orthotropic, cross-coupled, strongly damped.
#[test]
fn random_rotors_whirl_twist_and_stretch_as_computed_elsewhere() {
    for case in list(&references()["rotors"]) {
        let (name, machine) = (text(&case["name"]), drawn(text(&case["toml"])));
        let mut largest = (0.0_f64, 0.0_f64);
        for block in list(&case["whirl"]) {
            let found = whirl_modes(&machine, &[number(&block["speed"])]).expect("solvable");
            let senses = list(&block["sense"]);
            let expected = numbers(&block["frequency"]).into_iter().zip(numbers(&block["ratio"])).zip(senses);
            let ours = found[0].1.iter().filter(|mode| mode.damping_ratio < 0.9999);
            for (((frequency, ratio), sense), mode) in expected.zip(ours) {
                largest.0 = largest.0.max(close(name, mode.frequency, frequency, 1e-8));
                largest.1 = largest.1.max((mode.damping_ratio - ratio).abs());
                // the reference has the sign of the net sense, however small
                let sign = if mode.share > 0.0 { "forward" } else { "backward" };
                assert_eq!(Some(sign), sense.as_str(), "{name} at {frequency} rad/s: {}", mode.share);
                let is_clear = !matches!(mode.whirl, Whirl::Mixed | Whirl::Planar);
                assert!(!is_clear || mode.whirl.word() == sign, "{name} at {frequency} rad/s: {:?}", mode.whirl);
            }
        }
        assert!(largest.1 < 1e-8, "{name}: damping ratio {:.1e}", largest.1);
        let found = report(&machine, &[]).expect("solvable");
        let worst = |ours: &[f64], key: &str| {
            let pairs = ours.iter().zip(numbers(&case[key]));
            pairs.map(|(ours, reference)| close(key, *ours, reference, 1e-9)).fold(0.0, f64::max)
        };
        println!(
            "{name}: whirl {:.1e}, damping ratio {:.1e}, torsion {:.1e}, axial {:.1e}",
            largest.0,
            largest.1,
            worst(&found.torsion, "twist"),
            worst(&found.axial, "axial")
        );
    }
}

/// The aperiodic motions of a strong damper precess with `Im lambda` proportional to the speed: they are not critical speeds, and must not hide
/// any. Two of the four rotors have such motions.
#[test]
fn random_rotors_have_the_critical_speeds_found_by_a_fine_scan_and_no_others() {
    for case in list(&references()["rotors"]) {
        let found = report(&drawn(text(&case["toml"])), &[]).expect("solvable").critical_speeds;
        let expected = numbers(&case["critical"]);
        let ours: Vec<f64> = found.iter().map(|critical| critical.speed).collect();
        assert_eq!(ours.len(), expected.len(), "{}: {ours:?} {expected:?}", case["name"]);
        let errors =
            ours.iter().zip(&expected).map(|(ours, reference)| close("critical speed", *ours, *reference, 1e-8));
        println!("{}: {} critical speeds, {:.1e}", case["name"], ours.len(), errors.fold(0.0, f64::max));
    }
}

/// Static sag plus synchronous response to added and lost residual unbalances, with phase, at every node.
#[test]
fn random_rotors_start_from_the_sag_and_response_computed_elsewhere() {
    for case in list(&references()["rotors"]) {
        let machine = drawn(text(&case["toml"]));
        let rotor = RotorMatrices::assemble(&machine.rotor);
        let mut start = Vec::new();
        run_seen(
            machine,
            &mut Every(|frame| {
                if frame.time == 0.0 {
                    start = frame.displacement.to_vec();
                }
            }),
        );
        let expected: Vec<Vec<f64>> = list(&case["start"]).iter().map(numbers).collect();
        let size = expected.iter().flatten().fold(0.0_f64, |max, x| max.max(x.abs()));
        let mut largest = 0.0_f64;
        for (node, place) in expected.iter().enumerate() {
            for (dof, reference) in [rotor.u(node), rotor.v(node)].into_iter().zip(place) {
                largest = largest.max((start[dof] - reference).abs() / size);
            }
        }
        println!("{}: start {largest:.1e}", case["name"]);
        assert!(largest < 1e-8, "{}: {largest:e}", case["name"]);
    }
}

/// Rings on 2, 3, 5 and 7 blades against a Ritz series in harmonics, which converges as 1/N at the foot of a blade. The last change of the
/// extrapolated series is 6e-5.
#[test]
fn rings_on_blades_have_the_frequencies_of_a_ritz_series() {
    for case in list(&references()["rings"]) {
        let get = |key: &str| number(&case[key]);
        let (count, radius) = (get("count"), get("mean_radius"));
        let elements = count * (96.0 / count).round();
        let text = format!(
            "schema = 1\nname = \"ring\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\n\
             initial_speed = 1\n[rotor.bearings.b]\nstiffness = 1\n[diaphragms.d.material]\nyoung_modulus = {:e}\n\
             poisson_ratio = 0.3\ndensity = {:e}\n[diaphragms.d.ring]\nmean_radius = {radius:?}\nthickness = {:?}\n\
             width = {:?}\nelements = {elements}\n[diaphragms.d.blades]\ncount = {count}\nlength = {:?}\nthickness = {:?}\n\
             width = {:?}\nelements = 8\n[diaphragms.d.contact]\nrotor_radius = {:?}\ngap = {:?}\nfriction = 0.1\n",
            get("young_modulus"),
            get("density"),
            get("thickness"),
            get("width"),
            get("length"),
            get("blade_thickness"),
            get("blade_width"),
            0.98 * radius,
            0.02 * radius,
        );
        let found = report(&machine(&text), &[]).expect("solvable").rings.remove(0).1;
        let hertz = found.iter().map(|mode| mode.frequency / (2.0 * std::f64::consts::PI));
        let errors = hertz.zip(numbers(&case["frequency"])).map(|(ours, exact)| close("ring", ours, exact, 2e-4));
        println!("ring on {count} blades: {:.1e}", errors.fold(0.0, f64::max));
    }
}

/// Position, angle and speed at the instants of a case, with one step.
fn states(case: &Value, step: f64) -> Vec<[f64; 4]> {
    let times = numbers(&case["times"]);
    let text = text(&case["toml"]).replace("STEP", &format!("{step:?}"));
    let mut found = Vec::new();
    let row = run_seen(
        machine(&text),
        &mut Every(|frame| {
            if times.iter().any(|time| (frame.time - time).abs() < 0.25 * step) {
                found.push([frame.displacement[0], frame.displacement[1], frame.angle, frame.speed]);
            }
        }),
    );
    assert!(!text.contains("radial-spring") || row.value("contact_impulse_Ns") > 0.0, "contact happened");
    found
}

/// Point masses against Runge-Kutta of order 8, through resonance, gravity, residual, released and lost unbalances, cross-coupled bearings, speed laws
/// and rub: order 2 in the step, and the remaining error after extrapolation.
#[test]
fn point_masses_follow_an_independent_integration() {
    for case in list(&references()["points"]) {
        let steps = numbers(&case["steps"]);
        let (coarse, fine) = (states(case, steps[0]), states(case, steps[1]));
        let exact: Vec<Vec<f64>> = list(&case["state"]).iter().map(numbers).collect();
        assert_eq!((coarse.len(), fine.len()), (exact.len(), exact.len()), "every instant was met");
        let size = |k: usize| exact.iter().fold(0.0_f64, |max, state| max.max(state[k].abs()));
        let scales = [size(0).max(size(1)), size(0).max(size(1)), size(2), size(3)];
        let (mut plain, mut extrapolated) = (0.0_f64, 0.0_f64);
        for (i, state) in exact.iter().enumerate() {
            for k in 0..4 {
                plain = plain.max((fine[i][k] - state[k]).abs() / scales[k]);
                let better = fine[i][k] + (fine[i][k] - coarse[i][k]) / 3.0;
                extrapolated = extrapolated.max((better - state[k]).abs() / scales[k]);
            }
        }
        println!("{}: {plain:.1e} at {}, extrapolated {extrapolated:.1e}", case["name"], steps[1]);
        assert!(plain < 1e-3 && extrapolated < 1e-5, "{}: {plain:.2e} {extrapolated:.2e}", case["name"]);
    }
}

/// Jeffcott rotor of mass 1 on k = 1 in a radial spring with gap 1.
fn rub(zeta: f64, beta: f64, mu: f64, radius: f64, step: f64, tail: &str) -> String {
    format!(
        "schema = 1\nname = \"rub\"\n[run]\nend_time = 300\nstep = {step:?}\n[rotor.bearings.s]\nstiffness = 1\n\
         damping = {:?}\n[diaphragms.d]\nkind = \"radial-spring\"\nstiffness = {beta:?}\n[diaphragms.d.contact]\n\
         rotor_radius = {radius:?}\ngap = 1\nfriction = {mu:?}\n[rotor.speed_law]\nacceleration = 0\n\
         [rotor]\nkind = \"point-mass\"\npolar_inertia = 1\n{tail}",
        2.0 * zeta
    )
}

fn last_radius(text: &str) -> (f64, Row) {
    let mut radius = 0.0;
    let row = run_seen(machine(text), &mut Every(|frame| radius = frame.displacement[0].hypot(frame.displacement[1])));
    assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
    (radius, row)
}

#[test]
fn annular_rub_has_its_closed_form_at_other_parameters() {
    // zeta, beta, mu, e, W and the root of the closed form
    for (zeta, beta, mu, e, speed, exact) in [
        (0.05, 0.5, 0.1, 0.4, 1.05, 2.118_381_531),
        (0.2, 2.0, 0.15, 1.2, 1.3, 2.403_800_847),
        (0.15, 1.0, 0.0, 0.8, 0.9, 1.298_316_871),
    ] {
        let w2: f64 = speed * speed;
        let depth: f64 = beta * (exact - 1.0);
        let force = ((1.0 - w2) * exact + depth).hypot(2.0 * zeta * speed * exact + mu * depth);
        close("the root", force, e * w2, 1e-8);
        let radius = |step: f64| {
            let tail = format!("mass = 0\ninitial_speed = {speed:?}\n[rotor.unbalances.u]\nmass = 1\nradius = {e:?}\n");
            last_radius(&rub(zeta, beta, mu, 2.0, step, &tail)).0
        };
        let (coarse, fine) = (radius(0.02), radius(0.01));
        let error = close("annular rub", fine + (fine - coarse) / 3.0, exact, 3e-6);
        println!("annular rub zeta {zeta}, beta {beta}, mu {mu}, e {e}, W {speed}: {error:.1e}");
    }
}

#[test]
fn backward_rolling_has_its_limit_at_other_parameters() {
    // beta, R, W, mu, zeta and the root of r^2 (1 + beta (r - 1)/r) = (R W)^2
    for (beta, radius, speed, mu, zeta) in [(2.0, 8.0, 0.5, 0.3, 0.05), (10.0, 5.0, 0.3, 0.2, 0.02)] {
        let v: f64 = radius * speed;
        let exact = (beta + (beta * beta + 4.0 * (1.0 + beta) * v * v).sqrt()) / (2.0 * (1.0 + beta));
        let ratio: f64 = zeta / mu;
        let whirl = ratio + (1.0 + ratio * ratio).sqrt();
        let start = 1.03 * beta / (beta + 1.0 - whirl * whirl);
        let tail = format!(
            "mass = 1\ninitial_speed = {speed:?}\n[rotor.initial]\ndisplacement = [{start:?}, 0.0]\n\
             velocity = [0.0, {:?}]\n",
            -whirl * start
        );
        let (found, row) = last_radius(&rub(zeta, beta, mu, radius, 0.004, &tail));
        let error = close("rolling", found, exact, 1e-5);
        println!("rolling beta {beta}, V {v}: {error:.1e}");
        assert!(row.value("stick_time_s") > 100.0, "it rolls");
    }
}

/// A balanced mass point of inertia 2 without contact.
fn braked(initial_speed: f64, tail: &str) -> Row {
    run(machine(&format!(
        "schema = 1\nname = \"braked\"\n[run]\nend_time = 100\nstep = 0.01\n[rotor]\nkind = \"point-mass\"\nmass = 1\n\
         polar_inertia = 2\ninitial_speed = {initial_speed:?}\n[rotor.bearings.s]\nstiffness = 1\n{tail}"
    )))
}

#[test]
fn a_braked_rotor_stops_whatever_part_of_its_last_step_braking_takes() {
    // J W' = -(c0 + c1 W): rest at J/c1 ln(1 + c1 W0/c0); with -c0 sign(W) alone, half of these runs had no last step
    for constant in [0.5, 0.51, 0.53, 0.6, 1.0, 1.234, 2.0, 5.0, 7.3, 11.0] {
        let row = braked(10.0, &format!("[braking]\nconstant = {constant:?}\nlinear = 0.1\n"));
        assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::Stopped), "c0 {constant}");
        let exact = 20.0 * (1.0_f64 + 1.0 / constant).ln();
        // between the stop and the end of its step; the centred scheme is half a step late
        let late = row.value("stop_time_s") - exact;
        assert!((-0.005..0.02).contains(&late), "c0 {constant}: {late}");
        assert!(row.value("end_speed_rad_s").abs() < 1e-12 && row.value("energy_error") < 1e-9);
    }
    let text = study_machine("lab_rig").replace("constant = \"0.1 N m\"", "constant = \"40 N m\"");
    let row = run(machine(&text));
    assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::Stopped), "{:?}", row.outcome);
}

#[test]
fn a_rotor_at_rest_turns_only_under_more_than_c0() {
    // gravity turns an unbalance of 0.5 kg at 0.2 m with 0.5 9 0.2 = 0.9 N m initially
    let turn = |constant: f64| {
        let mut angles = Vec::new();
        let text = format!(
            "schema = 1\nname = \"rest\"\n[run]\nend_time = 0.2\nstep = 0.001\n[rotor]\nkind = \"point-mass\"\nmass = 1\n\
             polar_inertia = 2\ninitial_speed = 0\ngravity = [0.0, -9.0]\n[rotor.bearings.s]\nstiffness = 1e6\n\
             damping = 2e3\n[rotor.unbalances.u]\nmass = 0.5\nradius = 0.2\n[braking]\nconstant = {constant:?}\n"
        );
        let row = run_seen(machine(&text), &mut Every(|frame| angles.push(frame.angle)));
        assert_ne!(row.outcome.status, Status::Failed, "{:?}", row.outcome);
        angles.last().copied().expect("steps")
    };
    assert!(turn(1.0).abs() < 1e-12, "held");
    // J = 2 + 0.5 0.2^2; the deflection of the support is negligible
    let exact = -(0.9 - 0.4) / 2.02 * 0.2 * 0.2 / 2.0;
    close("angle turned", turn(0.4), exact, 0.02);
}

#[test]
fn a_shown_energy_is_that_of_its_own_step() {
    // every instant, not only those at which the run itself checks the balance
    let text = study_machine("lab_rig").replace("end_time = \"0.6 s\"", "end_time = \"0.16 s\"");
    let (mut least, mut most) = (f64::MAX, f64::MIN);
    let row = run_seen(
        machine(&text),
        &mut Every(|frame| {
            if frame.time > 0.0 {
                let all = frame.energies.stored() + frame.energies.taken();
                (least, most) = (least.min(all), most.max(all));
            }
        }),
    );
    assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
    println!(
        "energies of every step: spread {:.1e}, reported {:.1e}",
        (most - least) / most,
        row.value("energy_error")
    );
    assert!(most - least < 1e-8 * most);
}

#[test]
fn impacts_are_counted_alike_by_steps_above_and_below_a_millisecond() {
    let tail = "mass = 1\ninitial_speed = 1.4\n[rotor.unbalances.u]\nmass = 0.5\nradius = 1.5\n";
    let impacts = |step: f64| last_radius(&rub(0.05, 3.0, 0.1, 0.4, step, tail)).1.value("impacts");
    let (below, above) = (impacts(9e-4), impacts(4e-3));
    println!("impacts: {below} at 0.9 ms, {above} at 4 ms");
    assert!(above > 0.0 && (above - below).abs() < 0.5, "{below} {above}");
}

/// A spinning balanced disc pressed by its weight onto a flexible ring of three blades: its increments decay to rounding.
#[test]
fn a_rotor_that_comes_to_rest_on_the_ring_stays_there() {
    let stator = "[diaphragms.d.material]\nyoung_modulus = 7e10\npoisson_ratio = 0.3\ndensity = 2700\n\
                  [diaphragms.d.ring]\nmean_radius = 0.2\nthickness = 0.01\nwidth = 0.02\nelements = 48\n\
                  [diaphragms.d.blades]\ncount = 3\nlength = 0.1\nthickness = 0.004\nwidth = 0.02\nelements = 2\n\
                  [diaphragms.d.damping]\nmass_proportional = 200\nstiffness_proportional = 2e-6\n\
                  [diaphragms.d.contact]\nrotor_radius = 0.1945\ngap = 0.0005\nfriction = 0.1\n";
    // the bearing alone would sag by 0.575 mm, the gap is 0.5 mm; the rotor starts 0.085 mm above the gap
    let row = run(machine(&format!(
        "schema = 1\nname = \"pressed\"\n[run]\nend_time = 0.4\n[rotor]\nkind = \"point-mass\"\nmass = 5\npolar_inertia = 1\n\
         initial_speed = 50\ngravity = [11.5, 19.918584287042087]\n[rotor.initial]\n\
         displacement = [-4.25e-5, -7.361215932167728e-5]\n[rotor.bearings.b]\nstiffness = 2e5\ndamping = 900\n{stator}"
    )));
    assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::EndTime), "{:?}", row.outcome);
    assert!(row.value("contact_time_s") > 0.3, "it lies there");
    // the bearing carries the load at the deflection of the gap, the ring the rest, less the effect of the ring's deflection
    let rest = 5.0 * 23.0 - 2e5 * 5e-4;
    let held = row.value("contact_impulse_Ns") / row.value("contact_time_s");
    assert!(held > 0.2 * rest && held < rest, "{held} N of {rest} N");
}

/// An unbalance of ten, three and one times the inertia of the spin: the iterations of a step contract by `m e^2/(J + m e^2)` only. The reference times
/// of rest come from an independent integration (DOP853, 1e-11) of the three equations.
#[test]
fn an_unbalance_that_outweighs_the_spin_s_inertia_swings_as_integrated_elsewhere() {
    for (inertia, rest) in [(0.001, 0.465902195), (0.003, 1.069910321), (0.01, 2.465855037)] {
        let row = run(machine(&format!(
            "schema = 1\nname = \"light\"\n[run]\nend_time = 50\nstep = 0.001\n[rotor]\nkind = \"point-mass\"\nmass = 0\n\
             polar_inertia = {inertia:?}\ninitial_speed = 1.4\n[rotor.bearings.s]\nstiffness = 1\ndamping = 0.04\n\
             [rotor.unbalances.u]\nmass = 1\nradius = 0.1\npresent = \"before\"\n"
        )));
        assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::Stopped), "{:?}", row.outcome);
        let late = row.value("stop_time_s") - rest;
        println!("J {inertia}: at rest {late:.1e} s after the reference");
        assert!((-1e-4..0.0021).contains(&late), "{late}");
    }
}
