//! Bearings on pedestals, with skew stiffness and different properties in both directions, and bearing seats off the bearing line.
//!
//! The references were computed independently: separate Timoshenko elements (six Gauss points), eigenvalues of the first-order system in double
//! precision, the response to unbalance by a complex solution, peaks after a blade-off by Radau IIA of order 5 (displacements) and by the matrix exponential of
//! the whole system in steps of 1 us with a parabola through the three largest values (forces).
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Every, Row, close, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::modal::{report, unbalance_response, whirl_modes};
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_model::outcome::{Group, Part};

/// Shaft of 1 m with two discs; both ends have the same bearing on the same pedestal.
pub fn text(mass: &str, tail: &str) -> String {
    let bearing = |name: &str, position: f64, axial: &str| {
        format!(
            "[rotor.bearings.{name}]\nposition = {position:?}\n{axial}stiffness = [[4e7, 1e7], [-2e7, 8e7]]\ndamping = [[6e4, 0.0], [0.0, 9e4]]\n\
             [rotor.bearings.{name}.pedestal]\nmass = {mass}\nstiffness = [3e7, 8e7]\ndamping = [5e3, 8e3]\n"
        )
    };
    format!(
        "schema = 1\nname = \"pedestals\"\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 4\ndiameter = 0.07\n\
         [rotor.discs.middle]\nposition = 0.5\nmass = 80\ntransverse_inertia = 0.8\npolar_inertia = 1.5\n\
         [rotor.discs.right]\nposition = 0.75\nmass = 20\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.unbalances.blade]\nposition = 0.5\nmass = 0.05\nradius = 0.1\n{}{}{tail}",
        bearing("left", 0.0, "axial_stiffness = 1e6\n"),
        bearing("right", 1.0, "")
    )
}

pub const MASS: &str = "[40.0, 60.0]";

/// Constant speed.
const CONSTANT: &str = "[rotor.speed_law]\nacceleration = 0\n";

/// 0.3 s at a constant speed of 350 rad/s.
fn blade_off(gravity: &str) -> String {
    text(MASS, &format!("[rotor]\ninitial_speed = 350\ngravity = {gravity}\n{CONSTANT}[run]\nend_time = 0.3\n"))
}

fn at_rest(mass: &str) -> Machine {
    machine(&text(mass, "[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n"))
}

/// Speed, real and imaginary part of the eigenvalues.
const EIGENVALUES: [(f64, [[f64; 2]; 12]); 3] = [
    (
        0.0,
        [
            [-840.7605523044392, 188.63069062122005],
            [-890.4895430808576, 192.51386923741114],
            [-6.262273691189178, 277.7058968175795],
            [-3.552959675320761, 303.3611150790627],
            [-51.68242586807078, 757.9809155367253],
            [-56.922439286542, 914.4332712154714],
            [-55.07569989395257, 1028.185894145258],
            [-61.592798756018595, 1159.9793528510654],
            [-89.29658972602363, 1631.3355641115638],
            [-58.852307882049395, 1633.3949757054627],
            [-113.3409027211522, 3283.8567674463907],
            [-174.1079271961761, 3306.978046502632],
        ],
    ),
    (
        200.0,
        [
            [-840.4455278037524, 184.02303662514342],
            [-891.2778451066988, 190.46373028863846],
            [-6.371128697425092, 277.7361253612794],
            [-3.404903757619999, 303.2921090324688],
            [-51.58516386801774, 756.5959199728089],
            [-56.922314909131174, 914.3898166702305],
            [-54.84739194873949, 1027.133056183718],
            [-61.58469330260546, 1159.94529814183],
            [-64.06524596422588, 1541.4743789670936],
            [-86.55227829794313, 1730.3212565537763],
            [-133.42968008095454, 3253.053358161709],
            [-152.46445920153622, 3347.900064755286],
        ],
    ),
    (
        500.0,
        [
            [-841.1070770809783, 177.462789839637],
            [-892.2727848193042, 187.3719428627609],
            [-6.518991851604984, 277.72159539162357],
            [-3.1991521572967896, 303.2319931797454],
            [-50.66526073962861, 746.9914525985321],
            [-56.90211185782606, 914.2410194973972],
            [-54.17921152529104, 1019.6736152442235],
            [-61.524871892192756, 1159.7680247049789],
            [-59.82638694226216, 1414.871752306115],
            [-98.36404762450036, 1893.6291253249422],
            [-147.23921408756917, 3185.861536541239],
            [-134.8290658605132, 3467.005503748594],
        ],
    ),
];

