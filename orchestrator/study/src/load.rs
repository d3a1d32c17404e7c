//! A study file from its text: every key, path and value checked, all problems of all its files at once.

use super::axis::{Axis, MOST_VARIED};
use super::carried::{Carried, Others, refuse_taken};
use super::definition::Study;
use super::error::StudyError;
use super::input::{InputError, beside, read_frozen, read_input};
use super::kind::{FileKind, kind_of};
use super::limits::Limits;
use super::points::{PointsFile, read_points};
use super::table::{Keys, scalar_text, wrong_type};
use super::twin::TwinShare;
use super::vary::{Given, PathTable, read_vary};
use bladeoff_model::document::{Collector, Entry, MAX_FILE_BYTES, Node, Problems, Value, cut, parse_toml};
use bladeoff_model::machine::{Machine, MachineDef, ParamValue, PathInfo, TWIN};
use bladeoff_system::call::program;
use std::path::{Path, PathBuf};

/// Names of the columns that the table of this machine has whatever varies: no column that is carried along may have one of them.
pub type TakenNames = fn(&Machine) -> Vec<String>;

/// Version of the study format.
pub const STUDY_SCHEMA: i128 = 1;

/// Largest points file.
const MAX_POINTS_BYTES: u64 = 256 << 20;

/// Bytes of the longest path of `[set]`: a table of a long name would be repeated in each of its keys.
const LONGEST_PATH: usize = 512;

const KEYS: [&str; 9] = ["schema", "name", "machine", "seed", "set", "vary", "points", "limits", "twin_share"];

/// Reads and checks a study with its machine and points files.
///
/// # Errors
/// The study file cannot be read; or every problem found in the study, the machine and the points file.
pub fn load(path: &Path, taken: TakenNames) -> Result<Study, StudyError> {
    load_with(path, None, taken)
}

/// Where the files are that a study froze beside itself.
#[derive(Debug, Clone)]
pub struct FrozenFiles {
    /// The machine file.
    pub machine: PathBuf,
    /// The points file, if there is one.
    pub points: PathBuf,
}

/// Reads a study as a result directory keeps it: its machine and points are the frozen ones, whatever it calls them.
///
/// # Errors
/// As [`load`].
pub fn load_frozen(path: &Path, files: FrozenFiles, taken: TakenNames) -> Result<Study, StudyError> {
    load_with(path, Some(files), taken)
}

fn load_with(path: &Path, frozen: Option<FrozenFiles>, taken: TakenNames) -> Result<Study, StudyError> {
    let file = path.to_string_lossy().into_owned();
    let read = if frozen.is_some() { read_frozen } else { read_input };
    let text = read(path, MAX_FILE_BYTES as u64)?;
    let root = parse_toml(&file, &text).map_err(|problems| StudyError::Problems(vec![problems]))?;
    let mut loader = Loader { path, frozen, taken, problems: Collector::new(&file, &text), others: Vec::new() };
    let study = loader.study(&file, &text, &root);
    let mut all = Vec::new();
    if let Err(problems) = loader.problems.finish() {
        all.push(problems);
    }
    all.append(&mut loader.others);
    match study {
        Some(study) if all.is_empty() => Ok(study),
        _ if kind_of(&text) == Some(FileKind::Machine) => Err(StudyError::AMachine { path: path.to_path_buf() }),
        _ => Err(StudyError::Problems(all)),
    }
}

/// A machine file's text and what it says.
struct MachineFile {
    named: String,
    text: String,
    def: MachineDef,
    /// It has mistakes, which were reported: this is what could be read of it.
    partly: bool,
}

struct Loader<'a> {
    path: &'a Path,
    frozen: Option<FrozenFiles>,
    taken: TakenNames,
    problems: Collector<'a>,
    /// Problems of the machine and the points file.
    others: Vec<Problems>,
}

