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
mod definition;
pub mod design;
mod error;
mod feasible;
mod input;
mod kind;
mod limits;
mod load;
mod points;
mod sample_keys;
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
pub use definition::Study;
pub use error::StudyError;
pub use feasible::{CHECKED_COMBINATIONS, Chosen, at_its_axis, check_machines};
pub use input::{InputError, read_input};
pub use kind::{FileKind, kind_of};
pub use limits::{Limits, SampleLimits, Share};
pub use load::{FrozenFiles, STUDY_SCHEMA, TakenNames, load, load_frozen};
pub use sample_keys::{SampleKey, SampleKeys};
pub use samples::Samples;
pub use template::{STUDY_MACHINE, STUDY_TEMPLATE};
pub use twin::TwinShare;
pub use values::ValueList;
