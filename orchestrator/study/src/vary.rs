//! `[[vary]]`: one table per varied parameter; tables of the same `zip` group advance together.

use super::axis::{Axis, MOST_VARIED, Varied};
use super::extra_columns::can_be_extra_column;
use super::header::name_and_unit;
use super::parameter::variable_info;
use super::table::{Keys, scalar_text, wrong_type};
use super::values::{Gathered, Mixed, ValueList};
use bladeoff_model::machine::{
    MachineDef, ParamValue, PathError, PathInfo, PathKind, ValueError, is_of_the_format, some_of,
};
use bladeoff_system::call::program;
use bladeoff_text::document::units::parse_any_quantity;
use bladeoff_text::document::{Collector, Entry, MISSING, Node, Value, cut};
use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Range;

/// Most points of one axis.
pub(super) const MOST_POINTS: usize = 1_000_000;

/// Position at which a study names a parameter, and the value that a message shows with the key: the name itself if it is the value, otherwise
/// the value given to the parameter.
pub(super) struct Given<'a> {
    pub span: Range<usize>,
    pub key: &'a str,
    pub value: Option<String>,
}

/// The paths of a study's machine, and those that the study has used so far.
pub(super) struct PathTable<'a> {
    /// `None`: the machine could not be read; paths are then not checked.
    machine: Option<&'a MachineDef>,
    /// Whether only a part of the machine could be read.
    partly: bool,
    /// Whether the study computes formulas and has no machine.
    is_function: bool,
    /// Names of the standard columns of the table.
    own: Vec<String>,
    used: RefCell<Vec<(String, Range<usize>, String)>>,
}

impl<'a> PathTable<'a> {
    /// The paths of a machine; `partly`: only a part of it could be read.
    pub fn new(machine: Option<&'a MachineDef>, partly: bool) -> Self {
        Self { machine, partly, is_function: false, own: Vec::new(), used: RefCell::new(Vec::new()) }
    }

    /// The table for a study without a machine: there are no paths.
    pub fn of_function() -> Self {
        Self { machine: None, partly: false, is_function: true, own: Vec::new(), used: RefCell::new(Vec::new()) }
    }

    /// Sets the names of the standard columns of the table.
    pub fn with_own(mut self, own: Vec<String>) -> Self {
        self.own = own;
        self
    }

    /// The parameter that the entry `path` of a table names; it is then marked as used.
    pub fn named(&self, path: &Entry, keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<PathInfo> {
        let given = keys.text(path, problems)?;
        let value = Some(format!("{:?}", cut(given, 80)));
        let info =
            self.resolve(given, Given { span: path.node.span.clone(), key: &keys.key("path"), value }, problems)?;
        self.used(&info, path.node.span.clone(), &keys.key("path"));
        Some(info)
    }

    /// Message for an unknown path, depending on how much of the machine could be read.
    fn unknown(&self) -> &'static str {
        match (self.machine, self.partly) {
            (None, _) => "no machine has such a parameter",
            (Some(_), true) => "this machine, as far as it can be read, has no such parameter",
            (Some(_), false) => "this machine has no such parameter",
        }
    }

    /// As [`PathTable::resolve`] for a column of a points file, which may be something other than a parameter; `named`: parameters of other columns.
    pub fn column(
        &self,
        name: &str,
        span: Range<usize>,
        named: &[PathInfo],
        problems: &mut Collector<'_>,
    ) -> Option<PathInfo> {
        let key = cut(name, 80);
        let unknown = self.machine.filter(|_| !problems.is_full()).map(|machine| machine.resolve(name));
        let nearest = match unknown {
            Some(Err(PathError::Unknown { nearest, .. })) => nearest,
            // A column `name` is more likely the name of the points than that of the machine.
            Some(Err(PathError::Text { .. })) => None,
            _ => return self.resolve(name, Given { span, key: &key, value: None }, problems),
        };
        let (message, carry) = match name {
            "" => ("a column without a name (an index, as some programs write it?)", String::new()),
            // the message suggests `carry` only if the study would accept it
            _ if !can_be_extra_column(name) || self.own.iter().any(|own| own == name) => {
                (self.unknown(), String::new())
            }
            _ => (self.unknown(), format!("carry = [{key:?}] takes the column along into the table, ")),
        };
        let nearest = nearest.filter(|near| !named.iter().any(|info| info.path == *near));
        let message = format!("{message}; in the study's [points] {carry}ignore = [{key:?}] leaves it out");
        let problem = problems.add(span, &key, message);
        problem.nearest = nearest;
        problem.allowed = Some("a parameter's path, its ending or its column".to_owned());
        None
    }

