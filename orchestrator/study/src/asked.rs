//! `[[question]]` and `[[gate]]`: questions of a study file as written. This module reads keys and types only; a caller that knows the columns
//! of the table checks their meaning.

use super::error::StudyError;
use super::input::read_input;
use super::table::{Keys, scalar_text, wrong_type};
use bladeoff_text::document::{Collector, Entry, MAX_FILE_BYTES, Node, Value, cut, parse_toml};
use std::ops::Range;
use std::path::Path;

/// Most questions, and most gates, of a study.
const MOST: usize = 200;

/// A value and its position in the study file.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed<T> {
    /// The value.
    pub value: T,
    /// Byte range in the file.
    pub span: Range<usize>,
}

/// A `[[question]]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AskedQuestion {
    /// Byte range of the header.
    pub span: Range<usize>,
    /// Whether some of its keys were unreadable, which has been reported.
    pub is_partly: bool,
    /// `name`.
    pub name: Option<Placed<String>>,
    /// `probability`.
    pub probability: Option<Placed<String>>,
    /// `quantile`.
    pub quantile: Option<Placed<f64>>,
    /// `of`.
    pub of: Option<Placed<String>>,
    /// `mean`.
    pub mean: Option<Placed<String>>,
    /// `exceedance`.
    pub exceedance: Option<Placed<String>>,
    /// `sensitivity`.
    pub sensitivity: Option<Placed<String>>,
    /// `method`.
    pub method: Option<Placed<String>>,
    /// `fragility`.
    pub fragility: Option<Placed<String>>,
    /// `map`: two parameters.
    pub map: Option<Placed<[String; 2]>>,
    /// Whether the question has a `map`, valid or not.
    pub has_map: bool,
    /// `difference`, as texts.
    pub difference: Option<Placed<[String; 2]>>,
    /// `vary`.
    pub vary: Option<Placed<String>>,
    /// `confidence`.
    pub confidence: Option<Placed<f64>>,
}

impl AskedQuestion {
    /// Byte range of a key; of the header if the key is missing.
    #[must_use]
    pub fn place(&self, key: &str) -> Range<usize> {
        let text = |placed: &Option<Placed<String>>| placed.as_ref().map(|placed| placed.span.clone());
        let number = |placed: &Option<Placed<f64>>| placed.as_ref().map(|placed| placed.span.clone());
        let found = match key {
            "name" => text(&self.name),
            "probability" => text(&self.probability),
            "quantile" => number(&self.quantile),
            "of" => text(&self.of),
            "mean" => text(&self.mean),
            "exceedance" => text(&self.exceedance),
            "sensitivity" => text(&self.sensitivity),
            "method" => text(&self.method),
            "fragility" => text(&self.fragility),
            "difference" => self.difference.as_ref().map(|placed| placed.span.clone()),
            "map" => self.map.as_ref().map(|placed| placed.span.clone()),
            "vary" => text(&self.vary),
            _ => number(&self.confidence),
        };
        found.unwrap_or(self.span.clone())
    }
}

/// A `[[gate]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct AskedGate {
    /// `require`.
    pub require: Placed<String>,
    /// `confidence`.
    pub confidence: Option<Placed<f64>>,
}

/// Questions and gates of a study file, in order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Asked {
    /// `[[question]]`.
    pub questions: Vec<AskedQuestion>,
    /// `[[gate]]`.
    pub gates: Vec<AskedGate>,
}

impl Asked {
    /// Whether there are no questions and no gates.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.questions.is_empty() && self.gates.is_empty()
    }

    /// Reads the keys of a study; problems are added to `problems`.
    pub(super) fn read(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Self {
        let mut asked = Self::default();
        for (position, item) in items(keys.get("question"), "question", problems).iter().enumerate() {
            let key = format!("question[{position}]");
            let Some(table) = Keys::at(item, &key, problems) else { continue };
            let question = question(&table, problems);
            let name = question.name.as_ref();
            let is_taken = |name: &Placed<String>| {
                asked.questions.iter().any(|known: &AskedQuestion| {
                    known.name.as_ref().is_some_and(|known| known.value.eq_ignore_ascii_case(&name.value))
                })
            };
            if let Some(name) = name.filter(|name| is_taken(name)) {
                let message = format!("another question has the name `{}`", cut(&name.value, 80));
                problems.add(name.span.clone(), format!("{key}.name"), message).allowed =
                    Some("a name of its own, because it names a file".to_owned());
            }
            asked.questions.push(question);
        }
        for (position, item) in items(keys.get("gate"), "gate", problems).iter().enumerate() {
            let Some(table) = Keys::at(item, &format!("gate[{position}]"), problems) else { continue };
            asked.gates.extend(gate(&table, problems));
        }
        asked
    }
}

