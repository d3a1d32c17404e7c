//! Unbalances released during a run: at a time, at a speed, several, none.

use crate::common::{Every, Row, close, machine, run, run_seen, study_machine};
use bladeoff_core::record::{Frame, columns};
use bladeoff_model::machine::Machine;
use nalgebra::Complex;

/// Shaft of 1 m with two discs and gravity, without diaphragm.
fn shaft(engine: &str, end_time: f64, tail: &str) -> Machine {
    stepped(engine, end_time, "", tail)
}

/// Shaft of [`shaft`] with one more line of `[run]`.
fn stepped(engine: &str, end_time: f64, step: &str, tail: &str) -> Machine {
    machine(&format!(
        "schema = 1\nname = \"release\"\n[run]\nengine = \"{engine}\"\nend_time = {end_time:?}\n{}[rotor]\ninitial_speed = 300\n\
         gravity = [0.0, -9.81]\n[rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 4\ndiameter = 0.04\n\
         [rotor.discs.middle]\nposition = 0.5\nmass = 10\ntransverse_inertia = 0.03\npolar_inertia = 0.06\n\
         [rotor.discs.right]\nposition = 0.75\nmass = 4\ntransverse_inertia = 0.01\npolar_inertia = 0.02\n\
         [rotor.bearings.left]\nposition = 0.0\nstiffness = 2e7\ndamping = 3e3\naxial_stiffness = 1e6\n\
         [rotor.bearings.right]\nposition = 1.0\nstiffness = 2e7\ndamping = 3e3\n\
         [rotor.damping]\nmass_proportional = 5\nstiffness_proportional = 2e-5\n\
         [braking]\nconstant = 1\nlinear = 0.01\n{tail}",
        if step.is_empty() { String::new() } else { format!("{step}\n") }
    ))
}

fn blade(name: &str, release: &str) -> String {
    format!(
        "[rotor.unbalances.{name}]\ndisc = \"middle\"\nmass = 0.05\nradius = 0.12\nphase = 0.4\nkind = \"lost\"\n{release}\n"
    )
}

/// Largest difference of the columns that both rows have, relative to the larger value; without times of peaks and numerics.
fn difference(one: &Row, other: &Row) -> f64 {
    let names = columns(&one.machine).into_iter().filter(|column| {
        column.name.starts_with("max_") && !column.name.ends_with("_at_s") && !column.name.ends_with("_at_rad_s")
            || column.name.starts_with("end_speed")
    });
    let change = |name: String| match (one.get(&name), other.get(&name)) {
        (Some(a), Some(b)) if a != b => (a - b).abs() / a.abs().max(b.abs()),
        (Some(_), Some(_)) | (None, None) => 0.0,
        _ => f64::INFINITY,
    };
    names.map(|column| change(column.name)).fold(0.0, f64::max)
}

/// Last shown instant of a run, and displacement of the first node then.
fn end_place(machine: Machine) -> (f64, Complex<f64>) {
    let mut last = (0.0, Complex::new(0.0, 0.0));
    run_seen(
        machine,
        &mut Every(|frame: &Frame<'_>| {
            last = (frame.time, Complex::new(frame.displacement[0], frame.displacement[1]));
        }),
    );
    last
}

/// Jeffcott rotor at a constant speed whose unbalance is switched on at t0, from rest:
/// `z = X (e^{iWt} - A e^{s1 (t - t0)} - B e^{s2 (t - t0)})`, with z = z' = 0 at t0.
#[test]
fn a_jeffcott_rotor_answers_with_the_known_transient_of_second_order() {
    let (mass, piece, d, k, c, speed, t0, end) = (1.9, 0.1, 0.02, 2.0, 0.06, 1.3, 2.0 / 3.0 + 0.01234, 12.0);
    let i = Complex::new(0.0, 1.0);
    let all = mass + piece;
    let x = piece * d * speed * speed / (Complex::new(k - all * speed * speed, 0.0) + i * c * speed);
    let root = i * f64::sqrt(4.0 * all * k - c * c);
    let [s1, s2]: [Complex<f64>; 2] = [(root - c) / (2.0 * all), (-root - c) / (2.0 * all)];
    let (z0, v0) = (x * (i * speed * t0).exp(), i * speed * x * (i * speed * t0).exp());
    let (a, b) = ((v0 - s2 * z0) / (s1 - s2), (s1 * z0 - v0) / (s1 - s2));
    let exact = |time: f64| x * (i * speed * time).exp() - a * (s1 * (time - t0)).exp() - b * (s2 * (time - t0)).exp();
    for (engine, key, step) in
        [("reduced", "step", 0.02), ("exponential", "contact_step", 0.02), ("full", "step", 0.02)]
    {
        let error = |step: f64| {
            let text = format!(
                "schema = 1\nname = \"jeffcott\"\n[run]\nengine = \"{engine}\"\n{key} = {step:?}\nend_time = {end:?}\n[rotor]\nkind = \"point-mass\"\n\
                 mass = {mass:?}\npolar_inertia = 5.0\ninitial_speed = {speed:?}\n[rotor.speed_law]\nacceleration = 0.0\n\
                 [rotor.bearings.spring]\nstiffness = {k:?}\ndamping = {c:?}\n\
                 [rotor.unbalances.blade]\nmass = {piece:?}\nradius = {d:?}\nrelease_time = {t0:?}\n"
            );
            let (time, place) = end_place(machine(&text));
            (place - exact(time)).norm() / x.norm()
        };
        let (coarse, fine) = (error(step), error(0.5 * step));
        println!("{engine}: {coarse:e} {fine:e}");
        assert!(fine < 2e-4, "{engine}: {coarse:e} {fine:e}");
        // the error of exponential is that of its interpolated modal basis, 4e-7 at any step
        assert!(fine < 1e-6 || fine < coarse / 3.0, "{engine}: second order: {coarse:e} {fine:e}");
    }
}

