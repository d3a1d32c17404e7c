//! Keys of one table of a study file: typed access; unknown keys are rejected with the nearest known one.

use bladeoff_text::document::{Collector, Entry, MISSING, Node, Value, cut};
use std::ops::Range;

/// A table and its full name.
pub(super) struct Keys<'a> {
    prefix: String,
    span: Range<usize>,
    entries: &'a [Entry],
}

impl<'a> Keys<'a> {
    /// The table of an entry; a problem and `None` if the entry is not a table.
    pub fn of(entry: &'a Entry, prefix: &str, problems: &mut Collector<'_>) -> Option<Self> {
        Self::at(&entry.node, prefix, problems)
    }

    /// The table at a node; a problem and `None` if the node is not a table.
    pub fn at(node: &'a Node, prefix: &str, problems: &mut Collector<'_>) -> Option<Self> {
        match node.value.as_table() {
            Some(entries) => Some(Self { prefix: prefix.to_owned(), span: node.span.clone(), entries }),
            None => {
                wrong_type(node, prefix, "a table", problems);
                None
            }
        }
    }

    /// Full name of a key of the table.
    pub fn key(&self, name: &str) -> String {
        if self.prefix.is_empty() { name.to_owned() } else { format!("{}.{name}", self.prefix) }
    }

    /// Byte range of the table's beginning.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// All entries.
    pub fn entries(&self) -> &'a [Entry] {
        self.entries
    }

    /// The entry with this name.
    pub fn get(&self, name: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    /// The entry with this name; a problem if it is missing.
    pub fn require(&self, name: &str, what: &str, problems: &mut Collector<'_>) -> Option<&'a Entry> {
        let found = self.get(name);
        if found.is_none() {
            problems.add(self.span.clone(), self.key(name), MISSING).allowed = Some(what.to_owned());
        }
        found
    }

    /// The text of an entry; a problem if the value is not text.
    pub fn text(&self, entry: &'a Entry, problems: &mut Collector<'_>) -> Option<&'a str> {
        match &entry.node.value {
            Value::Text(text) => Some(text),
            _ => {
                wrong_type(&entry.node, &self.key(&entry.name), "a string", problems);
                None
            }
        }
    }

    /// The whole number of an entry within bounds; a problem if the value is not such a number.
    pub fn whole(&self, entry: &Entry, least: u64, most: u64, problems: &mut Collector<'_>) -> Option<u64> {
        if let Value::Integer(number) = entry.node.value
            && let Ok(number) = u64::try_from(number)
            && (least..=most).contains(&number)
        {
            return Some(number);
        }
        let value = problems.excerpt(entry.node.span.clone());
        let problem = problems.add(entry.node.span.clone(), self.key(&entry.name), "not a whole number in range");
        problem.value = Some(value);
        problem.allowed = Some(format!("a whole number, {least} to {most}"));
        None
    }

    /// Rejects every key that is not in `known`.
    pub fn refuse_unknown(&self, known: &[&str], problems: &mut Collector<'_>) {
        for entry in self.entries {
            if !known.contains(&entry.name.as_str()) {
                let nearest = problems.nearest(&entry.name, known.iter().copied());
                let key = self.key(&cut(&entry.name, 80));
                let problem = problems.add(entry.name_span.clone(), key, "unknown key");
                problem.allowed = Some(known.join(", "));
                problem.nearest = nearest;
            }
        }
    }
}

/// Reports a value of the wrong type.
pub(super) fn wrong_type(node: &Node, key: &str, wanted: &str, problems: &mut Collector<'_>) {
    let value = problems.excerpt(node.span.clone());
    let problem = problems.add(node.span.clone(), key, format!("is {}, not {wanted}", node.value.type_name()));
    problem.value = Some(value);
    problem.allowed = Some(wanted.to_owned());
}

/// A scalar as text, from which a parameter is parsed; `None` for arrays, tables and dates.
pub(super) fn scalar_text(value: &Value) -> Option<String> {
    match value {
        Value::Text(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        // The shortest text that is parsed to the same number.
        Value::Float(number) => Some(format!("{number:?}")),
        Value::Bool(flag) => Some(flag.to_string()),
        Value::DateTime | Value::Array(_) | Value::Table(_) => None,
    }
}
