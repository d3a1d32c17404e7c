//! Writes a machine's values as a file in SI, which records the computed machine.

use std::fmt::Write;

use super::def::MachineDef;
use super::layout::Scalar;
use super::schema::{Kind, SCHEMA};

impl MachineDef {
    /// All values as a machine file in SI that builds the same machine.
    #[must_use]
    pub fn to_toml(&self) -> String {
        to_toml(self)
    }
}

/// Every value that applies to the machine, including defaults, in the order of the format.
fn to_toml(def: &MachineDef) -> String {
    let mut out = format!("schema = {SCHEMA}\nname = {}\n", toml::Value::String(def.layout.name.clone()));
    let mut table = String::new();
    let slots = &def.layout.slots;
    let mut index = 0;
    while index < slots.len() {
        let slot = &slots[index];
        let key_path = whole(&slot.path, slot.key.name());
        let end = (index..slots.len()).find(|&i| whole(&slots[i].path, slots[i].key.name()) != key_path);
        let end = end.unwrap_or(slots.len());
        let values: Option<Vec<String>> = (index..end).map(|i| literal(def, i)).collect();
        if let Some(values) = values
            && def.applies(index)
        {
            let (above, name) = key_path.rsplit_once('.').unwrap_or(("", key_path));
            if above != table {
                out.push_str(&header(above));
                texts(def, above, &mut out);
                above.clone_into(&mut table);
            }
            let value = match slot.key.kind {
                Kind::Matrix(_) if slot.part => {
                    format!("[[{}, {}], [{}, {}]]", values[0], values[1], values[2], values[3])
                }
                Kind::Diagonal(_) if !slot.part => values.join(""),
                Kind::Vector(_) | Kind::Diagonal(_) | Kind::List(_) => format!("[{}]", values.join(", ")),
                _ => values.join(""),
            };
            writeln!(out, "{name} = {value}").expect("writing to a string cannot fail");
        }
        index = end;
    }
    out
}

/// The texts of a table.
fn texts(def: &MachineDef, table: &str, out: &mut String) {
    for (path, text) in &def.layout.texts {
        if let (Some((above, name)), Some(value)) = (path.rsplit_once('.'), &text.value)
            && above == table
            && def.holds(def.layout.condition(path, text.key.when))
        {
            writeln!(out, "{name} = {}", toml::Value::String(value.clone())).expect("writing to a string cannot fail");
        }
    }
}

/// Path of the key of which a slot is a component.
fn whole<'a>(path: &'a str, name: &str) -> &'a str {
    let from = path.rfind('.').map_or(0, |at| at + 1);
    &path[..from + name.len()]
}

/// Header of a table: `[rotor.discs.left]`, `[[rotor.shaft]]`, `[rotor.shaft.material]`.
fn header(table: &str) -> String {
    let plain: String = table.split('[').map(|piece| piece.split_once(']').map_or(piece, |(_, rest)| rest)).collect();
    if table.ends_with(']') { format!("\n[[{plain}]]\n") } else { format!("\n[{plain}]\n") }
}

fn literal(def: &MachineDef, index: usize) -> Option<String> {
    match def.states[index].scalar {
        Scalar::Number(number) if def.layout.slots[index].key.kind == Kind::Count => Some(format!("{number:.0}")),
        // Debug format: the shortest decimal that is parsed to the same double, always with point or exponent.
        Scalar::Number(number) => Some(format!("{number:?}")),
        Scalar::Word(word) => Some(format!("\"{word}\"")),
        Scalar::Absent | Scalar::Bad => None,
    }
}
