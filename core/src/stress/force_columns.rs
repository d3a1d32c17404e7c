//! Stresses by the static response of a ring's truncated modes to the contact forces.
//!
//! ```text
//! sigma_i = sum_j r_ij q_j + sum_d g_id f_d,    G = S (K^-1 - Phi Omega^-2 Phi^T)                                                (1)
//! ```
//! q: amplitudes of the retained modes; f: contact forces on the ring's degrees of freedom \[N, N m\]; S: stress per unit displacement of a
//! degree of freedom; K: stiffness of the complete model; Phi, Omega: mode shapes and circular frequencies of the retained modes. A contact
//! force is a line load on the ring's surface. Displacements converge quickly with the number of modes, curvature and strain near the load
//! converge slowly. With 40 blades, the 92 modes of the default basis have 99 % of the displacement under a force, and a third of its
//! stress.
//!
//! Source: mode acceleration method (Williams 1945; Rixen, Mech. Syst. Signal Process. 15, 2001). Limits: the truncated modes respond
//! statically. No correction if [`RingPart::residual`] is `None`. Verified by `the_residual_completes_the_stresses_of_a_static_load`,
//! `tests/runs/ring_stresses.rs`.

use crate::eight::{Eight, by_width};
use crate::stator::NodalForces;
use crate::structure::RingPart;
use bladeoff_numerics::linalg::lanes::{LANES, Lane};
use bladeoff_numerics::linalg::{Matrix, axpy, column_of};

/// Matrix G of (1) for some positions: stress per unit contact force.
#[derive(Debug, Clone)]
pub(super) struct ForceColumns {
    /// Columns of G, one per degree of freedom, in lanes of eight positions \[Pa/N\].
    entries: Vec<Lane>,
    /// Number of lanes per column.
    lanes: usize,
    /// Largest magnitude in each column \[Pa/N\].
    pub largest: Vec<f64>,
}

impl ForceColumns {
    /// Computes G. `nodal`: stress per unit displacement, one row per degree of freedom of ring and blades, one column per position. `None`
    /// without truncated modes.
    pub fn new(nodal: &Matrix, part: &RingPart) -> Option<Self> {
        let residual = part.residual.as_ref()?;
        let lanes = nodal.ncols().div_ceil(LANES);
        let mut entries = vec![Lane::default(); lanes * residual.nrows()];
        let (mut by_force, mut largest) = (vec![0.0; residual.nrows()], vec![0.0_f64; residual.nrows()]);
        for place in 0..nodal.ncols() {
            by_force.fill(0.0);
            for (dof, &stress) in column_of(nodal, place).iter().enumerate().filter(|(_, stress)| **stress != 0.0) {
                // the residual flexibility is symmetric: its column is also the displacement of this degree of freedom by each force
                axpy(stress, column_of(residual, dof), &mut by_force);
            }
            for (dof, &stress) in by_force.iter().enumerate() {
                entries[dof * lanes + place / LANES].0[place % LANES] = stress;
                largest[dof] = largest[dof].max(stress.abs());
            }
        }
        Some(Self { entries, lanes, largest })
    }

    /// Writes the stresses of all positions under contact forces, in lanes of eight \[Pa\].
    pub fn stresses(&self, forces: &NodalForces, sums: &mut Vec<Lane>) {
        sums.resize(self.lanes, Lane::default());
        combine(&self.entries, forces.all(), sums);
    }
}

by_width! {
    /// Linear combination of columns, each as long as `sums`, with the factors `times` (column, factor).
    fn combine(columns: &[Lane], times: &[(usize, f64)], sums: &mut [Lane]) = combine_in
}

