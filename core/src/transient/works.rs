//! Works and stores of energy of a step, as the scheme does them.

use super::rub::{Rub, StepContact};
use super::shaft_line::ShaftLine;
use crate::record::Energies;

/// Adds the works of the step at n; `line` settled, nothing advanced yet.
pub(super) fn add_works(
    now: &mut Energies,
    line: &mut ShaftLine<'_>,
    rub: Option<(&mut Rub<'_>, Option<&StepContact>)>,
    d: &[f64],
    d_twist: &[f64],
) {
    let dt = line.dt;
    let mut bearings = 0.0;
    for bearing in &line.rotor.bearings {
        let (x, v) = line.node(bearing.node);
        bearings += dt * bearing.damping_power(v);
        if bearing.skew != 0.0 {
            let force = bearing.skew_force(x);
            now.skew += dt * (force[0] * v[0] + force[1] * v[1]);
        }
    }
    now.bearings += bearings;
    now.structure += line.lateral.damping_work(d) - bearings + line.twist.damping_work(d_twist);
    let spin = line.centred_spin(d_twist);
    now.braking -= line.braking_work(spin);
    if let Some(prescribed) = &line.prescribed {
        now.drive += prescribed.torque * spin * dt;
    }
    if let Some((rub, contact)) = rub {
        now.stator += rub.ring_damping_work();
        // what the modes left out hold is strain; what they let go at the end of a contact is lost
        now.normal -= rub.held - rub.held_before;
        if let Some(contact) = contact {
            now.friction += contact.friction_work;
            now.normal += contact.normal_work;
            now.model += contact.model_work;
        }
    }
}

/// Writes the stores between n and n+1; before anything is advanced.
pub(super) fn write_stores(
    now: &mut Energies,
    line: &ShaftLine<'_>,
    rub: Option<&Rub<'_>>,
    d: &[f64],
    d_twist: &[f64],
) {
    let (coupling, gravity) = line.coupling_energies(d);
    let (ring_kinetic, ring_strain) = rub.map_or((0.0, 0.0), Rub::ring_energies);
    let spring = rub.map_or(0.0, |rub| {
        let x = line.place(rub.node);
        let dx = line.rotor.at(rub.node, &line.d_nodal);
        rub.spring_energy(rub.local(x), rub.local([x[0] + dx[0], x[1] + dx[1]]))
    });
    now.kinetic = line.lateral.kinetic_energy(d) + line.twist.kinetic_energy(d_twist) + coupling + ring_kinetic;
    now.strain = line.lateral.strain_energy(d)
        + line.twist.strain_energy(d_twist)
        + ring_strain
        + spring
        + rub.map_or(0.0, |rub| rub.held);
    now.gravity = gravity;
}
