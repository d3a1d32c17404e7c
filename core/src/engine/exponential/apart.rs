//! The stores and works of a run one by one, for who follows it: the row needs their sums alone ([`super::measured`]).

use super::shape::Shape;
use super::transient::Transient;
use crate::record::Energies;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// What it takes to tell them apart.
pub(super) struct Apart {
    /// Contact step \[s\].
    h: f64,
    shape: Shape,
    /// Jumps of all rates per impulse along each axis of the diaphragm's node, and room for rates.
    jumps: [Vec<f64>; 2],
    mean_rates: Vec<f64>,
    /// Rows of u and v of each bearing's node.
    bearings: Vec<[Vec<f64>; 2]>,
    /// The last look: its time in contact steps, and powers of bearings and skew stiffness then \[W\].
    looked: Option<(u64, [f64; 2])>,
    /// As they were at the last look.
    pub energies: Energies,
}

impl Apart {
    /// Of a run that begins, in contact steps of `h` \[s\].
    pub fn new(machine: &Machine, structure: &Structure, transient: &Transient, h: f64) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let system = &transient.flight.shared().grid.model.system;
        let jumps = match machine.diaphragms.first() {
            Some(diaphragm) => rotor.plane_places(diaphragm.contact.node).map(|dof| system.struck(&map.row(dof))),
            None => [vec![0.0; map.size()], vec![0.0; map.size()]],
        };
        Self {
            h,
            shape: Shape::new(structure, transient.flight.spin()),
            jumps,
            mean_rates: vec![0.0; map.size()],
            bearings: rotor.bearings.iter().map(|b| rotor.plane_places(b.node).map(|dof| map.row(dof))).collect(),
            looked: None,
            energies: Energies::default(),
        }
    }

    /// Takes them at n, of a run with these sums, whose last impulse is given.
    pub fn take(&mut self, transient: &mut Transient, structure: &Structure, struck: [f64; 2], sums: &Energies) {
        self.store(transient, structure, sums);
        let flight = &transient.flight;
        let (q, velocity) = (self.shape.coordinates(), self.shape.rates());
        // damping acts on what is between the velocities before and after an impulse
        for (j, mean) in self.mean_rates.iter_mut().enumerate() {
            *mean = velocity[j] + 0.5 * (self.jumps[0][j] * struck[0] + self.jumps[1][j] * struck[1]);
        }
        let [mut bearings, mut skew] = [0.0; 2];
        for (bearing, rows) in structure.rotor.bearings.iter().zip(&self.bearings) {
            let of = |state: &[f64]| [0, 1].map(|i| crate::linalg::dot(&rows[i], state));
            let v = of(&self.mean_rates);
            bearings += bearing.damping_power(v);
            let force = bearing.skew_force(of(q));
            skew += force[0] * v[0] + force[1] * v[1];
        }
        let powers = [bearings, skew];
        let (ticks, now) = (flight.ticks(), &mut self.energies);
        if let Some((last, before)) = self.looked {
            let half = 0.5 * (ticks - last) as f64 * self.h;
            now.bearings += half * (before[0] + powers[0]);
            now.skew += half * (before[1] + powers[1]);
        }
        self.looked = Some((ticks, powers));
        // of the sums, which have what the skew part of K takes
        now.structure = sums.structure - now.bearings + now.skew;
    }

    /// Takes the stores at n, and those works that the sums have one by one.
    pub fn store(&mut self, transient: &mut Transient, structure: &Structure, sums: &Energies) {
        self.shape.take(&mut transient.flight, structure);
        let (flight, now) = (&transient.flight, &mut self.energies);
        let model = &flight.shared().grid.model;
        let shift = flight.held_back(flight.gyroscopic_momentum());
        let (q, velocity) = (self.shape.coordinates(), self.shape.rates());
        let [kinetic, strain] = model.system.energies(flight.spin().speed + shift, q, velocity);
        let [turning, twisted] = flight.spin().energies(shift, flight.velocities());
        let ring = transient.contact.as_ref().map_or([0.0; 2], |contact| contact.rub.ring.energies());
        now.kinetic = kinetic + turning + ring[0];
        now.strain = strain + twisted + ring[1];
        now.gravity = -crate::linalg::dot(model.outputs.weight(), q);
        (now.braking, now.friction, now.normal, now.stator) = (sums.braking, sums.friction, sums.normal, sums.stator);
    }
}