    /// The parameter that `given`, a path or the end of one, names; a problem and `None` if it names none or several.
    pub fn resolve(&self, given: &str, at: Given<'_>, problems: &mut Collector<'_>) -> Option<PathInfo> {
        let Given { span, key, value } = at;
        if self.is_function {
            let problem = problems.add(span, key, "a study with model = \"function\" has no machine, and no paths");
            problem.value = value;
            problem.allowed = Some("name = \"x\": a variable of its formulas".to_owned());
            return None;
        }
        let Some(machine) = self.machine else {
            // The machine is unreadable, so only paths that no machine has are wrong.
            if !is_of_the_format(given) {
                problems.add(span, key, self.unknown()).value = value;
            }
            return None;
        };
        match if problems.is_full() { machine.find(given) } else { machine.resolve(given) } {
            Ok(info) => Some(info),
            Err(_) if problems.is_full() => one_more(problems),
            Err(PathError::Ambiguous { candidates, .. }) => {
                let problem = problems.add(span, key, format!("`{given}` is ambiguous: several parameters end so"));
                problem.value = value;
                problem.allowed = Some(some_of(&candidates));
                None
            }
            Err(PathError::Unknown { nearest, .. }) => {
                let problem = problems.add(span, key, self.unknown());
                problem.value = value;
                problem.allowed = Some(format!("a path of `{} paths MACHINE`, or its ending", program()));
                problem.nearest = nearest;
                None
            }
            Err(text @ PathError::Text { .. }) => {
                problems.add(span, key, text.to_string()).value = value;
                None
            }
        }
    }

    /// Every parameter by the name of its column in a result table.
    pub fn columns(&self) -> Columns {
        let all = self.machine.map(MachineDef::paths).unwrap_or_default();
        Columns(all.into_iter().map(|info| (info.column(), info)).collect())
    }

    /// The parameter of a column, given by its column name, its path or the end of the path.
    pub fn known(&self, columns: &Columns, name: &str) -> Option<PathInfo> {
        columns.find(name).cloned().or_else(|| self.machine?.find(name).ok())
    }

    /// The parameter and the unit of a header cell such as `contact.gap [mm]`, whose name is a path or the end of one.
    pub fn with_unit<'n>(&self, cell: &'n str) -> Option<(PathInfo, &'n str)> {
        let machine = self.machine.filter(|machine| machine.find(cell).is_err())?;
        let (name, unit) = name_and_unit(cell)?;
        Some((machine.find(name).ok()?, unit))
    }

    /// The value in `text`; a problem and `None` if the parameter does not allow it.
    pub fn value(
        &self,
        info: &PathInfo,
        text: &str,
        span: Range<usize>,
        key: &str,
        problems: &mut Collector<'_>,
    ) -> Option<ParamValue> {
        match self.machine?.parse_value(info, text) {
            Ok(value) => Some(value),
            Err(_) if problems.is_full() => one_more(problems),
            Err(error) => {
                let shown = problems.excerpt(span.clone());
                let (message, nearest) = refusal(error);
                let problem = problems.add(span, key, format!("{message} (for {})", info.path));
                problem.value = Some(shown);
                problem.allowed = Some(info.allowed.clone());
                problem.nearest = nearest;
                None
            }
        }
    }

    /// The number in `text` as the value of a variable; a problem and `None` if it is not a number.
    pub fn number(
        &self,
        text: &str,
        span: Range<usize>,
        key: &str,
        problems: &mut Collector<'_>,
    ) -> Option<ParamValue> {
        match parse_any_quantity(text) {
            Ok(number) => Some(ParamValue::Number(number)),
            Err(error) => {
                let value = problems.excerpt(span.clone());
                let (message, nearest) = error.parts();
                let problem = problems.add(span, key, message);
                problem.value = Some(value);
                problem.nearest = nearest;
                None
            }
        }
    }

    /// Records that the study gives this parameter its value at `span`.
    pub fn used(&self, info: &PathInfo, span: Range<usize>, key: &str) {
        self.used.borrow_mut().push((info.path.clone(), span, key.to_owned()));
    }

    /// Rejects every parameter that is given values twice.
    pub fn refuse_repeated(&self, problems: &mut Collector<'_>) {
        let mut first: HashMap<String, String> = HashMap::new();
        for (path, span, key) in self.used.borrow_mut().drain(..) {
            match first.get(&path) {
                Some(first) => drop(problems.add(span, key, format!("{path} is given by `{first}` already"))),
                None => drop(first.insert(path, key)),
            }
        }
    }
}

/// Parameters by the names of their columns.
pub(super) struct Columns(HashMap<String, PathInfo>);

impl Columns {
    /// The parameter of a column, or of an unambiguous ending of its name from a dot on.
    pub fn find(&self, name: &str) -> Option<&PathInfo> {
        if let Some(info) = self.0.get(name) {
            return Some(info);
        }
        let ends_so = |column: &String| column.strip_suffix(name).is_some_and(|rest| rest.ends_with('.'));
        let mut found = self.0.iter().filter(|(column, _)| !name.is_empty() && ends_so(column));
        let (_, info) = found.next()?;
        found.next().is_none().then_some(info)
    }
}