#[test]
fn eigenvalues_are_those_of_the_reference() {
    let speeds = EIGENVALUES.map(|(speed, _)| speed);
    let found = whirl_modes(&at_rest(MASS), &speeds).expect("solvable");
    for ((_, wanted), (speed, modes)) in EIGENVALUES.iter().zip(&found) {
        assert!(modes.len() >= wanted.len());
        for ([decay, frequency], mode) in wanted.iter().zip(modes) {
            let what = format!("{frequency} at {speed} rad/s");
            close(&what, mode.frequency, *frequency, 1e-9);
            close(&what, mode.damping_ratio, -decay / decay.hypot(*frequency), 1e-9);
        }
    }
}

/// Damped critical speeds: speed and real part where the imaginary part is the speed.
#[test]
fn critical_speeds_are_those_of_the_reference() {
    const WANTED: [[f64; 2]; 9] = [
        [184.37853737714684, -840.447107207564],
        [190.56069989066722, -891.2430069069896],
        [277.73924264091306, -6.411304163234179],
        [303.26555753325647, -3.331760922794566],
        [732.8534371012914, -49.22214984873408],
        [913.8627955258834, -56.82102678136499],
        [993.0953916056334, -52.620542076577294],
        [1158.6272648505767, -61.08125956363066],
        [1233.209458204933, -57.986943150809395],
    ];
    let found = report(&at_rest(MASS), &[]).expect("solvable");
    // the first two are overdamped
    let overdamped = found.overdamped_critical_speeds.iter();
    let found: Vec<_> = overdamped.chain(&found.critical_speeds).filter(|found| found.speed < 1500.0).collect();
    assert_eq!(found.len(), WANTED.len(), "{found:?}");
    assert_eq!(found.iter().filter(|found| found.damping_ratio >= 0.9).count(), 2);
    for (found, [speed, decay]) in found.iter().zip(WANTED) {
        close("critical speed", found.speed, speed, 1e-9);
        close("damping ratio", found.damping_ratio, -decay / decay.hypot(speed), 1e-9);
    }
}

