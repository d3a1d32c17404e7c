//! Torques over time and braking tables, against closed forms, and between the engines.

use crate::common::{Every, close, machine, run, run_seen};
use bladeoff_core::record::Frame;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::Matrix;

const ENGINES: [&str; 3] = ["exponential", "reduced", "full"];

/// Key of the step of an engine.
fn key(engine: &str) -> &str {
    if engine == "exponential" { "contact_step" } else { "step" }
}

/// Shaft of three sections with discs at both ends and in the middle. `of_run`: lines of `[run]`.
fn shaft(of_run: &str, tail: &str) -> Machine {
    machine(&format!(
        "schema = 1\nname = \"torques\"\n[run]\n{of_run}\n[rotor]\ninitial_speed = 300\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.25\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 0.4\nelements = 4\ndiameter = 0.06\n\
         [[rotor.shaft]]\nlength = 0.4\nelements = 4\ndiameter = 0.05\n\
         [[rotor.shaft]]\nlength = 0.4\nelements = 4\ndiameter = 0.06\n\
         [rotor.discs.left]\nposition = 0.0\nmass = 30\ntransverse_inertia = 0.2\npolar_inertia = 0.4\n\
         [rotor.discs.middle]\nposition = 0.6\nmass = 40\ntransverse_inertia = 0.4\npolar_inertia = 0.7\n\
         [rotor.discs.right]\nposition = 1.2\nmass = 20\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.bearings.left]\nposition = 0.1\nstiffness = 5e7\ndamping = 2e4\naxial_stiffness = 1e6\n\
         [rotor.bearings.right]\nposition = 1.1\nstiffness = 5e7\ndamping = 2e4\n\
         [rotor.damping]\nstiffness_proportional = 2e-5\n{tail}"
    ))
}

/// A driving torque at 0.2 m, in equilibrium with a torque at 1.2 m and braking.
const STEADY: &str = "[torques.steam]\nposition = 0.2\ntimes = [0]\nvalues = [\"3 kN m\"]\n\
    [torques.generator]\nposition = 1.2\nbalance = true\n[braking]\nlinear = 0.5\n";

/// Static torsion between two torques, calculated by hand: T L/(G I_p) of each section. The torsion rotates with the shaft without vibration, even
/// with few torsional modes.
#[test]
fn the_run_starts_with_the_static_torsion_and_stays_there() {
    let rigidity = |d: f64| 2e11 / 2.5 * std::f64::consts::PI / 32.0 * d.powi(4);
    let residual =
        "[rotor.unbalances.residual]\nposition = 0.6\nmass = 0.02\nradius = 0.05\nphase = 0.3\npresent = \"before\"\n";
    for engine in ENGINES {
        // bearings dissipate energy of the whirl
        for (tail, braked) in [(STEADY.to_owned(), 1e-12), (format!("{STEADY}{residual}"), 1e-7)] {
            let modes = if engine == "full" { "" } else { "torsional_modes = 2\n" };
            let machine = shaft(&format!("engine = \"{engine}\"\nend_time = 0.05\n{modes}"), &tail);
            let generator = machine.torques[1].before();
            assert!((generator + 3000.0 - 150.0).abs() < 1e-9, "{generator}");
            let [first, last] = [machine.torques[0].node, machine.torques[1].node];
            // braking acts in proportion to inertia, along the line
            let weights = Structure::build(&machine, None).expect("buildable").rotor.spin_weights;
            let moments: Vec<f64> = (first..last).map(|i| 3000.0 - 150.0 * weights[..=i].iter().sum::<f64>()).collect();
            let angle = |i: usize| moments[i - first] * 0.1 / rigidity(if (4..8).contains(&i) { 0.05 } else { 0.06 });
            let by_hand: f64 = (first..last).map(angle).sum();
            let (mut instants, mut worst) = (0, 0.0_f64);
            let row = run_seen(
                machine,
                &mut Every(|frame: &Frame<'_>| {
                    let torsion = frame.torsion_angles[first] - frame.torsion_angles[last];
                    worst = worst.max((torsion / by_hand - 1.0).abs());
                    instants += 1;
                }),
            );
            println!("{engine}: torsion {by_hand} rad, off by {worst:e}");
            assert!(instants > 100 && worst < 1e-7, "{engine}: {worst:e}");
            close("moment", row.value("max_torsional_moment_Nm"), moments[0], 1e-7);
            close("speed", row.value("end_speed_rad_s"), 300.0, braked);
            let mises = row.value("max_shaft_von_mises_section1_Pa");
            let shear = moments[4 - first] * 0.025 / (std::f64::consts::PI / 32.0 * 0.05_f64.powi(4));
            assert!(mises >= 3.0_f64.sqrt() * shear * (1.0 - 1e-6), "{mises} {shear}");
            assert!(row.value("energy_error") < 1e-6, "{engine}: {:e}", row.value("energy_error"));
        }
    }
}