/// Counts a problem without details.
fn one_more<T>(problems: &mut Collector<'_>) -> Option<T> {
    problems.add(0..0, "", "");
    None
}

/// Description of an invalid value, and the word or unit most likely meant.
fn refusal(error: ValueError) -> (String, Option<String>) {
    match error {
        ValueError::Quantity { source, .. } => source.parts(),
        ValueError::OutOfRange { .. } => ("out of range".to_owned(), None),
        ValueError::NotWhole { .. } => ("not a whole number".to_owned(), None),
        ValueError::NotAChoice { nearest, .. } => ("not an allowed word".to_owned(), nearest),
        ValueError::List { .. } => {
            ("one value is expected; write a matrix or list in the machine file".to_owned(), None)
        }
        ValueError::NoSuchParameter { .. } => ("this machine has no such parameter".to_owned(), None),
    }
}

/// A valid `[[vary]]` table.
struct Member {
    varied: Varied,
    zip: Option<String>,
    span: Range<usize>,
}

/// The axes of `[[vary]]`; a zip group is at the position of its first member.
pub(super) fn read_vary(entry: &Entry, paths: &PathTable, problems: &mut Collector<'_>) -> Vec<Axis> {
    let Value::Array(items) = &entry.node.value else {
        wrong_type(&entry.node, "vary", "an array of tables: [[vary]]", problems);
        return Vec::new();
    };
    if let Some(surplus) = items.get(MOST_VARIED) {
        let message = format!("{} parameters vary", items.len());
        problems.add(surplus.span.clone(), "vary", message).allowed = Some(format!("at most {MOST_VARIED}"));
        return Vec::new();
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (position, item) in items.iter().enumerate() {
        let Some(member) = read_member(item, &format!("vary[{position}]"), paths, problems) else { continue };
        let length = member.varied.values.len();
        let group = member.zip.as_deref().and_then(|zip| axes.iter_mut().find(|axis| axis.name == group_name(zip)));
        match group {
            None => axes.push(Axis {
                name: member.zip.as_deref().map_or_else(|| member.varied.info.path.clone(), group_name),
                varied: vec![member.varied],
                length,
            }),
            Some(axis) if axis.length == length => axis.varied.push(member.varied),
            Some(axis) => {
                let message = format!(
                    "has {length} values, but {} of the same zip group has {}",
                    axis.varied[0].info.path, axis.length
                );
                problems.add(member.span, format!("vary[{position}].zip"), message).allowed =
                    Some("as many values as the other members of the group".to_owned());
            }
        }
    }
    axes
}

fn group_name(zip: &str) -> String {
    format!("zip {zip}")
}

fn read_member(item: &Node, key: &str, paths: &PathTable, problems: &mut Collector<'_>) -> Option<Member> {
    let keys = Keys::at(item, key, problems)?;
    keys.refuse_unknown(&crate::keys::names("[[vary]]"), problems);
    let zip = match keys.get("zip") {
        Some(entry) => Some(keys.text(entry, problems)?.to_owned()),
        None => None,
    };
    let short = match keys.get("as") {
        Some(entry) => Some(keys.text(entry, problems)?.to_owned()),
        None => None,
    };
    let (info, is_variable, place) = match (keys.get("path"), keys.get("name")) {
        (None, Some(name)) => (keys.text(name, problems).map(variable_info), true, name.node.span.clone()),
        (Some(_), Some(name)) => {
            problems.add(name.name_span.clone(), keys.key("name"), "is given together with `path`").allowed =
                Some("`path` of a parameter, or `name` of a variable for formulas; a short name is `as`".to_owned());
            return None;
        }
        (_, None) => {
            let path = keys.require("path", "path = \"contact.gap\"", problems)?;
            (paths.named(path, &keys, problems), false, path.node.span.clone())
        }
    };
    let target = Target { info: info.as_ref(), is_variable, paths };
    let range = ["from", "to", "count", "spacing"].into_iter().find_map(|name| keys.get(name));
    let values = match (keys.get("values"), range) {
        (Some(_), Some(other)) => {
            problems.add(other.name_span.clone(), keys.key(&other.name), "is given together with `values`").allowed =
                Some("either `values`, or `from`, `to` and `count`".to_owned());
            None
        }
        (Some(values), None) => read_list(values, &keys, &target, problems),
        (None, Some(_)) => read_range(&keys, &target, problems),
        (None, None) => {
            problems.add(keys.span(), keys.key("values"), MISSING).allowed =
                Some("values = [...], or `from`, `to` and `count`".to_owned());
            None
        }
    };
    Some(Member { varied: Varied { info: info?, short, is_variable, values: values?, place }, zip, span: keys.span() })
}

/// Parameter or variable whose values are read.
struct Target<'a> {
    /// `None`: its name is invalid, which has been reported.
    info: Option<&'a PathInfo>,
    is_variable: bool,
    paths: &'a PathTable<'a>,
}

