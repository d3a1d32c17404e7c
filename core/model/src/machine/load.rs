//! Reads a machine file against the table of keys: reports unknown keys, wrong shapes and wrong values, and creates every slot, including
//! those that the file leaves to their defaults.

use std::collections::BTreeMap;
use std::ops::Range as Span;

use super::layout::{ByPath, Layout, Named, Origin, Scalar, Slot, State, Text};
use super::schema::{Branch, Key, Kind, Need, SCHEMA, Segment, root};
use super::value::from_node;
use bladeoff_text::document::{Collector, Entry, MISSING, Node, Problems, Value, cut, parse_toml};

/// Limits on sections, list entries and named tables, above the need of any machine; they bound the memory that a file can request.
const MOST_SECTIONS: usize = 1_000;
const MOST_ENTRIES: usize = 10_000;
/// Each bearing has its own result columns, and a message carries at most 2048 values of a sample.
const MOST_BEARINGS: usize = 50;
const MOST_NAMES: usize = 1_000;
const LONGEST_NAME: usize = 64;
const LONGEST_TEXT: usize = 200;

/// The readable part of a file, with the problems found.
pub(super) struct Loaded<'a> {
    pub layout: Layout,
    pub states: Vec<State>,
    pub problems: Collector<'a>,
}

/// Reads a machine file.
///
/// # Errors
/// A syntax error after which nothing can be read, or a version of the format that this program does not read.
pub(super) fn load<'a>(file: &'a str, text: &'a str) -> Result<Loaded<'a>, Problems> {
    let (document, mut problems) = parse_toml(file, text)?;
    let entries = document.value.as_table().unwrap_or_default();
    check_schema(entries, &mut problems)?;
    let layout = Layout {
        file: file.to_owned(),
        text: text.to_owned(),
        name: String::new(),
        slots: Vec::new(),
        by_path: ByPath::default(),
        conditions: Vec::new(),
        tables: BTreeMap::new(),
        groups: BTreeMap::new(),
        lengths: BTreeMap::new(),
        texts: BTreeMap::new(),
    };
    let mut walk = Walk { layout, states: Vec::new(), problems };
    walk.table(root(), "", &Source::Table(entries), 0..0);
    let Walk { mut layout, states, problems } = walk;
    layout.index();
    Ok(Loaded { layout, states, problems })
}

fn check_schema(entries: &[Entry], problems: &mut Collector<'_>) -> Result<(), Problems> {
    let Some(entry) = entries.iter().find(|entry| entry.name == "schema") else {
        problems.add(0..0, "schema", MISSING).allowed = Some(format!("schema = {SCHEMA}"));
        return Ok(());
    };
    if entry.node.value == Value::Integer(SCHEMA) {
        return Ok(());
    }
    let shown = problems.excerpt(entry.node.span.clone());
    let problem = problems.add(
        entry.node.span.clone(),
        "schema",
        format!("version {shown} of the machine format is not known; this program reads version {SCHEMA}"),
    );
    problem.value = Some(shown);
    problem.allowed = Some(SCHEMA.to_string());
    problems.clone().finish()
}

/// Source of a table's values.
enum Source<'a> {
    /// The file has the table.
    Table(&'a [Entry]),
    /// The file does not have the table: defaults apply.
    Absent,
    /// The file has another type of value in its place, which has been reported.
    Bad,
}

struct Walk<'a> {
    layout: Layout,
    states: Vec<State>,
    problems: Collector<'a>,
}

