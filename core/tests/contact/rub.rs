//! Contact on the Jeffcott rotor (m = k = 1, clearance 1): closed forms of forward rub, dry whip and rolling, rest,
//! dissipation. Every test first asserts that contact happened.

use crate::common::{Every, Row, close, machine, run_seen};
use bladeoff_model::outcome::{EndCause, Status};

/// Parameters that the cases vary.
#[derive(Clone, Copy)]
struct Case {
    zeta: f64,
    beta: f64,
    mu: f64,
    e: f64,
    radius: f64,
    law: &'static str,
    step: f64,
    end: f64,
}

const CASE: Case = Case { zeta: 0.1, beta: 1.0, mu: 0.05, e: 0.5, radius: 1.0, law: "slip", step: 0.0025, end: 200.0 };

/// The rotor on a massless radial spring (`stator` replaces the lines that name it).
fn text(c: &Case, stator: Option<&str>, tail: &str) -> String {
    let spring = format!("kind = \"radial-spring\"\nstiffness = {:?}", c.beta);
    // with e = 0 the mass is on the axis
    format!(
        "schema = 1\nname = \"rub\"\n[run]\nend_time = {:?}\nstep = {:?}\n\
         [rotor.bearings.spring]\nstiffness = 1\ndamping = {:?}\n\
         [rotor.unbalances.mass]\nmass = 1\nradius = {:?}\n\
         [diaphragms.ring]\n{}\n[diaphragms.ring.contact]\nrotor_radius = {:?}\ngap = 1\nfriction = {:?}\n\
         friction_law = \"{}\"\n[rotor]\nkind = \"point-mass\"\nmass = 0\n{tail}",
        c.end,
        c.step,
        2.0 * c.zeta,
        c.e,
        stator.unwrap_or(&spring),
        c.radius,
        c.mu,
        c.law,
    )
}

/// Radii, whirl angles and forces of a run, sampled at each step.
#[derive(Default)]
struct Orbit {
    radius: Vec<f64>,
    angle: Vec<f64>,
    force: Vec<f64>,
    friction: Vec<f64>,
    slip: Vec<f64>,
    speed: Vec<f64>,
}

fn orbit(text: &str) -> (Row, Orbit) {
    let mut orbit = Orbit::default();
    let row = run_seen(
        machine(text),
        &mut Every(|frame| {
            let [x, y] = [frame.displacement[0], frame.displacement[1]];
            orbit.radius.push(x.hypot(y));
            orbit.angle.push(y.atan2(x));
            let [contact] = frame.contacts else { unreachable!("there is a diaphragm") };
            orbit.force.push(contact.normal_force);
            orbit.friction.push(contact.friction_force);
            orbit.slip.push(contact.slip);
            orbit.speed.push(frame.speed);
        }),
    );
    assert!(row.get("first_contact_s").is_some() && row.value("contact_impulse_Ns") > 0.0, "contact happened");
    (row, orbit)
}

const CONSTANT_SPEED: &str = "[rotor.speed_law]\nacceleration = 0\n";

