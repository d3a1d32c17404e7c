//! A basis from another that is near it: at one speed from that of the station beside, without an eigenvalue problem of its own, or without what rounding has left between pairs.
//!
//! ```text
//! L' A R' = D + E                  L', R', D: left and right vectors and blocks of the other;  beside a station A' E = L' (A - A') R'              (1)
//! (D + E) X = X B,  [X]_kk = 1     with X = 1 + N:   D_l N_lk - N_lk D_k = N_lk [E X]_kk - [E X]_lk                                         (2)
//! D M - M F = C                    M = (D^2 - tr F D + det F)^-1 (D C - C adj F)                                                          (3)
//! R = R' X
//! ```
//! (2) says that each pair goes on in itself, and that its plane has not turned in itself, as [`super::pairs`] has it. It is taken in rounds from N = 0 on, each of which leaves some |E| beside the distance of the pairs' eigenvalues
//! of what the one before has left: a per cent or two at the default spacing. (3) is the theorem of Cayley and Hamilton for F. E is the change of A alone, so that rounding of its large entries is in no slow pair.
//! Where N is not small, or rounds do not halve what they change (pairs that cross, or merge with another), there is none.
//! Limits: what the other basis leaves between its pairs is left between these: an eigenvalue problem's is taken out by (2) first ([`super::station`]), and blocks are read from the new basis. (Carried on, both made
//! loads of soft bearings with strong damping move by 1e-5 with the last digits of a machine.)
//! Source: Stewart, Error and perturbation bounds for subspaces, SIAM Review 15, 1973, whose equation for one subspace (2) is for each pair.
//! Verified by the tests below and `loads_of_soft_bearings_do_not_hang_on_last_digits` (`tests/exponential_edges.rs`).

use super::plane_block::PlaneBlock;
use crate::linalg::lanes::kernel;
use crate::linalg::{Matrix, mul};

/// Rounds at most; those of a change by a per cent are eight. After some each has to halve what it changes.
const ROUNDS: usize = 40;
const FEW: usize = 4;
/// Largest norm of N.
const SMALL: f64 = 0.3;

/// Right vectors of blocks D and E that are not far from those of D alone; `None` where they are.
pub(crate) fn continued_basis(right: &Matrix, blocks: &[PlaneBlock], e: &Matrix) -> Option<Matrix> {
    if e.amax() == 0.0 {
        return Some(right.clone());
    }
    let pairs = blocks.len();
    let entries = [0, 1, 2, 3].map(|i| blocks.iter().map(|block| block[i]).collect::<Vec<f64>>());
    let weights: Vec<[Vec<f64>; 4]> = (0..pairs).map(|k| sylvester_weights(blocks, k)).collect();
    let (mut n, mut last) = (Matrix::zeros(2 * pairs, 2 * pairs), f64::INFINITY);
    for round in 0..ROUNDS {
        let moved = e + mul(e, &n);
        let within = |k: usize| -> PlaneBlock {
            [moved[(k, k)], moved[(k, k + pairs)], moved[(k + pairs, k)], moved[(k + pairs, k + pairs)]]
        };
        let mut largest = 0.0;
        let (firsts, seconds) = n.as_mut_slice().split_at_mut(2 * pairs * pairs);
        let columns = firsts.chunks_exact_mut(2 * pairs).zip(seconds.chunks_exact_mut(2 * pairs));
        let (forced, others) = moved.as_slice().split_at(2 * pairs * pairs);
        let forced = forced.chunks_exact(2 * pairs).zip(others.chunks_exact(2 * pairs));
        for (k, ((columns, forced), weights)) in columns.zip(forced).zip(&weights).enumerate() {
            turn_on([blocks[k], within(k)], &entries, weights, forced, columns, &mut largest);
        }
        if largest <= f64::EPSILON {
            return (n.norm() < SMALL).then(|| right + mul(right, &n));
        }
        let halves = round < FEW || largest < 0.5 * last;
        if largest.is_nan() || largest > 1.0 || !halves {
            return None;
        }
        last = largest;
    }
    None
}

