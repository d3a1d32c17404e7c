//! Finds a parameter of a machine by its path or the ending of its path.

use super::def::MachineDef;
use super::layout::{Origin, Scalar};
use super::paths::{PathError, PathInfo, PathKind, bracketed};
use super::schema::{Kind, Need, keys};
use super::value::ParamValue;
use bladeoff_text::document::units::format_digits;
use bladeoff_text::document::{cut, nearest};

impl MachineDef {
    /// Every parameter of this machine, including those at their defaults, in the order of the format.
    #[must_use]
    pub fn paths(&self) -> Vec<PathInfo> {
        list(self)
    }

    /// The parameter of a full path, or of an ending that is unique (`contact.gap`).
    ///
    /// # Errors
    /// [`PathError`]: several paths have this ending, or none; or the path is that of a text.
    pub fn resolve(&self, path_or_ending: &str) -> Result<PathInfo, PathError> {
        resolve(self, path_or_ending)
    }

    /// As [`MachineDef::resolve`], but without searching for the path most likely meant, which takes a thousand times longer.
    ///
    /// # Errors
    /// As [`MachineDef::resolve`]; `nearest` is `None`.
    pub fn find(&self, path_or_ending: &str) -> Result<PathInfo, PathError> {
        find(self, path_or_ending)
    }
}

/// Every parameter that applies to the machine.
fn list(def: &MachineDef) -> Vec<PathInfo> {
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

/// Finds a full path, or a unique ending from a dot on. Parameters that do not apply to the present kinds are considered only if no other fits,
/// because a study may set a kind together with them.
fn find(def: &MachineDef, given: &str) -> Result<PathInfo, PathError> {
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

/// As [`find`]; the error for an unknown path has the path most likely meant, or reports that the path is that of a text.
fn resolve(def: &MachineDef, given: &str) -> Result<PathInfo, PathError> {
    find(def, given).map_err(|error| match error {
        PathError::Unknown { given: shown, .. } => {
            let wanted = bracketed(given.trim());
            text(def, &wanted).unwrap_or_else(|| PathError::Unknown { given: shown, nearest: likely(def, &wanted) })
        }
        other => other,
    })
}

/// The text with this path or ending, the first of several, even if the file does not have it.
fn text(def: &MachineDef, wanted: &str) -> Option<PathError> {
    let ends_so = |path: &str| path.strip_suffix(wanted).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'));
    let texts = keys().iter().filter(|key| key.kind == Kind::Text && !wanted.is_empty());
    texts
        .flat_map(|key| match key.path.split_once(".NAME.") {
            None => vec![(key.path.to_owned(), key.meaning)],
            Some((group, name)) => {
                let tables = def.layout.group(group).iter();
                tables.map(|table| (format!("{group}.{}.{name}", table.name), key.meaning)).collect()
            }
        })
        .find(|(path, _)| ends_so(path))
        .map(|(path, meaning)| PathError::Text { path, meaning })
}

/// Paths of a component that is named by its axes, as in other programs: `stiffness.xy`, `stiffness_xy` and `kxy` mean `stiffness[0][1]`, or
/// `stiffness` if that is isotropic; `offset.y` means `offset[1]`.
fn by_axes(wanted: &str) -> Vec<String> {
    const AXES: [(&str, &str); 6] =
        [("xx", "[0][0]"), ("xy", "[0][1]"), ("yx", "[1][0]"), ("yy", "[1][1]"), ("x", "[0]"), ("y", "[1]")];
    let wanted = wanted.to_lowercase();
    let Some((axes, place)) = AXES.into_iter().find(|(axes, _)| wanted.ends_with(axes)) else { return Vec::new() };
    let before = &wanted[..wanted.len() - axes.len()];
    let table = match before.char_indices().last() {
        Some((at, '.' | '_')) if at > 0 => before[..at].to_owned(),
        Some((at, letter @ ('k' | 'c'))) if axes.len() == 2 && (at == 0 || before[..at].ends_with('.')) => {
            format!("{}{}", &before[..at], if letter == 'k' { "stiffness" } else { "damping" })
        }
        _ => return Vec::new(),
    };
    vec![format!("{table}{place}"), table]
}

/// The path whose ending with the same number of segments is most similar.
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
    for of_component in by_axes(wanted) {
        let ends_so =
            |path: &&str| path.strip_suffix(&*of_component).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'));
        if let Some(path) = applying().find(ends_so) {
            return Some(path.to_owned());
        }
    }
    let ending = |path: &str| path.rmatch_indices('.').nth(steps).map_or(0, |(at, _)| at + 1);
    let endings: Vec<(&str, &str)> = applying().map(|path| (&path[ending(path)..], path)).collect();
    let best = nearest(wanted, endings.iter().map(|(ending, _)| *ending))?;
    endings.iter().find(|(ending, _)| *ending == best).map(|(_, path)| (*path).to_owned())
}
