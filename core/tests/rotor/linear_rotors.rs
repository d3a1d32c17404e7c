//! Linear rotors against `data/literature/linear_rotors.json` (two independent codes), the SDLL cases of the ROTORINSA
//! verification set and the closed form of the spinning simply supported beam. The models go through the machine format.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Every, close, machine, run_seen};
use bladeoff_core::modal::{ModesReport, Whirl, quadratic_modes, report, whirl_modes};
use bladeoff_core::rotor::RotorMatrices;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{Matrix, Vector, solve};
use serde_json::Value;
use std::fmt::Write as _;

const LALANNE: &str = "lalanne_ferraris_3disc";
const NELSON: &str = "nelson_mcvaugh_isotropic_timoshenko";
const NELSON_NO_SHEAR: &str = "nelson_mcvaugh_isotropic_rayleigh_beam";

fn reference() -> Value {
    serde_json::from_str(include_str!("../data/literature/linear_rotors.json")).expect("the reference data are JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn index(value: &Value) -> usize {
    usize::try_from(value.as_u64().expect("a whole number")).expect("small")
}

/// The machine file of a reference model, each element cut into `split` (1: as published).
fn text_of(case: &Value, split: usize, tail: &str) -> String {
    let (model, positions) = (&case["model"], numbers(&case["model"]["node_positions"]));
    let material = &model["material"];
    let shear = if case["theory"]["shear"].as_bool() == Some(false) { "none" } else { "cowper" };
    let mut text = format!(
        "schema = 1\nname = \"reference\"\n[rotor.material]\nyoung_modulus = {:e}\npoisson_ratio = {}\n\
         density = {:e}\nshear_coefficient = \"{shear}\"\n",
        number(&material["E"]),
        number(&material["nu"]),
        number(&material["rho"]),
    );
    for element in list(&model["elements"]) {
        let length = number(&element["L"]);
        write!(
            text,
            "[[rotor.shaft]]\nlength = {length:?}\nelements = {split}\ndiameter = {:?}\ninner_diameter = {:?}\n",
            number(&element["od"]),
            number(&element["id"])
        )
        .expect("writing to a string");
    }
    for (k, disc) in list(&model["discs"]).iter().enumerate() {
        write!(
            text,
            "[rotor.discs.disc{k}]\nposition = {:?}\nmass = {:?}\ntransverse_inertia = {:?}\npolar_inertia = {:?}\n",
            positions[index(&disc["node"])],
            number(&disc["m"]),
            number(&disc["Id"]),
            number(&disc["Ip"])
        )
        .expect("writing to a string");
    }
    for (k, bearing) in list(&model["bearings"]).iter().enumerate() {
        let pair = |x: &str, y: &str| format!("[[{:?}, 0.0], [0.0, {:?}]]", number(&bearing[x]), number(&bearing[y]));
        write!(
            text,
            "[rotor.bearings.bearing{k}]\nposition = {:?}\nstiffness = {}\ndamping = {}\naxial_stiffness = 1e6\n",
            positions[index(&bearing["node"])],
            pair("kxx", "kyy"),
            pair("cxx", "cyy"),
        )
        .expect("writing to a string");
    }
    text + tail
}

fn at_rest(case: &Value, split: usize) -> Machine {
    machine(&text_of(case, split, "[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n"))
}

fn rotor_of(machine: &Machine) -> RotorMatrices {
    RotorMatrices::assemble(&machine.rotor)
}

fn worst(name: &str, error: f64) {
    println!("{name}: largest relative error {error:.2e}");
}

/// The references have the sign of the net sense, however small. Here, a mode whose nodes disagree is `mixed`, and a straight one `planar`.
fn assert_sense(whirl: Whirl, share: f64, sense: &str, what: &str) {
    let sign = if share > 0.0 { "forward" } else { "backward" };
    assert_eq!(sign, sense, "{what}: {share}");
    assert!(matches!(whirl, Whirl::Mixed | Whirl::Planar) || whirl.word() == sign, "{what}: {whirl:?}, {share}");
}

fn whirl_matches(name: &str, split: usize, key: &str, tolerance: f64) {
    let case = &reference()[name];
    let whirl = list(&case["whirl"]);
    let speeds: Vec<f64> = whirl.iter().map(|w| number(&w["speed_rad_s"])).collect();
    let machine = at_rest(case, split);
    let found = whirl_modes(&machine, &speeds).expect("solvable");
    let mut largest = (0.0_f64, 0.0_f64);
    for (entry, (speed, modes)) in whirl.iter().zip(&found) {
        let (frequencies, real) = (numbers(&entry[key]["wd_rad_s"]), numbers(&entry[key]["real_part"]));
        for (k, mode) in modes.iter().take(frequencies.len()).enumerate() {
            let what = format!("{name} whirl {k} at {speed} rad/s");
            largest.0 = largest.0.max(close(&what, mode.frequency, frequencies[k], tolerance));
            let ratio = -real[k] / real[k].hypot(frequencies[k]);
            // absolute: an undamped model has ratios of rounding size
            let error = (mode.damping_ratio - ratio).abs();
            assert!(error <= tolerance, "{what}: damping ratio {} {ratio}", mode.damping_ratio);
            largest.1 = largest.1.max(error);
            // at rest, an isotropic pair has no whirl sense
            if let (true, Some(sense)) = (*speed > 0.0, entry[key]["whirl"][k].as_str()) {
                assert_sense(mode.whirl, mode.share, sense, &what);
            }
        }
    }
    println!("{name} ({key}): frequency {:.2e} relative, damping ratio {:.2e} absolute", largest.0, largest.1);
}

#[test]
fn reference_rotors_have_the_published_whirl_frequencies_and_damping() {
    // two independent codes agree to 1e-12 (1.4e-10 without shear)
    whirl_matches(LALANNE, 1, "independent", 1e-9);
    whirl_matches(NELSON, 1, "independent", 1e-9);
    whirl_matches(NELSON_NO_SHEAR, 1, "independent", 1e-8);
}

#[test]
fn reference_rotors_with_four_times_the_elements_have_the_published_frequencies() {
    whirl_matches(LALANNE, 4, "independent_mesh_x4", 1e-8);
    whirl_matches(NELSON, 4, "independent_mesh_x4", 1e-8);
    whirl_matches(NELSON_NO_SHEAR, 4, "independent_mesh_x4", 1e-8);
}

#[test]
fn an_anisotropic_rotor_at_rest_whirls_in_planes() {
    let found = whirl_modes(&at_rest(&reference()[LALANNE], 1), &[0.0]).expect("solvable");
    assert!(found[0].1.iter().take(8).all(|mode| mode.whirl == Whirl::Planar));
}

fn criticals_match(name: &str, tolerance: f64) {
    let case = &reference()[name];
    let found: ModesReport = report(&at_rest(case, 1), &[]).expect("solvable");
    let mut largest = 0.0_f64;
    for (k, entry) in list(&case["critical_speeds_synchronous"]).iter().enumerate() {
        let ours = found.critical_speeds.get(k).unwrap_or_else(|| panic!("{name} has critical speed {k}"));
        largest = largest.max(close(&format!("{name} critical {k}"), ours.speed, number(&entry["rad_s"]), tolerance));
        let sense = entry["whirl"].as_str().expect("a sense");
        assert_sense(ours.whirl, ours.share, sense, &format!("{name} critical {k}"));
        assert!((ours.damping_ratio - number(&entry["damping_ratio"])).abs() < tolerance);
    }
    worst(&format!("{name} critical speeds"), largest);
}

#[test]
fn reference_rotors_have_the_published_critical_speeds() {
    criticals_match(LALANNE, 1e-8);
    criticals_match(NELSON, 1e-8);
    criticals_match(NELSON_NO_SHEAR, 1e-8);
}

#[test]
fn reference_rotors_have_the_published_totals_and_torsional_frequencies() {
    for name in [LALANNE, NELSON, NELSON_NO_SHEAR] {
        let case = &reference()[name];
        let machine = at_rest(case, 1);
        let rotor = rotor_of(&machine);
        let mut field = vec![0.0; rotor.lateral_size()];
        (0..rotor.nodes).for_each(|node| field[rotor.u(node)] = 1.0);
        let field = Vector::from_vec(field);
        let mass = field.dot(&(&rotor.mass * &field));
        close(name, mass, number(&case["totals"]["mass"]), 1e-12);
        close(name, rotor.axial_mass.sum(), number(&case["totals"]["mass"]), 1e-12);
        close(name, rotor.torsional_mass.sum(), number(&case["totals"]["polar_inertia_about_spin_axis"]), 1e-12);
        let found = report(&machine, &[]).expect("solvable");
        let mut largest = 0.0_f64;
        for (ours, reference) in found.torsion.iter().zip(numbers(&case["totals"]["torsional_free_free_freq_rad_s"])) {
            largest = largest.max(close(name, *ours, reference, 1e-9));
        }
        worst(&format!("{name} torsion"), largest);
    }
}

#[test]
fn reference_rotors_deflect_as_published_under_a_unit_load() {
    for name in [LALANNE, NELSON, NELSON_NO_SHEAR] {
        let case = &reference()[name];
        let rotor = rotor_of(&at_rest(case, 1));
        let mut load = Vector::zeros(rotor.lateral_size());
        load[rotor.v(index(&case["static_unit_load_y"]["load_node"]))] = 1.0;
        let x = solve(&rotor.stiffness, &load).expect("carried by its bearings");
        let deflections = numbers(&case["static_unit_load_y"]["uy_per_node"]);
        let scale = deflections.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
        let mut largest = 0.0_f64;
        for (node, reference) in deflections.iter().enumerate() {
            let error = (x[rotor.v(node)] - reference).abs() / scale;
            // tolerance for rounding: the condition number of the Nelson-McVaugh stiffness is 1e10
            assert!(error < 1e-8, "{name} node {node}: {} {reference}", x[rotor.v(node)]);
            largest = largest.max(error);
        }
        worst(&format!("{name} static deflection"), largest);
    }
}

/// Complex amplitudes (u, v) per node of the steady response, `x(t) = Re(X e^{iWt})`, as the transient starts: with an unbalance present before the
/// start, at a radius so large that its mass has no effect.
fn steady(case: &Value, speed: f64) -> (RotorMatrices, Vec<[f64; 2]>) {
    let positions = numbers(&case["model"]["node_positions"]);
    let unbalance = &case["unbalance"];
    let radius = 1e6;
    let text = text_of(
        case,
        1,
        &format!(
            "[rotor.unbalances.residual]\nposition = {:?}\nmass = {:e}\nradius = {radius:e}\npresent = \"before\"\n\
             [rotor]\ninitial_speed = {speed:?}\n[rotor.speed_law]\nacceleration = 0\n\
             [run]\nengine = \"full\"\nend_time = 1e-9\nstep = 1e-9\n",
            positions[index(&unbalance["node"])],
            number(&unbalance["me_kg_m"]) / radius,
        ),
    );
    let machine = machine(&text);
    let rotor = rotor_of(&machine);
    let mut amplitudes = Vec::new();
    run_seen(
        machine,
        &mut Every(|frame| {
            if frame.time == 0.0 {
                amplitudes = frame.displacement.iter().zip(frame.velocity).map(|(x, v)| [*x, -v / speed]).collect();
            }
        }),
    );
    (rotor, amplitudes)
}

#[test]
fn reference_rotors_respond_to_unbalance_as_published() {
    // without shear, an element of 5 mm is 1e6 times as stiff as the rotor, and rounding of its stiffness changes the response close to an undamped
    // critical speed: the two codes of the reference differ by 2.6e-8 there, and u differs from v by 6e-8, though the rotor is isotropic
    for (name, tolerance) in [(LALANNE, 1e-8), (NELSON, 1e-8), (NELSON_NO_SHEAR, 1e-7)] {
        let case = &reference()[name];
        let mut largest = 0.0_f64;
        for entry in list(&case["unbalance"]["response"]) {
            let speed = number(&entry["speed_rad_s"]);
            let (rotor, x) = steady(case, speed);
            for (node, values) in entry["nodes"].as_object().expect("a table") {
                let node: usize = node.parse().expect("a node number");
                for (dof, axis) in [(rotor.u(node), "x"), (rotor.v(node), "y")] {
                    let reference = number(&values[format!("u{axis}_abs")]);
                    let [re, im] = x[dof];
                    let what = format!("{name} u{axis} of node {node} at {speed} rad/s");
                    largest = largest.max(close(&what, re.hypot(im), reference, tolerance));
                    let phase = number(&values[format!("u{axis}_phase_rad")]);
                    let turn = (im.atan2(re) - phase).sin().abs();
                    assert!((im.atan2(re) - phase).cos() > 0.0 && turn < 1e-7, "{what}: phase {turn}");
                }
            }
        }
        worst(&format!("{name} unbalance response"), largest);
    }
}

#[test]
fn sdll124_frequencies_match_within_three_per_mille() {
    // ROTORINSA verification set, SDLL124: [Hz] at rest and at 30000 rpm, 0.3 %
    let case = &reference()[LALANNE];
    let top = 30_000.0 * std::f64::consts::PI / 30.0;
    let found = whirl_modes(&at_rest(case, 1), &[0.0, top]).expect("solvable");
    let published = [[60.6148, 63.026, 169.49, 185.563], [54.112, 68.122, 154.65, 196.0]];
    let mut largest = 0.0_f64;
    for ((_, modes), frequencies) in found.iter().zip(published) {
        for (mode, hz) in modes.iter().zip(frequencies) {
            largest = largest.max(close("SDLL124", mode.frequency / (2.0 * std::f64::consts::PI), hz, 3e-3));
        }
    }
    worst("SDLL124", largest);
}

/// The model of SDLL126: that of SDLL124 with ten times its bearing damping. SDLL124 (Code_Aster manual V2.02.124, section
/// 1.2) has K = 7e7 and C = 7e2 on one axis, K = 5e7 and C = 5e2 on the other: 7000 N s/m belong to the stiff axis, here y.
fn sdll126_case() -> Value {
    let mut case = reference()[LALANNE].clone();
    for bearing in case["model"]["bearings"].as_array_mut().expect("a list") {
        bearing["cxx"] = 5000.0.into();
        bearing["cyy"] = 7000.0.into();
    }
    case["unbalance"]["me_kg_m"] = 0.05.into();
    case
}

/// ROTORINSA verification set, SDLL126: amplitudes at disc 2 \[m\], transient, steady part; 0.1 %.
const SDLL126: [f64; 2] = [5.721e-4, 7.023e-4];

#[test]
fn sdll126_steady_state_has_the_published_amplitudes() {
    let case = sdll126_case();
    let (rotor, x) = steady(&case, 15_000.0 * std::f64::consts::PI / 30.0);
    for (dof, published) in [rotor.u(5), rotor.v(5)].into_iter().zip(SDLL126) {
        worst("SDLL126 steady", close("SDLL126", x[dof][0].hypot(x[dof][1]), published, 1e-3));
    }
}

#[test]
fn sdll126_transient_reaches_the_published_amplitudes() {
    // released from rest at constant speed with the reduced engine; after 8 s the initial transient has decayed to 1e-5
    let case = sdll126_case();
    let disc = index(&case["model"]["discs"][1]["node"]);
    let text = text_of(
        &case,
        1,
        &format!(
            "[rotor.unbalances.release]\nposition = {:?}\nmass = 5e-8\nradius = 1e6\n\
             [rotor]\ninitial_speed = \"15000 rpm\"\n[rotor.speed_law]\nacceleration = 0\n\
             [run]\nend_time = 8\nstep = 2e-5\n",
            numbers(&case["model"]["node_positions"])[disc],
        ),
    );
    let machine = machine(&text);
    let rotor = rotor_of(&machine);
    let mut peaks = [0.0_f64; 2];
    run_seen(
        machine,
        &mut Every(|frame| {
            if frame.time > 7.9 {
                for (peak, dof) in peaks.iter_mut().zip([rotor.u(disc), rotor.v(disc)]) {
                    *peak = peak.max(frame.displacement[dof].abs());
                }
            }
        }),
    );
    for (peak, published) in peaks.into_iter().zip(SDLL126) {
        worst("SDLL126 transient", close("SDLL126", peak, published, 1e-3));
    }
}

/// Frequencies of the spinning simply supported beam, computed without the supported displacements: no bearing is infinitely stiff.
fn supported_beam(elements: usize, spin: f64, count: usize) -> Vec<f64> {
    let model = &reference()["ss_timoshenko_beam_closed_form"]["model"];
    let length = number(&model["L"]);
    let text = format!(
        "schema = 1\nname = \"beam\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 0\n[rotor.material]\n\
         young_modulus = {:e}\npoisson_ratio = {}\ndensity = {}\nshear_coefficient = \"cowper\"\n\
         [[rotor.shaft]]\nlength = {length}\nelements = {elements}\ndiameter = {}\n\
         [rotor.bearings.a]\nposition = 0\nstiffness = 1\naxial_stiffness = 1\n\
         [rotor.bearings.b]\nposition = {length}\nstiffness = 1\n",
        number(&model["E"]),
        number(&model["nu"]),
        number(&model["rho"]),
        number(&model["od"]),
    );
    let rotor = rotor_of(&machine(&text));
    let fixed = [rotor.u(0), rotor.v(0), rotor.u(elements), rotor.v(elements)];
    let free: Vec<usize> = (0..rotor.lateral_size()).filter(|dof| !fixed.contains(dof)).collect();
    let part = |a: &Matrix| Matrix::from_fn(free.len(), free.len(), |i, j| a[(free[i], free[j])]);
    let (m, k, g) = (part(&rotor.mass), part(&rotor.stiffness), part(&rotor.gyroscopic()));
    let modes = quadratic_modes(&m, &(g * spin), &k, "the beam").expect("solvable");
    let mut frequencies: Vec<f64> = modes.values.iter().map(|[_, im]| *im).filter(|im| *im > 0.0).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.truncate(count);
    frequencies
}

#[test]
fn spinning_beam_on_each_mesh_matches_the_independent_finite_elements() {
    let case = &reference()["ss_timoshenko_beam_closed_form"];
    let mut largest = 0.0_f64;
    for entry in list(&case["fe_convergence_independent"]) {
        let published = numbers(&entry["wd_rad_s"]);
        let ours = supported_beam(index(&entry["n_elements"]), number(&entry["spin_rad_s"]), published.len());
        for (ours, published) in ours.iter().zip(published) {
            largest = largest.max(close("spinning beam", *ours, published, 1e-8));
        }
    }
    worst("spinning beam, finite elements", largest);
}

#[test]
fn spinning_beam_converges_to_the_closed_form() {
    let case = &reference()["ss_timoshenko_beam_closed_form"];
    for entry in list(&case["cases"]) {
        let spin = number(&entry["spin_rad_s"]);
        let mut exact: Vec<f64> = list(&entry["modes"])
            .iter()
            .take(4)
            .flat_map(|mode| [number(&mode["bending_backward_rad_s"]), number(&mode["bending_forward_rad_s"])])
            .collect();
        exact.sort_by(f64::total_cmp);
        let error = |elements: usize| {
            let ours = supported_beam(elements, spin, exact.len());
            ours.iter().zip(&exact).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(20), error(40));
        let order = (coarse / fine).log2();
        println!("spinning beam, {spin} rad/s: error {coarse:.2e} (20), {fine:.2e} (40), order {order:.3}");
        // four modes, 40 elements: 1e-3; order 2
        assert!(fine < 1e-3 && (order - 2.0).abs() < 0.1);
        // without the term of order 2, the remaining error is of order 4
        let extrapolated = |elements: usize| {
            let (a, b) = (supported_beam(elements, spin, exact.len()), supported_beam(2 * elements, spin, exact.len()));
            (0..exact.len()).map(|k| ((b[k] + (b[k] - a[k]) / 3.0) / exact[k] - 1.0).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (extrapolated(10), extrapolated(20));
        let order = (coarse / fine).log2();
        println!("  extrapolated: {coarse:.2e} (10, 20), {fine:.2e} (20, 40), order {order:.2}");
        assert!(order > 3.5);
    }
}
