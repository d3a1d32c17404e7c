//! Works and stored energies of a step, in the discrete form of the scheme.

use super::motion::Motion;
use crate::record::Energies;

/// Adds the works of the step at n; after the velocities are computed and before anything advances.
pub(super) fn add_works(now: &mut Energies, motion: &mut Motion<'_>) {
    let Motion { line, rubs, contacts, d, .. } = motion;
    let dt = line.dt;
    let mut bearings = 0.0;
    for site in line.rotor.supports() {
        let (x, v) = line.across(site);
        bearings += dt * site.damping_power(v);
        if site.skew != 0.0 {
            let force = site.skew_force(x);
            now.skew += dt * (force[0] * v[0] + force[1] * v[1]);
        }
    }
    now.bearings += bearings;
    for site in line.tables.changes() {
        let (x, v) = line.across(site);
        let force = site.skew_force(x);
        now.bearings += dt * site.damping_power(v);
        now.skew += dt * (force[0] * v[0] + force[1] * v[1]);
    }
    now.tables += line.tables.put_in(&line.lateral.x, &line.lateral.previous);
    now.structure +=
        line.lateral.stepper.damping_work(&d.lateral) - bearings + line.torsion.stepper.damping_work(&d.torsion);
    let spin = line.centred_spin(&d.torsion);
    now.braking -= line.spin.braking_work(spin);
    if let Some(work) = line.spin.drive_work(spin) {
        now.drive += work;
    }
    now.torques += line.torque_work();
    for (rub, contact) in rubs.iter_mut().zip(contacts) {
        now.stator += rub.ring_damping_work();
        // the truncated modes store strain energy; energy released at the end of a contact is lost
        let [held, before] = rub.held();
        now.normal -= held - before;
        if let Some(contact) = contact {
            now.friction += contact.friction_work;
            now.normal += contact.normal_work;
            now.model += contact.model_work;
        }
    }
}

/// Sets the stored energies between n and n+1; before anything advances.
pub(super) fn write_stores(now: &mut Energies, motion: &Motion<'_>) {
    let Motion { line, rubs, d, .. } = motion;
    let (coupling, gravity) = line.coupling_energies(d);
    let (lateral, torsion) = (&line.lateral.stepper, &line.torsion.stepper);
    now.kinetic = lateral.kinetic_energy(&d.lateral) + torsion.kinetic_energy(&d.torsion) + coupling;
    let twisted = [torsion.kinetic_energy(&d.torsion) + coupling, torsion.strain_energy(&d.torsion)];
    now.strain = lateral.strain_energy(&d.lateral) + twisted[1];
    now.strain += line.tables.stored(&line.lateral.x, &line.lateral.d);
    for rub in rubs {
        let (kinetic, strain) = rub.ring_energies();
        now.kinetic += kinetic;
        now.strain += strain;
        now.strain += rub.spring_energy(line);
        now.strain += rub.held()[0];
    }
    now.gravity = gravity;
    now.lateral = now.kinetic + now.strain - twisted[0] - twisted[1];
}
