//! Parameter paths: what they are, how a shortened one finds its parameter.

use thiserror::Error;

use super::def::MachineDef;
use super::layout::{Origin, Scalar};
use super::schema::{Kind, Need, Range, keys};
use super::value::ParamValue;
use crate::document::units::format_digits;
use crate::document::{cut, nearest};

/// What a parameter holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// A number with the unit of its [`PathInfo`].
    Number,
    /// A whole number.
    Count,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// A number or one of some words.
    NumberOrChoice(&'static [&'static str]),
}

/// One parameter of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct PathInfo {
    /// Full path.
    pub path: String,
    /// SI unit, "" for a pure number, count or word.
    pub unit: &'static str,
    /// What it holds.
    pub kind: PathKind,
    /// Present value; `None`: not given, see `shown`.
    pub value: Option<ParamValue>,
    /// Present value in a readable unit, or what holds without one in parentheses.
    pub shown: String,
    /// Meaning in one sentence.
    pub meaning: &'static str,
    /// Allowed values in words.
    pub allowed: String,
    /// Allowed numbers.
    pub range: Range,
    /// Whether the value is the format's default.
    pub default: bool,
}

impl PathInfo {
    /// Name of the result column of this parameter: the full path with the SI unit appended.
    #[must_use]
    pub fn column(&self) -> String {
        let unit: String = self.unit.chars().filter(|c| *c != ' ').map(|c| if c == '/' { '_' } else { c }).collect();
        if unit.is_empty() { self.path.clone() } else { format!("{}_{unit}", self.path) }
    }
}

/// Why a path finds no parameter.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PathError {
    /// Several parameters end so.
    #[error("`{given}` is ambiguous; it may be {}", some_of(candidates))]
    Ambiguous {
        /// What was given.
        given: String,
        /// Full paths that end so.
        candidates: Vec<String>,
    },
    /// No parameter ends so.
    #[error("this machine has no parameter `{given}`{}", nearest.as_ref().map_or_else(String::new, |path| format!("; did you mean `{path}`?")))]
    Unknown {
        /// What was given.
        given: String,
        /// The path most likely meant.
        nearest: Option<String>,
    },
}

/// Most candidates of an ambiguous path that are written out: a machine may have a thousand unbalances.
const SHOWN_CANDIDATES: usize = 20;

