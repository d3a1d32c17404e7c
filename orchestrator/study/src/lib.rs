//! Study files: a machine, what is fixed, what varies. From the text to validated samples, lazily, by number; no process, no
//! table. What a table says of a sample is given as plain declarations of columns and values.
//!
//! ```text
//! study.toml --load--> Study (every key, path, value checked) --Samples::new--> Samples (after --scale, --limit)
//! sample number --Design--> position on each axis --Axis--> values --MachineDef::set--> machine of that sample
//! ```
//! The format is described in `docs/studies.md`.

mod amount;
mod angle;
mod axis;
mod carried;
mod csv;
pub mod design;
mod feasible;
mod input;
mod keys;
mod kind;
mod limits;
mod load;
mod points;
mod samples;
mod table;
mod template;
mod twin;
mod values;
mod vary;

pub use amount::{parse_duration, parse_memory};
pub use angle::{FixedAngle, fixed_angle};
pub use axis::{Axis, Column, ColumnKind, MOST_VARIED, Varied, show};
pub use carried::Carried;
pub use feasible::{CHECKED_COMBINATIONS, Chosen, at_its_axis, check_machines};
pub use input::{InputError, read_input};
pub use keys::{SampleKey, SampleKeys};
pub use kind::{FileKind, kind_of};
pub use limits::{Limits, Share};
pub use load::{FrozenFiles, TakenNames, load, load_frozen};
pub use samples::Samples;
pub use template::{STUDY_MACHINE, STUDY_TEMPLATE};
pub use twin::{TWIN, TwinShare};
pub use values::ValueList;

use crate::design::DesignError;
use bladeoff_model::document::Problems;
use bladeoff_model::machine::{MachineDef, ParamValue, PathInfo};
use bladeoff_system::threads::ThreadsError;
use bladeoff_system::{call, shown};
use std::ffi::OsStr;
use std::path::PathBuf;

/// Version of the study format.
pub const STUDY_SCHEMA: i128 = 1;

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

/// Why a study cannot be run as it is.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Problems in the study, its machine or its points file.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Problems(Vec<Problems>),
    /// A machine instead of a study.
    #[error(
        "{} is a machine file, not a study\n  one run of it: {}\n  a study names it by `machine`; a template: {}",
        shown(path),
        call::command([OsStr::new("simulate"), call::path_word(path).as_os_str()]),
        call::command(["new", "study"])
    )]
    AMachine {
        /// The file.
        path: PathBuf,
    },
    /// A file that cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Too many samples, or a scale out of range.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// Its machines could not be built in parallel.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
}
