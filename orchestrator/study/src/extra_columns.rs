//! Columns of the points file that are not parameters: copied to the table or ignored, as the study specifies.

use super::column::{Column, ColumnKind};
use super::csv::{Cell, Csv};
use super::parameter::Parameter;
use super::table::{Keys, wrong_type};
use bladeoff_model::machine::ParamValue;
use bladeoff_text::document::{Collector, Value, cut};
use std::ops::Range;

/// Most columns of a points file that are not parameters.
pub(super) const MOST_OTHERS: usize = 64;
/// Longest text that is copied \[bytes\].
const LONGEST_TEXT: usize = 200;
/// Longest name of a column \[bytes\].
const LONGEST_NAME: usize = 64;

/// A column of the points file that is copied to the table.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraColumn {
    /// Name in the file and in the table.
    pub name: String,
    values: Values,
}

#[derive(Debug, Clone, PartialEq)]
enum Values {
    /// NaN where the cell is empty.
    Numbers(Vec<f64>),
    /// All texts concatenated, and the end of each.
    Texts { all: String, ends: Vec<usize> },
}

impl ExtraColumn {
    /// Meaning of the column in the table.
    #[must_use]
    pub fn column(&self) -> Column {
        Column {
            name: self.name.clone(),
            unit: String::new(),
            meaning: "carried along from the points file".to_owned(),
            kind: if matches!(self.values, Values::Numbers(_)) { ColumnKind::Real } else { ColumnKind::Word },
        }
    }

    /// Cell in a row of the points; `None` if it is empty.
    #[must_use]
    pub fn at(&self, position: u64) -> Option<ParamValue> {
        let index = usize::try_from(position).expect("a position in a list indexes memory");
        match &self.values {
            Values::Numbers(numbers) => Some(numbers[index]).filter(|number| !number.is_nan()).map(ParamValue::Number),
            Values::Texts { all, ends } => {
                let start = index.checked_sub(1).map_or(0, |before| ends[before]);
                let text = &all[start..ends[index]];
                (!text.is_empty()).then(|| ParamValue::Choice(text.to_owned()))
            }
        }
    }
}

/// An extra column while it is read: cells are stored as texts, because any of them can make the column a text column.
pub(super) struct Gathering {
    name: String,
    all: String,
    ends: Vec<usize>,
    numbers: Option<Vec<f64>>,
}

impl Gathering {
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), all: String::new(), ends: Vec::new(), numbers: Some(Vec::new()) }
    }

    /// Adds the next cell; `text`: the cell with a decimal point.
    pub fn push(&mut self, cell: &Cell<'_>, text: &str, problems: &mut Collector<'_>) {
        let is_plain = |c: char| c == '\n' || !c.is_control();
        if cell.text.len() > LONGEST_TEXT || !cell.text.chars().all(is_plain) {
            let problem = problems.add(cell.span.clone(), &self.name, "cannot be carried along");
            problem.value = Some(cut(&cell.text, 40));
            problem.allowed = Some(format!(
                "a number, or text of at most {LONGEST_TEXT} bytes without control characters other than line breaks"
            ));
        }
        if let Some(numbers) = &mut self.numbers {
            match number(text) {
                Some(number) => numbers.push(number),
                None => self.numbers = None,
            }
        }
        self.all.push_str(&cell.text);
        self.ends.push(self.all.len());
    }

    pub fn finish(self) -> ExtraColumn {
        // A column without any number is a text column.
        let numbers = self.numbers.filter(|numbers| numbers.iter().any(|number| !number.is_nan()));
        let values = match numbers {
            Some(numbers) => Values::Numbers(numbers),
            None => Values::Texts { all: self.all, ends: self.ends },
        };
        ExtraColumn { name: self.name, values }
    }
}

/// A cell as a number (NaN: empty, or `nan`, as programs write a missing number); `None`: text. `007` is text: as a number it would become 7.
fn number(text: &str) -> Option<f64> {
    if text.is_empty() || text.eq_ignore_ascii_case("nan") {
        return Some(f64::NAN);
    }
    let digits = text.trim_start_matches(['+', '-']);
    let counted = digits.starts_with('0') && digits[1..].starts_with(|c: char| c.is_ascii_digit());
    let starts = digits.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    text.parse().ok().filter(|number: &f64| number.is_finite() && starts && !counted)
}

/// `carry` and `ignore` of `[points]`, each name with its position.
#[derive(Default)]
pub(super) struct Others {
    pub carry: Vec<(String, Range<usize>)>,
    pub ignore: Vec<(String, Range<usize>)>,
}

