//! The stator ring: free-ring frequencies, the pinched ring, rigid-body motions, convergence.

use crate::common::{close, machine};
use bladeoff_core::modal::report;
use bladeoff_core::stator::RingMatrices;
use bladeoff_model::machine::{DiaphragmKind, FlexibleStator};
use bladeoff_numerics::linalg::{Matrix, Vector, mul_tn, symmetric_generalised};
use std::f64::consts::PI;

const YOUNG: f64 = 1.85e11;
const DENSITY: f64 = 7800.0;
const RADIUS: f64 = 0.369;
const WIDTH: f64 = 0.05;

/// The free ring of the validation cases, as a machine file.
fn text(thickness: f64, elements: usize, blades: &str) -> String {
    format!(
        "schema = 1\nname = \"ring\"\n[run]\nend_time = 1\n\
         [rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\ninitial_speed = 1\n\
         [rotor.bearings.spring]\nstiffness = 1\n\
         [diaphragms.ring.material]\nyoung_modulus = {YOUNG:e}\npoisson_ratio = 0.3\ndensity = {DENSITY}\n\
         [diaphragms.ring.ring]\nmean_radius = {RADIUS}\nthickness = {thickness:e}\nwidth = {WIDTH}\nelements = {elements}\n\
         {blades}\
         [diaphragms.ring.contact]\nrotor_radius = 0.36\ngap = 0.009\nfriction = 0.1\n"
    )
}

fn matrices(thickness: f64, elements: usize) -> RingMatrices {
    match &machine(&text(thickness, elements, "")).diaphragms[0].kind {
        DiaphragmKind::Flexible(stator) => RingMatrices::assemble(stator),
        other => panic!("{other:?}"),
    }
}

/// Frequencies \[Hz\] of the elastic modes n = 2.. (each the mean of its pair, whose difference must vanish).
fn free_ring(thickness: f64, elements: usize, modes: usize) -> Vec<f64> {
    let found = report(&machine(&text(thickness, elements, "")), &[]).expect("solvable");
    let (_, ring) = &found.rings[0];
    // below the first elastic mode: two translations and the rotation
    ring[3..3 + 2 * modes]
        .chunks_exact(2)
        .enumerate()
        .map(|(k, pair)| {
            assert_eq!([pair[0].nodal_diameters, pair[1].nodal_diameters], [k + 2; 2]);
            assert!((pair[0].frequency / pair[1].frequency - 1.0).abs() < 1e-7, "{pair:?}");
            0.5 * (pair[0].frequency + pair[1].frequency) / (2.0 * PI)
        })
        .collect()
}

/// Thin-ring theory: `omega_n^2 = E I n^2 (n^2-1)^2 / (rho S R^4 (n^2+1))` \[Hz\].
fn thin_ring(thickness: f64, n: f64) -> f64 {
    let ratio = YOUNG * thickness * thickness / (12.0 * DENSITY);
    n * (n * n - 1.0) / (2.0 * PI * RADIUS * RADIUS) * (ratio / (n * n + 1.0)).sqrt()
}

#[test]
fn free_ring_has_the_frequencies_of_its_theory() {
    // validation data: with membrane and rotary inertia as in (7)-(8)
    let exact = [211.331, 595.700, 1136.696, 1826.988];
    let (coarse, fine) = (free_ring(0.048, 48, 4), free_ring(0.048, 96, 4));
    for (k, exact) in exact.iter().enumerate() {
        // order 4 in the element (next test): the remaining error of 96 elements is a fifteenth of the last difference
        let left = (coarse[k] - fine[k]) / 15.0;
        let ours = fine[k] - left;
        println!(
            "free ring f{}: {:.4} Hz, mesh error {left:.1e}, extrapolated {ours:.4} against {exact}",
            k + 2,
            fine[k]
        );
        // half a unit of the last published digit
        assert!((ours - exact).abs() < 0.5e-3, "f{}: {ours} Hz against {exact}", k + 2);
    }
}