impl Loader<'_> {
    /// `None`: not all of it could be made; every reason is among the problems.
    fn study(&mut self, file: &str, text: &str, root: &Node) -> Option<Study> {
        let keys = Keys::at(root, "", &mut self.problems)?;
        keys.refuse_unknown(&KEYS, &mut self.problems);
        self.schema(&keys);
        let name = self.name(&keys);
        let seed = keys.get("seed").map_or(Some(0), |entry| keys.whole(entry, 0, i64::MAX as u64, &mut self.problems));
        let limits = keys.get("limits").map(|entry| Limits::read(entry, &mut self.problems)).unwrap_or_default();
        let machine = self.machine(&keys);
        let partly = machine.as_ref().is_some_and(|machine| machine.partly);
        let paths = PathTable::new(machine.as_ref().map(|machine| &machine.def), partly);
        let fixed = keys.get("set").map(|entry| self.fixed(entry, &paths)).unwrap_or_default();
        let mut axes = Vec::new();
        let (mut points_text, mut carried, mut others) = (None, Vec::new(), Others::default());
        if let Some(entry) = keys.get("points") {
            let points = self.points(entry, &paths, &mut others);
            if let Some((axis, columns, text)) = points {
                axes.push(axis);
                carried = columns;
                points_text = Some(text);
            }
        }
        if let Some(entry) = keys.get("vary") {
            axes.extend(read_vary(entry, &paths, &mut self.problems));
        }
        paths.refuse_repeated(&mut self.problems);
        let varied: usize = axes.iter().map(|axis| axis.varied.len()).sum();
        // a share of twins is a parameter that varies
        let varied = varied + usize::from(keys.get("twin_share").is_some());
        if varied > MOST_VARIED {
            let message = format!("{varied} parameters vary");
            self.problems.add(keys.span(), "vary", message).allowed = Some(format!("at most {MOST_VARIED}"));
        }
        let mut machine = machine?;
        for (info, value) in &fixed {
            machine.def.set(info, value).expect("type and range were checked when the value was read");
        }
        let twin = keys.get("twin_share").and_then(|entry| {
            if axes.iter().flat_map(|axis| &axis.varied).any(|varied| varied.info.path == TWIN) {
                let message = format!("{TWIN} varies: each sample has its own already");
                self.problems.add(entry.node.span.clone(), "twin_share", message).allowed =
                    Some(format!("twin_share, or {TWIN} in [[vary]] or the points"));
                return None;
            }
            TwinShare::read(entry, &mut machine.def, &mut self.problems)
        });
        if !others.carry.is_empty()
            && let Ok(built) = machine.def.build()
        {
            refuse_taken(&others, &axes, &(self.taken)(&built), &mut self.problems);
        }
        Some(Study {
            file: file.to_owned(),
            text: text.to_owned(),
            name: name?,
            seed: seed?,
            machine_file: machine.named,
            machine_text: machine.text,
            machine: machine.def,
            fixed,
            axes,
            points_text,
            carried,
            limits,
            twin,
        })
    }

    fn schema(&mut self, keys: &Keys<'_>) {
        let allowed = format!("schema = {STUDY_SCHEMA}");
        let Some(entry) = keys.require("schema", &allowed, &mut self.problems) else { return };
        if entry.node.value != Value::Integer(STUDY_SCHEMA) {
            let value = self.problems.excerpt(entry.node.span.clone());
            let problem = self.problems.add(entry.node.span.clone(), "schema", "not a version this program reads");
            problem.value = Some(value);
            problem.allowed = Some(STUDY_SCHEMA.to_string());
        }
    }

    /// `name`, by default the file's; it becomes a folder.
    fn name(&mut self, keys: &Keys<'_>) -> Option<String> {
        let stem = self.path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let (name, span) = match keys.get("name") {
            Some(entry) => (keys.text(entry, &mut self.problems)?.to_owned(), entry.node.span.clone()),
            None => (stem, keys.span()),
        };
        let letter = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
        if name.len() <= 64 && name.starts_with(|c: char| c.is_ascii_alphanumeric()) && name.chars().all(letter) {
            return Some(name);
        }
        let problem = self.problems.add(span, "name", "cannot be the name of a folder of results");
        problem.value = Some(format!("{:?}", cut(&name, 80)));
        problem.allowed = Some("up to 64 letters, digits, `.`, `_` or `-`, the first a letter or digit".to_owned());
        None
    }

    fn machine(&mut self, keys: &Keys<'_>) -> Option<MachineFile> {
        let allowed = "machine = \"machines/NAME.toml\", relative to the study file";
        let entry = keys.require("machine", allowed, &mut self.problems)?;
        let named = keys.text(entry, &mut self.problems)?;
        let (path, text) = self.file(entry, "machine", named, MAX_FILE_BYTES as u64)?;
        let (def, partly) = match MachineDef::parse_partly(&path, &text) {
            Ok(def) => (Some(def), false),
            Err(_) if matches!(kind_of(&text), Some(FileKind::Study(_))) => {
                let problem = self.problems.add(entry.node.span.clone(), "machine", "is a study file, not a machine");
                problem.value = Some(format!("{:?}", cut(named, 120)));
                problem.allowed = Some(allowed.to_owned());
                return None;
            }
            Err((def, problems)) => {
                self.others.push(problems);
                (def, true)
            }
        };
        def.map(|def| MachineFile { named: named.to_owned(), text, def, partly })
    }

    fn points(
        &mut self,
        entry: &Entry,
        paths: &PathTable,
        others: &mut Others,
    ) -> Option<(Axis, Vec<Carried>, String)> {
        let keys = Keys::of(entry, "points", &mut self.problems)?;
        keys.refuse_unknown(&["file", "carry", "ignore"], &mut self.problems);
        *others = Others::read(&keys, &mut self.problems);
        let file = keys.require("file", "file = \"points.csv\", relative to the study file", &mut self.problems)?;
        let named = keys.text(file, &mut self.problems)?;
        let (path, text) = self.file(file, "points.file", named, MAX_POINTS_BYTES)?;
        let place = file.node.span.clone();
        others.refuse_absent(&text, &mut self.problems);
        match read_points(&PointsFile { file: &path, named, place: place.clone(), text: &text, others }, paths) {
            Ok((axis, carried)) => {
                axis.varied.iter().for_each(|varied| paths.used(&varied.info, place.clone(), "points.file"));
                Some((axis, carried, text))
            }
            Err(problems) => {
                self.others.push(problems);
                None
            }
        }
    }

    /// A file named in the study: where it lies and what it says.
    fn file(&mut self, entry: &Entry, key: &str, named: &str, limit: u64) -> Option<(String, String)> {
        let read = |path: &Path| -> Result<_, InputError> {
            let found = match &self.frozen {
                None => beside(path, named)?,
                Some(files) if key == "machine" => files.machine.clone(),
                Some(files) => files.points.clone(),
            };
            let text = if self.frozen.is_some() { read_frozen } else { read_input }(&found, limit)?;
            Ok((found.to_string_lossy().into_owned(), text))
        };
        match read(self.path) {
            Ok(found) => Some(found),
            Err(error) => {
                let message = match std::error::Error::source(&error) {
                    Some(source) => format!("{error}: {source}"),
                    None => error.to_string(),
                };
                self.problems.add(entry.node.span.clone(), key, message).value = Some(format!("{:?}", cut(named, 120)));
                None
            }
        }
    }

    /// `[set]`: quoted paths or nested tables, both mean the same.
    fn fixed(&mut self, entry: &Entry, paths: &PathTable) -> Vec<(PathInfo, ParamValue)> {
        let mut found = Vec::new();
        if let Some(keys) = Keys::of(entry, "set", &mut self.problems) {
            self.fixed_below("", keys.entries(), paths, &mut found);
        }
        found
    }

    /// The overrides of one table. The parser bounds how deep tables lie.
    fn fixed_below(
        &mut self,
        above: &str,
        entries: &[Entry],
        paths: &PathTable,
        found: &mut Vec<(PathInfo, ParamValue)>,
    ) {
        for entry in entries {
            let path = if above.is_empty() { entry.name.clone() } else { format!("{above}.{}", entry.name) };
            let key = format!("set.{}", cut(&path, 120));
            if path.len() > LONGEST_PATH {
                let problem = self.problems.add(entry.name_span.clone(), key, "longer than any parameter's path");
                problem.allowed = Some(format!("a path of `{} paths MACHINE`, or its ending", program()));
                continue;
            }
            if let Value::Table(inner) = &entry.node.value {
                self.fixed_below(&path, inner, paths, found);
                continue;
            }
            let value = Some(self.problems.excerpt(entry.node.span.clone()));
            let at = Given { span: entry.name_span.clone(), key: &key, value };
            let Some(info) = paths.resolve(&path, at, &mut self.problems) else { continue };
            paths.used(&info, entry.name_span.clone(), &key);
            let Some(text) = scalar_text(&entry.node.value) else {
                wrong_type(&entry.node, &key, "a number, a string with a unit or a word", &mut self.problems);
                continue;
            };
            if let Some(value) = paths.value(&info, &text, entry.node.span.clone(), &key, &mut self.problems) {
                found.push((info, value));
            }
        }
    }
}
