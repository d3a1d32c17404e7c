//! Properties that follow from physical laws: structure of the matrices, rigid-body motions, conservation, the energy balance on both engines.
//! (The equations of motion against the Lagrangian: `core/src/engine/shaft_line/lagrangian_tests.rs`.)
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Every, Row, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::rotor::RotorMatrices;
use bladeoff_core::stator::RingMatrices;
use bladeoff_model::machine::{DiaphragmKind, Machine, UnbalanceKind};
use bladeoff_numerics::linalg::{Matrix, Vector};
use proptest::prelude::*;

/// A random machine: a shaft of random sections with a disc, two bearings, and a ring with blades.
fn random_machine() -> impl Strategy<Value = Machine> {
    let section = (0.05..0.6f64, 0.02..0.3f64, 0.0..0.9f64, 1usize..4, 0usize..3);
    let ring = (0.2..0.6f64, 0.01..0.08f64, 1usize..6, 1usize..4, 1usize..3);
    (prop::collection::vec(section, 1..5), ring, 0.5..500.0f64, 0.0..1.0f64).prop_map(|(sections, ring, mass, damping)| {
        let mut text = format!(
            "schema = 1\nname = \"random\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 10\n\
             [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
             [rotor.damping]\nmass_proportional = {damping}\nstiffness_proportional = 1e-5\n"
        );
        let mut end = 0.0;
        for (length, diameter, bore, elements, shear) in sections {
            let shear = ["\"cowper\"", "\"none\"", "0.85"][shear];
            text += &format!(
                "[[rotor.shaft]]\nlength = {length:?}\nelements = {elements}\ndiameter = {diameter:?}\n\
                 inner_diameter = {:?}\nshear_coefficient = {shear}\n",
                bore * diameter
            );
            end += length;
        }
        let (radius, thickness, blades, per_blade, pieces) = ring;
        let count = 2 + blades;
        text += &format!(
            "[rotor.discs.disc]\nposition = {end:?}\nmass = {mass:?}\ntransverse_inertia = {:?}\npolar_inertia = {:?}\n\
             [rotor.bearings.a]\nposition = 0\nstiffness = [[1e8, 1e6], [1e6, 2e8]]\ndamping = 1e4\naxial_stiffness = 1e6\n\
             [rotor.bearings.b]\nposition = {end:?}\nstiffness = 3e7\n\
             [diaphragms.d.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
             [diaphragms.d.ring]\nmean_radius = {radius:?}\nthickness = {thickness:?}\nwidth = 0.05\nelements = {}\n\
             [diaphragms.d.blades]\ncount = {count}\nlength = 0.2\nthickness = 0.01\nwidth = 0.04\nelements = {pieces}\n\
             [diaphragms.d.contact]\nposition = 0\nrotor_radius = {:?}\ngap = 1e-3\nfriction = 0.2\n",
            mass * 0.01,
            mass * 0.018,
            count * per_blade.max(2),
            radius - 1e-3
        );
        machine(&text)
    })
}

fn is_symmetric(a: &Matrix) -> bool {
    (a - a.transpose()).amax() <= 1e-12 * a.amax()
}

