//! Torsional modes of a shaft line that carries its unbalances.
//!
//! ```text
//! 2T   = J phi'^2 + n'^T n' + sum_st A_st psi_s' psi_t',     psi_s' = phi' + t_s.n'                                          (1)
//! A_st = m_s d_s^2 [s = t] - Q_st,    Q_st = (m d)_s (m d)_t (M^-1)_st cos(a_s - a_t)                                        (2)
//! phi  = Phi + b.e,   n = V e                                e has unit mass and is diagonal in (1)                          (3)
//! ```
//! phi: mean angle of the shaft line without unbalances; n: its elastic torsional modes, t_s: their row at unbalance s; psi_s:
//! angle of unbalance s, m_s, d_s, a_s its mass, radius and phase; M: lateral mass matrix; Q: compliance inertia, the inertia
//! that a jump of psi' does not meet because the node moves at once; Phi: mean angle of shaft line and unbalances; e: loaded
//! modes.
//!
//! An unbalance on a bare shaft has many times the polar inertia of its place. As a torque of the step its inertia A would feed
//! back into torsional modes that no step resolves (it did, and they grew). In the modes (3) it is exact at any step. The rest of
//! the unbalance's momentum is exchanged with the slow lateral motion, as torques that change slowly ([`super::spin`]).
//!
//! Source: (1) and (2) are the Lagrangian of docs/theory/01-shaft-line.md. Limits: (2) has the whole response of the rotor to a
//! jump of psi'; the part of it that a step does not resolve feeds back ([`super::spin`]). Damping must be proportional to
//! stiffness, as that of the torsion is, to stay diagonal in (3). Verified by the tests below and
//! `unbalances_on_a_bare_shaft_do_not_shake_it` (`tests/exponential/exponential.rs`).

use crate::engine::exponential::error::ExponentialError;
use crate::engine::shaft_line::{masses, sites};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::lanes::LANES;
use bladeoff_numerics::linalg::{Matrix, column_of, dot, inverse, mul_vec, norm, symmetric_generalised};

/// Largest part of a uniform rotation in an elastic torsional mode.
const ELASTIC: f64 = 1e-6;

/// Loaded torsional modes (3).
#[derive(Debug, Clone)]
pub(crate) struct LoadedModes {
    /// Inertia of the mean angle Phi: shaft line and unbalances \[kg m2\]. Infinite where the speed is prescribed: then Phi is phi.
    pub inertia: f64,
    /// sum_t A_st of (2), by unbalance s \[kg m2\].
    pub unbalance_inertias: Vec<f64>,
    /// Square of the frequency \[1/s2\] and damping \[1/s\] of each mode, up to a multiple of eight.
    pub modes: Vec<(f64, f64)>,
    /// Compliance inertia Q \[kg m2\], `Q_st` in column s.
    pub compliance_inertia: Matrix,
    /// Indices of the elastic modes of the bare shaft line.
    elastic_indices: Vec<usize>,
    /// V of (3): amplitudes of the elastic modes of the bare shaft line, a column for each loaded mode.
    bare_amplitudes: Matrix,
    /// b of (3), up to a multiple of eight: the row of phi beside Phi, along which brakes act.
    pub shift: Vec<f64>,
}

