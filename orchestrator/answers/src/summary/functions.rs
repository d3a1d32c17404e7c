//! Summary of the table of a formula study: statuses of the samples, and range of each formula.

use super::counts::Counts;
use super::figures::{Values, all_pass};
use super::text::{Align, TextTable};
use crate::tables::{Table, TableError};
use bladeoff_text::document::units::format_digits;
use std::path::PathBuf;

/// Accumulator of a summary. Rows are read in several passes, so that large tables need not be in memory.
#[derive(Debug, Clone)]
pub struct FunctionSummary {
    rows: u64,
    counts: Counts,
    /// Values of each formula in the rows that are ok.
    outputs: Vec<(String, Values)>,
}

impl FunctionSummary {
    /// Summary of the rows in these files; `outputs`: columns of the formulas.
    ///
    /// # Errors
    /// A table that cannot be read.
    pub fn of(files: &[PathBuf], outputs: impl IntoIterator<Item = String>) -> Result<Self, TableError> {
        let mut summary = Self::new(outputs);
        let columns = summary.columns();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        all_pass(files, &columns, &mut summary, Self::add, Self::go_on)?;
        Ok(summary)
    }

    fn new(outputs: impl IntoIterator<Item = String>) -> Self {
        let outputs = outputs.into_iter().map(|name| (name, Values::default())).collect();
        Self { rows: 0, counts: Counts::default(), outputs }
    }

    fn columns(&self) -> Vec<String> {
        let verdict = ["status", "cause"].map(str::to_owned);
        verdict.into_iter().chain(self.outputs.iter().map(|(name, _)| name.clone())).collect()
    }

    /// Adds the rows of a piece; later passes add only the values.
    fn add(&mut self, table: &Table, is_first: bool) {
        let (status, cause) = (table.words("status").unwrap_or(&[]), table.words("cause").unwrap_or(&[]));
        let word = |words: &[Option<String>], row: usize| words.get(row).and_then(Clone::clone);
        if is_first {
            self.rows += table.rows() as u64;
            for row in 0..table.rows() {
                self.counts.add(word(status, row).unwrap_or_default(), word(cause, row));
            }
        }
        let is_ok = |row: usize| status.get(row).is_some_and(|word| word.as_deref() == Some("ok"));
        for (name, values) in &mut self.outputs {
            let column = table.numbers(name).unwrap_or(&[]).iter().enumerate();
            column.filter(|(row, _)| is_ok(*row)).filter_map(|(_, value)| *value).for_each(|value| values.see(value));
        }
    }

    /// Ends a pass. Returns whether another pass is needed.
    fn go_on(&mut self) -> bool {
        self.outputs.iter_mut().fold(false, |open, (_, values)| values.go_on() | open)
    }

    /// The summary as text; `width` limits the width of its tables.
    #[must_use]
    pub fn text(&self, width: Option<usize>) -> String {
        let header = [("samples", Align::Right), ("ok", Align::Right), ("failed", Align::Left)];
        let mut verdict = TextTable::new(&header);
        let failed = self.counts.by_cause(&["failed", "quarantined"]);
        verdict.row(vec![self.rows.to_string(), self.counts.ok().to_string(), failed.clone()]);
        let header = ["least", "median", "largest"].map(|title| (title, Align::Right));
        let mut figures = TextTable::new(&[&[("formula", Align::Left)], &header[..]].concat());
        for (name, values) in &self.outputs {
            let cells = values
                .figures()
                .map(|figures| [figures.least, figures.median, figures.most].map(|value| format_digits(value, "", 4)));
            let cells = cells.unwrap_or_else(|| ["-", "-", "-"].map(str::to_owned));
            figures.row([vec![name.clone()], cells.to_vec()].concat());
        }
        let left_out =
            if failed == "0" { "All runs are included.".to_owned() } else { format!("Not included: {failed}.") };
        format!(
            "{}\n{}Rows: those with status ok. {left_out}\n",
            verdict.fitting("", width),
            figures.fitting("", width)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::Cells;

    #[test]
    fn figures_are_of_rows_that_are_ok_and_the_others_are_counted() {
        let words = |list: [Option<&str>; 4]| Cells::Words(list.map(|word| word.map(str::to_owned)).to_vec());
        let table = Table::from_columns(
            4,
            vec![
                ("status".into(), words([Some("ok"), Some("ok"), Some("failed"), Some("ok")])),
                ("cause".into(), words([None, None, Some("non_finite"), None])),
                ("g".into(), Cells::Numbers(vec![Some(2.0), Some(-1.0), Some(9e9), Some(0.5)])),
                ("h".into(), Cells::Numbers(vec![None; 4])),
            ],
        );
        let mut summary = FunctionSummary::new(["g".to_owned(), "h".to_owned()]);
        assert_eq!(summary.columns(), ["status", "cause", "g", "h"]);
        summary.add(&table, true);
        assert!(!summary.go_on(), "few are kept");
        let text = summary.text(None);
        let row = |start: &str| {
            let line = text.lines().find(|line| line.split_whitespace().next() == Some(start)).expect("the line");
            line.split_whitespace().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(row("4"), "4 3 1 (1 non_finite)", "{text}");
        assert_eq!(row("g"), "g -1 0.5 2", "the failed row's 9e9 is not counted: {text}");
        assert_eq!(row("h"), "h - - -", "{text}");
        assert!(text.contains("Not included: 1 (1 non_finite)."), "{text}");
    }
}
