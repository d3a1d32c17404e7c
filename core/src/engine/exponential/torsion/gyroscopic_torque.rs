//! Gyroscopic torques on the torsional modes, for machines where they matter.
//!
//! ```text
//! G_g   = q'^T S_g q/2                        gyroscopic momentum of site g, about the shaft's axis                             (1)
//! Y_j   = sum_g row_gj G_g                    its part in torsional mode j                                                      (2)
//! f_j   = -(Y_j(n+1) - Y_j(n))/h              mean torque on mode j over the step                                               (3)
//! ```
//! q: lateral coordinates; S_g: skew gyroscopic matrix of a disc or shaft element; row_gj: rotation of the site beside the mean
//! angle, per amplitude of mode j.
//!
//! The Lagrangian has `sum_g Omega_g G_g` with `Omega_g = W + sum_j row_gj e_j'`. So (2) is the momentum that belongs to `e_j'`,
//! and its rate of change is a torque: the `-1/2 (theta_u''^T H theta_v - theta_v''^T H^T theta_u)` of
//! [`crate::rotor::GyroSite`], integrated once over the step. Changes add up, so nothing drifts.
//!
//! Source: docs/theory/01-shaft-line.md. Limits: the torsional rates e_j' do not act on the lateral motion. Whether the torques
//! are taken is decided at the start, from the whirl at the initial speed. Verified by the tests below and
//! `core/tests/rotor/torsion.rs`.

use super::spin::Spin;
use crate::engine::beginning::{projected, steady_state};
use crate::engine::exponential::modal::row_batch::RowBatch;
use crate::engine::shaft_line::sites;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{Matrix, norm};

/// Value of [`share`] above which the torques are taken. Without them the largest torsional moment is 0.2 % off at 0.044 (the
/// steam turbine of `studies/machines`), 0.7 % at 0.13, where one section is 5 % off, and half of the right one at 1.5.
const RELEVANT_SHARE: f64 = 0.06;

/// Momenta (2) as quadratic forms. S is skew, so Y_j is a sum over pairs of coordinates:
/// `sum_(a < b) (sum_g row_gj S_g)_ab (q_a' q_b - q_b' q_a)/2`.
#[derive(Debug, Clone)]
pub(crate) struct GyroscopicTorque {
    /// Pairs of coordinates with a part in any mode; half of S on them, a row for each mode.
    pairs: Vec<[usize; 2]>,
    half_forms: RowBatch,
}

/// Momenta (2) at n, their changes over the last step, and buffers for a motion.
#[derive(Debug, Clone, Default)]
pub(crate) struct GyroscopicMomenta {
    momenta: Vec<f64>,
    pub changes: Vec<f64>,
    pub coordinates: Vec<f64>,
    pub rates: Vec<f64>,
    products: Vec<f64>,
    next: Vec<f64>,
}

impl GyroscopicTorque {
    /// Gyroscopic torques of a machine; `None` where they are too small to matter.
    pub fn of(machine: &Machine, structure: &Structure, spin: &Spin) -> Option<Self> {
        (share(machine, structure, spin) > RELEVANT_SHARE).then(|| Self::new(structure, spin))
    }

    fn new(structure: &Structure, spin: &Spin) -> Self {
        let rotor = &structure.rotor;
        let rows: Vec<Vec<f64>> = (0..rotor.nodes).map(|node| spin.rotation_row(structure, node)).collect();
        let mut half_matrices = Vec::new();
        for j in 0..rows.first().map_or(0, Vec::len) {
            let nodal: Vec<f64> = rows.iter().map(|row| row[j]).collect();
            let mut dense = Matrix::zeros(rotor.lateral_size(), rotor.lateral_size());
            // rows behind the last mode are zero
            if nodal.iter().any(|&angle| angle != 0.0) {
                rotor.gyro.iter().for_each(|site| site.add_dense(0.5 * site.mean(&nodal), &mut dense));
            }
            half_matrices.push(projected(structure, &dense));
        }
        let size = structure.lateral.coordinates.size();
        let all = (0..size).flat_map(|b| (0..b).map(move |a| [a, b]));
        let pairs: Vec<[usize; 2]> =
            all.filter(|&[a, b]| half_matrices.iter().any(|half| half[(a, b)] != 0.0)).collect();
        let half_forms = Matrix::from_fn(half_matrices.len(), pairs.len(), |j, at| {
            let [a, b] = pairs[at];
            half_matrices[j][(a, b)]
        });
        Self { pairs, half_forms: RowBatch::new(&half_forms) }
    }

    /// Updates the momenta (2) to the motion in `coordinates` and `rates`, and their changes.
    pub fn update(&self, state: &mut GyroscopicMomenta) {
        let GyroscopicMomenta { momenta, changes, coordinates, rates, products, next } = state;
        products.clear();
        products.extend(self.pairs.iter().map(|&[a, b]| rates[a] * coordinates[b] - rates[b] * coordinates[a]));
        self.half_forms.multiply(products, next);
        momenta.resize(next.len(), 0.0);
        changes.clear();
        changes.extend(next.iter().zip(momenta.iter()).map(|(next, last)| next - last));
        std::mem::swap(momenta, next);
    }
}

