//! Machine: text of a machine file -> [`MachineDef`] (values that may be varied by path) -> [`Machine`]
//! (validated, SI).
//!
//! ```text
//! text --document--> tree with spans --load, beside schema--> layout (shared) + states (per sample) --build--> Machine
//! ```

mod assumptions;
mod bearing_table;
mod braking;
mod build;
mod def;
mod engine;
mod find;
mod identity;
mod layout;
mod load;
mod model;
mod paths;
mod reservations;
mod schema;
mod section;
mod template;
mod torque;
mod unbalance;
mod value;
mod words;
mod write;

pub use assumptions::Assumption;
pub use bearing_table::{BearingTable, Coefficients, Interpolation};
pub use build::{MOST_LOST, Overdrawn, overdrawn};
pub use def::MachineDef;
pub use engine::{EngineChoice, EngineReason, NotCovered, decides_engine};
pub use model::*;
pub use paths::{PathError, PathInfo, PathKind, is_detection, is_of_the_format, some_of};
pub use reservations::Reservation;
pub use schema::{
    CONTACT_STEP, END_TIME, ENGINE, Key, Kind, Need, Range, SCHEMA, STEP, STEP_LIMIT, TWIN, TWIN_LIMIT, When, keys,
};
pub use section::GAUSS5;
pub use template::machine_template;
pub use value::{ParamValue, ValueError};
