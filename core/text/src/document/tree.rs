//! A TOML file as a tree with the position of every key and value, in the order of the file.
//!
//! Built on `toml::de::DeTable`, which keeps spans; a serde derive would stop at the first problem.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

use super::problem::{Collector, Problems};

/// Largest file that is read \[bytes\]; a machine or study file has some kB.
pub const MAX_FILE_BYTES: usize = 1 << 20;
/// Most lines with syntax errors for which the rest of the file is still read; a file with more is hardly TOML.
const MOST_SYNTAX_ERRORS: usize = 8;

/// A value and its position.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Byte range of the value; for a table, of its header.
    pub span: Range<usize>,
    /// The value.
    pub value: Value,
}

/// One `key = value` of a table, or a table with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Key.
    pub name: String,
    /// Byte range of the first occurrence of the key.
    pub name_span: Range<usize>,
    /// The value.
    pub node: Node,
}

/// A TOML value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// String.
    Text(String),
    /// Whole number.
    Integer(i128),
    /// Number with a fraction or exponent, or too large for an integer; may be infinite or NaN.
    Float(f64),
    /// true or false.
    Bool(bool),
    /// Date, time or both.
    DateTime,
    /// Array, also of tables.
    Array(Vec<Node>),
    /// Table in the order of the file.
    Table(Vec<Entry>),
}

impl Value {
    /// Name of the type, for messages.
    #[must_use]
    pub fn type_name(&self) -> &'static str {
        match self {
            Value::Text(_) => "a string",
            Value::Integer(_) => "a whole number",
            Value::Float(_) => "a number",
            Value::Bool(_) => "a boolean",
            Value::DateTime => "a date or time",
            Value::Array(_) => "an array",
            Value::Table(_) => "a table",
        }
    }

    /// The entries of a table.
    #[must_use]
    pub fn as_table(&self) -> Option<&[Entry]> {
        match self {
            Value::Table(entries) => Some(entries),
            _ => None,
        }
    }

    /// The value of a number, whole or not.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self {
            // Exact up to 2^53; beyond that the nearest double, as for any decimal literal.
            Value::Integer(whole) => Some(*whole as f64),
            Value::Float(number) => Some(*number),
            _ => None,
        }
    }
}

/// Reads a TOML file. If the file has syntax errors, the tree has the parts that can be read around them. The collector then holds the syntax
/// errors, so that other problems of the file are reported together with them.
///
/// # Errors
/// The file exceeds [`MAX_FILE_BYTES`], or has too many syntax errors to be read: then only the first is reported, as later ones may follow from it.
pub fn parse_toml<'a>(file: &'a str, text: &'a str) -> Result<(Node, Collector<'a>), Problems> {
    if text.len() > MAX_FILE_BYTES {
        let mut problems = Collector::new(file, "");
        problems.add(0..0, "", format!("the file has {} bytes", text.len())).allowed =
            Some(format!("at most {MAX_FILE_BYTES} bytes"));
        return Err(problems.into_problems());
    }
    let mut problems = Collector::new(file, text);
    let first = match DeTable::parse(text) {
        Ok(table) => return Ok((root(&table), problems)),
        Err(error) => error,
    };
    match read_around(text) {
        Some((tree, errors)) => {
            errors.into_iter().for_each(|error| error.report(&mut problems));
            problems.keep_apart_from_syntax();
            Ok((tree, problems))
        }
        None => {
            SyntaxError::of(text, &first).report(&mut problems);
            Err(problems.into_problems())
        }
    }
}

/// A syntax error and the start of its line.
struct SyntaxError {
    line: usize,
    span: Range<usize>,
    message: String,
}

impl SyntaxError {
    fn of(text: &str, error: &Error) -> Self {
        let span = error.span().unwrap_or(0..0);
        let message = error.message().trim_end().replace('\n', ", ");
        Self { line: line_start(text, span.start), span, message }
    }

    fn report(self, problems: &mut Collector<'_>) {
        let at = match problems.excerpt(self.span.clone()).trim() {
            "" => String::new(),
            piece => format!(" at `{piece}`"),
        };
        problems.add(self.span, "", format!("not valid TOML: {}{at}", self.message));
    }
}

