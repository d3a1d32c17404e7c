//! Columns by which two tables match, and columns that are compared. Names from the command line are resolved, and all errors are reported together.

use super::asked::Asked;
use super::error::CompareError;
use super::tolerance::{self, Tolerance};
use crate::tables::{ColumnHead, DETECTION, HeadKind};
use bladeoff_model::machine::is_detection;
use bladeoff_text::document::{cut, nearest, visible};
use std::path::Path;

const SAMPLE: &str = "sample";
const STATUS: &str = "status";
/// Columns that place a point in its design; these are not inputs of a run.
const OF_DESIGN: [&str; 2] = ["replicate", "block"];
/// Columns of a verdict; the columns behind them are results.
const VERDICT: [&str; 3] = [STATUS, "cause", "causes"];

/// Input and result columns of one table.
pub(super) struct Columns {
    inputs: Vec<ColumnHead>,
    results: Vec<ColumnHead>,
}

impl Columns {
    /// # Errors
    /// The file is not a result table.
    pub fn of(heads: Vec<ColumnHead>, path: &Path) -> Result<Self, CompareError> {
        let no = |column| CompareError::NoColumn { path: path.to_path_buf(), column };
        let at = |name: &str| heads.iter().position(|head| head.name == name);
        let status = at(STATUS).ok_or_else(|| no(STATUS))?;
        at(SAMPLE).filter(|sample| *sample < status).ok_or_else(|| no(SAMPLE))?;
        let inputs = heads[..status]
            .iter()
            .filter(|head| head.name != SAMPLE && !OF_DESIGN.contains(&head.name.as_str()))
            .cloned()
            .collect();
        let results = heads[status..].iter().filter(|head| !VERDICT.contains(&head.name.as_str())).cloned().collect();
        Ok(Self { inputs, results })
    }
}

/// Columns for matching and comparison.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// Inputs by which rows match, in the order of A.
    pub by: Vec<ColumnHead>,
    /// Inputs of either table, including ignored ones, in the order of A, then of B.
    pub inputs: Vec<ColumnHead>,
    /// Names of the ignored inputs.
    pub ignored: Vec<String>,
    /// Inputs that only one table has and that are not ignored; if there are any, no row matches.
    pub alone: (Vec<String>, Vec<String>),
    /// Results of both tables.
    pub results: Vec<ColumnHead>,
    /// Results of A alone and of B alone.
    pub only: (Vec<String>, Vec<String>),
    /// Results whose kind or unit differs between the tables.
    pub of_another_kind: Vec<String>,
    /// Tolerances of columns.
    pub tolerances: Vec<Tolerance>,
}

impl Names {
    /// # Errors
    /// Names from the command line that match no column, and invalid tolerances.
    pub fn of(a: &Columns, b: &Columns, asked: &Asked<'_>) -> Result<Self, CompareError> {
        let mut found = Self::default();
        let mut wrong = Vec::new();
        found.inputs = a.inputs.clone();
        let is_new = |head: &&ColumnHead| !a.inputs.iter().any(|known| known.name == head.name);
        found.inputs.extend(b.inputs.iter().filter(is_new).cloned());
        for name in asked.ignore {
            match ignored(name, &found.inputs, a, b) {
                Ok(column) if found.ignored.contains(&column) => {}
                Ok(column) => found.ignored.push(column),
                Err(why) => wrong.push(line("--ignore", name, &why)),
            }
        }
        let is_matched = |head: &&ColumnHead| !found.ignored.contains(&head.name);
        let like = |head: &ColumnHead, others: &[ColumnHead]| others.iter().any(|other| other == head);
        for head in a.inputs.iter().filter(is_matched) {
            if like(head, &b.inputs) { found.by.push(head.clone()) } else { found.alone.0.push(head.name.clone()) }
        }
        let of_b = b.inputs.iter().filter(is_matched).filter(|head| !like(head, &a.inputs));
        found.alone.1 = of_b.map(|head| head.name.clone()).collect();
        for head in &a.results {
            match b.results.iter().find(|other| other.name == head.name) {
                Some(other) if other == head && head.kind != HeadKind::Other => found.results.push(head.clone()),
                Some(_) => found.of_another_kind.push(head.name.clone()),
                None => found.only.0.push(head.name.clone()),
            }
        }
        let of_b = b.results.iter().filter(|head| !a.results.iter().any(|other| other.name == head.name));
        found.only.1 = of_b.map(|head| head.name.clone()).collect();
        for text in asked.tolerances {
            let columns = tolerance::Columns {
                results: &found.results,
                inputs: &found.inputs,
                only: (&found.only.0, &found.only.1),
                of_another_kind: &found.of_another_kind,
            };
            match Tolerance::read(text, columns) {
                Ok(tolerance) => found.tolerances.push(tolerance),
                Err(why) => wrong.push(line("--tolerance", text, &why)),
            }
        }
        if wrong.is_empty() { Ok(found) } else { Err(CompareError::Asked(wrong)) }
    }
}

/// Error message for an option, in one line.
fn line(option: &str, given: &str, why: &str) -> String {
    visible(&format!("{option} {:?}: {why}", cut(given, 80))).into_owned()
}

/// The input that a name refers to: the column name, the name without its unit, or the part of either behind a dot.
fn ignored(name: &str, inputs: &[ColumnHead], a: &Columns, b: &Columns) -> Result<String, String> {
    if let Some(head) = inputs.iter().find(|head| head.name == name) {
        return Ok(head.name.clone());
    }
    if name == SAMPLE {
        return Err("the number of a sample is not an input: rows never match by it".to_owned());
    }
    if OF_DESIGN.contains(&name) {
        return Err("that is a place in the design, not an input: rows never match by it".to_owned());
    }
    if a.results.iter().chain(&b.results).any(|head| head.name == name) || VERDICT.contains(&name) {
        return Err("that is a result; rows match by inputs only".to_owned());
    }
    let aliases = |head: &ColumnHead| {
        let unit: String = head.unit.chars().filter(|c| *c != ' ').map(|c| if c == '/' { '_' } else { c }).collect();
        let path = head.name.strip_suffix(&unit).and_then(|path| path.strip_suffix('_')).unwrap_or(&head.name);
        let endings =
            |name: &str| name.match_indices('.').map(|(dot, _)| name[dot + 1..].to_owned()).collect::<Vec<_>>();
        [vec![path.to_owned()], endings(path), endings(&head.name)].concat()
    };
    let means = |head: &&ColumnHead| {
        let is_of_detection = head.name == DETECTION && (is_detection(name) || name == "contact.detection");
        is_of_detection || aliases(head).iter().any(|alias| alias == name)
    };
    let meant: Vec<&str> = inputs.iter().filter(means).map(|head| head.name.as_str()).collect();
    match meant[..] {
        [one] => Ok(one.to_owned()),
        [] => {
            let all: Vec<String> =
                inputs.iter().flat_map(|head| [vec![head.name.clone()], aliases(head)].concat()).collect();
            let near = nearest(name, all.iter().map(String::as_str));
            let near = near.map(|near| format!("; did you mean {near}?")).unwrap_or_default();
            Err(match inputs.is_empty() {
                true => "neither table has an input that varies".to_owned(),
                false => format!("neither table has such an input{near}"),
            })
        }
        _ => Err(format!("that could be {}", meant.join(" or "))),
    }
}
