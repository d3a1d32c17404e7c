//! Loads of the bearings, with the static response of the modes left out.
//!
//! The load is `K (x + x_r) + C x'`: x of the modes kept, and `x_r = R f` the displacement that the modes left out take at once under
//! the forces f on the shaft (R as at the contact, `docs/theory/05-reduction.md`): weight, unbalance, gyroscopic moments, contact, damping
//! and skew stiffness of the bearings. Without it a bearing that is stiff against the shaft loses its load: what a force next to it puts
//! into it is in the modes left out. Inertia of these is not covered: after a sudden force the true load swings about this one.
//! Verified by `stiff_bearings_carry_what_stands_on_them` in `tests/engines.rs`.

use super::shaft_line::ShaftLine;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::dot;

/// Rows of R and scratch of one run.
pub(super) struct BearingLoads {
    /// For u and v of each bearing; empty in the full engine.
    rows: Vec<[Vec<f64>; 2]>,
    /// Weight of shaft, discs and unbalances on the nodal freedoms \[N\].
    weight: Vec<f64>,
    force: Vec<f64>,
    loads: Vec<[f64; 2]>,
    /// Places of the bearings with a clearance, and displacements of their journals \[m\].
    limited: Vec<usize>,
    journals: Vec<[f64; 2]>,
}

impl BearingLoads {
    pub fn new(machine: &Machine, structure: &Structure, line: &ShaftLine<'_>) -> Self {
        let rotor = &structure.rotor;
        let rows = structure.lateral_residual.as_ref().map_or_else(Vec::new, |residual| {
            let row = |place: usize| residual.row(place).iter().copied().collect();
            rotor.bearings.iter().map(|bearing| rotor.plane_places(bearing.node).map(row)).collect()
        });
        let weight = line.nodal_weight();
        let bearings = machine.rotor.bearings.iter().enumerate();
        let limited: Vec<usize> = bearings.filter(|(_, of)| of.clearance.is_some()).map(|(place, _)| place).collect();
        Self {
            rows,
            force: vec![0.0; weight.len()],
            weight,
            loads: vec![[0.0; 2]; rotor.bearings.len()],
            journals: vec![[0.0; 2]; limited.len()],
            limited,
        }
    }

    /// At the instant n of a step, after [`ShaftLine::settle`]. `pressed`: nodes and contact forces on the rotor \[N\].
    pub fn update(&mut self, line: &ShaftLine<'_>, pressed: impl Iterator<Item = (usize, [f64; 2])>) {
        if !self.rows.is_empty() {
            self.gather(line, pressed);
        }
        for (i, bearing) in line.rotor.bearings.iter().enumerate() {
            let (mut x, v) = line.node(bearing.node);
            if let Some(rows) = self.rows.get(i) {
                x[0] += dot(&rows[0], &self.force);
                x[1] += dot(&rows[1], &self.force);
            }
            self.loads[i] = bearing.load(x, v);
            if let Some(at) = self.limited.iter().position(|&place| place == i) {
                self.journals[at] = x;
            }
        }
    }

    /// Loads in the machine's order \[N\].
    pub fn all(&self) -> &[[f64; 2]] {
        &self.loads
    }

    /// Displacements of the journals whose bearings have a clearance, in the machine's order \[m\].
    pub fn journals(&self) -> &[[f64; 2]] {
        &self.journals
    }

    /// Forces on the shaft that the modes left out follow.
    fn gather(&mut self, line: &ShaftLine<'_>, pressed: impl Iterator<Item = (usize, [f64; 2])>) {
        self.force.copy_from_slice(&self.weight);
        line.add_driving_forces(&mut self.force);
        for bearing in &line.rotor.bearings {
            let (x, v) = line.node(bearing.node);
            let (skew, damping) = (bearing.skew_force(x), bearing.load([0.0; 2], v));
            line.rotor.add_at(bearing.node, [skew[0] - damping[0], skew[1] - damping[1]], &mut self.force);
        }
        for (node, force) in pressed {
            line.rotor.add_at(node, force, &mut self.force);
        }
    }
}
