//! A JSON file as the tree of a TOML file, with the same positions.
//!
//! Python's notation is accepted: `NaN`, `Infinity` and `-Infinity` are numbers. A member that is `null` counts as absent, because TOML has no
//! such value.

use std::ops::Range;

use super::problem::{Collector, Problems, cut};
use super::tree::{Entry, MAX_FILE_BYTES, Node, Value};

/// Deepest nesting of arrays and objects.
const DEEPEST: usize = 64;

/// Reads a JSON file whose outermost value is an object. A repeated name in an object is reported.
///
/// # Errors
/// The file exceeds [`MAX_FILE_BYTES`], or has a syntax error (the first one is reported).
pub fn parse_json<'a>(file: &'a str, text: &'a str) -> Result<(Node, Collector<'a>), Problems> {
    let mut problems = Collector::new(file, text);
    if text.len() > MAX_FILE_BYTES {
        let mut problems = Collector::new(file, "");
        problems.add(0..0, "", format!("the file has {} bytes", text.len())).allowed =
            Some(format!("at most {MAX_FILE_BYTES} bytes"));
        return Err(problems.into_problems());
    }
    let mut json = Json { text, at: text.len() - text.trim_start_matches('\u{feff}').len(), twice: Vec::new() };
    let root = json.object_file();
    for (span, name) in json.twice {
        problems.add(span, cut(&name, 80), "given twice");
    }
    match root {
        Ok(root) => Ok((root, problems)),
        Err((span, message)) => {
            problems.add(span, "", format!("not valid JSON: {message}"));
            Err(problems.into_problems())
        }
    }
}

type Syntax = (Range<usize>, String);

struct Json<'a> {
    text: &'a str,
    at: usize,
    twice: Vec<(Range<usize>, String)>,
}

impl<'a> Json<'a> {
    fn object_file(&mut self) -> Result<Node, Syntax> {
        self.blanks();
        if self.peek() != Some('{') {
            return Err(self.unexpected("an object `{`"));
        }
        let root = self.value(0)?.ok_or_else(|| self.unexpected("an object `{`"))?;
        self.blanks();
        if self.at < self.text.len() { Err(self.unexpected("the end of the file")) } else { Ok(root) }
    }

    /// Reads a value; `None`: null.
    fn value(&mut self, depth: usize) -> Result<Option<Node>, Syntax> {
        self.blanks();
        let start = self.at;
        let value = match self.peek() {
            Some('{' | '[') if depth >= DEEPEST => {
                return Err((start..start + 1, format!("nested deeper than {DEEPEST} levels")));
            }
            Some('{') => Value::Table(self.members(depth)?),
            Some('[') => Value::Array(self.items(depth)?),
            Some('"') => Value::Text(self.string()?),
            _ => match self.word() {
                "null" => return Ok(None),
                "true" => Value::Bool(true),
                "false" => Value::Bool(false),
                "NaN" => Value::Float(f64::NAN),
                "Infinity" => Value::Float(f64::INFINITY),
                "-Infinity" => Value::Float(f64::NEG_INFINITY),
                word => match number(word) {
                    Some(number) => number,
                    None => {
                        self.at = start;
                        return Err(self.unexpected("a value"));
                    }
                },
            },
        };
        Ok(Some(Node { span: start..self.at, value }))
    }

    fn members(&mut self, depth: usize) -> Result<Vec<Entry>, Syntax> {
        let mut entries: Vec<Entry> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        self.at += 1;
        self.blanks();
        if self.take('}') {
            return Ok(entries);
        }
        loop {
            self.blanks();
            let start = self.at;
            if self.peek() != Some('"') {
                return Err(self.unexpected("a name in quotes"));
            }
            let name = self.string()?;
            let name_span = start..self.at;
            self.blanks();
            if !self.take(':') {
                return Err(self.unexpected("`:`"));
            }
            let node = self.value(depth + 1)?;
            if !seen.insert(name.clone()) {
                self.twice.push((name_span, name));
            } else if let Some(node) = node {
                entries.push(Entry { name, name_span, node });
            }
            self.blanks();
            if self.take('}') {
                return Ok(entries);
            }
            if !self.take(',') {
                return Err(self.unexpected("`,` or `}`"));
            }
        }
    }

    fn items(&mut self, depth: usize) -> Result<Vec<Node>, Syntax> {
        let mut items = Vec::new();
        self.at += 1;
        self.blanks();
        if self.take(']') {
            return Ok(items);
        }
        loop {
            let start = self.at;
            // null keeps its place in a list, but not as a number
            let null = |end| Node { span: start..end, value: Value::Text("null".to_owned()) };
            let node = self.value(depth + 1)?;
            items.push(node.unwrap_or_else(|| null(self.at)));
            self.blanks();
            if self.take(']') {
                return Ok(items);
            }
            if !self.take(',') {
                return Err(self.unexpected("`,` or `]`"));
            }
        }
    }

    fn string(&mut self) -> Result<String, Syntax> {
        let start = self.at;
        let unended = |at| (start..at, "a string without its end".to_owned());
        self.at += 1;
        let mut said = String::new();
        loop {
            let Some(next) = self.peek() else { return Err(unended(start + 1)) };
            self.at += next.len_utf8();
            match next {
                '"' => return Ok(said),
                '\n' => return Err(unended(self.at - 1)),
                '\\' => said.push(self.escaped()?),
                other => said.push(other),
            }
        }
    }