/// Two discs on one element: two torsional degrees of freedom, without damping and braking.
fn two_discs(engine: &str, step: f64, end: f64, tail: &str) -> Machine {
    machine(&text_of_two_discs(engine, step, end, tail))
}

fn text_of_two_discs(engine: &str, step: f64, end: f64, tail: &str) -> String {
    let key = key(engine);
    format!(
        "schema = 1\nname = \"two discs\"\n[run]\nengine = \"{engine}\"\n{key} = {step:?}\nend_time = {end:?}\n[rotor]\ninitial_speed = 200\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.25\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 1\ndiameter = 0.05\n\
         [rotor.discs.a]\nposition = 0.0\nmass = 50\ntransverse_inertia = 1\npolar_inertia = 1.5\n\
         [rotor.discs.b]\nposition = 1.0\nmass = 50\ntransverse_inertia = 1\npolar_inertia = 0.5\n\
         [rotor.bearings.a]\nposition = 0.0\nstiffness = 1e8\ndamping = 1e4\naxial_stiffness = 1e6\n\
         [rotor.bearings.b]\nposition = 1.0\nstiffness = 1e8\ndamping = 1e4\n\
         {tail}"
    )
}

/// Inertia, squared frequency and elastic mode of unit inertia of [`two_discs`], by hand.
fn two_inertias(mass: &Matrix, k: f64) -> (f64, f64, [f64; 2]) {
    let (a, b, c) = (mass[(0, 0)], mass[(0, 1)], mass[(1, 1)]);
    let inertia = a + 2.0 * b + c;
    // orthogonal to the rotation
    let shape = [b + c, -(a + b)];
    let norm = (a * shape[0] * shape[0] + 2.0 * b * shape[0] * shape[1] + c * shape[1] * shape[1]).sqrt();
    let mode = shape.map(|part| part / norm);
    (inertia, k * (mode[0] - mode[1]).powi(2), mode)
}

/// Largest errors of moment and spin against closed forms in time, relative to the largest moment and to the change of the spin.
fn errors(machine: Machine, exact: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let rotor = Structure::build(&machine, None).expect("buildable").rotor;
    let k = -rotor.torsional_stiffness[(0, 1)];
    let (mut errors, mut sizes, start) = ([0.0_f64; 2], [0.0_f64; 2], exact(0.0)[1]);
    run_seen(
        machine,
        &mut Every(|frame: &Frame<'_>| {
            let [moment, speed] = exact(frame.time);
            let found = k * (frame.torsion_angles[0] - frame.torsion_angles[1]);
            errors = [errors[0].max((found - moment).abs()), errors[1].max((frame.speed - speed).abs())];
            sizes = [sizes[0].max(moment.abs()), sizes[1].max((speed - start).abs())];
        }),
    );
    [errors[0] / sizes[0], errors[1] / sizes[1]]
}

/// A torque step on one disc: the moment oscillates up to twice its static share with the frequency of the two discs, and the spin accelerates with
/// T/J.
#[test]
fn a_torque_step_swings_to_twice_the_static_share() {
    let (torque, from, end) = (400.0, 0.010_03, 0.08);
    let tail = format!("[torques.kick]\nposition = 0\ntimes = [{from:?}, {from:?}]\nvalues = [0, {torque:?}]\n");
    for engine in ENGINES {
        let rotor = Structure::build(&two_discs(engine, 1e-4, end, &tail), None).expect("buildable").rotor;
        let k = -rotor.torsional_stiffness[(0, 1)];
        let (inertia, square, mode) = two_inertias(&rotor.torsional_mass, k);
        let amplitude = k * (mode[0] - mode[1]) * mode[0] * torque / square;
        let share = rotor.spin_weights[1] * torque;
        close("static share", amplitude, share, 1e-12);
        let exact = |time: f64| {
            let s = (time - from).max(0.0);
            [amplitude * (1.0 - (square.sqrt() * s).cos()), 200.0 + torque * s / inertia]
        };
        let of = |step: f64| errors(two_discs(engine, step, end, &tail), exact);
        let [coarse, fine] = [of(5e-5), of(2.5e-5)];
        let order = (coarse[0] / fine[0]).log2();
        println!("{engine}: moment off by {coarse:?} {fine:?}, order {order:.2}, w {} rad/s", square.sqrt());
        if engine == "exponential" {
            assert!(fine[0] < 1e-7 && fine[1] < 1e-6, "{fine:?}");
        } else {
            assert!((order - 2.0).abs() < 0.3 && fine[0] < 1e-4 && fine[1] < 1e-2, "{engine}: {order} {fine:?}");
        }
        let row = run(two_discs(engine, 2.5e-5, end, &tail));
        close("peak", row.value("max_torsional_moment_Nm"), 2.0 * share, 2e-4);
        close("spin", row.value("end_speed_rad_s"), exact(end)[1], 1e-9);
    }
}

