//! Continuation of a modal basis: its modal planes at a new speed from those of the neighbouring basis, without an eigenvalue problem.
//!
//! ```text
//! L' A R' = D + E                  L', R', D: left and right vectors and blocks of the known basis;  E = L' (A - A') R', of the change of A   (1)
//! (D + E) X = X B,  [X]_kk = 1     with X = 1 + N:   D_l N_lk - N_lk D_k = N_lk [E X]_kk - [E X]_lk                                         (2)
//! D M - M F = C                    M = (D^2 - tr F D + det F)^-1 (D C - C adj F)                                                          (3)
//! R = R' X                         right vectors of the new basis
//! ```
//! `A`, `A'`: system matrices at the new speed and at that of the known basis; `B`: blocks of the new basis; `X = 1 + N`: new planes in the known ones; `M`, `F`, `C`: 2 x 2 blocks.
//!
//! (2) states that each plane is invariant and not rotated in itself (`modal_planes`). It is solved by iteration from N = 0. Each iteration reduces the error by
//! about |E| divided by the distance of the eigenvalues of two planes: to one or two per cent at the default grid spacing. (3) is a Sylvester equation of 2 x 2 blocks, solved by the theorem of Cayley and Hamilton for F.
//! E comes from the change of A alone, so the rounding of large entries of A does not reach slow planes.
//!
//! This iteration, with the coupling that rounding left between the planes of an eigenvalue problem as E, refines a basis at its own speed (`modal_basis`). Without this, loads of soft bearings with
//! strong damping changed by 1e-5 with the last digits of a machine.
//! Limits: there is no continuation if N is not small, or if the iteration does not halve its changes: where planes cross or merge. A coupling of the known basis remains in the new one.
//! Source: Stewart, Error and perturbation bounds for subspaces, SIAM Review 15, 1973; (2) is its equation for one subspace, written for each plane.
//! Verified by the tests below and `loads_of_soft_bearings_do_not_hang_on_last_digits` (`tests/exponential/exponential_edges.rs`).

use super::plane_block::PlaneBlock;
use bladeoff_numerics::linalg::lanes::kernel;
use bladeoff_numerics::linalg::{Matrix, mul};

/// Largest number of iterations; a change of A by a per cent takes eight.
const MAX_ITERATIONS: usize = 40;
/// Number of iterations after which each one has to halve its change.
const FREE_ITERATIONS: usize = 4;
/// Largest Frobenius norm of N.
const MAX_CHANGE_NORM: f64 = 0.3;

/// Right vectors of the invariant planes of `D + E` by (2), with D the blocks of a basis with the given right vectors; `None` if the iteration does not converge.
pub(crate) fn continued_basis(right: &Matrix, blocks: &[PlaneBlock], e: &Matrix) -> Option<Matrix> {
    if e.amax() == 0.0 {
        return Some(right.clone());
    }
    let planes = blocks.len();
    let entries = [0, 1, 2, 3].map(|i| blocks.iter().map(|block| block[i]).collect::<Vec<f64>>());
    let weights: Vec<[Vec<f64>; 4]> = (0..planes).map(|k| sylvester_weights(blocks, k)).collect();
    let (mut n, mut previous_change) = (Matrix::zeros(2 * planes, 2 * planes), f64::INFINITY);
    for iteration in 0..MAX_ITERATIONS {
        let e_x = e + mul(e, &n);
        let block_of = |k: usize| -> PlaneBlock {
            [e_x[(k, k)], e_x[(k, k + planes)], e_x[(k + planes, k)], e_x[(k + planes, k + planes)]]
        };
        let mut largest = 0.0;
        let (firsts, seconds) = n.as_mut_slice().split_at_mut(2 * planes * planes);
        let columns = firsts.chunks_exact_mut(2 * planes).zip(seconds.chunks_exact_mut(2 * planes));
        let (e_x_columns, others) = e_x.as_slice().split_at(2 * planes * planes);
        let e_x_columns = e_x_columns.chunks_exact(2 * planes).zip(others.chunks_exact(2 * planes));
        for (k, ((columns, e_x_columns), weights)) in columns.zip(e_x_columns).zip(&weights).enumerate() {
            iterate_plane([blocks[k], block_of(k)], &entries, weights, e_x_columns, columns, &mut largest);
        }
        if largest <= f64::EPSILON {
            return (n.norm() < MAX_CHANGE_NORM).then(|| right + mul(right, &n));
        }
        let halves = iteration < FREE_ITERATIONS || largest < 0.5 * previous_change;
        if largest.is_nan() || largest > 1.0 || !halves {
            return None;
        }
        previous_change = largest;
    }
    None
}

