//! Gyroscopic torques on the torsional modes, for machines where they matter.
//!
//! ```text
//! G_g   = q'^T S_g q/2                        gyroscopic momentum of site g, about the shaft's axis
//! Y_j   = sum_g row_gj G_g                    its part in torsional mode j; row_gj: angle of the site beside the mean angle, per amplitude      (1)
//! f_j   = -(Y_j(n+1) - Y_j(n))/h              mean torque on the mode over the step                                                             (2)
//! ```
//! The Lagrangian has `sum_g Omega_g G_g` with `Omega_g = W + sum_j row_gj e_j'`. So (1) is the momentum that belongs to `e_j'`, and its rate of change is a torque: the
//! `-1/2 (theta_u''^T H theta_v - theta_v''^T H^T theta_u)` of [`crate::rotor::GyroSite`], integrated once over the step. Changes add up, so nothing drifts.
//!
//! Source: docs/theory/01-shaft-line.md. Limits: the torsional rate `e_j'` does not act on the lateral motion. The choice is made at the start, from the whirl at the initial speed.
//! Verified by the tests below and `core/tests/torsion.rs`.

use super::spin::Spin;
use crate::engine::beginning::{projected, steady_state};
use crate::engine::exponential::modal::row_batch::RowBatch;
use crate::engine::shaft_line::sites;
use crate::linalg::{Matrix, norm};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Value of [`share`] above which the torques are taken. Measured without them: at 0.044 (the steam turbine of `studies/machines`) the largest torsional moment is 0.2 % off. At 0.13 it is 0.7 %
/// off, and one section 5 %. At 1.5 it is half of the right one.
const RELEVANT_SHARE: f64 = 0.06;

/// S of (1) for each torsional mode. S is skew, so Y_j is a sum over pairs of coordinates: `sum_(a < b) (sum_g row_gj S_g)_ab (q_a' q_b - q_b' q_a)/2`.
#[derive(Debug, Clone)]
pub(crate) struct GyroscopicTorque {
    /// Pairs of coordinates that any mode has; half of S on them, a row for each mode.
    pairs: Vec<[usize; 2]>,
    halves: RowBatch,
}

/// Momenta (1) at n, what they have changed by over the last step, and room for a motion.
#[derive(Debug, Clone, Default)]
pub(crate) struct GyroscopicMomenta {
    momenta: Vec<f64>,
    pub changes: Vec<f64>,
    pub places: Vec<f64>,
    pub rates: Vec<f64>,
    areas: Vec<f64>,
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
        let mut each = Vec::new();
        for j in 0..rows.first().map_or(0, Vec::len) {
            let nodal: Vec<f64> = rows.iter().map(|row| row[j]).collect();
            let mut dense = Matrix::zeros(rotor.lateral_size(), rotor.lateral_size());
            // behind the last mode there are zeros
            if nodal.iter().any(|&angle| angle != 0.0) {
                rotor.gyro.iter().for_each(|site| site.add_dense(0.5 * site.mean(&nodal), &mut dense));
            }
            each.push(projected(structure, &dense));
        }
        let size = structure.lateral.coordinates.size();
        let all = (0..size).flat_map(|b| (0..b).map(move |a| [a, b]));
        let pairs: Vec<[usize; 2]> = all.filter(|&[a, b]| each.iter().any(|half| half[(a, b)] != 0.0)).collect();
        let halves = Matrix::from_fn(each.len(), pairs.len(), |j, at| {
            let [a, b] = pairs[at];
            each[j][(a, b)]
        });
        Self { pairs, halves: RowBatch::new(&halves) }
    }

    /// Takes (1) of the motion that `now` has, and what it has changed by.
    pub fn update(&self, now: &mut GyroscopicMomenta) {
        let GyroscopicMomenta { momenta, changes, places, rates, areas, next } = now;
        areas.clear();
        areas.extend(self.pairs.iter().map(|&[a, b]| rates[a] * places[b] - rates[b] * places[a]));
        self.halves.multiply(areas, next);
        momenta.resize(next.len(), 0.0);
        changes.clear();
        changes.extend(next.iter().zip(momenta.iter()).map(|(next, last)| next - last));
        std::mem::swap(momenta, next);
    }
}