impl Walk<'_> {
    fn report(&mut self, span: &Span<usize>, path: &str, message: impl Into<String>, allowed: &str) {
        let shown = self.problems.excerpt(span.clone());
        let problem = self.problems.add(span.clone(), path, message);
        problem.value = Some(shown);
        problem.allowed = Some(allowed.to_owned());
    }

    fn table(&mut self, branch: &'static Branch, path: &str, source: &Source<'_>, span: Span<usize>) {
        let named = branch.branches.iter().any(|branch| branch.segment == Segment::Named);
        if let Source::Table(entries) = source {
            self.layout.tables.insert(path.to_owned(), span.clone());
            if entries.is_empty() && !path.is_empty() {
                self.problems.add(span.clone(), path, "empty table: write its keys or leave it out");
            }
            if !named {
                self.unknown_names(branch, path, entries);
            }
        }
        let find = |name: &str| match source {
            Source::Table(entries) => entries.iter().find(|entry| entry.name == name),
            Source::Absent | Source::Bad => None,
        };
        for &key in &branch.keys {
            self.key(key, &join(path, key.name()), find(key.name()), source, &span);
        }
        for below in &branch.branches {
            match below.segment {
                Segment::Fixed(name) => {
                    let (source, span) = match find(name) {
                        Some(entry) => (self.as_table(entry, &join(path, name)), entry.name_span.clone()),
                        None if matches!(source, Source::Bad) => (Source::Bad, span.clone()),
                        None => (Source::Absent, span.clone()),
                    };
                    self.table(below, &join(path, name), &source, span);
                }
                Segment::Named => {
                    if let Source::Table(entries) = source {
                        self.named_tables(below, path, entries);
                    }
                }
                Segment::Array(name) => {
                    if let Some(entry) = find(name) {
                        self.sections(below, &join(path, name), entry);
                    }
                }
            }
        }
    }

    fn unknown_names(&mut self, branch: &Branch, path: &str, entries: &[Entry]) {
        for entry in entries.iter().filter(|entry| !branch.names().any(|name| name == entry.name)) {
            let shown = self.problems.excerpt(entry.node.span.clone());
            let what = if matches!(entry.node.value, Value::Table(_)) { "unknown table" } else { "unknown key" };
            let key = join(path, &cut(&entry.name, 80));
            let nearest = self.problems.nearest(&entry.name, branch.names());
            let problem = self.problems.add(entry.name_span.clone(), key, what);
            if !matches!(entry.node.value, Value::Table(_)) {
                problem.value = Some(shown);
            }
            problem.nearest = nearest;
            let mut names: Vec<&str> = branch.names().collect();
            names.dedup();
            problem.allowed = Some(names.join(", "));
        }
    }

    fn as_table<'a>(&mut self, entry: &'a Entry, path: &str) -> Source<'a> {
        if let Some(entries) = entry.node.value.as_table() {
            return Source::Table(entries);
        }
        let message = format!("a table is expected, not {}", entry.node.value.type_name());
        self.report(&entry.node.span, path, message, &format!("[{path}]"));
        Source::Bad
    }

    fn named_tables(&mut self, branch: &'static Branch, path: &str, entries: &[Entry]) {
        let most = if path == "rotor.bearings" { MOST_BEARINGS } else { MOST_NAMES };
        let mut members = Vec::new();
        for entry in entries.iter().take(most) {
            let below = join(path, &cut(&entry.name, 80));
            if let Some(allowed) = wrong_name(path, &entry.name) {
                let problem = self.problems.add(entry.name_span.clone(), below, "not a usable name");
                problem.value = Some(cut(&entry.name, 80));
                problem.allowed = Some(allowed);
                continue;
            }
            let source = self.as_table(entry, &below);
            members.push(Named { name: entry.name.clone() });
            self.table(branch, &below, &source, entry.name_span.clone());
        }
        if let Some(entry) = entries.get(most) {
            let message = format!("{} tables", entries.len());
            self.problems.add(entry.name_span.clone(), path, message).allowed = Some(format!("at most {most}"));
        }
        self.layout.groups.insert(path.to_owned(), members);
    }

    fn sections(&mut self, branch: &'static Branch, path: &str, entry: &Entry) {
        let Value::Array(items) = &entry.node.value else {
            let message = format!("an array of tables is expected, not {}", entry.node.value.type_name());
            self.report(&entry.name_span, path, message, &format!("[[{path}]] for each section"));
            self.layout.lengths.insert(path.to_owned(), 0);
            return;
        };
        if items.len() > MOST_SECTIONS {
            let message = format!("{} sections", items.len());
            self.problems.add(entry.name_span.clone(), path, message).allowed =
                Some(format!("at most {MOST_SECTIONS}"));
            self.layout.lengths.insert(path.to_owned(), 0);
            return;
        }
        let mut members = Vec::new();
        for (i, item) in items.iter().enumerate() {
            let below = format!("{path}[{i}]");
            let source = match item.value.as_table() {
                Some(entries) => Source::Table(entries),
                None => {
                    let message = format!("a table is expected, not {}", item.value.type_name());
                    self.report(&item.span, &below, message, &format!("[[{path}]] for each section"));
                    Source::Bad
                }
            };
            members.push(Named { name: i.to_string() });
            self.table(branch, &below, &source, item.span.clone());
        }
        self.layout.groups.insert(path.to_owned(), members);
    }

    fn key(&mut self, key: &'static Key, path: &str, entry: Option<&Entry>, source: &Source<'_>, table: &Span<usize>) {
        let bad = matches!(source, Source::Bad);
        match key.kind {
            // Read first of all.
            Kind::Schema => {}
            Kind::Text => self.text(key, path, entry, table),
            Kind::Number(_) | Kind::NumberOr(..) | Kind::Count | Kind::Choice(_) => {
                self.slot(key, path.to_owned(), false, entry.map(|entry| &entry.node), bad, table);
            }
            Kind::Vector(_) => self.array(key, path, entry, bad, table),
            Kind::Matrix(_) => match entry {
                Some(Entry { node: Node { value: Value::Array(rows), span }, .. }) => {
                    self.matrix(key, path, rows, span)
                }
                _ => self.slot(key, path.to_owned(), false, entry.map(|entry| &entry.node), bad, table),
            },
            Kind::Diagonal(_) => match entry {
                Some(Entry { node: Node { value: Value::Array(_), .. }, .. }) => {
                    self.array(key, path, entry, bad, table)
                }
                _ => self.slot(key, path.to_owned(), false, entry.map(|entry| &entry.node), bad, table),
            },
            Kind::List(_) => {
                if let Some(entry) = entry {
                    self.list(key, path, &entry.node);
                }
            }
        }
    }

    fn slot(
        &mut self,
        key: &'static Key,
        path: String,
        part: bool,
        node: Option<&Node>,
        bad: bool,
        table: &Span<usize>,
    ) {
        let span = node.map_or_else(|| table.clone(), |node| node.span.clone());
        let slot = Slot { path, key, part, span };
        let state = match node {
            Some(node) => State { scalar: from_node(&slot, node, &mut self.problems), origin: Origin::File },
            None if bad => State { scalar: Scalar::Bad, origin: Origin::File },
            None => State::default_of(key),
        };
        self.layout.slots.push(slot);
        self.states.push(state);
    }

    fn array(&mut self, key: &'static Key, path: &str, entry: Option<&Entry>, bad: bool, table: &Span<usize>) {
        let items = match entry.map(|entry| &entry.node) {
            None => None,
            Some(Node { value: Value::Array(items), .. }) if items.len() == 2 => Some(items),
            Some(node) => {
                let message = match &node.value {
                    Value::Array(items) => format!("{} components instead of 2", items.len()),
                    other => format!("two components are expected, not {}", other.type_name()),
                };
                self.report(&node.span, path, message, &format!("[x, y], each {}", key.range.words(key.unit())));
                None
            }
        };
        for i in 0..2 {
            let node = items.map(|items| &items[i]);
            let bad = bad || entry.is_some() && items.is_none();
            self.slot(key, format!("{path}[{i}]"), true, node, bad, table);
        }
    }

    fn matrix(&mut self, key: &'static Key, path: &str, rows: &[Node], span: &Span<usize>) {
        let cells: Option<Vec<&Node>> = rows.iter().try_fold(Vec::new(), |mut cells, row| match &row.value {
            Value::Array(row) if row.len() == 2 => {
                cells.extend(row);
                Some(cells)
            }
            _ => None,
        });
        let cells = cells.filter(|cells| cells.len() == 4);
        if cells.is_none() {
            let allowed = format!("one number in {0}, or [[xx, xy], [yx, yy]]", key.unit());
            self.report(span, path, "not a 2x2 matrix", &allowed);
        }
        for i in 0..4 {
            let node = cells.as_ref().map(|cells| cells[i]);
            self.slot(key, format!("{path}[{}][{}]", i / 2, i % 2), true, node, cells.is_none(), span);
        }
    }

    fn list(&mut self, key: &'static Key, path: &str, node: &Node) {
        let length = match &node.value {
            Value::Array(items) if (1..=MOST_ENTRIES).contains(&items.len()) => {
                for (i, item) in items.iter().enumerate() {
                    self.slot(key, format!("{path}[{i}]"), true, Some(item), false, &node.span);
                }
                items.len()
            }
            other => {
                let message = match other {
                    Value::Array(items) => format!("a list of {} entries", items.len()),
                    other => format!("a list is expected, not {}", other.type_name()),
                };
                let allowed = format!("1 to {MOST_ENTRIES} numbers, each {}", key.range.words(key.unit()));
                self.report(&node.span, path, message, &allowed);
                0
            }
        };
        self.layout.lengths.insert(path.to_owned(), length);
        self.layout.tables.insert(path.to_owned(), node.span.clone());
    }

    fn text(&mut self, key: &'static Key, path: &str, entry: Option<&Entry>, table: &Span<usize>) {
        let allowed = format!("1 to {LONGEST_TEXT} characters, none of them a control character");
        let (mut value, mut span) = (None, table.clone());
        match entry.map(|entry| &entry.node) {
            None if matches!(key.need, Need::Optional(_)) => return,
            None => self.problems.add(table.clone(), path, MISSING).allowed = Some(allowed),
            Some(Node { value: Value::Text(text), span: place }) => {
                let length = text.chars().count();
                if text.trim().is_empty() || length > LONGEST_TEXT || text.chars().any(char::is_control) {
                    self.report(place, path, "not a usable name", &allowed);
                } else {
                    value = Some(text.clone());
                }
                span = place.clone();
            }
            Some(node) => {
                let message = format!("text in quotes is expected, not {}", node.value.type_name());
                self.report(&node.span, path, message, &allowed);
                span = node.span.clone();
            }
        }
        if path == "name" {
            self.layout.name = value.unwrap_or_default();
        } else {
            self.layout.texts.insert(path.to_owned(), Text { key, value, span });
        }
    }
}

/// Required form of a name, if `name` is invalid. Names become parts of column names.
fn wrong_name(group: &str, name: &str) -> Option<String> {
    let mut letters = name.chars();
    let plain = letters.next().is_some_and(|c| c.is_ascii_alphabetic())
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if !plain || name.len() > LONGEST_NAME {
        return Some(format!("a letter, then letters, digits, _ or -; at most {LONGEST_NAME}"));
    }
    let like_a_column = ["at_s", "N"].iter().any(|end| name == *end || name.ends_with(&format!("_{end}")));
    (group == "rotor.bearings" && like_a_column)
        .then(|| "a bearing's name does not end in _at_s or _N: it would read like another result column".to_owned())
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}