#[inline(always)]
fn combine_in<V: Eight>(columns: &[Lane], times: &[(usize, f64)], sums: &mut [Lane]) {
    sums.fill(Lane::default());
    let length = sums.len();
    // four columns at a time: the degrees of freedom of a node
    let (fours, rest) = times.as_chunks::<4>();
    for four in fours {
        let [a, b, c, d] = four.map(|(column, _)| &columns[column * length..][..length]);
        let factors = four.map(|(_, factor)| V::all(factor));
        for ((((sum, a), b), c), d) in sums.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            let first = V::load(a) * factors[0] + V::load(b) * factors[1];
            let second = V::load(c) * factors[2] + V::load(d) * factors[3];
            (V::load(sum) + (first + second)).store(sum);
        }
    }
    for &(column, factor) in rest {
        for (sum, entries) in sums.iter_mut().zip(&columns[column * length..][..length]) {
            (V::load(sum) + V::load(entries) * V::all(factor)).store(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::stator::NodalForces;
    use crate::stress::{Known, RingStresses};
    use crate::structure::Structure;
    use bladeoff_model::machine::{DiaphragmKind, FlexibleStator, Machine, MachineDef};

    const NONE: Known = Known { ring: 0.0, blades: 0.0, bending: 0.0 };

    /// The lab rig with 20 blades of three elements, and `ring_modes` ring modes.
    fn rig(ring_modes: &str) -> (Machine, Structure) {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let mut def = MachineDef::parse(&path, &text).expect("parses");
        for (path, value) in [
            ("run.engine", "reduced"),
            ("run.ring_modes", ring_modes),
            ("diaphragms.seal.ring.elements", "40"),
            ("diaphragms.seal.blades.count", "20"),
            ("diaphragms.seal.blades.elements", "3"),
        ] {
            let info = def.resolve(path).expect("a key");
            let value = def.parse_value(&info, value).expect("a value");
            def.set(&info, &value).expect("allowed");
        }
        let machine = def.build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        (machine, structure)
    }

    fn stator(machine: &Machine) -> &FlexibleStator {
        let DiaphragmKind::Flexible(stator) = &machine.diaphragms[0].kind else { panic!("a flexible ring") };
        stator
    }

    /// Static amplitudes of the retained modes under forces.
    fn statics(structure: &Structure, forces: &NodalForces) -> Vec<f64> {
        let ring = structure.rings[0].as_ref().expect("a ring");
        let mut q = vec![0.0; ring.part.coordinates.size()];
        for &(dof, force) in forces.all() {
            ring.part.coordinates.add_row(dof, force, &mut q);
        }
        q.iter_mut().enumerate().for_each(|(j, q)| *q /= ring.part.stiffness[(j, j)]);
        q
    }

    #[test]
    fn the_residual_completes_the_stresses_of_a_static_load() {
        let (machine, few) = rig("12");
        let (_, all) = rig("10000");
        let ring = few.rings[0].as_ref().expect("a ring");
        let mut reduced = RingStresses::new(stator(&machine), ring);
        let mut whole = RingStresses::new(stator(&machine), all.rings[0].as_ref().expect("a ring"));
        let surface = ring.matrices.surface(0.0505, true);
        for (element, xi) in [(0, 0.0), (3, 0.31), (17, 0.5), (38, 0.77), (39, 0.96)] {
            let mut forces = NodalForces::none();
            forces.add_at(&surface, (element, xi), [100.0, -30.0]);
            let (q, full) = (statics(&few, &forces), statics(&all, &forces));
            let expected = whole.above(&NONE, &full, &NodalForces::none());
            let found = reduced.above(&NONE, &q, &forces);
            let [expected, found] =
                [expected, found].map(|all| [all.ring, all.blades, all.bending].map(|s| s.expect("loaded")));
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-6, "{element} {xi}: {found} {expected}");
            }
            let places =
                [reduced.angle_of(found[0], &q, &forces), whole.angle_of(expected[0], &full, &NodalForces::none())];
            assert!((places[0] - places[1]).abs() < 1e-12, "{places:?}");
            assert_eq!(
                reduced.blade_of(found[1], &q, &forces),
                whole.blade_of(expected[1], &full, &NodalForces::none())
            );
            let without = reduced.above(&NONE, &q, &NodalForces::none()).ring.expect("loaded");
            assert!(without < 0.5 * expected[0], "twelve modes have {without} of {}", expected[0]);
        }
    }

    #[test]
    fn with_all_modes_kept_forces_add_nothing() {
        let (machine, all) = rig("10000");
        let ring = all.rings[0].as_ref().expect("a ring");
        assert!(ring.residual.is_none());
        let mut forces = NodalForces::none();
        forces.add_at(&ring.matrices.surface(0.0505, true), (3, 0.31), [100.0, -30.0]);
        let q = &statics(&all, &forces);
        let fresh = || RingStresses::new(stator(&machine), ring);
        assert_eq!(fresh().above(&NONE, q, &forces), fresh().above(&NONE, q, &NodalForces::none()));
    }

    /// A force moves around the ring, varies, and is absent at times. Each maximum equals that of evaluations without stored bounds.
    #[test]
    fn bounds_with_a_memory_find_the_same_maxima_under_moving_forces() {
        let (machine, few) = rig("12");
        let ring = few.rings[0].as_ref().expect("a ring");
        let surface = ring.matrices.surface(0.0505, true);
        let fresh = RingStresses::new(stator(&machine), ring);
        let (mut ours, mut most, mut evaluated, mut raised) = (fresh.clone(), [0.0_f64; 2], 0, 0);
        for step in 0..3000 {
            let angle = 1e-3 * f64::from(step);
            let size = 100.0 * (1.5 + (4e-3 * f64::from(step)).sin());
            let mut forces = NodalForces::none();
            if step % 700 < 600 {
                forces.add_at(&surface, surface.locate(angle), [size, 0.3 * size]);
                forces.add_at(&surface, surface.locate(angle + 0.2), [0.5 * size, 0.1 * size]);
            }
            let q = &statics(&few, &forces);
            let found = ours.above(&Known { ring: most[0], blades: most[1], bending: f64::INFINITY }, q, &forces);
            let exact = fresh.clone().above(&Known { ring: -1.0, blades: -1.0, bending: f64::INFINITY }, q, &forces);
            let pairs = [(found.ring, exact.ring), (found.blades, exact.blades)];
            for (most, (found, exact)) in most.iter_mut().zip(pairs) {
                let exact = exact.expect("evaluated");
                if exact > *most {
                    assert_eq!(found.map(f64::to_bits), Some(exact.to_bits()), "step {step}");
                    (*most, raised) = (exact, raised + 1);
                }
                evaluated += usize::from(found.is_some());
            }
        }
        assert!(raised > 50 && evaluated < 3000, "{raised} {evaluated}");
    }
}