/// Inverse matrices in (3), entry by entry, for the blocks D of all planes and the block of plane k as F; zero for plane k itself.
fn sylvester_weights(blocks: &[PlaneBlock], k: usize) -> [Vec<f64>; 4] {
    let [a, b, c, d] = blocks[k];
    let (trace, determinant) = (a + d, a * d - b * c);
    let mut inverses = [const { Vec::new() }; 4];
    for (l, &[p, q, r, s]) in blocks.iter().enumerate() {
        let [x, y, z, w] = [
            p * p + q * r - trace * p + determinant,
            q * (p + s - trace),
            r * (p + s - trace),
            s * s + q * r - trace * s + determinant,
        ];
        let factor = if l == k { 0.0 } else { 1.0 / (x * w - y * z) };
        for (list, entry) in inverses.iter_mut().zip([w, -y, -z, x]) {
            list.push(factor * entry);
        }
    }
    inverses
}

kernel! {
    /// Iterates (2) once for the two columns of plane k.
    ///
    /// `own`: its D_k and [E X]_kk; `entries`: those of the blocks D of all planes; `largest`: largest change so far.
    fn iterate_plane(
        own: [PlaneBlock; 2],
        entries: &[Vec<f64>; 4],
        weights: &[Vec<f64>; 4],
        e_x_columns: (&[f64], &[f64]),
        columns: (&mut [f64], &mut [f64]),
        largest: &mut f64,
    ) {
        let [[a, b, c, d], [e, f, g, h]] = own;
        let planes = entries[0].len();
        let (p, q, r, s) = (&entries[0][..planes], &entries[1][..planes], &entries[2][..planes], &entries[3][..planes]);
        let (x, y, z, w) = (&weights[0][..planes], &weights[1][..planes], &weights[2][..planes], &weights[3][..planes]);
        let ((u, u_below), (v, v_below)) = (e_x_columns.0.split_at(planes), e_x_columns.1.split_at(planes));
        let ((m, m_below), (n, n_below)) = (columns.0.split_at_mut(planes), columns.1.split_at_mut(planes));
        let (u_below, v_below, m, n) = (&u_below[..planes], &v_below[..planes], &mut m[..planes], &mut n[..planes]);
        let (m_below, n_below) = (&mut m_below[..planes], &mut n_below[..planes]);
        let mut largest_change = *largest;
        for l in 0..planes {
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
                // a NaN is kept
                let change = (new[i] - old[i]).abs();
                largest_change = if largest_change >= change || largest_change.is_nan() { largest_change } else { change };
            }
            (m[l], n[l], m_below[l], n_below[l]) = (new[0], new[1], new[2], new[3]);
        }
        *largest = largest_change;
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

    /// Model and modal basis at a speed \[rad/s\] of a machine of the repository with a changed bearing stiffness.
    fn machine_basis(name: &str, stiffness: [&str; 2], speed: f64) -> (LateralModel, ModalBasis) {
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
        let basis = ModalBasis::new(&model, speed, None).expect("has a basis");
        (model, basis)
    }

    /// Machine, stiffness before and after the change, speed and grid spacing \[rad/s\].
    const MACHINES: [(&str, [&str; 2], f64, f64); 4] = [
        ("lp_turbine_paper", ["\"6e8 N/m\"", "\"6e8 N/m\""], 150.0, 4.0),
        ("lp_turbine_paper", ["\"6e8 N/m\"", "[[6e8, 2e8], [-1e8, 4e8]]"], 60.0, 4.0),
        ("lab_rig", ["\"2e6 N/m\"", "\"2e6 N/m\""], 500.0, 16.0),
        ("lab_rig", ["\"2e6 N/m\"", "[[2e6, 3e5], [-1e5, 1.7e6]]"], 240.0, 8.0),
    ];

    #[test]
    fn a_continued_basis_equals_that_of_its_eigenvalue_problem() {
        for (name, stiffness, speed, spacing) in MACHINES {
            let (model, mut basis) = machine_basis(name, stiffness, speed);
            let system = &model.state_space;
            // six spacings down, and up again
            for step in 1..=12 {
                let to =
                    if step <= 6 { speed - f64::from(step) * spacing } else { speed - f64::from(12 - step) * spacing };
                let (generator, motions) = (system.system_matrix(to), system.eigen_motions(to).expect("solvable"));
                let change = system.system_matrix_change(basis.interval_model.speed, to);
                let difference = &generator - system.system_matrix(basis.interval_model.speed);
                assert!((&change - &difference).amax() < 1e-13 * generator.amax(), "{name}: the change of A");
                let e = mul(&basis.left, &mul(&change, &basis.right));
                let right = continued_basis(&basis.right, &basis.blocks, &e).expect("near enough");
                let wanted =
                    modal_planes::aligned_with_neighbour(&motions, &generator, &basis.left).expect("found again");
                assert!((&right - &wanted).amax() < 1e-9, "{name} {to}: {}", (&right - &wanted).amax());
                basis = ModalBasis::new(&model, to, Some(&basis)).expect("has a basis");
                assert_eq!(basis.right, right, "{name}: the modal basis takes the continued one");
                // A R = R B
                let (planes, a_r) = (basis.blocks.len(), mul(&generator, &right));
                for (k, block) in basis.blocks.iter().enumerate() {
                    for j in 0..2 {
                        let kept = right.column(k) * block[j] + right.column(k + planes) * block[2 + j];
                        let error = (a_r.column(k + j * planes) - kept).amax();
                        assert!(error < 1e-13 * generator.amax(), "{name} {to}, pair {k}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn there_is_no_continuation_over_a_large_change() {
        let (name, stiffness, speed, _) = MACHINES[0];
        let (model, basis) = machine_basis(name, stiffness, speed);
        let change = model.state_space.system_matrix_change(speed, 20.0 * speed);
        let e = mul(&basis.left, &mul(&change, &basis.right));
        assert!(continued_basis(&basis.right, &basis.blocks, &e).is_none());
        // planes with equal blocks are not distinguishable, unless nothing changes
        let (equal, identity) = (vec![[0.0, 1.0, -4.0, 0.0]; 2], Matrix::identity(4, 4));
        assert_eq!(continued_basis(&identity, &equal, &Matrix::zeros(4, 4)), Some(identity.clone()));
        assert!(continued_basis(&identity, &equal, &Matrix::from_element(4, 4, 0.1)).is_none());
    }

    /// Chain of bases down through rest, where the modes of an isotropic rotor cross, to the opposite speed: bases that cannot be continued are computed anew, and the chain continues.
    #[test]
    fn a_chain_of_bases_continues_beyond_crossing_modes() {
        for (name, stiffness, speed, spacing) in MACHINES {
            let (model, mut basis) = machine_basis(name, stiffness, speed);
            let (mut eigenvalue_problems, mut to) = (0, speed);
            for _ in 0..(2.0 * speed / spacing) as usize {
                to -= spacing;
                let change = model.state_space.system_matrix_change(basis.interval_model.speed, to);
                let e = mul(&basis.left, &mul(&change, &basis.right));
                eigenvalue_problems += usize::from(continued_basis(&basis.right, &basis.blocks, &e).is_none());
                basis = ModalBasis::new(&model, to, Some(&basis)).expect("has a basis");
            }
            let generator = mul(&basis.left, &mul(&model.state_space.system_matrix(to), &basis.right));
            let size = basis.blocks.len();
            for (i, j) in (0..2 * size).flat_map(|i| (0..2 * size).map(move |j| (i, j))) {
                let kept = if i % size == j % size { basis.blocks[i % size][2 * (i / size) + j / size] } else { 0.0 };
                assert!((generator[(i, j)] - kept).abs() < 1e-12 * generator.amax(), "{name}: {i} {j}");
            }
            println!("{name}: {eigenvalue_problems} eigenvalue problems");
            assert!(eigenvalue_problems <= 12, "{name}: {eigenvalue_problems}");
        }
    }
}
