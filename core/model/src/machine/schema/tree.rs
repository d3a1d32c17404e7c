//! The table of keys as nested tables, for reading a file.

use std::sync::OnceLock;

use super::key::Key;
use super::keys::KEYS;

/// Kind of a path segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Segment {
    /// A fixed name.
    Fixed(&'static str),
    /// A table per name the user chooses.
    Named,
    /// An array of tables under this name.
    Array(&'static str),
}

/// A table of the format.
#[derive(Debug)]
pub struct Branch {
    /// Segment of this table in the table above.
    pub segment: Segment,
    /// Plain keys of the table.
    pub keys: Vec<&'static Key>,
    /// Subtables.
    pub branches: Vec<Branch>,
}

impl Branch {
    fn new(segment: Segment) -> Self {
        Self { segment, keys: Vec::new(), branches: Vec::new() }
    }

    fn insert(&mut self, key: &'static Key, rest: &'static str) {
        let Some((step, rest)) = rest.split_once('.') else {
            self.keys.push(key);
            return;
        };
        let segment = match step.strip_suffix("[i]") {
            Some(name) => Segment::Array(name),
            None if step == "NAME" => Segment::Named,
            None => Segment::Fixed(step),
        };
        let at = self.branches.iter().position(|branch| branch.segment == segment).unwrap_or_else(|| {
            self.branches.push(Branch::new(segment));
            self.branches.len() - 1
        });
        self.branches[at].insert(key, rest);
    }

    /// Every name allowed in this table; none for a table of named tables.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        let tables = self.branches.iter().filter_map(|branch| match branch.segment {
            Segment::Fixed(name) | Segment::Array(name) => Some(name),
            Segment::Named => None,
        });
        self.keys.iter().map(|key| key.name()).chain(tables)
    }
}

/// The whole format.
pub fn root() -> &'static Branch {
    static ROOT: OnceLock<Branch> = OnceLock::new();
    ROOT.get_or_init(|| {
        let mut root = Branch::new(Segment::Fixed(""));
        for key in KEYS {
            root.insert(key, key.path);
        }
        root
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::schema::{Kind, Need};
    use bladeoff_text::document::units::{examples, parse_quantity};

    #[test]
    fn every_key_has_a_known_unit_and_a_default_that_is_allowed() {
        for key in KEYS {
            // A unit that is not in the table of symbols panics here.
            let _ = parse_quantity("1 x", key.unit());
            assert_ne!(examples(key.unit()), "a number with its unit", "{}", key.path);
            assert!(!key.meaning.is_empty() && !key.meaning.ends_with('.'), "{}", key.path);
            match (key.need, key.kind) {
                (Need::Number(default), _) => assert!(key.range.contains(default), "{}", key.path),
                (Need::Word(word), Kind::Choice(words) | Kind::NumberOr(_, words)) => assert!(words.contains(&word)),
                (Need::Word(_), _) => panic!("{}", key.path),
                (Need::Required | Need::Optional(_), _) => {}
            }
        }
    }

    #[test]
    fn paths_are_unique_and_nest() {
        let mut paths: Vec<&str> = KEYS.iter().map(|key| key.path).collect();
        paths.sort_unstable();
        paths.windows(2).for_each(|pair| assert_ne!(pair[0], pair[1]));
        let rotor = root().branches.iter().find(|branch| branch.segment == Segment::Fixed("rotor")).unwrap();
        assert!(rotor.names().any(|name| name == "shaft") && rotor.names().any(|name| name == "gravity"));
    }
}