impl Target<'_> {
    fn value(&self, text: &str, span: Range<usize>, key: &str, problems: &mut Collector<'_>) -> Option<ParamValue> {
        if self.is_variable {
            self.paths.number(text, span, key, problems)
        } else {
            self.paths.value(self.info?, text, span, key, problems)
        }
    }
}

fn read_list(entry: &Entry, keys: &Keys<'_>, target: &Target<'_>, problems: &mut Collector<'_>) -> Option<ValueList> {
    let info = target.info?;
    let Value::Array(items) = &entry.node.value else {
        wrong_type(&entry.node, &keys.key("values"), "an array of values", problems);
        return None;
    };
    if items.is_empty() {
        problems.add(entry.node.span.clone(), keys.key("values"), "is empty").allowed =
            Some("at least one value".to_owned());
        return None;
    }
    let mut values = Gathered::new(info, items.len());
    for (position, item) in items.iter().enumerate() {
        let key = format!("{}[{position}]", keys.key("values"));
        match scalar_text(&item.value) {
            Some(text) => {
                if let Some(value) = target.value(&text, item.span.clone(), &key, problems) {
                    values.push(&value);
                }
            }
            None => wrong_type(item, &key, "a number, a string with a unit or a word", problems),
        }
    }
    let values = one_kind(values, entry.node.span.clone(), &keys.key("values"), problems)?;
    // A missing value has been reported.
    (values.len() == items.len() as u64).then_some(values)
}

/// Requires that a column has only numbers or only words.
pub(super) fn one_kind(
    values: Gathered,
    span: Range<usize>,
    key: &str,
    problems: &mut Collector<'_>,
) -> Option<ValueList> {
    let mixed = |Mixed| {
        problems.add(span, key, "mixes numbers and words").allowed = Some("all numbers, or all words".to_owned());
    };
    values.finish().map_err(mixed).ok()
}

fn read_range(keys: &Keys<'_>, target: &Target<'_>, problems: &mut Collector<'_>) -> Option<ValueList> {
    let count = keys
        .require("count", "count = 5", problems)
        .and_then(|entry| keys.whole(entry, 2, MOST_POINTS as u64, problems));
    let log = read_spacing(keys, problems);
    let from = keys.require("from", "from = \"1 mm\"", problems);
    let to = keys.require("to", "to = \"2 mm\"", problems);
    let info = target.info?;
    if !matches!(info.kind, PathKind::Number | PathKind::NumberOrChoice(_)) {
        problems.add(keys.span(), keys.key("from"), format!("{} has no range of real numbers", info.path)).allowed =
            Some("values = [...]".to_owned());
        return None;
    }
    let mut end = |entry: Option<&Entry>| -> Option<f64> {
        let entry = entry?;
        let key = keys.key(&entry.name);
        let Some(text) = scalar_text(&entry.node.value) else {
            wrong_type(&entry.node, &key, "a number or a string with a unit", problems);
            return None;
        };
        match target.value(&text, entry.node.span.clone(), &key, problems)? {
            ParamValue::Number(value) => Some(value),
            ParamValue::Choice(word) => {
                problems.add(entry.node.span.clone(), key, format!("`{word}` is a word, not a number"));
                None
            }
        }
    };
    let (start, stop) = (end(from), end(to));
    let (from_value, to_value, count, log) = (start?, stop?, count?, log?);
    let span = from.map_or_else(|| keys.span(), |entry| entry.node.span.clone());
    if log && (from_value * to_value).partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        problems
            .add(span, keys.key("spacing"), "logarithmic spacing needs both ends of the same sign and not zero")
            .allowed = Some("spacing = \"linear\", or other ends".to_owned());
        return None;
    }
    if from_value == to_value {
        problems.add(span, keys.key("from"), "both ends are equal").allowed =
            Some("values = [...] for one value".to_owned());
        return None;
    }
    Some(ValueList::Range { from: from_value, to: to_value, count, log })
}

fn read_spacing(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<bool> {
    let Some(entry) = keys.get("spacing") else { return Some(false) };
    match keys.text(entry, problems)? {
        "linear" => Some(false),
        "log" => Some(true),
        other => {
            let nearest = problems.nearest(other, ["linear", "log"]);
            let problem = problems.add(entry.node.span.clone(), keys.key("spacing"), "unknown spacing");
            problem.value = Some(format!("{:?}", cut(other, 80)));
            problem.allowed = Some("linear, log".to_owned());
            problem.nearest = nearest;
            None
        }
    }
}