/// Smallest x^T A x over a fixed set of vectors, relative to |A| |x|^2.
fn least(a: &Matrix) -> f64 {
    let size = a.nrows();
    (1..40)
        .map(|k: u64| {
            let mut state = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let x = Vector::from_fn(size, |_, _| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
            });
            x.dot(&(a * &x)) / (a.amax() * x.dot(&x))
        })
        .fold(f64::MAX, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rotor_matrices_have_their_structure(m in random_machine()) {
        let rotor = RotorMatrices::assemble(&m.rotor);
        for a in [&rotor.mass, &rotor.stiffness, &rotor.torsional_mass, &rotor.torsional_stiffness, &rotor.axial_mass, &rotor.axial_stiffness] {
            prop_assert!(is_symmetric(a));
            prop_assert!(least(a) > -1e-14);
        }
        // positive definite: the Cholesky factor exists
        prop_assert!(bladeoff_numerics::linalg::spd_inverse(&rotor.mass).is_some());
        prop_assert!(bladeoff_numerics::linalg::spd_inverse(&rotor.stiffness).is_some());
        prop_assert!(bladeoff_numerics::linalg::spd_inverse(&rotor.torsional_mass).is_some());
        let g = rotor.gyroscopic();
        prop_assert!((&g + g.transpose()).amax() <= 1e-15 * g.amax() && g.amax() > 0.0);
        // damping takes energy
        prop_assert!(least(&(&rotor.damping + rotor.damping.transpose())) > -1e-14);
    }

    #[test]
    fn rigid_motions_of_the_shaft_cost_nothing_and_carry_its_inertia(m in random_machine(), tilt in -1.0..1.0f64) {
        let rotor = RotorMatrices::assemble(&m.rotor);
        let bladeoff_model::machine::RotorKind::Shaft(shaft) = &m.rotor.kind else { unreachable!("a shaft") };
        // without bearings
        let mut free = m.rotor.clone();
        free.bearings.clear();
        let k = RotorMatrices::assemble(&free).stiffness;
        let mut field = Vector::zeros(rotor.lateral_size());
        let mut along_v = field.clone();
        for (node, z) in shaft.nodes.iter().enumerate() {
            field[rotor.u(node)] = 1.0 + tilt * z;
            field[rotor.theta_v(node).expect("a shaft")] = tilt;
            along_v[rotor.v(node)] = 1.0 + tilt * z;
            along_v[rotor.theta_u(node).expect("a shaft")] = -tilt;
        }
        for field in [&field, &along_v] {
            prop_assert!((&k * field).amax() <= 1e-12 * k.amax(), "{}", (&k * field).amax() / k.amax());
        }
        // both planes have the same inertia, and a translation the whole mass
        let t = field.dot(&(&rotor.mass * &field));
        prop_assert!((along_v.dot(&(&rotor.mass * &along_v)) / t - 1.0).abs() < 1e-12);
        let ones = Vector::from_element(rotor.nodes, 1.0);
        prop_assert!((&rotor.torsional_stiffness * &ones).amax() <= 1e-14 * rotor.torsional_stiffness.amax());
        prop_assert!((rotor.spin_weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn ring_matrices_have_their_structure(m in random_machine()) {
        let DiaphragmKind::Flexible(stator) = &m.diaphragms[0].kind else { unreachable!("flexible") };
        let ring = RingMatrices::assemble(stator);
        prop_assert!(is_symmetric(&ring.mass) && is_symmetric(&ring.stiffness));
        prop_assert!(bladeoff_numerics::linalg::spd_inverse(&ring.mass).is_some());
        // the blades hold the ring
        prop_assert!(bladeoff_numerics::linalg::spd_inverse(&ring.stiffness).is_some());
        let mut free = stator.clone();
        free.blades = None;
        let free = RingMatrices::assemble(&free);
        prop_assert!(least(&free.stiffness) > -1e-14);
        let mut rotation = Vector::zeros(free.size());
        (0..free.nodes).for_each(|node| rotation[4 * node] = 1.0);
        prop_assert!((&free.stiffness * rotation).amax() < 1e-13 * free.stiffness.amax());
    }
}

/// Machines in which all terms are present.
fn everything(engine: &str, changes: &[(&str, &str)], end: f64) -> Machine {
    let text = study_machine("lab_rig")
        .replace("gravity = [0.0, 0.0]", "gravity = [2.0, -9.0]")
        .replace("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 3e5], [-2e5, 1.6e6]]")
        .replace("damping = \"600 N s/m\"", "damping = [[600.0, 50.0], [20.0, 500.0]]")
        .replace("offset = [\"0 mm\", \"0 mm\"]", "offset = [\"0.1 mm\", \"-0.05 mm\"]")
        .replace(
            "[rotor.damping]",
            "[rotor.unbalances.residual]\nposition = \"0.4 m\"\nmass = \"5 g\"\nradius = \"30 mm\"\nphase = \"70 deg\"\n\
             present = \"before\"\n\
             [rotor.unbalances.lost]\nposition = \"0.4 m\"\nmass = \"2 g\"\nradius = \"45 mm\"\nphase = \"200 deg\"\n\
             kind = \"lost\"\n[rotor.damping]",
        );
    let end = format!("{end:e}");
    let mut all = vec![("run.end_time", end.as_str()), ("run.engine", engine)];
    all.extend_from_slice(changes);
    machine_with(&text, &all)
}

fn balanced(what: &str, row: &Row) {
    let error = row.value("energy_error");
    println!(
        "{what}: energy error {error:.1e}, {} impacts, friction {:.3} J, normal work {:.1e} J, stick {:.1e} s",
        row.value("impacts"),
        row.value("friction_energy_J"),
        row.value("normal_work_J"),
        row.value("stick_time_s")
    );
    assert!(row.value("contact_impulse_Ns") > 0.0 && row.value("impacts") >= 1.0, "{what}: contact happened");
    assert!(error < 1e-6, "{what}: {error}");
    assert!(row.value("friction_energy_J") >= 0.0);
}

#[test]
fn energy_balance_closes_on_the_reduced_engine_with_everything_in_it() {
    let cases: [(&str, &[(&str, &str)]); 5] = [
        ("hyp2", &[]),
        ("hyp1, slip", &[("contact.detection", "hyp1"), ("contact.friction_law", "slip")]),
        ("hyp2-frozen, mean line", &[("contact.detection", "hyp2-frozen"), ("contact.surface", "mean-line")]),
        ("hyp2, slip", &[("contact.friction_law", "slip")]),
        ("hyp2, mu 0.4", &[("contact.friction", "0.4")]),
    ];
    for (name, changes) in cases {
        balanced(&format!("reduced, {name}"), &run(everything("reduced", changes, 0.25)));
    }
}

#[test]
fn force_at_n_is_sound_in_light_rub_and_never_silently_wrong_in_heavy_rub() {
    // force and gap at different places: once the closest point jumps between n and n+1, the normal force may add energy or not be unique, which
    // the guard reports
    let light =
        run(machine_with(&study_machine("lab_rig"), &[("run.end_time", "0.25"), ("run.force_location", "current")]));
    balanced("reduced, force at n, light rub", &light);
    assert!(light.value("normal_work_J").abs() < 1e-4 * light.value("friction_energy_J"));
    let heavy = run(everything("reduced", &[("run.force_location", "current")], 0.25));
    println!(
        "heavy rub, force at n: {:?}, normal work {:.1e} J",
        heavy.outcome.causes.words(),
        heavy.value("normal_work_J")
    );
    assert!(heavy.value("impacts") >= 1.0, "contact happened");
    let wrong = heavy.value("normal_work_J").abs() > 0.01 * heavy.value("friction_energy_J");
    assert!(!wrong || heavy.outcome.status != bladeoff_model::outcome::Status::Ok);
}

#[test]
fn energy_balance_closes_on_the_full_engine_with_everything_in_it() {
    let first = run(everything("reduced", &[], 0.25)).value("first_contact_s");
    for (name, changes) in [("hyp2", &[][..]), ("hyp1", &[("contact.detection", "hyp1")][..])] {
        balanced(&format!("full, {name}"), &run(everything("full", changes, first + 0.02)));
    }
}

#[test]
fn free_shaft_line_keeps_angular_momentum_and_energy() {
    // only the torsional damping takes energy, bearings are isotropic: angular momentum about Z of the whole flexible line, with gyroscopic sites,
    // torsion and unbalance; the error of central differences is of order 2
    let text = study_machine("lab_rig")
        .replace("damping = \"600 N s/m\"", "damping = 0")
        .replace("mass_proportional = \"5 1/s\"", "mass_proportional = 0")
        .replace("stiffness_proportional = \"2e-5 s\"", "stiffness_proportional = 0")
        .replace("constant = \"0.1 N m\"\nlinear = \"2e-3 N m s\"\nquadratic = \"1e-5 N m s2\"", "constant = 0");
    let text = text.split("[diaphragms").next().expect("a first part").to_owned()
        + "[rotor.initial]\ndisplacement = [0.02, -0.01]\nvelocity = [3.0, 4.0]\n";
    let drift = |text: &str, step: f64, torsional: &str| {
        let step_text = format!("{step:e}");
        let changes = [
            ("run.end_time", "0.1"),
            ("run.step", &*step_text),
            ("run.engine", "full"),
            ("rotor.damping.torsional", torsional),
        ];
        let m = machine_with(text, &changes);
        let mut dissipated = 0.0;
        let rotor = RotorMatrices::assemble(&m.rotor);
        let site = m.rotor.unbalances[0].clone();
        let mass = if site.kind == UnbalanceKind::Lost { -site.mass } else { site.mass };
        let mut momenta: Vec<f64> = Vec::new();
        // factors of the nodes' own spin rates, whose torsional part is the central difference of three instants
        let mut waiting: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        let row = run_seen(
            m.clone(),
            &mut Every(|frame| {
                let (x, v) = (frame.displacement, frame.velocity);
                dissipated = frame.energies.structure;
                let momentum = &rotor.mass * Vector::from_column_slice(v);
                // quarter turn R of the frame: L = p . R x + p_psi, p = M x' + 1/2 Omega S x
                let mut l = 0.0;
                for node in 0..rotor.nodes {
                    let (tu, tv) = (rotor.theta_u(node).expect("a shaft"), rotor.theta_v(node).expect("a shaft"));
                    l += x[rotor.u(node)] * momentum[rotor.v(node)] - x[rotor.v(node)] * momentum[rotor.u(node)];
                    l += x[tu] * momentum[tv] - x[tv] * momentum[tu];
                }
                let skew: f64 = rotor.gyro.iter().map(|g| g.bilinear(v, x)).sum();
                l += rotor.torsional_mass.sum() * frame.speed + 0.5 * skew;
                let (s, c) = (frame.angle + frame.torsion_angles[site.torsional_node] + site.phase).sin_cos();
                let (ex, ey) = (site.radius * c, site.radius * s);
                let [u, w] = [x[rotor.u(site.node)] + ex, x[rotor.v(site.node)] + ey];
                let [vu, vw] = [v[rotor.u(site.node)], v[rotor.v(site.node)]];
                l += mass * (u * vw - w * vu);
                let mut factors = vec![0.0; rotor.nodes];
                factors[site.torsional_node] = mass * (u * ex + w * ey);
                let mut turned = vec![0.0; x.len()];
                for node in 0..rotor.nodes {
                    let (tu, tv) = (rotor.theta_u(node).expect("a shaft"), rotor.theta_v(node).expect("a shaft"));
                    (turned[rotor.u(node)], turned[rotor.v(node)]) = (-x[rotor.v(node)], x[rotor.u(node)]);
                    (turned[tu], turned[tv]) = (-x[tv], x[tu]);
                }
                rotor.gyro.iter().for_each(|g| g.spread(0.5 * g.bilinear(&turned, x), &mut factors));
                momenta.push(l + factors.iter().sum::<f64>() * frame.speed);
                waiting.push((factors, frame.torsion_angles.to_vec()));
            }),
        );
        let inner = 1..momenta.len() - 1;
        let momenta: Vec<f64> = inner
            .map(|n| {
                let rates = waiting[n + 1]
                    .1
                    .iter()
                    .zip(&waiting[n - 1].1)
                    .map(|(after, before)| (after - before) / (2.0 * step));
                momenta[n] + waiting[n].0.iter().zip(rates).map(|(factor, rate)| factor * rate).sum::<f64>()
            })
            .collect();
        let change = momenta.iter().map(|l| (l - momenta[0]).abs()).fold(0.0, f64::max) / momenta[0].abs();
        (row.value("energy_error"), change, dissipated)
    };
    // the blade on its node; or lost from a disc at another node
    let of_a_disc = text.replace(
        "[rotor.unbalances.blade_off]\nposition = \"0.6 m\"",
        "[rotor.unbalances.blade_off]\nposition = \"0.5 m\"\ndisc = \"left\"\nkind = \"lost\"",
    );
    assert_ne!(text, of_a_disc);
    // (for a disc's mass, rounding is visible at the smaller steps, in the momentum as in the energy)
    for (name, text, torsional, steps) in [
        ("a blade", &text, "0", [1e-6, 5e-7]),
        ("a blade", &text, "1e-3", [1e-6, 5e-7]),
        ("lost from a disc", &of_a_disc, "0", [1.2e-6, 7e-7]),
    ] {
        let [coarse, fine] = steps.map(|step| drift(text, step, torsional));
        let (ratio, square) = (coarse.1 / fine.1, (steps[0] / steps[1]) * (steps[0] / steps[1]));
        println!(
            "free shaft line, {name}, torsion damped by {torsional} s ({:.1e} J): energy {:.1e} {:.1e}, angular momentum {:.1e} {:.1e}, \
             {ratio:.3} for {square:.3}",
            fine.2, coarse.0, fine.0, coarse.1, fine.1
        );
        assert!(if torsional == "0" { fine.2.abs() < 1e-12 } else { fine.2 > 1e-9 }, "{}", fine.2);
        assert!(fine.0 < 1e-8 && fine.1 < 2e-8 * (steps[1] / 5e-7) * (steps[1] / 5e-7));
        assert!((0.95..1.05).contains(&(ratio / square)), "{ratio} {square}");
    }
}

#[test]
fn high_friction_on_the_turbine_is_bounded_and_never_invents_energy() {
    for (friction, law) in [("0.3", "stick-slip"), ("0.5", "stick-slip"), ("0.4", "slip")] {
        let changes = [("run.end_time", "4.2"), ("contact.friction", friction), ("contact.friction_law", law)];
        let mut largest = 0.0_f64;
        let mut start = None;
        let row = run_seen(
            machine_with(&study_machine("lp_turbine_paper"), &changes),
            &mut Every(|frame| {
                let stored = frame.energies.stored();
                if stored > 0.0 {
                    start.get_or_insert(stored);
                }
                largest = largest.max(stored);
            }),
        );
        let start: f64 = start.expect("the rotor turns");
        println!(
            "turbine, mu {friction}, {law}: {:?} {:?}, energy at most {:.6} of the start, error {:.1e}, friction {:.2e} of \
             {start:.2e} J, stick {:.2e} s, end speed {:.2}",
            row.outcome.status,
            row.outcome.causes.words(),
            largest / start,
            row.value("energy_error"),
            row.value("friction_energy_J"),
            row.value("stick_time_s"),
            row.value("end_speed_rad_s"),
        );
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        let sound = row.value("energy_error") < 1e-6 && largest <= start * (1.0 + 1e-6);
        assert!(sound || row.outcome.status != bladeoff_model::outcome::Status::Ok);
        assert!(law == "slip" || sound, "with stick no energy is invented");
    }
}