/// Gyroscopic momenta of the torsional modes relative to what the unbalances exchange with these modes, for the whirl that the unbalances keep at the initial speed. Both are norms over the modes,
/// which have unit mass: each is the square root of twice the energy that a sudden change of these momenta would give. Infinite where the unbalances exchange nothing.
fn share(machine: &Machine, structure: &Structure, spin: &Spin) -> f64 {
    let (rotor, sites, speed) = (&structure.rotor, sites(machine), machine.rotor.initial_speed);
    if rotor.gyro.is_empty() || spin.torsional_amplitudes().is_empty() {
        return 0.0;
    }
    let stiffness = &structure.lateral.stiffness + projected(structure, &rotor.skew_stiffness());
    // at an undamped resonance there are no bounds
    let Ok((real, imaginary)) = steady_state(structure, &sites, &stiffness, speed, 0.0) else { return f64::INFINITY };
    let [x, y] = [real, imaginary].map(|q| {
        let mut nodal = vec![0.0; rotor.lateral_size()];
        structure.lateral.coordinates.expand(&q, &mut nodal);
        nodal
    });
    let rows: Vec<Vec<f64>> = (0..rotor.nodes).map(|node| spin.rotation_row(structure, node)).collect();
    let (mut gyroscopic, mut exchanged) =
        (vec![0.0; spin.torsional_amplitudes().len()], vec![0.0; spin.torsional_amplitudes().len()]);
    let add = |sums: &mut [f64], momentum: f64, nodes: [usize; 2]| {
        for (sum, (one, other)) in sums.iter_mut().zip(rows[nodes[0]].iter().zip(&rows[nodes[1]])) {
            *sum += (0.5 * momentum * (one + other)).abs();
        }
    };
    for site in &rotor.gyro {
        add(&mut gyroscopic, 0.5 * speed * site.bilinear(&y, &x), site.nodes());
    }
    for site in &sites {
        let [u, v] = rotor.plane_places(site.node);
        let way = (x[u] * x[u] + x[v] * x[v]).max(y[u] * y[u] + y[v] * y[v]).sqrt();
        add(&mut exchanged, site.mass * site.radius * speed * way, [site.twist_node; 2]);
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

    /// (1) of any motion is that of the sites one by one.
    #[test]
    fn the_momenta_of_the_torsional_modes_are_those_of_the_sites() {
        let machine = machine(HEAVY);
        let structure = Structure::build(&machine, None).expect("buildable");
        let spin = Spin::new(&machine, &structure).expect("definite");
        let gyration = GyroscopicTorque::new(&structure, &spin);
        let size = structure.lateral.coordinates.size();
        let [places, rates] = [3, 5].map(|n| (0..size).map(|i| (i * n % 7) as f64 - 2.5).collect::<Vec<f64>>());
        let [x, v] = [&places, &rates].map(|q| {
            let mut nodal = vec![0.0; structure.rotor.lateral_size()];
            structure.lateral.coordinates.expand(q, &mut nodal);
            nodal
        });
        let mut now = GyroscopicMomenta { places, rates, ..GyroscopicMomenta::default() };
        gyration.update(&mut now);
        let rows: Vec<Vec<f64>> = (0..structure.rotor.nodes).map(|node| spin.rotation_row(&structure, node)).collect();
        let mut largest = 0.0_f64;
        for j in 0..rows[0].len() {
            let of = |site: &crate::rotor::GyroSite| {
                let [one, other] = site.nodes().map(|node| rows[node][j]);
                0.25 * (one + other) * site.bilinear(&v, &x)
            };
            let wanted: f64 = structure.rotor.gyro.iter().map(of).sum();
            largest = largest.max(wanted.abs());
            assert!((now.momenta[j] - wanted).abs() < 1e-11 * largest, "{j}: {} {wanted}", now.momenta[j]);
        }
        assert!(largest > 0.0 && now.changes == now.momenta, "the first is the change from nothing");
        gyration.update(&mut now);
        assert!(now.changes.iter().all(|change| *change == 0.0));
    }

    /// The machines of the repository are computed without these torques, which cost more than they contribute there.
    #[test]
    fn the_torques_are_taken_where_they_matter() {
        for (path, from, to) in [
            (HEAVY, 1.0, 3.0),
            ("../studies/machines/lp_turbine.toml", 0.01, 0.05),
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
