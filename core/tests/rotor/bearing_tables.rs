//! Bearings whose stiffness and damping are tables over the speed, with skew and cross terms.
//!
//! The references were computed independently: separate Timoshenko elements (six Gauss points), separate interpolation of each of the eight
//! coefficients, eigenvalues of the first-order system in double precision, the response to unbalance by a complex solution.
#![expect(clippy::unreadable_literal, reason = "reference values as they were computed")]

use crate::common::{Every, Row, close, machine, machine_with, run, run_seen, study_machine, table_rotor};
use bladeoff_core::modal::{equilibrium, report, unbalance_response, whirl_modes};
use bladeoff_model::machine::{Engine, Machine, MachineDef};

/// Speed, real and imaginary parts of the eigenvalues.
const LINEAR: [(f64, [[f64; 2]; 8]); 4] = [
    (
        150.0,
        [
            [-163.26732273380617, 104.59143818396359],
            [-166.24331295069732, 108.55169131445481],
            [-8.967155532475267, 321.3623396879905],
            [-4.846357493594731, 324.070309163837],
            [-15.955286185652795, 1444.7950827896184],
            [-19.737648262654474, 1613.0490688350567],
            [-28.75639692989057, 3204.8865966373896],
            [-28.420288804606685, 3294.1207260923475],
        ],
    ),
    (
        333.0,
        [
            [-291.0767265636683, 153.94453935139242],
            [-306.70396600965, 162.49000536738265],
            [-8.13629905522223, 314.72571807513935],
            [-7.076358357181322, 320.28315381763025],
            [-27.461197037137993, 1343.5597563329795],
            [-40.23016637277567, 1713.5579613532743],
            [-55.78349551797686, 3156.512961652227],
            [-51.96561282591483, 3358.190177043172],
        ],
    ),
    (
        500.0,
        [
            [-395.5953893030553, 167.13822829476985],
            [-421.69292554644016, 176.48443875748094],
            [-6.713391501487454, 314.4949560477854],
            [-7.445563855414353, 316.21565548564814],
            [-34.16847990912481, 1255.2852788320474],
            [-57.83219774313642, 1803.1194669629413],
            [-77.376199638582, 3116.484326186017],
            [-67.79536109729534, 3425.6870987900506],
        ],
    ),
    (
        650.0,
        [
            [-495.45281402673214, 160.5248512658366],
            [-529.1031481248418, 171.27391948888436],
            [-9.370547956843971, 313.1996025417907],
            [-3.7939219552441354, 315.32869742422764],
            [-38.033861749468315, 1180.0434579430544],
            [-73.56075375484511, 1879.9785419538962],
            [-95.519040119294, 3083.1175853268605],
            [-79.28188449021235, 3494.4850655799623],
        ],
    ),
];
/// Speed and amplitudes (x, y) of the middle disc.
const LINEAR_RESPONSE: [(f64, [[f64; 2]; 2]); 7] = [
    (150.0, [[1.379605151012754e-05, -4.2660964607426067e-07], [-4.318178942193344e-07, -1.4419882290125633e-05]]),
    (250.0, [[7.773595761260988e-05, -9.166538029036852e-06], [-7.96761230379975e-06, -8.400342507036817e-05]]),
    (300.0, [[0.00032659863637612844, -0.0001726634965504018], [-0.00020076340915883782, -0.0004274676369471742]]),
    (320.0, [[-0.00014221805237376358, -0.0007419613558113326], [-0.0007870835862853297, 0.0007684334693395455]]),
    (333.0, [[-0.0003988317843484611, -0.00024144696051080328], [-8.705559294807469e-05, 0.00038853883868618285]]),
    (400.0, [[-0.000128078153072099, -1.5058447905002984e-05], [-8.845087075077342e-06, 0.00012232220915869024]]),
    (600.0, [[-6.60411115312271e-05, -2.680312907406582e-06], [-1.6796023176824663e-06, 6.4993981794414e-05]]),
];
/// Damped critical speeds and real parts.
const LINEAR_CRITICAL: [[f64; 2]; 2] =
    [[314.9353308070237, -8.308138880993809], [320.49872819319876, -7.011672315516616]];
