//! Reads a study file from its text: every key, path and value is checked, and all problems of all its files are reported at once.

use super::asked::{Asked, names};
use super::axis::{Axis, MOST_VARIED};
use super::bearing_files::with_tables;
use super::definition::{Fixed, MachineSubject, Study, Subject};
use super::engine::{refuse_auto, settle};
use super::error::{OfRoss, StudyError};
use super::extra_columns::{ExtraColumn, Others, refuse_taken};
use super::file::{self, Files};
use super::frozen::FrozenFiles;
use super::function::OWN_COLUMNS;
use super::input::{read_frozen, read_input};
use super::kind::{FileKind, kind_of};
use super::limits::Limits;
use super::model::{is_function, read_function};
use super::named::{NamedFiles, Which};
use super::parameter::{Parameter, refuse_same};
use super::points::{PointsFile, read_points};
use super::refine::RefineDef;
use super::set::read_set;
use super::stop::StopDef;
use super::table::Keys;
use super::twin::TwinShare;
use super::vary::{PathTable, read_vary};
use bladeoff_model::machine::{Machine, MachineDef, TWIN};
use bladeoff_text::document::{Collector, Entry, MAX_FILE_BYTES, Node, Problems, Value, cut, parse_toml};
use std::path::Path;

/// Names of the columns that every table of this machine has; an extra column must not have one of these names.
pub type TakenNames = fn(&Machine) -> Vec<String>;

/// Input of the check of questions and gates.
#[derive(Debug)]
pub struct ToCheck<'a> {
    /// Questions and gates.
    pub asked: &'a Asked,
    /// The study; `None`: it has too many mistakes.
    pub study: Option<&'a Study>,
    /// The machine, as far as it could be read.
    pub machine: Option<&'a MachineDef>,
    /// Whether the study computes formulas and needs no machine.
    pub is_function: bool,
    /// Names that the file defines for varied and computed values, even if other parts could not be read.
    pub names: &'a [String],
    /// Whether the file has a `[design]`, valid or not.
    pub has_design: bool,
}

/// Adds the problems of questions and gates; implemented by a caller that knows the columns of the table.
pub type CheckAsked = fn(to_check: &ToCheck<'_>, problems: &mut Collector<'_>);

/// Version of the study format.
pub const STUDY_SCHEMA: i128 = 1;

/// Largest points file \[bytes\].
const MAX_POINTS_BYTES: u64 = 256 << 20;

/// Reads and checks a study with its machine and points files.
///
/// # Errors
/// The study file cannot be read; otherwise every problem found in the study, the machine and the points file.
pub fn load(path: &Path, taken: TakenNames) -> Result<Study, StudyError> {
    load_with(path, None, taken, |_, _| {})
}

/// As [`load`], and checks the questions and gates.
///
/// # Errors
/// As [`load`]; the problems include those of questions and gates.
pub fn load_checked(path: &Path, taken: TakenNames, check: CheckAsked) -> Result<Study, StudyError> {
    load_with(path, None, taken, check)
}

/// Reads a study from its text. Files that it names are relative to `file`.
///
/// # Errors
/// As [`load`].
pub fn load_text(file: &str, text: &str, taken: TakenNames) -> Result<Study, StudyError> {
    read_text(Path::new(file), text, None, taken, |_, _| {})
}

/// Reads the study of a result directory: its machine and points are the stored copies, whatever names the study has for them.
///
/// # Errors
/// As [`load`].
pub fn load_frozen(files: FrozenFiles, taken: TakenNames) -> Result<Study, StudyError> {
    load_with(&files.study(), Some(files), taken, |_, _| {})
}

fn load_with(
    path: &Path,
    frozen: Option<FrozenFiles>,
    taken: TakenNames,
    check: CheckAsked,
) -> Result<Study, StudyError> {
    let read = if frozen.is_some() { read_frozen } else { read_input };
    let text = read(path, MAX_FILE_BYTES as u64)?;
    read_text(path, &text, frozen, taken, check)
}

fn read_text(
    path: &Path,
    text: &str,
    frozen: Option<FrozenFiles>,
    taken: TakenNames,
    check: CheckAsked,
) -> Result<Study, StudyError> {
    let file = path.to_string_lossy().into_owned();
    if kind_of(text) == Some(FileKind::Ross) {
        return Err(OfRoss { path: path.to_path_buf() }.into());
    }
    let (root, problems) = parse_toml(&file, text).map_err(|problems| StudyError::Problems(vec![problems]))?;
    let files = NamedFiles { study: path, frozen };
    let (others, seen) = (Vec::new(), Seen::default());
    let mut loader = Loader { path, files, taken, problems, others, seen };
    let study = loader.study(&file, text, &root);
    let Seen { asked, machine, is_function, names, has_design } = std::mem::take(&mut loader.seen);
    if !asked.is_empty() {
        let (study, machine) = (study.as_ref(), machine.as_ref());
        let to_check = ToCheck { asked: &asked, study, machine, is_function, names: &names, has_design };
        check(&to_check, &mut loader.problems);
    }
    let mut all = Vec::new();
    if let Err(problems) = loader.problems.finish() {
        all.push(problems);
    }
    all.append(&mut loader.others);
    match study {
        Some(study) if all.is_empty() => Ok(study),
        _ if kind_of(text) == Some(FileKind::Machine) => Err(StudyError::AMachine { path: path.to_path_buf() }),
        _ => Err(StudyError::Problems(all)),
    }
}

