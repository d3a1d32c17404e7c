//! State of the shaft line at t = 0.
//!
//! Static sag under gravity, plus the synchronous steady state of the unbalances present before t = 0, plus the disturbance of the machine's initial
//! state. Velocities and accelerations are computed so that the first step is of second order.

use super::accelerations::{Accelerations, accelerations};
use crate::engine::shaft_line::{Increments, ShaftLine};
use crate::engine::time_step::StartError;
use crate::engine::torques::initial_torsion;
use crate::rotor::UnbalanceSite;
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, Presence};
use bladeoff_numerics::linalg::{Matrix, Vector, add_outer, axpy, dot, solve};

/// Sets the state of the shaft line at t = 0.
///
/// ```text
/// sag        (K + K_skew) q = Phi^T w                  w: weight, and forces of bearing seats off the bearing line
/// torsion    that of the torques at t = 0 (`engine/torques.rs`), which also turns the unbalances of the steady state
/// steady     [K + K_skew - W^2 M + i W (C + W G)] X = F,   F_u = m d W^2 e^{i(a + phi0)}, F_v = -i F_u
///            q = Re X, q' = Re(i W X)
/// ```
/// Source: docs/theory/04-time-integration.md.
/// Limits: the steady state is that of constant speed. It does not contain the small ripple of speed and torsion on anisotropic supports.
/// Verified by `a_residual_unbalance_starts_steady` and the Jeffcott cases of `tests/rotor/jeffcott.rs`.
///
/// Returns whether the accelerations converged; otherwise the start is not valid.
///
/// # Errors
/// [`StartError::Singular`] where a matrix has no inverse.
pub(super) fn start(machine: &Machine, structure: &Structure, line: &mut ShaftLine<'_>) -> Result<bool, StartError> {
    let (q, v) = initial_motion(machine, structure)?;
    if let Some(torsion) = initial_torsion(machine, structure) {
        line.begin_torsion(&torsion);
    }
    let speed = machine.rotor.initial_speed;
    let a = accelerations(line, structure, &q, &v, speed)
        .ok_or(StartError::Singular { what: "mass", part: "the rotor" })?;
    line.begin(&q, &before_start(line, &v, speed, &a));
    Ok(a.settled)
}

/// Lateral coordinates and their velocities at t = 0.
///
/// # Errors
/// [`StartError::Singular`] where a matrix has no inverse.
pub(in crate::engine) fn initial_motion(
    machine: &Machine,
    structure: &Structure,
) -> Result<(Vec<f64>, Vec<f64>), StartError> {
    let rotor = &machine.rotor;
    let part = &structure.lateral;
    let size = part.coordinates.size();
    let mut before: Vec<UnbalanceSite> =
        rotor.unbalances.iter().filter(|u| u.presence == Presence::Before).map(UnbalanceSite::new).collect();
    if let Some(torsion) = initial_torsion(machine, structure) {
        let turn = |site: &UnbalanceSite| dot(&structure.torsion.coordinates.row(site.torsional_node), &torsion);
        before.iter_mut().for_each(|site| site.phase += turn(site));
    }
    let changes = structure
        .rotor
        .change_at(rotor.initial_speed)
        .map(|changes| changes.map(|change| projected(structure, &change)));
    let stiffness = || {
        let constant = &part.stiffness + projected(structure, &structure.rotor.skew_stiffness());
        changes.iter().fold(constant, |sum, [stiffness, _]| sum + stiffness)
    };
    let damping = || changes.iter().fold(part.damping.clone(), |sum, [_, damping]| sum + damping);
    let (mut q, mut v) = (vec![0.0; size], vec![0.0; size]);

    if rotor.gravity != [0.0; 2] || rotor.bearings.iter().any(|bearing| bearing.elevation != [0.0; 2]) {
        let weight = structure.rotor.constant_force(rotor, &before);
        let mut force = vec![0.0; size];
        part.coordinates.project(&weight, &mut force);
        let sag = solve(&stiffness(), &Vector::from_vec(force))
            .ok_or(StartError::Singular { what: "stiffness", part: "the rotor" })?;
        q.copy_from_slice(sag.as_slice());
    }

    let speed = rotor.initial_speed;
    if !before.is_empty() && speed > 0.0 {
        let (real, imaginary) =
            steady_state(structure, &before, [&stiffness(), &damping()], speed, rotor.initial.angle)?;
        for i in 0..size {
            q[i] += real[i];
            v[i] -= speed * imaginary[i];
        }
    }

    for (state, disturbance) in [(&mut q, rotor.initial.displacement), (&mut v, rotor.initial.velocity)] {
        if disturbance != [0.0; 2] {
            let added = part.coordinates_of(&structure.rotor.mass, &structure.rotor.uniform(disturbance));
            axpy(1.0, &added, state);
        }
    }
    Ok((q, v))
}

