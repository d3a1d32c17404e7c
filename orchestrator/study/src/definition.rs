//! A study as read from its file.

use super::axis::Axis;
use super::carried::Carried;
use super::limits::Limits;
use super::twin::TwinShare;
use bladeoff_model::machine::{MachineDef, ParamValue, PathInfo, TWIN};

/// A study whose every key was checked.
#[derive(Debug, Clone)]
pub struct Study {
    /// File as the user named it.
    pub file: String,
    /// Its text, to be kept beside the results.
    pub text: String,
    /// Name: letters, digits, `.`, `_`, `-`; default the file's name.
    pub name: String,
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// The machine file as the study names it.
    pub machine_file: String,
    /// Its text.
    pub machine_text: String,
    /// The machine with the overrides of `[set]`.
    pub machine: MachineDef,
    /// The overrides of `[set]`.
    pub fixed: Vec<(PathInfo, ParamValue)>,
    /// What varies, the slowest axis first.
    pub axes: Vec<Axis>,
    /// Text of the points file, to be kept beside the results.
    pub points_text: Option<String>,
    /// Columns of the points file, which is the first axis, that stand in the table as they are.
    pub carried: Vec<Carried>,
    /// How many failed and invalid samples are acceptable.
    pub limits: Limits,
    /// Which samples have a twin run; `None`: as the machine says.
    pub twin: Option<TwinShare>,
}

impl Study {
    /// `run.twin` of its machine, before anything varies; 0: no twin runs.
    #[must_use]
    pub fn shift(&self) -> f64 {
        match self.machine.resolve(TWIN).ok().and_then(|info| info.value) {
            Some(ParamValue::Number(shift)) => shift,
            _ => 0.0,
        }
    }
}
