//! Check that the bearings hold the rotor.

use super::places::Nodes;
use super::reader::Reader;
use crate::machine::model::Bearing;

/// A ratio of smallest to largest stiffness below this counts as zero.
const SINGULAR: f64 = 1e-12;

/// Checks that at least one bearing holds the shaft along Z.
pub(super) fn check_axial(reader: &mut Reader<'_>, bearings: &[Bearing]) {
    if bearings.iter().any(|bearing| bearing.axial_stiffness > 0.0) {
        return;
    }
    let path = match bearings.first() {
        Some(bearing) => format!("rotor.bearings.{}.axial_stiffness", bearing.name),
        None => "rotor.bearings".to_owned(),
    };
    reader.fail(
        &path,
        "no axial support: no bearing has axial stiffness",
        "axial_stiffness > 0 N/m on at least one bearing",
    );
}

/// Checks that the bearings hold the rigid rotor in X and Y, and a shaft also against tilt.
pub(super) fn check_lateral(reader: &mut Reader<'_>, bearings: &[Bearing], nodes: Option<&Nodes>) {
    let Some(nodes) = nodes else { return };
    let (held, allowed) = match nodes {
        Nodes::Point => (holds_point(bearings), "bearings whose summed stiffness resists every translation"),
        Nodes::Line(nodes) => (
            holds_line(bearings, nodes),
            "bearings at two or more nodes whose stiffness resists every translation and tilt",
        ),
    };
    if !held {
        reader.fail("rotor.bearings", "no lateral support: the bearings do not hold the rotor", allowed);
    }
}

fn holds_point(bearings: &[Bearing]) -> bool {
    let mut sum = [[0.0; 2]; 2];
    for stiffness in bearings.iter().map(Bearing::stiffness_to_ground) {
        (0..4).for_each(|at| sum[at / 2][at % 2] += stiffness[at / 2][at % 2]);
    }
    let largest = largest(&sum);
    let [[xx, xy], [yx, yy]] = sum.map(|row| row.map(|entry| entry / largest));
    // A negative determinant is a static instability.
    largest > 0.0 && xx * yy - xy * yx > SINGULAR
}

fn holds_line(bearings: &[Bearing], nodes: &[f64]) -> bool {
    let places: Vec<f64> = bearings.iter().map(|bearing| nodes[bearing.node]).collect();
    let (low, high) = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &z| (a.min(z), b.max(z)));
    if low >= high || bearings.is_empty() {
        return false;
    }
    // Stiffness of the rigid shaft for X, Y and tilt about both axes, with z from -1 to 1 between the outermost bearings.
    let mut sum = [[0.0; 4]; 4];
    for (bearing, z) in bearings.iter().zip(places) {
        let arm = (2.0 * z - low - high) / (high - low);
        let (shape, stiffness) = ([1.0, arm], bearing.stiffness_to_ground());
        for i in 0..4 {
            (0..4).for_each(|j| sum[i][j] += shape[i / 2] * shape[j / 2] * stiffness[i % 2][j % 2]);
        }
    }
    let largest = largest(&sum);
    if largest == 0.0 || !largest.is_finite() {
        return false;
    }
    let (values, determinant) = singular_values(sum.map(|row| row.map(|entry| entry / largest)));
    let (least, most) = values.iter().fold((f64::INFINITY, 0.0), |(a, b), &value| (value.min(a), value.max(b)));
    least > SINGULAR * most && determinant > 0.0
}

/// Largest absolute value of an entry.
fn largest<const N: usize>(matrix: &[[f64; N]; N]) -> f64 {
    matrix.iter().flatten().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}

