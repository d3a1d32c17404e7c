//! Load of a bearing, a pedestal or a displacement sensor of a machine with bearing tables, at any spin.
//!
//! ```text
//! d     = (terms of the constant parts) - sum over tables  R_ij (dK_j N_j q + dC_j N_j q')                 displacement across support i      (1)
//! load  = K_i(W) d + C_i(W) N_i q' - s_i
//! ```
//!
//! | symbol | quantity |
//! |---|---|
//! | `dK_j`, `dC_j` | differences of table j at the spin W from its constant part ([`super::bearing_tables`]) |
//! | `N_j` | rows of the displacement across table j on the lateral coordinates |
//! | `R_ij` | residual flexibility: displacement across support i that forces across table j make in the truncated modes, 2 x 2 \[m/N\] |
//! | `K_i`, `C_i` | stiffness and damping of the support; a sensor has unit stiffness |
//! | `s_i` | force that the seat takes from the load \[N\] |
//!
//! (1) is the load of the reduced engine: the differences act on the displacement of the modes kept. Verified by `tests/exponential/bearing_tables.rs`.

use super::bearing_tables::{BearingTables, TableChanges, square};
use crate::rotor::BearingSite;
use crate::structure::Structure;
use bladeoff_numerics::linalg::{Matrix, mul};

/// Terms of the load of one bearing in `outputs`, equation (1), before q'' is replaced; all matrices have two rows (u, v).
#[derive(Debug, Clone)]
pub(super) struct BearingRows {
    /// Load per q.
    pub displacement_rows: Matrix,
    /// Load per q', without the gyroscopic part.
    pub velocity_rows: Matrix,
    /// Load per q' and unit spin.
    pub gyroscopic_rows: Matrix,
    /// `K_b R E_s`: load per force on the nodes of the unbalances, two columns each.
    pub unbalance_loads: Matrix,
    /// `K_b R E_c`: load per force on the nodes of the diaphragms, two columns each.
    pub contact_loads: Matrix,
    /// `K_b (R w - e)` \[N\].
    pub weight_load: [f64; 2],
}

/// Terms of (1) of one support.
#[derive(Debug, Clone)]
pub(super) struct SupportLoads {
    /// Terms of d with the constant parts of the tables.
    displacement: BearingRows,
    /// N_i, 2 x n.
    rows: Matrix,
    /// R_ij of each table j; `None` without truncated modes.
    flexibility: Option<Vec<Matrix>>,
    /// The support with the constant part of its table.
    constant: BearingSite,
    /// Number of its table; `None` of a support without one.
    table: Option<usize>,
    /// s_i.
    seat: [f64; 2],
}

impl SupportLoads {
    /// Terms of a support with the force of its seat; `displacement`: those of a support of unit stiffness; `bearing`: place among the bearings.
    pub fn new(
        structure: &Structure,
        (site, seat): (&BearingSite, [f64; 2]),
        bearing: Option<usize>,
        displacement: BearingRows,
    ) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let across = |rows: [Vec<f64>; 2]| Matrix::from_column_slice(rows[0].len(), 2, &rows.concat()).transpose();
        let flexibility = structure.lateral_residual.as_ref().map(|residual| {
            let row = across(site.rows(|place| residual.row(place).iter().copied().collect()));
            let table = |(at, _): &(usize, _)| {
                let columns = rotor.bearings[*at].rows(|place| row.column(place).iter().copied().collect());
                Matrix::from_column_slice(2, 2, &columns.concat())
            };
            rotor.tables.iter().map(table).collect()
        });
        Self {
            displacement,
            rows: across(site.rows(|place| map.row(place))),
            flexibility,
            constant: *site,
            table: rotor.tables.iter().position(|(at, _)| bearing == Some(*at)),
            seat,
        }
    }

    /// Terms of the load, with the changes of all tables at a spin.
    pub fn rows(&self, tables: &BearingTables, changes: &TableChanges) -> BearingRows {
        let site = self.table.map_or(self.constant, |table| self.constant.changed_by(&changes[table]));
        let (k, c) = (square(&site.stiffness), square(&site.damping));
        let BearingRows { mut displacement_rows, mut velocity_rows, weight_load, .. } = self.displacement.clone();
        for ((flexibility, change), (_, rows)) in self.flexibility.iter().flatten().zip(changes).zip(tables.sites()) {
            displacement_rows -= mul(flexibility, &mul(&square(&change.stiffness), rows));
            velocity_rows -= mul(flexibility, &mul(&square(&change.damping), rows));
        }
        let load = site.load(weight_load, [0.0; 2]);
        BearingRows {
            displacement_rows: mul(&k, &displacement_rows),
            velocity_rows: mul(&k, &velocity_rows) + mul(&c, &self.rows),
            gyroscopic_rows: mul(&k, &self.displacement.gyroscopic_rows),
            unbalance_loads: mul(&k, &self.displacement.unbalance_loads),
            contact_loads: mul(&k, &self.displacement.contact_loads),
            weight_load: [load[0] - self.seat[0], load[1] - self.seat[1]],
        }
    }
}
