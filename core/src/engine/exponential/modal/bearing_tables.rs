//! Bearing tables of the lateral motion: stiffness and damping of bearings that change with the spin.
//!
//! ```text
//! K(W) = K_c + sum over tables  N^T dK(W) N,    C(W) = C_c + sum over tables  N^T dC(W) N                               (1)
//! strain energy   x^T dKs(W) x/2,  x = N q      beside that of K_c                                                        (2)
//! work of a table, from interval to interval     x^T (dKs(W+) - dKs(W)) x/2                                               (3)
//! ```
//!
//! | symbol | quantity |
//! |---|---|
//! | `K_c`, `C_c` | constant parts of the tables, which the matrices of the structure contain |
//! | `dK`, `dC` | differences of the table's coefficients at the spin W from its constant part, 2 x 2; `dKs`: symmetric part |
//! | `N` | rows of the displacement across the bearing on the lateral coordinates q, 2 x n |
//!
//! A speed interval has the coefficients between those of its two bases, in proportion, as it has all other quantities. They are constant in the interval, and change
//! in steps from interval to interval. (3) is then the exact change of (2) at a fixed displacement, and the energy of a run closes only with it.
//! Source: docs/theory/01-shaft-line.md, "Tables over the speed". Limits: the moving static point does no work; each basis has the table at its own speed, so a table
//! that bends between two bases is straight there ([`super::grid_spacing`] refines the grid).
//! Verified by `tests/exponential/bearing_tables.rs`.

use crate::rotor::BearingSite;
use crate::structure::Structure;
use bladeoff_model::machine::BearingTable;
use bladeoff_numerics::linalg::{Matrix, dot, mul, mul_tn};

/// Bearing tables on the lateral coordinates of a structure; empty without tables.
#[derive(Debug, Clone)]
pub(crate) struct BearingTables(Vec<TableSite>);

/// A bearing with a table.
#[derive(Debug, Clone)]
struct TableSite {
    /// Its place among the bearings.
    bearing: usize,
    /// The bearing with the constant part of its table.
    constant: BearingSite,
    table: BearingTable,
    /// N, 2 x n.
    rows: Matrix,
}

/// Differences of all tables from their constant parts, at one speed or in one speed interval.
pub(crate) type TableChanges = Vec<BearingSite>;

impl BearingTables {
    /// Bearing tables of a structure.
    pub fn new(structure: &Structure) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let site = |(bearing, table): &(usize, BearingTable)| {
            let constant = rotor.bearings[*bearing];
            let rows = constant.rows(|place| map.row(place)).concat();
            let rows = Matrix::from_column_slice(map.size(), 2, &rows).transpose();
            TableSite { bearing: *bearing, constant, table: table.clone(), rows }
        };
        Self(rotor.tables.iter().map(site).collect())
    }

    /// Whether no bearing has a table.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Place among the bearings, and N, of each table.
    pub fn sites(&self) -> impl Iterator<Item = (usize, &Matrix)> {
        self.0.iter().map(|site| (site.bearing, &site.rows))
    }

    /// Lowest and highest speed that all tables have \[rad/s\].
    pub fn range(&self) -> [f64; 2] {
        let ranges = self.0.iter().map(|site| site.table.range());
        ranges.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], [from, to]| [from.max(low), to.min(high)])
    }

    /// Largest sizes of the stiffnesses \[N/m\] and of the damping coefficients \[N s/m\] of each table.
    pub fn largest(&self) -> Vec<[f64; 2]> {
        let size = |m: &[[f64; 2]; 2]| m.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        let of_table = |site: &TableSite| {
            site.table
                .at_nodes()
                .fold([0.0_f64; 2], |[k, c], at| [k.max(size(&at.stiffness)), c.max(size(&at.damping))])
        };
        self.0.iter().map(of_table).collect()
    }

    /// Largest difference of two sets of changes, as a share of the largest coefficients of [`BearingTables::largest`].
    pub fn departure(&self, [one, other]: [&TableChanges; 2], largest: &[[f64; 2]]) -> f64 {
        let of = |x: &[[f64; 2]; 2], y: &[[f64; 2]; 2], largest: f64| {
            let parts = x.iter().flatten().zip(y.iter().flatten());
            parts.fold(0.0_f64, |sum, (x, y)| if largest > 0.0 { sum.max((x - y).abs() / largest) } else { sum })
        };
        one.iter().zip(other).zip(largest).fold(0.0, |sum, ((x, y), [k, c])| {
            sum.max(of(&x.stiffness, &y.stiffness, *k)).max(of(&x.damping, &y.damping, *c))
        })
    }

    /// dK and dC at a spin \[rad/s\].
    pub fn changes(&self, spin: f64) -> TableChanges {
        self.0.iter().map(|site| site.constant.change_to(&site.table.extended(spin))).collect()
    }

    /// Changes between those of two bases, with the shares of both.
    pub fn between([lower, upper]: [&TableChanges; 2], [a, b]: [f64; 2]) -> TableChanges {
        let mix = |x: &[[f64; 2]; 2], y: &[[f64; 2]; 2]| [0, 1].map(|i| [0, 1].map(|j| a * x[i][j] + b * y[i][j]));
        let both = lower.iter().zip(upper);
        both.map(|(x, y)| BearingSite {
            stiffness: mix(&x.stiffness, &y.stiffness),
            skew: a * x.skew + b * y.skew,
            damping: mix(&x.damping, &y.damping),
            ..*x
        })
        .collect()
    }

    /// One of the two matrices of (1), n x n, from the changes at a spin; `None` without tables.
    pub fn matrix(&self, changes: &TableChanges, of_change: impl Fn(&BearingSite) -> &[[f64; 2]; 2]) -> Option<Matrix> {
        let of_table = |(site, change): (&TableSite, &BearingSite)| {
            mul_tn(&site.rows, &mul(&square(of_change(change)), &site.rows))
        };
        self.0.iter().zip(changes).map(of_table).reduce(|sum, matrix| sum + matrix)
    }

    /// Changes of K and of C between two spins \[rad/s\], and dC at the first; `None` without tables.
    pub fn changes_between(&self, from: f64, to: f64) -> Option<[Matrix; 3]> {
        let [before, after] = [from, to].map(|spin| self.changes(spin));
        let difference = Self::between([&before, &after], [-1.0, 1.0]);
        Some([
            self.matrix(&difference, |change| &change.stiffness)?,
            self.matrix(&difference, |change| &change.damping)?,
            self.matrix(&before, |change| &change.damping)?,
        ])
    }

    /// (2) of the lateral coordinates q \[J\].
    pub fn strain_energy(&self, changes: &TableChanges, q: &[f64]) -> f64 {
        let energy = |(site, change): (&TableSite, &BearingSite)| {
            let q = &q[..site.rows.ncols()];
            let x = [0, 1].map(|axis| dot(site.rows.row(axis).transpose().as_slice(), q));
            0.5 * change.stiffness_form(x, x)
        };
        self.0.iter().zip(changes).map(energy).sum()
    }
}

