//! What is read from the lateral motion, linearly: velocities of the unbalances' nodes, loads of the bearings, places of the contacts.
//!
//! ```text
//! load  = K (Phi q + R f) + C Phi q'                                       R static flexibility of the modes left out                 (1)
//! f     = w - W S Phi q' + skew - C Phi q' + sum_s E_s (f_s - m_s Phi_s q'') + E_c f_c     weight, gyroscopic, bearings, unbalances, contact
//! q''   = M^-1 [Phi^T (w + sum_s E_s f_s) - (C + W G) q' - K q],      f_s = m d (psi'^2 - i psi'') e^{i psi}                          (2)
//! ```
//! All of it is linear in q, q' and the unbalances' forces at a given spin: one row of the basis for each output, one 2 x 2 matrix for each bearing and
//! unbalance, one constant. (1) is the load of the reduced engine; W'/2 of the gyroscopic moments is not in its static part (1e-4 of a part of it).
//! Source: docs/theory/05-reduction.md, "Bearing loads". Verified by `tests/exponential.rs`.

use super::state_space::StateSpace;
use crate::engine::shaft_line::sites;
use crate::linalg::{Matrix, mul};
use crate::rotor::BearingSite;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Outputs: two rows for each unbalance (u', v'), two for each bearing (its load), two for each bearing with a clearance (the displacement of its journal, as a load of unit stiffness), four for each diaphragm (u, v, u', v' of its node).
#[derive(Debug, Clone)]
pub(crate) struct Outputs {
    /// Phi^T of the unbalances' nodes, two columns each.
    site_columns: Matrix,
    masses: Vec<f64>,
    contact_columns: Matrix,
    bearings: Vec<BearingRows>,
    /// Phi^T w.
    weight: Vec<f64>,
}

/// The terms of (1) for one bearing, (2) not yet in it.
#[derive(Debug, Clone)]
struct BearingRows {
    of_place: Matrix,
    of_velocity: Matrix,
    /// Per W.
    of_gyration: Matrix,
    /// Of forces on the unbalances' nodes: `K R E_s`, two columns each.
    of_sites: Matrix,
    /// The same of forces on the diaphragms' nodes.
    of_contacts: Matrix,
    of_weight: [f64; 2],
}

/// What a bearing's load has besides its rows.
#[derive(Debug, Clone)]
pub(crate) struct DirectFeedthrough {
    /// Of each unbalance's force and of a force on each diaphragm's node, by rows.
    pub of_force: Vec<[f64; 4]>,
    pub of_contact: Vec<[f64; 4]>,
    pub constant: [f64; 2],
}

impl Outputs {
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
        let gravity = machine.rotor.gravity;
        let mut nodal_weight = rotor.weight(gravity);
        for site in &sites {
            rotor.add_at(site.node, gravity.map(|g| site.mass * g), &mut nodal_weight);
        }
        let mut weight = vec![0.0; map.size()];
        map.project(&nodal_weight, &mut weight);
        let nodes = [site_nodes.as_slice(), &contact_nodes];
        let rows = |bearing: &BearingSite| bearing_rows(structure, nodes, &nodal_weight, bearing);
        let loads = rotor.bearings.iter().map(rows);
        let journals = rotor.bearings.iter().zip(&machine.rotor.bearings).filter(|(_, of)| of.clearance.is_some());
        let bearings = loads.chain(journals.map(|(bearing, _)| rows(&displacement_of(bearing)))).collect();
        Self {
            site_columns: columns(&site_nodes),
            contact_columns: columns(&contact_nodes),
            masses: sites.iter().map(|site| site.mass).collect(),
            bearings,
            weight,
        }
    }

    /// Place of the first row of a bearing.
    pub fn load_row(&self, bearing: usize) -> usize {
        self.site_columns.ncols() + 2 * bearing
    }

    /// Phi^T w.
    pub fn weight(&self) -> &[f64] {
        &self.weight
    }

    /// How many unbalances.
    pub fn unbalances(&self) -> usize {
        self.masses.len()
    }

    /// Places of the first rows of all bearings.
    pub fn load_rows(&self) -> Vec<usize> {
        (0..self.bearings.len()).map(|bearing| self.load_row(bearing)).collect()
    }

    /// Largest share of a coordinate's rate in a bearing's load, before rates cancel \[N s/m\].
    pub fn of_velocity(&self, bearing: usize) -> f64 {
        self.bearings[bearing].of_velocity.amax()
    }

    /// Whether there is a diaphragm.
    pub fn has_contact(&self) -> bool {
        self.contact_columns.ncols() > 0
    }

    /// Place of the first row of a diaphragm.
    pub fn contact_row(&self, diaphragm: usize) -> usize {
        self.load_row(self.bearings.len()) + 4 * diaphragm
    }

    /// Y: rows on (q, q') at a spin.
    pub fn output_rows(&self, system: &StateSpace, spin: f64) -> Matrix {
        let (n, sites) = (system.size, self.site_columns.ncols());
        let contacts = self.contact_columns.ncols();
        let mut y = Matrix::zeros(self.contact_row(contacts / 2), 2 * n);
        y.view_mut((0, n), (sites, n)).copy_from(&self.site_columns.transpose());
        let velocity_terms = &system.damping + &system.gyroscopic * spin;
        for (i, bearing) in self.bearings.iter().enumerate() {
            let inertia = self.inertia(system, bearing);
            let of_place = &bearing.of_place - mul(&inertia, &system.stiffness);
            let of_velocity = &bearing.of_velocity + &bearing.of_gyration * spin - mul(&inertia, &velocity_terms);
            y.view_mut((self.load_row(i), 0), (2, n)).copy_from(&of_place);
            y.view_mut((self.load_row(i), n), (2, n)).copy_from(&of_velocity);
        }
        for k in 0..contacts {
            let row = self.contact_row(k / 2) + k % 2;
            y.view_mut((row, 0), (1, n)).copy_from(&self.contact_columns.column(k).transpose());
            y.view_mut((row + 2, n), (1, n)).copy_from(&self.contact_columns.column(k).transpose());
        }
        y
    }

    /// Pushes of a unit force on the unbalances' nodes, two columns each, of the weight, and on the diaphragms' nodes.
    pub fn input_vectors(&self, system: &StateSpace) -> Matrix {
        let push = |matrix: &Matrix| {
            matrix.column_iter().flat_map(|c| system.input_vector(c.as_slice())).collect::<Vec<f64>>()
        };
        let all = [push(&self.site_columns), system.input_vector(&self.weight), push(&self.contact_columns)].concat();
        Matrix::from_column_slice(2 * system.size, self.contact_input(0) + self.contact_columns.ncols(), &all)
    }

    /// Place of the first push of a diaphragm.
    pub fn contact_input(&self, diaphragm: usize) -> usize {
        self.site_columns.ncols() + 1 + 2 * diaphragm
    }

    /// What loads have of forces at once.
    pub fn feedthrough(&self, system: &StateSpace) -> Vec<DirectFeedthrough> {
        let of = |bearing: &BearingRows| {
            let inertia = self.inertia(system, bearing);
            let of_force = &bearing.of_sites + mul(&inertia, &self.site_columns);
            let of_contact = &bearing.of_contacts + mul(&inertia, &self.contact_columns);
            let weight = &inertia * crate::linalg::Vector::from_column_slice(&self.weight);
            DirectFeedthrough {
                of_force: squares(&of_force),
                of_contact: squares(&of_contact),
                constant: [bearing.of_weight[0] + weight[0], bearing.of_weight[1] + weight[1]],
            }
        };
        self.bearings.iter().map(of).collect()
    }

    /// `-K R sum_s E_s m_s Phi_s M^-1`: (2) before its forces.
    fn inertia(&self, system: &StateSpace, bearing: &BearingRows) -> Matrix {
        let mut held = self.site_columns.transpose();
        for (k, mut row) in held.row_iter_mut().enumerate() {
            row.scale_mut(-self.masses[k / 2]);
        }
        mul(&mul(&bearing.of_sites, &held), &system.inverse_mass)
    }
}

