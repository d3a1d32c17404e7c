//! A history of one run, as drawn: instants, channels, and metadata of the run. The reader of the file builds it.

use std::collections::BTreeMap;

/// Metadata of a history file: key and value, such as `machine`, `detection`, `contact.gap_m`.
pub type About = BTreeMap<String, String>;

/// One channel of a history.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Full name: `contact.gap_m`.
    pub name: String,
    /// SI unit; "" for a pure number, or if the file has no units (CSV).
    pub unit: String,
    /// One value per instant.
    pub values: Vec<f64>,
}

/// A history in memory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// Instants \[s\].
    pub time: Vec<f64>,
    /// Channels in the order of the file.
    pub channels: Vec<Series>,
    /// Metadata of the run; empty for CSV.
    pub about: About,
    /// Outcome of the run; empty for CSV and for a recovered file.
    pub outcome: About,
}

impl History {
    /// Channel with this full name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Series> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Channels that match a pattern: a full name, a name with `*` for any characters, or the part of a name before `.` or `_`.
    #[must_use]
    pub fn fitting(&self, pattern: &str) -> Vec<&Series> {
        let fits = |name: &str| {
            matches(name, pattern) || name.strip_prefix(pattern).is_some_and(|rest| rest.starts_with(['.', '_']))
        };
        self.channels.iter().filter(|channel| fits(&channel.name)).collect()
    }

    /// A numeric entry of the metadata.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.about.get(key)?.parse().ok()
    }
}

/// Whether a name matches a pattern in which `*` is any sequence of characters.
#[must_use]
pub fn matches(name: &str, pattern: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn a_star_stands_for_any_characters() {
        assert!(matches("contact.gap_m", "contact.gap_m"));
        assert!(!matches("contact.gap_m", "contact.gap"));
        assert!(matches("contact.gap_m", "contact.*"));
        assert!(matches("bearing.front.load_N", "*load*"));
        assert!(matches("bearing.front.load_N", "bearing.*.load_N"));
        assert!(!matches("bearing.front.load_N", "bearing.*.load"));
        assert!(!matches("ab", "ab*b"));
    }
}