impl LoadedModes {
    /// Creates the loaded modes of a machine.
    ///
    /// # Errors
    /// [`ExponentialError::Singular`] where a lost mass is larger than the mass that was there.
    pub fn new(machine: &Machine, structure: &Structure) -> Result<Self, ExponentialError> {
        let (sites, torsion) = (sites(machine), &structure.torsion);
        let elastic_indices = elastic_modes(structure);
        let count = elastic_indices.len();
        let rows: Vec<Vec<f64>> =
            sites.iter().map(|site| bare_row(structure, &elastic_indices, site.torsional_node)).collect();
        let (lateral, _) = masses(structure, &sites);
        let inverse_mass = inverse(&lateral).ok_or(ExponentialError::Singular { part: "the shaft line" })?;
        let node_rows: Vec<Vec<f64>> = sites
            .iter()
            .map(|site| structure.lateral.coordinates.row(structure.rotor.plane_places(site.node)[0]))
            .collect();
        let node_compliance = |s: usize, t: usize| -> f64 {
            node_rows[t]
                .iter()
                .enumerate()
                .map(|(j, part)| part * dot(column_of(&inverse_mass, j), &node_rows[s]))
                .sum()
        };
        let of = |s: usize, t: usize| {
            let [one, other] = [s, t].map(|at| sites[at].mass * sites[at].radius);
            one * other * node_compliance(s, t) * libm::cos(sites[s].phase - sites[t].phase)
        };
        let compliance_inertia = Matrix::from_fn(sites.len(), sites.len(), |t, s| of(s, t));
        let residual_inertia = |s: usize, t: usize| {
            let site_row = if s == t { sites[s].mass * sites[s].radius * sites[s].radius } else { 0.0 };
            site_row - compliance_inertia[(t, s)]
        };
        // (1) in Phi' and n': inertia of the first row and column, their coupling, and the rest
        let (mut inertia, mut coupling) = (structure.rotor.torsional_mass.sum(), vec![0.0; count]);
        let mut mass = Matrix::identity(count, count);
        for s in 0..sites.len() {
            for t in 0..sites.len() {
                let a = residual_inertia(s, t);
                inertia += a;
                for i in 0..count {
                    coupling[i] += a * rows[s][i];
                    for j in 0..count {
                        mass[(i, j)] += a * rows[s][i] * rows[t][j];
                    }
                }
            }
        }
        if inertia <= 0.0 {
            return Err(ExponentialError::Singular { part: "the torsion" });
        }
        if machine.rotor.speed_law.is_some() {
            inertia = f64::INFINITY;
        }
        let unbalance_inertias =
            (0..sites.len()).map(|s| (0..sites.len()).map(|t| residual_inertia(s, t)).sum()).collect();
        // the rest less its coupling to Phi
        let (mut mass, mut stiffness) = (mass, Matrix::zeros(count, count));
        for i in 0..count {
            stiffness[(i, i)] = torsion.stiffness[(elastic_indices[i], elastic_indices[i])];
            for j in 0..count {
                mass[(i, j)] -= coupling[i] * coupling[j] / inertia;
            }
        }
        let (squares, bare_amplitudes) =
            symmetric_generalised(&stiffness, &mass, "torsion of the shaft with its unbalances")?;
        let mut shift: Vec<f64> =
            (0..count).map(|j| -dot(&coupling, column_of(&bare_amplitudes, j)) / inertia).collect();
        shift.resize(count.next_multiple_of(LANES), 0.0);
        let damping = |j: usize| -> f64 {
            let parts = elastic_indices.iter().zip(column_of(&bare_amplitudes, j));
            parts.map(|(&i, part)| torsion.damping[(i, i)] * part * part).sum()
        };
        let mut modes: Vec<(f64, f64)> = (0..count).map(|j| (squares[j], damping(j))).collect();
        modes.resize(count.next_multiple_of(LANES), (1.0, 0.0));
        Ok(Self { inertia, unbalance_inertias, modes, compliance_inertia, elastic_indices, bare_amplitudes, shift })
    }

    /// Largest number of last steps over which the slope of the spin may be extrapolated. The predicted psi' acts on the rotor,
    /// whose response is a part k < Q/J of it in the spin: with r the ratio of a step to the last one,
    /// `W(n+1) = k [(1 + r) W(n) - r W(n-1)] + ...`. This grows for no sequence of steps where `k (1 + 2 r) < 1`. Beyond that
    /// limit the slope counts for fewer steps; the rest follows in the next step.
    pub fn max_extrapolation(&self) -> f64 {
        let total_compliance = self.compliance_inertia.iter().map(|q| q.abs()).sum::<f64>();
        (0.5 * (self.inertia / total_compliance - 1.0)).max(1.0)
    }

    /// Mean angle of the bare shaft line and amplitudes of its elastic modes, from Phi and amplitudes of the loaded modes, or their rates.
    pub fn to_bare(&self, mean: f64, amplitudes: &[f64]) -> (f64, Vec<f64>) {
        let mut bare = vec![0.0; self.elastic_indices.len()];
        mul_vec(&self.bare_amplitudes, &amplitudes[..bare.len()], &mut bare);
        (mean + dot(&self.shift, amplitudes), bare)
    }

    /// Inverse of [`LoadedModes::to_bare`].
    ///
    /// # Errors
    /// [`ExponentialError::Singular`] where the loaded modes are dependent.
    pub fn of_bare(&self, mean: f64, bare: &[f64]) -> Result<(f64, Vec<f64>), ExponentialError> {
        let inverse = inverse(&self.bare_amplitudes).ok_or(ExponentialError::Singular { part: "the torsion" })?;
        let mut amplitudes = vec![0.0; bare.len()];
        mul_vec(&inverse, bare, &mut amplitudes);
        Ok((mean - dot(&self.shift[..bare.len()], &amplitudes), amplitudes))
    }

    /// Square of the lowest frequency \[1/s2\]; 0 without modes.
    pub fn lowest_square(&self) -> f64 {
        let own = self.modes[..self.elastic_indices.len()].iter().map(|mode| mode.0);
        own.reduce(f64::min).unwrap_or(0.0)
    }

    /// Amplitudes of the elastic modes of the bare shaft line in torsional coordinates.
    pub fn bare_torsion(&self, structure: &Structure, coordinates: &[f64]) -> Vec<f64> {
        debug_assert_eq!(coordinates.len(), structure.torsion.coordinates.size());
        self.elastic_indices.iter().map(|&index| coordinates[index]).collect()
    }

