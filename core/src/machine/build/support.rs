//! Whether the bearings hold the rotor.

use nalgebra::{Matrix4, SMatrix};

use super::reader::Reader;
use super::shaft::Nodes;
use crate::machine::model::Bearing;

/// Stiffnesses that differ by more than this count as none.
const SINGULAR: f64 = 1e-12;

/// At least one bearing holds the shaft along Z.
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

/// The bearings hold the rigid rotor in X and Y, and a shaft also against tilt.
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
    let mut sum = SMatrix::<f64, 2, 2>::zeros();
    for bearing in bearings {
        sum += SMatrix::<f64, 2, 2>::from_fn(|i, j| bearing.stiffness[i][j]);
    }
    let largest = sum.amax();
    // A negative determinant is a static instability.
    largest > 0.0 && (sum / largest).determinant() > SINGULAR
}

fn holds_line(bearings: &[Bearing], nodes: &[f64]) -> bool {
    let places: Vec<f64> = bearings.iter().map(|bearing| nodes[bearing.node]).collect();
    let (low, high) = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &z| (a.min(z), b.max(z)));
    if low >= high || bearings.is_empty() {
        return false;
    }
    // Stiffness of the rigid shaft for X, Y and tilt about both, with z from -1 to 1 between the outermost bearings.
    let mut sum = Matrix4::<f64>::zeros();
    for (bearing, z) in bearings.iter().zip(places) {
        let arm = (2.0 * z - low - high) / (high - low);
        let shape = [1.0, arm];
        sum += Matrix4::from_fn(|i, j| shape[i / 2] * shape[j / 2] * bearing.stiffness[i % 2][j % 2]);
    }
    let largest = sum.amax();
    if largest == 0.0 || !largest.is_finite() {
        return false;
    }
    let sum = sum / largest;
    let values = sum.singular_values();
    values.min() > SINGULAR * values.max() && sum.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bearing(node: usize, stiffness: [[f64; 2]; 2]) -> Bearing {
        Bearing { name: "b".into(), node, stiffness, damping: [[0.0; 2]; 2], axial_stiffness: 0.0 }
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

    #[test]
    fn cross_coupling_of_a_journal_bearing_is_no_lack_of_support() {
        let journal = [[1e7, 4e7], [-1e6, 1e7]];
        assert!(holds_line(&[bearing(0, journal), bearing(1, journal)], &[0.0, 1.0]));
        assert!(holds_point(&[bearing(0, journal)]));
        assert!(!holds_point(&[bearing(0, [[1e7, 0.0], [0.0, -1e7]])]));
        assert!(!holds_point(&[]));
    }
}
