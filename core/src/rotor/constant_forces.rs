//! What bearings add to the constant matrices: coefficients over the speed, and constant forces.
//!
//! A table is the tangent at a static point that moves with the speed, so displacements count from there: weight acts on the shaft between such bearings, and on
//! them as a constant force. Verified by `tests/rotor/bearing_tables.rs`, `tests/rotor/pedestals.rs`.

use super::{BearingSite, RotorMatrices, UnbalanceSite};
use bladeoff_model::machine::{Presence, Rotor};
use bladeoff_numerics::linalg::{Matrix, Vector, solve};

impl RotorMatrices {
    /// Bearings with a table, by their place among the bearings, with what their coefficients at a speed \[rad/s\] differ from the constant part.
    pub fn table_changes(&self, speed: f64) -> impl Iterator<Item = (usize, BearingSite)> {
        self.tables.iter().map(move |(place, table)| (*place, self.bearings[*place].change_to(&table.at(speed))))
    }

    /// What stiffness, its skew part included, and damping at a speed \[rad/s\] differ from those of the constant parts; `None` without tables.
    #[must_use]
    pub fn change_at(&self, speed: f64) -> Option<[Matrix; 2]> {
        if self.tables.is_empty() {
            return None;
        }
        let size = self.lateral_size();
        let mut change = [Matrix::zeros(size, size), Matrix::zeros(size, size)];
        for (_, site) in self.table_changes(speed) {
            site.add_to(&site.stiffness, &mut change[0]);
            site.add_to(&site.damping, &mut change[1]);
        }
        Some(change)
    }

    /// Force that the seat of each bearing adds to its journal \[N\]: `K e` of a linear bearing. A table counts from the equilibrium at each speed, so its seat carries
    /// the share of the static load that a support without displacement carries.
    ///
    /// ```text
    /// [K' B^T; B 0] (q, s) = (w, 0)        K': without the tables, B: displacements across them, s: forces on the bearings       (1)
    /// ```
    #[must_use]
    pub fn seat_forces(&self, rotor: &Rotor) -> Vec<[f64; 2]> {
        let mut seats: Vec<[f64; 2]> = self
            .bearings
            .iter()
            .zip(&rotor.bearings)
            .map(|(site, bearing)| site.seat_force(bearing.elevation))
            .collect();
        let before = rotor.unbalances.iter().filter(|unbalance| unbalance.presence == Presence::Before);
        let load = if self.tables.is_empty() {
            return seats;
        } else {
            self.load_with(rotor, &before.map(UnbalanceSite::new).collect::<Vec<_>>(), &seats)
        };
        if load.iter().all(|force| *force == 0.0) {
            return seats;
        }
        let (size, tables) = (self.lateral_size(), self.tables.len());
        let mut stiffness = &self.stiffness + self.skew_stiffness();
        let mut system = Matrix::zeros(size + 2 * tables, size + 2 * tables);
        for (at, (place, _)) in self.tables.iter().enumerate() {
            let site = &self.bearings[*place];
            site.add_to(&site.stiffness.map(|row| row.map(|entry| -entry)), &mut stiffness);
            for axis in 0..2 {
                for (place, sign) in [(Some(site.places[axis]), 1.0), (site.base.map(|base| base[axis]), -1.0)] {
                    let (Some(place), row) = (place, size + 2 * at + axis) else { continue };
                    (system[(row, place)], system[(place, row)]) = (sign, sign);
                }
            }
        }
        system.view_mut((0, 0), (size, size)).copy_from(&stiffness);
        let mut right = Vector::zeros(size + 2 * tables);
        right.rows_mut(0, size).copy_from_slice(&load);
        // without a solution nothing holds the rotor, which the start of a run reports
        if let Some(found) = solve(&system, &right) {
            for (at, (place, _)) in self.tables.iter().enumerate() {
                seats[*place] = [0, 1].map(|axis| -found[size + 2 * at + axis]);
            }
        }
        seats
    }

    /// Constant forces per place \[N\]: weight of rotor, pedestals and some unbalances, and the forces of bearing seats that are not on the bearing line.
    #[must_use]
    pub fn constant_force(&self, rotor: &Rotor, unbalances: &[UnbalanceSite]) -> Vec<f64> {
        self.load_with(rotor, unbalances, &self.seat_forces(rotor))
    }

    fn load_with(&self, rotor: &Rotor, unbalances: &[UnbalanceSite], seats: &[[f64; 2]]) -> Vec<f64> {
        let mut force = self.weight(rotor.gravity);
        for site in unbalances {
            self.add_at(site.node, rotor.gravity.map(|g| site.mass * g), &mut force);
        }
        for ((site, bearing), seat) in self.bearings.iter().zip(&rotor.bearings).zip(seats) {
            if *seat != [0.0; 2] {
                site.push(*seat, &mut force);
            }
            if let (Some(places), Some(pedestal)) = (site.base, &bearing.pedestal) {
                // of the mass that the machine gives, which may be none
                (0..2).for_each(|axis| force[places[axis]] += pedestal.mass[axis] * rotor.gravity[axis]);
            }
        }
        force
    }
}