/// Names that a study file defines, valid or not.
pub(super) fn names(keys: &Keys<'_>) -> Vec<String> {
    let mut names = Vec::new();
    for entry in ["uncertain", "vary", "derived"].iter().filter_map(|name| keys.get(name)) {
        let Value::Array(items) = &entry.node.value else { continue };
        for entry in items.iter().filter_map(|item| item.value.as_table()).flatten() {
            if let (true, Value::Text(text)) =
                (["path", "name", "as"].contains(&entry.name.as_str()), &entry.node.value)
            {
                names.push(text.clone());
            }
        }
    }
    let outputs = keys.get("function").and_then(|entry| entry.node.value.as_table()).unwrap_or_default();
    names.extend(outputs.iter().map(|entry| entry.name.clone()));
    names.retain(|name| !name.is_empty());
    names
}

/// Reads only name, text, questions and gates of a study file.
///
/// # Errors
/// The file cannot be read, or is not TOML; problems of its questions and gates.
pub fn read_asked(path: &Path) -> Result<(String, String, Asked), StudyError> {
    let file = path.to_string_lossy().into_owned();
    let text = read_input(path, MAX_FILE_BYTES as u64)?;
    let (root, mut problems) = parse_toml(&file, &text).map_err(|problems| StudyError::Problems(vec![problems]))?;
    let asked = Keys::at(&root, "", &mut problems).map(|keys| Asked::read(&keys, &mut problems));
    problems.finish().map_err(|problems| StudyError::Problems(vec![problems]))?;
    Ok((file, text, asked.unwrap_or_default()))
}

/// The tables of an array of tables.
fn items<'a>(entry: Option<&'a Entry>, name: &str, problems: &mut Collector<'_>) -> &'a [Node] {
    let Some(entry) = entry else { return &[] };
    let Value::Array(items) = &entry.node.value else {
        wrong_type(&entry.node, name, &format!("an array of tables: [[{name}]]"), problems);
        return &[];
    };
    if let Some(surplus) = items.get(MOST) {
        let message = format!("{} of them", items.len());
        problems.add(surplus.span.clone(), name, message).allowed = Some(format!("at most {MOST}"));
        return &[];
    }
    items
}

fn question(keys: &Keys<'_>, problems: &mut Collector<'_>) -> AskedQuestion {
    let before = problems.count();
    keys.refuse_unknown(&crate::keys::names("[[question]]"), problems);
    let name = "name = \"overload\": letters, digits, `_` and `-`";
    keys.require("name", name, problems);
    let mut words = |name: &str| placed_text(keys, name, problems);
    let mut question = AskedQuestion {
        span: keys.span(),
        is_partly: false,
        name: words("name"),
        probability: words("probability"),
        of: words("of"),
        mean: words("mean"),
        exceedance: words("exceedance"),
        sensitivity: words("sensitivity"),
        method: words("method"),
        fragility: words("fragility"),
        vary: words("vary"),
        ..AskedQuestion::default()
    };
    question.quantile = placed_number(keys, "quantile", problems);
    question.confidence = placed_number(keys, "confidence", problems);
    question.difference = pair(keys, "difference", "two values of what `vary` names: [\"a\", \"b\"]", problems);
    question.map = pair(keys, "map", "two parameters: [\"contact.gap\", \"contact.friction\"]", problems);
    question.has_map = keys.get("map").is_some();
    question.is_partly = problems.count() > before;
    question
}

