//! Counts and text of ok rows that leave a condition open.

/// Why an ok row leaves a condition open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// A formula in the condition has no value (the square root of a negative number).
    NoValue,
    /// A quantity of the condition was not judged in this run.
    Unjudged,
    /// The condition asks for an event at a time after the end of the run.
    Later,
}

/// Counts of ok rows that leave a condition open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Undecided {
    /// [`Why::NoValue`].
    pub no_value: u64,
    /// [`Why::Unjudged`].
    pub unjudged: u64,
    /// [`Why::Later`].
    pub later: u64,
}

impl Undecided {
    /// Counts a row.
    pub fn see(&mut self, why: Why) {
        match why {
            Why::NoValue => self.no_value += 1,
            Why::Unjudged => self.unjudged += 1,
            Why::Later => self.later += 1,
        }
    }

    /// Adds the rows of another group.
    pub fn add(&mut self, other: &Self) {
        self.no_value += other.no_value;
        self.unjudged += other.unjudged;
        self.later += other.later;
    }

    /// Names of these kinds of rows: "runs that nothing judged"; empty without any.
    #[must_use]
    pub fn words(&self) -> String {
        let kinds = [
            (self.no_value, "runs where the condition has no value"),
            (self.unjudged, "runs in which a quantity of the condition was not judged"),
            (self.later, "runs that ended before the time in the condition"),
        ];
        let kinds = kinds.iter().filter(|(count, _)| *count > 0).map(|(_, words)| *words);
        kinds.collect::<Vec<_>>().join(" and ")
    }

    /// Adds a note for each kind of row, except rows without a value, which have their own.
    pub fn note(&self, notes: &mut Vec<String>) {
        let runs = |count: u64| if count == 1 { "1 run".to_owned() } else { format!("{count} runs") };
        if self.unjudged > 0 {
            let runs = runs(self.unjudged);
            notes.push(format!("in {runs} a quantity of the condition was not judged: undecided"));
        }
        if self.later > 0 {
            let runs = runs(self.later);
            notes.push(format!("{runs} ended without the event before the time in the condition: undecided"));
        }
    }
}