#[test]
fn full_annular_rub_has_the_radius_of_its_closed_form() {
    // [(1-W^2) r + beta (r-1)]^2 + [2 zeta W r + mu beta (r-1)]^2 = (e W^2)^2
    for law in ["slip", "stick-slip"] {
        for (speed, published) in [(0.9, 1.131_250), (1.0, 1.400_000), (1.1, 1.797_607), (1.2, 2.377_023)] {
            let case = Case { law, ..CASE };
            let residual = {
                let (r, w2) = (published, speed * speed);
                let radial: f64 = (1.0 - w2) * r + r - 1.0;
                let tangential = 0.2 * speed * r + 0.05 * (r - 1.0);
                (radial.hypot(tangential) / (0.5 * w2) - 1.0).abs()
            };
            assert!(residual < 2e-6, "the published radius solves the closed form");
            let tail = format!("polar_inertia = 1\ninitial_speed = {speed:?}\n{CONSTANT_SPEED}");
            let (row, orbit) = orbit(&text(&case, None, &tail));
            assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes.words());
            let last = &orbit.radius[orbit.radius.len() - 2000..];
            let (low, high) = last.iter().fold((f64::MAX, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
            let ours = *last.last().expect("samples");
            // order 2 in the step (next test): the remaining error is a third of the difference from twice the step
            let twice = Case { step: 2.0 * case.step, ..case };
            let coarse = *self::orbit(&text(&twice, None, &tail)).1.radius.last().expect("samples");
            let extrapolated = ours + (ours - coarse) / 3.0;
            // half a unit of the last digit
            assert!((extrapolated - published).abs() < 0.51e-6, "W {speed}: {extrapolated} {published}");
            let error = (ours / published - 1.0).abs();
            println!(
                "annular rub {law} W {speed}: {ours:.6}, extrapolated {extrapolated:.7} against {published}, {error:.1e}, ripple {:.1e}",
                high - low
            );
            assert!(high - low < 1e-6, "steady");
            // the contact force is that of the spring; friction is Coulomb's, forward
            let force = orbit.force.last().expect("samples");
            close("force", *force, published - 1.0, 1e-3);
            close("friction", *orbit.friction.last().expect("samples"), 0.05 * force, 1e-12);
        }
    }
}

#[test]
fn annular_rub_radius_converges_with_order_two() {
    let radius = |step: f64| {
        let case = Case { step, ..CASE };
        let tail = format!("polar_inertia = 1\ninitial_speed = 1\n{CONSTANT_SPEED}");
        *orbit(&text(&case, None, &tail)).1.radius.last().expect("samples") - 1.4
    };
    let (coarse, fine) = (radius(0.04), radius(0.02));
    let order = (coarse / fine).log2();
    println!("annular rub: error {coarse:.2e} at 0.04, {fine:.2e} at 0.02, order {order:.3}");
    assert!((order - 2.0).abs() < 0.05);
}

/// Normal force of the steady rub on a rigid stator: (ours, closed form, largest penetration).
fn rigid_rub(law: &'static str, location: &str, speed: f64, step: f64) -> (f64, f64, f64) {
    let case = Case { law, step, end: 150.0, ..CASE };
    let tail = format!("polar_inertia = 1\ninitial_speed = {speed:?}\n{CONSTANT_SPEED}");
    let text = text(&case, Some("kind = \"rigid\""), &tail)
        .replace("[run]\n", &format!("[run]\nforce_location = \"{location}\"\n"));
    let (row, orbit) = orbit(&text);
    close("radius", *orbit.radius.last().expect("samples"), 1.0, 1e-6);
    // r = 1: [(1-W^2) + N]^2 + [2 zeta W + mu N]^2 = (e W^2)^2
    let (w2, f) = (speed * speed, 0.5 * speed * speed);
    let (a, b) = (1.0 - w2, 0.2 * speed);
    let (p, q, s): (f64, f64, f64) = (1.0 + 0.05 * 0.05, a + 0.05 * b, a * a + b * b - f * f);
    let exact = (-q + (q * q - p * s).sqrt()) / p;
    (*orbit.force.last().expect("samples"), exact, row.value("residual_penetration_m"))
}

#[test]
fn annular_rub_on_a_rigid_stator_has_the_force_of_its_closed_form() {
    // with multipliers instead of a spring; the force of step n acts at the contact place of n+1, which acts like a friction coefficient of
    // mu + W dt: first order in the step, second order with the place of n
    for (law, location, expected) in
        [("slip", "next", 1.0), ("stick-slip", "next", 1.0), ("stick-slip", "current", 2.0)]
    {
        for speed in [0.95, 1.0, 1.1] {
            let error = |step: f64| {
                let (ours, exact, penetration) = rigid_rub(law, location, speed, step);
                assert!(penetration < 1e-9);
                (ours / exact - 1.0).abs()
            };
            let (coarse, fine) = (error(0.02), error(0.01));
            let order = (coarse / fine).log2();
            println!(
                "rigid annular rub {law} {location} W {speed}: {coarse:.1e} at 0.02, {fine:.1e} at 0.01, order {order:.2}"
            );
            assert!((order - expected).abs() < 0.15 && fine < 6e-3);
        }
    }
}

const WHIP: Case = Case { zeta: 0.05, beta: 4.0, mu: 0.2, e: 0.0, radius: 10.0, law: "slip", step: 0.005, end: 250.0 };

/// Whirl speed of dry whip, `zeta/mu + sqrt(1 + (zeta/mu)^2)`.
fn whirl_speed(c: &Case) -> f64 {
    c.zeta / c.mu + (1.0 + (c.zeta / c.mu).powi(2)).sqrt()
}

/// Backward whirl from `x = (r0, 0)`, `x' = (0, -w r0)` at the constant speed `spin`.
fn whip(c: &Case, r0: f64, spin: f64) -> (Row, Orbit) {
    let tail = format!(
        "polar_inertia = 1\ninitial_speed = {spin:?}\n{CONSTANT_SPEED}\
         [rotor.initial]\ndisplacement = [{r0:?}, 0.0]\nvelocity = [0.0, {:?}]\n",
        -whirl_speed(c) * r0
    );
    orbit(&text(c, None, &tail))
}

/// Whether the whirl grows, rather than decays, by half of its radius.
fn grows(c: &Case, r0: f64) -> bool {
    let (_, orbit) = whip(c, r0, 1e6);
    let end = orbit.radius.iter().position(|r| *r > 1.5 * r0 || *r < r0 / 1.5).expect("it grows or decays");
    // R W > w r up to that instant
    assert!(orbit.slip[..end].iter().zip(&orbit.force).all(|(slip, force)| *force == 0.0 || *slip > 0.0));
    orbit.radius[end] > r0
}

#[test]
fn dry_whip_decays_below_its_threshold_and_grows_above() {
    for law in ["slip", "stick-slip"] {
        let case = Case { law, ..WHIP };
        assert!(!grows(&case, 1.17) && grows(&case, 1.22));
        let threshold = threshold(&case);
        println!("dry whip {law}: threshold {threshold:.6} against 1.190614");
        close("threshold", threshold, 1.190_614, 1e-5);
    }
}

/// The radius that separates decay from growth, by bisection.
fn threshold(case: &Case) -> f64 {
    let (mut low, mut high) = (1.17, 1.22);
    while high - low > 2e-7 {
        let middle = 0.5 * (low + high);
        if grows(case, middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn dry_whip_threshold_converges_with_order_two() {
    // the run starts in contact: without the contact force in the acceleration at t = 0, the order would be 1
    let exact = 4.0 / (5.0 - whirl_speed(&WHIP).powi(2));
    let error = |step: f64| (threshold(&Case { step, ..WHIP }) - exact).abs();
    let (coarse, fine) = (error(0.02), error(0.01));
    let order = (coarse / fine).log2();
    println!("dry whip: threshold error {coarse:.1e} at 0.02, {fine:.1e} at 0.01, order {order:.2}");
    assert!((order - 2.0).abs() < 0.1);
}

#[test]
fn dry_whip_turns_backward_at_its_whirl_speed() {
    close("closed form", whirl_speed(&WHIP), 1.280_776, 1e-6);
    let (row, orbit) = whip(&Case { end: 5.0, step: 0.001, ..WHIP }, 1.190_614, 1e4);
    // the radius stays on the threshold orbit for a while; the whirl speed is the mean over that time
    let turned: f64 = orbit
        .angle
        .windows(2)
        .map(|pair| {
            let d = pair[1] - pair[0];
            d - 2.0 * std::f64::consts::PI * (d / (2.0 * std::f64::consts::PI)).round()
        })
        .sum();
    let speed = -turned / ((orbit.angle.len() - 1) as f64 * row.value("step_s"));
    println!("dry whip: backward at {speed:.6}, radius {:.6}", orbit.radius.last().expect("samples"));
    close("whirl speed", speed, 1.280_776, 2e-5);
    close("radius", *orbit.radius.last().expect("samples"), 1.190_614, 1e-5);
}

#[test]
fn dry_whip_needs_enough_friction() {
    // mu > 2 zeta sqrt(1 + beta)/beta = 0.0559: below it a whirl of any size decays, above it the threshold is finite
    let below = Case { mu: 0.05, end: 2000.0, step: 0.02, ..WHIP };
    assert!(!grows(&below, 3.0) && !grows(&below, 30.0) && !grows(&below, 100.0));
    let above = Case { mu: 0.06, end: 4000.0, step: 0.02, ..WHIP };
    let w = whirl_speed(&above);
    let threshold = 4.0 / (5.0 - w * w);
    assert!(!grows(&above, 0.95 * threshold) && grows(&above, 1.05 * threshold), "{threshold}");
}

#[test]
fn backward_whirl_ends_in_rolling_at_its_limit() {
    // r^2 (1 + beta (r-1)/r) = V^2, V = R_r W: beta 4, V 3: 5 r^2 - 4 r = 9, r = 1.8
    for (speed, exact) in [(0.3, 1.8), (0.5, (4.0 + (16.0 + 20.0 * 25.0_f64).sqrt()) / 10.0)] {
        let case = Case { law: "stick-slip", end: 400.0, step: 0.002, ..WHIP };
        let (row, orbit) = whip(&case, 1.22, speed);
        assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes.words());
        let last = *orbit.radius.last().expect("samples");
        let error = close("rolling radius", last, exact, 1e-4);
        println!("rolling at V {}: r {last:.6} against {exact:.6}, {error:.1e}", 10.0 * speed);
        assert!(row.value("stick_time_s") > 100.0);
        assert!(orbit.slip.last().expect("samples").abs() < 1e-6);
    }
}

#[test]
fn slip_without_stick_is_invalid_where_rolling_would_begin() {
    let case = Case { law: "slip", end: 400.0, ..WHIP };
    let (row, _) = whip(&case, 1.22, 0.3);
    assert!(row.value("slip_reversal_steps") > 0.0);
    assert!(row.outcome.causes.contains(bladeoff_model::outcome::Cause::SlipReversal));
    assert_ne!(row.outcome.status, Status::Ok);
    let (impulse, guarded) = (row.value("contact_impulse_Ns"), row.value("guarded_contact_impulse_Ns"));
    assert!(0.0 < guarded && guarded < impulse, "what came before the reversal: {guarded} of {impulse}");
}

#[test]
fn free_spin_in_backward_whirl_is_bounded_and_never_gains_energy() {
    // free spin: whip takes its energy from the spin until the rotor rolls and comes to rest
    let case = Case { law: "stick-slip", end: 600.0, ..WHIP };
    let tail = format!(
        "polar_inertia = 20\ninitial_speed = 1\n[rotor.initial]\ndisplacement = [1.3, 0.0]\nvelocity = [0.0, {:?}]\n",
        -whirl_speed(&case) * 1.3
    );
    let mut totals = Vec::new();
    let row = run_seen(machine(&text(&case, None, &tail)), &mut Every(|frame| totals.push(frame.energies.stored())));
    assert!(row.value("contact_time_s") > 10.0 && row.value("stick_time_s") > 1.0, "contact and stick happened");
    // the first few steps are left out: the initial state is not in equilibrium
    let start = totals[20];
    assert!(totals.iter().skip(20).all(|total| *total <= start * (1.0 + 1e-3)));
    assert!(row.value("friction_energy_J") >= 0.0);
    println!(
        "free whip: energy {start:.4} to {:.4}, error {:.1e}",
        totals[totals.len() - 1],
        row.value("energy_error")
    );
}

/// Static contact force and radius of a rotor pressed onto the stator by a weight of 5 while it slides: along n
/// `r + N = 5 cos`, along t `mu N = 5 sin`, so `(r + N)^2 + (mu N)^2 = 25`; `N = beta (r - 1)` on a spring, `r = 1` on a rigid stator.
fn pressed(beta: Option<f64>, mu: f64) -> (f64, f64) {
    let radius = |normal: f64| beta.map_or(1.0, |beta| 1.0 + normal / beta);
    let (mut low, mut high) = (0.0, 5.0);
    while high - low > 1e-13 {
        let normal: f64 = 0.5 * (low + high);
        if (radius(normal) + normal).powi(2) + (mu * normal).powi(2) < 25.0 { low = normal } else { high = normal }
    }
    (low, radius(low))
}

#[test]
fn rotor_that_stops_in_contact_comes_to_rest() {
    // gravity presses the rotor onto the stator, and only contact friction brakes
    for (stator, beta) in [(None, Some(4.0)), (Some("kind = \"rigid\""), None)] {
        let (mu, radius, inertia, speed, step) = (0.3, 2.0, 3.0, 5.0, 0.002);
        let case = Case { zeta: 0.5, beta: 4.0, mu, e: 0.0, radius, law: "stick-slip", step, end: 500.0 };
        let tail = format!("polar_inertia = {inertia:?}\ninitial_speed = {speed:?}\ngravity = [0.0, -5.0]\n");
        let (row, orbit) = orbit(&text(&case, stator, &tail));
        assert_eq!(row.outcome.end_cause, EndCause::Stopped, "{:?}", row.outcome);
        let (load, place) = pressed(beta, mu);
        let per_step = mu * load * radius / inertia * step;
        // friction takes the whole momentum of the spin and no more, J W = R (impulse of friction), within the braking of one step
        let taken = radius * step * orbit.friction.iter().sum::<f64>() / inertia;
        let slides = orbit.friction.iter().zip(&orbit.force).filter(|(t, n)| (*t - mu * *n).abs() <= 1e-9 * *n).count();
        assert!(slides as f64 > 0.9 * orbit.force.len() as f64, "{slides} of {}", orbit.force.len());
        println!(
            "stop in contact: {:.3} s, load {:.4} ({load:.4} static), radius {:.4} ({place:.4}), spin taken {taken:.5} of {speed}",
            row.value("stop_time_s"),
            orbit.force[orbit.force.len() - 10],
            orbit.radius[orbit.radius.len() - 10],
        );
        assert!((taken - speed).abs() < 2.0 * per_step, "{taken}");
        // the speed never increases, is at most the braking of one step in the last step, and then zero
        assert!(orbit.speed.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12));
        let last = *orbit.speed.last().expect("samples");
        assert!(last.abs() < 1.5 * per_step, "{last}");
        assert_eq!(row.value("end_speed_rad_s"), 0.0);
        // residual oscillation 8 s after the fall onto the stator: exp(-zeta w t)
        // (at the end the rotor may stick, without friction's share of the load)
        let (left, unloaded) = (orbit.force[orbit.force.len() - 10], pressed(beta, 0.0).0);
        assert!((0.97 * load..1.03 * unloaded).contains(&left), "{left}");
        close("radius", orbit.radius[orbit.radius.len() - 10], place, 0.02);
        // the fall onto a rigid stator is an impact, which dissipates energy; a spring returns it
        assert!(beta.is_none() || row.outcome.status == Status::Ok, "{:?}", row.outcome.causes.words());
    }
}

#[test]
fn a_start_that_does_not_settle_fails() {
    // an unbalance that outweighs the inertia of the spin 2500 times: a run cannot start if its accelerations at t = 0 do not converge
    let case = Case { mu: 0.1, e: 0.5, ..CASE };
    let tail = "polar_inertia = 1e-4\ninitial_speed = 1\n[rotor.initial]\ndisplacement = [0.1, 0.2]\n";
    let row = crate::common::run(machine(&text(&case, None, tail)));
    assert_eq!(row.outcome.cause, Some(bladeoff_model::outcome::Cause::Diverged));
    assert_eq!((row.outcome.end_cause, row.value("steps"), row.value("iterations")), (EndCause::Failure, 0.0, 0.0));
}

#[test]
fn a_loaded_start_has_the_velocity_asked_for() {
    // in contact at t = 0, with a damping at which an iteration of the start reduces its error by 0.91 only: the first step is centred on v0
    for law in ["slip", "stick-slip"] {
        let case = Case { zeta: 50.0, beta: 4.0, mu: 0.2, e: 0.0, radius: 10.0, law, step: 0.2, end: 2.0 };
        let tail = format!(
            "polar_inertia = 1\ninitial_speed = 100.0\n{CONSTANT_SPEED}[rotor.initial]\ndisplacement = [1.3, 0.0]\nvelocity = [0.2, -0.7]\n"
        );
        let mut first = None;
        let row = run_seen(
            machine(&text(&case, None, &tail)),
            &mut Every(|frame| {
                first.get_or_insert([frame.velocity[0], frame.velocity[1]]);
            }),
        );
        assert_eq!(row.value("first_contact_s"), 0.0, "contact happened, from the start on");
        let [u, v] = first.expect("a step");
        assert!((u - 0.2).hypot(v + 0.7) < 1e-9, "{law}: {u} {v}");
    }
}

#[test]
fn friction_dissipates_and_brakes_the_spin_in_every_rub() {
    for (law, mu) in [("slip", 0.05), ("stick-slip", 0.05), ("stick-slip", 0.4)] {
        for stator in [None, Some("kind = \"rigid\"")] {
            let case = Case { law, mu, end: 60.0, ..CASE };
            let tail = "polar_inertia = 50\ninitial_speed = 1.05\n[rotor.initial]\nvelocity = [0.3, -0.2]\n";
            let (row, orbit) = orbit(&text(&case, stator, tail));
            let power: f64 = orbit.friction.iter().zip(&orbit.slip).map(|(f, s)| f * s).fold(0.0, f64::min);
            let largest: f64 = orbit.friction.iter().zip(&orbit.slip).map(|(f, s)| f * s).fold(0.0, f64::max);
            println!("friction {law} mu {mu}: least power {power:.2e} of {largest:.2e}");
            assert!(power >= -1e-9 * largest, "friction never gives: {power}");
            assert!(row.value("friction_energy_J") > 0.0);
            for (friction, force) in orbit.friction.iter().zip(&orbit.force) {
                assert!(friction.abs() <= mu * force * (1.0 + 1e-9) + 1e-15);
            }
            // forward whirl: the friction torque brakes the spin over every contact
            let first = orbit.force.iter().position(|f| *f > 0.0).expect("contact happened");
            assert!(*orbit.speed.last().expect("samples") < orbit.speed[first]);
        }
    }
}
