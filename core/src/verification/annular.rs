//! Full annular rub of the Jeffcott rotor (m = k = 1, clearance 1) with a stator of finite mass. Its contact has a closed form and
//! is covered by both engines.
//!
//! ```text
//! D_r = k - m W^2 + i c W,   D_s = K - M W^2 + i C W      rotor and stator, all turning with W; e the normal, N the contact force
//! D_r z_r = m_u e_u W^2 - N e (1 + i mu),   D_s z_s = N e (1 + i mu),   z_r - z_s = e
//! |D_r + N (1 + i mu)(1 + D_r/D_s)| = m_u e_u W^2          quadratic in N
//! |z_r| = |1 + N (1 + i mu)/D_s|
//! ```
//! The stator is a very stiff ring on eight very narrow blades, so that its three lowest modes are those of a rigid body. The blades are as long as
//! they are thick and clamped at both ends; their stiffness is `K = 4 E b (t/L + (t/L)^3) = 8 E b`.

use super::case::{Case, Check};
use super::machine::{stepping, watch};
use bladeoff_model::machine::Engine;

const ZETA: f64 = 0.1;
const FRICTION: f64 = 0.05;
const UNBALANCE: f64 = 0.5;
const STATOR: Stator = Stator { mass: 0.2, stiffness: 4.0, damping: 0.4 };

pub(super) fn add(checks: &mut Vec<Check>) {
    let runs = [(Engine::Reduced, &[1.0][..]), (Engine::Exponential, &[0.9, 1.0, 1.1])];
    for (engine, speeds) in runs {
        let case = Case {
            name: "annular rub, stator with mass",
            engine: engine.word(),
            unit: "gap",
            source: "closed form, |D_r + N (1 + i mu)(1 + D_r/D_s)| = m e W^2",
            // the ring's frequency is 5e-5 above that of the rigid body (mesh and bending), its displacement is up to 0.2
            tolerance: 2e-5,
        };
        for &speed in speeds {
            case.check(checks, format!("radius at W = {speed}"), radius(engine, speed), closed_form(speed));
        }
    }
}

/// Rigid body in the plane with the same properties along both axes.
struct Stator {
    /// Mass M; the rotor's mass is 1.
    mass: f64,
    /// Stiffness K; the rotor's stiffness is 1.
    stiffness: f64,
    /// Damping coefficient C; the rotor's is 2 zeta.
    damping: f64,
}

/// Radius |z_r| of the rotor's orbit in clearances, at the speed `w`.
fn closed_form(w: f64) -> f64 {
    type Complex = nalgebra::Complex<f64>;
    let rotor = Complex::new(1.0 - w * w, 2.0 * ZETA * w);
    let stator = Complex::new(STATOR.stiffness - STATOR.mass * w * w, STATOR.damping * w);
    let force = UNBALANCE * w * w;
    let pressed = Complex::new(1.0, FRICTION);
    // |a + N b|^2 = force^2, the root with N > 0
    let (a, b) = (rotor, pressed * (rotor / stator + 1.0));
    let (p, q, s) = (b.norm_sqr(), (a * b.conj()).re, a.norm_sqr() - force * force);
    let normal = (-q + (q * q - p * s).sqrt()) / p;
    let place = pressed * normal / stator + 1.0;
    place.norm_sqr().sqrt()
}

/// Radius of the rotor's orbit at the end of a run; `None` without contact.
fn radius(engine: Engine, speed: f64) -> Option<f64> {
    const RADIUS: f64 = 20.0;
    let (thickness, young, blade) = (8.0, 1e6, 5.0);
    let density = STATOR.mass / (2.0 * std::f64::consts::PI * RADIUS * thickness);
    let width = STATOR.stiffness / (8.0 * young);
    // with the force at the place of n+1 the effective friction of the reduced engine is mu + W h
    let place = if engine == Engine::Reduced { "force_location = \"current\"\n" } else { "" };
    let text = format!(
        "schema = 1\nname = \"annular\"\n[run]\nend_time = 150\nring_modes = 3\n{place}{}\
         [rotor]\nkind = \"point-mass\"\nmass = 0\npolar_inertia = 1e9\ninitial_speed = {speed:?}\n\
         [rotor.bearings.spring]\nstiffness = 1\ndamping = {:?}\n\
         [rotor.unbalances.mass]\nmass = 1\nradius = {UNBALANCE:?}\n\
         [diaphragms.ring.material]\nyoung_modulus = {young:?}\npoisson_ratio = 0.3\ndensity = {density:?}\n\
         [diaphragms.ring.ring]\nmean_radius = {RADIUS:?}\nthickness = {thickness:?}\nwidth = 1\nelements = 96\n\
         [diaphragms.ring.blades]\ncount = 8\nlength = {blade:?}\nthickness = {blade:?}\nwidth = {width:?}\nelements = 1\n\
         [diaphragms.ring.damping]\nmass_proportional = {:?}\n\
         [diaphragms.ring.contact]\nrotor_radius = {:?}\ngap = 1\nfriction = {FRICTION:?}\n",
        stepping(engine, 0.012),
        2.0 * ZETA,
        STATOR.damping / STATOR.mass,
        RADIUS - 1.0,
    );
    let (mut radius, mut force) = (0.0, 0.0);
    watch(&text, |frame| {
        if let Some(contact) = frame.contacts.first() {
            radius = libm::hypot(contact.rotor[0], contact.rotor[1]);
            force = contact.normal_force;
        }
    })?;
    (force > 0.0).then_some(radius)
}
