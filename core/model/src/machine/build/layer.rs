//! `[rotor.layers.NAME]`: sleeves and other layers on the shaft.

use super::path::below;
use super::places::{self, Nodes};
use super::reader::Reader;
use super::shaft::Form;
use crate::machine::model::{Layer, ShaftElement};

/// Reads one layer; `elements`: those of the shaft, which end at its nodes.
pub(super) fn layer(
    reader: &mut Reader<'_>,
    nodes: Option<&Nodes>,
    elements: Option<&[ShaftElement]>,
    name: &str,
    table: &str,
) -> Option<Layer> {
    let form = Form::read(reader, table);
    let Some(Nodes::Line(nodes)) = nodes else { return None };
    let [start, end] = places::layer_ends(reader, table);
    let first = start.and_then(|place| places::node_at(reader, nodes, &below(table, "position"), place));
    let last = end.and_then(|place| places::node_at(reader, nodes, &below(table, "length"), place));
    let (first, last, form, elements) = (first?, last?, form?, elements?);
    if last <= first {
        reader.fail(&below(table, "length"), "too short to be computed with", "a length with a node at each end");
        return None;
    }
    let (from, whole) = (nodes[first], nodes[last] - nodes[first]);
    let place = |node: usize| (nodes[node] - from) / whole;
    let part = |i: usize| form.part([place(i), place(i + 1)], elements[i].length, elements[i].section);
    Some(Layer { name: name.to_owned(), first, elements: (first..last).map(part).collect() })
}