impl Others {
    pub fn read(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Self {
        let mut others = Self { carry: names(keys, "carry", problems), ignore: names(keys, "ignore", problems) };
        others.carry.retain(|(name, span)| {
            let usable = can_be_extra_column(name);
            if !usable {
                let problem = problems.add(span.clone(), "points.carry", "cannot be the name of a column of the table");
                problem.value = Some(format!("{:?}", cut(name, 80)));
                problem.allowed =
                    Some(format!("a letter, then letters, digits, `_`, `-` or `.`, at most {LONGEST_NAME}"));
            }
            usable
        });
        if let Some((name, span)) =
            others.ignore.iter().find(|(name, _)| others.carry.iter().any(|(extra, _)| extra == name))
        {
            problems.add(span.clone(), "points.ignore", format!("`{}` is carried along already", cut(name, 80)));
        }
        others
    }

    pub fn count(&self) -> usize {
        self.carry.len() + self.ignore.len()
    }

    pub fn carries(&self, name: &str) -> bool {
        self.carry.iter().any(|(extra, _)| extra == name)
    }

    pub fn ignores(&self, name: &str) -> bool {
        self.ignore.iter().any(|(ignored, _)| without_sign(ignored) == name)
    }

    /// Reports names that the header does not have, at their positions in the study.
    pub fn refuse_absent(&self, text: &str, problems: &mut Collector<'_>) {
        let mut unread = Collector::new("", text);
        let Some(csv) = Csv::new(text, &mut unread) else { return };
        let Some(header) = csv.lines().next() else { return };
        let header: Vec<String> = csv.header(header).into_iter().map(|cell| cell.text.into_owned()).collect();
        for (key, (name, span)) in self
            .carry
            .iter()
            .map(|name| ("points.carry", name))
            .chain(self.ignore.iter().map(|name| ("points.ignore", name)))
        {
            if !header.iter().any(|column| column == without_sign(name)) {
                let nearest = problems.nearest(name, header.iter().map(String::as_str));
                let problem = problems.add(span.clone(), key, "the points file has no such column");
                problem.value = Some(format!("{:?}", cut(name, 80)));
                problem.nearest = nearest;
            }
        }
    }
}

/// The name of a column without the sign at the start of Dakota's header.
fn without_sign(name: &str) -> &str {
    name.strip_prefix('%').unwrap_or(name)
}

fn names(keys: &Keys<'_>, name: &str, problems: &mut Collector<'_>) -> Vec<(String, Range<usize>)> {
    let Some(entry) = keys.get(name) else { return Vec::new() };
    let Value::Array(items) = &entry.node.value else {
        wrong_type(&entry.node, &keys.key(name), "an array of column names", problems);
        return Vec::new();
    };
    if items.len() > MOST_OTHERS {
        let message = format!("names {} columns", items.len());
        problems.add(entry.node.span.clone(), keys.key(name), message).allowed = Some(format!("at most {MOST_OTHERS}"));
        return Vec::new();
    }
    let mut found: Vec<(String, Range<usize>)> = Vec::new();
    for item in items {
        match &item.value {
            Value::Text(text) if found.iter().any(|(known, _)| known == text) => {
                problems.add(item.span.clone(), keys.key(name), format!("`{}` is named twice", cut(text, 80)));
            }
            Value::Text(text) => found.push((text.clone(), item.span.clone())),
            _ => wrong_type(item, &keys.key(name), "the name of a column in quotes", problems),
        }
    }
    found
}

/// Whether a column with this name is allowed in the table.
pub(super) fn can_be_extra_column(name: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    name.len() <= LONGEST_NAME && name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(letter)
}

/// Rejects extra columns with the name of another column of the table.
pub(super) fn refuse_taken(extra: &Others, parameters: &[Parameter], outcome: &[String], problems: &mut Collector<'_>) {
    let parameters = parameters.iter().map(|parameter| parameter.column().name);
    let taken: Vec<String> = parameters.chain(outcome.iter().cloned()).collect();
    for (name, span) in &extra.carry {
        if taken.contains(name) {
            let problem =
                problems.add(span.clone(), "points.carry", format!("the table already has a column `{name}`"));
            problem.allowed = Some("another name in the header of the points file".to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_looks_like_a_counted_name_is_text() {
        for (text, expected) in
            [("1", Some(1.0)), ("-0.5", Some(-0.5)), ("1e-3", Some(1e-3)), (".5", Some(0.5)), ("0", Some(0.0))]
        {
            assert_eq!(number(text), expected, "{text}");
        }
        for text in ["007", "run-001", "inf", "-nan", "1e999", "1 mm", "0x10", "-"] {
            assert_eq!(number(text), None, "{text}");
        }
        for missing in ["", "nan", "NaN"] {
            assert!(number(missing).is_some_and(f64::is_nan));
        }
    }
}