/// Speed, real and imaginary parts of the eigenvalues.
const PCHIP: [(f64, [[f64; 2]; 8]); 4] = [
    (
        150.0,
        [
            [-169.4129984040116, 108.62131279699749],
            [-172.81919472982293, 112.94740512258929],
            [-9.131498079732921, 320.8572239335758],
            [-5.014371960121231, 323.9254450854593],
            [-16.64272968461337, 1444.6773653194484],
            [-20.686734466248126, 1612.8740296922635],
            [-30.04761119508126, 3204.806545430907],
            [-29.762230197869485, 3293.9884757661957],
        ],
    ),
    (
        333.0,
        [
            [-295.51783183781265, 155.64277002092481],
            [-311.6916978287296, 164.27105496299018],
            [-8.047246828736212, 314.5546429347676],
            [-7.133499004628463, 320.1660456839472],
            [-27.89257803333186, 1343.4181412611563],
            [-40.96515737023964, 1713.3318867573132],
            [-56.73496074938021, 3156.384970164917],
            [-52.91225146924717, 3358.0524538095706],
        ],
    ),
    (
        500.0,
        [
            [-403.4237488628863, 168.92268856859076],
            [-430.4254185044746, 178.33991557531598],
            [-6.550883384977777, 314.4536342099751],
            [-7.55396121741003, 315.9144952396412],
            [-34.82529041068891, 1254.9869371477891],
            [-59.216285761172855, 1802.5740225040036],
            [-79.09575489685837, 3116.1721238520568],
            [-69.4353375948732, 3425.3883093075365],
        ],
    ),
    (
        650.0,
        [
            [-513.1024978071612, 163.6284399006974],
            [-548.5726292321235, 174.7710679952211],
            [-9.44114047176794, 312.7965354230495],
            [-3.6035490371234467, 315.1572866897518],
            [-39.2160278021247, 1179.3766951609557],
            [-76.6239685182851, 1878.5048317342003],
            [-99.18762210630211, 3082.29409225749],
            [-82.67639592990153, 3493.7564486959477],
        ],
    ),
];
/// Speed and amplitudes (x, y) of the middle disc.
const PCHIP_RESPONSE: [(f64, [[f64; 2]; 2]); 7] = [
    (150.0, [[1.383973819212456e-05, -4.039718346554379e-07], [-3.7550375644698057e-07, -1.4450537139880159e-05]]),
    (250.0, [[7.818972024290033e-05, -9.157431153234262e-06], [-7.633912759271362e-06, -8.443597976202798e-05]]),
    (300.0, [[0.00032659863637612844, -0.0001726634965504018], [-0.00020076340915883782, -0.0004274676369471742]]),
    (320.0, [[-0.00015333738249337782, -0.0007351523288750563], [-0.0007772035985045038, 0.0007796669851181329]]),
    (333.0, [[-0.00039527369979353423, -0.00023687956230609313], [-8.313526135547448e-05, 0.0003882710267366036]]),
    (400.0, [[-0.0001275622342697597, -1.505758412137258e-05], [-8.545429902153956e-06, 0.00012198625996411093]]),
    (600.0, [[-6.588189056935356e-05, -2.740628129658772e-06], [-1.6179848909138622e-06, 6.4854854361621e-05]]),
];
/// Damped critical speeds and real parts.
const PCHIP_CRITICAL: [[f64; 2]; 2] = [[314.8462958128103, -8.26485555903676], [320.4241088972234, -7.048803444264763]];

pub const AT_CONSTANT_SPEED: &str = "[rotor]\ninitial_speed = 350\n[run]\nend_time = 1\nend_speed = 100\n";

