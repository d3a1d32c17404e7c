//! A history of one run as it is drawn: instants, channels, what is known of the run. Whoever reads the file makes it.

use std::collections::BTreeMap;

/// What stands in a file beside the numbers: key and value, such as `machine`, `detection`, `contact.gap_m`.
pub type About = BTreeMap<String, String>;

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Full name: `contact.gap_m`.
    pub name: String,
    /// SI unit; "" where the file does not say (CSV) or for a pure number.
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
    /// About the run; empty for CSV.
    pub about: About,
    /// The outcome; empty for CSV and for a recovered file.
    pub outcome: About,
}

impl History {
    /// A channel by its full name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Series> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Channels that fit a pattern: a full name, or one with `*` for any characters, or the beginning before `.` or `_`.
    #[must_use]
    pub fn fitting(&self, pattern: &str) -> Vec<&Series> {
        let fits = |name: &str| {
            matches(name, pattern) || name.strip_prefix(pattern).is_some_and(|rest| rest.starts_with(['.', '_']))
        };
        self.channels.iter().filter(|channel| fits(&channel.name)).collect()
    }

    /// A number about the run.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.about.get(key)?.parse().ok()
    }
}

/// Whether a name fits a pattern in which `*` stands for any characters.
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
