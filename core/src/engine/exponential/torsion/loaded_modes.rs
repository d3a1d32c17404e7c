//! The twist of a shaft line with its unbalances on it.
//!
//! ```text
//! 2T   = J phi'^2 + n'^T n' + sum_st A_st psi_s' psi_t',     psi_s' = phi' + t_s.n'      n: elastic modes of the bare shaft line               (1)
//! A_st = m_s d_s^2 [s = t] - Q_st,    Q_st = (m d)_s (m d)_t (M^-1)_st cos(a_s - a_t)     less what the rotor gives way to at once             (2)
//! phi  = angle + b.e,   n = V e                          angle takes all unbalances along, e has unit mass and is diagonal in (1)              (3)
//! ```
//! An unbalance on a bare shaft has many times the polar inertia of its place: as torques of their own the inertia `A` of (1) would feed back into
//! modes of twist that no step resolves (it did, and made them grow). In the modes (3) it is exact at any step. What is left of an unbalance, the
//! exchange of momentum with the slow lateral motion, are torques that change slowly ([`super::spin`]).
//!
//! (2) has the rotor's whole answer to a jump of psi', `M^-1` of the nodes; what of it a step does not resolve feeds back ([`super::spin`]).
//! Source: docs/theory/01-shaft-line.md, (1) and (2) are its Lagrangian. Limits: damping proportional to stiffness, as the twist's is, stays diagonal in (3).
//! Verified by the tests below and `unbalances_on_a_bare_shaft_do_not_shake_it` (`tests/exponential.rs`).

use crate::engine::exponential::error::ExponentialError;
use crate::engine::shaft_line::{masses, sites};
use crate::linalg::lanes::LANES;
use crate::linalg::{Matrix, column_of, dot, inverse, norm, symmetric_generalised};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Part of a uniform rotation in a mode of twist below which the mode is elastic.
const ELASTIC: f64 = 1e-6;

/// (3).
#[derive(Debug, Clone)]
pub(crate) struct LoadedModes {
    /// Of `angle`, all unbalances with it \[kg m2\].
    pub inertia: f64,
    /// Square of the frequency and damping of each mode, up to a multiple of eight \[1/s2, 1/s\].
    pub modes: Vec<(f64, f64)>,
    /// Q \[kg m2\], `Q_st` in column s.
    pub compliance_inertia: Matrix,
    /// Modes of the bare shaft line that are elastic.
    elastic: Vec<usize>,
    /// V of (3).
    modes_of: Matrix,
    /// b of (3), up to a multiple of eight: what a torque on phi, of the brakes, is on the modes.
    pub shift: Vec<f64>,
}

impl LoadedModes {
    /// Of a machine.
    ///
    /// # Errors
    /// [`ExponentialError::Singular`] where a lost mass is more than there was.
    pub fn new(machine: &Machine, structure: &Structure) -> Result<Self, ExponentialError> {
        let (sites, twist) = (sites(machine), &structure.twist);
        let elastic = elastic_modes(structure);
        let count = elastic.len();
        let rows: Vec<Vec<f64>> = sites.iter().map(|site| bare_row(structure, &elastic, site.twist_node)).collect();
        let (lateral, _) = masses(structure, &sites);
        let yielding = inverse(&lateral).ok_or(ExponentialError::Singular { part: "the shaft line" })?;
        let along: Vec<Vec<f64>> = sites
            .iter()
            .map(|site| structure.lateral.coordinates.row(structure.rotor.plane_places(site.node)[0]))
            .collect();
        let jump = |s: usize, t: usize| -> f64 {
            along[t].iter().enumerate().map(|(j, part)| part * dot(column_of(&yielding, j), &along[s])).sum()
        };
        let of = |s: usize, t: usize| {
            let [one, other] = [s, t].map(|at| sites[at].mass * sites[at].radius);
            one * other * jump(s, t) * libm::cos(sites[s].phase - sites[t].phase)
        };
        let gives_way = Matrix::from_fn(sites.len(), sites.len(), |t, s| of(s, t));
        let carried = |s: usize, t: usize| {
            let own = if s == t { sites[s].mass * sites[s].radius * sites[s].radius } else { 0.0 };
            own - gives_way[(t, s)]
        };
        // (1) in angle and n: the first row and column, and the rest
        let (mut inertia, mut edge) = (structure.rotor.twist_mass.sum(), vec![0.0; count]);
        let mut mass = Matrix::identity(count, count);
        for s in 0..sites.len() {
            for t in 0..sites.len() {
                let a = carried(s, t);
                inertia += a;
                for i in 0..count {
                    edge[i] += a * rows[s][i];
                    for j in 0..count {
                        mass[(i, j)] += a * rows[s][i] * rows[t][j];
                    }
                }
            }
        }
        if inertia <= 0.0 {
            return Err(ExponentialError::Singular { part: "the twist" });
        }
        // less what turns with the angle
        let (mut mass, mut stiffness) = (mass, Matrix::zeros(count, count));
        for i in 0..count {
            stiffness[(i, i)] = twist.stiffness[(elastic[i], elastic[i])];
            for j in 0..count {
                mass[(i, j)] -= edge[i] * edge[j] / inertia;
            }
        }
        let (squares, modes_of) = symmetric_generalised(&stiffness, &mass, "the twist with its unbalances")?;
        let mut shift: Vec<f64> = (0..count).map(|j| -dot(&edge, column_of(&modes_of, j)) / inertia).collect();
        shift.resize(count.next_multiple_of(LANES), 0.0);
        let damping = |j: usize| -> f64 {
            let parts = elastic.iter().zip(column_of(&modes_of, j));
            parts.map(|(&i, part)| twist.damping[(i, i)] * part * part).sum()
        };
        let mut modes: Vec<(f64, f64)> = (0..count).map(|j| (squares[j], damping(j))).collect();
        modes.resize(count.next_multiple_of(LANES), (1.0, 0.0));
        Ok(Self { inertia, modes, compliance_inertia: gives_way, elastic, modes_of, shift })
    }