fn at(interpolation: &str) -> Machine {
    machine(&table_rotor(interpolation, AT_CONSTANT_SPEED))
}

#[test]
fn eigenvalues_between_the_points_are_those_of_the_reference() {
    for (interpolation, reference) in [("linear", LINEAR), ("pchip", PCHIP)] {
        let machine = at(interpolation);
        for (speed, wanted) in reference {
            let (_, modes) = whirl_modes(&machine, &[speed]).expect("solvable").remove(0);
            assert!(modes.len() >= wanted.len());
            for ([decay, frequency], mode) in wanted.iter().zip(&modes) {
                let what = format!("{frequency} at {speed} rad/s, {interpolation}");
                close(&what, mode.frequency, *frequency, 1e-9);
                close(&what, mode.damping_ratio, -decay / decay.hypot(*frequency), 1e-9);
            }
        }
    }
}

#[test]
fn critical_speeds_through_the_table_are_those_of_the_reference() {
    for (interpolation, wanted) in [("linear", LINEAR_CRITICAL), ("pchip", PCHIP_CRITICAL)] {
        let found = report(&at(interpolation), &[]).expect("solvable").critical_speeds;
        let found: Vec<_> = found.iter().filter(|found| (100.0..700.0).contains(&found.speed)).collect();
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (found, [speed, decay]) in found.iter().zip(wanted) {
            close("critical speed", found.speed, speed, 1e-9);
            close("damping ratio", found.damping_ratio, -decay / decay.hypot(speed), 1e-6);
        }
    }
}

