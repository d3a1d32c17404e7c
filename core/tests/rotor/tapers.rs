//! Tapered sections, layers and all kinds of bearings of a rotor file, against ROSS.
//!
//! The references are from ROSS 2.3.0 (`run_modal(speed, num_modes=40, sparse=False)`), for the rotor that `data/ross_rotor.py` creates. Torsional
//! modes are not compared: for a taper, ROSS takes the mean of the polar moments at both ends, this program the flexibility.

use crate::common::{Row, close, machine, machine_with, run};
use bladeoff_core::modal::whirl_modes;
use bladeoff_core::rotor::RotorMatrices;
use bladeoff_core::stress::ShaftStresses;
use bladeoff_model::machine::{Machine, RotorKind, Shaft};
use bladeoff_numerics::linalg::{Matrix, Vector, solve};
use std::f64::consts::PI;

const ROTOR: &str = include_str!("../data/ross_rotor.machine.toml");

/// Speed \[rad/s\], damped frequencies \[rad/s\] and logarithmic decrements of the lateral modes.
const ROSS: [(f64, [[f64; 2]; 12]); 3] = [
    (
        0.0,
        [
            [710.0863683639983, 7.41019057293669e-01],
            [757.7268994049592, 6.74238739336133e-01],
            [1848.5766559818253, 2.26251679421858],
            [2070.8554401385086, 2.21703139603974],
            [3672.208506220725, 4.14147696116362e-01],
            [4097.511980036801, 4.36447380745552e-01],
            [5748.600737766476, 1.52945541090965],
            [5953.861501742273, 2.24579284018047],
            [13224.727096671197, 5.51152141261609e-01],
            [13530.99296150075, 5.81816069158449e-01],
            [14912.426202715742, 2.17737816369407],
            [16385.33812883913, 1.19778735315683],
        ],
    ),
    (
        200.0,
        [
            [725.4341871646624, 5.25499268085672e-01],
            [770.8061978925634, 4.93473248403478e-01],
            [1812.5452229656646, 1.68172478253168],
            [2044.149484390364, 1.72254568633554],
            [3654.075753965496, 3.75876944333775e-01],
            [4085.9929114646334, 4.12792638176055e-01],
            [5535.184289686043, 1.74406553415504],
            [5728.163779869423, 2.45442153556769],
            [6813.016947742614, 4.88987829472167],
            [7465.512920915156, 4.41394432328375],
            [13579.093740281769, 6.35772059062740e-01],
            [13956.42992662837, 6.45016328593661e-01],
        ],
    ),
    (
        500.0,
        [
            [742.2054197141997, 4.52066079787582e-01],
            [776.29098936474, 4.24847444505931e-01],
            [1848.4814073558337, 1.39040834339003],
            [2055.2234774292574, 1.50220978115735],
            [3653.062441369329, 3.44320714808962e-01],
            [4082.7909977735767, 3.95957016513522e-01],
            [5311.715908041581, 1.71238908290701],
            [5627.11612231522, 2.35012093071265],
            [8347.447661479593, 2.59333654145281],
            [8509.232965312794, 2.56383880275325],
            [13929.363156762007, 6.16460988768400e-01],
            [14314.139791605698, 6.18984728351955e-01],
        ],
    ),
];

/// Mass of the rotor without its pedestal \[kg\].
const MASS: f64 = 113.20032465049407;

fn shaft(machine: &Machine) -> &Shaft {
    match &machine.rotor.kind {
        RotorKind::Shaft(shaft) => shaft,
        RotorKind::PointMass(_) => unreachable!("a shaft"),
    }
}

#[test]
fn a_rotor_with_tapers_and_layers_whirls_as_in_ross() {
    let machine = machine(ROTOR);
    let found = whirl_modes(&machine, &ROSS.map(|(speed, _)| speed)).expect("solvable");
    let mut largest = [0.0_f64; 2];
    for ((speed, expected), (_, modes)) in ROSS.iter().zip(&found) {
        for (k, ([frequency, decrement], mode)) in expected.iter().zip(modes).enumerate() {
            let what = format!("mode {k} at {speed} rad/s");
            largest[0] = largest[0].max(close(&what, mode.frequency, *frequency, 1e-9));
            let zeta = mode.damping_ratio;
            let ours = 2.0 * PI * zeta / (1.0 - zeta * zeta).sqrt();
            largest[1] = largest[1].max(close(&format!("decrement of {what}"), ours, *decrement, 1e-8));
        }
    }
    println!("ROSS: frequency {:.1e}, logarithmic decrement {:.1e} relative", largest[0], largest[1]);
    let rotor = RotorMatrices::assemble(&machine.rotor);
    close("mass", rotor.axial_mass.sum(), MASS, 1e-12);
}