/// A torque that rises to a constant value accelerates a rotor from rest, against braking that is linear in the spin:
/// `J W' = T(t) - c W`. The moment is the undamped response of the two discs to the ramp.
#[test]
fn a_torque_drives_a_rotor_up_from_rest() {
    let (torque, rise, brake, end) = (400.0, 0.050_07, 3.0, 0.4);
    let tail = format!(
        "[torques.motor]\nposition = 0\ntimes = [0, {rise:?}]\nvalues = [0, {torque:?}]\n[braking]\nlinear = {brake:?}\n"
    );
    for engine in ENGINES {
        let from_rest = |step: f64| {
            let text = text_of_two_discs(engine, step, end, &tail);
            assert!(text.contains("initial_speed = 200\n"));
            machine(&text.replace("initial_speed = 200\n", "initial_speed = 0\n"))
        };
        let rotor = Structure::build(&from_rest(1e-4), None).expect("buildable").rotor;
        let k = -rotor.torsional_stiffness[(0, 1)];
        let (inertia, square, mode) = two_inertias(&rotor.torsional_mass, k);
        let (rate, w, c) = (torque / rise, square.sqrt(), brake / inertia);
        // a ramp of unit rate from rest: spin and modal displacement
        let spin = |t: f64| if t > 0.0 { (t - (1.0 - (-c * t).exp()) / c) / brake } else { 0.0 };
        let modal = |t: f64| if t > 0.0 { mode[0] * (t - (w * t).sin() / w) / square } else { 0.0 };
        let exact = |time: f64| {
            let both = |of: &dyn Fn(f64) -> f64| rate * (of(time) - of(time - rise));
            [k * (mode[0] - mode[1]) * both(&modal), both(&spin)]
        };
        let [coarse, fine] = [5e-5, 2.5e-5].map(|step| errors(from_rest(step), exact));
        println!("{engine}: off by {coarse:?} {fine:?}, ends at {} rad/s", exact(end)[1]);
        assert!(exact(end)[1] > 40.0);
        let orders = [0, 1].map(|i| (coarse[i] / fine[i]).log2());
        let moment = if engine == "exponential" { 1e-10 } else { 1e-4 };
        assert!(fine[0] < moment && fine[1] < 1e-8 && (orders[1] - 2.0).abs() < 0.1, "{engine}: {fine:?} {orders:?}");
        let row = run(from_rest(2.5e-5));
        assert_eq!(row.outcome.status.word(), "ok", "{engine}");
        close("spin", row.value("end_speed_rad_s"), exact(end)[1], 1e-6);
        assert!(row.value("energy_error") < 1e-6, "{engine}: {:e}", row.value("energy_error"));
    }
}

