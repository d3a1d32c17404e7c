//! `[[uncertain]]`: one table for each uncertain parameter or variable.

use super::super::parameter::{Origin, Parameter, variable_info};
use super::super::sampling::layout::MOST_PARAMETERS;
use super::super::table::{Keys, scalar_text, wrong_type};
use super::super::uncertain::{Distribution, Holds, Uncertain, Values, Written};
use super::super::vary::PathTable;
use super::empirical::{Files, Source};
use super::quantity::Quantities;
use super::{Draft, tables};
use bladeoff_model::machine::{ParamValue, PathInfo, PathKind};
use bladeoff_text::document::{Collector, Entry, MISSING, Node, Value, cut};

/// Reads the tables in order.
pub(super) fn read(
    node: &Node,
    paths: &PathTable<'_>,
    files: &mut Files<'_, '_>,
    problems: &mut Collector<'_>,
) -> Vec<Draft> {
    let items = tables(node, "uncertain", problems);
    if let Some(surplus) = items.get(MOST_PARAMETERS) {
        let message = format!("{} parameters are uncertain", items.len());
        problems.add(surplus.span.clone(), "uncertain", message).allowed = Some(format!("at most {MOST_PARAMETERS}"));
        return vec![Draft { parameter: None, law: None, sentence: String::new() }];
    }
    let one = |(number, item)| table(number, item, paths, files, problems);
    items.iter().enumerate().map(one).collect()
}

fn table(
    number: usize,
    item: &Node,
    paths: &PathTable<'_>,
    files: &mut Files<'_, '_>,
    problems: &mut Collector<'_>,
) -> Draft {
    let nothing = Draft { parameter: None, law: None, sentence: String::new() };
    let Some(keys) = Keys::at(item, &format!("uncertain[{number}]"), problems) else { return nothing };
    keys.refuse_unknown(&crate::keys::names("[[uncertain]]"), problems);
    let named = named(&keys, paths, problems);
    let short = keys.get("as").and_then(|entry| keys.text(entry, problems)).map(str::to_owned);
    let distribution = distribution(&keys, problems);
    let Some((info, is_variable, place)) = named else { return nothing };
    let read = distribution.and_then(|distribution| {
        let quantities = Quantities::new(info.unit, is_variable);
        let mut reader = LawReader { keys: &keys, info: &info, is_variable, distribution, quantities };
        reader.law(paths, files, problems)
    });
    let has_words = matches!(&read, Some((law, _)) if law.words().is_some());
    let parameter = Parameter { info, short, has_words, is_variable, origin: Origin::Uncertain(number), place };
    let (law, sentence) = read.map_or((None, String::new()), |(law, sentence)| (Some(law), sentence));
    Draft { parameter: Some(parameter), law, sentence }
}

/// Path or name of an uncertain input, and its position in the file.
fn named(
    keys: &Keys<'_>,
    paths: &PathTable<'_>,
    problems: &mut Collector<'_>,
) -> Option<(PathInfo, bool, std::ops::Range<usize>)> {
    match (keys.get("path"), keys.get("name")) {
        (Some(path), None) => {
            let info = paths.named(path, keys, problems)?;
            Some((info, false, path.node.span.clone()))
        }
        (None, Some(name)) => Some((variable_info(keys.text(name, problems)?), true, name.node.span.clone())),
        (Some(_), Some(name)) => {
            problems.add(name.name_span.clone(), keys.key("name"), "is given together with `path`").allowed =
                Some("`path` of a parameter, or `name` of a variable for formulas; a short name is `as`".to_owned());
            None
        }
        (None, None) => {
            problems.add(keys.span(), keys.key("path"), MISSING).allowed =
                Some("path = \"contact.gap\", or name = \"growth\" of a variable for formulas".to_owned());
            None
        }
    }
}

fn distribution(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<Distribution> {
    let entry = keys.require("distribution", "distribution = \"normal\"", problems)?;
    let word = keys.text(entry, problems)?;
    let found = Distribution::from_word(word);
    if found.is_none() {
        let words = || Distribution::ALL.iter().map(|(word, _)| *word);
        let nearest = problems.nearest(word, words());
        let key = keys.key("distribution");
        let problem = problems.add(entry.node.span.clone(), key, "not an allowed word");
        problem.value = Some(format!("{:?}", cut(word, 80)));
        problem.allowed = Some(words().collect::<Vec<_>>().join(", "));
        problem.nearest = nearest;
    }
    found
}

/// Reader of the keys of a distribution.
struct LawReader<'a> {
    keys: &'a Keys<'a>,
    info: &'a PathInfo,
    is_variable: bool,
    distribution: Distribution,
    quantities: Quantities,
}

