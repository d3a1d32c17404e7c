//! Plan of a study of a machine.

use std::path::Path;

use bladeoff_model::machine::{ENGINE, Engine, ParamValue};
use bladeoff_system::folder::Folder;
use serde::{Deserialize, Serialize};

use super::{BASIS_FILE, JobSpecError, MOST_BASIS, MOST_PLAN, PLAN_FILE, hash, read_file};

pub(super) const FORMAT: &str = "bladeoff work plan";
pub(super) const VERSION: u32 = 1;

/// Data shared by all samples of a study of a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MachineJob {
    /// Name of the machine file, for messages.
    pub machine_file: String,
    /// Text of the machine file.
    pub machine_toml: String,
    /// Overrides of the whole study: full path and value.
    pub fixed: Vec<(String, ParamValue)>,
    /// Varied parameters, in the order of the parameters of a sample.
    pub varied: Vec<Varied>,
    /// Reduced basis as bytes; `None`: no sample needs one.
    pub basis: Option<Vec<u8>>,
}

/// Varied parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Varied {
    /// Full path in the machine.
    pub path: String,
    /// Words that a number represents, by index; `None`: a number in SI.
    pub choices: Option<Vec<String>>,
}

/// Plan in the form of the file. Numbers are text in Rust's shortest form that reads back exactly.
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

impl MachineJob {
    pub(super) fn text(&self) -> String {
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

    /// Reads a plan of this format and version, with the basis beside it.
    pub(super) fn from_bytes(bytes: &[u8], dir: &Folder, path: &Path) -> Result<Self, JobSpecError> {
        let refused = |source| JobSpecError::NotAPlan { path: path.to_path_buf(), source };
        let file: PlanFile = serde_json::from_slice(bytes).map_err(|source| refused(Some(source)))?;
        let mut fixed = Vec::with_capacity(file.fixed.len());
        for Fixed { path: param, number, choice } in file.fixed {
            let value = match (number, choice) {
                (Some(text), None) => match text.parse() {
                    Ok(number) => ParamValue::Number(number),
                    Err(_) => return Err(JobSpecError::Number { path: path.to_path_buf(), text }),
                },
                (None, Some(choice)) => ParamValue::Choice(choice),
                _ => return Err(refused(None)),
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

/// Hash of the basis in the plan of a directory; `None`: no such plan.
#[must_use]
pub fn planned_basis(dir: &Folder) -> Option<String> {
    let text = dir.place(PLAN_FILE).read(MOST_PLAN).ok()?;
    serde_json::from_slice::<PlanFile>(&text).ok()?.basis_blake3
}

/// Engine in the plan of a directory whose machine file names none; `None`: no such plan. A plan without an engine means
/// `reduced`, as before the choice existed.
#[must_use]
pub fn planned_engine(dir: &Folder) -> Option<Engine> {
    let text = dir.place(PLAN_FILE).read(MOST_PLAN).ok()?;
    let file: PlanFile = serde_json::from_slice(&text).ok()?;
    let named = file.fixed.into_iter().rev().find(|fixed| fixed.path == ENGINE).and_then(|fixed| fixed.choice);
    Some(named.and_then(|word| Engine::from_word(&word)).unwrap_or(Engine::Reduced))
}

#[cfg(test)]
pub(super) fn example() -> MachineJob {
    MachineJob {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Names and order of the keys are stored in every result directory, and their hash in its table: a renamed key fails this test.
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
        assert_eq!(MachineJob { varied: varied.into(), ..example() }.text(), text);
    }
}