/// Response of two discs to a short circuit, by fine steps of the fourth-order Runge-Kutta rule. The peaks of a torque with high frequency are
/// between the steps of the coarser runs.
#[test]
fn a_short_circuit_rings_as_the_equation_says() {
    let (start, end) = (0.004_07, 0.06);
    let tail = format!(
        "[torques.generator]\nposition = 1.0\ntimes = [0.0, {start:?}, 0.02]\nvalues = [-200, -200, 0]\n\
         [torques.generator.short_circuit]\nstart = {start:?}\nfrequency = \"3000 rpm\"\namplitude = -900\ndecay = 0.05\n\
         double_amplitude = 500\ndouble_decay = 0.02\n\
         [torques.steam]\nposition = 0.0\nbalance = true\ntimes = [0.01, 0.03]\nfactors = [1, 0.2]\n"
    );
    let reference = two_discs("full", 1e-4, end, &tail);
    let rotor = Structure::build(&reference, None).expect("buildable").rotor;
    let k = -rotor.torsional_stiffness[(0, 1)];
    let (inertia, square, mode) = two_inertias(&rotor.torsional_mass, k);
    let torques = |t: f64| -> [f64; 2] {
        let line = |points: &[(f64, f64)]| {
            let next = points.iter().position(|(at, _)| *at > t);
            match next {
                Some(0) => points[0].1,
                None => points[points.len() - 1].1,
                Some(i) => {
                    let ((a, x), (b, y)) = (points[i - 1], points[i]);
                    x + (y - x) * (t - a) / (b - a)
                }
            }
        };
        let s = (t - start).max(0.0);
        let w = 100.0 * std::f64::consts::PI;
        let swing = -900.0 * (-s / 0.05).exp() * (w * s).sin() + 500.0 * (-s / 0.02).exp() * (2.0 * w * s).sin();
        [200.0 * line(&[(0.01, 1.0), (0.03, 0.2)]), line(&[(0.0, -200.0), (start, -200.0), (0.02, 0.0)]) + swing]
    };
    // amplitude, rate, spin, at steps of 1 us
    let h = 1e-6;
    let rates = |t: f64, [q, v, _]: [f64; 3]| {
        let [one, other] = torques(t);
        [v, mode[0] * one + mode[1] * other - square * q, (one + other) / inertia]
    };
    let mut states = vec![[(mode[0] * 200.0 - mode[1] * 200.0) / square, 0.0, 200.0]];
    for n in 0..=(end / h).round() as usize {
        let (t, y) = (n as f64 * h, states[n]);
        let add = |k: [f64; 3], part: f64| [0, 1, 2].map(|i| y[i] + part * h * k[i]);
        let k1 = rates(t, y);
        let k2 = rates(t + 0.5 * h, add(k1, 0.5));
        let k3 = rates(t + 0.5 * h, add(k2, 0.5));
        let k4 = rates(t + h, add(k3, 1.0));
        states.push([0, 1, 2].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])));
    }
    let exact = |time: f64| {
        let at = (time / h).round() as usize;
        [k * (mode[0] - mode[1]) * states[at][0], states[at][2]]
    };
    for engine in ENGINES {
        let of = |step: f64| errors(two_discs(engine, step, end, &tail), exact);
        let [coarse, fine] = [of(5e-5), of(2.5e-5)];
        let orders = [0, 1].map(|i| (coarse[i] / fine[i]).log2());
        println!("{engine}: off by {coarse:?} {fine:?}, orders {orders:?}");
        if engine == "exponential" {
            assert!(fine[0] < 1e-6 && fine[1] < 1e-8, "{fine:?}");
        } else {
            assert!((orders[0] - 2.0).abs() < 0.3 && fine[0] < 1e-2, "{engine}: {orders:?} {fine:?}");
        }
    }
}

/// `J W' = -B(W)` with B linear between speeds: `W + a = (W0 + a) e^{-b t}` in each piece.
#[test]
fn a_coast_down_follows_the_braking_table() {
    let points = [(0.0, 0.4), (40.0, 1.2), (70.0, 0.9), (100.0, 3.0)];
    let inertia = 0.5;
    let exact = |time: f64| {
        let (mut speed, mut left) = (90.0_f64, time);
        for ends in points.windows(2).rev() {
            let ((low, b0), (high, b1)) = (ends[0], ends[1]);
            if speed <= low {
                continue;
            }
            let slope = (b1 - b0) / (high - low);
            let shift = b0 / slope - low;
            let at = |t: f64| (speed + shift) * (-slope * t / inertia).exp() - shift;
            let passing = -inertia / slope * ((low + shift) / (speed + shift)).ln();
            if passing > left {
                return at(left);
            }
            (speed, left) = (low, left - passing);
        }
        0.0
    };
    let list = |part: fn(&(f64, f64)) -> f64| format!("{:?}", points.iter().map(part).collect::<Vec<f64>>());
    for engine in ENGINES {
        let of = |step: f64, end: f64| {
            run(machine(&format!(
                "schema = 1\nname = \"table\"\n[run]\nengine = \"{engine}\"\n{} = {step:?}\nend_time = {end:?}\n[rotor]\nkind = \"point-mass\"\nmass = 2\n\
                 polar_inertia = {inertia:?}\ninitial_speed = 90\n[rotor.bearings.b]\nstiffness = 1e4\n\
                 [braking]\nspeeds = {}\ntorques = {}\n",
                key(engine),
                list(|point| point.0),
                list(|point| point.1)
            )))
        };
        // a corner of the table inside a step causes an error of the same order that depends on its position in the step
        for end in [4.0, 12.0, 30.0] {
            let error = |step: f64| (of(step, end).value("end_speed_rad_s") - exact(end)).abs();
            let [coarse, fine] = [error(2.5e-4), error(1.25e-4)];
            println!("{engine}: {} rad/s after {end} s, off by {coarse:e} {fine:e}", exact(end));
            assert!(fine < 2e-6 && (end > 4.0 || fine < 0.3 * coarse), "{engine}: {coarse:e} {fine:e}");
        }
        // B(0) = 0.4 N m stops the rotor
        let row = of(2.5e-4, 200.0);
        assert_eq!(row.value("end_speed_rad_s"), 0.0, "{engine}");
        let stop = {
            let (mut low, mut high) = (30.0, 200.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if exact(middle) > 0.0 { low = middle } else { high = middle }
            }
            low
        };
        close("stop", row.value("end_time_s"), stop, 1e-3);
    }
}