/// Singular values and determinant of a 4x4 matrix.
///
/// One-sided Jacobi method: rows are rotated in pairs until all are orthogonal to each other; their lengths are the singular values. The
/// method keeps the relative accuracy of small singular values, and rotations preserve the determinant.
/// Source: Hestenes, J. SIAM 6 (1958), 51-90. Verified by `singular_values_are_those_of_the_factors`.
fn singular_values(mut rows: [[f64; 4]; 4]) -> ([f64; 4], f64) {
    /// Most sweeps; convergence is quadratic and takes about five.
    const ROUNDS: usize = 30;
    let dot = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for _ in 0..ROUNDS {
        let mut turned = false;
        for (p, q) in [(0, 1), (2, 3), (0, 2), (1, 3), (0, 3), (1, 2)] {
            let (pp, qq, pq) = (dot(&rows[p], &rows[p]), dot(&rows[q], &rows[q]), dot(&rows[p], &rows[q]));
            if pq.abs() <= f64::EPSILON * (pp * qq).sqrt() {
                continue;
            }
            turned = true;
            let cotangent = (qq - pp) / (2.0 * pq);
            let tangent = f64::copysign(1.0, cotangent) / (cotangent.abs() + cotangent.hypot(1.0));
            let cos = 1.0 / tangent.hypot(1.0);
            let sin = cos * tangent;
            for at in 0..4 {
                let (a, b) = (rows[p][at], rows[q][at]);
                (rows[p][at], rows[q][at]) = (cos * a - sin * b, sin * a + cos * b);
            }
        }
        if !turned {
            break;
        }
    }
    // Laplace expansion by the minors of the upper and the lower two rows
    let minor = |row: usize, a: usize, b: usize| rows[row][a] * rows[row + 1][b] - rows[row][b] * rows[row + 1][a];
    let pairs = [
        (0, 1, 2, 3, 1.0),
        (0, 2, 1, 3, -1.0),
        (0, 3, 1, 2, 1.0),
        (1, 2, 0, 3, 1.0),
        (1, 3, 0, 2, -1.0),
        (2, 3, 0, 1, 1.0),
    ];
    let determinant = pairs.map(|(a, b, c, d, sign)| sign * minor(0, a, b) * minor(2, c, d)).iter().sum();
    (rows.map(|row| dot(&row, &row).sqrt()), determinant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::model::Pedestal;

    fn bearing(node: usize, stiffness: [[f64; 2]; 2]) -> Bearing {
        Bearing {
            name: "b".into(),
            node,
            stiffness,
            damping: [[0.0; 2]; 2],
            axial_stiffness: 0.0,
            clearance: None,
            elevation: [0.0; 2],
            pedestal: None,
            table: None,
        }
    }

    #[test]
    fn a_shaft_needs_stiffness_in_both_directions_at_two_places() {
        let nodes = [0.0, 1.0, 2.0];
        let full = [[1e8, 0.0], [0.0, 1e8]];
        let (x, y) = ([[1e8, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1e8]]);
        assert!(holds_line(&[bearing(0, full), bearing(2, full)], &nodes));
        assert!(holds_line(&[bearing(0, x), bearing(0, y), bearing(1, full)], &nodes));
        assert!(!holds_line(&[bearing(0, full), bearing(0, full)], &nodes));
        assert!(!holds_line(&[bearing(0, x), bearing(2, full)], &nodes));
        assert!(!holds_line(&[], &nodes));
    }

    /// Rotations by about 0.3 and 1.1 rad in two planes each, on both sides of a diagonal of known values.
    #[test]
    fn singular_values_are_those_of_the_factors() {
        let turn = |mut rows: [[f64; 4]; 4], (p, q): (usize, usize), angle: f64| {
            let (sin, cos) = angle.sin_cos();
            for at in 0..4 {
                let (a, b) = (rows[p][at], rows[q][at]);
                (rows[p][at], rows[q][at]) = (cos * a - sin * b, sin * a + cos * b);
            }
            rows
        };
        let transposed = |rows: [[f64; 4]; 4]| [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| rows[j][i]));
        for (values, sign) in
            [([3.0, 2.0, 1.0, 0.5], 1.0), ([1.0, 1e-3, 7e-8, 2e-11], -1.0), ([1.0, 1.0, 0.0, 1.0], 1.0)]
        {
            let mut matrix = [[0.0; 4]; 4];
            (0..4).for_each(|i| matrix[i][i] = values[i]);
            matrix[0][0] *= sign;
            for _ in 0..2 {
                for (planes, angle) in [((0, 1), 0.3), ((2, 3), 1.1), ((0, 2), 1.1), ((1, 3), 0.3)] {
                    matrix = turn(matrix, planes, angle);
                }
                matrix = transposed(matrix);
            }
            let (mut found, determinant) = singular_values(matrix);
            found.sort_by(|a, b| b.total_cmp(a));
            let mut sorted = values;
            sorted.sort_by(|a, b| b.total_cmp(a));
            for (found, expected) in found.iter().zip(sorted) {
                assert!((found - expected).abs() < 1e-15 + 1e-14 * expected, "{values:?}: {found:e} {expected:e}");
            }
            let expected = sign * values.iter().product::<f64>();
            // the rotations' rounding affects the smallest value most
            let rounding = 1e-14 * sorted[..3].iter().product::<f64>();
            assert!((determinant - expected).abs() < rounding, "{determinant:e} {expected:e}");
        }
    }

    #[test]
    fn cross_coupling_of_a_journal_bearing_is_no_lack_of_support() {
        let journal = [[1e7, 4e7], [-1e6, 1e7]];
        assert!(holds_line(&[bearing(0, journal), bearing(1, journal)], &[0.0, 1.0]));
        assert!(holds_point(&[bearing(0, journal)]));
        assert!(!holds_point(&[bearing(0, [[1e7, 0.0], [0.0, -1e7]])]));
        assert!(!holds_point(&[]));
    }

    #[test]
    fn a_pedestal_is_in_series() {
        let pedestal = |stiffness| Some(Pedestal { mass: [1.0; 2], stiffness, damping: [0.0; 2] });
        let mut one = bearing(0, [[3.0, 0.0], [0.0, 6.0]]);
        one.pedestal = pedestal([6.0, 3.0]);
        assert_eq!(one.stiffness_to_ground(), [[2.0, 0.0], [0.0, 2.0]]);
        // K_p (K + K_p)^-1 K of a journal bearing, calculated by hand
        one.stiffness = [[1.0, 2.0], [-1.0, 1.0]];
        one.pedestal = pedestal([1.0, 3.0]);
        let (found, expected) = (one.stiffness_to_ground(), [[0.6, 0.6], [-0.3, 1.2]]);
        let pairs = found.as_flattened().iter().zip(expected.as_flattened());
        pairs.for_each(|(found, expected): (&f64, &f64)| {
            assert!((found - expected).abs() < 1e-14, "{found}, not {expected}")
        });
    }
}
