//! Differences between the study of a directory and the present one, in words.

use super::columns::own_columns;
use super::directory::STUDY;
use super::error::Change;
use super::prepare::{Prepared, SAMPLES_KEY};
use super::provenance::EXPONENTIAL;
use crate::engine_choice::as_planned;
use crate::version::VERSIONS;
use bladeoff_core::NUMERICS_VERSION;
use bladeoff_model::machine::ParamValue;
use bladeoff_study::{FrozenFiles, Origin, Parameter, SampleKeys, Samples, Study, Varied, load_frozen, show};
use bladeoff_system::folder::Folder;
use bladeoff_system::shown;
use bladeoff_worker::job_spec::{BASIS_FILE, MOST_BASIS};
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of axis values that are printed in full.
const SHOWN_VALUES: u64 = 6;
/// Largest number of listed differences.
const SHOWN_CHANGES: usize = 20;

/// Lists the differences that affect samples; `header`: header of the directory's record, empty if it is lost.
pub(super) fn changes(folder: &Folder, prepared: &Prepared<'_>, header: &BTreeMap<String, String>) -> Vec<Change> {
    let directory = folder.path();
    let mut found = Vec::new();
    let present: BTreeMap<String, String> = prepared.header().into_iter().collect();
    let mut compare = |key: &str, shown: &str| {
        let value = |pairs: &BTreeMap<String, String>| pairs.get(key).cloned().unwrap_or_else(|| "none".to_owned());
        let (from, to) = (value(header), value(&present));
        if !header.is_empty() && from != to {
            found.push(Change { key: shown.to_owned(), from, to });
        }
    };
    compare("numerics_version", "numerics version of the program");
    // only studies of that engine name it; another engine is a difference of its own
    if header.contains_key(EXPONENTIAL) && present.contains_key(EXPONENTIAL) {
        compare(EXPONENTIAL, "revision of the exponential engine of the program");
    }
    compare("scale", "--scale");
    compare("limit", "--limit");
    // of all combinations the seed chooses none
    if prepared.samples.limit().is_some() || header.contains_key("limit") || prepared.samples.layout().is_some() {
        compare("seed", "seed");
    }
    match load_frozen(FrozenFiles::of(directory), own_columns) {
        Ok(mut old) => {
            as_planned(&mut old, directory);
            found.extend(study_changes(&old, prepared.samples.study()));
            found.extend(fewer_points(&old, prepared.samples.study()));
            if has_other_keys(old, folder, header) {
                found.push(Change {
                    key: "keys of the samples".to_owned(),
                    from: "from an earlier build with other keys of machine files".to_owned(),
                    to: "of this build".to_owned(),
                });
            }
        }
        Err(_) => found.push(Change {
            key: shown(directory.join(STUDY)),
            from: "cannot be read any more".to_owned(),
            to: "compared only by the keys of the samples".to_owned(),
        }),
    }
    if found.is_empty() {
        compare_rest(&mut found, header, &present);
    }
    let more = found.len().saturating_sub(SHOWN_CHANGES);
    if more > 0 {
        found.truncate(SHOWN_CHANGES);
        found.push(Change { key: "and".to_owned(), from: format!("{more} more"), to: "...".to_owned() });
    }
    found
}

/// Whether the record of the same study has other sample keys than this build.
fn has_other_keys(old: Study, directory: &Folder, header: &BTreeMap<String, String>) -> bool {
    let says = |key: &str, value: String| header.get(key) == Some(&value);
    let is_its_study = says("study_blake3", blake3::hash(old.text.as_bytes()).to_hex().to_string())
        && old
            .machine()
            .is_some_and(|machine| says("machine_blake3", blake3::hash(machine.text.as_bytes()).to_hex().to_string()))
        && says("numerics_version", NUMERICS_VERSION.to_string());
    let part = |key: &str| header.get(key).map(String::as_str);
    let scale = part("scale").and_then(|scale| scale.parse().ok());
    let limit = part("limit").and_then(|limit| limit.parse().ok());
    let (Ok(samples), Ok(basis)) = (Samples::new(old, scale, limit), directory.place(BASIS_FILE).read(MOST_BASIS))
    else {
        return false;
    };
    let is_its_basis = says("basis_blake3", blake3::hash(&basis).to_hex().to_string());
    is_its_study && is_its_basis && !says(SAMPLES_KEY, SampleKeys::new(&samples, VERSIONS, &basis).digest())
}

