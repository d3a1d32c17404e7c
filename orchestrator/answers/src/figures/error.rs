//! Why a figure is not made.

use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use plotters::drawing::DrawingAreaErrorKind;
use resvg::usvg;
use std::io;
use std::path::PathBuf;

type DrawError = DrawingAreaErrorKind<io::Error>;

/// A figure that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The plotting library.
    #[error("the figure cannot be drawn")]
    Draw(#[source] DrawError),
    /// The picture is no SVG that can be rendered.
    #[error("the figure cannot be rendered")]
    Render(#[source] usvg::Error),
    /// The PNG encoder, or a picture without pixels.
    #[error("the figure cannot be encoded as PNG ({width} x {height} pixels)")]
    Encode {
        /// Width.
        width: u32,
        /// Height.
        height: u32,
    },
    /// The extension names no picture format.
    #[error("{}: the extension of a figure is .svg or .png", shown(path))]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// A spectrum.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
}

impl From<DrawError> for FigureError {
    fn from(error: DrawError) -> Self {
        FigureError::Draw(error)
    }
}

/// A history from which no spectrum can be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// Too few records.
    #[error("{records} records are too few for a spectrum; it takes at least {least} (record more often with --every)")]
    Short {
        /// Records there are.
        records: usize,
        /// Records it takes.
        least: usize,
    },
    /// Order tracking needs the spin angle.
    #[error("order tracking needs the channel rotor.angle_rad in the history")]
    NoAngle,
    /// The shaft hardly turns.
    #[error("the shaft turns {turns:.1} times in the history; order tracking takes at least {least}")]
    FewTurns {
        /// Turns.
        turns: f64,
        /// Turns it takes.
        least: f64,
    },
}