/// Frequency of harmonic n by the Rayleigh quotient of (7)-(8) on `u = a sin, v = b cos`: closed form to rounding \[Hz\].
fn harmonic(thickness: f64, n: f64) -> f64 {
    let (s, i) = (WIDTH * thickness, WIDTH * thickness.powi(3) / 12.0);
    let (r2, r4) = (RADIUS * RADIUS, RADIUS.powi(4));
    // strain (b + n a)/R, curvature b (1 - n^2)/R^2, rotation (a + n b)/R; integrals of sin^2 and cos^2 are equal
    let k = [[s * n * n / r2, s * n / r2], [s * n / r2, s / r2 + i * (1.0 - n * n).powi(2) / r4]]
        .map(|r| r.map(|x| x * YOUNG));
    let m = [[s + i / r2, i * n / r2], [i * n / r2, s + i * n * n / r2]].map(|r| r.map(|x| x * DENSITY));
    let a = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let b = k[0][0] * m[1][1] + k[1][1] * m[0][0] - k[0][1] * m[1][0] - k[1][0] * m[0][1];
    let c = k[0][0] * k[1][1] - k[0][1] * k[1][0];
    (2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())).sqrt() / (2.0 * PI)
}

#[test]
fn free_ring_closed_form_gives_the_published_numbers_and_the_mesh_converges_to_it() {
    for (n, published) in [(2.0, 211.331), (3.0, 595.700), (4.0, 1136.696), (5.0, 1826.988)] {
        close("closed form", harmonic(0.048, n), published, 1e-6);
    }
    let error = |elements: usize| (free_ring(0.048, elements, 3)[2] / harmonic(0.048, 4.0) - 1.0).abs();
    let errors = [error(24), error(48), error(96)];
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    println!("free ring f4: errors {errors:?} (24, 48, 96 elements), orders {orders:?}");
    // cubic u against cubic v: u_s is one degree lower than v, the membrane locks with order 4
    assert!(orders.iter().all(|order| (order - 4.0).abs() < 0.1));
}

#[test]
fn free_ring_tends_to_thin_ring_theory_with_its_thickness() {
    for (n, published) in [(2.0, 211.65), (3.0, 598.64), (4.0, 1147.85), (5.0, 1856.31)] {
        close("thin ring", thin_ring(0.048, n), published, 3e-5);
    }
    let error = |thickness: f64| -> Vec<f64> {
        let ours = free_ring(thickness, 96, 4);
        ours.iter().enumerate().map(|(k, f)| (f / thin_ring(thickness, k as f64 + 2.0) - 1.0).abs()).collect()
    };
    let (thick, half, thin) = (error(0.048), error(0.024), error(0.012));
    println!("free ring against thin-ring theory: {thick:?} {half:?} {thin:?}");
    for k in 0..4 {
        // the neglected terms are of order (thickness/R)^2
        for ratio in [thick[k] / half[k], half[k] / thin[k]] {
            assert!((3.8..4.2).contains(&ratio), "f{}: {ratio}", k + 2);
        }
    }
}

