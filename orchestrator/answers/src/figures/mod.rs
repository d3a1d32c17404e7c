//! Figures: SVG and PNG from one drawing code.
//!
//! ```text
//! data -> a function of panels, rings, orbit, contact_map, spectrum, waterfall, response_spectrum, machine, maps -> Figure (SVG text) -> .svg | .png
//! ```
//! The elements and axes are those of `crate::drawing`, as in a page. resvg renders the SVG to PNG with the font embedded here, so that no font of
//! the system is needed and every machine makes the same PNG. Colours tell apart with any kind of colour vision (Okabe-Ito for lines, viridis for
//! maps).

mod contact_map;
mod contacts;
mod error;
mod heat;
mod machine;
mod maps;
mod orbit;
mod panels;
mod response_spectrum;
mod rings;
mod spectrum;
mod style;
mod waterfall;

pub use crate::drawing::Rgb;
pub use contact_map::contact_map;
pub use contacts::{CRITICAL_SPEEDS, Contact, contacts, critical_passages};
pub use error::{FigureError, SpectrumError};
pub use machine::machine;
pub(crate) use maps::{Colours, Layers, Picture, STEPS, UNKNOWN, marks, pictures_of, stepped};
pub use maps::{MapScales, maps, maps_on, of_in_words};
pub use orbit::{Ring, orbits, ring_of};
pub(crate) use orbit::{clearance, last_turn, reach_of};
pub use panels::{Line, Mark, Panel, panels, panels_marked, style, tall_panel};
pub use response_spectrum::response_spectrum;
pub use rings::{RingShape, rings};
pub use spectrum::{order_map, spectrogram};
pub(crate) use style::fixed;
pub use style::{COLOURS, GREY, Scale, plain_name, viridis};
pub use waterfall::waterfall;

use crate::drawing::{Anchor, Svg, WHITE, html};
use bladeoff_system::files::write_whole;
use resvg::{tiny_skia, usvg};
use std::path::Path;
use std::sync::Arc;

/// DejaVu Sans, Latin and Greek (licence beside it).
const FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");
/// Its name.
const FAMILY: &str = "DejaVu Sans";
/// PNG pixels per SVG pixel.
const PNG_SCALE: f32 = 2.0;
/// Height of a title \[px\].
const HEAD: f64 = 38.0;

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    svg: String,
    size: (u32, u32),
}

impl Figure {
    /// Draws on a white ground, below a title.
    fn draw(size: (u32, u32), title: &str, draw: impl FnOnce(&mut Svg)) -> Self {
        let (width, height) = size;
        let mut svg = Svg::default();
        svg.put(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" color=\"#000\" fill=\"currentColor\" font-family=\"sans-serif\" font-size=\"10\">\n<title>{}</title>",
            html(title)
        ));
        let (width, height) = (f64::from(width), f64::from(height));
        svg.rect(format_args!("class=\"ground\" {}", WHITE.fill()), (0.0, 0.0), (width, height));
        svg.text("font-size=\"14\"", (width / 2.0, 27.0), Anchor::Middle, title);
        draw(&mut svg);
        svg.0 += "</svg>\n";
        Self { svg: svg.0, size }
    }

    /// The SVG text.
    #[must_use]
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The bytes of a PNG.
    ///
    /// # Errors
    /// [`FigureError::Render`], [`FigureError::Encode`].
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(FONT.to_vec());
        fonts.set_sans_serif_family(FAMILY);
        let options = usvg::Options { fontdb: Arc::new(fonts), ..usvg::Options::default() };
        let tree = usvg::Tree::from_str(&self.svg, &options).map_err(FigureError::Render)?;
        let (width, height) = ((self.size.0 as f32 * PNG_SCALE) as u32, (self.size.1 as f32 * PNG_SCALE) as u32);
        let failed = || FigureError::Encode { width, height };
        let mut pixels = tiny_skia::Pixmap::new(width, height).ok_or_else(failed)?;
        resvg::render(&tree, tiny_skia::Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut pixels.as_mut());
        pixels.encode_png().map_err(|_| failed())
    }

    /// Writes the figure in the format of the file's extension.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn write(&self, path: &Path) -> Result<(), FigureError> {
        let bytes = match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => self.svg.clone().into_bytes(),
            Some("png") => self.png()?,
            _ => return Err(FigureError::Extension { path: path.to_path_buf() }),
        };
        Ok(write_whole(path, &bytes)?)
    }

    /// Writes `NAME.svg` and `NAME.png` into a directory.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn write_both(&self, directory: &Path, name: &str) -> Result<(), FigureError> {
        self.write(&directory.join(format!("{name}.svg")))?;
        self.write(&directory.join(format!("{name}.png")))
    }
}

#[cfg(test)]
#[path = "scale_tests.rs"]
mod scale_tests;