/// The inverse in (3) of every D with that of a pair as F, entry by entry; nothing for the pair itself.
fn sylvester_weights(blocks: &[PlaneBlock], k: usize) -> [Vec<f64>; 4] {
    let [a, b, c, d] = blocks[k];
    let (trace, determinant) = (a + d, a * d - b * c);
    let mut all = [const { Vec::new() }; 4];
    for (l, &[p, q, r, s]) in blocks.iter().enumerate() {
        let [x, y, z, w] = [
            p * p + q * r - trace * p + determinant,
            q * (p + s - trace),
            r * (p + s - trace),
            s * s + q * r - trace * s + determinant,
        ];
        let times = if l == k { 0.0 } else { 1.0 / (x * w - y * z) };
        for (list, entry) in all.iter_mut().zip([w, -y, -z, x]) {
            list.push(times * entry);
        }
    }
    all
}

kernel! {
    /// A round of (2) for the two columns of a pair with these D_k and [E X]_kk; `entries`: of every D; the largest change so far.
    fn turn_on(
        own: [PlaneBlock; 2],
        entries: &[Vec<f64>; 4],
        weights: &[Vec<f64>; 4],
        forced: (&[f64], &[f64]),
        columns: (&mut [f64], &mut [f64]),
        largest: &mut f64,
    ) {
        let [[a, b, c, d], [e, f, g, h]] = own;
        let pairs = entries[0].len();
        let (p, q, r, s) = (&entries[0][..pairs], &entries[1][..pairs], &entries[2][..pairs], &entries[3][..pairs]);
        let (x, y, z, w) = (&weights[0][..pairs], &weights[1][..pairs], &weights[2][..pairs], &weights[3][..pairs]);
        let ((u, u_below), (v, v_below)) = (forced.0.split_at(pairs), forced.1.split_at(pairs));
        let ((m, m_below), (n, n_below)) = (columns.0.split_at_mut(pairs), columns.1.split_at_mut(pairs));
        let (u_below, v_below, m, n) = (&u_below[..pairs], &v_below[..pairs], &mut m[..pairs], &mut n[..pairs]);
        let (m_below, n_below) = (&mut m_below[..pairs], &mut n_below[..pairs]);
        let mut most = *largest;
        for l in 0..pairs {
            // C, D C - C adj F, M: by rows
            let (c_a, c_b) = (m[l] * e + n[l] * g - u[l], m[l] * f + n[l] * h - v[l]);
            let (c_c, c_d) = (m_below[l] * e + n_below[l] * g - u_below[l], m_below[l] * f + n_below[l] * h - v_below[l]);
            let k_a = p[l] * c_a + q[l] * c_c - (c_a * d - c_b * c);
            let k_b = p[l] * c_b + q[l] * c_d - (c_b * a - c_a * b);
            let k_c = r[l] * c_a + s[l] * c_c - (c_c * d - c_d * c);
            let k_d = r[l] * c_b + s[l] * c_d - (c_d * a - c_c * b);
            let new = [x[l] * k_a + y[l] * k_c, x[l] * k_b + y[l] * k_d, z[l] * k_a + w[l] * k_c, z[l] * k_b + w[l] * k_d];
            let old = [m[l], n[l], m_below[l], n_below[l]];
            for i in 0..4 {
                // what is no number stays
                let change = (new[i] - old[i]).abs();
                most = if most >= change || most.is_nan() { most } else { change };
            }
            (m[l], n[l], m_below[l], n_below[l]) = (new[0], new[1], new[2], new[3]);
        }
        *largest = most;
    }
}

#[cfg(test)]
mod tests {
    use super::super::modal_basis::{LateralModel, ModalBasis};
    use super::super::modal_planes;
    use super::super::outputs::Outputs;
    use super::super::section_loads::SectionLoadModel;
    use super::super::state_space::StateSpace;
    use super::*;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;

