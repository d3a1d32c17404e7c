//! Results as one HTML page: self-contained, offline, readable without scripts, printed, dark, by keyboard.
//!
//! ```text
//! Page { sections { blocks: text, tables, commands, figures } } --html--> one file
//! figure: a drawing (SVG, also used in print) + a chart of the same numbers by the chart library where scripts run
//! ```
//! The chart library is Plotly (its cartesian bundle, MIT; `plotly/LICENSE` is shown in the page). The page's policy allows two scripts,
//! identified by their SHA-256, and no requests. Text from a file that became markup by mistake could not do anything.
//! All text is escaped here, including text that Plotly would read as markup (see [`plain`]). The page contains no time stamp: the same
//! results give the same bytes.

mod block;
pub mod chart;
pub(crate) mod escape;
mod figure;
mod film;
mod maps;
mod shell;
mod table;

pub use block::{Block, Page, Section};
pub use escape::plain;
pub use figure::{Explorer, Figure, Plot};
pub use film::animation;
pub use maps::map_figures;
pub use table::Table;
