//! Why a figure is not made.

use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use resvg::usvg;
use std::path::PathBuf;

/// A figure that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
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
    /// Records that are not evenly spaced.
    #[error("a spectrum takes records every {interval:.3e} s; after {at} s there is another interval")]
    Uneven {
        /// The last record before \[s\].
        at: f64,
        /// Mean interval \[s\].
        interval: f64,
    },
    /// A value that is no number, or too large to be one.
    #[error("{channel} is not a finite number at {at} s; select another time range with --from and --to")]
    NoNumber {
        /// The channel.
        channel: String,
        /// When \[s\].
        at: f64,
    },
    /// A signal without a spectrum.
    #[error("{channel} is constant: it has no spectrum")]
    Constant {
        /// The channel.
        channel: String,
    },
    /// A waterfall needs the speed.
    #[error("a waterfall needs the channel rotor.speed_rad_s in the history")]
    NoSpeed,
    /// A waterfall needs several speeds.
    #[error(
        "the speed changes from {} to {} rpm only, and a waterfall takes 5 %; `--kind spectrogram` shows a steady speed",
        rpm(*from),
        rpm(*to)
    )]
    SteadySpeed {
        /// Smallest \[rad/s\].
        from: f64,
        /// Largest \[rad/s\].
        to: f64,
    },
    /// Nothing touches.
    #[error("there is no contact: {channel} is always 0")]
    NoContact {
        /// The channel of the force.
        channel: String,
    },
    /// Order tracking needs the spin angle.
    #[error("order tracking needs the channel rotor.angle_rad in the history")]
    NoAngle,
    /// Records are too far apart for the turns between them.
    #[error(
        "the shaft turns {per_record:.1} times between two records on average; order tracking takes at least one record a turn"
    )]
    FastTurns {
        /// Turns between two records.
        per_record: f64,
    },
    /// The shaft hardly turns.
    #[error("the shaft turns {turns:.1} times in the history; order tracking takes at least {least}")]
    FewTurns {
        /// Turns.
        turns: f64,
        /// Turns it takes.
        least: f64,
    },
}

fn rpm(speed: f64) -> String {
    format!("{:.1}", speed * 30.0 / std::f64::consts::PI)
}
