//! Results as one HTML page: self-contained, offline, readable without scripts, printed, dark, by keyboard.
//!
//! ```text
//! Page { sections { blocks: text, tables, commands, figures } } --html--> one file
//! figure: a drawing (SVG, always there and what is printed) + what the chart library makes of the same numbers where scripts run
//! ```
//! The chart library is Plotly (its cartesian bundle, MIT; `plotly/LICENSE` is shown in the page). The page's policy lets two scripts run,
//! known by their SHA-256, and no request whatever leave: text from outside that became markup by a mistake would still do nothing.
//! All text is escaped here, and in what Plotly reads as markup of its own (see [`plain`]). The page says nothing of the time it was made: the same
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
