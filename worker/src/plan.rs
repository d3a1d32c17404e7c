//! The frozen work plan: everything a worker needs beside sample numbers and parameter values.
//!
//! The orchestrator writes it into the result directory before the first worker starts; every worker checks its hash, which
//! it was given on its command line, and with it that of the basis file. So all samples of a result directory come from
//! one plan, whatever happens to the files a study was read from.

use std::path::{Path, PathBuf};

use bladeoff_model::machine::ParamValue;
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use bladeoff_system::shown;
use serde::{Deserialize, Serialize};

/// Name of the plan in a result directory.
pub const PLAN_FILE: &str = "plan.json";
/// Name of the frozen basis in a result directory.
pub const BASIS_FILE: &str = "basis.bin";
/// Largest plan that is read.
const MOST_PLAN: u64 = 64 << 20;
/// Largest basis that is read.
pub const MOST_BASIS: u64 = 256 << 20;
const FORMAT: &str = "bladeoff work plan";
const VERSION: u32 = 1;

/// What all samples of a study share.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorkPlan {
    /// Name of the machine file, for messages.
    pub machine_file: String,
    /// Text of the machine file.
    pub machine_toml: String,
    /// Overrides of the whole study: full path and value.
    pub fixed: Vec<(String, ParamValue)>,
    /// What varies, in the order of the parameters of a sample.
    pub varied: Vec<Varied>,
    /// The reduced basis as bytes; `None` if no sample needs one.
    pub basis: Option<Vec<u8>>,
}

/// A parameter that differs from sample to sample.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Varied {
    /// Full path in the machine.
    pub path: String,
    /// The words a number stands for, by index; `None` for a number in SI.
    pub choices: Option<Vec<String>>,
}

/// Why a plan could not be written, or read as the one expected.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not the one the run was started with.
    #[error("{} has changed: blake3 {found}, expected {expected}", shown(path))]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// The hash it should have.
        expected: String,
    },
    /// The file is not a plan of this version.
    #[error("{} is not a {FORMAT} of version {VERSION}", shown(path))]
    NotAPlan {
        /// The file.
        path: PathBuf,
        /// Where reading failed; `None` if it is another format or version.
        #[source]
        source: Option<serde_json::Error>,
    },
    /// A number in the plan cannot be read.
    #[error("{}: {text:?} is not a number", shown(path))]
    Number {
        /// The file.
        path: PathBuf,
        /// What stands there.
        text: String,
    },
}

/// The plan as it is in the file. Numbers are text in Rust's shortest form that reads back exactly.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    format: String,
    version: u32,
    machine_file: String,
    machine_toml: String,
    fixed: Vec<Fixed>,
    varied: Vec<Varied>,
    basis_blake3: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fixed {
    path: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    number: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    choice: Option<String>,
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl WorkPlan {
    /// The hash [`write`](WorkPlan::write) would return: the same for the same plan.
    #[must_use]
    pub fn hash(&self) -> String {
        hash(self.text().as_bytes())
    }

    fn text(&self) -> String {
        let fixed = self.fixed.iter().map(|(path, value)| {
            let (number, choice) = match value {
                ParamValue::Number(number) => (Some(format!("{number:?}")), None),
                ParamValue::Choice(choice) => (None, Some(choice.clone())),
            };
            Fixed { path: path.clone(), number, choice }
        });
        let file = PlanFile {
            format: FORMAT.to_owned(),
            version: VERSION,
            machine_file: self.machine_file.clone(),
            machine_toml: self.machine_toml.clone(),
            fixed: fixed.collect(),
            varied: self.varied.clone(),
            basis_blake3: self.basis.as_deref().map(hash),
        };
        let mut text = serde_json::to_string_pretty(&file).expect("text and lists always have a JSON form");
        text.push('\n');
        text
    }

    /// Writes plan and basis into a result directory, durably, and returns the plan's hash.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn write(&self, dir: &Folder) -> Result<String, PlanFileError> {
        if let Some(basis) = &self.basis {
            write_whole(dir.place(BASIS_FILE), basis)?;
        }
        let text = self.text();
        write_whole(dir.place(PLAN_FILE), text.as_bytes())?;
        Ok(hash(text.as_bytes()))
    }

    /// Reads the plan of a result directory, which must be the one with this hash.
    ///
    /// # Errors
    /// A file that is not there, has changed, or is of another version.
    pub fn read(dir: &Path, expected: &str) -> Result<Self, PlanFileError> {
        Self::read_in(&Folder::open(dir).map_err(FileError::at("open", dir))?, expected)
    }

    /// The same in an open directory.
    ///
    /// # Errors
    /// As [`WorkPlan::read`].
    pub fn read_in(dir: &Folder, expected: &str) -> Result<Self, PlanFileError> {
        let place = dir.place(PLAN_FILE);
        let path = place.to_path_buf();
        let file: PlanFile = serde_json::from_slice(&read_file(&place, MOST_PLAN, expected)?)
            .map_err(|source| PlanFileError::NotAPlan { path: path.clone(), source: Some(source) })?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(PlanFileError::NotAPlan { path, source: None });
        }
        let mut fixed = Vec::with_capacity(file.fixed.len());
        for Fixed { path: param, number, choice } in file.fixed {
            let value = match (number, choice) {
                (Some(text), None) => match text.parse() {
                    Ok(number) => ParamValue::Number(number),
                    Err(_) => return Err(PlanFileError::Number { path, text }),
                },
                (None, Some(choice)) => ParamValue::Choice(choice),
                _ => return Err(PlanFileError::NotAPlan { path, source: None }),
            };
            fixed.push((param, value));
        }
        let basis = match &file.basis_blake3 {
            Some(expected) => Some(read_file(&dir.place(BASIS_FILE), MOST_BASIS, expected)?),
            None => None,
        };
        let PlanFile { machine_file, machine_toml, varied, .. } = file;
        Ok(Self { machine_file, machine_toml, fixed, varied, basis })
    }
}

