//! `[[derived]]`: a parameter or a variable computed by a formula of others.

use super::super::derived::{Derived, DerivedError, Variable};
use super::super::parameter::{Origin, Parameter, variable_info};
use super::super::table::Keys;
use super::super::vary::PathTable;
use super::tables;
use bladeoff_model::machine::PathKind;
use bladeoff_text::document::{Collector, MISSING, Node};
use std::ops::Range;

/// A table as read.
pub(super) struct Formula {
    pub parameter: Parameter,
    pub text: String,
    /// Byte range of the formula.
    span: Range<usize>,
}

/// The tables in order; `None`: problems were added.
pub(super) fn read(node: &Node, paths: &PathTable<'_>, problems: &mut Collector<'_>) -> Vec<Option<Formula>> {
    let items = tables(node, "derived", problems);
    items.iter().enumerate().map(|(number, item)| table(number, item, paths, problems)).collect()
}

fn table(number: usize, item: &Node, paths: &PathTable<'_>, problems: &mut Collector<'_>) -> Option<Formula> {
    let keys = Keys::at(item, &format!("derived[{number}]"), problems)?;
    keys.refuse_unknown(&crate::keys::names("[[derived]]"), problems);
    let short = keys.get("as").and_then(|entry| keys.text(entry, problems)).map(str::to_owned);
    let formula = keys.require("formula", "formula = \"cold_gap - growth\"", problems);
    let formula = formula.and_then(|entry| Some((keys.text(entry, problems)?, entry.node.span.clone())));
    let (info, is_variable, place) = match (keys.get("path"), keys.get("name")) {
        (Some(path), None) => (paths.named(path, &keys, problems)?, false, path.node.span.clone()),
        (None, Some(name)) => (variable_info(keys.text(name, problems)?), true, name.node.span.clone()),
        (_, name) => {
            let (span, message) = match name {
                Some(name) => (name.name_span.clone(), "is given together with `path`"),
                None => (keys.span(), MISSING),
            };
            let key = keys.key(if name.is_some() { "name" } else { "path" });
            problems.add(span, key, message).allowed =
                Some("`path` of a parameter, or `name` of a variable for further formulas".to_owned());
            return None;
        }
    };
    if matches!(info.kind, PathKind::Choice(_)) {
        let message = format!("{} takes words, and a formula gives numbers", info.path);
        problems.add(place, keys.key("path"), message);
        return None;
    }
    let (text, span) = formula?;
    let parameter = Parameter { info, short, has_words: false, is_variable, origin: Origin::Derived(number), place };
    Some(Formula { parameter, text: text.to_owned(), span })
}

/// All formulas; `variables`: all variables, those of the formulas last. `None`: problems were added.
pub(super) fn formulas(variables: Vec<Variable>, read: &[Formula], problems: &mut Collector<'_>) -> Option<Derived> {
    let texts: Vec<String> = read.iter().map(|formula| formula.text.clone()).collect();
    let errors = match Derived::new(variables, &texts) {
        Ok(derived) => return Some(derived),
        Err(errors) => errors,
    };
    for error in errors {
        let Formula { text, span, parameter, .. } = &read[error.formula()];
        let Origin::Derived(number) = parameter.origin else { continue };
        let place = match &error {
            DerivedError::Formula { place, .. } => problems.inside(span, text, place),
            DerivedError::Words { .. } | DerivedError::Circle { .. } => span.clone(),
        };
        problems.add(place, format!("derived[{number}].formula"), error.to_string());
    }
    None
}