impl LawReader<'_> {
    /// The distribution and its description for `check`.
    fn law(
        &mut self,
        paths: &PathTable<'_>,
        files: &mut Files<'_, '_>,
        problems: &mut Collector<'_>,
    ) -> Option<(Uncertain, String)> {
        let is_number = matches!(self.info.kind, PathKind::Number | PathKind::NumberOrChoice(_));
        if !is_number && self.distribution != Distribution::Discrete {
            let entry = self.keys.get("distribution")?;
            let what = if self.info.kind == PathKind::Count { "whole numbers" } else { "words" };
            let message = format!("{} takes {what} only", self.info.path);
            problems.add(entry.node.span.clone(), self.keys.key("distribution"), message).allowed =
                Some("distribution = \"discrete\" with `values`".to_owned());
            return None;
        }
        let mut written = Written::default();
        let mut sound = true;
        let keys = self.keys;
        for entry in keys.entries() {
            let Some(holds) = Distribution::holds(&entry.name) else { continue };
            sound &= self.key(entry, holds, &mut written, paths, problems).is_some();
        }
        if !sound {
            return None;
        }
        if self.distribution == Distribution::Empirical
            && let (Some(file), Some(column)) = (self.keys.get("file"), self.keys.get("column"))
        {
            let source = Source { file, column, keys: self.keys };
            written.values = Some(Values::Numbers(files.column(&source, &mut self.quantities, problems)?));
        }
        let law = Uncertain::new(self.distribution, &written, self.info.unit)
            .map_err(|errors| errors.iter().for_each(|error| self.refuse(error.key(), &error.to_string(), problems)))
            .ok()?;
        if !self.is_variable
            && law.words().is_none()
            && let Err(error) = law.refuse_outside(self.info.range, self.info.unit)
        {
            self.refuse(error.key(), &format!("{error} (for {})", self.info.path), problems);
            return None;
        }
        let sentence = law.sentence(&written, self.info.unit);
        Some((law, sentence))
    }

    /// Reports a mistake at its key, or at the table if the key is missing.
    fn refuse(&self, key: &str, message: &str, problems: &mut Collector<'_>) {
        let span = self.keys.get(key).map_or_else(|| self.keys.span(), |entry| entry.node.span.clone());
        problems.add(span, self.keys.key(key), message);
    }

    fn key(
        &mut self,
        entry: &Entry,
        holds: Holds,
        written: &mut Written,
        paths: &PathTable<'_>,
        problems: &mut Collector<'_>,
    ) -> Option<()> {
        let key = self.keys.key(&entry.name);
        match holds {
            Holds::Quantity => {
                let number = self.quantity(&entry.node, &key, problems)?;
                written.numbers.push((entry.name.clone(), number));
            }
            Holds::Number => {
                let number = pure(&entry.node, &key, problems)?;
                written.numbers.push((entry.name.clone(), number));
            }
            Holds::Text => written.texts.push((entry.name.clone(), self.keys.text(entry, problems)?.to_owned())),
            Holds::Values => written.values = Some(self.values(entry, &key, paths, problems)?),
            Holds::Weights => {
                let Value::Array(items) = &entry.node.value else {
                    wrong_type(&entry.node, &key, "an array of numbers", problems);
                    return None;
                };
                let one = |(at, item)| pure(item, &format!("{key}[{at}]"), problems);
                written.weights = Some(items.iter().enumerate().map(one).collect::<Option<_>>()?);
            }
        }
        Some(())
    }

    /// A number in the unit of the parameter; not necessarily an allowed value (such as a standard deviation).
    fn quantity(&mut self, node: &Node, key: &str, problems: &mut Collector<'_>) -> Option<f64> {
        if let Some(number) = node.value.as_number() {
            return Some(number);
        }
        let Value::Text(text) = &node.value else {
            wrong_type(node, key, "a number or a string with a unit", problems);
            return None;
        };
        let read = self.quantities.quoted(text);
        read.map_err(|(message, nearest)| {
            let value = problems.excerpt(node.span.clone());
            let problem = problems.add(node.span.clone(), key, message);
            problem.value = Some(value);
            problem.nearest = nearest;
        })
        .ok()
    }

    /// Values of the key `values`, each checked against the parameter.
    fn values(
        &mut self,
        entry: &Entry,
        key: &str,
        paths: &PathTable<'_>,
        problems: &mut Collector<'_>,
    ) -> Option<Values> {
        let Value::Array(items) = &entry.node.value else {
            wrong_type(&entry.node, key, "an array of values", problems);
            return None;
        };
        let (mut numbers, mut words) = (Vec::new(), Vec::new());
        for (at, item) in items.iter().enumerate() {
            let key = format!("{key}[{at}]");
            if self.is_variable {
                numbers.push(self.quantity(item, &key, problems)?);
                continue;
            }
            let Some(text) = scalar_text(&item.value) else {
                wrong_type(item, &key, "a number, a string with a unit or a word", problems);
                return None;
            };
            match paths.value(self.info, &text, item.span.clone(), &key, problems)? {
                ParamValue::Number(number) => numbers.push(number),
                ParamValue::Choice(word) => words.push(word),
            }
        }
        match (numbers.is_empty(), words.is_empty()) {
            (false, false) => {
                problems.add(entry.node.span.clone(), key, "mixes numbers and words").allowed =
                    Some("all numbers, or all words".to_owned());
                None
            }
            (_, true) => Some(Values::Numbers(numbers)),
            (true, false) => Some(Values::Words(words)),
        }
    }
}

/// A number without a unit, or a percentage.
fn pure(node: &Node, key: &str, problems: &mut Collector<'_>) -> Option<f64> {
    let number = match &node.value {
        Value::Text(text) => {
            let percent = text.trim().strip_suffix('%').and_then(|number| number.trim_end().parse::<f64>().ok());
            percent.filter(|percent| percent.is_finite()).map(|percent| percent / 100.0)
        }
        value => value.as_number(),
    };
    if number.is_none() {
        wrong_type(node, key, "a number, or one with `%`", problems);
    }
    number
}