/// Text and content of a machine file.
struct MachineFile {
    named: String,
    text: String,
    def: MachineDef,
    /// Whether `def` is only the readable part of the machine; its mistakes have been reported.
    partly: bool,
}

struct Loader<'a> {
    path: &'a Path,
    files: NamedFiles<'a>,
    taken: TakenNames,
    problems: Collector<'a>,
    /// Problems of the machine and the points file.
    others: Vec<Problems>,
    seen: Seen,
}

/// Parts that were read, even if the study is invalid.
#[derive(Default)]
struct Seen {
    asked: Asked,
    machine: Option<MachineDef>,
    is_function: bool,
    names: Vec<String>,
    has_design: bool,
}

impl Loader<'_> {
    /// `None`: a part is invalid; problems were added.
    fn study(&mut self, file: &str, text: &str, root: &Node) -> Option<Study> {
        let keys = Keys::at(root, "", &mut self.problems)?;
        keys.refuse_unknown(&crate::keys::names(""), &mut self.problems);
        self.schema(&keys);
        let name = self.name(&keys);
        let seed = keys.get("seed").map_or(Some(0), |entry| keys.whole(entry, 0, i64::MAX as u64, &mut self.problems));
        let asked = Asked::read(&keys, &mut self.problems);
        let has_design = keys.get("design").is_some();
        self.seen = Seen { asked: asked.clone(), names: names(&keys), has_design, ..Seen::default() };
        let limits = match keys.get("limits") {
            Some(entry) => Limits::read(entry, !asked.is_empty(), &mut self.problems),
            None => Limits::of(!asked.is_empty()),
        };
        let is_function = is_function(&keys, &mut self.problems)?;
        let machine = if is_function { None } else { self.machine(&keys) };
        self.seen.is_function = is_function;
        self.seen.machine = machine.as_ref().filter(|_| !asked.is_empty()).map(|machine| machine.def.clone());
        let partly = machine.as_ref().is_some_and(|machine| machine.partly);
        let paths = match is_function {
            true => PathTable::of_function(),
            false => PathTable::new(machine.as_ref().map(|machine| &machine.def), partly),
        };
        let paths = match machine.as_ref().filter(|_| keys.get("points").is_some()).map(|machine| machine.def.build()) {
            Some(Ok(built)) => {
                paths.with_own(OWN_COLUMNS.into_iter().map(str::to_owned).chain((self.taken)(&built)).collect())
            }
            _ => paths,
        };
        let set = keys.get("set").filter(|_| !is_function);
        let fixed = set.map(|entry| read_set(entry, &paths, &mut self.problems)).unwrap_or_default();
        let mut axes = Vec::new();
        let (mut points_text, mut extra_columns, mut others) = (None, Vec::new(), Others::default());
        if let Some(entry) = keys.get("points").filter(|_| !is_function) {
            let points = self.points(entry, &paths, &mut others);
            if let Some((axis, columns, text)) = points {
                axes.push(axis);
                extra_columns = columns;
                points_text = Some(text);
            }
        }
        if let Some(entry) = keys.get("vary") {
            axes.extend(read_vary(entry, &paths, &mut self.problems));
        }
        file::needs(&keys, &mut self.problems);
        let mut files = Files::new(&self.files, &mut self.others);
        let (sampled, variables) = file::read(&keys, &axes, seed.unwrap_or(0), &paths, &mut files, &mut self.problems);
        let empirical_texts = files.texts;
        let stop = keys.get("stop").and_then(|entry| {
            let layout = sampled.as_ref().and_then(|sampled| sampled.values.layout());
            StopDef::read(entry, &asked, (has_design, layout), &mut self.problems)
        });
        let refine = keys
            .get("refine")
            .and_then(|entry| RefineDef::read(entry, &asked, keys.get("stop").is_some(), &mut self.problems));
        paths.refuse_repeated(&mut self.problems);
        let function = if is_function { read_function(&keys, variables.as_deref(), &mut self.problems) } else { None };
        let parameters = sampled.as_ref().map(|sampled| sampled.parameters.as_slice()).unwrap_or_default();
        let mut of_samples = parameters.iter().filter(|parameter| is_function || !parameter.is_variable);
        let told = of_samples.clone().count();
        // a share of twins counts as a varied parameter
        let told = told + usize::from(keys.get("twin_share").is_some());
        if told > MOST_VARIED {
            // reported at the first parameter above the limit
            let place = match of_samples.nth(MOST_VARIED) {
                Some(parameter) => (parameter.place.clone(), parameter.key()),
                None => {
                    (keys.get("twin_share").map_or(keys.span(), |entry| entry.name_span.clone()), "twin_share".into())
                }
            };
            let message = format!("{told} parameters differ from sample to sample");
            self.problems.add(place.0, place.1, message).allowed = Some(format!("at most {MOST_VARIED}"));
        }
        let of_design = |name: &&str| !matches!(*name, "replicate" | "block") || keys.get("design").is_some();
        let mut own: Vec<String> = OWN_COLUMNS.into_iter().filter(of_design).map(str::to_owned).collect();
        if is_function {
            refuse_same(parameters, &own, &mut self.problems);
        }
        let mut twin = None;
        let subject = match function {
            Some(function) => Subject::Function(function),
            None => {
                let mut machine = machine?;
                for Fixed { info, value, .. } in &fixed {
                    machine.def.set(info, value).expect("type and range were checked when the value was read");
                }
                let mut engine = None;
                if let Some(sampled) = &sampled {
                    refuse_auto(&axes, sampled, &mut self.problems);
                    engine = settle(&mut machine.def, &axes, sampled);
                }
                twin = keys.get("twin_share").and_then(|entry| self.twin(entry, parameters, &mut machine.def));
                if let Ok(built) = machine.def.build() {
                    own.extend((self.taken)(&built));
                }
                let MachineFile { named, text, def, .. } = machine;
                Subject::Machine(MachineSubject { file: named, text, def, fixed, engine })
            }
        };
        refuse_taken(&others, parameters, &own, &mut self.problems);
        if !is_function {
            refuse_same(parameters, &own, &mut self.problems);
        }
        Some(Study {
            file: file.to_owned(),
            text: text.to_owned(),
            name: name?,
            seed: seed?,
            subject,
            axes,
            sampled: sampled?,
            design_place: keys.get("design").map_or(0..0, |entry| entry.name_span.clone()),
            points_text,
            empirical_texts,
            extra_columns,
            limits,
            asked,
            stop,
            refine,
            twin,
        })
    }

    /// Reads `twin_share`; sets `run.twin` of the machine if it is 0.
    fn twin(&mut self, entry: &Entry, parameters: &[Parameter], machine: &mut MachineDef) -> Option<TwinShare> {
        if parameters.iter().any(|parameter| parameter.info.path == TWIN) {
            let message = format!("{TWIN} varies, so each sample has its own value");
            self.problems.add(entry.node.span.clone(), "twin_share", message).allowed =
                Some(format!("twin_share, or {TWIN} in [[vary]] or the points"));
            return None;
        }
        TwinShare::read(entry, machine, &mut self.problems)
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

    /// `name`, by default that of the file; used as the name of a folder.
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
        let wanted = (Which::Machine, MAX_FILE_BYTES as u64);
        let (path, text) = self.files.read(entry, ("machine", named), wanted, &mut self.problems)?;
        let text = match with_tables(Path::new(&path), text) {
            Ok(text) => text,
            Err(problems) => {
                self.others.push(problems);
                return None;
            }
        };
        let (def, partly) = match MachineDef::parse_partly(&path, &text) {
            Ok(def) => (Some(def), false),
            Err(_) if kind_of(&text) == Some(FileKind::Ross) => {
                let problem = self.problems.add(
                    entry.node.span.clone(),
                    "machine",
                    "is a rotor saved by ROSS, not a machine file",
                );
                problem.value = Some(format!("{:?}", cut(named, 120)));
                problem.allowed = Some(format!("{allowed}; `bladeoff import ross` makes a machine file of it"));
                return None;
            }
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
    ) -> Option<(Axis, Vec<ExtraColumn>, String)> {
        let keys = Keys::of(entry, "points", &mut self.problems)?;
        keys.refuse_unknown(&crate::keys::names("[points]"), &mut self.problems);
        *others = Others::read(&keys, &mut self.problems);
        let file = keys.require("file", "file = \"points.csv\", relative to the study file", &mut self.problems)?;
        let named = keys.text(file, &mut self.problems)?;
        let wanted = (Which::Points, MAX_POINTS_BYTES);
        let (path, text) = self.files.read(file, ("points.file", named), wanted, &mut self.problems)?;
        let place = file.node.span.clone();
        others.refuse_absent(&text, &mut self.problems);
        match read_points(&PointsFile { file: &path, named, place: place.clone(), text: &text, others }, paths) {
            Ok((axis, extra_columns)) => {
                axis.varied.iter().for_each(|varied| paths.used(&varied.info, place.clone(), "points.file"));
                Some((axis, extra_columns, text))
            }
            Err(problems) => {
                self.others.push(problems);
                None
            }
        }
    }
}
