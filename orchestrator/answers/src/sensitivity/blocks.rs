//! Blocks of rows that count as a whole: a run without a number takes its block out.

use bladeoff_text::document::units::format_digits;

/// The blocks whose every row has a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blocks {
    /// Their numbers.
    pub whole: Vec<usize>,
    /// Blocks that all rows are there of.
    pub of: usize,
    /// Rows of these blocks that have no number.
    pub lost: usize,
}

/// A share as a person reads it.
#[must_use]
pub(super) fn percent(share: f64) -> String {
    format!("{} %", format_digits(100.0 * share, "", 2))
}

/// So many of what blocks are called: "1 trajectory", "12 base points".
#[must_use]
pub(super) fn counted(count: usize, many: &str) -> String {
    let one = match (count, many) {
        (1, "trajectories") => "trajectory",
        (1, many) => many.strip_suffix('s').unwrap_or(many),
        _ => many,
    };
    format!("{count} {one}")
}

/// A number that can be calculated with.
#[must_use]
pub(super) fn number(value: Option<f64>) -> Option<f64> {
    value.filter(|value| value.is_finite())
}

impl Blocks {
    /// Of so many rows each; a block of which rows are missing at the end is none yet.
    #[must_use]
    pub fn new(values: &[Option<f64>], rows: usize) -> Self {
        let all = values.chunks_exact(rows);
        let of = all.len();
        let (mut whole, mut lost) = (Vec::new(), 0);
        for (block, values) in all.enumerate() {
            let without = values.iter().filter(|value| number(**value).is_none()).count();
            lost += without;
            if without == 0 {
                whole.push(block);
            }
        }
        Self { whole, of, lost }
    }

    /// Blocks left out.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.of - self.whole.len()
    }

    /// What is said of those left out; `name`: what a block is.
    pub(super) fn told(&self, name: &str, notes: &mut Vec<String>) {
        if self.left_out() > 0 {
            let (out, of, lost) = (self.left_out(), self.of, self.lost);
            let share = percent(out as f64 / of as f64);
            let (lost, of) = (counted(lost, "runs"), counted(of, name));
            notes.push(format!("{lost} without a number: {out} of {of} left out ({share})"));
        }
    }
}
