//! A study file from its text: every key, path and value checked, all problems of all its files at once.

use super::asked::{Asked, names};
use super::axis::{Axis, MOST_VARIED};
use super::carried::{Carried, Others, refuse_taken};
use super::definition::{MachineSubject, Study, Subject};
use super::derived::Variable;
use super::drawn::{self, Files};
use super::error::StudyError;
use super::frozen::FrozenFiles;
use super::function::{FunctionError, FunctionModel, OWN_COLUMNS};
use super::input::{read_frozen, read_input};
use super::kind::{FileKind, kind_of};
use super::limits::Limits;
use super::named::{NamedFiles, Which};
use super::parameter::Parameter;
use super::points::{PointsFile, read_points};
use super::set::read_set;
use super::table::Keys;
use super::twin::TwinShare;
use super::vary::{PathTable, read_vary};
use bladeoff_model::document::{Collector, Entry, MAX_FILE_BYTES, Node, Problems, Value, cut, parse_toml};
use bladeoff_model::machine::{Machine, MachineDef, TWIN};
use std::path::Path;

/// Names of the columns that the table of this machine has whatever varies: no column that is carried along may have one of them.
pub type TakenNames = fn(&Machine) -> Vec<String>;

/// What questions and gates are checked by.
#[derive(Debug)]
pub struct ToCheck<'a> {
    /// What is asked.
    pub asked: &'a Asked,
    /// The study; `None`: so much in its file is wrong that there is none.
    pub study: Option<&'a Study>,
    /// Its machine, as far as that could be read.
    pub machine: Option<&'a MachineDef>,
    /// It computes formulas and needs no machine.
    pub is_function: bool,
    /// Names that the file gives to what differs from sample to sample and to what is computed, whether or not the rest could be read.
    pub names: &'a [String],
    /// Whether there is a `[design]`, be it a wrong one.
    pub has_design: bool,
}

/// Adds what is wrong with questions and gates: by who knows the table of a study.
pub type CheckAsked = fn(to_check: &ToCheck<'_>, problems: &mut Collector<'_>);

/// Version of the study format.
pub const STUDY_SCHEMA: i128 = 1;

/// Largest points file.
const MAX_POINTS_BYTES: u64 = 256 << 20;

const KEYS: [&str; 17] = [
    "schema",
    "name",
    "model",
    "machine",
    "function",
    "seed",
    "set",
    "vary",
    "points",
    "uncertain",
    "correlation",
    "derived",
    "design",
    "limits",
    "twin_share",
    "question",
    "gate",
];
/// What a study without a machine has no use for.
const OF_MACHINES: [&str; 4] = ["machine", "set", "points", "twin_share"];

/// Reads and checks a study with its machine and points files.
///
/// # Errors
/// The study file cannot be read; or every problem found in the study, the machine and the points file.
pub fn load(path: &Path, taken: TakenNames) -> Result<Study, StudyError> {
    load_with(path, None, taken, |_, _| {})
}

/// As [`load`], with what is asked of the study checked as well.
///
/// # Errors
/// As [`load`]; what is wrong with its questions and gates is among the problems.
pub fn load_checked(path: &Path, taken: TakenNames, check: CheckAsked) -> Result<Study, StudyError> {
    load_with(path, None, taken, check)
}

/// A study by its text. Files that it names lie around `file`.
///
/// # Errors
/// As [`load`].
pub fn load_text(file: &str, text: &str, taken: TakenNames) -> Result<Study, StudyError> {
    read_text(Path::new(file), text, None, taken, |_, _| {})
}

/// Reads a study as a result directory keeps it: its machine and points are the frozen ones, whatever it calls them.
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
    let root = parse_toml(&file, text).map_err(|problems| StudyError::Problems(vec![problems]))?;
    let files = NamedFiles { study: path, frozen };
    let (problems, others, seen) = (Collector::new(&file, text), Vec::new(), Seen::default());
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
    files: NamedFiles<'a>,
    taken: TakenNames,
    problems: Collector<'a>,
    /// Problems of the machine and the points file.
    others: Vec<Problems>,
    seen: Seen,
}

/// What was read, whatever becomes of the study.
#[derive(Default)]
struct Seen {
    asked: Asked,
    machine: Option<MachineDef>,
    is_function: bool,
    names: Vec<String>,
    has_design: bool,
}

