//! Counts of rows that are not ok, and their text.

use bladeoff_model::outcome::Status;

/// Counts of rows that are not ok.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bad {
    /// Number of counted rows, including ok ones.
    pub of: u64,
    /// Rows that are not ok.
    pub all: u64,
    /// Beyond rows, included in `all`.
    pub beyond: u64,
    /// Rows that are not ok and whose recorded values determine the condition.
    pub decided: u64,
    /// Beyond rows whose recorded values determine the condition.
    pub beyond_decided: u64,
}

impl Bad {
    /// Counts a row.
    pub fn see(&mut self, status: Status, is_decided: bool) {
        let (bad, beyond) = (u64::from(status != Status::Ok), u64::from(status == Status::Beyond));
        let decided = u64::from(is_decided);
        self.add(&Self { of: 1, all: bad, beyond, decided: bad * decided, beyond_decided: beyond * decided });
    }

    /// Adds the rows of another group.
    pub fn add(&mut self, other: &Self) {
        self.of += other.of;
        self.all += other.all;
        self.beyond += other.beyond;
        self.decided += other.decided;
        self.beyond_decided += other.beyond_decided;
    }

    /// Failed, invalid and quarantined rows.
    #[must_use]
    pub fn failing(&self) -> u64 {
        self.all - self.beyond
    }

    /// Counts in words: "2 bad runs and 17 runs beyond the model"; empty without any.
    #[must_use]
    pub fn words(&self) -> String {
        let plural = |count: u64| if count == 1 { "" } else { "s" };
        let failing =
            Some(self.failing()).filter(|count| *count > 0).map(|count| format!("{count} bad run{}", plural(count)));
        let beyond = Some(self.beyond).filter(|count| *count > 0);
        let beyond = beyond.map(|count| format!("{count} run{} beyond the model", plural(count)));
        failing.into_iter().chain(beyond).collect::<Vec<_>>().join(" and ")
    }

    /// Counts of the rows whose recorded values do not determine the condition.
    #[must_use]
    pub fn open(&self) -> Self {
        Self { of: self.of, all: self.all - self.decided, beyond: self.beyond - self.beyond_decided, ..Self::default() }
    }

    /// Counts of the rows whose recorded values determine the condition.
    #[must_use]
    pub fn decided(&self) -> Self {
        Self { of: self.of, all: self.decided, beyond: self.beyond_decided, ..Self::default() }
    }

    /// Label of a figure that includes only runs inside the model: " of runs inside the model (83 %)"; empty without beyond rows.
    #[must_use]
    pub fn inside(&self) -> String {
        if self.beyond == 0 {
            return String::new();
        }
        let share = (self.of - self.all) as f64 / self.of.max(1) as f64;
        format!(" of runs inside the model ({})", crate::share::percent(share))
    }
}