/// The tree read around syntax errors, and the first error of each line; `None`: too many errors. An array or a string without its end, which
/// swallows later keys, is replaced by blanks up to the next key, and the rest is read again.
fn read_around(text: &str) -> Option<(Node, Vec<SyntaxError>)> {
    let mut rest = text.to_owned();
    let mut unclosed: Vec<SyntaxError> = Vec::new();
    while unclosed.len() <= MOST_SYNTAX_ERRORS {
        let (table, errors) = DeTable::parse_recoverable(&rest);
        let tree = root(&table);
        let mut errors: Vec<SyntaxError> = errors.iter().map(|error| SyntaxError::of(&rest, error)).collect();
        errors.sort_by_key(|error| (error.line, error.span.start));
        errors.dedup_by_key(|error| error.line);
        let found = errors.iter().find_map(|error| Some((swallower(tree.value.as_table()?, error.line)?, error)));
        let Some((entry, error)) = found else {
            errors.append(&mut unclosed);
            errors.sort_by_key(|error| error.span.start);
            return (errors.len() <= MOST_SYNTAX_ERRORS).then_some((tree, errors));
        };
        let value = entry.node.span.start;
        // the name of a duplicate key may be behind this value
        let start = entry.name_span.start.min(value);
        let first_line = value..value + rest[value..].find('\n').unwrap_or(rest.len() - value);
        let line = 1 + rest[..error.line].matches('\n').count();
        let message = format!(
            "{} with an error or without its end: {} (line {line})",
            entry.node.value.type_name(),
            error.message
        );
        unclosed.push(SyntaxError { line: line_start(&rest, start), span: first_line, message });
        let end = next_key(&rest, value);
        // blanks of the same number of bytes, so that all positions stay valid
        let blank: String = rest[start..end].bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }).collect();
        rest.replace_range(start..end, &blank);
    }
    None
}

/// The entry whose value begins on an earlier line and contains the line at `line`, which has a syntax error: an array or a string without
/// its end has swallowed other keys.
fn swallower(entries: &[Entry], line: usize) -> Option<&Entry> {
    entries.iter().find_map(|entry| match &entry.node.value {
        // the span of a table is that of its header, or of an inline table
        Value::Table(inner) => swallower(inner, line),
        Value::Array(items) => {
            let inner = items.iter().filter_map(|item| item.value.as_table());
            inner.into_iter().find_map(|table| swallower(table, line)).or_else(|| contains(entry, line))
        }
        _ => contains(entry, line),
    })
}

fn contains(entry: &Entry, line: usize) -> Option<&Entry> {
    let span = &entry.node.span;
    (span.start < line && line <= span.end).then_some(entry)
}

/// Start of the first line after the one of `at` that looks like a key or a table header; the end of the text without such a line.
fn next_key(text: &str, at: usize) -> usize {
    let mut start = at;
    while let Some(newline) = text[start..].find('\n') {
        start += newline + 1;
        let line = text[start..].lines().next().unwrap_or_default().trim();
        let is_word =
            |name: &str| !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "_-.\"'[] ".contains(c));
        let is_header = line.starts_with('[')
            && line.trim_start_matches('[').starts_with(|c: char| c.is_alphabetic() || "_\"'".contains(c))
            && !line.ends_with(',');
        if is_header || line.split_once('=').is_some_and(|(name, _)| is_word(name.trim())) {
            return start;
        }
    }
    text.len()
}

fn root(table: &Spanned<DeTable<'_>>) -> Node {
    Node { span: table.span(), value: Value::Table(entries(table.get_ref())) }
}

fn line_start(text: &str, at: usize) -> usize {
    text.get(..at).and_then(|before| before.rfind('\n')).map_or(0, |newline| newline + 1)
}

fn entries(table: &DeTable<'_>) -> Vec<Entry> {
    let mut list: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            name: key.get_ref().to_string(),
            name_span: key.span(),
            node: Node { span: value.span(), value: convert(value.get_ref()) },
        })
        .collect();
    // The map of the toml crate is sorted by name; the tree keeps the order of the file.
    list.sort_by_key(|entry| entry.name_span.start);
    list
}