impl Loader<'_> {
    /// `None`: not all of it could be made; every reason is among the problems.
    fn study(&mut self, file: &str, text: &str, root: &Node) -> Option<Study> {
        let keys = Keys::at(root, "", &mut self.problems)?;
        keys.refuse_unknown(&KEYS, &mut self.problems);
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
        let is_function = self.is_function(&keys)?;
        let machine = if is_function { None } else { self.machine(&keys) };
        self.seen.is_function = is_function;
        self.seen.machine = machine.as_ref().filter(|_| !asked.is_empty()).map(|machine| machine.def.clone());
        let partly = machine.as_ref().is_some_and(|machine| machine.partly);
        let paths = match is_function {
            true => PathTable::of_function(),
            false => PathTable::new(machine.as_ref().map(|machine| &machine.def), partly),
        };
        let set = keys.get("set").filter(|_| !is_function);
        let fixed = set.map(|entry| read_set(entry, &paths, &mut self.problems)).unwrap_or_default();
        let mut axes = Vec::new();
        let (mut points_text, mut carried, mut others) = (None, Vec::new(), Others::default());
        if let Some(entry) = keys.get("points").filter(|_| !is_function) {
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
        drawn::needs(&keys, &mut self.problems);
        let mut files = Files::new(&self.files, &mut self.others);
        let (drawn, variables) = drawn::read(&keys, &axes, seed.unwrap_or(0), &paths, &mut files, &mut self.problems);
        let empirical_texts = files.texts;
        paths.refuse_repeated(&mut self.problems);
        let function = if is_function { self.function(&keys, variables.as_deref()) } else { None };
        let parameters = drawn.as_ref().map(|drawn| drawn.parameters.as_slice()).unwrap_or_default();
        let told = parameters.iter().filter(|parameter| is_function || !parameter.is_variable).count();
        // a share of twins is a parameter that varies
        let told = told + usize::from(keys.get("twin_share").is_some());
        if told > MOST_VARIED {
            let message = format!("{told} parameters vary");
            self.problems.add(keys.span(), "vary", message).allowed = Some(format!("at most {MOST_VARIED}"));
        }
        let of_design = |name: &&str| !matches!(*name, "replicate" | "block") || keys.get("design").is_some();
        let mut own: Vec<String> = OWN_COLUMNS.into_iter().filter(of_design).map(str::to_owned).collect();
        let mut twin = None;
        let subject = match function {
            Some(function) => Subject::Function(function),
            None => {
                let mut machine = machine?;
                for (info, value) in &fixed {
                    machine.def.set(info, value).expect("type and range were checked when the value was read");
                }
                twin = keys.get("twin_share").and_then(|entry| self.twin(entry, parameters, &mut machine.def));
                if let Ok(built) = machine.def.build() {
                    own.extend((self.taken)(&built));
                }
                Subject::Machine(MachineSubject { file: machine.named, text: machine.text, def: machine.def, fixed })
            }
        };
        refuse_taken(&others, parameters, &own, &mut self.problems);
        self.refuse_columns(parameters, &own);
        Some(Study {
            file: file.to_owned(),
            text: text.to_owned(),
            name: name?,
            seed: seed?,
            subject,
            axes,
            drawn: drawn?,
            design_place: keys.get("design").map_or(0..0, |entry| entry.name_span.clone()),
            points_text,
            empirical_texts,
            carried,
            limits,
            asked,
            twin,
        })
    }

    /// `model`: whether the study computes formulas instead of a machine. `None`: the reason is among the problems.
    fn is_function(&mut self, keys: &Keys<'_>) -> Option<bool> {
        let is_function = match keys.get("model") {
            None => false,
            Some(entry) => match keys.text(entry, &mut self.problems)? {
                "machine" => false,
                "function" => true,
                word => {
                    let nearest = self.problems.nearest(word, ["machine", "function"]);
                    let problem = self.problems.add(entry.node.span.clone(), "model", "not one of its words");
                    problem.value = Some(format!("{:?}", cut(word, 80)));
                    problem.allowed = Some("machine, function".to_owned());
                    problem.nearest = nearest;
                    return None;
                }
            },
        };
        if is_function {
            for entry in OF_MACHINES.iter().filter_map(|name| keys.get(name)) {
                let message = "belongs to a machine, and model = \"function\" has none";
                self.problems.add(entry.name_span.clone(), &entry.name, message);
            }
        } else if let Some(entry) = keys.get("function") {
            let message = "stands without model = \"function\"";
            self.problems.add(entry.name_span.clone(), "function", message).allowed =
                Some("model = \"function\" and [function], or `machine`".to_owned());
        }
        Some(is_function)
    }

    /// `[function]`: what is computed of the variables.
    fn function(&mut self, keys: &Keys<'_>, variables: Option<&[Variable]>) -> Option<FunctionModel> {
        let entry = keys.require("function", "[function] with g = \"3 - x\"", &mut self.problems)?;
        let keys = Keys::of(entry, "function", &mut self.problems)?;
        let mut outputs = Vec::new();
        for entry in keys.entries() {
            let text = keys.text(entry, &mut self.problems)?;
            outputs.push((entry.name.clone(), text.to_owned()));
        }
        match FunctionModel::new(&outputs, variables?) {
            Ok(function) => Some(function),
            Err(errors) => {
                for error in errors {
                    let entry = error.output().and_then(|output| keys.entries().get(output));
                    let (span, key) = match (entry, &error) {
                        (Some(entry), FunctionError::Formula { output, place, .. }) => {
                            let said = &outputs[*output].1;
                            (self.problems.inside(&entry.node.span, said, place), keys.key(&cut(&entry.name, 80)))
                        }
                        (Some(entry), FunctionError::Words { .. }) => {
                            (entry.node.span.clone(), keys.key(&cut(&entry.name, 80)))
                        }
                        (Some(entry), _) => (entry.name_span.clone(), keys.key(&cut(&entry.name, 80))),
                        (None, _) => (keys.span(), "function".to_owned()),
                    };
                    self.problems.add(span, key, error.to_string());
                }
                None
            }
        }
    }

    /// `twin_share`; sets `run.twin` of the machine where it is 0.
    fn twin(&mut self, entry: &Entry, parameters: &[Parameter], machine: &mut MachineDef) -> Option<TwinShare> {
        if parameters.iter().any(|parameter| parameter.info.path == TWIN) {
            let message = format!("{TWIN} varies: each sample has its own already");
            self.problems.add(entry.node.span.clone(), "twin_share", message).allowed =
                Some(format!("twin_share, or {TWIN} in [[vary]] or the points"));
            return None;
        }
        TwinShare::read(entry, machine, &mut self.problems)
    }

    /// Refuses names that give a parameter the column of something else: paths cannot.
    fn refuse_columns(&mut self, parameters: &[Parameter], own: &[String]) {
        let columns: Vec<String> = parameters.iter().map(|parameter| parameter.column().name).collect();
        for (number, parameter) in parameters.iter().enumerate() {
            if !parameter.is_variable && parameter.short.is_none() {
                continue;
            }
            let column = &columns[number];
            // at the later of two, or at the one that has a name to change; two of one name were told of
            let named = |of: usize| parameters[of].is_variable || parameters[of].short.is_some();
            let is_told = |of: usize| parameters[of].shown() == parameter.shown();
            let has = |other: &usize| {
                columns[*other] == *column
                    && !is_told(*other)
                    && (*other < number || (*other > number && !named(*other)))
            };
            let is_own = own.contains(column) || parameter.short.as_ref().is_some_and(|short| own.contains(short));
            let what = match (is_own, (0..columns.len()).find(has)) {
                (true, _) => "the table has a column of its own with this name".to_owned(),
                (_, Some(other)) => format!("{} has the same column", parameters[other].info.path),
                _ => continue,
            };
            let problem = self.problems.add(parameter.place.clone(), parameter.shown(), what);
            problem.value = Some(format!("{column:?}"));
            problem.allowed = Some("another name".to_owned());
        }
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
        let wanted = (Which::Machine, MAX_FILE_BYTES as u64);
        let (path, text) = self.files.read(entry, ("machine", named), wanted, &mut self.problems)?;
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
        let wanted = (Which::Points, MAX_POINTS_BYTES);
        let (path, text) = self.files.read(file, ("points.file", named), wanted, &mut self.problems)?;
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
}