#[test]
fn pinched_ring_closes_and_opens_as_the_inextensional_theory_says() {
    // two opposite radial forces P; theory: 0.148779 and 0.136620 P R^3/(E I)
    let change = |thickness: f64, elements: usize| -> [f64; 2] {
        let ring = matrices(thickness, elements);
        // unsupported: translations and rotation are held by three soft springs that a balanced load does not stretch
        let mut stiffness = ring.stiffness.clone();
        let soft = 1e-6 * stiffness.diagonal().amin();
        for dof in [0, 4 * (elements / 4), 4 * (elements / 2)] {
            stiffness[(dof, dof)] += soft;
        }
        let mut load = Vector::zeros(ring.size());
        for node in [0, elements / 2] {
            load[4 * node + 2] = -1.0;
        }
        let x = nalgebra_solve(&stiffness, &load);
        let at = |node: usize| x[4 * node + 2];
        let unit = RADIUS.powi(3) / (YOUNG * WIDTH * thickness.powi(3) / 12.0);
        [-(at(0) + at(elements / 2)) / unit, (at(elements / 4) + at(3 * elements / 4)) / unit]
    };
    let theory = [0.148_779, 0.136_620];
    let error = |thickness: f64| {
        let ours = change(thickness, 96);
        [(ours[0] / theory[0] - 1.0).abs(), (ours[1] / theory[1] - 1.0).abs()]
    };
    let (thick, half, thin) = (error(0.02), error(0.01), error(0.0025));
    println!(
        "pinched ring: closing {:.1e} {:.1e} {:.1e}, opening {:.1e} {:.1e} {:.1e}",
        thick[0], half[0], thin[0], thick[1], half[1], thin[1]
    );
    for k in 0..2 {
        // extension is of order (thickness/R)^2; six published digits
        assert!(thin[k] < 1e-4, "{}", thin[k]);
        assert!(thick[k] / half[k] > 3.0);
    }
}

fn nalgebra_solve(a: &Matrix, b: &Vector) -> Vector {
    bladeoff_numerics::linalg::solve(a, b).expect("held")
}

#[test]
fn rigid_rotation_has_no_strain_energy_on_any_mesh() {
    for elements in [4, 5, 7, 12, 48, 96] {
        for thickness in [0.001, 0.048, 0.1] {
            let ring = matrices(thickness, elements);
            let mut field = Vector::zeros(ring.size());
            (0..elements).for_each(|node| field[4 * node] = 1.0);
            let energy = field.dot(&(&ring.stiffness * &field));
            // zero except for rounding of its terms
            assert!(energy.abs() < 1e-14 * ring.stiffness.amax() * elements as f64, "{elements}: {energy}");
            let mass = field.dot(&(&ring.mass * &field));
            let exact = DENSITY
                * 2.0
                * PI
                * RADIUS
                * WIDTH
                * thickness
                * (1.0 + thickness * thickness / (12.0 * RADIUS * RADIUS));
            close("inertia of the rotation", mass, exact, 1e-12);
        }
    }
}

/// Strain energy of a unit translation along X, over that of the same ring stretched by a unit radial displacement.
fn translation_energy(elements: usize) -> f64 {
    let ring = matrices(0.048, elements);
    let mut field = Vector::zeros(ring.size());
    let mut breathing = Vector::zeros(ring.size());
    for node in 0..elements {
        let (sin, cos) = (2.0 * PI * node as f64 / elements as f64).sin_cos();
        // v = cos alpha, u = -sin alpha, derivatives along s = R alpha
        field[4 * node] = -sin;
        field[4 * node + 1] = -cos / RADIUS;
        field[4 * node + 2] = cos;
        field[4 * node + 3] = -sin / RADIUS;
        breathing[4 * node + 2] = 1.0;
    }
    field.dot(&(&ring.stiffness * &field)) / breathing.dot(&(&ring.stiffness * &breathing))
}

#[test]
fn rigid_translation_costs_nothing_in_the_limit_with_its_order() {
    let energies: Vec<f64> = [8, 16, 32, 64, 128].into_iter().map(translation_energy).collect();
    let orders: Vec<f64> = energies.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("rigid translation: energies {energies:?}, orders {orders:.2?}");
    // bending: the second derivative of a cubic has an error of order 2, its energy of order 4; membrane: order 6, which dominates on coarse
    // meshes because the ring is stiffer along than across
    assert!(orders.iter().all(|order| (3.9..6.2).contains(order)));
    assert!((orders[3] - 4.0).abs() < 0.1 && energies[2] < 1e-8);
}

