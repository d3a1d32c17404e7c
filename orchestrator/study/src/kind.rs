//! Recognises the kind of a file from its text, for messages to users who gave the other kind.

use bladeoff_text::document::{Value, parse_toml};

/// A file of this program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileKind {
    /// A machine.
    Machine,
    /// A study, with the machine that it names, if any.
    Study(Option<String>),
    /// A rotor as ROSS saves it (TOML or JSON).
    Ross,
}

/// Kind of a text by its outermost keys; `None`: unreadable or ambiguous.
#[must_use]
pub fn kind_of(text: &str) -> Option<FileKind> {
    if is_of_ross(text) {
        return Some(FileKind::Ross);
    }
    // also with syntax errors: the reader of the right kind reports them with all others
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

/// Classes of ROSS whose objects identify its files: `"BearingElement_Bearing 0"` is a table of TOML or an object of JSON.
const ROSS: [&str; 6] =
    ["ShaftElement_", "DiskElement_", "BearingElement_", "SealElement_", "CouplingElement_", "PointMass_"];

/// Whether a text has elements as ROSS saves them: each is a table or an object named by its class and a tag.
fn is_of_ross(text: &str) -> bool {
    let is_named = |(at, _): (usize, &str)| {
        let start = text[..at].rfind(|c: char| !c.is_ascii_alphanumeric()).map_or(0, |before| before + 1);
        let before = text[..start].trim_end_matches(['"', '\'']);
        let line = &before[before.rfind('\n').map_or(0, |newline| newline + 1)..];
        // a header of TOML, or the key of a JSON object
        if line.trim() == "[" {
            return true;
        }
        let rest = text[at..].split_once('"').map_or("", |(_, rest)| rest);
        before.len() < start && before.trim_end().ends_with(['{', ',']) && rest.trim_start().starts_with(':')
    };
    ROSS.iter().any(|class| text.match_indices(class).any(is_named))
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
        // a bearing alone, a fluid-film bearing, and names of this program that resemble a class
        for ross in ["[\"BearingElement_a\"]\nn = 0\n", "[BallBearingElement_a]\nn = 0\n", "{ \"SealElement_0\" : {}}"]
        {
            assert_eq!(kind_of(ross), Some(FileKind::Ross), "{ross}");
        }
        for own in [
            "name = \"ShaftElement_1\"\n[rotor]\n",
            "[rotor.bearings.BearingElement_a]\n",
            "x = [\"a\", \"DiskElement_1\"]",
        ] {
            assert_ne!(kind_of(own), Some(FileKind::Ross), "{own}");
        }
        for broken in ["[rotor", "name = \"lab\n[rotor]\nkind = \"beam\"\n"] {
            assert_eq!(kind_of(broken), Some(FileKind::Machine), "{broken}");
        }
        for neither in ["", "schema = 1\nname = \"x\"", "machine = \"m.toml\"\n[rotor]\n", "a,b\n1,2\n"] {
            assert_eq!(kind_of(neither), None, "{neither}");
        }
    }
}
