//! Blocks of rows that are used as a whole: a run without a number excludes its block.

use bladeoff_text::document::units::format_digits;

/// The blocks in which every row has a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blocks {
    /// Indices of the blocks.
    pub whole: Vec<usize>,
    /// Number of blocks of which all rows exist.
    pub of: usize,
    /// Number of rows without a number in these blocks.
    pub lost: usize,
}

/// A share in per cent, as text.
#[must_use]
pub(super) fn percent(share: f64) -> String {
    format!("{} %", format_digits(100.0 * share, "", 2))
}

/// A count with the name of a block: "1 trajectory", "12 base points".
#[must_use]
pub(super) fn counted(count: usize, many: &str) -> String {
    let one = match (count, many) {
        (1, "trajectories") => "trajectory",
        (1, many) => many.strip_suffix('s').unwrap_or(many),
        _ => many,
    };
    format!("{count} {one}")
}

/// The number, if it is finite.
#[must_use]
pub(super) fn number(value: Option<f64>) -> Option<f64> {
    value.filter(|value| value.is_finite())
}

impl Blocks {
    /// Blocks of `rows` rows each; an incomplete block at the end is ignored.
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

    /// Number of excluded blocks.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.of - self.whole.len()
    }

    /// Adds a note about excluded blocks; `name`: name of the blocks.
    pub(super) fn told(&self, name: &str, notes: &mut Vec<String>) {
        if self.left_out() > 0 {
            let (out, of, lost) = (self.left_out(), self.of, self.lost);
            let share = percent(out as f64 / of as f64);
            let (lost, of) = (counted(lost, "runs"), counted(of, name));
            notes.push(format!("{lost} without a number: {out} of {of} left out ({share})"));
        }
    }
}
