//! Inputs and outputs of the lateral motion: input vectors of unbalances, weight and contact, output rows of bearing loads and nodal motion.
//!
//! ```text
//! load  = K_b (Phi q + R f - e) + C_b Phi q'                               load of a bearing; the same of a pedestal                     (1)
//! f     = w - W S Phi q' + skew - C Phi q' + sum_s E_s (f_s - m_s Phi_s q'') + E_c f_c     nodal forces on the truncated modes
//! q''   = M^-1 [Phi^T (w + sum_s E_s f_s) - (C + W G) q' - K q],      f_s = m d (psi'^2 - i psi'') e^{i psi}                          (2)
//! ```
//!
//! | symbol | quantity |
//! |---|---|
//! | `K_b`, `C_b` | stiffness and damping of the bearing, 2 x 2 |
//! | `e` | elevation of the bearing's seat |
//! | `Phi` | mode shapes: nodal displacements of the coordinates q; `Phi_s` those of the node of unbalance s |
//! | `R` | residual flexibility: static flexibility of the truncated modes, on nodal forces \[m/N\] |
//! | `f` | nodal forces: weight `w`, gyroscopic moments (nodal matrix `S` per unit spin), bearings (`skew`, damping), unbalances, contact |
//! | `E_s`, `E_c` | unit forces along u and v on the node of unbalance s, on that of the contact |
//! | `f_s`, `f_c` | force of unbalance s (mass m_s, radius d, angle psi), contact force \[N\] |
//!
//! At a given spin W all outputs are linear in q, q', the forces of the unbalances and the contact: output rows plus a direct feedthrough of the forces and a constant.
//! (1) is the load of the reduced engine. Limit: the term W'/2 of the gyroscopic moments is not in its static part (1e-4 of that part).
//! Source: docs/theory/05-reduction.md, "Bearing loads". Verified by `tests/exponential/exponential.rs`.

use super::bearing_tables::square;
use super::state_space::StateSpace;
use super::support_loads::{BearingRows, SupportLoads};
use crate::engine::shaft_line::sites;
use crate::rotor::BearingSite;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{Matrix, mul};
use std::borrow::Cow;

/// Input vectors and output rows of the lateral motion of a machine.
///
/// Order of the output rows:
/// - per unbalance two: velocity (u', v') of its node \[m/s\];
/// - per bearing two: its load \[N\];
/// - per pedestal two: its load \[N\];
/// - per bearing with a clearance two: displacement of its journal \[m\], computed as the load of a bearing of unit stiffness;
/// - per monitor two: displacement of its node \[m\], computed likewise;
/// - per diaphragm four: displacement (u, v) and velocity (u', v') of its node.
#[derive(Debug, Clone)]
pub(crate) struct Outputs {
    /// `Phi_s^T`: two columns (u, v) per unbalance.
    unbalance_columns: Matrix,
    /// Mass m_s of each unbalance \[kg\].
    masses: Vec<f64>,
    /// `Phi^T` of the diaphragms' nodes, two columns (u, v) each.
    contact_columns: Matrix,
    /// Bearings, pedestals, bearings with a clearance, then monitors; with the constant parts of bearing tables.
    bearings: Vec<BearingRows>,
    /// Terms of all supports at any speed; empty without bearing tables.
    at_speeds: Vec<SupportLoads>,
    /// Weight in the coordinates, `Phi^T w`.
    weight: Vec<f64>,
}

/// Direct feedthrough of forces to a bearing load, and its constant part; both add to the output rows.
#[derive(Debug, Clone)]
pub(crate) struct DirectFeedthrough {
    /// Load per force of each unbalance, 2 x 2 by rows.
    pub of_force: Vec<[f64; 4]>,
    /// Load per force on each diaphragm's node, 2 x 2 by rows.
    pub of_contact: Vec<[f64; 4]>,
    /// Load of the weight \[N\].
    pub constant: [f64; 2],
}