#[test]
fn a_release_at_the_start_is_an_unbalance_from_the_start() {
    for engine in ["reduced", "exponential"] {
        let plain = run(shaft(engine, 0.2, &blade("one", "")));
        for at_once in ["release_time = 0", "release_speed = 300"] {
            let released = run(shaft(engine, 0.2, &blade("one", at_once)));
            assert_eq!(released.value("release_one_at_s"), 0.0);
            assert_eq!(released.value("released_energy_J"), 0.0);
            assert_eq!(released.outcome.values[..20], plain.outcome.values[..20], "{engine}");
            assert_eq!(difference(&plain, &released), 0.0, "{engine} {at_once}");
        }
    }
    // the difference decreases with the square of the step
    for (engine, key) in [("reduced", "step"), ("exponential", "contact_step")] {
        let change = |step: f64| {
            let of = |release: &str| run(stepped(engine, 0.1, &format!("{key} = {step:?}"), &blade("one", release)));
            difference(&of(""), &of("release_time = \"10 ns\""))
        };
        let (coarse, fine) = (change(2e-5), change(1e-5));
        println!("{engine}: {coarse:e} {fine:e}");
        assert!(fine > 0.0 && fine < 0.4 * coarse && coarse < 1e-4, "{engine}: {coarse:e} {fine:e}");
    }
}

#[test]
fn all_engines_agree_on_a_lost_blade_in_a_coast_down() {
    let tail = blade("one", "release_time = \"50.0123 ms\"");
    let rows: Vec<Row> =
        ["reduced", "full", "exponential"].into_iter().map(|engine| run(shaft(engine, 0.4, &tail))).collect();
    for row in &rows {
        close("time", row.value("release_one_at_s"), 0.050_012_3, 1e-12);
        assert!(row.value("energy_error") < 1e-6, "{}", row.value("energy_error"));
        for column in ["max_bearing_load_N", "released_energy_J", "release_one_at_rad_s", "end_speed_rad_s"] {
            close(column, row.value(column), rows[1].value(column), 2e-3);
        }
    }
}

#[test]
fn the_energy_closes_only_with_that_of_the_piece() {
    for engine in ["reduced", "exponential"] {
        let mut errors = [0.0_f64; 2];
        let (mut first, mut largest) = (None, 0.0_f64);
        let tail = blade("one", "release_time = \"0.1 s\"");
        run_seen(
            shaft(engine, 0.3, &tail),
            &mut Every(|frame: &Frame<'_>| {
                let of = frame.energies;
                let total = of.stored() + of.taken();
                let first: [f64; 2] = *first.get_or_insert([total; 2]);
                largest = largest.max(of.stored().abs());
                for (error, total) in errors.iter_mut().zip([total, total + of.released]) {
                    *error = error.max((total - first[0]).abs());
                }
            }),
        );
        let [with, without] = errors.map(|error| error / largest);
        assert!(with < 1e-5 && without > 1e-3, "{engine}: {with:e} {without:e}");
    }
}

#[test]
fn a_release_at_a_speed_is_one_at_the_time_of_that_speed() {
    for engine in ["reduced", "exponential"] {
        let at_speed = run(shaft(engine, 0.5, &blade("one", "release_speed = 297")));
        let time = at_speed.value("release_one_at_s");
        assert!((0.05..0.45).contains(&time), "{time}");
        close("speed", at_speed.value("release_one_at_rad_s"), 297.0, 1e-12);
        let at_time = run(shaft(engine, 0.5, &blade("one", &format!("release_time = {time:?}"))));
        assert!(difference(&at_speed, &at_time) < 1e-8, "{engine}: {:e}", difference(&at_speed, &at_time));
        close("speed", at_time.value("release_one_at_rad_s"), 297.0, 1e-9);
    }
}

