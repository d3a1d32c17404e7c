//! What a twin run told: a second run with a slightly larger initial speed.

use super::row::Row;
use bladeoff_model::machine::TWIN;
use bladeoff_model::outcome::Status;

/// Words of the column `twin_status`.
const STATUS: &[&str] = &["ok", "invalid", "failed"];

/// A run's twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twin {
    /// `(F_twin - F)/F` of the largest bearing loads; `None` where there is nothing to compare.
    pub load_change: Option<f64>,
    pub status: Status,
}

impl Twin {
    pub(super) fn report(of: Option<&Self>, row: &mut Row<'_>) {
        row.real(
            "twin_bearing_load_change",
            "",
            format_args!(
                "how much larger max_bearing_load_N is in a second run whose initial speed is larger by {TWIN} of it, relative to \
                 this run's; negative: smaller; null without such a run, and where one of the two failed"
            ),
            of.and_then(|twin| twin.load_change),
        );
        let status = of.and_then(|twin| STATUS.iter().position(|word| *word == twin.status.word()));
        row.choice("twin_status", STATUS, "status of that second run; null without one", status);
    }
}