/// Fictitious increments of the step before t = 0, `d- = dt v0 - dt^2 a0/2`, which make the first step second order.
fn before_start(line: &ShaftLine<'_>, velocity: &[f64], spin: f64, a: &Accelerations) -> Increments {
    let (dt, rigid) = (line.dt, &line.spin.rigid);
    let lateral = velocity.iter().zip(&a.lateral).map(|(v, a)| dt * v - 0.5 * dt * dt * a);
    let torsion = rigid.iter().zip(&a.torsion).map(|(rigid, a)| dt * spin * rigid - 0.5 * dt * dt * a);
    Increments { lateral: lateral.collect(), torsion: torsion.collect() }
}

/// Projection of a nodal matrix of the lateral motion on the coordinates.
pub(in crate::engine) fn projected(structure: &Structure, nodal: &Matrix) -> Matrix {
    match structure.lateral.coordinates.shapes() {
        None => nodal.clone(),
        Some(shapes) => bladeoff_numerics::linalg::project(nodal, shapes),
    }
}

/// Complex amplitude of the synchronous response in coordinates: (Re X, Im X).
///
/// # Errors
/// [`StartError::Singular`] where the dynamic stiffness has no inverse.
pub(in crate::engine) fn steady_state(
    structure: &Structure,
    before: &[UnbalanceSite],
    [stiffness, damping]: [&Matrix; 2],
    speed: f64,
    angle: f64,
) -> Result<(Vec<f64>, Vec<f64>), StartError> {
    let part = &structure.lateral;
    let size = part.coordinates.size();
    let gyroscopic = projected(structure, &structure.rotor.gyroscopic());
    let mut mass = part.mass.clone();
    let mut force = Vector::zeros(2 * size);
    for site in before {
        let rows = structure.rotor.plane_places(site.node).map(|dof| part.coordinates.row(dof));
        for row in &rows {
            add_outer(&mut mass, site.mass, row);
        }
        let (sin, cos) = libm::sincos(site.phase + angle);
        let amplitude = site.mass * site.radius * speed * speed;
        for i in 0..size {
            force[i] += amplitude * (cos * rows[0][i] + sin * rows[1][i]);
            force[size + i] += amplitude * (sin * rows[0][i] - cos * rows[1][i]);
        }
    }
    // [K - W^2 M] X_r - W [C + W G] X_i = F_r;  W [C + W G] X_r + [K - W^2 M] X_i = F_i
    let dynamic = stiffness - &mass * (speed * speed);
    let velocity = (damping + &gyroscopic * speed) * speed;
    let mut system = Matrix::zeros(2 * size, 2 * size);
    system.view_mut((0, 0), (size, size)).copy_from(&dynamic);
    system.view_mut((size, size), (size, size)).copy_from(&dynamic);
    system.view_mut((0, size), (size, size)).copy_from(&(-&velocity));
    system.view_mut((size, 0), (size, size)).copy_from(&velocity);
    let x = solve(&system, &force).ok_or(StartError::Singular { what: "dynamic stiffness", part: "the rotor" })?;
    Ok((x.as_slice()[..size].to_vec(), x.as_slice()[size..].to_vec()))
}
