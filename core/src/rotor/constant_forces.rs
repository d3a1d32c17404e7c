//! Contributions of the bearings beyond the constant matrices: speed-dependent coefficients, and constant forces.
//!
//! A bearing table is a linearisation about a static equilibrium that moves with the speed, so displacements are relative to that
//! equilibrium. Weight therefore bends the shaft between such bearings, and acts on them as a constant force. Verified by
//! `tests/rotor/bearing_tables.rs`, `tests/rotor/pedestals.rs`.

use super::{BearingSite, RotorMatrices, UnbalanceSite};
use bladeoff_model::machine::{Presence, Rotor};
use bladeoff_numerics::linalg::{Matrix, Vector, solve};

impl RotorMatrices {
    /// Index of each bearing with a table, and the difference of its coefficients at a speed \[rad/s\] from the constant part.
    pub fn table_changes(&self, speed: f64) -> impl Iterator<Item = (usize, BearingSite)> {
        self.tables.iter().map(move |(place, table)| (*place, self.bearings[*place].change_to(&table.at(speed))))
    }

    /// Differences of stiffness (skew part included) and damping at a speed \[rad/s\] from the constant parts, as lateral matrices; `None`
    /// without tables.
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

    /// Force of the seat of each bearing on its journal \[N\]: `K e` for a linear bearing. The displacements of a table are relative to the
    /// equilibrium at each speed. So its seat carries the share of the static load that a rigid support carries.
    ///
    /// ```text
    /// [K' B^T; B 0] (q, s) = (w, 0)        K': stiffness without the tables, B: displacements across them, w: static load, s: forces on the bearings     (1)
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
        // without a solution the rotor is not supported; the start of a run reports this
        if let Some(found) = solve(&system, &right) {
            for (at, (place, _)) in self.tables.iter().enumerate() {
                seats[*place] = [0, 1].map(|axis| -found[size + 2 * at + axis]);
            }
        }
        seats
    }

    /// Constant lateral forces [N, N m]: weight of rotor, pedestals and the given unbalances, and forces of bearing seats off the bearing
    /// line.
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
                // weight of the pedestal mass in the machine file, which may be zero
                (0..2).for_each(|axis| force[places[axis]] += pedestal.mass[axis] * rotor.gravity[axis]);
            }
        }
        force
    }
}
