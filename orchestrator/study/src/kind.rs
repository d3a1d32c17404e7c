//! Which kind of file a text is: for whoever was given the other kind.

use bladeoff_text::document::{Value, parse_toml};

/// A file of this program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileKind {
    /// A machine.
    Machine,
    /// A study, with the machine that it names, if it does.
    Study(Option<String>),
    /// A rotor as ROSS saves it (TOML or JSON).
    Ross,
}

/// What a text is by its outermost keys; `None`: it cannot be read, or might be either.
#[must_use]
pub fn kind_of(text: &str) -> Option<FileKind> {
    if is_of_ross(text) {
        return Some(FileKind::Ross);
    }
    // also around syntax errors: the reader of the right kind reports them beside all others
    let (root, _) = parse_toml("", text).ok()?;
    let entries = root.value.as_table()?;
    let has = |names: &[&str]| entries.iter().any(|entry| names.contains(&entry.name.as_str()));
    match (
        has(&["rotor", "braking", "diaphragms"]),
        has(&["machine", "model", "function", "vary", "points", "set", "uncertain", "design"]),
    ) {
        (true, false) => Some(FileKind::Machine),
        (false, true) => {
            let named = entries.iter().find(|entry| entry.name == "machine").map(|entry| &entry.node.value);
            Some(FileKind::Study(match named {
                Some(Value::Text(machine)) => Some(machine.clone()),
                _ => None,
            }))
        }
        _ => None,
    }
}

/// Whether a text holds elements as ROSS saves them: each is a table or an object named by its class, with its left node `n`.
fn is_of_ross(text: &str) -> bool {
    text.contains("ShaftElement_")
        && text.contains("odl")
        && ["\"ShaftElement_", "'ShaftElement_", "[ShaftElement_"].iter().any(|start| text.contains(start))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{STUDY_MACHINE, STUDY_TEMPLATE};
    use bladeoff_model::machine::machine_template;

    #[test]
    fn templates_are_what_they_are_and_other_texts_nothing() {
        assert_eq!(kind_of(machine_template().as_ref()), Some(FileKind::Machine));
        assert_eq!(kind_of(STUDY_TEMPLATE), Some(FileKind::Study(Some(STUDY_MACHINE.to_owned()))));
        for study in
            ["[[vary]]\npath = \"x\"", "model = \"function\"", "[[uncertain]]\nname = \"x\"", "[design]\nsamples = 3"]
        {
            assert_eq!(kind_of(&format!("schema = 1\n{study}")), Some(FileKind::Study(None)), "{study}");
        }
        for ross in [
            "ross_version = \"2.0.0\"\n[\"ShaftElement_Shaft Element 0\"]\nL = 0.25\nodl = 0.05\nn = 0\n",
            "{\"parameters\": {}, \"ShaftElement_0\": {\"L\": 0.25, \"odl\": 0.05, \"n\": 0}}",
        ] {
            assert_eq!(kind_of(ross), Some(FileKind::Ross), "{ross}");
        }
        for broken in ["[rotor", "name = \"lab\n[rotor]\nkind = \"beam\"\n"] {
            assert_eq!(kind_of(broken), Some(FileKind::Machine), "{broken}");
        }
        for neither in ["", "schema = 1\nname = \"x\"", "machine = \"m.toml\"\n[rotor]\n", "a,b\n1,2\n"] {
            assert_eq!(kind_of(neither), None, "{neither}");
        }
    }
}