/// Compares everything that is not a parameter.
fn compare_rest(found: &mut Vec<Change>, header: &BTreeMap<String, String>, present: &BTreeMap<String, String>) {
    let hashed = [
        ("machine_blake3", "tables of the machine or their order"),
        ("basis_blake3", "reduced basis"),
        ("points_blake3", "points file"),
    ];
    let mut hashed: Vec<(String, String)> = hashed.map(|(key, shown)| (key.to_owned(), shown.to_owned())).into();
    let files = header.keys().chain(present.keys()).filter(|key| key.starts_with("empirical_"));
    let files: BTreeSet<&String> = files.collect();
    hashed.extend(files.into_iter().map(|key| (key.clone(), format!("file of an empirical distribution ({key})"))));
    // finally the file itself, which contains everything
    hashed.push(("study_blake3".to_owned(), "study file".to_owned()));
    for (key, shown) in &hashed {
        if key == "study_blake3" && !found.is_empty() {
            break;
        }
        let short = |pairs: &BTreeMap<String, String>| {
            pairs.get(key.as_str()).map_or("none".to_owned(), |hash| hash.chars().take(12).collect())
        };
        let (from, to) = (short(header), short(present));
        if from != to {
            found.push(Change { key: shown.to_owned(), from, to });
        }
    }
}

/// Parameters with another value or other values along their axis.
#[must_use]
pub fn study_changes(old: &Study, new: &Study) -> Vec<Change> {
    let (then, now) = (described(old), described(new));
    let paths: BTreeSet<&String> = then.keys().chain(now.keys()).collect();
    let text = |values: &BTreeMap<String, String>, path: &String| {
        values.get(path).cloned().unwrap_or_else(|| "not there".to_owned())
    };
    let changed = paths.into_iter().filter(|path| then.get(*path) != now.get(*path));
    changed.map(|path| Change { key: path.clone(), from: text(&then, path), to: text(&now, path) }).collect()
}

/// Lost points of the design. Additional points are no difference.
fn fewer_points(old: &Study, new: &Study) -> Option<Change> {
    let points = |study: &Study| {
        study.sampled.values.layout().map(|layout| (layout.kind(), layout.replicates(), layout.count()))
    };
    let ((kind, replicates, from), (new_kind, now, to)) = points(old).zip(points(new))?;
    let change = Change { key: "points of the design".to_owned(), from: from.to_string(), to: to.to_string() };
    // Another kind or other replicates keep no point.
    (to < from && (kind, replicates) == (new_kind, now)).then_some(change)
}

/// Settings that determine the points of a design, except their number.
fn design_in_words(study: &Study) -> Vec<(&'static str, String)> {
    let Some(layout) = study.sampled.values.layout() else { return Vec::new() };
    let of_law = |parameter: &Parameter| matches!(parameter.origin, Origin::Uncertain(_));
    let order: Vec<&str> = study.parameters().iter().filter(|p| of_law(p)).map(|p| p.info.path.as_str()).collect();
    let mut all = vec![
        ("design.kind", layout.kind().word().to_owned()),
        ("design.replicates", layout.replicates().to_string()),
        ("design.scramble", layout.is_scrambled().to_string()),
        ("order of [[uncertain]]", order.join(", ")),
        ("[[correlation]]", study.sampled.correlated.join("; ")),
    ];
    if let Some(trajectories) = layout.trajectories() {
        all.push(("step of the trajectories (design.levels)", trajectories.delta().to_string()));
    }
    if let Some(saltelli) = layout.saltelli() {
        all.push(("design.second_order", saltelli.has_second_order().to_string()));
    }
    all
}

/// Parameters with their values.
fn described(study: &Study) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    if let Some(machine) = study.machine() {
        all.extend(machine.def.paths().into_iter().map(|info| (info.path, info.shown)));
        all.extend(machine.def.texts().map(|(path, text)| (path.to_owned(), text.to_owned())));
    }
    if let Some(model) = study.function() {
        all.extend(model.outputs.iter().map(|output| (format!("function.{}", output.name), output.text.clone())));
    }
    for (number, parameter) in study.parameters().iter().enumerate() {
        match parameter.origin {
            Origin::Uncertain(_) => {
                let said = &study.sampled.distributions[number];
                all.insert(parameter.info.path.clone(), said.clone());
            }
            Origin::Derived(formula) => {
                all.insert(parameter.info.path.clone(), study.sampled.formulas[formula].clone());
            }
            Origin::Varied(..) => {}
        }
    }
    for axis in &study.axes {
        for varied in &axis.varied {
            all.insert(varied.info.path.clone(), values(varied, axis.length));
        }
    }
    all.extend(design_in_words(study).into_iter().map(|(key, said)| (key.to_owned(), said)));
    if let Some(twin) = &study.twin {
        all.insert("twin_share".to_owned(), twin.to_string());
    }
    all
}

fn values(varied: &Varied, length: u64) -> String {
    let at = |position| show(&varied.info, &varied.values.at(position));
    if length <= SHOWN_VALUES {
        return (0..length).map(at).collect::<Vec<_>>().join(", ");
    }
    let mut hasher = blake3::Hasher::new();
    (0..length).for_each(|position| {
        match varied.values.at(position) {
            ParamValue::Number(number) => hasher.update(&number.to_bits().to_le_bytes()),
            ParamValue::Choice(word) => hasher.update(word.as_bytes()).update(b","),
        };
    });
    let mark: String = hasher.finalize().to_hex().chars().take(6).collect();
    format!("{length} values, {}, {} ... {} (hash {mark})", at(0), at(1), at(length - 1))
}