/// Ratio of the gyroscopic momenta to the angular momenta that the unbalances exchange with the torsional modes, for the steady
/// whirl of the unbalances at the initial speed. Both are norms over the modes of unit mass: the square root of twice the energy
/// that a sudden change of these momenta would give. Infinite without unbalances.
fn share(machine: &Machine, structure: &Structure, spin: &Spin) -> f64 {
    let (rotor, sites, speed) = (&structure.rotor, sites(machine), machine.rotor.initial_speed);
    if rotor.gyro.is_empty() || spin.torsional_amplitudes().is_empty() {
        return 0.0;
    }
    let mut stiffness = &structure.lateral.stiffness + projected(structure, &rotor.skew_stiffness());
    let mut damping = structure.lateral.damping.clone();
    if let Some(changes) = rotor.change_at(speed) {
        let [of_stiffness, of_damping] = changes.map(|change| projected(structure, &change));
        (stiffness, damping) = (stiffness + of_stiffness, damping + of_damping);
    }
    // an undamped resonance has no steady whirl
    let Ok((real, imaginary)) = steady_state(structure, &sites, [&stiffness, &damping], speed, 0.0) else {
        return f64::INFINITY;
    };
    let [x, y] = [real, imaginary].map(|q| {
        let mut nodal = vec![0.0; rotor.lateral_size()];
        structure.lateral.coordinates.expand(&q, &mut nodal);
        nodal
    });
    let rows: Vec<Vec<f64>> = (0..rotor.nodes).map(|node| spin.rotation_row(structure, node)).collect();
    let (mut gyroscopic, mut exchanged) =
        (vec![0.0; spin.torsional_amplitudes().len()], vec![0.0; spin.torsional_amplitudes().len()]);
    let add_to = |sums: &mut [f64], momentum: f64, nodes: [usize; 2]| {
        for (sum, (one, other)) in sums.iter_mut().zip(rows[nodes[0]].iter().zip(&rows[nodes[1]])) {
            *sum += (0.5 * momentum * (one + other)).abs();
        }
    };
    for site in &rotor.gyro {
        add_to(&mut gyroscopic, 0.5 * speed * site.bilinear(&y, &x), site.nodes());
    }
    for site in &sites {
        let [u, v] = rotor.plane_places(site.node);
        let amplitude = (x[u] * x[u] + x[v] * x[v]).max(y[u] * y[u] + y[v] * y[v]).sqrt();
        add_to(&mut exchanged, site.mass * site.radius * speed * amplitude, [site.torsional_node; 2]);
    }
    let (gyroscopic, exchanged) = (norm(&gyroscopic), norm(&exchanged));
    if exchanged > 0.0 { gyroscopic / exchanged } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    fn machine(path: &str) -> Machine {
        let path = format!("{}/{path}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        MachineDef::parse(&path, &text).expect("parses").build().expect("valid")
    }

    const HEAVY: &str = "tests/data/heavy_unbalance.toml";

    /// The momenta (2) of a motion are the sums over the sites.
    #[test]
    fn the_momenta_of_the_torsional_modes_are_those_of_the_sites() {
        let machine = machine(HEAVY);
        let structure = Structure::build(&machine, None).expect("buildable");
        let spin = Spin::new(&machine, &structure).expect("definite");
        let torque = GyroscopicTorque::new(&structure, &spin);
        let size = structure.lateral.coordinates.size();
        let [coordinates, rates] = [3, 5].map(|n| (0..size).map(|i| (i * n % 7) as f64 - 2.5).collect::<Vec<f64>>());
        let [x, v] = [&coordinates, &rates].map(|q| {
            let mut nodal = vec![0.0; structure.rotor.lateral_size()];
            structure.lateral.coordinates.expand(q, &mut nodal);
            nodal
        });
        let mut momenta = GyroscopicMomenta { coordinates, rates, ..GyroscopicMomenta::default() };
        torque.update(&mut momenta);
        let rows: Vec<Vec<f64>> = (0..structure.rotor.nodes).map(|node| spin.rotation_row(&structure, node)).collect();
        let mut largest = 0.0_f64;
        for j in 0..rows[0].len() {
            let of = |site: &crate::rotor::GyroSite| {
                let [one, other] = site.nodes().map(|node| rows[node][j]);
                0.25 * (one + other) * site.bilinear(&v, &x)
            };
            let wanted: f64 = structure.rotor.gyro.iter().map(of).sum();
            largest = largest.max(wanted.abs());
            assert!((momenta.momenta[j] - wanted).abs() < 1e-11 * largest, "{j}: {} {wanted}", momenta.momenta[j]);
        }
        assert!(largest > 0.0 && momenta.changes == momenta.momenta, "the first is the change from nothing");
        torque.update(&mut momenta);
        assert!(momenta.changes.iter().all(|change| *change == 0.0));
    }

    /// The machines of the repository are computed without these torques, which cost more than they contribute there.
    #[test]
    fn the_torques_are_taken_where_they_matter() {
        for (path, from, to) in [
            (HEAVY, 1.0, 3.0),
            ("../studies/machines/lp_turbine_paper.toml", 0.01, 0.05),
            ("../studies/machines/lab_rig.toml", 0.0, 0.01),
        ] {
            let machine = machine(path);
            let structure = Structure::build(&machine, None).expect("buildable");
            let spin = Spin::new(&machine, &structure).expect("definite");
            let share = share(&machine, &structure, &spin);
            assert!(from < share && share < to, "{path}: {share}");
        }
    }
}