/// A drive compensates the sum of the torques, which may have any value; the torsion is static between the torque and the inertias.
#[test]
fn a_prescribed_speed_takes_the_rest_of_all_torques() {
    let tail = "[torques.fan]\nposition = 1.2\ntimes = [0]\nvalues = [-500]\n[rotor.speed_law]\nacceleration = 0\n";
    for engine in ENGINES {
        let machine = shaft(&format!("engine = \"{engine}\"\nend_time = 0.02\n"), tail);
        let weight = Structure::build(&machine, None).expect("buildable").rotor.spin_weights[machine.torques[0].node];
        let (mut work, mut drive) = (0.0, 0.0);
        let row = run_seen(
            machine,
            &mut Every(|frame: &Frame<'_>| (work, drive) = (frame.energies.torques, frame.energies.drive)),
        );
        // the weight of the last node is that of its disc and half an element
        close("moment", row.value("max_torsional_moment_Nm"), 500.0 * (1.0 - weight), 1e-6);
        close("work", work, -500.0 * 300.0 * 0.02, 1e-2);
        close("drive", drive, -work, 1e-6);
        assert!(row.value("energy_error") < 1e-6, "{engine}: {:e}", row.value("energy_error"));
    }
}

/// Two jumps, a slope and a short circuit.
const COURSE: &str = "[torques.steam]\nposition = 0.2\ntimes = [\"10.03 ms\", \"10.03 ms\", \"60 ms\"]\nvalues = [\"3 kN m\", \"2 kN m\", 0]\n\
    [torques.generator]\nposition = 1.2\nbalance = true\ntimes = [\"0 s\", \"25.01 ms\", \"25.01 ms\"]\nfactors = [1, 1, 0]\n\
    [torques.generator.short_circuit]\nstart = \"25.01 ms\"\nfrequency = \"3000 rpm\"\namplitude = \"-8 kN m\"\ndecay = \"60 ms\"\n\
    double_amplitude = \"4 kN m\"\n[braking]\nconstant = 20\nspeeds = [0, 250, 400]\ntorques = [5, 100, 160]\n\
    [rotor.unbalances.blade]\ndisc = \"middle\"\nmass = 0.1\nradius = 0.1\nkind = \"lost\"\nrelease_time = \"20 ms\"\n\
    [rotor.unbalances.residual]\nposition = 0.6\nmass = 0.05\nradius = 0.1\nphase = 1.0\npresent = \"before\"\n";

#[test]
fn the_energy_closes_only_with_the_work_of_the_torques() {
    for engine in ENGINES {
        let (mut first, mut largest, mut errors) = (None, 0.0_f64, [0.0_f64; 2]);
        let row = run_seen(
            shaft(&format!("engine = \"{engine}\"\nend_time = 0.1\n"), COURSE),
            &mut Every(|frame: &Frame<'_>| {
                let of = frame.energies;
                let total = of.stored() + of.taken();
                let first: f64 = *first.get_or_insert(total);
                largest = largest.max(of.stored().abs());
                for (error, total) in errors.iter_mut().zip([total, total + of.torques]) {
                    *error = error.max((total - first).abs());
                }
            }),
        );
        let [with, without] = errors.map(|error| error / largest);
        println!("{engine}: {with:e}, without the torques {without:e}, guard {:e}", row.value("energy_error"));
        assert!(with < 1e-5 && without > 1e-2, "{engine}: {with:e} {without:e}");
        assert!(row.value("energy_error") < if engine == "exponential" { 1e-5 } else { 1e-6 });
    }
}