/// The hash of the basis that the plan of a directory was written with; `None` where there is no such plan.
#[must_use]
pub fn planned_basis(dir: &Folder) -> Option<String> {
    let text = dir.place(PLAN_FILE).read(MOST_PLAN).ok()?;
    serde_json::from_slice::<PlanFile>(&text).ok()?.basis_blake3
}

fn read_file(path: &Place, limit: u64, expected: &str) -> Result<Vec<u8>, PlanFileError> {
    let bytes = path.read(limit)?;
    let found = hash(&bytes);
    if found != expected {
        return Err(PlanFileError::Changed { path: path.to_path_buf(), found, expected: expected.to_owned() });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn example() -> WorkPlan {
        WorkPlan {
            machine_file: "lab_rig.toml".into(),
            machine_toml: "# a comment\n[rotor]\n".into(),
            fixed: vec![
                ("run.end_time".into(), ParamValue::Number(0.1 + 0.2)),
                ("diaphragms.seal.contact.detection".into(), ParamValue::Choice("hyp1".into())),
            ],
            varied: vec![Varied { path: "blade_off.mass".into(), choices: None }],
            basis: Some(vec![1, 2, 3]),
        }
    }

    #[test]
    fn a_plan_reads_back_exactly_and_its_hash_is_its_own() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let hash = example().write(&Folder::open(dir.path()).expect("opened")).expect("written");
        assert_eq!(hash, example().hash());
        assert_eq!(WorkPlan::read(dir.path(), &hash).expect("read"), example());
        let other = WorkPlan { basis: Some(vec![1, 2, 4]), ..example() };
        assert_ne!(other.hash(), hash);
    }

    /// Names and order of the keys are at rest in every result directory, their hash in its table: a rename here shows.
    #[test]
    fn the_text_of_a_plan_is_what_directories_hold() {
        let varied = [
            Varied { path: "blade_off.mass".into(), choices: None },
            Varied { path: "contact.detection".into(), choices: Some(vec!["hyp1".into(), "hyp2".into()]) },
        ];
        let text = r##"{
  "format": "bladeoff work plan",
  "version": 1,
  "machine_file": "lab_rig.toml",
  "machine_toml": "# a comment\n[rotor]\n",
  "fixed": [
    {
      "path": "run.end_time",
      "number": "0.30000000000000004"
    },
    {
      "path": "diaphragms.seal.contact.detection",
      "choice": "hyp1"
    }
  ],
  "varied": [
    {
      "path": "blade_off.mass",
      "choices": null
    },
    {
      "path": "contact.detection",
      "choices": [
        "hyp1",
        "hyp2"
      ]
    }
  ],
  "basis_blake3": "b177ec1bf26dfb3b7010d473e6d44713b29b765b99c6e60ecbfae742de496543"
}
"##;
        assert_eq!(WorkPlan { varied: varied.into(), ..example() }.text(), text);
    }

    #[test]
    fn a_changed_plan_or_basis_is_refused() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let hash = example().write(&Folder::open(dir.path()).expect("opened")).expect("written");
        fs::write(dir.path().join(BASIS_FILE), [9]).expect("written");
        let error = WorkPlan::read(dir.path(), &hash).expect_err("basis changed");
        assert!(matches!(&error, PlanFileError::Changed { path, .. } if path.ends_with(BASIS_FILE)), "{error}");
        let error = WorkPlan::read(dir.path(), "00").expect_err("another plan");
        assert!(matches!(&error, PlanFileError::Changed { path, .. } if path.ends_with(PLAN_FILE)), "{error}");
        let error = WorkPlan::read(&dir.path().join("nowhere"), "00").expect_err("not there");
        assert!(matches!(error, PlanFileError::File(_)), "{error}");
    }
}
