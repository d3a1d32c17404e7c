//! The summary of the table of a study of formulas: what became of the samples, and how far what each formula gave reaches.

use super::counts::Counts;
use super::summary::median;
use super::text::{Align, TextTable};
use crate::tables::Table;
use bladeoff_model::document::units::format_digits;

/// A summary under construction: a table is added part by part, so that a large one need not be in memory.
#[derive(Debug, Clone)]
pub struct FunctionSummary {
    rows: u64,
    counts: Counts,
    /// Of each formula the values of the rows that are ok.
    outputs: Vec<(String, Vec<f64>)>,
}

impl FunctionSummary {
    /// Of a table with these columns for formulas.
    #[must_use]
    pub fn new(outputs: impl IntoIterator<Item = String>) -> Self {
        let outputs = outputs.into_iter().map(|name| (name, Vec::new())).collect();
        Self { rows: 0, counts: Counts::default(), outputs }
    }

    /// Columns of a table that it looks at.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let verdict = ["status", "cause"].map(str::to_owned);
        verdict.into_iter().chain(self.outputs.iter().map(|(name, _)| name.clone())).collect()
    }

    /// Adds the rows of a table or of a part of one.
    pub fn add(&mut self, table: &Table) {
        let (status, cause) = (table.words("status").unwrap_or(&[]), table.words("cause").unwrap_or(&[]));
        let word = |words: &[Option<String>], row: usize| words.get(row).and_then(Clone::clone);
        self.rows += table.rows() as u64;
        for row in 0..table.rows() {
            self.counts.add(word(status, row).unwrap_or_default(), word(cause, row));
        }
        let is_ok = |row: usize| status.get(row).is_some_and(|word| word.as_deref() == Some("ok"));
        for (name, values) in &mut self.outputs {
            let column = table.numbers(name).unwrap_or(&[]).iter().enumerate();
            values.extend(column.filter(|(row, _)| is_ok(*row)).filter_map(|(_, value)| *value));
        }
    }

    /// The summary as text, its tables within a width where there is one.
    #[must_use]
    pub fn text(mut self, width: Option<usize>) -> String {
        let header = [("samples", Align::Right), ("ok", Align::Right), ("failed", Align::Left)];
        let mut verdict = TextTable::new(&header);
        let failed = self.counts.by_cause(&["failed", "quarantined"]);
        verdict.row(vec![self.rows.to_string(), self.counts.ok().to_string(), failed.clone()]);
        let header = ["least", "median", "largest"].map(|title| (title, Align::Right));
        let mut figures = TextTable::new(&[&[("formula", Align::Left)], &header[..]].concat());
        for (name, values) in &mut self.outputs {
            values.sort_by(f64::total_cmp);
            let ends = values.first().copied().zip(values.last().copied());
            let cells =
                ends.map(|(least, most)| [least, median(values), most].map(|value| format_digits(value, "", 4)));
            let cells = cells.unwrap_or_else(|| ["-", "-", "-"].map(str::to_owned));
            figures.row([vec![name.clone()], cells.to_vec()].concat());
        }
        let left_out = if failed == "0" { "No row is left out.".to_owned() } else { format!("Left out: {failed}.") };
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
        summary.add(&table);
        let text = summary.text(None);
        let row = |start: &str| {
            let line = text.lines().find(|line| line.split_whitespace().next() == Some(start)).expect("the line");
            line.split_whitespace().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(row("4"), "4 3 1 (1 non_finite)", "{text}");
        assert_eq!(row("g"), "g -1 0.5 2", "the failed row's 9e9 is not counted: {text}");
        assert_eq!(row("h"), "h - - -", "{text}");
        assert!(text.contains("Left out: 1 (1 non_finite)."), "{text}");
    }
}
