//! `empirical`: the column of a CSV file, a copy of which is stored with the results, as of a points file.

use super::super::csv::{Cell, Csv, DecimalSign};
use super::super::header::{name_and_unit, refuse_numbers, with_unit};
use super::super::named::{NamedFiles, Which};
use super::super::table::Keys;
use super::quantity::Quantities;
use bladeoff_text::document::{Collector, Entry, Problems, cut};

/// Most values of a distribution: its kinks and moments are computed from all of them.
const MOST_VALUES: usize = 1_000_000;
/// Largest file \[bytes\].
const MOST_BYTES: u64 = 256 << 20;

/// Keys that locate the values of an empirical distribution.
pub(crate) struct Source<'a> {
    pub file: &'a Entry,
    pub column: &'a Entry,
    pub keys: &'a Keys<'a>,
}

/// The files of a study's distributions.
pub(crate) struct Files<'r, 'o> {
    named: &'r NamedFiles<'r>,
    /// Texts of the files read, in the order of the tables.
    pub texts: Vec<String>,
    /// Mistakes in the files.
    others: &'o mut Vec<Problems>,
}

impl<'r, 'o> Files<'r, 'o> {
    /// Creates an empty list.
    pub fn new(named: &'r NamedFiles<'r>, others: &'o mut Vec<Problems>) -> Self {
        Self { named, texts: Vec::new(), others }
    }

    /// The values of a column. `None`: problems were added.
    pub(super) fn column(
        &mut self,
        source: &Source<'_>,
        quantities: &mut Quantities,
        problems: &mut Collector<'_>,
    ) -> Option<Vec<f64>> {
        let named = source.keys.text(source.file, problems)?;
        let column = source.keys.text(source.column, problems)?;
        let key = source.keys.key("file");
        let wanted = (Which::Empirical(self.texts.len()), MOST_BYTES);
        let (path, text) = self.named.read(source.file, (&key, named), wanted, problems)?;
        let mut found = Collector::new(&path, &text);
        let values = values(&text, column, quantities, &mut found);
        if let Err(problems) = found.finish() {
            self.others.push(problems);
            return None;
        }
        self.texts.push(text);
        let values = match values? {
            Ok(values) => values,
            Err(columns) => {
                let nearest = problems.nearest(column, columns.iter().map(String::as_str));
                let span = source.column.node.span.clone();
                let problem = problems.add(span, source.keys.key("column"), "the file has no such column");
                problem.value = Some(format!("{:?}", cut(column, 80)));
                problem.allowed = Some(cut(&columns.join(", "), 300));
                problem.nearest = nearest;
                return None;
            }
        };
        Some(values)
    }
}

/// The values of a column; if it is missing, the names of the columns in the file.
fn values(
    text: &str,
    column: &str,
    quantities: &mut Quantities,
    problems: &mut Collector<'_>,
) -> Option<Result<Vec<f64>, Vec<String>>> {
    let csv = Csv::new(text, problems)?;
    let Some(header) = csv.lines().next() else {
        problems.add(0..0, "", "there is no header line").allowed = Some("a line of column names".to_owned());
        return None;
    };
    let header: Vec<Cell<'_>> = csv.header(header);
    header.iter().for_each(|cell| cell.refuse_unsound(problems));
    let bare = |cell: &Cell<'_>| name_and_unit(&cell.text).is_some_and(|(name, _)| name == column);
    let named = header.iter().position(|cell| cell.text == column).or_else(|| header.iter().position(bare));
    let Some(place) = named else {
        if refuse_numbers(&header, problems) {
            return None;
        }
        return Some(Err(header.iter().map(|cell| cut(&cell.text, 80)).collect()));
    };
    if let Some(again) = header.iter().skip(place + 1).find(|cell| cell.text == column) {
        problems.add(again.span.clone(), cut(column, 80), "names the same column as an earlier one");
        return None;
    }
    if let Some(surplus) = csv.lines().nth(1 + MOST_VALUES) {
        problems.add(surplus, "", "too many values").allowed = Some(format!("at most {MOST_VALUES}"));
        return None;
    }
    let unit = match name_and_unit(&header[place].text).filter(|(_, unit)| !matches!(*unit, "" | "-")) {
        Some((_, unit)) => match quantities.cell(&format!("1 {unit}")) {
            Ok(_) => unit,
            Err((message, nearest)) => {
                problems.add(header[place].span.clone(), cut(column, 80), message).nearest = nearest;
                return None;
            }
        },
        None => "",
    };
    let (mut sign, mut values) = (DecimalSign::default(), Vec::new());
    for line in csv.lines().skip(1) {
        let cells: Vec<Cell<'_>> = csv.cells(line.clone()).collect();
        if cells.len() != header.len() {
            let message = format!("has {} cells, the header has {}", cells.len(), header.len());
            problems.add(line, "", message);
            continue;
        }
        let cell = &cells[place];
        cell.refuse_unsound(problems);
        let Some(shown) = sign.read(csv, cell, false, problems) else { continue };
        let shown = with_unit(shown, unit);
        match quantities.cell(&shown) {
            Ok(number) => values.push(number),
            Err((message, nearest)) => {
                let problem = problems.add(cell.span.clone(), cut(column, 80), message);
                problem.value = Some(format!("{:?}", cut(&shown, 80)));
                problem.nearest = nearest;
            }
        }
    }
    sign.refuse_both(csv, problems);
    if values.is_empty() {
        problems.add(text.len()..text.len(), "", "no values below the header");
    }
    Some(Ok(values))
}
