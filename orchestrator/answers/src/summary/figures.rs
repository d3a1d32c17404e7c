//! Smallest, median and largest value of a stream of values.

use crate::estimate::order::{KEPT, Order};
use crate::tables::{Table, TableError};
use std::path::PathBuf;

/// Accumulator over several passes.
#[derive(Debug, Clone)]
pub(super) struct Values(Order);

/// Figures of a summary.
#[derive(Debug, Clone, Copy)]
pub(super) struct Figures {
    pub least: f64,
    pub median: f64,
    pub most: f64,
}

impl Default for Values {
    fn default() -> Self {
        Self(Order::keeping(KEPT))
    }
}

impl Values {
    pub fn see(&mut self, value: f64) {
        self.0.see(value);
    }

    pub fn count(&self) -> u64 {
        self.0.count()
    }

    /// Ranks of the median: one rank, or two different ones.
    fn middle(&self) -> [u64; 2] {
        let n = self.0.count();
        [n.div_ceil(2), n / 2 + 1]
    }

    /// Ends a pass. Returns whether another pass is needed.
    pub fn go_on(&mut self) -> bool {
        let [below, above] = self.middle();
        let last = self.0.count();
        self.0.ask([1, below, above, last])
    }

    /// The figures; `None` without values.
    pub fn figures(&self) -> Option<Figures> {
        let [below, above] = self.middle().map(|rank| self.0.at(rank));
        let (below, above) = (below?, above?);
        let median = if self.0.count() % 2 == 1 { below } else { (below + above) / 2.0 };
        Some(Figures { least: self.0.at(1)?, median, most: self.0.at(self.0.count())? })
    }
}

/// Passes the rows of these files to a summary, as often as `go_on` returns true. `add` gets whether it is the first pass.
pub(super) fn all_pass<S>(
    files: &[PathBuf],
    columns: &[&str],
    summary: &mut S,
    add: fn(&mut S, &Table, bool),
    go_on: fn(&mut S) -> bool,
) -> Result<(), TableError> {
    let mut is_first = true;
    loop {
        Table::for_each_piece(files, columns, |piece| {
            add(summary, piece, is_first);
            Ok(())
        })?;
        if !go_on(summary) {
            return Ok(());
        }
        is_first = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_sorted_values_also_of_more_than_are_kept() {
        for count in [0, 1, 2, 7, KEPT as u64 + 1, 3 * KEPT as u64] {
            let mut values = Values::default();
            let mut passes = 0;
            loop {
                (0..count).for_each(|at| values.see(((at * 7919) % count) as f64));
                passes += 1;
                if !values.go_on() {
                    break;
                }
            }
            let found = values.figures().map(|found| [found.least, found.median, found.most]);
            let last = count.saturating_sub(1) as f64;
            assert_eq!(found, (count > 0).then_some([0.0, last / 2.0, last]), "{count}");
            assert_eq!(passes > 1, count > KEPT as u64, "{count}: {passes}");
        }
    }
}