/// 2 x 2 matrix.
pub(super) fn square(m: &[[f64; 2]; 2]) -> Matrix {
    Matrix::from_row_slice(2, 2, &[m[0][0], m[0][1], m[1][0], m[1][1]])
}

#[cfg(test)]
mod tests {
    use super::super::modal_basis::{LateralModel, ModalBasis};
    use super::super::outputs::Outputs;
    use super::super::section_loads::SectionLoadModel;
    use super::super::state_space::StateSpace;
    use super::*;
    use bladeoff_model::machine::MachineDef;

    /// Lab rig whose left bearing has a table with cross terms.
    fn rig() -> LateralModel {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let linear = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\n";
        let table = "kind = \"table\"\ninterpolation = \"pchip\"\ncoefficients = { speeds = [0, 200, 500], kxx = [4e6, 2e6, 1.5e6], kxy = [4e5, 2e5, 1e5], \
                     kyx = [-3e5, -1e5, -1e5], kyy = [2.4e6, 2e6, 1.9e6], cxx = [2e3, 700, 600], cyx = [-200, -100, 50], cyy = [1500, 600, 500] }\n";
        assert!(text.contains(linear));
        let text = text.replacen(linear, table, 1);
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let state_space = StateSpace::new(&machine, &structure).expect("regular");
        let outputs = Outputs::new(&machine, &structure);
        let measures = SectionLoadModel::new(&machine, &structure, &state_space, outputs.weight());
        LateralModel { state_space, outputs, measures }
    }

    #[test]
    fn the_change_of_the_system_matrix_is_that_of_the_tables_too() {
        let system = rig().state_space;
        for [from, to] in [[300.0, 310.0], [310.0, 180.0], [4.0, 0.5]] {
            let matrix = system.system_matrix(to);
            let difference = &matrix - system.system_matrix(from);
            let error = (system.system_matrix_change(from, to) - &difference).amax();
            assert!(error < 1e-13 * matrix.amax(), "{from} {to}: {error:e} of {:e}", matrix.amax());
            // the table is part of it
            let [k, _, _] = system.tables.changes_between(from, to).expect("a table");
            assert!(k.amax() > 0.0);
        }
    }

    #[test]
    fn bases_are_continued_through_a_table() {
        let model = rig();
        let mut basis = ModalBasis::new(&model, 320.0, None).expect("has a basis");
        for step in 1..30 {
            let speed = 320.0 - 8.0 * f64::from(step);
            let continued = ModalBasis::new(&model, speed, Some(&basis)).expect("has a basis");
            let own = ModalBasis::new(&model, speed, None).expect("has a basis");
            let spectrum = |basis: &ModalBasis| {
                let mut traces: Vec<f64> = basis.blocks.iter().map(|block| block[0] + block[3]).collect();
                traces.sort_by(f64::total_cmp);
                traces
            };
            let largest = spectrum(&own).iter().fold(0.0_f64, |largest, trace| largest.max(trace.abs()));
            for (one, other) in spectrum(&continued).iter().zip(&spectrum(&own)) {
                assert!((one - other).abs() < 1e-9 * largest, "{speed}: {one} {other}");
            }
            basis = continued;
        }
    }
}