/// Its 2 x 2 blocks side by side, each by rows.
fn squares(matrix: &Matrix) -> Vec<[f64; 4]> {
    let at = |i: usize, j: usize| matrix[(i, j)];
    (0..matrix.ncols() / 2).map(|s| [at(0, 2 * s), at(0, 2 * s + 1), at(1, 2 * s), at(1, 2 * s + 1)]).collect()
}

/// A bearing whose load (1) is the displacement of its journal: unit stiffness, no damping.
fn displacement_of(bearing: &BearingSite) -> BearingSite {
    BearingSite { node: bearing.node, stiffness: [[1.0, 0.0], [0.0, 1.0]], skew: 0.0, damping: [[0.0; 2]; 2] }
}

/// `nodes`: of the unbalances and of the diaphragms.
fn bearing_rows(structure: &Structure, nodes: [&[usize]; 2], weight: &[f64], bearing: &BearingSite) -> BearingRows {
    let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
    let n = map.size();
    let rows_of = |node: usize| {
        let rows: Vec<f64> = rotor.plane_places(node).into_iter().flat_map(|dof| map.row(dof)).collect();
        Matrix::from_column_slice(n, 2, &rows).transpose()
    };
    let square = |m: &[[f64; 2]; 2]| Matrix::from_row_slice(2, 2, &[m[0][0], m[0][1], m[1][0], m[1][1]]);
    let (k, own) = (square(&bearing.stiffness), rows_of(bearing.node));
    let mut found = BearingRows {
        of_place: mul(&k, &own),
        of_velocity: mul(&square(&bearing.damping), &own),
        of_gyration: Matrix::zeros(2, n),
        of_sites: Matrix::zeros(2, 2 * nodes[0].len()),
        of_contacts: Matrix::zeros(2, 2 * nodes[1].len()),
        of_weight: [0.0; 2],
    };
    let Some(residual) = &structure.lateral_residual else {
        return found;
    };
    // K R on all nodal freedoms, and of a node
    let yielding = mul(&k, &residual.select_rows(&rotor.plane_places(bearing.node)));
    let at = |node: usize| yielding.select_columns(&rotor.plane_places(node));
    for other in &rotor.bearings {
        let skew = Matrix::from_row_slice(2, 2, &[0.0, -other.skew, other.skew, 0.0]);
        let rows = rows_of(other.node);
        found.of_place += mul(&at(other.node), &mul(&skew, &rows));
        found.of_velocity -= mul(&at(other.node), &mul(&square(&other.damping), &rows));
    }
    if let Some(shapes) = map.shapes() {
        found.of_gyration = -mul(&yielding, &mul(&rotor.gyroscopic(), shapes));
    }
    for (nodes, of) in nodes.into_iter().zip([&mut found.of_sites, &mut found.of_contacts]) {
        for (s, &node) in nodes.iter().enumerate() {
            of.view_mut((0, 2 * s), (2, 2)).copy_from(&at(node));
        }
    }
    let pressed = mul(&yielding, &Matrix::from_column_slice(weight.len(), 1, weight));
    found.of_weight = [pressed[0], pressed[1]];
    found
}