/// Half the major axis of the ellipse of complex amplitudes, each real and imaginary part.
fn major([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let forward = (a - d).hypot(b + c);
    let backward = (a + d).hypot(c - b);
    0.5 * (forward + backward)
}

#[test]
fn unbalance_response_is_that_of_the_reference() {
    // amplitudes (x, y) of the middle node, the left pedestal and the force of the right bearing
    const WANTED: [(f64, [[[f64; 2]; 2]; 3]); 3] = [
        (
            100.0,
            [
                [[6.773967349755274e-06, -3.14719435808214e-08], [1.436571278689342e-07, -5.7296181755574185e-06]],
                [[9.688818631634887e-07, -1.6996505564368088e-08], [-2.488639368852473e-09, -3.534770104463977e-07]],
                [[29.229891126489164, -0.021789573087137803], [0.0993705984547244, -28.50762517132739]],
            ],
        ),
        (
            300.0,
            [
                [[-0.00035597599709725363, -0.0001531284114943754], [-0.0012154797776509124, -0.0008782589507405986]],
                [[-6.007679295999575e-05, -2.3859022382742608e-05], [-8.111280351178839e-05, -5.746670628448314e-05]],
                [[-1754.3927828019778, -888.0363190658493], [-6730.867121101209, -5036.784893544884]],
            ],
        ),
        (
            600.0,
            [
                [[-5.3774041406435284e-05, -2.807623162431857e-06], [-1.10816604654399e-06, 6.122392686466201e-05]],
                [[-1.1612381107094139e-05, -9.620769725490488e-07], [2.896966381156356e-07, 5.3724376171769545e-06]],
                [[-431.7490239785454, -18.557863150894924], [-25.151749323595254, 480.5622339435122]],
            ],
        ),
    ];
    // the reference has the mass of the unbalance in its mass matrix; the response here does not
    let text = text(MASS, "[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n");
    let machine = machine(&text.replace("mass = 80\n", "mass = 80.05\n"));
    for (speed, [node, pedestal, bearing]) in WANTED {
        let found = unbalance_response(&machine, &[speed]).remove(0);
        close("middle node", found.nodes[2], major(node), 1e-9);
        close("bearing", found.bearings[1], major(bearing), 1e-9);
        // force of the pedestal: K_p x + i W C_p x
        let force = |[re, im]: [f64; 2], k: f64, c: f64| [k * re - speed * c * im, k * im + speed * c * re];
        let load = major([force(pedestal[0], 3e7, 5e3), force(pedestal[1], 8e7, 8e3)]);
        close("pedestal", found.pedestals[0], load, 1e-9);
    }
}

/// Peaks of bearing and pedestal forces: load, x, y, upward.
const PEAKS: [(&str, &str, [f64; 4]); 12] = [
    ("[0.0, 0.0]", "bearing left", [1841.657986119, 923.320918689, 1788.161166707, 1787.879163457]),
    ("[0.0, 0.0]", "bearing right", [2145.355389161, 1126.865306630, 2081.631651807, 2080.688603691]),
    ("[0.0, 0.0]", "pedestal left", [2010.329524473, 1064.984114404, 1944.670978216, 1944.670978216]),
    ("[0.0, 0.0]", "pedestal right", [2340.895540591, 1300.789182765, 2263.145234164, 2263.145234164]),
    ("[0.0, -9.81]", "bearing left", [2416.003743605, 923.317331691, 2377.048342051, 1198.947828628]),
    ("[0.0, -9.81]", "bearing right", [2814.631164348, 1126.858035145, 2768.610511904, 1393.657039131]),
    ("[0.0, -9.81]", "pedestal left", [3160.622663955, 1064.979855695, 3121.844653740, 767.140945388]),
    ("[0.0, -9.81]", "pedestal right", [3585.039155363, 1300.781704484, 3538.671121513, 987.513274199]),
    ("[3.0, -4.0]", "bearing left", [2042.885394040, 1103.366860043, 2028.271883333, 973.995300416]),
    ("[3.0, -4.0]", "bearing right", [2378.946723867, 1336.901394726, 2361.737752574, 1145.786400210]),
    ("[3.0, -4.0]", "pedestal left", [2431.117067945, 1365.022451174, 2424.470273607, 822.732443483]),
    ("[3.0, -4.0]", "pedestal right", [2792.360917654, 1630.816591732, 2783.201728997, 1016.364183415]),
];

fn assert_peaks(row: &Row, gravity: &str, tolerance: impl Fn(&str) -> f64) {
    for (_, place, wanted) in PEAKS.iter().filter(|(of, ..)| *of == gravity) {
        let (what, name) = place.split_once(' ').expect("two words");
        let columns = [
            format!("max_{what}_load_{name}"),
            format!("max_{what}_force_x_{name}"),
            format!("max_{what}_force_y_{name}"),
            format!("max_upward_{what}_force_{name}"),
        ];
        for (column, wanted) in columns.iter().zip(wanted) {
            let found = row.value(&format!("{column}_N"));
            let error = close(&format!("{column} with {gravity}"), found, *wanted, tolerance(column));
            println!("{column} {gravity}: {error:.1e}");
            let time = row.value(&format!("{column}_at_s"));
            assert!((0.04..0.3).contains(&time), "{column} at {time} s");
            close(column, row.value(&format!("{column}_at_rad_s")), 350.0, 1e-9);
        }
    }
}

#[test]
fn blade_off_has_the_peaks_of_the_reference() {
    for engine in [Engine::Full, Engine::Reduced] {
        for gravity in ["[0.0, 0.0]", "[0.0, -9.81]", "[3.0, -4.0]"] {
            let machine = machine_with(&blade_off(gravity), &[("run.engine", engine.word()), ("run.step", "2 us")]);
            let mut largest = [0.0_f64; 3];
            let row = run_seen(
                machine,
                &mut Every(|frame| {
                    for (largest, node) in largest.iter_mut().zip([0, 2, 4]) {
                        *largest = largest.max(frame.displacement[2 * node].hypot(frame.displacement[10 + 2 * node]));
                    }
                }),
            );
            assert_eq!(row.outcome.status.word(), "ok");
            assert_peaks(&row, gravity, |_| 1e-6);
            if gravity == "[0.0, 0.0]" {
                for (found, wanted) in largest.iter().zip([6.1528000391e-5, 3.7953922483e-4, 7.39128352975e-5]) {
                    close("displacement", *found, wanted, 1e-6);
                }
            }
            assert!(row.value("energy_error") < 1e-9, "{}", row.value("energy_error"));
        }
    }
}

#[test]
fn the_exponential_engine_has_the_peaks_of_the_reference_at_its_own_step() {
    for gravity in ["[0.0, 0.0]", "[0.0, -9.81]", "[3.0, -4.0]"] {
        let row = run_seen(machine_with(&blade_off(gravity), &[("run.engine", "exponential")]), &mut Every(|_| ()));
        assert_eq!(row.outcome.status.word(), "ok");
        // case D has no weight; with weight, the error of an upward force is that of its oscillation (5e-6), compared with the oscillation less the
        // static part
        assert_peaks(&row, gravity, |column| {
            let is_offset = gravity != "[0.0, 0.0]" && column.starts_with("max_upward");
            if is_offset { 1.3e-5 } else { 1e-5 }
        });
        assert!(row.value("energy_error") < 1e-8, "{}", row.value("energy_error"));
    }
}

/// Rub of the lab rig on pedestals, one bearing with skew stiffness: the forces include those of contact steps, and the energy balance the power of
/// pedestal dampers.
#[test]
fn a_rub_on_pedestals_has_the_forces_of_the_reduced_engine() {
    let pedestal = "[rotor.bearings.left.pedestal]\nmass = [2.0, 3.0]\nstiffness = [2e6, 4e6]\ndamping = 500\n\
                    [rotor.bearings.right.pedestal]\nmass = 1.0\nstiffness = 3e6\ndamping = [300, 200]\n[rotor.unbalances.blade_off]";
    let text = study_machine("lab_rig")
        .replacen("\"2e6 N/m\"", "[[2e6, 3e5], [-1e5, 1.7e6]]", 1)
        .replace("gravity = [0.0, 0.0]", "gravity = [0.0, -9.81]")
        .replace("[rotor.unbalances.blade_off]", pedestal);
    let row = |engine, step| {
        run_seen(machine_with(&text, &[("run.end_time", "0.12 s"), ("run.engine", engine), step]), &mut Every(|_| ()))
    };
    let reduced = row("reduced", ("run.step", "1.7 us"));
    let exponential = row("exponential", ("run.contact_step", "1.7 us"));
    for row in [&reduced, &exponential] {
        assert!(row.value("impacts") > 0.0, "touches");
        println!("energy error {:e}", row.value("energy_error"));
        assert!(row.value("energy_error") < 1e-6, "{}", row.value("energy_error"));
    }
    for column in bladeoff_core::record::columns(&reduced.machine) {
        if column.part == Part::Peak && column.group == Group::BearingLoads {
            println!(
                "{}: {:.1e}",
                column.name,
                close(&column.name, exponential.value(&column.name), reduced.value(&column.name), 5e-3)
            );
        }
    }
}

/// All dissipation belongs to the supports: a shaft without damping dissipates nothing.
#[test]
fn the_dampers_of_pedestals_take_energy_from_the_balance() {
    for engine in ["full", "reduced", "exponential"] {
        let text = blade_off("[0.0, 0.0]").replace(CONSTANT, "");
        let mut last = None;
        let row = run_seen(
            machine_with(&text, &[("run.engine", engine), ("run.end_time", "0.1 s")]),
            &mut Every(|frame| last = Some(frame.energies)),
        );
        let energies = last.expect("a frame");
        assert!(energies.bearings > 0.1, "{engine}: {}", energies.bearings);
        // the exponential engine integrates the two parts by different rules
        let share = if engine == "exponential" { 1e-4 } else { 1e-9 };
        println!("{engine}: structure {:e} of {:e}", energies.structure, energies.bearings);
        assert!(energies.structure.abs() < share * energies.bearings, "{engine}: {}", energies.structure);
        assert!(row.value("energy_error") < 1e-8, "{engine}");
    }
}

/// Real and imaginary part of the lowest eigenvalues at 200 rad/s.
const MASSLESS: [[f64; 2]; 6] = [
    [-881.6713202223334, 178.09828443271954],
    [-838.5829233147639, 178.86738489441626],
    [-6.46129494544495, 280.4022127550505],
    [-3.4254415911566283, 304.07693070138924],
    [-109.55410849415203, 1152.8276592151096],
    [-87.16950094252192, 1388.391910325299],
];
const MASSLESS_PEAKS: [(&str, f64); 2] = [("left", 2463.4535296265), ("right", 2869.9633475239)];
/// Forces (x, y) of the middle, left and right bearing \[N\], by one static solution of all degrees of freedom.
const SEAT_LOADS: [[f64; 2]; 3] = [
    [-633.4312638290654, 2059.2716315155485],
    [475.0734478717993, -1544.4537236366702],
    [158.3578159572675, -514.8179078788907],
];

/// Massless pedestals: the exact eigenvalues are those of a first-order motion of the pedestals, by a generalised eigenproblem with a singular mass matrix.
#[test]
fn a_pedestal_without_mass_follows_its_springs_and_dampers() {
    let (speed, modes) = whirl_modes(&at_rest("0"), &[200.0]).expect("solvable").remove(0);
    for (found, wanted) in modes.iter().zip(MASSLESS) {
        let what = format!("{} at {speed} rad/s", wanted[1]);
        // the substitute mass of such a pedestal has a frequency of 1e5 rad/s between its springs
        let (size, tolerance) = (wanted[0].hypot(wanted[1]), (wanted[0].hypot(wanted[1]) / 1e5).powi(2));
        let errors = [
            close(&what, found.frequency, wanted[1], tolerance),
            close(&what, found.damping_ratio, -wanted[0] / size, tolerance),
        ];
        println!("{what}: {errors:?} of {tolerance:.1e}");
    }
    for engine in [Engine::Full, Engine::Reduced] {
        let text = blade_off("[0.0, -9.81]").replace(MASS, "0");
        let row =
            run_seen(machine_with(&text, &[("run.engine", engine.word()), ("run.step", "2 us")]), &mut Every(|_| ()));
        assert_eq!(row.outcome.status.word(), "ok");
        for (name, wanted) in MASSLESS_PEAKS {
            // without inertia, the pedestal transmits the bearing force
            for what in ["bearing", "pedestal"] {
                let column = format!("max_{what}_load_{name}_N");
                println!("{column}: {:.1e}", close(&column, row.value(&column), wanted, 2e-5));
            }
        }
    }
}

/// Without other forces, the journal of a bearing whose seat is off the bearing line rests at the seat; the loads of the seats bend the shaft.
#[test]
fn a_seat_off_the_bearing_line_moves_the_rotor_and_bends_a_third_bearing_into_load() {
    // all seats displaced equally: the rotor is displaced with them, without load
    for engine in [Engine::Full, Engine::Reduced] {
        let base = machine_with(&blade_off("[0.0, 0.0]"), &[("run.engine", engine.word()), ("run.end_time", "1 ms")]);
        let mut shifted = base.clone();
        shifted.rotor.bearings.iter_mut().for_each(|bearing| bearing.elevation = [2e-4, -3e-4]);
        shifted.rotor.unbalances.clear();
        let mut place = [0.0; 2];
        let row = run_seen(shifted, &mut Every(|frame| place = [frame.displacement[4], frame.displacement[14]]));
        close("x", place[0], 2e-4, 1e-9);
        close("y", place[1], -3e-4, 1e-9);
        assert!(row.value("max_bearing_load_N") < 1e-6, "{}", row.value("max_bearing_load_N"));
        assert!(row.value("energy_error") < 1e-9);
    }
    // one seat 0.1 mm above a statically indeterminate line: the loads of a stiff third bearing, from the flexibility of the rotor at rest
    let third = |elevation: &str| {
        blade_off("[0.0, 0.0]").replace(
            "[rotor.unbalances",
            &format!(
                "[rotor.bearings.middle]\nposition = 0.25\nstiffness = [[2e7, 3e6], [-1e6, 3e7]]\ndamping = 1e4\nelevation = {elevation}\n[rotor.unbalances"
            ),
        )
    };
    for engine in [Engine::Full, Engine::Reduced] {
        let text = third("[1e-4, -2e-4]");
        let mut machine = machine_with(&text, &[("run.engine", engine.word()), ("run.end_time", "1 ms")]);
        machine.rotor.unbalances.clear();
        let mut loads = Vec::new();
        let row = run_seen(machine, &mut Every(|frame| loads = frame.bearing_loads.to_vec()));
        for (found, wanted) in loads.iter().flatten().zip(SEAT_LOADS.as_flattened()) {
            close("static load", *found, *wanted, 1e-8);
        }
        assert!(row.value("energy_error") < 1e-9);
    }
}

/// A uniform shaft on three equal supports, the middle one raised: `P = delta/(a^3/(6 E I) + 1.5/k)`, `M = P a/2` at the middle, the stress `M/W`.
#[test]
fn a_raised_middle_support_bends_the_shaft() {
    let (young, diameter, span, k, raised) = (2e11, 0.05_f64, 0.6_f64, 5e8, [3e-5, -4e-5]);
    let bearing = |name: &str, position: f64, more: &str| {
        format!("[rotor.bearings.{name}]\nposition = {position:?}\nstiffness = {k:?}\ndamping = 1e3\n{more}\n")
    };
    let inertia = std::f64::consts::PI / 64.0 * diameter.powi(4);
    let force = 5e-5 / (span.powi(3) / (6.0 * young * inertia) + 1.5 / k);
    let expected = 0.5 * force * span * 0.5 * diameter / inertia;
    for engine in ["full", "reduced", "exponential"] {
        let row = run(machine(&format!(
            "schema = 1\nname = \"three\"\n[run]\nengine = \"{engine}\"\nend_time = 2e-3\n[rotor]\ninitial_speed = 100\n[rotor.material]\n\
             young_modulus = {young:?}\npoisson_ratio = 0.3\ndensity = 7800\nshear_coefficient = \"none\"\n\
             [[rotor.shaft]]\nlength = {:?}\nelements = 12\ndiameter = {diameter:?}\n{}{}{}",
            2.0 * span,
            bearing("left", 0.0, "axial_stiffness = 1e6"),
            bearing("middle", span, &format!("elevation = {raised:?}")),
            bearing("right", 2.0 * span, ""),
        )));
        let found = row.value("max_bending_stress_Pa");
        println!("{engine}: {found} {expected} {:.1e}", found / expected - 1.0);
        close(engine, found, expected, 1e-6);
        close(engine, row.value("max_shaft_von_mises_Pa"), expected, 1e-6);
    }
}

/// A rotor without a preferred direction: its modes at rest and at a tiny spin are those at a small spin, where the general problem is solved.
#[test]
fn round_pedestals_have_round_modes_at_rest() {
    let text = text("50", "[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n")
        .replace(
            "stiffness = [[4e7, 1e7], [-2e7, 8e7]]\ndamping = [[6e4, 0.0], [0.0, 9e4]]",
            "stiffness = 4e7\ndamping = 1e4",
        )
        .replace("stiffness = [3e7, 8e7]\ndamping = [5e3, 8e3]", "stiffness = 3e7\ndamping = 5e3");
    let found = whirl_modes(&machine(&text), &[0.0, 1e-9, 0.2]).expect("solvable");
    for (_, modes) in &found[..2] {
        assert_eq!(modes.len(), found[2].1.len());
        for (at_rest, turning) in modes.iter().zip(&found[2].1) {
            close("frequency", at_rest.frequency, turning.frequency, 1e-3);
            close("damping ratio", at_rest.damping_ratio, turning.damping_ratio, 1e-2);
        }
    }
}

/// An almost rigid pedestal leaves the stresses of the shaft as on rigid ground: the pedestal's displacements are not those of a shaft node.
/// 36 modes: with 24, the truncated modes of both machines differ by 1 % in the stress beside the contact.
#[test]
fn a_stiff_pedestal_leaves_the_stresses_of_the_shaft() {
    let text = study_machine("lab_rig");
    let pedestal =
        "\n[rotor.bearings.left.pedestal]\nmass = \"1000 kg\"\nstiffness = \"1e12 N/m\"\ndamping = \"1e5 N s/m\"\n";
    for engine in ["reduced", "full", "exponential"] {
        // released at this speed, the rotor touches after 47 ms
        let own = [("rotor.initial_speed", "300"), ("run.end_time", "0.07 s"), ("run.rotor_modes", "36")];
        let changes = [&own[..], &[("run.engine", engine)]].concat();
        let [ground, pedestal] = [text.clone(), text.clone() + pedestal].map(|text| run(machine_with(&text, &changes)));
        assert!(ground.value("contact_impulse_Ns") > 0.0, "contact happened");
        for name in [
            "max_bending_stress_Pa",
            "max_shaft_von_mises_Pa",
            "max_bending_stress_section0_Pa",
            "max_torsional_moment_Nm",
            "max_eccentricity_m",
        ] {
            let (found, expected) = (pedestal.value(name), ground.value(name));
            println!("{engine}: {name}: {found} {expected} {:.1e}", found / expected - 1.0);
            assert!((found - expected).abs() < 1e-3 * expected, "{engine}: {name}: {found}, not {expected}");
        }
    }
}

/// A point mass on a bearing and a massless pedestal in series: equal to the mass on half the stiffness and half the damping.
#[test]
fn a_point_mass_leaves_its_mass_to_itself() {
    let text = |bearing: &str| {
        format!(
            "schema = 1\nname = \"pm\"\n[run]\nend_time = 0.3\nstep = 1e-5\nengine = \"full\"\n[rotor]\nkind = \"point-mass\"\nmass = 10\n\
             polar_inertia = 0.1\ninitial_speed = 200\ngravity = [0, -9.81]\n[rotor.unbalances.u]\nmass = 0.01\nradius = 0.1\n\
             [rotor.bearings.a]\n{bearing}"
        )
    };
    let series = "stiffness = 2e6\ndamping = 400\n[rotor.bearings.a.pedestal]\nstiffness = 2e6\ndamping = 400\n";
    let [on_pedestal, alone] = [series, "stiffness = 1e6\ndamping = 200\n"].map(|bearing| machine(&text(bearing)));
    let frequency = |machine: &Machine| {
        let (_, modes) = whirl_modes(machine, &[200.0]).expect("solvable").remove(0);
        modes.iter().map(|mode| mode.frequency).filter(|rate| *rate > 1.0).fold(f64::INFINITY, f64::min)
    };
    let [found, expected] = [frequency(&on_pedestal), frequency(&alone)];
    assert!((found - expected).abs() < 1e-3 * expected, "{found} rad/s, not {expected}");
    let [on_pedestal, alone] = [on_pedestal, alone].map(run);
    for name in ["max_bearing_load_N", "max_bearing_force_y_a_N"] {
        let (found, expected) = (on_pedestal.value(name), alone.value(name));
        assert!((found - expected).abs() < 1e-3 * expected, "{name}: {found}, not {expected}");
    }
}
