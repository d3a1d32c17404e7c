//! Keys of one element of a rotor file: finite numbers, lists, flags; each mistake is reported at its position.

use bladeoff_text::document::{Collector, Entry, MISSING, Node, Value, cut};
use std::ops::Range;

/// Longest list; a table over the speed has some dozens of entries.
const LONGEST_LIST: usize = 1_000;

/// Allowed sign of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    Any,
    NotNegative,
    Positive,
}

impl Sign {
    fn holds(self, number: f64) -> bool {
        match self {
            Sign::Any => true,
            Sign::NotNegative => number >= 0.0,
            Sign::Positive => number > 0.0,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Sign::Any => "a finite number",
            Sign::NotNegative => "a number >= 0",
            Sign::Positive => "a number > 0",
        }
    }
}

/// The table of one element.
pub struct Fields<'a, 'c, 't> {
    /// Name of the table.
    pub element: &'a str,
    /// Byte range of the name.
    pub span: Range<usize>,
    entries: &'a [Entry],
    problems: &'c mut Collector<'t>,
}

impl<'a, 'c, 't> Fields<'a, 'c, 't> {
    pub fn new(entry: &'a Entry, problems: &'c mut Collector<'t>) -> Self {
        Self {
            element: &entry.name,
            span: entry.name_span.clone(),
            entries: entry.node.value.as_table().unwrap_or_default(),
            problems,
        }
    }

    fn find(&self, name: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    fn path(&self, name: &str) -> String {
        format!("{}.{name}", cut(self.element, 80))
    }

    /// Reports an invalid value.
    pub fn fail(&mut self, name: &str, message: impl Into<String>, allowed: &str) {
        let (span, path) =
            (self.find(name).map_or(self.span.clone(), |entry| entry.node.span.clone()), self.path(name));
        let shown = self.find(name).map(|entry| self.problems.excerpt(entry.node.span.clone()));
        let problem = self.problems.add(span, path, message);
        problem.value = shown;
        problem.allowed = Some(allowed.to_owned());
    }

    fn missing(&mut self, name: &str, allowed: &str) {
        let path = self.path(name);
        self.problems.add(self.span.clone(), path, MISSING).allowed = Some(allowed.to_owned());
    }

    fn checked(&mut self, name: &str, node: &Node, sign: Sign) -> Option<f64> {
        match node.value.as_number() {
            Some(number) if number.is_finite() && sign.holds(number) => Some(number),
            _ => {
                let shown = self.problems.excerpt(node.span.clone());
                let message = match &node.value {
                    Value::Integer(_) | Value::Float(_) => "not a usable number".to_owned(),
                    other => format!("a number is expected, not {}", other.type_name()),
                };
                let path = self.path(name);
                let problem = self.problems.add(node.span.clone(), path, message);
                problem.value = Some(shown);
                problem.allowed = Some(sign.words().to_owned());
                None
            }
        }
    }

    /// A required number.
    pub fn number(&mut self, name: &str, sign: Sign) -> Option<f64> {
        match self.find(name) {
            Some(entry) => self.checked(name, &entry.node, sign),
            None => {
                self.missing(name, sign.words());
                None
            }
        }
    }

    /// A number with a default; `None`: invalid, which has been reported.
    pub fn number_or(&mut self, name: &str, sign: Sign, default: f64) -> Option<f64> {
        if self.has(name) { self.number(name, sign) } else { Some(default) }
    }

    /// One number or a list of numbers, empty if the key is missing; `None`: invalid, which has been reported.
    pub fn list(&mut self, name: &str, sign: Sign) -> Option<Vec<f64>> {
        let Some(entry) = self.find(name) else { return Some(Vec::new()) };
        match &entry.node.value {
            Value::Array(items) if items.len() > LONGEST_LIST => {
                let message = format!("a list of {} entries", items.len());
                self.fail(name, message, &format!("at most {LONGEST_LIST}"));
                None
            }
            Value::Array(items) if items.iter().any(|item| matches!(item.value, Value::Array(_))) => {
                let message = "coefficients over speed and frequency";
                self.fail(
                    name,
                    message,
                    "a list over the speed: take the synchronous coefficients (frequency = speed)",
                );
                None
            }
            // every entry is checked, so that all mistakes are reported
            Value::Array(items) => {
                let checked: Vec<Option<f64>> = items.iter().map(|item| self.checked(name, item, sign)).collect();
                checked.into_iter().collect()
            }
            _ => self.checked(name, &entry.node, sign).map(|number| vec![number]),
        }
    }

    /// A required node number.
    pub fn node(&mut self, name: &str) -> Option<usize> {
        let allowed = "the number of a node: a whole number from 0 to 9999";
        let Some(entry) = self.find(name) else {
            self.missing(name, allowed);
            return None;
        };
        // a whole number, even if written as 3.0
        let whole = entry.node.value.as_number().filter(|number| number.fract() == 0.0 && (0.0..1e4).contains(number));
        if whole.is_none() {
            self.fail(name, "not a node", allowed);
        }
        whole.map(|number| number as usize)
    }

    /// A flag with a default; `None`: invalid, which has been reported.
    pub fn flag(&mut self, name: &str, default: bool) -> Option<bool> {
        match self.find(name).map(|entry| &entry.node.value) {
            None => Some(default),
            Some(Value::Bool(flag)) => Some(*flag),
            Some(_) => {
                self.fail(name, "true or false is expected", "true, false");
                None
            }
        }
    }

    /// A text; `None`: missing or not a text.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        match &self.find(name)?.node.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The keys of a subtable; an error is reported if it is missing or not a table.
    pub fn table(&mut self, name: &str) -> Option<Fields<'a, '_, 't>> {
        match self.find(name) {
            Some(entry) if entry.node.value.as_table().is_some() => Some(Fields {
                element: self.element,
                span: entry.name_span.clone(),
                entries: entry.node.value.as_table().unwrap_or_default(),
                problems: self.problems,
            }),
            Some(_) => {
                self.fail(name, "a table is expected", "a table with rho, E, G_s");
                None
            }
            None => {
                self.missing(name, "a table with rho, E, G_s");
                None
            }
        }
    }
}
