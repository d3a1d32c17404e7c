//! Study files: a machine, fixed values, varied values. From the text to validated samples, generated lazily by number. This crate starts no
//! processes and writes no tables; it only declares the columns and values of a sample.
//!
//! ```text
//! study.toml --load--> Study (every key, path, value checked) --Samples::new--> Samples (after --scale, --limit)
//! sample number --Combinations--> position on each axis --Axis--> values --MachineDef::set--> machine of that sample
//! ```
//! The format is described in `docs/studies.md`.
//!
//! Values of the samples of a `[design]`, pure functions of (study, seed, index):
//!
//! ```text
//! the tables          file          from the file to everything below
//! [design]            sampling      index -> a coordinate in (0, 1) for each uncertain parameter, with its complement
//! [[correlation]]     correlation   makes coordinates dependent (Gaussian copula)
//! [[uncertain]]       uncertain     coordinate -> value, by the quantile function
//! [[derived]]         derived       values by formulas of other values
//!                     sample_values all of the above: index -> values of all variables
//! ```
//! Both tail probabilities are carried through, so that neither loses digits. Results have the same bytes everywhere: plain operations in
//! order and functions from `libm`.

mod amount;
mod angle;
mod asked;
mod axis;
mod bearing_files;
mod column;
pub mod correlation;
mod csv;
mod definition;
pub mod derived;
mod engine;
mod error;
mod extra_columns;
mod feasible;
mod file;
mod frozen;
mod function;
mod header;
mod idle;
mod input;
mod keys;
mod kind;
mod limits;
mod load;
mod model;
mod named;
mod parameter;
mod points;
mod refine;
mod sample_keys;
pub mod sample_values;
mod samples;
pub mod sampling;
mod set;
mod stop;
mod table;
mod template;
mod twin;
pub mod uncertain;
mod value_table;
mod values;
mod vary;

pub use amount::{parse_duration, parse_memory, parse_task_time};
pub use angle::{FixedAngle, fixed_angle};
pub use asked::{Asked, AskedGate, AskedQuestion, Placed, read_asked};
pub use axis::{Axis, MOST_VARIED, Varied, show};
pub use bearing_files::with_tables;
pub use column::{Column, ColumnKind};
pub use definition::{Fixed, MachineSubject, Study, Subject};
pub use error::{OfRoss, StudyError};
pub use extra_columns::ExtraColumn;
pub use feasible::{CHECKED_COMBINATIONS, Chosen, at_its_axis, check_machines};
pub use file::SampledTables;
pub use frozen::{FrozenFiles, MACHINE, POINTS, STUDY, empirical, is_empirical};
pub use function::{FunctionError, FunctionModel, MOST_OUTPUTS, OWN_COLUMNS, Output};
pub use idle::idle_levels;
pub use input::{InputError, meant, read_input};
pub use keys::{STUDY_KEYS, STUDY_TABLES, StudyKey};
pub use kind::{FileKind, kind_of};
pub use limits::{Limits, SampleLimits, Share};
pub use load::{CheckAsked, STUDY_SCHEMA, TakenNames, ToCheck, load, load_checked, load_frozen, load_text};
pub use parameter::{Origin, Parameter};
pub use refine::RefineDef;
pub use sample_keys::{SampleKey, SampleKeys, Versions};
pub use samples::Samples;
pub use stop::{FIRST_LOOK, StopDef, block, is_blocked};
pub use template::{RISK_TEMPLATE, STUDY_MACHINE, STUDY_TEMPLATE};
pub use twin::TwinShare;
pub use value_table::TABLE_BYTES;
pub use values::ValueList;