impl DirectFeedthrough {
    /// Feedthrough between those of two speeds, with the shares of both.
    pub fn between([lower, upper]: [&Self; 2], [a, b]: [f64; 2]) -> Self {
        let mix = |x: &[[f64; 4]], y: &[[f64; 4]]| {
            x.iter().zip(y).map(|(x, y)| [0, 1, 2, 3].map(|i| a * x[i] + b * y[i])).collect()
        };
        Self {
            of_force: mix(&lower.of_force, &upper.of_force),
            of_contact: mix(&lower.of_contact, &upper.of_contact),
            constant: [0, 1].map(|i| a * lower.constant[i] + b * upper.constant[i]),
        }
    }
}

impl Outputs {
    /// Inputs and outputs of a machine on its structure.
    pub fn new(machine: &Machine, structure: &Structure) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let sites = sites(machine);
        let columns = |nodes: &[usize]| {
            let rows: Vec<f64> =
                nodes.iter().flat_map(|&node| rotor.plane_places(node)).flat_map(|dof| map.row(dof)).collect();
            Matrix::from_column_slice(map.size(), 2 * nodes.len(), &rows)
        };
        let site_nodes: Vec<usize> = sites.iter().map(|site| site.node).collect();
        let contact_nodes: Vec<usize> = machine.diaphragms.iter().map(|d| d.contact.node).collect();
        let nodal_weight = rotor.constant_force(&machine.rotor, &sites);
        let mut weight = vec![0.0; map.size()];
        map.project(&nodal_weight, &mut weight);
        let nodes = [site_nodes.as_slice(), &contact_nodes];
        // each site with the force that its seat takes from the load
        let supports = supports(machine, structure);
        let rows = |(site, seat): &(BearingSite, [f64; 2])| {
            let mut rows = bearing_rows(structure, nodes, &nodal_weight, site);
            (0..2).for_each(|axis| rows.weight_load[axis] -= seat[axis]);
            rows
        };
        let at_speeds = |(at, (site, seat)): (usize, &(BearingSite, [f64; 2]))| {
            let displacement = bearing_rows(structure, nodes, &nodal_weight, &journal_displacement(site));
            SupportLoads::new(structure, (site, *seat), (at < rotor.bearings.len()).then_some(at), displacement)
        };
        let bearings = supports.iter().map(rows).collect();
        let changing = if rotor.tables.is_empty() { &[][..] } else { &supports };
        let at_speeds = changing.iter().enumerate().map(at_speeds).collect();
        Self {
            unbalance_columns: columns(&site_nodes),
            contact_columns: columns(&contact_nodes),
            masses: sites.iter().map(|site| site.mass).collect(),
            bearings,
            at_speeds,
            weight,
        }
    }

    /// Terms of (1) of all supports at a spin \[rad/s\].
    fn rows_at(&self, system: &StateSpace, spin: f64) -> Cow<'_, [BearingRows]> {
        if self.at_speeds.is_empty() {
            return Cow::Borrowed(&self.bearings);
        }
        let changes = system.tables.changes(spin);
        Cow::Owned(self.at_speeds.iter().map(|support| support.rows(&system.tables, &changes)).collect())
    }

    /// Index of the first output row of a bearing; pedestals, then journals in bearings with a clearance, then monitors, are counted behind all bearings.
    pub fn load_row(&self, bearing: usize) -> usize {
        self.unbalance_columns.ncols() + 2 * bearing
    }

    /// Weight in the coordinates, `Phi^T w`.
    pub fn weight(&self) -> &[f64] {
        &self.weight
    }

    /// Number of unbalances.
    pub fn unbalances(&self) -> usize {
        self.masses.len()
    }

    /// Indices of the first output rows of all bearings and pedestals, then of the journals and monitors.
    pub fn load_rows(&self) -> Vec<usize> {
        (0..self.bearings.len()).map(|bearing| self.load_row(bearing)).collect()
    }

    /// Largest coefficient of a velocity in the load of a bearing \[N s/m\]: the velocities may cancel in the sum.
    pub fn max_velocity_coefficient(&self, bearing: usize) -> f64 {
        self.bearings[bearing].velocity_rows.amax()
    }

    /// Number of diaphragms.
    pub fn contacts(&self) -> usize {
        self.contact_columns.ncols() / 2
    }

    /// Index of the first output row of a diaphragm.
    pub fn contact_row(&self, diaphragm: usize) -> usize {
        self.load_row(self.bearings.len()) + 4 * diaphragm
    }

    /// Output rows Y on `(q, q')` at a spin \[rad/s\].
    pub fn output_rows(&self, system: &StateSpace, spin: f64) -> Matrix {
        let (n, unbalances) = (system.size, self.unbalance_columns.ncols());
        let contacts = self.contact_columns.ncols();
        let mut y = Matrix::zeros(self.contact_row(contacts / 2), 2 * n);
        y.view_mut((0, n), (unbalances, n)).copy_from(&self.unbalance_columns.transpose());
        let (stiffness, velocity_matrix) =
            (system.stiffness_at(spin), &*system.damping_at(spin) + &system.gyroscopic * spin);
        for (i, bearing) in self.rows_at(system, spin).iter().enumerate() {
            let inertia = self.inertia(system, bearing);
            let displacement_rows = &bearing.displacement_rows - mul(&inertia, &stiffness);
            let velocity_rows =
                &bearing.velocity_rows + &bearing.gyroscopic_rows * spin - mul(&inertia, &velocity_matrix);
            y.view_mut((self.load_row(i), 0), (2, n)).copy_from(&displacement_rows);
            y.view_mut((self.load_row(i), n), (2, n)).copy_from(&velocity_rows);
        }
        for k in 0..contacts {
            let row = self.contact_row(k / 2) + k % 2;
            y.view_mut((row, 0), (1, n)).copy_from(&self.contact_columns.column(k).transpose());
            y.view_mut((row + 2, n), (1, n)).copy_from(&self.contact_columns.column(k).transpose());
        }
        y
    }

    /// Input vectors in x: unit forces on the nodes of the unbalances (two columns each), the weight, unit forces on the nodes of the diaphragms (two each).
    pub fn input_vectors(&self, system: &StateSpace) -> Matrix {
        let columns = |matrix: &Matrix| {
            matrix.column_iter().flat_map(|c| system.input_vector(c.as_slice())).collect::<Vec<f64>>()
        };
        let input_columns =
            [columns(&self.unbalance_columns), system.input_vector(&self.weight), columns(&self.contact_columns)]
                .concat();
        Matrix::from_column_slice(2 * system.size, self.contact_input(0) + self.contact_columns.ncols(), &input_columns)
    }

    /// Index of the first input vector of a diaphragm.
    pub fn contact_input(&self, diaphragm: usize) -> usize {
        self.unbalance_columns.ncols() + 1 + 2 * diaphragm
    }

    /// Direct feedthrough of each bearing load at a spin \[rad/s\], those with a clearance last.
    pub fn feedthrough(&self, system: &StateSpace, spin: f64) -> Vec<DirectFeedthrough> {
        let of_bearing = |bearing: &BearingRows| {
            let inertia = self.inertia(system, bearing);
            let of_force = &bearing.unbalance_loads + mul(&inertia, &self.unbalance_columns);
            let of_contact = &bearing.contact_loads + mul(&inertia, &self.contact_columns);
            let weight = &inertia * bladeoff_numerics::linalg::Vector::from_column_slice(&self.weight);
            DirectFeedthrough {
                of_force: squares(&of_force),
                of_contact: squares(&of_contact),
                constant: [bearing.weight_load[0] + weight[0], bearing.weight_load[1] + weight[1]],
            }
        };
        self.rows_at(system, spin).iter().map(of_bearing).collect()
    }

    /// `-K_b R sum_s E_s m_s Phi_s M^-1`: load per generalised force, by the inertia of the unbalances' masses on the truncated modes.
    fn inertia(&self, system: &StateSpace, bearing: &BearingRows) -> Matrix {
        let mut site_inertia = self.unbalance_columns.transpose();
        for (k, mut row) in site_inertia.row_iter_mut().enumerate() {
            row.scale_mut(-self.masses[k / 2]);
        }
        mul(&mul(&bearing.unbalance_loads, &site_inertia), &system.inverse_mass)
    }
}