/// A prescribed speed passes the speed of the release while it rises.
#[test]
fn overspeed_releases_a_blade() {
    for engine in ["reduced", "exponential"] {
        let tail = format!("{}[rotor.speed_law]\nacceleration = 100\n", blade("one", "release_speed = \"310 rad/s\""));
        let row = run(shaft(engine, 0.3, &tail));
        close("time", row.value("release_one_at_s"), 0.1, 1e-9);
        assert!(row.value("energy_error") < 1e-5, "{engine}: {}", row.value("energy_error"));
    }
}

#[test]
fn a_release_that_never_happens_is_a_result() {
    for engine in ["reduced", "exponential"] {
        let none = run(shaft(engine, 0.2, ""));
        for never in ["release_speed = 310", "release_time = 1", "release_speed = 100"] {
            let row = run(shaft(engine, 0.2, &blade("one", never)));
            assert_eq!(row.get("release_one_at_s"), None);
            assert_eq!(row.get("release_one_at_rad_s"), None);
            assert_eq!(row.outcome.status, none.outcome.status);
            assert_eq!(difference(&none, &row), 0.0, "{engine}: {never}");
        }
    }
}

/// Two masses lost in the same step, the later one first in the file, and one lost at the start.
#[test]
fn several_losses_happen_in_their_order() {
    let times = [0.100_003, 0.100_001];
    let tail = |first: &str| {
        let released = |name: &str, time: f64| blade(name, &format!("release_time = {time:?}"));
        let residual = blade("c", "").replace("kind = \"lost\"", "present = \"before\"").replace("0.05", "0.01");
        format!("{}{}{residual}", released(first, times[0]), released("b", times[1]))
    };
    for engine in ["reduced", "exponential"] {
        let row = run(shaft(engine, 0.3, &tail("a")));
        close("a", row.value("release_a_at_s"), times[0], 1e-12);
        close("b", row.value("release_b_at_s"), times[1], 1e-12);
        assert!(row.value("energy_error") < 1e-5, "{engine}: {}", row.value("energy_error"));
        let one = run(shaft(engine, 0.3, &blade("a", "release_time = 0.1")));
        assert!(row.value("max_bearing_load_N") > 1.5 * one.value("max_bearing_load_N"));
    }
}

/// A follower changes no digit, and a released blade rubs.
#[test]
fn a_released_blade_rubs_and_nobody_who_looks_changes_it() {
    let text = study_machine("lab_rig")
        .replace("end_time = \"0.6 s\"", "end_time = \"0.22 s\"")
        .replace("phase = \"0 deg\"", "phase = \"0 deg\"\nrelease_time = \"0.0500017 s\"");
    for engine in ["reduced", "exponential"] {
        let machine = || machine(&text.replace("[run]", &format!("[run]\nengine = \"{engine}\"")));
        let (plain, seen) = (run(machine()), run_seen(machine(), &mut Every(|_: &Frame<'_>| {})));
        assert_eq!(plain.outcome, seen.outcome, "{engine}");
        assert!(plain.value("first_contact_s") > 0.05, "{engine}");
        assert!(plain.value("energy_error") < 1e-5, "{engine}: {}", plain.value("energy_error"));
    }
}

/// A second mass is lost while the rotor rubs: the energy balance closes, and both engines agree on energy and speed.
#[test]
fn a_second_blade_is_lost_in_a_rub() {
    let text = study_machine("lab_rig").replace("end_time = \"0.6 s\"", "end_time = \"0.25 s\"").replace(
        "[rotor.damping]",
        "[rotor.unbalances.second]\ndisc = \"left\"\nmass = \"4 g\"\nradius = \"40 mm\"\nphase = \"50 deg\"\nkind = \"lost\"\n\
         release_time = \"0.2000013 s\"\n\n[rotor.damping]",
    );
    let rows = ["reduced", "exponential"]
        .map(|engine| run(machine(&text.replace("[run]", &format!("[run]\nengine = \"{engine}\"")))));
    for row in &rows {
        assert!(
            row.value("first_contact_s") < 0.19 && row.value("contact_impulse_Ns") > 0.1,
            "contact before the release"
        );
        assert!(row.value("energy_error") < 1e-5, "{}", row.value("energy_error"));
        println!("{} {}", row.value("released_energy_J"), row.value("release_second_at_rad_s"));
    }
    for column in ["released_energy_J", "release_second_at_rad_s"] {
        close(column, rows[1].value(column), rows[0].value(column), 2e-2);
    }
}