/// Paths in words, the first of many.
#[must_use]
pub fn some_of(paths: &[String]) -> String {
    let shown = paths[..paths.len().min(SHOWN_CANDIDATES)].join(", ");
    match paths.len().saturating_sub(SHOWN_CANDIDATES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Every parameter that applies.
pub(super) fn list(def: &MachineDef) -> Vec<PathInfo> {
    (0..def.layout.slots.len()).filter(|&index| def.applies(index)).map(|index| info(def, index)).collect()
}

fn info(def: &MachineDef, index: usize) -> PathInfo {
    let (slot, state) = (&def.layout.slots[index], def.states[index]);
    let unit = slot.key.unit();
    let (value, shown) = match state.scalar {
        Scalar::Number(number) => (Some(ParamValue::Number(number)), format_digits(number, unit, 10)),
        Scalar::Word(word) => (Some(ParamValue::Choice(word.to_owned())), word.to_owned()),
        Scalar::Absent | Scalar::Bad => {
            let instead = match slot.key.need {
                Need::Optional(instead) => instead,
                _ => "not given",
            };
            (None, format!("({instead})"))
        }
    };
    PathInfo {
        path: slot.path.clone(),
        unit,
        kind: match slot.key.kind {
            Kind::Count => PathKind::Count,
            Kind::Choice(words) => PathKind::Choice(words),
            Kind::NumberOr(_, words) => PathKind::NumberOrChoice(words),
            _ => PathKind::Number,
        },
        value,
        shown,
        meaning: slot.key.meaning,
        allowed: slot.allowed(),
        range: slot.range(),
        default: state.origin == Origin::Default,
    }
}

/// Full path, or an ending at a dot that a single parameter has. Parameters that do not apply to the present kinds
/// count only if no other fits: a study may set a kind together with them.
pub(super) fn find(def: &MachineDef, given: &str) -> Result<PathInfo, PathError> {
    let wanted = bracketed(given.trim());
    if let Some(index) = def.layout.find(&wanted) {
        return Ok(info(def, index));
    }
    let slots = &def.layout.slots;
    let ends_so = |path: &str| !wanted.is_empty() && path.strip_suffix(&wanted).is_some_and(|rest| rest.ends_with('.'));
    let mut found: Vec<usize> = (0..slots.len()).filter(|&index| ends_so(&slots[index].path)).collect();
    if found.iter().any(|&index| def.applies(index)) {
        found.retain(|&index| def.applies(index));
    }
    match found[..] {
        [index] => Ok(info(def, index)),
        [] => Err(PathError::Unknown { given: cut(given, 120), nearest: None }),
        _ => Err(PathError::Ambiguous {
            given: given.to_owned(),
            candidates: found.into_iter().map(|index| slots[index].path.clone()).collect(),
        }),
    }
}

/// Whether some machine may have a parameter of this path or ending: judged by the format alone, for a machine of which
/// nothing could be read.
#[must_use]
pub fn is_of_the_format(given: &str) -> bool {
    let wanted = bracketed(given.trim());
    let steps: Vec<&str> = wanted.split('.').collect();
    let place = |step: &str| step.find('[').unwrap_or(step.len());
    let fits = |step: &str, pattern: &str| {
        // A section, or a component: `shaft[0]`, `offset[1]`.
        pattern == "NAME" || step[..place(step)] == pattern[..place(pattern)]
    };
    keys().iter().any(|key| {
        let pattern: Vec<&str> = key.path.split('.').collect();
        steps.len() <= pattern.len()
            && steps.iter().rev().zip(pattern.iter().rev()).all(|(step, part)| fits(step, part))
    })
}

/// As [`find`]; an unknown path comes with the one most likely meant.
pub(super) fn resolve(def: &MachineDef, given: &str) -> Result<PathInfo, PathError> {
    find(def, given).map_err(|error| match error {
        PathError::Unknown { given: shown, .. } => {
            PathError::Unknown { given: shown, nearest: likely(def, &bracketed(given.trim())) }
        }
        other => other,
    })
}

/// `rotor.shaft.0.diameter` as `rotor.shaft[0].diameter`.
fn bracketed(given: &str) -> String {
    let mut path = String::with_capacity(given.len() + 4);
    for step in given.split('.') {
        if !path.is_empty() && !step.is_empty() && step.bytes().all(|byte| byte.is_ascii_digit()) {
            path.push('[');
            path.push_str(step);
            path.push(']');
        } else {
            if !path.is_empty() {
                path.push('.');
            }
            path.push_str(step);
        }
    }
    path
}

/// The path whose ending of as many steps is nearest to the one given.
fn likely(def: &MachineDef, wanted: &str) -> Option<String> {
    if wanted.is_empty() || wanted.len() > 200 {
        return None;
    }
    let steps = wanted.matches('.').count();
    let applying =
        || (0..def.layout.slots.len()).filter(|&i| def.applies(i)).map(|i| def.layout.slots[i].path.as_str());
    // `contact.offset` without its component.
    let component = |path: &&str| {
        path.match_indices(wanted).any(|(at, _)| {
            (at == 0 || path.as_bytes()[at - 1] == b'.')
                && path.as_bytes().get(at + wanted.len()) == Some(&b'[')
                && !path[at + wanted.len()..].contains('.')
        })
    };
    if let Some(path) = applying().find(component) {
        return Some(path.to_owned());
    }
    let ending = |path: &str| path.rmatch_indices('.').nth(steps).map_or(0, |(at, _)| at + 1);
    let endings: Vec<(&str, &str)> = applying().map(|path| (&path[ending(path)..], path)).collect();
    let best = nearest(wanted, endings.iter().map(|(ending, _)| *ending))?;
    endings.iter().find(|(ending, _)| *ending == best).map(|(_, path)| (*path).to_owned())
}