/// Machine of one conical section with an almost clamping pair of bearings; `elements` of the section.
fn cone(elements: usize, ends: &str) -> Machine {
    machine(&format!(
        "schema = 1\nname = \"cone\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 0\n[rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = {elements}\n{ends}\n\
         [rotor.bearings.a]\nposition = 0\nstiffness = 1e8\naxial_stiffness = 1e6\n[rotor.bearings.b]\nposition = 1\nstiffness = 1e8\n"
    ))
}

const HOLLOW: &str = "diameter = 0.2\ninner_diameter = 0.02\nend_diameter = 0.1\nend_inner_diameter = 0.06";

/// Mass, centre of mass and inertias of a hollow frustum are exact with one element; a split or a finer section has the same.
#[test]
fn a_hollow_cone_has_the_mass_and_inertia_of_a_frustum() {
    let integral = |power: i32, of: fn(f64) -> f64| {
        // polynomials up to degree 4: exact with many Simpson intervals to rounding
        let at = |z: f64| of(z) * ((0.2 - 0.1 * z).powi(power) - (0.02 + 0.04 * z).powi(power));
        let h = 1e-3;
        (0..1000)
            .map(|i| h / 6.0 * (at(h * f64::from(i)) + 4.0 * at(h * (f64::from(i) + 0.5)) + at(h * f64::from(i + 1))))
            .sum::<f64>()
    };
    let mass = 7800.0 * PI / 4.0 * integral(2, |_| 1.0);
    let moment = 7800.0 * PI / 4.0 * integral(2, |z| z);
    let polar = 7800.0 * PI / 32.0 * integral(4, |_| 1.0);
    let about_end = 7800.0 * PI / 4.0 * integral(2, |z| z * z) + 0.5 * polar;
    for elements in [1, 3] {
        let rotor = RotorMatrices::assemble(&cone(elements, HOLLOW).rotor);
        let (mut translation, mut rotation) = (vec![0.0; rotor.lateral_size()], vec![0.0; rotor.lateral_size()]);
        for node in 0..rotor.nodes {
            translation[rotor.u(node)] = 1.0;
            rotation[rotor.u(node)] = node as f64 / elements as f64;
            rotation[rotor.u(node) + 1] = 1.0;
        }
        let (translation, rotation) = (Vector::from_vec(translation), Vector::from_vec(rotation));
        close("mass", translation.dot(&(&rotor.mass * &translation)), mass, 1e-12);
        close("moment", translation.dot(&(&rotor.mass * &rotation)), moment, 1e-12);
        close("inertia", rotation.dot(&(&rotor.mass * &rotation)), about_end, 1e-12);
        close("polar inertia", rotor.torsional_mass.sum(), polar, 1e-12);
        close("axial mass", rotor.axial_mass.sum(), mass, 1e-12);
    }
}