    fn escaped(&mut self) -> Result<char, Syntax> {
        let wrong = |at: usize| (at - 1..at, "an unknown escape in a string".to_owned());
        let at = self.at;
        let Some(next) = self.peek() else { return Err(wrong(at)) };
        self.at += next.len_utf8();
        Ok(match next {
            '"' | '\\' | '/' => next,
            'b' => '\u{8}',
            'f' => '\u{c}',
            'n' => '\n',
            'r' => '\r',
            't' => '\t',
            'u' => {
                let high = self.hex().ok_or_else(|| wrong(at))?;
                let code = if (0xd800..0xdc00).contains(&high) && self.text[self.at..].starts_with("\\u") {
                    self.at += 2;
                    let low = self.hex().ok_or_else(|| wrong(at))?;
                    0x1_0000 + ((high - 0xd800) << 10) + low.wrapping_sub(0xdc00)
                } else {
                    high
                };
                char::from_u32(code).ok_or_else(|| wrong(at))?
            }
            _ => return Err(wrong(at)),
        })
    }

    fn hex(&mut self) -> Option<u32> {
        let digits =
            self.text.get(self.at..self.at + 4).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()))?;
        self.at += 4;
        u32::from_str_radix(digits, 16).ok()
    }

    /// Reads a word up to the next delimiter or blank.
    fn word(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| c.is_whitespace() || ",:{}[]\"".contains(c)).unwrap_or(rest.len());
        self.at += end;
        &rest[..end]
    }

    fn blanks(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, mark: char) -> bool {
        let is_there = self.peek() == Some(mark);
        self.at += usize::from(is_there);
        is_there
    }

    fn unexpected(&self, expected: &str) -> Syntax {
        let found = match self.peek() {
            None => "the end of the file".to_owned(),
            Some(_) => format!("`{}`", cut(self.text[self.at..].lines().next().unwrap_or_default(), 20)),
        };
        let end = self.at + self.peek().map_or(0, char::len_utf8);
        (self.at..end, format!("{expected} is expected, not {found}"))
    }
}

fn number(word: &str) -> Option<Value> {
    let is_number = word.starts_with(|c: char| c == '-' || c.is_ascii_digit());
    if !is_number || !word.chars().all(|c| c.is_ascii_digit() || "+-.eE".contains(c)) {
        return None;
    }
    match word.parse::<i128>() {
        Ok(whole) => Some(Value::Integer(whole)),
        Err(_) => word.parse().ok().map(Value::Float),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<Vec<Entry>, String> {
        let (root, problems) = parse_json("f", text).map_err(|problems| problems.to_string())?;
        problems.finish().map_err(|problems| problems.to_string())?;
        Ok(root.value.as_table().expect("an object").to_vec())
    }

    #[test]
    fn values_have_their_kinds_and_places() {
        let text = "\u{feff}{\"a\": 1, \"b\" : [1.5, -2e3, NaN, null],\n \"c\": {\"d\": \"x\\u00e9\\ud83d\\ude00\\n\"}, \"e\": null, \"f\": true, \"g\": 1e999}\n";
        let entries = read(text).unwrap();
        let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c", "f", "g"]);
        assert_eq!(entries[0].node.value, Value::Integer(1));
        let Value::Array(items) = &entries[1].node.value else { panic!("an array") };
        assert_eq!((items.len(), &text[items[1].span.clone()]), (4, "-2e3"));
        assert!(items[2].value.as_number().unwrap().is_nan() && items[3].value.as_number().is_none());
        assert_eq!(entries[2].node.value.as_table().unwrap()[0].node.value, Value::Text("xé😀\n".to_owned()));
        assert_eq!(&text[entries[2].name_span.clone()], "\"c\"");
        assert_eq!(entries[4].node.value.as_number(), Some(f64::INFINITY));
    }

    #[test]
    fn syntax_errors_are_reported_where_they_are() {
        for (text, expected) in [
            ("", "f:1:1: not valid JSON: an object `{` is expected, not the end of the file"),
            ("[1]", "f:1:1: not valid JSON: an object `{` is expected, not `[1]`"),
            ("{\"a\": 1\n \"b\": 2}", "f:2:2: not valid JSON: `,` or `}` is expected, not `\"b\": 2}`"),
            ("{\"a\": 1,}", "f:1:9: not valid JSON: a name in quotes is expected, not `}`"),
            ("{\"a\": 01x}", "f:1:7: not valid JSON: a value is expected, not `01x}`"),
            ("{\"a\": \"x}", "f:1:7: not valid JSON: a string without its end"),
            ("{\"a\": \"\\q\"}", "f:1:8: not valid JSON: an unknown escape in a string"),
            ("{\"a\": 1} 2", "f:1:10: not valid JSON: the end of the file is expected, not `2`"),
            ("{\"a\": 1, \"a\": 2}", "f:1:10: a: given twice"),
        ] {
            assert_eq!(read(text).unwrap_err(), expected, "{text}");
        }
        let deep = format!("{{\"a\": {}", "[".repeat(100_000));
        assert!(read(&deep).unwrap_err().contains("nested deeper than 64 levels"));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn any_text_is_a_tree_or_refused(pieces in prop::collection::vec(prop::sample::select(PIECES.to_vec()), 0..24)) {
            let text = pieces.concat();
            for text in [text.clone(), format!("{{\"a\": {text}}}")] {
                if let Err(problems) = parse_json("f", &text) {
                    prop_assert!(problems.list.iter().all(|problem| problem.span.end <= text.len()), "{problems}");
                }
            }
        }
    }

    const PIECES: [&str; 24] = [
        "{", "}", "[", "]", ",", ":", "\"", "\"a\"", "\"b\":", "1", "-", "e5", ".", "null", "tru", "NaN", "\\", "\\u",
        "d83d", "\\ud8", "é", "\n", " ", "😀",
    ];
}
