//! Parameter paths and their properties.

use thiserror::Error;

use super::schema::{Range, keys};
use super::value::ParamValue;

/// Type of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// A number with the unit of its [`PathInfo`].
    Number,
    /// A whole number.
    Count,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A number or one of these words.
    NumberOrChoice(&'static [&'static str]),
}

/// One parameter of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct PathInfo {
    /// Full path.
    pub path: String,
    /// SI unit, "" for a pure number, count or word.
    pub unit: &'static str,
    /// Type.
    pub kind: PathKind,
    /// Present value; `None`: not given, see `shown`.
    pub value: Option<ParamValue>,
    /// Present value in a readable unit; the effect of a missing value in parentheses.
    pub shown: String,
    /// Meaning in one sentence.
    pub meaning: &'static str,
    /// Description of the allowed values.
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

/// Whether a path is that of a contact detection, which the result table abbreviates because there is one such column.
#[must_use]
pub fn is_detection(path: &str) -> bool {
    path.ends_with(".contact.detection")
}

/// Reason for finding no parameter by a path.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PathError {
    /// Several parameters have this ending.
    #[error("`{given}` is ambiguous; it may be {}", some_of(candidates))]
    Ambiguous {
        /// Path as given.
        given: String,
        /// Full paths with this ending.
        candidates: Vec<String>,
    },
    /// No parameter has this ending.
    #[error("this machine has no parameter `{given}`{}", nearest.as_ref().map_or_else(String::new, |path| format!("; did you mean `{path}`?")))]
    Unknown {
        /// Path as given.
        given: String,
        /// The path most likely meant.
        nearest: Option<String>,
    },
    /// A text of the machine file, which is no parameter.
    #[error(
        "{path} is text ({meaning}), not a parameter: write `{} = \"...\"` {} of the machine file",
        path.rsplit('.').next().unwrap_or(path),
        path.rsplit_once('.').map_or_else(|| "at the top".to_owned(), |(table, _)| format!("in [{table}]"))
    )]
    Text {
        /// Its full path.
        path: String,
        /// Meaning of the text.
        meaning: &'static str,
    },
}

/// Most candidates of an ambiguous path that are listed: a machine may have a thousand unbalances.
const SHOWN_CANDIDATES: usize = 20;

/// Lists paths, up to the first twenty of them.
#[must_use]
pub fn some_of(paths: &[String]) -> String {
    let shown = paths[..paths.len().min(SHOWN_CANDIDATES)].join(", ");
    match paths.len().saturating_sub(SHOWN_CANDIDATES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Whether some machine may have a parameter with this path or ending, judged by the format alone; for a machine file that is
/// unreadable.
#[must_use]
pub fn is_of_the_format(given: &str) -> bool {
    let wanted = bracketed(given.trim());
    let steps: Vec<&str> = wanted.split('.').collect();
    let place = |step: &str| step.find('[').unwrap_or(step.len());
    let fits = |step: &str, pattern: &str| {
        // Sections and components match without their index: `shaft[0]`, `offset[1]`.
        pattern == "NAME" || step[..place(step)] == pattern[..place(pattern)]
    };
    keys().iter().any(|key| {
        let pattern: Vec<&str> = key.path.split('.').collect();
        steps.len() <= pattern.len()
            && steps.iter().rev().zip(pattern.iter().rev()).all(|(step, part)| fits(step, part))
    })
}

/// Writes indices in brackets: `rotor.shaft.0.diameter` becomes `rotor.shaft[0].diameter`.
pub(super) fn bracketed(given: &str) -> String {
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
