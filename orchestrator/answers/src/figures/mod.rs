//! Figures: SVG and PNG from one drawing code.
//!
//! ```text
//! data -> a function of panels, rings, orbit, contact_map, spectrum, waterfall, response_spectrum, machine, maps -> Figure (SVG text) -> .svg | .png
//! ```
//! plotters lays out and draws the SVG, resvg renders it to PNG; both measure and draw text with the font embedded here, so
//! that no font of the system is needed and every machine draws the same picture. Colours tell apart with any kind of colour
//! vision (Okabe-Ito for lines, viridis for maps).

mod contact_map;
mod contacts;
mod error;
mod heat;
mod machine;
mod maps;
mod orbit;
mod panels;
mod response_spectrum;
mod rimmed;
mod rings;
mod spectrum;
mod style;
mod waterfall;

pub use contact_map::contact_map;
pub use contacts::{CRITICAL_SPEEDS, Contact, contacts, critical_passages};
pub use error::{FigureError, SpectrumError};
pub use machine::machine;
pub(crate) use maps::{Colours, Layers, Picture, STEPS, UNKNOWN, marks, pictures_of, stepped};
pub use maps::{MapScales, maps, maps_on, of_in_words};
pub use orbit::{Ring, orbits, ring_of};
pub(crate) use orbit::{clearance, last_turn, reach_of};
pub use panels::{Line, Mark, Panel, panels, panels_marked, tall_panel};
pub use plotters::style::RGBColor;
pub use response_spectrum::response_spectrum;
pub use rings::{RingShape, rings};
pub use spectrum::{order_map, spectrogram};
pub use style::{COLOURS, GREY, Scale, plain_name, viridis};
pub(crate) use style::{digits_of, fixed};
pub use waterfall::waterfall;

use style::FINE;

use bladeoff_system::files::write_whole;
use bladeoff_text::document::pictured_lines;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, FontStyle, IntoDrawingArea, SVGBackend, WHITE};
use plotters::style::register_font;
use resvg::{tiny_skia, usvg};
use std::path::Path;
use std::sync::{Arc, Once};

/// DejaVu Sans, Latin and Greek (licence beside it).
const FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");
/// Its name, and the name under which everything draws with it.
const FAMILY: (&str, &str) = ("DejaVu Sans", "sans-serif");
/// PNG pixels per SVG pixel.
const PNG_SCALE: f32 = 2.0;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    svg: String,
    size: (u32, u32),
}

impl Figure {
    /// Draws on a white area.
    fn draw(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Result<(), FigureError>) -> Result<Self, FigureError> {
        static FONTS: Once = Once::new();
        FONTS.call_once(|| {
            if register_font(FAMILY.1, FontStyle::Normal, FONT).is_err() {
                unreachable!("the embedded font is a font");
            }
        });
        let mut svg = String::new();
        let (width, height) = (size.0 * FINE, size.1 * FINE);
        {
            let area = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
            area.fill(&WHITE)?;
            draw(&area.margin(8 * FINE, 0, 0, 0))?;
            area.present()?;
        }
        // shown at its size in pixels; the viewBox keeps the finer units
        let fine = format!("width=\"{width}\" height=\"{height}\"");
        let svg = svg.replacen(&fine, &format!("width=\"{}\" height=\"{}\"", size.0, size.1), 1);
        // Names of files and channels may hold what XML cannot.
        let svg = pictured_lines(&svg).replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}");
        Ok(Self { svg, size })
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
        fonts.set_sans_serif_family(FAMILY.0);
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
