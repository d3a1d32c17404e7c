//! Loads of the bearings and pedestals, with the static response of the truncated modes.
//!
//! The load is `K (x + x_r - e) + C x'`: x is the displacement of the journal relative to its pedestal or the ground, e the elevation of the seat.
//! The load of a pedestal is that of its own spring and damper. x contains the kept modes. `x_r = R f` is the static correction: the displacement
//! that the truncated modes take at once under the forces f on the shaft (R as at the contact, `docs/theory/05-reduction.md`). f contains weight,
//! unbalance, gyroscopic moments, contact, and damping and skew stiffness of the bearings. Without the correction, the computed load of a bearing
//! that is stiff against the shaft is too small: the effect of a nearby force on it is in the truncated modes. The inertia of the truncated modes is
//! neglected: after a sudden force the true load oscillates about the computed one.
//! Verified by `stiff_bearings_carry_what_stands_on_them` in `tests/runs/engines.rs`.

use super::shaft_line::ShaftLine;
use crate::record::Loads;
use crate::rotor::BearingSite;
use crate::structure::Structure;
use bladeoff_model::machine::{Bearing, Machine, Monitor};
use bladeoff_numerics::linalg::dot;

/// Loads of bearings and pedestals during one run.
pub(super) struct BearingLoads {
    /// Rows of R for u and v across each bearing, each pedestal and each monitor, in this order \[m/N\]; empty in the full engine.
    rows: Vec<[Vec<f64>; 2]>,
    /// Constant forces on the nodal degrees of freedom \[N\].
    weight: Vec<f64>,
    /// Forces f on the nodal degrees of freedom at n \[N\].
    force: Vec<f64>,
    /// Loads of the bearings, then of the pedestals \[N\]; the force on the rotor is their opposite.
    loads: Vec<[f64; 2]>,
    /// Number of bearings.
    bearings: usize,
    /// Elevation e of each bearing's seat \[m\], and the force K e that it subtracts from the load \[N\].
    seats: Vec<[[f64; 2]; 2]>,
    /// Indices of the bearings with a clearance, and displacements of their journals relative to the seat \[m\].
    limited: Vec<usize>,
    journals: Vec<[f64; 2]>,
    /// Sites of unit stiffness at the monitors, and displacements of the monitors \[m\].
    monitor_sites: Vec<BearingSite>,
    monitors: Vec<[f64; 2]>,
}

impl BearingLoads {
    pub fn new(machine: &Machine, structure: &Structure, line: &ShaftLine<'_>) -> Self {
        let rotor = &structure.rotor;
        let monitor_site = |monitor: &Monitor| BearingSite::unit(monitor.node, rotor.plane_places(monitor.node));
        let monitor_sites: Vec<BearingSite> = machine.monitors.iter().map(monitor_site).collect();
        let rows = structure.lateral_residual.as_ref().map_or_else(Vec::new, |residual| {
            let sites = rotor.supports().chain(&monitor_sites);
            sites.map(|site| site.rows(|place| residual.row(place).iter().copied().collect())).collect()
        });
        let weight = line.nodal_weight();
        let bearings = machine.rotor.bearings.iter().enumerate();
        let seat = |(bearing, force): (&Bearing, [f64; 2])| [bearing.elevation, force];
        let limited: Vec<usize> = bearings.filter(|(_, of)| of.clearance.is_some()).map(|(place, _)| place).collect();
        Self {
            rows,
            force: vec![0.0; weight.len()],
            weight,
            loads: vec![[0.0; 2]; rotor.supports().count()],
            bearings: rotor.bearings.len(),
            seats: machine.rotor.bearings.iter().zip(rotor.seat_forces(&machine.rotor)).map(seat).collect(),
            journals: vec![[0.0; 2]; limited.len()],
            limited,
            monitors: vec![[0.0; 2]; monitor_sites.len()],
            monitor_sites,
        }
    }

    /// Updates the constant forces after a change of the unbalances.
    pub fn set_weight(&mut self, line: &ShaftLine<'_>) {
        self.weight = line.nodal_weight();
    }

    /// Computes loads and displacements at the instant n, after [`ShaftLine::settle`]. `pressed`: nodes and contact forces on the rotor \[N\].
    pub fn update(&mut self, line: &ShaftLine<'_>, pressed: impl Iterator<Item = (usize, [f64; 2])>) {
        if !self.rows.is_empty() {
            self.gather(line, pressed);
        }
        for (i, site) in line.rotor.supports().enumerate() {
            let (mut x, v) = line.across(site);
            if let Some(rows) = self.rows.get(i) {
                x[0] += dot(&rows[0], &self.force);
                x[1] += dot(&rows[1], &self.force);
            }
            self.loads[i] = site.load(x, v);
            if let Some(change) = line.tables.change(i) {
                let changed = change.load(x, v);
                (0..2).for_each(|axis| self.loads[i][axis] += changed[axis]);
            }
            let Some([elevation, force]) = self.seats.get(i) else { continue };
            (0..2).for_each(|axis| self.loads[i][axis] -= force[axis]);
            if let Some(at) = self.limited.iter().position(|&place| place == i) {
                self.journals[at] = [x[0] - elevation[0], x[1] - elevation[1]];
            }
        }
        let first = self.loads.len();
        for (i, (site, monitor)) in self.monitor_sites.iter().zip(&mut self.monitors).enumerate() {
            (*monitor, _) = line.across(site);
            if let Some(rows) = self.rows.get(first + i) {
                (0..2).for_each(|axis| monitor[axis] += dot(&rows[axis], &self.force));
            }
        }
    }

    /// Loads of bearings and pedestals, and displacements of the monitors and of the journals in bearings with a clearance.
    pub fn all(&self) -> Loads<'_> {
        let (bearings, pedestals) = self.loads.split_at(self.bearings);
        Loads { bearings, pedestals, journals: &self.journals, monitors: &self.monitors }
    }

    /// Collects the forces on the shaft that the truncated modes follow.
    fn gather(&mut self, line: &ShaftLine<'_>, pressed: impl Iterator<Item = (usize, [f64; 2])>) {
        self.force.copy_from_slice(&self.weight);
        line.add_driving_forces(&mut self.force);
        for site in line.rotor.supports() {
            let (x, v) = line.across(site);
            let (skew, damping) = (site.skew_force(x), site.load([0.0; 2], v));
            site.push([skew[0] - damping[0], skew[1] - damping[1]], &mut self.force);
        }
        for change in line.tables.changes() {
            // damping of the tables is already among the driving forces
            change.push(change.load(line.across(change).0, [0.0; 2]).map(|part| -part), &mut self.force);
        }
        for (node, force) in pressed {
            line.rotor.add_at(node, force, &mut self.force);
        }
    }
}