    /// Adds a change of the rates, in torsional coordinates, to the mean rate and the rates of the elastic modes of the bare shaft line.
    pub fn add_to_bare(&self, structure: &Structure, change: &[f64], (mean, bare): (&mut f64, &mut [f64])) {
        let mut weights = vec![0.0; change.len()];
        structure.torsion.coordinates.project(&structure.rotor.spin_weights, &mut weights);
        *mean += dot(&weights, change);
        self.elastic_indices.iter().zip(bare).for_each(|(&index, rate)| *rate += change[index]);
    }

    /// Row of a node's rotation beside Phi on the modes (3), zeros up to a multiple of eight.
    pub fn row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.torsion_row(structure, node).iter().zip(&self.shift).map(|(torsion, shift)| torsion + shift).collect()
    }

    /// Row of a node's torsion, its rotation beside phi, on the modes (3), zeros up to a multiple of eight.
    pub fn torsion_row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        let bare = bare_row(structure, &self.elastic_indices, node);
        let mut row: Vec<f64> = (0..bare.len()).map(|j| dot(&bare, column_of(&self.bare_amplitudes, j))).collect();
        row.resize(self.modes.len(), 0.0);
        row
    }
}

/// Row of a node's torsion on the elastic modes of the bare shaft line.
fn bare_row(structure: &Structure, elastic_indices: &[usize], node: usize) -> Vec<f64> {
    let row = structure.torsion.coordinates.row(node);
    elastic_indices.iter().map(|&j| row[j]).collect()
}

/// Indices of the torsional modes without uniform rotation.
fn elastic_modes(structure: &Structure) -> Vec<usize> {
    let (rotor, part) = (&structure.rotor, &structure.torsion);
    let rigid = part.coordinates_of(&rotor.torsional_mass, &vec![1.0; rotor.nodes]);
    let whole = norm(&rigid);
    (0..rigid.len()).filter(|&j| rigid[j].abs() < ELASTIC * whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    fn machine(name: &str, changes: &[(&str, &str)]) -> Machine {
        let path = format!("{}/../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let mut definition = MachineDef::parse(&path, &text).expect("parses");
        for (path, value) in changes {
            let info = definition.resolve(path).expect("a path");
            let value = definition.parse_value(&info, value).expect("a value");
            definition.set(&info, &value).expect("allowed");
        }
        definition.build().expect("valid")
    }

    /// The energy (1) of a motion is the same in the modes of the bare shaft line and in (3).
    #[test]
    fn the_modes_have_the_energy_of_the_loaded_shaft_line() {
        for (name, position, mass) in [
            ("lp_turbine_paper", "1.1 m", "12 kg"),
            ("lp_turbine_paper", "5 m", "0.3 kg"),
            ("lab_rig", "0.3 m", "0.2 kg"),
        ] {
            let machine = machine(name, &[("blade_off.position", position), ("blade_off.mass", mass)]);
            let structure = Structure::build(&machine, None).expect("buildable");
            let loaded = LoadedModes::new(&machine, &structure).expect("definite");
            let site = sites(&machine)[0];
            let a = site.mass * site.radius * site.radius - loaded.compliance_inertia[(0, 0)];
            let site_row = loaded.row(&structure, site.torsional_node);
            let (spin, rates): (f64, Vec<f64>) = (
                3.0,
                (0..site_row.len())
                    .map(|j| if j < loaded.elastic_indices.len() { 0.3 - 0.1 * j as f64 } else { 0.0 })
                    .collect(),
            );
            let new = loaded.inertia * spin * spin + dot(&rates, &rates);
            // phi and n of the same motion
            let phi = spin + dot(&loaded.shift, &rates);
            let n: Vec<f64> = (0..loaded.elastic_indices.len())
                .map(|i| (0..loaded.elastic_indices.len()).map(|j| loaded.bare_amplitudes[(i, j)] * rates[j]).sum())
                .collect();
            let psi = phi + dot(&bare_row(&structure, &loaded.elastic_indices, site.torsional_node), &n);
            assert!((psi - spin - dot(&site_row, &rates)).abs() < 1e-12 * psi.abs(), "{name}: {psi}");
            let old = structure.rotor.torsional_mass.sum() * phi * phi + dot(&n, &n) + a * psi * psi;
            assert!((new / old - 1.0).abs() < 1e-12, "{name}: {new} {old}");
            let torsion = &structure.torsion;
            let strain = |e: &[f64]| loaded.modes.iter().zip(e).map(|(mode, e)| mode.0 * e * e).sum::<f64>();
            let bare: f64 =
                loaded.elastic_indices.iter().zip(&n).map(|(&j, n)| torsion.stiffness[(j, j)] * n * n).sum();
            assert!((strain(&rates) / bare - 1.0).abs() < 1e-9, "{name}: {} {bare}", strain(&rates));
        }
    }
}