/// Without a load between its ends, a cone has the textbook moment at every node, whatever its number of elements.
#[test]
fn moments_of_a_cone_are_in_equilibrium() {
    let machine = cone(3, HOLLOW);
    let rotor = RotorMatrices::assemble(&machine.rotor);
    let stresses = ShaftStresses::new(shaft(&machine));
    let clamped = [rotor.u(0), rotor.u(0) + 1, rotor.v(0), rotor.v(0) + 1];
    let mut stiffness = rotor.stiffness.clone();
    clamped.iter().for_each(|&place| stiffness[(place, place)] += 1e16);
    let end = rotor.u(3);
    // without the spring of its bearing
    for axis in 0..2 {
        let place = rotor.plane_places(3)[axis];
        stiffness[(place, place)] -= 1e8;
    }
    let mut load = Vector::zeros(rotor.lateral_size());
    load[end] = 1000.0;
    let x = solve(&stiffness, &load).expect("clamped");
    for element in 0..3 {
        let [left, right] = stresses.bending_moments(element, x.as_slice()).map(|moment| moment[0].hypot(moment[1]));
        for (moment, z) in [(left, element as f64 / 3.0), (right, (element + 1) as f64 / 3.0)] {
            assert!((moment - 1000.0 * (1.0 - z)).abs() < 1e-4, "element {element} at {z}: {moment}");
        }
    }
    let moduli = stresses.moduli(0).bending;
    close("smallest modulus", moduli, PI * (0.1f64.powi(4) - 0.06f64.powi(4)) / (32.0 * 0.1), 1e-12);
    let mut torque = vec![0.0; 4];
    torque[3] = 500.0;
    let torsional_stiffness =
        &rotor.torsional_stiffness + Matrix::from_fn(4, 4, |i, j| if i + j == 0 { 1e16 } else { 0.0 });
    let torsion = solve(&torsional_stiffness, &Vector::from_vec(torque)).expect("clamped");
    close("torque", stresses.largest(0, x.as_slice(), torsion.as_slice()).torsion, 500.0, 1e-9);
}

/// One element of a solid cone has the static torsion and elongation of the textbook.
#[test]
fn a_cone_twists_and_stretches_by_its_exact_flexibility() {
    let rotor = RotorMatrices::assemble(&cone(1, "diameter = 0.2\nend_diameter = 0.1").rotor);
    // D = D1 + (D2 - D1) z/L: int dz/D^4 = L (D2^-3 - D1^-3)/(3 (D1 - D2)), int dz/D^2 = L/(D1 D2)
    let (large, small) = (0.2_f64, 0.1_f64);
    let fourth = (small.powi(-3) - large.powi(-3)) / (3.0 * (large - small));
    let torsion = 2e11 / 2.6 * PI / 32.0 / fourth;
    let traction = 2e11 * PI / 4.0 * large * small;
    let errors = [
        close("torsion", rotor.torsional_stiffness[(0, 0)], torsion, 1e-5),
        close("traction", -rotor.axial_stiffness[(0, 1)], traction, 1e-6),
    ];
    println!("cone, one element: torsion {:.1e}, traction {:.1e} relative", errors[0], errors[1]);
}

/// The frequencies of a cone converge with the square of the element length, because the shape functions are those of a cylinder.
#[test]
fn a_cone_converges_with_its_elements() {
    let first = |elements| whirl_modes(&cone(elements, HOLLOW), &[0.0]).expect("solvable")[0].1[0].frequency;
    let fine = first(64);
    let errors = [4, 8, 16].map(|elements| (first(elements) / fine - 1.0).abs());
    println!(
        "cone: error of the first frequency with 4, 8, 16 elements {:.1e}, {:.1e}, {:.1e}",
        errors[0], errors[1], errors[2]
    );
    assert!(errors[0] < 5e-3 && errors[1] < errors[0] / 2.5 && errors[2] < errors[1] / 3.0, "{errors:?}");
}

/// A section divided into parts of the same cone, by its keys or by a position inside, is the same cone.
#[test]
fn a_place_in_a_cone_cuts_it_where_it_stands() {
    let cut = machine(&format!(
        "{}[monitors.seal]\nposition = 0.25\ngap = 1e-3\n",
        "schema = 1\nname = \"cone\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 0\n[rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 2\ndiameter = 0.2\ninner_diameter = 0.02\nend_diameter = 0.1\nend_inner_diameter = 0.06\n\
         [rotor.bearings.a]\nposition = 0\nstiffness = 1e8\naxial_stiffness = 1e6\n[rotor.bearings.b]\nposition = 1\nstiffness = 1e8\n"
    ));
    let found: Vec<[f64; 4]> = shaft(&cut)
        .elements
        .iter()
        .map(|element| [element.diameter, element.inner_diameter, element.end_diameter, element.end_inner_diameter])
        .collect();
    let expected = [[0.2, 0.02, 0.175, 0.03], [0.175, 0.03, 0.15, 0.04], [0.15, 0.04, 0.1, 0.06]];
    assert_eq!(found.len(), 3);
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        close("diameter", *found, *expected, 1e-14);
    }
}