    /// How many steps of the last one's length the slope of `angle` may foretell. What is foreseen of psi' acts on the rotor, whose answer is k of it in the spin's,
    /// `k < Q/J`: with r the ratio of a step to the last one, `W(n+1) = k [(1 + r) W(n) - r W(n-1)] + ...`, which grows in no order of steps where
    /// `k (1 + 2 r) < 1`. Beyond what this allows a slope is taken as that of fewer steps: what it misses is in the next one's.
    pub fn max_extrapolation(&self) -> f64 {
        let heavy = self.compliance_inertia.iter().map(|q| q.abs()).sum::<f64>();
        (0.5 * (self.inertia / heavy - 1.0)).max(1.0)
    }

    /// The turn of a node beside `angle`, per amplitude of (3); zeros up to a multiple of eight.
    pub fn row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.twist(structure, node).iter().zip(&self.shift).map(|(twist, shift)| twist + shift).collect()
    }

    /// The same beside phi: the node's twist.
    pub fn twist(&self, structure: &Structure, node: usize) -> Vec<f64> {
        let bare = bare_row(structure, &self.elastic, node);
        let mut row: Vec<f64> = (0..bare.len()).map(|j| dot(&bare, column_of(&self.modes_of, j))).collect();
        row.resize(self.modes.len(), 0.0);
        row
    }
}

/// Elastic twist of a node per amplitude of the bare shaft line's modes.
fn bare_row(structure: &Structure, elastic: &[usize], node: usize) -> Vec<f64> {
    let row = structure.twist.coordinates.row(node);
    elastic.iter().map(|&j| row[j]).collect()
}

/// The modes of twist without the uniform rotation.
fn elastic_modes(structure: &Structure) -> Vec<usize> {
    let (rotor, part) = (&structure.rotor, &structure.twist);
    let rigid = part.coordinates_of(&rotor.twist_mass, &vec![1.0; rotor.nodes]);
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

    /// (1) of any motion, in the modes of the bare shaft line and in (3).
    #[test]
    fn the_modes_have_the_energy_of_the_loaded_shaft_line() {
        for (name, position, mass) in
            [("lp_turbine", "1.1 m", "12 kg"), ("lp_turbine", "5 m", "0.3 kg"), ("lab_rig", "0.3 m", "0.2 kg")]
        {
            let machine = machine(name, &[("blade_off.position", position), ("blade_off.mass", mass)]);
            let structure = Structure::build(&machine, None).expect("buildable");
            let loaded = LoadedModes::new(&machine, &structure).expect("definite");
            let site = sites(&machine)[0];
            let a = site.mass * site.radius * site.radius - loaded.compliance_inertia[(0, 0)];
            let own = loaded.row(&structure, site.twist_node);
            let (spin, rates): (f64, Vec<f64>) = (
                3.0,
                (0..own.len()).map(|j| if j < loaded.elastic.len() { 0.3 - 0.1 * j as f64 } else { 0.0 }).collect(),
            );
            let new = loaded.inertia * spin * spin + dot(&rates, &rates);
            // phi and n of the same motion
            let phi = spin + dot(&loaded.shift, &rates);
            let n: Vec<f64> = (0..loaded.elastic.len())
                .map(|i| (0..loaded.elastic.len()).map(|j| loaded.modes_of[(i, j)] * rates[j]).sum())
                .collect();
            let psi = phi + dot(&bare_row(&structure, &loaded.elastic, site.twist_node), &n);
            assert!((psi - spin - dot(&own, &rates)).abs() < 1e-12 * psi.abs(), "{name}: {psi}");
            let old = structure.rotor.twist_mass.sum() * phi * phi + dot(&n, &n) + a * psi * psi;
            assert!((new / old - 1.0).abs() < 1e-12, "{name}: {new} {old}");
            let twist = &structure.twist;
            let strain = |e: &[f64]| loaded.modes.iter().zip(e).map(|(mode, e)| mode.0 * e * e).sum::<f64>();
            let bare: f64 = loaded.elastic.iter().zip(&n).map(|(&j, n)| twist.stiffness[(j, j)] * n * n).sum();
            assert!((strain(&rates) / bare - 1.0).abs() < 1e-9, "{name}: {} {bare}", strain(&rates));
        }
    }
}