/// Recursion is bounded: the parser rejects nesting beyond 80 levels.
fn convert(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(digits) => match i128::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(whole) => Value::Integer(whole),
            Err(_) => Value::Float(digits.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(digits) => Value::Float(digits.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Bool(*flag),
        DeValue::Datetime(_) => Value::DateTime,
        DeValue::Array(items) => {
            Value::Array(items.iter().map(|item| Node { span: item.span(), value: convert(item.get_ref()) }).collect())
        }
        DeValue::Table(table) => Value::Table(entries(table)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn tables_keep_the_order_and_places_of_the_file() {
        let text = "z = 1_000\n[b]\ny = 2.5\n[a]\nx = \"s\"\n";
        let (root, _) = parse_toml("f", text).unwrap();
        let names: Vec<&str> = root.value.as_table().unwrap().iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names, ["z", "b", "a"]);
        let b = &root.value.as_table().unwrap()[1];
        let y = &b.node.value.as_table().unwrap()[0];
        assert_eq!(&text[y.node.span.clone()], "2.5");
        assert_eq!(root.value.as_table().unwrap()[0].node.value, Value::Integer(1000));
    }

    #[test]
    fn numbers_beyond_an_integer_and_a_double_do_not_panic() {
        let text = format!("a = {}\nb = 1e999\nc = -inf\nd = nan\ne = 0xff", "9".repeat(400));
        let (root, _) = parse_toml("f", &text).unwrap();
        let values: Vec<f64> =
            root.value.as_table().unwrap().iter().map(|entry| entry.node.value.as_number().unwrap()).collect();
        assert!(values[0].is_infinite() && values[1].is_infinite() && values[2].is_infinite() && values[3].is_nan());
        assert_eq!(values[4], 255.0);
    }

    fn read(text: &str) -> Problems {
        match parse_toml("f", text) {
            Ok((_, problems)) => problems.into_problems(),
            Err(problems) => problems,
        }
    }

    #[test]
    fn every_line_with_a_syntax_error_is_reported_once() {
        let lines = |text: &str| read(text).list.iter().map(|problem| problem.line).collect::<Vec<_>>();
        assert_eq!(lines("a = 1\nb = = 2\nc = \"x\nd = 3\n"), [2, 3]);
        assert_eq!(lines("[run\na = 1\n[b]\nd = 1 m\n"), [1, 4]);
        let message = &read("a = 1\nb = = 2\n").list[0].message;
        assert!(message.starts_with("not valid TOML: "), "{message}");
    }

    #[test]
    fn an_array_or_string_without_an_end_hides_nothing() {
        for text in [
            "a = [[1, 2], [3, 4]\nb = 2\nc = = 3\n",
            "a = '''x\nb = 2\nc = = 3\n",
            "a = [\n  1,\n  2 3,\n]\nb = 2\nc = = 3\n",
        ] {
            let (root, problems) = parse_toml("f", text).unwrap_or_else(|problems| panic!("{text}: {problems}"));
            let names: Vec<&str> = root.value.as_table().unwrap().iter().map(|entry| entry.name.as_str()).collect();
            assert!(names.contains(&"b") && !names.contains(&"a"), "{text}: {names:?}");
            let found = problems.into_problems();
            let lines: Vec<usize> = found.list.iter().map(|problem| problem.line).collect();
            assert_eq!(lines, [1, 1 + text[..text.find("c =").unwrap()].matches('\n').count()], "{text}: {found}");
            assert!(found.list[0].message.contains("without its end"), "{found}");
        }
        assert_eq!(parse_toml("f", &"x\n".repeat(20)).unwrap_err().list.len(), 1);
        assert_eq!(parse_toml("f", &"x = [\n".repeat(20)).unwrap_err().list.len(), 1);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Pieces of TOML in any order: read or rejected, with all positions inside the text.
        #[test]
        fn any_text_is_a_tree_or_refused(pieces in prop::collection::vec(prop::sample::select(PIECES.to_vec()), 0..24)) {
            let text = pieces.concat();
            let problems = read(&text);
            prop_assert!(problems.list.iter().all(|problem| problem.span.end <= text.len()), "{problems}");
        }
    }

    const PIECES: [&str; 26] = [
        "\n",
        "\n",
        "\n",
        "a",
        "b",
        "[",
        "]",
        "[[",
        "]]",
        " = ",
        "=",
        "1",
        "\"x",
        "\"",
        "'''",
        "\"\"\"",
        "{",
        "}",
        ",",
        ".",
        "#",
        "[[a]]\n",
        "[a.b]\n",
        "b = [1\n",
        "a.b = 2\n",
        "ä = 1\n",
    ];

    #[test]
    fn duplicate_keys_deep_nesting_and_large_files_are_refused() {
        assert_eq!(read("a = 1\na = 2").list[0].line, 2);
        for deep in ["[".repeat(100_000), format!("a = {}", "[".repeat(100_000)), "{a=".repeat(10_000)] {
            assert_eq!(read(&format!("k = {deep}")).list.len(), 1);
        }
        assert_eq!(read(&vec!["a"; 50_000].join(".")).list.len(), 1);
        assert!(parse_toml("f", &" ".repeat(MAX_FILE_BYTES + 1)).unwrap_err().list[0].message.contains("bytes"));
    }
}