#[test]
fn free_ring_has_exactly_three_rigid_body_modes() {
    let ring = matrices(0.048, 24);
    let (values, shapes) = symmetric_generalised(&ring.stiffness, &ring.mass, "the ring").expect("solvable");
    assert!(values[..3].iter().all(|square| square.abs() < 1e-4 * values[3]), "{:?}", &values[..4]);
    assert!((mul_tn(&shapes, &(&ring.mass * &shapes)) - Matrix::identity(ring.size(), ring.size())).amax() < 1e-10);
}

#[test]
fn bladed_ring_is_held_and_keeps_the_symmetry_of_its_blades() {
    let blades = "[diaphragms.ring.blades]\ncount = 6\nlength = 0.25\nthickness = 0.02\nwidth = 0.05\nelements = 2\n";
    let machine = machine(&text(0.048, 48, blades));
    let DiaphragmKind::Flexible(stator) = &machine.diaphragms[0].kind else { panic!("a flexible diaphragm") };
    let ring = RingMatrices::assemble(stator);
    // uniform radial load: the same radial displacement at every blade foot, no rotation
    let mut load = Vector::zeros(ring.size());
    (0..48).for_each(|node| load[4 * node + 2] = 1.0);
    let x = nalgebra_solve(&ring.stiffness, &load);
    for blade in 1..6 {
        close("blade foot", x[4 * 8 * blade + 2], x[2], 1e-9);
    }
    assert!((0..48).map(|node| x[4 * node]).sum::<f64>().abs() < 1e-9 * x[2].abs());
    assert!(report(&machine, &[]).expect("solvable").rings[0].1[0].frequency > 10.0);
}

/// A ring of 400 elements, each shorter than its thickness, and a ring a thousand times smaller have the frequencies of the coarse or of the
/// large one: the eigenvalue solution is independent of the magnitude of the numbers.
#[test]
fn small_elements_and_small_rings_keep_their_frequencies() {
    let lab = |elements: usize| {
        let machine = crate::common::machine_with(
            &crate::common::study_machine("lab_rig"),
            &[("ring.elements", &elements.to_string())],
        );
        match &machine.diaphragms[0].kind {
            DiaphragmKind::Flexible(stator) => stator.clone(),
            other => panic!("{other:?}"),
        }
    };
    let squares = |stator: &FlexibleStator| {
        let ring = RingMatrices::assemble(stator);
        symmetric_generalised(&ring.stiffness, &ring.mass, "the ring").unwrap_or_else(|error| panic!("{error}")).0
    };
    let (coarsest, coarse, fine) = (squares(&lab(104)), squares(&lab(200)), squares(&lab(400)));
    assert!(fine[0] > 0.0 && fine.windows(2).all(|pair| pair[0] <= pair[1]));
    // finer meshes are softer, by less with each refinement
    let change = |a: &[f64], b: &[f64], k: usize| 1.0 - (b[k] / a[k]).sqrt();
    let mesh = (0..12).map(|k| {
        let (first, second) = (change(&coarsest, &coarse, k), change(&coarse, &fine, k));
        assert!(second > -1e-11 && second <= first + 1e-11, "mode {k}: {first:e} {second:e}");
        second
    });
    let mesh = mesh.fold(0.0, f64::max);
    assert!(mesh < 1e-4);
    let mut tiny = lab(200);
    let blades = tiny.blades.as_mut().expect("a ring on blades");
    for length in [
        &mut tiny.ring.mean_radius,
        &mut tiny.ring.thickness,
        &mut tiny.ring.width,
        &mut blades.length,
        &mut blades.thickness,
        &mut blades.width,
    ] {
        *length *= 1e-3;
    }
    let tiny = squares(&tiny);
    let scale = (0..800).map(|k| close("a mode", tiny[k].sqrt(), 1e3 * coarse[k].sqrt(), 1e-8)).fold(0.0, f64::max);
    println!("200 to 400 elements {mesh:.1e}, a thousandth of the size {scale:.1e}");
}
