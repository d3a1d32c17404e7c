//! Plan of a study of formulas.

use serde::{Deserialize, Serialize};

pub(super) const FORMAT: &str = "bladeoff function plan";
pub(super) const VERSION: u32 = 1;

/// Data shared by all samples of a study of formulas.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FunctionJob {
    /// Variables, in the order of the parameters of a sample.
    pub variables: Vec<Variable>,
    /// Formulas, in the order of the values of an outcome.
    pub formulas: Vec<Formula>,
}

/// Variable of formulas.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Short name, if any.
    pub short: Option<String>,
}

/// Formula.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Formula {
    /// Its name.
    pub name: String,
    /// Text, as in the study.
    pub formula: String,
}

/// Plan in the form of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    format: String,
    version: u32,
    variables: Vec<Variable>,
    formulas: Vec<Formula>,
}

impl FunctionJob {
    pub(super) fn text(&self) -> String {
        let file = PlanFile {
            format: FORMAT.to_owned(),
            version: VERSION,
            variables: self.variables.clone(),
            formulas: self.formulas.clone(),
        };
        let mut text = serde_json::to_string_pretty(&file).expect("text and lists always have a JSON form");
        text.push('\n');
        text
    }

    /// Reads a plan of this format and version.
    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, serde_json::Error> {
        let PlanFile { variables, formulas, .. } = serde_json::from_slice(bytes)?;
        Ok(Self { variables, formulas })
    }
}

#[cfg(test)]
pub(super) fn example() -> FunctionJob {
    FunctionJob {
        variables: vec![
            Variable { name: "x".into(), short: None },
            Variable { name: "growth".into(), short: Some("y".into()) },
        ],
        formulas: vec![Formula { name: "g".into(), formula: "3 - x".into() }],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names and order of the keys are stored in every result directory, and their hash in its table: a renamed key fails this test.
    #[test]
    fn the_text_of_a_function_plan_is_what_directories_hold() {
        let text = r#"{
  "format": "bladeoff function plan",
  "version": 1,
  "variables": [
    {
      "name": "x",
      "short": null
    },
    {
      "name": "growth",
      "short": "y"
    }
  ],
  "formulas": [
    {
      "name": "g",
      "formula": "3 - x"
    }
  ]
}
"#;
        assert_eq!(example().text(), text);
    }
}
