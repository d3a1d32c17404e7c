//! `[monitors.NAME]`: places of the shaft whose displacement is monitored.

use super::path::below;
use super::places::{self, Nodes};
use super::reader::Reader;
use crate::machine::model::Monitor;

/// Largest number of monitors: each has result columns, and a message between processes has limited space.
const MOST: usize = 20;

pub(super) fn monitors(reader: &mut Reader<'_>, nodes: Option<&Nodes>) -> Option<Vec<Monitor>> {
    let names: Vec<String> = reader.layout.group("monitors").iter().map(|member| member.name.clone()).collect();
    if names.len() > MOST {
        reader.fail("monitors", format!("{} monitors", names.len()), format!("at most {MOST}"));
    }
    let monitor = |name: &String| {
        let table = &*below("monitors", name);
        let node = places::node(reader, nodes, table);
        let gap = reader.number(&below(table, "gap"));
        Some(Monitor { name: name.clone(), node: node?, gap: gap? })
    };
    let all: Vec<Option<Monitor>> = names.iter().map(monitor).collect();
    all.into_iter().collect()
}
