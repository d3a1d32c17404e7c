//! Positions along the shaft: a disc, bearing or contact between two nodes splits the element and creates a node.

use super::path::{Path, below, joined};
use super::reader::Reader;
use crate::machine::model::ShaftElement;
use bladeoff_text::document::units::format_digits;

/// Most elements of all sections together: matrices are dense, and eigenvalue problems cost the cube.
pub(super) const MOST_ELEMENTS: usize = 500;

/// Nodes that a position may refer to.
pub(super) enum Nodes {
    /// The one node of a mass point.
    Point,
    /// Positions along the shaft, ascending.
    Line(Vec<f64>),
}

pub(super) struct Line {
    pub nodes: Vec<f64>,
    /// `None`: the nodes are known, but a cross-section is invalid.
    pub elements: Option<Vec<ShaftElement>>,
}

/// Largest distance from a node, as a share of the shaft's length, at which a position refers to that node; allows for rounding in files.
const TOLERANCE: f64 = 1e-6;
/// Shortest part of a split element, as a share of the shaft's length. The square of the highest frequency grows as the square of 1/length, and
/// rounding grows with it: at 1e-3 of a slender shaft, the lowest frequency keeps six digits, at 1e-4 three.
const SHORTEST: f64 = 1e-3;

/// Tables whose `position` is on the shaft.
fn tables(reader: &Reader<'_>) -> Vec<Path> {
    let groups = [
        ("rotor.discs", ""),
        ("rotor.bearings", ""),
        ("rotor.unbalances", ""),
        ("diaphragms", ".contact"),
        ("monitors", ""),
        ("torques", ""),
    ];
    let members = groups.iter().flat_map(|(group, below)| {
        reader.layout.group(group).iter().map(move |member| joined(&[group, ".", &member.name, below]))
    });
    members.collect()
}

/// Positions of the two ends of a layer \[m\], as far as the file gives them.
pub(super) fn layer_ends(reader: &Reader<'_>, table: &str) -> [Option<f64>; 2] {
    let start = reader.number(&below(table, "position"));
    [start, start.and_then(|start| Some(start + reader.number(&below(table, "length"))?))]
}

/// Splits the elements that contain a position. The nodes do not depend on the order of the file.
pub(super) fn split(reader: &Reader<'_>, line: &mut Line) {
    let mut places: Vec<f64> =
        tables(reader).iter().filter_map(|table| reader.number(&below(table, "position"))).collect();
    let layers = reader.layout.group("rotor.layers").iter();
    places.extend(layers.flat_map(|layer| layer_ends(reader, &below("rotor.layers", &layer.name))).flatten());
    places.sort_by(f64::total_cmp);
    for place in places {
        if let Where::Between(right) = find(&line.nodes, place)
            && line.nodes.len() <= MOST_ELEMENTS
        {
            let (from, to) = (line.nodes[right - 1], line.nodes[right]);
            line.nodes.insert(right, place);
            if let Some(elements) = &mut line.elements {
                let whole = elements[right - 1];
                let cut = (place - from) / (to - from);
                elements[right - 1] = whole.part([0.0, cut], place - from);
                elements.insert(right, whole.part([cut, 1.0], to - place));
            }
        }
    }
}

/// Location of a position.
enum Where {
    /// At this node.
    Node(usize),
    /// In the element that ends at this node.
    Between(usize),
    /// So close to this node that an element between them would be too short.
    Near(usize),
    Outside,
}

fn find(nodes: &[f64], place: f64) -> Where {
    let length = nodes[nodes.len() - 1];
    let tolerance = TOLERANCE * length;
    let right = nodes.partition_point(|z| *z < place);
    let distance = |node: usize| nodes.get(node).map_or(f64::INFINITY, |z| (z - place).abs());
    let left = right.saturating_sub(1);
    let nearest = if distance(left) <= distance(right) { left } else { right };
    if distance(nearest) <= tolerance {
        Where::Node(nearest)
    } else if right == nodes.len() || right == 0 {
        Where::Outside
    } else if distance(nearest) < SHORTEST * length {
        Where::Near(nearest)
    } else {
        Where::Between(right)
    }
}

/// The node of the table's `position`, after [`split`]; reports an invalid position. `None`: unknown.
pub(super) fn node(reader: &mut Reader<'_>, nodes: Option<&Nodes>, table: &str) -> Option<usize> {
    let nodes = match nodes? {
        Nodes::Point => return Some(0),
        Nodes::Line(nodes) => nodes,
    };
    let path = below(table, "position");
    let place = reader.number(&path)?;
    node_at(reader, nodes, &path, place)
}

/// The node at a position \[m\] that a key determines; reports an invalid position.
pub(super) fn node_at(reader: &mut Reader<'_>, nodes: &[f64], path: &str, place: f64) -> Option<usize> {
    let length = nodes[nodes.len() - 1];
    let metres = |z: f64| format_digits(z, "m", 10);
    match find(nodes, place) {
        Where::Node(node) => return Some(node),
        Where::Outside => drop(reader.fail(path, "outside the shaft", format!("0 to {}", metres(length)))),
        Where::Near(node) => {
            let apart = (place - nodes[node]).abs();
            let message = format!(
                "{} from the node at {}: the element between them would be too short to be computed with",
                format_digits(apart, "m", 3),
                metres(nodes[node])
            );
            let allowed = format!("{}, or at least {} away from it", metres(nodes[node]), metres(SHORTEST * length));
            reader.fail(path, message, allowed);
        }
        Where::Between(_) => {
            let message = "no node there, and no further element can be split";
            reader.fail(path, message, format!("at most {MOST_ELEMENTS} elements in all sections together"));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_a_node_between_two_or_too_near_to_one() {
        let nodes = [0.0, 1.0, 2.0];
        for (place, expected) in [
            (0.0, "node 0"),
            (1.0 + 1.9e-6, "node 1"),
            (1.0 - 1.9e-6, "node 1"),
            (2.0 + 1.9e-6, "node 2"),
            (2.0 + 2.1e-6, "outside"),
            (1.0 + 2.1e-6, "near 1"),
            (1.0019, "near 1"),
            (0.9981, "near 1"),
            (1.0021, "between 2"),
            (0.5, "between 1"),
        ] {
            let found = match find(&nodes, place) {
                Where::Node(node) => format!("node {node}"),
                Where::Between(right) => format!("between {right}"),
                Where::Near(node) => format!("near {node}"),
                Where::Outside => "outside".to_owned(),
            };
            assert_eq!(found, expected, "{place}");
        }
    }
}