/// Half the major axis of the ellipse of complex amplitudes, each real and imaginary part.
fn major([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    0.5 * ((a - d).hypot(b + c) + (a + d).hypot(c - b))
}

#[test]
fn unbalance_response_between_the_points_is_that_of_the_reference() {
    for (interpolation, reference) in [("linear", &LINEAR_RESPONSE[..]), ("pchip", &PCHIP_RESPONSE)] {
        // the reference has the mass of the unbalance in its mass matrix; the response here does not
        let machine = machine(&table_rotor(interpolation, AT_CONSTANT_SPEED).replace("mass = 80\n", "mass = 80.05\n"));
        for (speed, wanted) in reference {
            let found = unbalance_response(&machine, &[*speed]).remove(0);
            close(&format!("{speed} {interpolation}"), found.nodes[2], major(*wanted), 1e-9);
        }
    }
}

/// Coast-down through the critical speeds, braked hard.
fn coast_down(engine: Engine, step: &str) -> Row {
    let tail = "[rotor]\ninitial_speed = 360\n[braking]\nconstant = 600\n[run]\nend_time = 2\nend_speed = 250\n";
    run_seen(
        machine_with(&table_rotor("pchip", tail), &[("run.engine", engine.word()), ("run.step", step)]),
        &mut Every(|_| ()),
    )
}

#[test]
fn a_coast_down_through_the_table_closes_its_energy_balance_on_both_engines() {
    let [full, reduced, coarse] =
        [coast_down(Engine::Full, "4 us"), coast_down(Engine::Reduced, "4 us"), coast_down(Engine::Full, "8 us")];
    for row in [&full, &reduced] {
        assert_eq!((row.outcome.status.word(), row.outcome.end_cause.word()), ("ok", "end_speed"));
        println!("energy error {:e}", row.value("energy_error"));
        assert!(row.value("energy_error") < 1e-8, "{}", row.value("energy_error"));
    }
    for column in ["max_bearing_load_left_N", "max_bearing_load_right_N", "max_bearing_force_x_left_N", "end_time_s"] {
        println!("{column}: {:.1e}", close(column, reduced.value(column), full.value(column), 1e-6));
        println!("{column}: {:.1e} by the step", close(column, coarse.value(column), full.value(column), 1e-4));
    }
}

/// When the speed changes, a table adds energy, which is a separate term: without it the balance does not close.
#[test]
fn the_change_of_stiffness_with_the_speed_puts_in_energy() {
    // a table that changes fast between two speeds, a slow rotor, hard braking
    let tail = "[rotor]\ninitial_speed = 360\n[braking]\nconstant = 600\n[run]\nend_time = 2\nend_speed = 250\n";
    let machine = machine_with(&table_rotor("linear", tail), &[("run.engine", "full"), ("run.step", "4 us")]);
    let (mut first, mut worst, mut without, mut largest) = (None, 0.0_f64, 0.0_f64, 0.0_f64);
    run_seen(
        machine,
        &mut Every(|frame| {
            let (total, tables) = (frame.energies.stored() + frame.energies.taken(), frame.energies.tables);
            let start = *first.get_or_insert(total);
            worst = worst.max((total - start).abs());
            without = without.max((total + tables - start).abs());
            largest = largest.max(frame.energies.stored());
        }),
    );
    println!("with the term {:e}, without {:e}", worst / largest, without / largest);
    assert!(worst < 1e-9 * largest && without > 100.0 * worst, "{worst:e} {without:e} {largest:e}");
}

#[test]
fn weight_bends_the_shaft_between_table_bearings_and_is_in_their_forces() {
    let tail = "[rotor]\ninitial_speed = 350\ngravity = [0.0, -9.81]\n[run]\nend_time = \"1 ms\"\nend_speed = 100\n";
    let machine = machine(&table_rotor("linear", tail));
    let rest = equilibrium(&machine).expect("held");
    // masses by the law of the lever: shaft, both discs
    let shaft = 7800.0 * std::f64::consts::PI / 4.0 * 0.07 * 0.07;
    let right = 9.81 * (0.5 * shaft + 0.5 * 80.0 + 0.75 * 20.0);
    close("right", -rest.bearings[1][1], right, 1e-10);
    close("left", -rest.bearings[0][1], 9.81 * (shaft + 100.0) - right, 1e-10);
    assert!(rest.bearings.iter().all(|force| force[0].abs() < 1e-6));
    for engine in [Engine::Full, Engine::Reduced] {
        let mut still = machine.clone();
        still.rotor.unbalances.clear();
        still.run.engine = engine;
        let mut moved = 0.0_f64;
        let row =
            run_seen(still, &mut Every(|frame| moved = moved.max(frame.displacement[0].hypot(frame.displacement[10]))));
        close("load", row.value("max_bearing_load_right_N"), right, 1e-8);
        assert!(row.value("max_upward_bearing_force_right_N") < 1e-9);
        assert!(moved < 1e-12, "the journal stays at its static point: {moved:e}");
    }
}

#[test]
fn a_table_that_the_run_may_leave_is_rejected() {
    let problem = |tail: &str, from: &str, to: &str| {
        let text = table_rotor("linear", tail).replace(from, to);
        MachineDef::parse("test.toml", &text).expect_err("a problem").to_string()
    };
    let low = problem("[rotor]\ninitial_speed = 350\n[run]\nend_time = 1\nend_speed = 99\n", "", "");
    let low = low.lines().next().unwrap_or_default();
    assert!(low.contains("run.end_speed = 945.380362 rpm: the run may fall below the table of rotor.bearings.left, which begins at 954.93 rpm"), "{low}");
    assert!(low.ends_with("allowed: at least 954.93 rpm, or a table from 945.38 rpm"), "{low}");
    let high = problem("[rotor]\ninitial_speed = 670\n[run]\nend_time = 1\nend_speed = 100\n", "", "");
    let high = high.lines().next().unwrap_or_default();
    for part in [
        "rotor.initial_speed = ",
        "the table of rotor.bearings.left ends at 6684.51 rpm, below 6717.93 rpm, which is 1.05 times the largest speed of the run, 6398.03 rpm",
        "allowed: a largest speed of at most 6366.2 rpm, or a table up to 6717.93 rpm",
    ] {
        assert!(high.contains(part), "{part}: {high}");
    }
    let law =
        "[rotor]\ninitial_speed = 350\n[rotor.speed_law]\nacceleration = 400\n[run]\nend_time = 1\nend_speed = 100\n";
    let law = problem(law, "", "");
    assert!(law.contains("rotor.speed_law.acceleration = 3819.718634 rpm/s: "), "{law}");
    assert!(law.contains("the largest speed of the run, 7161.97 rpm"), "{law}");
    let descending = problem(AT_CONSTANT_SPEED, "[100, 200, 300,", "[100, 300, 200,");
    assert!(descending.contains("not a list of ascending speeds"), "{descending}");
    let short = problem(AT_CONSTANT_SPEED, "kyy = [5e7, ", "kyy = [");
    assert!(short.contains("4 values for 5 speeds"), "{short}");
    let missing = problem(AT_CONSTANT_SPEED, "kyy = ", "#");
    assert!(missing.contains("rotor.bearings.left.coefficients.kyy"), "{missing}");
    let seat = problem(AT_CONSTANT_SPEED, "kind = \"table\"", "kind = \"table\"\nelevation = [0, 0]");
    assert!(seat.contains("elevation") && seat.contains("only with kind = \"linear\""), "{seat}");
    let constant = problem(AT_CONSTANT_SPEED, "kind = \"table\"", "kind = \"linear\"");
    assert!(constant.contains("only with kind = \"table\""), "{constant}");
}

/// A speed law that leaves the table is rejected in a file; a rotor whose unbalance drives it out of the table ends there.
#[test]
fn a_run_that_leaves_the_table_is_beyond_the_model() {
    let tail = "[rotor]\ninitial_speed = 350\n[run]\nend_time = 1\nend_speed = 100\nengine = \"full\"\n[braking]\nconstant = 600\n";
    let mut machine = machine(&table_rotor("linear", tail));
    // the check of a file would reject this value
    machine.run.end_speed = 0.0;
    let row = run_seen(machine, &mut Every(|_| ()));
    assert_eq!((row.outcome.status.word(), row.outcome.end_cause.word()), ("beyond", "table_range"));
    assert_eq!(row.outcome.cause.map(|cause| cause.word()), Some("table_range"));
    assert!((row.value("end_speed_rad_s") - 100.0).abs() < 0.01, "{}", row.value("end_speed_rad_s"));
}

/// The shipped turbine on oil films with a length of 0.7 diameters (Reynolds' boundary, no groove, 85 kN each), from the slowest to the highest
/// speed. At the slowest speed, the damping across the load is 330 times that of the linear bearings: the journals are almost clamped.
const FILM: &str = "coefficients = { speeds = [10, 13, 17, 22, 30, 40, 55, 75, 100, 130, 170], \
    kxx = [5.27e8, 5.242e8, 5.214e8, 5.234e8, 5.258e8, 5.28e8, 5.333e8, 5.415e8, 5.505e8, 5.616e8, 5.737e8], \
    kxy = [-5.374e8, -4.569e8, -3.748e8, -3.175e8, -2.485e8, -1.846e8, -1.145e8, -4.683e7, 1.974e7, 8.903e7, 1.681e8], \
    kyx = [-1.928e9, -1.763e9, -1.595e9, -1.498e9, -1.381e9, -1.272e9, -1.174e9, -1.103e9, -1.046e9, -1.012e9, -9.886e8], \
    kyy = [5.287e9, 4.384e9, 3.464e9, 3.038e9, 2.526e9, 2.05e9, 1.634e9, 1.351e9, 1.112e9, 9.495e8, 8.005e8], \
    cxx = [2.328e7, 1.952e7, 1.619e7, 1.396e7, 1.151e7, 9.519e6, 7.865e6, 6.626e6, 5.669e6, 5.03e6, 4.472e6], \
    cxy = [-6.016e7, -4.59e7, -3.481e7, -2.679e7, -1.956e7, -1.46e7, -1.061e7, -7.813e6, -5.895e6, -4.583e6, -3.547e6], \
    cyx = [-6.016e7, -4.59e7, -3.481e7, -2.679e7, -1.956e7, -1.46e7, -1.061e7, -7.813e6, -5.895e6, -4.583e6, -3.547e6], \
    cyy = [3.341e8, 2.355e8, 1.634e8, 1.185e8, 8.003e7, 5.525e7, 3.709e7, 2.559e7, 1.824e7, 1.365e7, 1.027e7] }\n";

/// The turbine without its ring on these films, optionally on pedestals.
fn turbine_on_films(pedestal: &str) -> String {
    let text = study_machine("lp_turbine_paper");
    let rotor = text.split("[diaphragms").next().expect("a rotor").replacen("[run] ", "[run]\nend_speed = 10 #", 1);
    rotor
        .replace("stiffness = \"6e8 N/m\" ", &format!("{pedestal}kind = \"table\"\n{FILM}#"))
        .replace("stiffness = \"6e8 N/m\"\n", &format!("{pedestal}kind = \"table\"\n{FILM}"))
        .replace("damping = \"6e5 N s/m\"\n", "")
}

/// With the default number of modes, on both engines with modal reduction.
#[test]
fn the_loads_of_strongly_damped_tables_are_those_of_the_full_engine() {
    let pedestal = "pedestal = { mass = 3000, stiffness = [2e9, 4e9], damping = 1e6 }\n";
    for (what, text, speeds) in [
        ("ground", turbine_on_films(""), &["157", "80", "40", "20", "11"][..]),
        ("pedestals", turbine_on_films(pedestal), &["157", "40"]),
    ] {
        for speed in speeds {
            let of = |engine: &str| {
                let changes = [("rotor.initial_speed", *speed), ("run.end_time", "0.15 s"), ("run.engine", engine)];
                run(machine_with(&text, &changes))
            };
            let [full, reduced, exponential] = ["full", "reduced", "exponential"].map(of);
            for column in ["max_bearing_load_front_N", "max_bearing_load_rear_N", "max_upward_bearing_force_rear_N"] {
                for row in [&reduced, &exponential] {
                    let error = close(&format!("{what} {speed} {column}"), row.value(column), full.value(column), 5e-4);
                    println!("{what}, {speed} rad/s, {column}: {error:.1e}");
                }
            }
        }
    }
}

/// A rub of the lab rig whose left bearing almost clamps its journal.
#[test]
fn a_rub_on_a_strongly_damped_table_has_the_loads_of_the_full_engine() {
    let linear = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\n";
    let table = "kind = \"table\"\ncoefficients = { speeds = [0, 200, 400], kxx = [8e7, 3e7, 2e7], kxy = [-1e7, 0, 3e6], kyx = [-4e7, -2e7, -2e7], \
                 kyy = [9e7, 4e7, 3e7], cxx = [4e5, 2e5, 1e5], cyy = [9e5, 4e5, 3e5] }\n";
    let text = study_machine("lab_rig").replacen(linear, table, 1);
    let of = |engine: &str| {
        run(machine_with(&text, &[("run.end_time", "0.06 s"), ("contact.gap", "0.3 mm"), ("run.engine", engine)]))
    };
    let [full, reduced, exponential] = ["full", "reduced", "exponential"].map(of);
    assert!(full.value("impacts") > 0.0, "touches");
    for column in ["max_bearing_load_left_N", "max_bearing_load_right_N", "max_filtered_contact_force_N"] {
        for row in [&reduced, &exponential] {
            println!("{column}: {:.1e}", close(column, row.value(column), full.value(column), 1e-2));
        }
    }
}