/// Two halves of a pipe wall, one inside the other, are equal to the pipe: a layer adds its stiffness and mass.
#[test]
fn a_pipe_in_a_pipe_is_a_thick_pipe() {
    let text = |inner: &str, layer: &str| {
        format!(
            "schema = 1\nname = \"pipe\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 0\n[rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\nshear_coefficient = \"none\"\n\
             [[rotor.shaft]]\nlength = 1.0\nelements = 4\ndiameter = 0.2\ninner_diameter = 0.1\n\
             [[rotor.shaft]]\nlength = 1.0\nelements = 4\n{inner}\n{layer}\
             [rotor.bearings.a]\nposition = 0\nstiffness = 1e8\naxial_stiffness = 1e6\n[rotor.bearings.b]\nposition = 2\nstiffness = 1e8\n"
        )
    };
    let layer = "[rotor.layers.wall]\nposition = 1\nlength = 1\ndiameter = 0.2\ninner_diameter = 0.15\n";
    let whole = machine(&text("diameter = 0.2\ninner_diameter = 0.1", ""));
    let layered = machine(&text("diameter = 0.15\ninner_diameter = 0.1", layer));
    let [whole_modes, layered_modes] =
        [&whole, &layered].map(|machine| whirl_modes(machine, &[300.0]).expect("solvable").remove(0).1);
    for (expected, found) in whole_modes.iter().zip(&layered_modes) {
        close("frequency", found.frequency, expected.frequency, 1e-9);
    }
    let [whole, layered] = [&whole, &layered].map(|machine| RotorMatrices::assemble(&machine.rotor));
    for (whole, layered) in [
        (whole.torsional_stiffness, layered.torsional_stiffness),
        (whole.axial_mass, layered.axial_mass),
        (whole.torsional_mass, layered.torsional_mass),
    ] {
        assert!((&whole - &layered).amax() < 1e-12 * whole.amax());
    }
}

/// A coast-down of the rotor after an unbalance, in all degrees of freedom.
fn coast_down(engine: &str) -> Row {
    let step = if engine == "exponential" { "" } else { "step = 1e-6\n" };
    let of_run = format!("end_time = 0.2\n{step}rotor_modes = 30\ntorsional_modes = 6");
    let text = ROTOR.replacen("end_time = 10.0", &of_run, 1)
        + "[rotor.unbalances.blade]\nposition = 0.4\nmass = 0.02\nradius = 0.2\n[braking]\nquadratic = 0.002\n[rotor.damping]\ntorsional = 5e-6\n";
    run(machine_with(&text, &[("run.engine", engine), ("rotor.gravity[1]", "-9.81")]))
}

/// Tapers, layers, a table and a pedestal give the same loads, moments and stresses on all engines, and each closes its energy balance. Torsional moments of
/// `exponential` are not compared: between contacts its steps are longer than the periods of these torsional modes (1 ms to 80 us).
#[test]
fn a_rotor_with_tapers_and_layers_coasts_down_the_same_on_all_engines() {
    let [full, reduced, exponential] = ["full", "reduced", "exponential"].map(coast_down);
    for row in [&full, &reduced, &exponential] {
        assert_eq!(row.outcome.status.word(), "ok");
        assert!(row.value("energy_error") < 1e-8, "{}", row.value("energy_error"));
    }
    let (mut compared, mut largest) = (0, [0.0_f64; 3]);
    for column in bladeoff_core::record::columns(&full.machine) {
        let is_load = ["max_bearing", "max_pedestal", "max_bending"].iter().any(|name| column.name.starts_with(name));
        let is_torsion = column.name.starts_with("max_torsion");
        let Some(expected) = full.get(&column.name).filter(|value| *value > 0.0) else { continue };
        if !(is_load || is_torsion) || column.name.contains("_at_") {
            continue;
        }
        compared += 1;
        let error = |row: &Row| (row.value(&column.name) / expected - 1.0).abs();
        if is_load {
            (largest[0], largest[1]) = (largest[0].max(error(&reduced)), largest[1].max(error(&exponential)));
        } else {
            largest[2] = largest[2].max(error(&reduced));
        }
    }
    println!(
        "{compared} columns against full: loads and bending reduced {:.1e}, exponential {:.1e}; torsion reduced {:.1e}",
        largest[0], largest[1], largest[2]
    );
    assert_eq!(compared, 25);
    assert!(largest[0] < 1e-9 && largest[1] < 1e-4 && largest[2] < 1e-6, "{largest:?}");
}