    /// A machine of the repository with its first bearing stiffness changed, and a station at a speed.
    fn station(name: &str, stiffness: [&str; 2], speed: f64) -> (LateralModel, ModalBasis) {
        let path = format!("{}/../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        assert!(text.contains(stiffness[0]));
        let text = text.replacen(stiffness[0], stiffness[1], 1);
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let system = StateSpace::new(&machine, &structure).expect("regular");
        let outputs = Outputs::new(&machine, &structure);
        let measures = SectionLoadModel::new(&machine, &structure, &system, outputs.weight());
        let model = LateralModel { state_space: system, outputs, measures };
        let station = ModalBasis::new(&model, speed, None).expect("has a basis");
        (model, station)
    }

    const MACHINES: [(&str, [&str; 2], f64, f64); 4] = [
        ("lp_turbine", ["\"6e8 N/m\"", "\"6e8 N/m\""], 150.0, 4.0),
        ("lp_turbine", ["\"6e8 N/m\"", "[[6e8, 2e8], [-1e8, 4e8]]"], 60.0, 4.0),
        ("lab_rig", ["\"2e6 N/m\"", "\"2e6 N/m\""], 500.0, 16.0),
        ("lab_rig", ["\"2e6 N/m\"", "[[2e6, 3e5], [-1e5, 1.7e6]]"], 240.0, 8.0),
    ];

    #[test]
    fn a_basis_from_the_station_beside_is_that_of_its_own_motions() {
        for (name, stiffness, speed, spacing) in MACHINES {
            let (model, mut station) = station(name, stiffness, speed);
            let system = &model.state_space;
            // on the way down, and back up
            for step in 1..=12 {
                let to =
                    if step <= 6 { speed - f64::from(step) * spacing } else { speed - f64::from(12 - step) * spacing };
                let (generator, motions) = (system.system_matrix(to), system.eigen_motions(to).expect("solvable"));
                let change = system.system_matrix_change(station.interval_model.speed, to);
                let whole = &generator - system.system_matrix(station.interval_model.speed);
                assert!((&change - &whole).amax() < 1e-13 * generator.amax(), "{name}: the change of A");
                let e = mul(&station.left, &mul(&change, &station.right));
                let right = continued_basis(&station.right, &station.blocks, &e).expect("near enough");
                let wanted =
                    modal_planes::aligned_with_neighbour(&motions, &generator, &station.left).expect("found again");
                assert!((&right - &wanted).amax() < 1e-9, "{name} {to}: {}", (&right - &wanted).amax());
                station = ModalBasis::new(&model, to, Some(&station)).expect("has a basis");
                assert_eq!(station.right, right, "{name}: it is what a station takes");
                // A R = R B
                let (pairs, moved) = (station.blocks.len(), mul(&generator, &right));
                for (k, block) in station.blocks.iter().enumerate() {
                    for j in 0..2 {
                        let kept = right.column(k) * block[j] + right.column(k + pairs) * block[2 + j];
                        let off = (moved.column(k + j * pairs) - kept).amax();
                        assert!(off < 1e-13 * generator.amax(), "{name} {to}, pair {k}: {off}");
                    }
                }
            }
        }
    }

    #[test]
    fn far_from_a_station_there_is_none() {
        let (name, stiffness, speed, _) = MACHINES[0];
        let (model, station) = station(name, stiffness, speed);
        let change = model.state_space.system_matrix_change(speed, 20.0 * speed);
        let e = mul(&station.left, &mul(&change, &station.right));
        assert!(continued_basis(&station.right, &station.blocks, &e).is_none());
        // equal blocks have nothing between them that could tell them apart, unless nothing changes
        let (equal, one) = (vec![[0.0, 1.0, -4.0, 0.0]; 2], Matrix::identity(4, 4));
        assert_eq!(continued_basis(&one, &equal, &Matrix::zeros(4, 4)), Some(one.clone()));
        assert!(continued_basis(&one, &equal, &Matrix::from_element(4, 4, 0.1)).is_none());
    }

    /// Down through rest, where an isotropic rotor's modes cross, and as far on the other side: what is not near has its own motions, and all goes on from there.
    #[test]
    fn a_chain_goes_on_behind_modes_that_cross() {
        for (name, stiffness, speed, spacing) in MACHINES {
            let (model, mut station) = station(name, stiffness, speed);
            let (mut own, mut to) = (0, speed);
            for _ in 0..(2.0 * speed / spacing) as usize {
                to -= spacing;
                let change = model.state_space.system_matrix_change(station.interval_model.speed, to);
                let e = mul(&station.left, &mul(&change, &station.right));
                own += usize::from(continued_basis(&station.right, &station.blocks, &e).is_none());
                station = ModalBasis::new(&model, to, Some(&station)).expect("has a basis");
            }
            let generator = mul(&station.left, &mul(&model.state_space.system_matrix(to), &station.right));
            let size = station.blocks.len();
            for (i, j) in (0..2 * size).flat_map(|i| (0..2 * size).map(move |j| (i, j))) {
                let kept = if i % size == j % size { station.blocks[i % size][2 * (i / size) + j / size] } else { 0.0 };
                assert!((generator[(i, j)] - kept).abs() < 1e-12 * generator.amax(), "{name}: {i} {j}");
            }
            println!("{name}: {own} of their own");
            assert!(own <= 12, "{name}: {own}");
        }
    }
}