/// 2 x 2 blocks of a matrix with two rows, from left to right, each by rows.
fn squares(matrix: &Matrix) -> Vec<[f64; 4]> {
    let at = |i: usize, j: usize| matrix[(i, j)];
    (0..matrix.ncols() / 2).map(|s| [at(0, 2 * s), at(0, 2 * s + 1), at(1, 2 * s), at(1, 2 * s + 1)]).collect()
}

/// Supports in the order of the output rows, each with the force that its seat takes from the load \[N\], or with the place of its seat \[m\].
fn supports(machine: &Machine, structure: &Structure) -> Vec<(BearingSite, [f64; 2])> {
    let rotor = &structure.rotor;
    let bearings = || rotor.bearings.iter().zip(&machine.rotor.bearings);
    let loads = rotor.bearings.iter().copied().zip(rotor.seat_forces(&machine.rotor));
    let loads = loads.chain(rotor.pedestals.iter().map(|site| (*site, [0.0; 2])));
    let journals = bearings().filter(|(_, bearing)| bearing.clearance.is_some());
    let journals = journals.map(|(site, bearing)| (journal_displacement(site), bearing.elevation));
    let monitors = machine.monitors.iter().map(|monitor| monitor.node);
    let monitors = monitors.map(|node| (BearingSite::unit(node, rotor.plane_places(node)), [0.0; 2]));
    loads.chain(journals).chain(monitors).collect()
}

