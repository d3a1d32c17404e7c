//! Drawings: the SVG of every picture, in a page and in a file of its own, with its axes.
//!
//! Colours are attributes of the elements. Grid, frame and text have classes as well, by which a page gives them its own colours.

mod axis;
mod frame;
mod svg;

pub use axis::{Axis, shown};
pub(crate) use axis::{number, number_within, share_of};
pub(crate) use frame::{Frame, LETTER, LINE, MOST_LETTERS, Ruling, TEXT};
pub use svg::Rgb;
pub(crate) use svg::{Anchor, BLACK, INK, Svg, WHITE, html};