/// The engines share only the courses of the torques, no other code. With all torsional modes, torsion and spin after 90 ms agree.
#[test]
fn the_engines_agree_on_the_torsion() {
    let of = |engine: &str, step: f64| {
        let modes = if engine == "full" { "" } else { "rotor_modes = 52\ntorsional_modes = 12\n" };
        let machine =
            shaft(&format!("engine = \"{engine}\"\n{} = {step:?}\nend_time = 0.1\n{modes}", key(engine)), COURSE);
        let ends = [machine.torques[0].node, machine.torques[1].node];
        let mut last = [0.0; 2];
        let row = run_seen(
            machine,
            &mut Every(|frame: &Frame<'_>| {
                let [first, second] = ends.map(|node| frame.torsion_angles[node]);
                if (frame.time - 0.09).abs() < 1e-9 {
                    last = [first - second, frame.speed];
                }
            }),
        );
        (last, row)
    };
    let (full, row) = of("full", 1.25e-6);
    let moment = row.value("max_torsional_moment_Nm");
    let error = |engine: &str, step: f64| {
        let (last, row) = of(engine, step);
        close("moment", row.value("max_torsional_moment_Nm"), moment, 5e-4);
        [0, 1].map(|i| (last[i] / full[i] - 1.0).abs())
    };
    let reduced = error("reduced", 1.25e-6);
    let exponential = [1e-4, 5e-5, 2.5e-5].map(|step| error("exponential", step));
    println!("reduced {reduced:?}, exponential {exponential:?}, moment {moment} N m");
    assert!(reduced[0] < 1e-6 && reduced[1] < 1e-9, "{reduced:?}");
    // the remaining difference does not depend on the step: the torsional rates do not act on the gyroscopic moments of `exponential`
    for [torsion, speed] in exponential {
        assert!(torsion < 2e-5 && speed < 5e-7, "{exponential:?}");
    }
}

/// A lost blade that rubs while the generator is short-circuited.
#[test]
fn a_rub_during_a_short_circuit_agrees_between_the_engines() {
    let torques = "[torques.drive]\nposition = 0.3\ntimes = [\"30 ms\", \"30 ms\"]\nvalues = [\"60 N m\", 0]\n\
        [torques.generator]\nposition = 0.9\nbalance = true\ntimes = [\"30 ms\", \"30 ms\"]\nfactors = [1, 0]\n\
        [torques.generator.short_circuit]\nstart = \"30 ms\"\nfrequency = \"3000 rpm\"\namplitude = \"-60 N m\"\ndecay = \"50 ms\"\n\
        double_amplitude = \"30 N m\"\n";
    let rig = crate::common::study_machine("lab_rig")
        .replacen("end_time = \"0.6 s\"", "end_time = 0.12", 1)
        .replacen("rotor_radius = \"50 mm\"", "rotor_radius = \"50.2 mm\"", 1)
        .replacen("gap = \"0.5 mm\"", "gap = \"0.3 mm\"", 1);
    let rows = ENGINES.map(|engine| {
        let text = rig.replacen("end_time = 0.12", &format!("end_time = 0.12\nengine = \"{engine}\""), 1) + torques;
        let row = run(machine(&text));
        assert!(row.value("first_contact_s") < 0.1 && row.value("contact_impulse_Ns") > 0.0, "{engine}: contact");
        row
    });
    let alone = run(machine(&rig.replacen("end_time = 0.12", "end_time = 0.12\nengine = \"exponential\"", 1)));
    assert!(rows[0].value("max_torsional_moment_Nm") > 2.0 * alone.value("max_torsional_moment_Nm"));
    for row in &rows {
        for column in [
            "max_torsional_moment_Nm",
            "max_bearing_load_N",
            "contact_impulse_Ns",
            "friction_energy_J",
            "end_speed_rad_s",
        ] {
            println!(
                "{column} {} of {}, {:+.2e}",
                row.value(column),
                rows[2].value(column),
                row.value(column) / rows[2].value(column) - 1.0
            );
        }
        println!("energy {:e} {:?}", row.value("energy_error"), row.outcome.status);
    }
    for row in &rows[..2] {
        for (column, most) in [
            ("max_torsional_moment_Nm", 2e-3),
            ("max_bearing_load_N", 1e-2),
            ("contact_impulse_Ns", 2e-2),
            ("friction_energy_J", 2e-2),
            ("end_speed_rad_s", 1e-3),
        ] {
            close(column, row.value(column), rows[2].value(column), most);
        }
    }
}