/// Bearing of unit stiffness without damping, whose load (1) is the displacement of the journal.
fn journal_displacement(bearing: &BearingSite) -> BearingSite {
    BearingSite { stiffness: [[1.0, 0.0], [0.0, 1.0]], skew: 0.0, damping: [[0.0; 2]; 2], ..*bearing }
}

/// Terms of the load of a bearing; `nodes`: those of the unbalances and of the diaphragms.
fn bearing_rows(structure: &Structure, nodes: [&[usize]; 2], weight: &[f64], bearing: &BearingSite) -> BearingRows {
    let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
    let n = map.size();
    let rows_of =
        |site: &BearingSite| Matrix::from_column_slice(n, 2, &site.rows(|place| map.row(place)).concat()).transpose();
    let (k, nodal_rows) = (square(&bearing.stiffness), rows_of(bearing));
    let mut terms = BearingRows {
        displacement_rows: mul(&k, &nodal_rows),
        velocity_rows: mul(&square(&bearing.damping), &nodal_rows),
        gyroscopic_rows: Matrix::zeros(2, n),
        unbalance_loads: Matrix::zeros(2, 2 * nodes[0].len()),
        contact_loads: Matrix::zeros(2, 2 * nodes[1].len()),
        weight_load: [0.0; 2],
    };
    let Some(residual) = &structure.lateral_residual else {
        return terms;
    };
    // K_b R on forces on all nodes, on forces on one node, and on forces across a bearing
    let residual_rows = bearing.rows(|place| residual.row(place).iter().copied().collect());
    let residual_rows = Matrix::from_column_slice(residual.ncols(), 2, &residual_rows.concat()).transpose();
    let residual = mul(&k, &residual_rows);
    let at = |node: usize| residual.select_columns(&rotor.plane_places(node));
    for other in rotor.supports() {
        let skew = Matrix::from_row_slice(2, 2, &[0.0, -other.skew, other.skew, 0.0]);
        let (rows, across) = (rows_of(other), other.rows(|place| residual.column(place).iter().copied().collect()));
        let across = Matrix::from_column_slice(2, 2, &across.concat());
        terms.displacement_rows += mul(&across, &mul(&skew, &rows));
        terms.velocity_rows -= mul(&across, &mul(&square(&other.damping), &rows));
    }
    if let Some(shapes) = map.shapes() {
        terms.gyroscopic_rows = -mul(&residual, &mul(&rotor.gyroscopic(), shapes));
    }
    for (nodes, loads) in nodes.into_iter().zip([&mut terms.unbalance_loads, &mut terms.contact_loads]) {
        for (s, &node) in nodes.iter().enumerate() {
            loads.view_mut((0, 2 * s), (2, 2)).copy_from(&at(node));
        }
    }
    let weight_load = mul(&residual, &Matrix::from_column_slice(weight.len(), 1, weight));
    terms.weight_load = [weight_load[0], weight_load[1]];
    terms
}