fn gate(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<AskedGate> {
    keys.refuse_unknown(&crate::keys::names("[[gate]]"), problems);
    keys.require("require", "require = \"P(max_bearing_load_N > 1.2 MN) < 1e-2\"", problems);
    let require = placed_text(keys, "require", problems);
    let confidence = placed_number(keys, "confidence", problems);
    Some(AskedGate { require: require?, confidence })
}

fn placed_text(keys: &Keys<'_>, name: &str, problems: &mut Collector<'_>) -> Option<Placed<String>> {
    let entry = keys.get(name)?;
    let value = keys.text(entry, problems)?.to_owned();
    Some(Placed { value, span: entry.node.span.clone() })
}

fn placed_number(keys: &Keys<'_>, name: &str, problems: &mut Collector<'_>) -> Option<Placed<f64>> {
    let entry = keys.get(name)?;
    let span = entry.node.span.clone();
    match entry.node.value.as_number() {
        Some(value) => Some(Placed { value, span }),
        None => {
            wrong_type(&entry.node, &keys.key(name), "a number between 0 and 1", problems);
            None
        }
    }
}

/// Two values as texts: of a parameter (`difference`), or names (`map`).
fn pair(keys: &Keys<'_>, name: &str, allowed: &str, problems: &mut Collector<'_>) -> Option<Placed<[String; 2]>> {
    let entry = keys.get(name)?;
    let texts: Vec<String> = match &entry.node.value {
        Value::Array(items) => items.iter().map_while(|item| scalar_text(&item.value)).collect(),
        _ => Vec::new(),
    };
    let given = if let Value::Array(items) = &entry.node.value { items.len() } else { 0 };
    match <[String; 2]>::try_from(texts) {
        Ok(value) if given == 2 => Some(Placed { value, span: entry.node.span.clone() }),
        _ => {
            wrong_type(&entry.node, &keys.key(name), allowed, problems);
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Asked, String) {
        let (root, _) = parse_toml("s.toml", text).expect("TOML");
        let mut problems = Collector::new("s.toml", text);
        let keys = Keys::at(&root, "", &mut problems).expect("a table");
        let asked = Asked::read(&keys, &mut problems);
        (asked, problems.finish().map_or_else(|problems| problems.to_string(), |()| String::new()))
    }

    #[test]
    fn keys_are_read_with_their_places() {
        let text = "[[question]]\nname = \"overload\"\nprobability = 'y > 1'\nconfidence = 0.9\n\n[[question]]\nname = \"less\"\n\
                    mean = \"y\\u0020\"\ndifference = [\"1 mm\", 2e-3]\nvary = \"gap\"\n\n[[gate]]\nrequire = \"\"\"\nP(y > 1) < 0.1\"\"\"\n";
        let (asked, problems) = read(text);
        assert_eq!(problems, "");
        let first = &asked.questions[0];
        let formula = first.probability.as_ref().expect("there");
        assert_eq!((formula.value.as_str(), &text[formula.span.clone()]), ("y > 1", "'y > 1'"));
        assert_eq!((first.confidence.as_ref().map(|placed| placed.value), first.is_partly), (Some(0.9), false));
        let second = &asked.questions[1];
        assert_eq!(second.difference.as_ref().expect("there").value, ["1 mm", "0.002"]);
        assert_eq!(asked.gates[0].require.value, "P(y > 1) < 0.1");
        assert_eq!(&text[second.place("quantile")].trim(), &"[[question]]");
    }

    #[test]
    fn every_mistake_is_told_at_once() {
        let (asked, problems) = read(
            "[[question]]\nname = 3\nprobabilty = \"y > 1\"\nconfidence = \"a\"\n\n[[question]]\nname = \"a\"\nmean = \"y\"\n\
             difference = [\"a\"]\n\n[[question]]\nname = \"A\"\nmean = \"y\"\n\n[[gate]]\nconfidence = true\n",
        );
        assert_eq!((asked.questions.len(), asked.gates.len()), (3, 0));
        assert!(asked.questions[0].is_partly && asked.questions[1].is_partly && !asked.questions[2].is_partly);
        for part in [
            "s.toml:2:8: question[0].name = 3: is a whole number, not a string",
            "question[0].probabilty: unknown key",
            "did you mean `probability`?",
            "question[0].confidence = \"a\": is a string, not a number between 0 and 1",
            "question[1].difference",
            "question[2].name: another question has the name `A`",
            "gate[0].require: missing",
            "gate[0].confidence = true",
        ] {
            assert!(problems.contains(part), "{part}\nin\n{problems}");
        }
    }
}
