//! `[set]`: overrides of the machine for the whole study.

use super::definition::Fixed;
use super::table::{Keys, scalar_text, wrong_type};
use super::vary::{Given, PathTable};
use bladeoff_system::call::program;
use bladeoff_text::document::{Collector, Entry, Value, cut};

/// Longest path \[bytes\]: the name of a table is repeated in each of its keys.
const LONGEST_PATH: usize = 512;

/// Reads `[set]`: quoted paths or nested tables, with the same meaning.
pub(super) fn read_set(entry: &Entry, paths: &PathTable<'_>, problems: &mut Collector<'_>) -> Vec<Fixed> {
    let mut found = Vec::new();
    if let Some(keys) = Keys::of(entry, "set", problems) {
        fixed_below("", keys.entries(), paths, &mut found, problems);
    }
    found
}

/// The overrides of one table. The parser bounds the depth of nesting.
fn fixed_below(
    above: &str,
    entries: &[Entry],
    paths: &PathTable<'_>,
    found: &mut Vec<Fixed>,
    problems: &mut Collector<'_>,
) {
    for entry in entries {
        let path = if above.is_empty() { entry.name.clone() } else { format!("{above}.{}", entry.name) };
        let key = format!("set.{}", cut(&path, 120));
        if path.len() > LONGEST_PATH {
            let problem = problems.add(entry.name_span.clone(), key, "longer than any parameter's path");
            problem.allowed = Some(format!("a path of `{} paths MACHINE`, or its ending", program()));
            continue;
        }
        if let Value::Table(inner) = &entry.node.value {
            fixed_below(&path, inner, paths, found, problems);
            continue;
        }
        let value = Some(problems.excerpt(entry.node.span.clone()));
        let at = Given { span: entry.name_span.clone(), key: &key, value };
        let Some(info) = paths.resolve(&path, at, problems) else { continue };
        paths.used(&info, entry.name_span.clone(), &key);
        let Some(text) = scalar_text(&entry.node.value) else {
            wrong_type(&entry.node, &key, "a number, a string with a unit or a word", problems);
            continue;
        };
        if let Some(value) = paths.value(&info, &text, entry.node.span.clone(), &key, problems) {
            found.push(Fixed { info, value, place: entry.name_span.clone() });
        }
    }
}
