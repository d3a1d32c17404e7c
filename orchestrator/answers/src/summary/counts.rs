//! Counts of rows by status and cause.

use std::collections::BTreeMap;

/// Counts of rows by status and cause.
#[derive(Debug, Clone, Default)]
pub(super) struct Counts(BTreeMap<(String, String), u64>);

impl Counts {
    /// Counts a row.
    pub fn add(&mut self, status: String, cause: Option<String>) {
        *self.0.entry((status, cause.unwrap_or_else(|| "no cause".to_owned()))).or_default() += 1;
    }

    /// Text such as "2 (2 slip_reversal)" for the rows with these statuses.
    pub fn by_cause(&self, statuses: &[&str]) -> String {
        let mut causes: BTreeMap<&str, u64> = BTreeMap::new();
        for ((status, cause), count) in &self.0 {
            if statuses.contains(&status.as_str()) {
                *causes.entry(cause).or_default() += count;
            }
        }
        let total: u64 = causes.values().sum();
        if total == 0 {
            return "0".to_owned();
        }
        let named: Vec<String> = causes.iter().map(|(cause, count)| format!("{count} {cause}")).collect();
        format!("{total} ({})", named.join(", "))
    }

    /// Number of ok rows.
    pub fn ok(&self) -> u64 {
        self.0.iter().filter(|((status, _), _)| status == "ok").map(|(_, count)| count).sum()
    }
}
